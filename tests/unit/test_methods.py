"""The paragraph of methods: its numbers are those of the file, its words those of the settings."""

import json

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

from roughcontact import evaluate, self_affine_surface, write_dataset
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import quantity, with_interval
from roughcontact.interface.program import main
from roughcontact.report.methods import methods_paragraph

LOADS = [1e6, 5e6, 2e7, 8e7]


@pytest.fixture(scope="module")
def statistics():
    height = self_affine((60, 96), (1e-6, 1e-6), (6e-6, 3e-5), rms_height=1e-7, seed=3)
    cut = height.isel(x=slice(0, 80))  # no longer periodic
    contact = {"bodies": ["steel", "PEEK"], "mean_pressure": LOADS}
    return evaluate(cut, level={"form": "mean", "s_filter": "3 um"}, contact=contact)


def test_the_numbers_are_those_of_the_file(statistics):
    text = methods_paragraph(statistics)
    for index in (0, 2, 3):  # the lowest load, one between, the highest
        load = statistics.isel(load=index)
        interval = (float(load[f"relative_contact_area{suffix}"]) for suffix in ("", "_lower", "_upper"))
        area = with_interval(*(100 * suffix for suffix in interval))
        pressure = quantity(LOADS[index], "Pa")
        assert (
            f"A mean pressure of {pressure} gives a true contact area of {area} % of the nominal area" in text
        )
    assert quantity(LOADS[1], "Pa") not in text
    assert f"E* = {quantity(float(statistics['contact_modulus']), 'Pa')}" in text
    assert f"its rms height is {quantity(float(statistics['rms_height']), 'm')}" in text


def test_the_words_are_those_of_the_settings(statistics):
    text = methods_paragraph(statistics)
    assert "were taken relative to their mean" in text
    assert "an S-filter of cut-off 3.00 µm applied" in text
    assert "steel (207 GPa, ν 0.30, hardness 1.40 GPa, yield stress 250 MPa) on PEEK (3.80 GPa" in text
    assert "the pressure limited to the hardness of 250 MPa" in text
    assert "made periodic by blending opposite edges;" in text
    cells = {"mask": "0 0 9 9 um; 20 0 30 9 um", "parts": [1, 1, 2, 1], "place": []}
    settings = json_attribute(statistics.attrs, "settings") | {"surface": cells}
    used = methods_paragraph(statistics.assign_attrs(settings=json.dumps(settings)))
    corners = "(corners from the lower left one)"
    assert f"without those within 0 0 9 9 um; 20 0 30 9 um {corners}, part 1-1 of 2x1, cut to what" in used
    assert "show, were taken relative" in used


def test_the_range_of_a_hardness_has_its_own_unit_under_the_loads_of_rubber(statistics):
    soft = statistics.assign(hardness=1.4e9, hardness_lower=1.1e9, hardness_upper=1.8e9, contact_modulus=4e6)
    assert "in the intervals 1.10 to 1.80 GPa" in methods_paragraph(soft)


def test_an_overview_that_numbers_rest_on_is_named(statistics):
    assert "overview" not in methods_paragraph(statistics)
    over = statistics.assign(mean_gap_alone_lower=statistics["mean_gap_lower"])
    assert "Area, pressure in contact and gap are of the surface over a coarser map" in methods_paragraph(
        over
    )
    at_its_place = methods_paragraph(over.assign_attrs(overview_correlation=0.957))
    assert "its overview, on which the map lies with a correlation of 0.96. The intervals" in at_its_place


def test_the_bound_is_never_rounded_down(statistics):
    with_bounds = statistics.assign(error_bound=("load", np.array([1.01e-5, 2e-6, 1e-6, 1e-7])))
    assert "at most 1.1×10⁻⁵." in methods_paragraph(with_bounds)
    assert "at most 2.0×10⁻⁵." in methods_paragraph(statistics.assign(error_bound=("load", np.full(4, 2e-5))))


def test_the_paragraph_of_a_gap_of_atoms_has_no_digits_of_it(statistics):
    gaps = {
        "mean_gap": [5e-12] * 4,
        "mean_gap_lower": [0.0] * 4,
        "mean_gap_upper": [1e-10, 1e-9, 2e-9, np.nan],
    }
    atoms = statistics.assign({name: ("load", values) for name, values in gaps.items()})
    text = methods_paragraph(atoms)
    assert "a mean gap of < 1 nm." in text
    assert "a mean gap of < 1 (0 to 2.00) nm." in text
    assert " pm" not in text


