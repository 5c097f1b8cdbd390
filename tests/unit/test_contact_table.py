"""The table over the mean gap: shear flow factors against closed forms and published curves."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from known_surfaces import self_affine
from scipy import sparse
from scipy.sparse.linalg import spsolve

import roughcontact as rc
from roughcontact.arguments.maps import spacing
from roughcontact.evaluation.evaluate import tabulate_by_gap
from roughcontact.interface.program import main
from roughcontact.statistics.sealing.flow import flow_columns
from roughcontact.surface.synthetic import rough_reference_surface
from validation import closed_forms
from validation.sealing import gaussian_heights


@pytest.mark.parametrize("depth", [0.3, 0.7])
def test_ridges_across_carry_what_the_closed_form_says(depth):
    """Ridges across the sliding direction: <g^-2>/<g^-3> of the mean gap is driven; along it all of it."""
    gap = (1 + depth * np.cos(2 * np.pi * (np.arange(4096) + 0.5) / 4096))[None]
    factors = flow_columns(gap, (1.0, 1.0))
    assert factors["shear_flow_x"] == pytest.approx(1 - (gap**-2.0).mean() / (gap**-3.0).mean(), abs=1e-6)
    along = flow_columns(np.broadcast_to(gap.T, (4096, 4)), (1.0, 1.0))
    assert along["shear_flow_x"] == pytest.approx(0, abs=1e-12)


def by_finite_differences(gap, carried):
    """Return the mean flux along x (viscosity 1) that a mean pressure gradient or moving faces carry.

    Reynolds' equation with the mean gap of two points between them, as in Patir and Cheng (1978); `carried`
    is the flux through the links of all points along both axes.
    """
    points = gap.shape[0]
    step, identity = sparse.eye(points, format="csr"), sparse.eye(points)
    ahead = sparse.csr_matrix(np.roll(step.toarray(), 1, axis=1)) - step  # of the next point, less this one
    differences = sparse.vstack([sparse.kron(ahead, identity), sparse.kron(identity, ahead)]).tocsr()
    faces = np.concatenate([((gap + np.roll(gap, -1, axis)) / 2).ravel() for axis in (0, 1)])
    conducts = sparse.diags(faces**3 / 12)
    # without one point, where the pressure is 0
    matrix = (differences.T @ conducts @ differences).tocsc()[1:, 1:]
    pressure = np.append(0, spsolve(matrix, (differences.T @ carried)[1:]))
    return (carried - conducts @ (differences @ pressure))[gap.size :].mean()


@pytest.mark.parametrize("rough_face_slides", [True, False])
def test_the_shear_factor_changes_its_sign_with_the_face_that_slides(rough_face_slides):
    """Reynolds' equation by finite differences: the gap moves with the rough face and squeezes the fluid."""
    points = 64
    x = 2 * np.pi * (np.arange(points) + 0.5) / points
    gap = 1 + 0.3 * np.cos(x) * np.cos(x[:, None]) + 0.2 * np.sin(2 * x + x[:, None])
    faces = (gap + np.roll(gap, -1, 1)) / 2
    # carried along x by the mean speed of the faces, half of one; seen from the rough face if that slides
    seen = (-1 if rough_face_slides else 1) * faces / 2
    flux = by_finite_differences(gap, np.append(np.zeros(gap.size), seen))
    flux += gap.mean() if rough_face_slides else 0.0
    factor = 2 * flux - gap.mean()  # sigma phi_s
    computed = flow_columns(gap, (1 / points, 1 / points), tolerance=1e-9)["shear_flow_x"] * gap.mean()
    assert computed > 0.05
    assert factor == pytest.approx(computed if rough_face_slides else -computed, rel=0.02)


