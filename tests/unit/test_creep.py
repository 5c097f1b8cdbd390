"""Bodies that creep under a constant load: against a viscoelastic body stepped in time, and elastic ones."""

import re

import numpy as np
import pytest
from scipy.integrate import quad

import roughcontact as rc
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.relaxation import Relaxation
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.evaluation.creep import moduli_after
from roughcontact.interface.command_line.answers import solution
from roughcontact.interface.command_line.options import parse_bodies
from roughcontact.interface.command_line.solving import solve_file
from roughcontact.kernels.fourier import wavenumbers
from roughcontact.report.tables import creep_table
from roughcontact.results.collect import collect_statistics, summary_table
from roughcontact.results.storage import write_dataset

POLYMER = {"youngs_modulus": "3 GPa", "poissons_ratio": 0.4, "thermal_conductivity": 0.3}
CREEPING = POLYMER | {"creep_modulus": {"1 h": "2.1 GPa", "10 years": "1.4 GPa"}}
SEAL = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}


def face(points=64, **options):
    waves = {"hurst": 0.8, "longest": points / 2 * 1e-6, "shortest": 8e-6, "rms_gradient": 0.1, "seed": 1}
    return rc.self_affine_surface((points, points), 1e-6, **waves | options)


def evaluated(body, **contact):
    return rc.evaluate(
        face(),
        window={"method": "raw"},
        bodies=["steel", body],
        mean_pressure=["1 MPa", "10 MPa"],
        statistics={"seal": SEAL},
        **contact,
    )


def solved(window, modulus, load):
    return rc.solve_contact(window, contact_modulus=modulus, mean_pressure=load).isel(load=0)


def test_a_viscoelastic_body_stepped_in_time_comes_to_the_elastic_contact():
    """A standard linear solid, u = G (J0 p + z), z' = ((J - J0) p - z)/tau: the error falls as the step."""
    window, slow, fast = face(), 1e6, 1e7
    load = 0.02 * fast * float(window.attrs.get("rms_gradient", 0.1))
    first, growth = 1 / fast, 1 / slow - 1 / fast
    length = wavenumbers(window.shape, spacing(window))
    elastic = solved(window, 1 / (first + growth * (1 - np.exp(-1))), load)
    gaps, areas, pressures = [], [], []
    for count in (1, 10, 100):
        step, hidden = 1 / count, np.zeros(window.shape)
        for _ in range(count):  # implicit
            wave = np.fft.rfft2(hidden / (1 + step))
            below = np.fft.irfft2(np.divide(2 * wave, length, out=0 * wave, where=length > 0), s=window.shape)
            now = solved(window - below, 1 / (first + growth * step / (1 + step)), load)
            hidden = (hidden + step * growth * now["pressure"].values) / (1 + step)
        gaps.append(float(now["gap"].mean() / elastic["gap"].mean()))
        areas.append(float(now["contact"].mean() / elastic["contact"].mean()))
        square = (now["pressure"] - elastic["pressure"]) ** 2
        pressures.append(float(np.sqrt(square.mean() / (elastic["pressure"] ** 2).mean())))
    off = np.subtract(gaps, 1)
    np.testing.assert_allclose(np.diff(np.log10(off)), -1, atol=0.1)  # first order
    assert off[-1] < 0.0025
    assert (np.abs(np.subtract(areas, 1)) < [0.2, 0.02, 0.005]).all()
    assert pressures[-1] > 0.2  # no answer, as many steps as there are


def test_the_creep_compliance_is_the_inverse_of_the_relaxation():
    """The standard linear solid in closed form, and int E(t - s) J(s) ds = t of more terms."""
    solid = Relaxation(1e6, np.array([9e6]), np.array([1.0]))
    for time in (0.0, 0.5, 10.0):
        assert solid.creep_modulus(time) == pytest.approx(1 / (1e-6 - 9e-7 * np.exp(-0.1 * time)), rel=1e-9)
    times, moduli = np.array([0.3, 2.0, 0.3, 9.0]), np.array([2.0, 1.0, 3.0, 5.0])
    series = Relaxation(0.5, moduli, times)

    def carried(time):
        return (0.5 + (moduli * np.exp(-(4.0 - time) / times)).sum()) / series.creep_modulus(time)

    assert quad(carried, 0, 4)[0] == pytest.approx(4.0, rel=1e-7)


def test_after_a_time_the_contact_is_the_elastic_one_of_that_modulus():
    result, softer = evaluated(CREEPING), evaluated(POLYMER | {"youngs_modulus": "1.4 GPa"})
    assert result["time"].values.tolist() == [3600.0, 10 * 31557600.0]
    for name in ("relative_contact_area", "mean_gap", "thermal_conductance", "leak_rate_x"):
        for end in ("", "_lower", "_upper"):
            np.testing.assert_allclose(result[f"{name}_after{end}"][:, 1], softer[f"{name}{end}"], rtol=1e-5)
    assert not [name for name in result if "pressure" in str(name) and "_after" in str(name)]
    table = creep_table(result, [1])
    assert [row[1] for row in table["rows"]] == ["at once", "60 min", "10 years"]
    assert table["header"][2:5] == ["contact area (%)", "mean gap (µm)", "conductance by conductivity (mm⁻¹)"]
    # at once as everywhere else, not as a body that has crept
    assert "time" not in softer.dims
    assert creep_table(softer, [0]) is None


