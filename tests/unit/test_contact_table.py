"""The table over the mean gap: shear flow factors against closed forms and published curves."""

import numpy as np
import pandas as pd
import pytest

import roughcontact as rc
from roughcontact.command_line.program import main
from roughcontact.references.synthetic import rough_reference_surface
from roughcontact.sealing.flow import flow_columns


@pytest.mark.parametrize("depth", [0.3, 0.7])
def test_ridges_across_carry_what_the_closed_form_says(depth):
    """Ridges across the sliding direction: <g^-2>/<g^-3> of the mean gap is driven; along it all of it."""
    gap = (1 + depth * np.cos(2 * np.pi * (np.arange(4096) + 0.5) / 4096))[None]
    found = flow_columns(gap, (1.0, 1.0), tolerance=1e-12)
    assert found["shear_flow_x"] == pytest.approx(1 - (gap**-2.0).mean() / (gap**-3.0).mean(), abs=1e-6)
    along = flow_columns(np.broadcast_to(gap.T, (4096, 4)), (1.0, 1.0), tolerance=1e-12)
    assert along["shear_flow_x"] == pytest.approx(0, abs=1e-12)


def test_far_apart_it_is_three_halves_of_sigma_over_the_gap():
    """Patir and Cheng (1979): isotropic roughness moves 3/2 sigma/H times sigma, and at H = 3 0.46 of it."""
    height = rough_reference_surface(128)
    values = height.values / float(height.std())
    factors = []
    for gap in (20.0, 3.0):
        found = flow_columns(np.maximum(gap + values, 0), (1.0, 1.0), tolerance=1e-9)
        factors.append((found["shear_flow_x"] + found["shear_flow_y"]) / 2 * gap)
    assert factors[0] == pytest.approx(1.5 / 20, rel=0.03)
    curve = 1.899 * 3**0.98 * np.exp(-0.92 * 3 + 0.05 * 9)  # their fit for gamma = 1
    assert factors[1] == pytest.approx(curve, rel=0.2)  # published scatter


@pytest.fixture(scope="module")
def statistics():
    return rc.evaluate(
        rough_reference_surface(64) * 1e-6,
        contact={"contact_modulus": "1 GPa", "relative_pressure": [0.01, 0.1, 0.5], "tolerance": 1e-3},
        statistics={"flow": "always"},
        window={"method": "raw"},
    )


def test_the_table_is_that_of_the_statistics(statistics, tmp_path, capsys):
    window = rough_reference_surface(64) * 1e-6
    table = rc.contact_table(
        window, contact_modulus="1 GPa", relative_pressure=[0.01, 0.1, 0.5], tolerance=1e-3
    )
    assert (np.diff(table["mean_gap"]) < 0).all()
    assert table["mean_pressure"].values == pytest.approx(statistics["mean_pressure"].values, rel=1e-6)
    assert table["pressure_flow_factor_y"].values == pytest.approx(
        statistics["flow_factor_yy"].values, rel=1e-3
    )
    sigma = table.attrs["rms_height"]
    shear = statistics["shear_flow_x"].values * statistics["mean_gap"].values / sigma
    assert table["shear_flow_factor_x"].values == pytest.approx(shear, rel=1e-3)
    assert (table["relative_contact_area_lower"] <= table["relative_contact_area"]).all()

    rc.write_dataset(statistics, tmp_path / "result.nc")
    assert main(["table", str(tmp_path / "result.nc"), "-o", str(tmp_path / "table.csv")]) == 0
    written = pd.read_csv(tmp_path / "table.csv")
    assert {"mean_gap_m", "mean_pressure_Pa", "contact_stiffness_Pa_m-1", "shear_flow_factor_x"} <= set(
        written
    )
    assert written["mean_gap_m"].values == pytest.approx(statistics["mean_gap"].values, rel=1e-6)
    assert main(["table", str(tmp_path / "result.nc")]) == 0
    assert capsys.readouterr().out.startswith("mean_gap_m,mean_pressure_Pa,")


def test_statistics_without_flow_are_refused(statistics):
    from roughcontact.evaluation import over_mean_gap

    with pytest.raises(rc.SettingsError, match=r"statistics\.flow: always"):
        over_mean_gap(statistics.drop_vars("flow_factor_xx"))