@pytest.mark.parametrize("gap", [3.0, 6.0])
def test_finite_differences_give_the_published_factor_of_ridges_across(gap):
    """Patir and Cheng's gamma of 1/9: by their method on maps like theirs; on finer ones both meet."""
    theirs, coarse, fine = [], [], []
    for seed in range(6):
        height = gaussian_heights(6, 54, points=128, seed=seed)
        local = np.maximum(gap + height, 1e-9)
        faces = ((local + np.roll(local, -1, 1)) / 2) ** 3 / 12
        flux = by_finite_differences(local, np.append(np.zeros(local.size), faces))
        theirs.append(12 * flux / gap**3)
        for axis in (0, 1):  # linearly between the points
            between = (height + np.roll(height, -1, axis)) / 2
            height = np.stack([height, between], axis=axis + 1).reshape(
                [size * (1 + (index == axis)) for index, size in enumerate(height.shape)]
            )
        for factors, values in ((coarse, local), (fine, np.maximum(gap + height, 0))):
            factor = flow_columns(values, (1.0, 1.0), tolerance=1e-5)["flow_factor_xx"]
            factors.append(factor * (values.mean() / gap) ** 3)
    # three times the scatter of the mean, and the published fit
    assert np.mean(theirs) == pytest.approx(closed_forms.patir_cheng_flow_factor(gap, 1 / 9), abs=0.03)
    assert np.mean(coarse) < np.mean(fine) < np.mean(theirs)


def test_far_apart_it_is_three_halves_of_sigma_over_the_gap():
    """Patir and Cheng (1979): isotropic roughness moves 3/2 sigma/H times sigma, and at H = 3 0.46 of it."""
    height = rough_reference_surface(128)
    values = height.values / float(height.std())
    factors = []
    for gap in (20.0, 3.0):
        factors_at_gap = flow_columns(np.maximum(gap + values, 0), (1.0, 1.0), tolerance=1e-9)
        factors.append((factors_at_gap["shear_flow_x"] + factors_at_gap["shear_flow_y"]) / 2 * gap)
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


def test_flow_factors_of_a_map_are_not_tabulated_over_the_gap_of_an_overview(statistics):
    of_overview = statistics.assign(
        mean_gap_alone=statistics["mean_gap"], mean_gap=0.8 * statistics["mean_gap"]
    )
    message = (
        "the mean gap is that of the surface over an overview, the flow factors are of the map: solve it"
    )
    with pytest.raises(rc.SettingsError, match=f"{message} without the overview"):
        tabulate_by_gap(of_overview)


def test_the_table_is_that_of_the_statistics(statistics, tmp_path, capsys):
    window = rough_reference_surface(64) * 1e-6
    said = []
    table = rc.contact_table(
        window,
        contact_modulus="1 GPa",
        relative_pressure=[0.01, 0.1, 0.5],
        tolerance=1e-3,
        progress=lambda *what: said.append(what),
    )
    assert [what[:2] for what in said[2:]] == [*((done, 3) for done in range(4)), (3, 3)]
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
    assert main(["table", str(tmp_path / "result.nc"), "-o", str(tmp_path / "table.xlsx")]) == 2
    assert main(["table", str(tmp_path / "result.nc"), "-o", str(tmp_path / "table.csv")]) == 0
    assert main(["table", str(tmp_path / "result.nc"), "-o", str(tmp_path / "table.NC")]) == 0
    assert rc.read_dataset(tmp_path / "table.NC").attrs["rms_height"] == pytest.approx(sigma)
    written = pd.read_csv(tmp_path / "table.csv")
    assert {"mean_gap_m", "mean_pressure_Pa", "contact_stiffness_Pa_per_m", "shear_flow_factor_x"} <= set(
        written
    )
    assert written["rms_height_m"].values == pytest.approx(sigma, rel=1e-9)
    assert written["mean_gap_m"].values == pytest.approx(statistics["mean_gap"].values, rel=1e-6)
    assert main(["table", str(tmp_path / "result.nc")]) == 0
    assert capsys.readouterr().out.startswith("mean_gap_m,mean_pressure_Pa,")


@pytest.mark.parametrize(
    ("dims", "message"),
    [
        (("surface", "load"), "is of all surfaces; name the statistics.nc in the folder of one"),
        (("load",), "flow"),
    ],
)
def test_what_has_no_table_is_refused_by_the_name_of_its_file(dims, message, tmp_path, capsys):
    loads = np.full((2,) * len(dims), 1e6)
    numbers = xr.Dataset({"mean_gap": (dims, loads * 1e-13)}, coords={"mean_pressure": (dims, loads)})
    rc.write_dataset(numbers, tmp_path / "statistics.nc")
    assert main(["table", str(tmp_path / "statistics.nc")]) == 2
    sentence = capsys.readouterr().err
    assert f"{tmp_path / 'statistics.nc'}: " in sentence
    assert message in sentence