def test_the_command_takes_the_results_of_the_folder(statistics, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_dataset(statistics, tmp_path / "results/one/statistics.nc")
    assert main(["methods"]) == 0
    assert capsys.readouterr().out == f"{methods_paragraph(statistics)}\n"


def test_the_command_prints_it_for_each_result(statistics, tmp_path, capsys):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        write_dataset(statistics, tmp_path / name / "statistics.nc")
    assert main(["methods", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"# one\n{methods_paragraph(statistics)}\n# two\n")
    assert main(["methods", str(tmp_path / "one")]) == 0  # the folder of a surface
    assert capsys.readouterr().out == f"{methods_paragraph(statistics)}\n"
    (tmp_path / "empty").mkdir()
    assert main(["methods", str(tmp_path / "empty")]) == 2
    assert "empty: is a folder; name the" in capsys.readouterr().err.replace("\\", "/")
    several = xr.concat([statistics, statistics], dim="surface", data_vars="all")
    write_dataset(several, tmp_path / "all.nc")
    assert main(["methods", str(tmp_path / "all.nc")]) == 2
    assert (
        "all.nc: is of all surfaces; name the statistics.nc in the folder of one" in capsys.readouterr().err
    )


def test_a_body_of_finite_size_has_a_force_and_no_neighbours():
    height = self_affine((64, 64), (1e-6, 1e-6), (4e-6, 1.6e-5), rms_height=1e-9, seed=5)
    contact = {"bodies": ["steel", "steel"], "boundary": "free", "force": "1 mN"}
    text = methods_paragraph(evaluate(height, contact=contact, form={"radius": "1 mm"}))
    assert "is the roughness of a body of finite size of radius 1.00 mm;" in text
    assert "under a prescribed force" in text
    assert "half-spaces without neighbours" in text
    assert "periodic" not in text
    assert "A force of 1.00 mN gives a true contact area of" in text
    assert "are for this body, also at other positions on its roughness" in text


def test_a_wider_body_has_its_radius_and_the_force_of_each_pressure():
    height = self_affine((64, 64), 1e-6, (4e-6, 1.6e-5), rms_height=1e-8, seed=5)
    contact = {"bodies": ["steel", "steel"], "force": "20 N"}
    form = {"radius": "50 mm", "local_scale": True}
    text = methods_paragraph(evaluate(height, contact=contact, form=form, uncertainty={"sources": []}))
    assert "solved under Hertz's largest pressures on a body of finite size of radius 50.0 mm;" in text
    assert "MPa, Hertz's largest under 20.0 N, gives a true contact area of" in text


def test_the_paragraph_of_a_pair_names_both_files():
    surface = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=8e-6, longest=3.2e-5, rms_height=1e-7)
    contact = {"contact_modulus": 1e9, "mean_pressure": 5e6}
    statistics = evaluate(surface, contact=contact, uncertainty={"sources": []})
    text = methods_paragraph(statistics.assign_attrs(source_sha256=f"{'a1' * 32} + {'b2' * 32}"))
    assert "heights (SHA-256 a1a1a1a1… and b2b2b2b2…) were" in text
    assert "the two faces added at one of their relative positions." in text


def test_of_profiles_the_paragraph_says_which_surfaces_were_solved():
    surface = self_affine_surface((128, 128), 1e-6, hurst=0.8, shortest=8e-6, longest=4e-5, rms_height=1e-7)
    profiles = [surface[[row]] for row in (10, 50, 90)]
    contact = {"contact_modulus": 1e9, "mean_pressure": 5e6}
    statistics = evaluate(profiles, lay="none", contact=contact, uncertainty={"sources": ["solver"]})
    text = methods_paragraph(statistics)
    assert (
        "was drawn at random from the surfaces with the spectrum, heights and slopes of 3 profiles;" in text
    )
    assert "periodic as measured" not in text


def test_the_paragraph_says_how_rows_scars_and_waves_were_treated():
    surface = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=4e-6, longest=3.2e-5, rms_height=1e-7)
    rows = np.random.default_rng(1).normal(0, 1e-6, (64, 1))
    text = methods_paragraph(
        evaluate(
            surface + rows,
            level={"robust": True, "line_alignment": "auto", "scar_threshold": 5},
            window={"reliable_band": True},
            instrument={"noise": "2 nm", "correct": True},
            contact={"contact_modulus": 1e9, "mean_pressure": 5e6, "influence": "elements"},
            uncertainty={"sources": ["solver"]},
        )
    )
    assert "on the grid of the window, its pressure constant on every pixel; the relative" in text
    assert "levelled by a robustly fitted plane, outliers" in text
    assert "scars beyond 5.0 standard deviations rejected, rows aligned (jitter), missing" in text
    assert "was corrected for noise of 2.00 nm, waves shorter than 2.00 µm were removed;" in text


@pytest.mark.parametrize(
    ("sources", "about"),
    [(["solver", "material"], "this map alone"), (["solver", "window"], "the mean of maps of this size")],
)
def test_the_intervals_are_of_the_surface_where_they_include_it(sources, about):
    surface = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=8e-6, longest=3.2e-5, rms_height=1e-7)
    contact = {"contact_modulus": 1e9, "mean_pressure": 5e6}
    text = methods_paragraph(evaluate(surface, contact=contact, uncertainty={"sources": sources}))
    assert f"The intervals hold 95 % and are for {about}" in text
