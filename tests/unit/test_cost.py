"""Run time against error: the finer grids, the errors against a known answer, and the advice."""

import numpy as np
import pandas as pd
import pytest
from cost import QUANTITIES, TOLERANCES, advice, cheapest, choices, main, run_time_against_error

import roughcontact as rc
from roughcontact.arguments.maps import height_map, refined
from roughcontact.errors import HeightMapError
from roughcontact.surface import synthetic
from validation import closed_forms
from validation.surfaces import product_wave_surface


@pytest.mark.parametrize("shape", [(8, 6), (7, 6), (9, 5), (1, 8), (7, 1)])
def test_a_refined_map_goes_through_the_points(shape):
    values = np.random.default_rng(1).standard_normal(shape)
    steps = tuple(3 if n > 1 else 1 for n in shape)
    fine = refined(height_map(values, (2.0, 0.5)), 3)
    assert fine.shape == tuple(n * step for n, step in zip(shape, steps, strict=True))
    np.testing.assert_allclose(fine.values[:: steps[0], :: steps[1]], values, atol=1e-14)


def test_a_refined_wave_is_that_wave():
    coarse, fine = (product_wave_surface((n, 2 * n), 1 / n, amplitude=1.0, wavelength=1.0) for n in (8, 32))
    result = refined(coarse, 4)
    np.testing.assert_allclose(result.values, fine.values, atol=1e-14)
    assert float(result["x"][1] - result["x"][0]) == pytest.approx(1 / 32)


@pytest.fixture(scope="module")
def table():
    """The rough reference case from 128 points per side, at two loads whose answers are known."""
    gradient = 0.55501825
    return run_time_against_error(
        synthetic.rough_reference_surface(128),
        contact_modulus=1.0,
        mean_pressure=[0.05 * gradient, 0.2 * gradient],
    )


def test_every_grid_and_tolerance_is_there(table):
    grids = sorted(set(zip(table["points_x"], table["points_y"], strict=True)))
    assert grids == [(32, 32), (64, 64), (128, 128), (256, 256)]
    assert len(table) == len(grids) * len(TOLERANCES) * 2
    assert (table["seconds"] > 0).all()
    assert np.isfinite(table).all(axis=None)


def test_errors_cover_the_known_answer(table):
    """Area and mean gap by an independent code at 1024 points."""
    reference = list(closed_forms.ROUGH_AREA_AND_GAP.values())[:2]
    for (load, rows), (area, gap) in zip(table.groupby("mean_pressure"), reference, strict=True):
        assert load > 0
        deviation = (rows["relative_contact_area"] / area - 1).abs()
        assert (deviation <= rows["relative_contact_area_error"] + 5e-5).all()
        deviation = (rows["mean_gap"] / (gap * 0.023699516) - 1).abs()
        assert (deviation <= rows["mean_gap_error"] + 1e-5).all()


def test_errors_fall_with_the_grid(table):
    tight = choices(table)[lambda rows: rows["tolerance"] == 1e-5].sort_values("points_x")
    for name in QUANTITIES:
        errors = tight[f"{name}_error"].values
        assert (np.diff(errors) <= 0).all()
        assert errors[-1] < errors[0] / 5  # the grid is 8 times finer
    assert tight["relative_contact_area_error"].values[-1] < 0.01


def made_up(errors, seconds):
    """Return a table of two grids and two tolerances with these errors of everything."""
    rows = []
    for (points, tolerance), error, time in zip(
        [(64, 0.1), (64, 0.01), (128, 0.1), (128, 0.01)], errors, seconds, strict=True
    ):
        for load in (1.0, 2.0):
            row = {"points_x": points, "points_y": 1, "tolerance": tolerance, "seconds": time}
            row |= {"mean_pressure": load} | {f"{name}_error": error / load for name in QUANTITIES}
            rows.append(row)
    return pd.DataFrame(rows)


def test_a_coarse_grid_that_is_right_by_chance_is_not_trusted():
    table = made_up(errors=[1e-4, 0.03, 0.02, 0.004], seconds=[1, 2, 3, 4])
    errors = choices(table).set_index(["points_x", "tolerance"])["mean_gap_error"]
    assert errors[64, 0.1] == 0.03
    assert errors[128, 0.01] == 0.004
    best = cheapest(table, "mean_gap", 0.01)
    assert (best["points_x"], best["tolerance"], best["seconds"]) == (128, 0.01, 4)
    assert cheapest(table, "mean_gap", 0.001) is None


def test_advice_in_words():
    sentences = advice(made_up(errors=[0.06, 0.03, 0.02, 0.004], seconds=[0.1, 0.2, 0.34, 0.456]))
    assert sentences[:3] == [
        "For 5 % in contact area, solve at 64 with tolerance 1e-2: 0.20 s.",
        "For 1 % in contact area, solve at 128 with tolerance 1e-2: 0.46 s.",
        (
            "For 0.2 % in contact area, no grid of this comparison is fine enough; the best, 128 with "
            "tolerance 1e-2, has 0.400 %."
        ),
    ]
    assert len(sentences) == 9


def test_targets_that_one_choice_serves_share_a_sentence():
    sentences = advice(made_up(errors=[0.001] * 4, seconds=[1, 2, 3, 4]))
    assert sentences[1] == "For 5 % or 1 % or 0.2 % in mean gap, solve at 64 with tolerance 1e-1: 1.0 s."


def test_the_command_prints_the_advice_and_keeps_the_table(tmp_path, capsys):
    window = synthetic.rough_reference_surface(64)
    contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=[0.02, 0.1])
    rc.write_dataset(window.to_dataset(name="height"), tmp_path / "window.nc")
    rc.write_dataset(rc.contact_statistics(contact), tmp_path / "statistics.nc")
    assert main([str(tmp_path)]) == 0
    kept_table = pd.read_csv(tmp_path / "cost.csv")
    assert sorted(set(kept_table["points_x"])) == [32, 64, 128]
    assert kept_table["mean_pressure"].nunique() == 2
    printed = capsys.readouterr().out
    for sentence in advice(kept_table):
        assert sentence in printed


@pytest.mark.parametrize(
    ("heights", "message"), [(np.eye(7, 6), "6 × 7 points"), (np.ones((64, 64)), "flat")]
)
def test_a_map_that_tells_nothing_is_refused(heights, message):
    height = height_map(heights, 1.0)
    with pytest.raises(HeightMapError, match=message):
        run_time_against_error(height, contact_modulus=1.0, mean_pressure=[1.0])