def test_the_ends_at_a_gap_are_those_of_a_curve_moved_along_it():
    """Of powers of the gap that is known to a factor of 1.2, and the stiffness with the conductance."""
    gap, factor, sigma = np.geomspace(3e-6, 1e-7, 2001), 1.2, 4e-7
    rows = {
        "mean_gap": gap,
        "approach": gap + 1e-6,
        "mean_gap_lower": gap / factor,
        "mean_gap_upper": gap * factor,
        "mean_pressure": 1e6 * (gap / 1e-6) ** -2.0,
        "contact_stiffness": 1e12 * (gap / 1e-6) ** -3.0,
        "conductance_per_conductivity": 10 * (gap / 1e-6) ** -3.0,
        "conductance_per_conductivity_lower": 5 * (gap / 1e-6) ** -3.0,
        "conductance_per_conductivity_upper": 20 * (gap / 1e-6) ** -3.0,
    }
    for axis in "xy":
        rows |= {f"flow_factor_{axis}{axis}": gap / 3e-6, f"shear_flow_{axis}": (gap / 1e-6) ** -2.0}
    statistics = xr.Dataset({name: ("load", values) for name, values in rows.items()}).assign(
        rms_height=sigma
    )
    table = tabulate_by_gap(statistics)
    inner = table.sel(mean_gap=slice(2.4e-6, 1.3e-7))
    # a gap larger by f at each load: p(u) = 1/u^2 becomes f^2/u^2
    for name, exponent in {
        "mean_pressure": 2,
        "pressure_flow_factor_x": -1,
        "shear_flow_factor_x": 2,
        "shear_flow_factor_y": 2,
    }.items():
        low, high = sorted([factor**exponent, factor**-exponent])
        np.testing.assert_allclose(inner[f"{name}_lower"], low * inner[name], rtol=1e-4)
        np.testing.assert_allclose(inner[f"{name}_upper"], high * inner[name], rtol=1e-4)
    np.testing.assert_allclose(table["contact_stiffness_lower"], table["contact_stiffness"] / 2)
    np.testing.assert_allclose(table["contact_stiffness_upper"], table["contact_stiffness"] * 2)
    # beyond the loads that were solved
    assert float(table["mean_pressure_lower"][0]) == 0
    assert np.isnan(float(table["mean_pressure_upper"][-1]))
    assert float(table["pressure_flow_factor_x_lower"][-1]) == 0
    assert float(table["pressure_flow_factor_x_upper"][0]) == 1  # of faces far apart
    assert float(table["shear_flow_factor_x_lower"][0]) == 0


def test_an_interval_from_the_closed_gap_to_faces_far_apart_is_none():
    """A gap that may be that of either load, or of none, tells nothing of flow and pressure."""
    rows = {"mean_gap": [4e-7, 2e-7], "mean_gap_lower": [5e-8, 3e-8], "mean_gap_upper": [9e-7, 8e-7]}
    rows |= {"mean_pressure": [1e6, 4e6], "contact_stiffness": [1e12, 4e12], "approach": [1e-6, 8e-7]}
    rows |= {"relative_contact_area": [0.01, 0.04], "conductance_per_conductivity": [10.0, 40.0]}
    rows |= {"relative_contact_area_lower": [0.008, 0.03], "relative_contact_area_upper": [0.02, 0.05]}
    for axis in "xy":
        rows |= {f"flow_factor_{axis}{axis}": [0.9, 0.8], f"shear_flow_{axis}": [0.2, 0.3]}
    statistics = xr.Dataset({name: ("load", values) for name, values in rows.items()})
    table = tabulate_by_gap(statistics.assign(rms_height=3e-7))
    for name in ("pressure_flow_factor_x", "shear_flow_factor_y", "mean_pressure"):
        assert table[name].notnull().all()
        assert table[f"{name}_lower"].isnull().all()
        assert table[f"{name}_upper"].isnull().all()
    assert table["relative_contact_area_upper"].notnull().all()