def test_where_points_flow_nothing_is_said():
    result = evaluated(CREEPING | {"hardness": "60 MPa"}, uncertainty={"sources": []})
    flows = result["load_share_above_hardness"].values > 0
    assert flows.any()
    np.testing.assert_array_equal(np.isnan(result["mean_gap_after"]).all("time"), flows)


def test_a_relaxation_says_the_same_as_its_creep():
    series = {"long_time_modulus": "1 GPa", "moduli": ["2 GPa"], "times": [3600.0]}
    after = 1e9 / (1 - 2 / 3 * np.exp(-1 / 3))  # of the standard linear solid
    quick = {"uncertainty": {"sources": []}}
    relaxing = {"relaxation": series, "youngs_modulus": "3 GPa", "poissons_ratio": 0.4}
    by_series = evaluated(relaxing, time="1 h", **quick)
    by_table = evaluated(relaxing | {"relaxation": None, "creep_modulus": {3600: after}}, **quick)
    np.testing.assert_allclose(by_series["mean_gap_after"], by_table["mean_gap_after"], rtol=1e-9)
    bodies = resolve({"contact": {"bodies": [{"relaxation": series}, "rigid"]}})[""]["contact"]["bodies"]
    assert [(body["youngs_modulus"], body["poissons_ratio"]) for body in bodies] == [(1e9, 0.5), (1e15, 0.0)]


def test_a_creep_modulus_is_stated_on_the_command_line():
    texts = [["3GPa", "0.4", "creep_modulus=1 h: 2.1 GPa, 10 years: 1.4 GPa"], ["rigid"]]
    contact = resolve({"contact": {"bodies": parse_bodies(texts), "mean_pressure": 1e6}})[""]["contact"]
    assert [*moduli_after(contact)] == [3600.0, 315576000.0]
    texts[0][-1] = "creep_modulus=2.1 GPa"
    with pytest.raises(rc.SettingsError, match=r"bodies\[0\]\.creep_modulus"):
        resolve({"contact": {"bodies": parse_bodies(texts), "mean_pressure": 1e6}})


def test_each_exit_has_what_has_crept_with_its_time(tmp_path):
    """Screen, JSON and table of one result, and that of cases with unlike times."""
    body, path = {"youngs_modulus": 3e9, "poissons_ratio": 0.4}, tmp_path / "map.nc"
    heights = rc.self_affine_surface((24, 24), 1e-6, hurst=0.8, shortest=4e-6, longest=24e-6, rms_height=2e-7)
    heights.to_netcdf(path)
    entries, results = [], {}
    for case, moduli in {"early": {"60": 2.5e9, "3600": 2e9}, "late": {"3600": 2e9, "7200": 1.8e9}}.items():
        contact = {"bodies": [body | {"creep_modulus": moduli}, body], "mean_pressure": [2e6]}
        settings = resolve({"contact": contact, "uncertainty": {"sources": ["solver"]}})[""]
        results[case], statistics = solve_file(path, {}, settings)
        write_dataset(statistics, tmp_path / f"{case}.nc")
        entries.append({"surface": "a", "case": case, "statistics": tmp_path / f"{case}.nc"})
    result, time = results["late"], 3600.0
    gap = float(statistics["mean_gap_after"].sel(time=time)[0])
    assert result["loads"][0]["after"][0]["time"] == time
    assert result["loads"][0]["after"][0]["mean_gap_after"] == gap
    assert re.search(r"after .*mean gap.*\n.*at once.*\n.*60 min .*\n.*2 h ", solution(result, statistics))
    together = collect_statistics(entries)
    assert together["time"].values.tolist() == [60.0, 3600.0, 7200.0]
    frame = summary_table(together).set_index("case")
    assert frame.loc["late", "mean_gap_after_3600s_m"] == gap
    assert frame.loc["early", "mean_gap_after_3600s_m"] == pytest.approx(gap, rel=1e-12)
    assert frame.loc["early", "mean_gap_after_60s_m"] > gap
    assert np.isnan(frame.loc["late", "mean_gap_after_60s_m"])
    for numbers, labels in ((together, [("case", "late")]), (statistics, [])):
        rows = rc.summary(numbers).set_index([*dict(labels), "quantity", "time"]).sort_index()
        row = rows.loc[[(*dict(labels).values(), "mean_gap_after", time)]].iloc[0]
        of_time = statistics.sel(time=time).isel(load=0)
        for column, suffix in (("value", ""), ("lower", "_lower"), ("upper", "_upper")):
            assert row[column] == of_time[f"mean_gap_after{suffix}"]