def test_a_pressure_is_possible_at_a_gap_where_the_gap_is_possible_at_that_pressure():
    """Intervals of the table at a gap and of the statistics at a load say the same; none is impossible."""
    window = rc.periodic_window(rc.level(rc.read_height_map("data_samples/ground.txt")))
    loads = np.geomspace(1e-3, 2, 12).tolist()
    statistics = rc.evaluate(
        window,
        level={"form": "none", "outlier_threshold": None},
        contact={"contact_modulus": "100 GPa", "relative_pressure": loads},
        statistics={"flow": "always"},
        window={"method": "raw"},
    )
    table = tabulate_by_gap(statistics)
    gap, pressure = table["mean_gap"].values, statistics["mean_pressure"].values
    assert gap[-1] == 0  # as closed as it gets
    lower, upper = (statistics[f"mean_gap_{side}"].values for side in ("lower", "upper"))
    possible = (lower[None] <= gap[:, None]) & (gap[:, None] <= upper[None])
    lowest = table["mean_pressure_lower"].values[:, None]
    largest = table["mean_pressure_upper"].fillna(np.inf).values[:, None]
    is_within = (lowest <= pressure * (1 + 1e-9)) & (pressure * (1 - 1e-9) <= largest)
    np.testing.assert_array_equal(is_within[:-1], possible[:-1])
    assert possible[:-1].sum() > 2 * gap.size
    assert np.isnan([table["mean_pressure_lower"][-1], table["mean_pressure_upper"][-1]]).all()
    for name in ("mean_pressure", "relative_contact_area", "contact_stiffness"):
        for side in ("lower", "upper"):
            assert (np.diff(table[f"{name}_{side}"].dropna("mean_gap")) >= 0).all()
    for axis in "xy":
        for name, largest_value in {"pressure": 1.5, "shear": gap / table.attrs["rms_height"]}.items():
            low, value, high = (
                table[f"{name}_flow_factor_{axis}{side}"].values for side in ("_lower", "", "_upper")
            )
            bounds = np.array([np.zeros_like(low), low, value, high, largest_value + 1e-12 + 0 * value])
            has_ends = np.isfinite(low)  # nothing is known from the closed gap to faces far apart
            np.testing.assert_array_equal(has_ends, np.isfinite(high))
            assert has_ends.sum() > gap.size / 2
            assert (np.diff(bounds[:, has_ends], axis=0) >= 0).all()


def test_without_an_error_budget_the_columns_of_the_ends_are_empty(statistics):
    bare = statistics.drop_vars(
        [name for name in statistics.variables if name.endswith(("_lower", "_upper"))]
    )
    table = tabulate_by_gap(bare)
    bound_columns = [name for name in table.data_vars if name.endswith(("_lower", "_upper"))]
    assert len(bound_columns) == 16
    assert all(np.isnan(table[name]).all() for name in bound_columns)
    np.testing.assert_array_equal(table["mean_pressure"], tabulate_by_gap(statistics)["mean_pressure"])


@pytest.mark.parametrize("hardness", [None, 1.4e9])
def test_the_approach_is_that_of_the_bodies(hardness):
    """Where no point flows the heights, the gap and the displacement by the pressure tell the place."""
    window = rc.periodic_window(rc.level(rc.read_height_map("data_samples/ground.txt")))
    problem = {"contact_modulus": 1.154e11, "mean_pressure": [6e6, 4.5e8, 1.2e9], "hardness": hardness}
    law = rc.contact_table(window, **problem)
    solved = rc.solve_contact(window, **problem, tolerance=1e-6)
    axes = [2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(window.shape, spacing(window), strict=True)]
    q = np.hypot.outer(*axes)
    q[0, 0] = np.inf
    positions = []
    for pressure, gap in zip(solved["pressure"].values, solved["gap"].values, strict=True):
        displacement = np.fft.ifft2(np.fft.fft2(pressure) * 2 / (problem["contact_modulus"] * q)).real
        unyielded = pressure < (hardness or np.inf) * (1 - 1e-6)
        positions.append(np.mean((gap + window.values - displacement)[unyielded]))
    np.testing.assert_allclose(np.diff(law["approach"]), np.diff(positions), rtol=3e-3)
    by_gap = np.diff(law["mean_gap"])
    if hardness:
        assert (np.diff(positions) < [1.05, 1.8] * by_gap).all()
    else:
        np.testing.assert_allclose(np.diff(law["approach"]), by_gap, rtol=1e-9)


def test_loads_end_below_the_hardness_of_named_materials():
    window = rc.periodic_window(rc.level(rc.read_height_map("data_samples/sandblasted.x3p")))
    table = rc.contact_table(window, bodies=["steel", "steel"], loads=4)
    assert float(table["mean_pressure"].max()) == pytest.approx(
        0.95 * rc.material("steel")["hardness"], rel=1e-6
    )
    assert float(table["relative_contact_area"].max()) > 0.9
    explicit_loads = rc.contact_table(window, contact_modulus="100 GPa", mean_pressure=["100 MPa", "200 MPa"])
    np.testing.assert_allclose(explicit_loads["mean_pressure"], [1e8, 2e8])
    with pytest.raises(rc.SettingsError, match="loads = 0"):
        rc.contact_table(window, contact_modulus="100 GPa", loads=0)


def test_closed_gaps_of_conductors_are_no_warning():
    metal = {"youngs_modulus": "100 GPa", "poissons_ratio": 0.3, "electrical_resistivity": 2e-8}
    table = rc.contact_table(
        rough_reference_surface(64) * 1e-6, bodies=[metal, metal], relative_pressure=[0.1, 20]
    )
    closed = table.isel(mean_gap=-1)
    assert closed["mean_gap"] == closed["pressure_flow_factor_x"] == 0
    assert np.isnan([closed["mean_pressure_lower"], closed["mean_pressure_upper"]]).all()


@pytest.mark.slow
def test_the_table_of_cuts_holds_that_of_the_whole_surface():
    """Curves of a surface that is nine times as large lie within the ends in nine of ten rows."""
    large_surface = self_affine((384, 384), 1e-6, (4e-6, 4e-5), rms_height=3e-7, seed=2)
    true = rc.contact_table(large_surface, contact_modulus="1 GPa", loads=12).sortby("mean_gap")
    sigma = true.attrs["rms_height"]
    inside = []
    for corner in (0, 128, 256):
        cut = rc.height_map(large_surface.values[corner : corner + 128, :128], 1e-6)
        table = rc.contact_table(rc.periodic_window(rc.level(cut)), contact_modulus="1 GPa", loads=12)
        table = table.sel(mean_gap=slice(float(true["mean_gap"].max()), 0.15 * sigma))
        for name in ("mean_pressure", "pressure_flow_factor_x", "shear_flow_factor_x"):
            values = np.interp(np.log(table["mean_gap"]), np.log(true["mean_gap"]), true[name])
            if name.startswith("shear"):  # times sigma is what drives the flow
                values = values * sigma / table.attrs["rms_height"]
            bounds = table[f"{name}_lower"].fillna(0.0), table[f"{name}_upper"].fillna(np.inf)
            inside += ((bounds[0] <= values) & (values <= bounds[1])).values.tolist()
    assert np.mean(inside) >= 0.9


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ccx") is None, reason="needs CalculiX (Debian: calculix-ccx)")
@pytest.mark.parametrize("hardness", ["none", "200 MPa"])
def test_finite_elements_return_the_contact_law(tmp_path, hardness):
    """Two blocks in CalculiX that are pressed together, the upper one warm, in mm, N, MPa, mW."""
    body = {"youngs_modulus": "2 GPa", "poissons_ratio": 0.0, "thermal_conductivity": 50.0}
    bodies = [body | ({} if hardness == "none" else {"hardness": hardness}), body]
    loads = np.geomspace(5e-4, 0.3, 12).tolist()
    waves = {"hurst": 0.8, "longest": 3e-5, "shortest": 4e-6}
    face = rc.self_affine_surface((64, 64), 1e-6, **waves, rms_height=4e-7, seed=1)
    result = rc.evaluate(
        face,
        contact={"bodies": bodies, "relative_pressure": loads, "tolerance": 1e-3},
        statistics={"flow": "always"},
        window={"method": "raw"},
        uncertainty={"sources": []},
    )
    rc.write_dataset(result, tmp_path / "result.nc")
    assert main(["table", str(tmp_path / "result.nc"), "-o", str(tmp_path / "law.inp")]) == 0
    law = tabulate_by_gap(result)
    *_, by_gap = (tmp_path / "law.inp").read_text().partition("** conductance, mean gap\n")
    rows = np.array([line.removeprefix("** ").split(", ") for line in by_gap.splitlines()], float)
    np.testing.assert_allclose(rows.T, [law["thermal_conductance"] * 1e-3, law["mean_gap"] * 1e3], rtol=1e-8)
    touch = (law["approach"] + law["mean_pressure"] / law["contact_stiffness"]).values[0]
    pressure = np.append(0, law["mean_pressure"]) * 1e-6
    overclosure = np.append(0, touch - law["approach"]) * 1e3
    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    points = [(x, y, z) for z in (-1, 0, 0, 1) for x, y in corners]
    nodes = "\n".join(f"{number}, {x}, {y}, {z}" for number, (x, y, z) in enumerate(points, start=1))

    def pressed(rows, kind, closing):
        """Return what CalculiX prints: pressure, what the faces have come closer, heat over difference."""
        blocks = Path(__file__).with_name("scripts") / "blocks.inp"
        text = blocks.read_text().format(nodes=nodes, law=rows, kind=kind, closing=-closing)
        (tmp_path / "blocks.inp").write_text(text)
        subprocess.run(["ccx", "blocks"], cwd=tmp_path, check=True, capture_output=True)
        printed = (tmp_path / "blocks.dat").read_text()

        def numbers(pattern):
            found = [float(number) for number in re.findall(pattern, printed)]
            assert len(found) == 10
            return np.array(found)

        forces = -numbers(r"total force.*\n\n(?:\s+\S+){2}\s+(\S+)")
        heat = numbers(r"total heat.*\n\n\s+(\S+)")
        lower, upper = (numbers(rf"\n +{node}(?: +\S+){{2}} +(\S+)") for node in (5, 9))
        colder, warmer = (numbers(rf"\n +{node} +(\S+)(?=\n)") for node in (5, 9))
        return forces, lower - upper, heat / (warmer - colder)

    compression = 2 * pressure[8] / 210000
    forces, closer, _ = pressed("*INCLUDE, INPUT=law.inp", "NODE", overclosure[8] + compression)
    assert forces.max() > 0.99 * pressure[8]
    # digits of the printed displacements
    np.testing.assert_allclose(forces, np.interp(closer, overclosure, pressure), rtol=1e-5)
    # CalculiX 2.20 knows the pressure of a conductance from a linear law between surfaces alone
    conducts = (tmp_path / "law.inp").read_text().partition("*GAP CONDUCTANCE")
    stiff = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1e5\n"
    forces, _, conductance = pressed(
        stiff + "".join(conducts[1:]), "SURFACE", pressure[8] / 1e5 + compression
    )
    assert forces.max() > 0.99 * pressure[8]
    expected = np.interp(forces, pressure[1:], law["thermal_conductance"] * 1e-3)
    np.testing.assert_allclose(conductance, expected, rtol=1e-5)


def test_the_rows_of_the_window_stay_where_they_are():
    """Rows that jump are those of the map that was given, as for `solve_contact`."""
    jumps = 0.05 * np.random.default_rng(0).normal(size=(64, 1))
    window = 0.01 * (rough_reference_surface(64) + jumps - jumps.mean())
    load = {"contact_modulus": "1 GPa", "mean_pressure": "1 MPa", "tolerance": 1e-3}
    assert rc.contact_table(window, **load).attrs["rms_height"] == pytest.approx(float(window.std()))


def test_statistics_without_flow_are_refused(statistics):
    with pytest.raises(rc.SettingsError, match="--flow always, or with flow: always"):
        tabulate_by_gap(statistics.drop_vars("flow_factor_xx"))


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"loads": 2.5}, rc.SettingsError, "loads = 2.5: give a whole number"),
        ({"loads": "4"}, rc.SettingsError, "loads = '4': give a whole number"),
        ({"loads": 0}, rc.SettingsError, "loads = 0: give a whole number"),
        (
            {"boundary": "free", "force": 1.0},
            rc.SettingsError,
            "contact_table, boundary 'free': .*periodic map",
        ),
        ({}, rc.HeightMapError, "flat"),
    ],
)
def test_what_is_no_table_of_a_map_is_refused(arguments, error, words):
    flat = rc.height_map(np.zeros((16, 16)), 1e-6)
    with pytest.raises(error, match=words):
        rc.contact_table(flat, contact_modulus="1 GPa", **arguments)
