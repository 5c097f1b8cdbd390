"""What `solve_contact` returns, refuses and promises, whatever the map."""

from functools import partial

import array_api_compat
import numpy as np
import pytest
import scipy
import xarray as xr
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact.arguments.maps import height_map
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.loads import DEFAULT_PLAN, plan_loads
from roughcontact.contact.response import linear_response
from roughcontact.kernels.fourier import wavenumbers
from roughcontact.surface import synthetic
from validation.closed_forms import full_contact_fluctuation

MODULUS = 2e9


def rough(shape=(64, 48), spacing=(1e-6, 1.5e-6), seed=1, gradient=0.1):
    return self_affine(shape, spacing, (8e-6, 80e-6), rms_gradient=gradient, seed=seed)


@pytest.fixture(scope="module")
def solved():
    window = rough()
    loads = [2e7, 2e6, 4e8, 2e6]
    return window, rc.solve_contact(window, contact_modulus=MODULUS, mean_pressure=loads, tolerance=1e-6)


def test_names_dimensions_and_units_follow_the_conventions(solved):
    window, contact = solved
    assert contact.sizes == {"load": 4, "y": 64, "x": 48}
    for name in ("pressure", "gap", "contact"):
        assert contact[name].dims == ("load", "y", "x")
    units = {"pressure": "Pa", "gap": "m", "approach": "m", "mean_pressure": "Pa", "error_bound": "1"}
    assert {name: contact[name].attrs["units"] for name in units} == units
    np.testing.assert_array_equal(contact["x"], window["x"])
    np.testing.assert_array_equal(contact["height"], window)
    assert contact["height"].attrs["source_format"] == "array"
    assert contact["contact"].dtype == np.int8


def test_loads_keep_their_order_and_a_repeated_load_repeats_its_solution(solved):
    _, contact = solved
    np.testing.assert_array_equal(contact["mean_pressure"], [2e7, 2e6, 4e8, 2e6])
    np.testing.assert_allclose(contact["pressure"][1], contact["pressure"][3], atol=1e-5 * 2e8)


def test_every_load_fulfils_the_contact_conditions(solved):
    window, contact = solved
    assert (contact["converged"] == 1).all()
    assert (contact["error_bound"] <= 1e-6).all()
    assert (contact["load_error"] < 1e-14).all()
    for load in range(contact.sizes["load"]):
        piece = contact.isel(load=load)
        pressure, gap = piece["pressure"].values, piece["gap"].values
        assert pressure.min() >= 0
        assert max(0.0, -gap.min()) == float(piece["max_penetration"])
        assert -gap.min() < 1e-5 * np.ptp(window.values)
        np.testing.assert_array_equal(piece["contact"], pressure > 0)
        q = wavenumbers(pressure.shape, (1e-6, 1.5e-6))
        spectrum = np.fft.rfft2(pressure)
        spectrum[0, 0] = 0
        q[0, 0] = 1
        displacement = np.fft.irfft2(spectrum * 2 / (MODULUS * q), s=pressure.shape)
        rebuilt = displacement - window.values + float(piece["approach"])
        np.testing.assert_allclose(gap, rebuilt, rtol=0, atol=1e-12 * np.ptp(window.values))


@pytest.mark.parametrize("rule", ["zero", "nogi-kato", "lattice"])
def test_the_file_says_what_the_approach_is(tmp_path, rule):
    """Sign, reference and the part of the zero frequency: in words, and so it is."""
    height = height_map(rough().values[:, :40] + 3e-6, 1e-6)[:40, :40]
    loads = np.array([1e6, 1e7, 1e8])
    contact = rc.solve_contact(
        height, contact_modulus=MODULUS, mean_pressure=loads, zero_frequency=rule, tolerance=1e-8
    )
    rc.write_dataset(contact, tmp_path / "contact.nc")
    approach = rc.read_dataset(tmp_path / "contact.nc")["approach"]
    assert "falls as the load rises" in approach.attrs["long_name"]
    assert (np.diff(approach) < 0).all()
    assert "gap = displacement - height + approach" in approach.attrs["comment"]
    mean_displacement = contact["gap"].mean(("y", "x")) + height.mean() - approach
    side = 40e-6
    factor = {"zero": 0.0, "nogi-kato": 4 * np.arcsinh(1.0) / np.pi, "lattice": 3.900264920001956 / np.pi}[
        rule
    ]
    np.testing.assert_allclose(mean_displacement, factor * side * loads / MODULUS, rtol=1e-9, atol=1e-14)


def test_fields_are_optional_and_reduce_replaces_them():
    window = rough()
    kwargs = {"contact_modulus": MODULUS, "mean_pressure": [1e7, 5e7]}
    full = rc.solve_contact(window, **kwargs)
    scalars = rc.solve_contact(window, fields=False, **kwargs)
    assert set(full.data_vars) - set(scalars.data_vars) == {"pressure", "gap", "contact", "height"}
    assert set(scalars.dims) == {"load"}
    xr.testing.assert_identical(scalars, full.drop_dims(["y", "x"]))
    reduced = rc.solve_contact(window, reduce=rc.contact_statistics, **kwargs)
    statistics = rc.contact_statistics(full)
    for name in statistics.data_vars:
        np.testing.assert_array_equal(reduced[name], statistics[name], err_msg=name)


def test_a_reduce_that_cannot_reduce_is_named():
    kwargs = {"contact_modulus": MODULUS, "mean_pressure": [1e7]}
    with pytest.raises(rc.SettingsError, match="reduce = 'area': give a function of a Dataset"):
        rc.solve_contact(rough(), reduce="area", **kwargs)
    with pytest.raises(rc.RoughContactError, match="given as reduce returned NoneType: let it return a Data"):
        rc.solve_contact(rough(), reduce=lambda contact: None, **kwargs)


@pytest.mark.parametrize("threads", [0, -3])
def test_a_number_of_threads_is_one_or_more(threads):
    with pytest.raises(rc.SettingsError, match=rf"threads = {threads}: give a whole number of 1 or more"):
        rc.solve_contact(rough(), contact_modulus=MODULUS, mean_pressure=[1e7], threads=threads)


def test_progress_is_told_after_every_load():
    calls = []
    rc.solve_contact(
        rough(), contact_modulus=MODULUS, mean_pressure=[1e7, 5e6], progress=lambda *call: calls.append(call)
    )
    assert [call[:2] for call in calls] == [(1, 2), (2, 2)]
    assert "5e+06 Pa" in calls[0][2]


@pytest.mark.parametrize("rule", ["nogi-kato", "lattice"])
@pytest.mark.parametrize("shape", [(1, 48), (48, 1)])
def test_a_profile_has_no_mean_displacement_but_its_own(rule, shape):
    """It goes on without end across: the sum over all of it has none."""
    profile = height_map(rough().values[0].reshape(shape), 1e-6)
    with pytest.raises(
        rc.SettingsError, match=f"zero_frequency = '{rule}' is for maps.* use 'zero'"
    ) as caught:
        rc.solve_contact(profile, contact_modulus=MODULUS, mean_pressure=1e6, zero_frequency=rule)
    assert caught.value.keys == ("zero_frequency",)


def test_a_flat_map_takes_no_iteration():
    flat = height_map(np.full((8, 12), 1e6), 1e-6)
    contact = rc.solve_contact(flat, contact_modulus=MODULUS, mean_pressure=[1e6, 1e7])
    np.testing.assert_array_equal(contact["pressure"][1], np.full((8, 12), 1e7))
    assert (contact["gap"] == 0).all()
    assert (contact["operator_applications"] == 0).all()
    assert (contact["error_bound"] == 0).all()
    assert (contact["approach"] == 1e6).all()


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"contact_modulus": -1.0}, rc.SettingsError, "contact_modulus = -1"),
        ({"contact_modulus": "steel"}, rc.SettingsError, "steel"),
        ({"mean_pressure": []}, rc.SettingsError, "empty"),
        ({"mean_pressure": [1e6, 0.0]}, rc.SettingsError, "mean_pressure = 0"),
        ({"mean_pressure": np.nan}, rc.SettingsError, "mean_pressure = nan"),
        ({"tolerance": 1e-16}, rc.SettingsError, "tolerance"),
        ({"tolerance": 1.0}, rc.SettingsError, "tolerance"),
        ({"zero_frequency": "periodic"}, rc.SettingsError, "nogi-kato"),
        ({"zero_frequency": "lattice"}, rc.SettingsError, "square"),
        ({"on_failure": "ignore"}, rc.SettingsError, "flag"),
    ],
)
def test_meaningless_arguments_are_refused_by_name(change, error, words):
    arguments = {"contact_modulus": MODULUS, "mean_pressure": 1e6} | change
    with pytest.raises(error, match=words):
        rc.solve_contact(rough(), **arguments)


def test_maps_that_cannot_be_solved_are_refused():
    window = rough()
    holes = window.copy()
    holes[3, 4] = np.nan
    holes[0, 0] = np.inf
    uneven = window.assign_coords(x=window["x"].values ** 1.2)
    backwards = window[:, ::-1]
    cases = [
        (holes, "2 of 3072"),
        (uneven, "not evenly spaced"),
        (backwards, "increase"),
        (window[:1, :1], "single point"),
        (window.rename(x="u"), "dimensions"),
        (window.drop_vars("x"), "pixel size"),
    ]
    for bad, words in cases:
        with pytest.raises(rc.HeightMapError, match=words):
            rc.solve_contact(bad, contact_modulus=MODULUS, mean_pressure=1e6)


def test_a_tolerance_below_the_rounding_floor_is_raised_or_flagged_never_returned():
    window = rough(shape=(256, 256))
    kwargs = {"contact_modulus": MODULUS, "mean_pressure": 6e7, "tolerance": 1e-15}
    with pytest.raises(rc.ConvergenceError, match=r"rounding in double\s+precision"):
        rc.solve_contact(window, **kwargs)
    flagged = rc.solve_contact(window, on_failure="flag", **kwargs)
    assert float(flagged["converged"][0]) == 0
    assert 1e-15 < float(flagged["error_bound"][0]) < 1e-11


def test_single_precision_says_its_floor_and_keeps_to_it():
    window, load = rough(shape=(256, 256)), {"contact_modulus": MODULUS, "mean_pressure": 2e7}
    double = rc.solve_contact(window, tolerance=1e-8, **load)
    single = rc.solve_contact(window, tolerance=1e-4, precision="single", **load)
    assert single["pressure"].dtype == single["gap"].dtype == np.float32
    floor = float(single["rounding_floor"][0])
    assert 1e-7 < floor < float(single["error_bound"][0]) <= 1e-4
    error = np.linalg.norm(single["pressure"] - double["pressure"]) / np.linalg.norm(double["pressure"])
    assert error < 3e-4
    with pytest.raises(rc.ConvergenceError, match="rounding in single"):
        rc.solve_contact(window, tolerance=1e-3 * floor, precision="single", **load)
    with pytest.raises(rc.SettingsError, match="precision = 'half'"):
        rc.solve_contact(window, precision="half", **load)


def test_runs_repeat_exactly_and_thread_counts_agree_to_the_certificate():
    window, load = rough(shape=(512, 512)), {"contact_modulus": MODULUS, "mean_pressure": 2e7}
    first_result, repetition = (rc.solve_contact(window, tolerance=1e-5, **load) for _ in range(2))
    np.testing.assert_array_equal(first_result["pressure"], repetition["pressure"])
    with_two_threads = rc.solve_contact(window, tolerance=1e-5, threads=2, **load)
    assert float(with_two_threads["contact"].mean()) == pytest.approx(
        float(first_result["contact"].mean()), rel=1e-4
    )
    assert np.linalg.norm(with_two_threads["pressure"] - first_result["pressure"]) <= 4e-5 * np.linalg.norm(
        first_result["pressure"]
    )


def test_loads_from_one_pixel_to_ten_times_full_contact():
    window = rough()
    spacing = (1e-6, 1.5e-6)
    full = -full_contact_fluctuation(window.values, spacing, MODULUS).min()
    loads = [1e-7 * full, 1e-4 * full, 0.5 * full, 0.999 * full, 1.001 * full, 10 * full]
    contact = rc.solve_contact(window, contact_modulus=MODULUS, mean_pressure=loads, tolerance=1e-8)
    points = contact["contact"].sum(["y", "x"]).values
    assert points[0] == 1
    assert (np.diff(points[:5]) > 0).all()
    assert points[-1] == points[-2] == window.size
    assert (contact["converged"] == 1).all()


def relative_numbers(window, *, modulus, pressure):
    stats = rc.contact_statistics(
        rc.solve_contact(window, contact_modulus=modulus, mean_pressure=pressure, tolerance=3e-12)
    )
    rms = float(stats["rms_height"])
    return np.array(
        [
            float(stats["relative_contact_area_pixels"][0]),
            float(stats["relative_contact_area"][0]),
            float(stats["max_pressure"][0]) / pressure,
            float(stats["mean_gap"][0]) / rms,
            float(stats["elastic_energy"][0]) / (pressure * rms),
        ]
    )


def test_relative_numbers_do_not_depend_on_units_position_or_orientation():
    spacing = 1e-6
    window = self_affine((48, 48), spacing, (8e-6, 48e-6), rms_gradient=0.1, seed=5)
    values, pressure = window.values, 0.1 * 0.1 * MODULUS
    expected = relative_numbers(window, modulus=MODULUS, pressure=pressure)

    def same(heights, pitch=spacing, modulus=MODULUS, load=pressure):
        numbers = relative_numbers(height_map(heights, pitch), modulus=modulus, pressure=load)
        np.testing.assert_allclose(numbers, expected, rtol=1e-10)

    same(np.roll(values, (7, -5), axis=(0, 1)))
    same(values[::-1])
    same(values[:, ::-1])
    same(values.T)
    same(np.tile(values, (2, 2)))
    same(values * 1e6, pitch=1.0)  # µm
    same(values, modulus=MODULUS * 1e-6, load=pressure * 1e-6)  # MPa
    same(values * 1e9, load=pressure * 1e9)  # steeper, in proportion to the load
    same(values * 1e-9, load=pressure * 1e-9)


def test_an_offset_of_the_heights_only_shifts_the_approach():
    window = rough()
    kwargs = {"contact_modulus": MODULUS, "mean_pressure": 5e7, "tolerance": 1e-6}
    near, far = (rc.solve_contact(window + offset, **kwargs) for offset in (0.0, 1.0))
    scale = float(near["pressure"].max())
    # heights of 1 m keep 1e-16 m: 1e-10 of the rms height here
    np.testing.assert_allclose(far["pressure"], near["pressure"], rtol=0, atol=1e-5 * scale)
    assert float(far["approach"][0] - near["approach"][0]) == pytest.approx(1.0, rel=1e-12)


def test_the_elastic_energy_the_gap_and_the_load_agree():
    """dU = -p d(mean gap), by differences over a narrow load step, and the linear response is that slope."""
    window = rough(shape=(96, 96), spacing=(1e-6, 1e-6))
    mean = 3e7
    loads = [mean * 0.995, mean, mean * 1.005]
    contact = rc.solve_contact(window, contact_modulus=MODULUS, mean_pressure=loads, tolerance=1e-9)
    stats = rc.contact_statistics(contact)
    energy, gap = stats["elastic_energy"].values, stats["mean_gap"].values
    assert energy[2] - energy[0] == pytest.approx(-mean * (gap[2] - gap[0]), rel=1e-4)
    response, _ = linear_response(
        contact["contact"].values[1] > 0, (1e-6, 1e-6), Elasticity(MODULUS), tolerance=1e-3
    )
    # points that join or leave in between make the difference quotient no better than this
    assert response == pytest.approx(-(gap[2] - gap[0]) / (loads[2] - loads[0]), rel=5e-3)


def test_linear_response_limits():
    with pytest.raises(ValueError, match="no point"):
        linear_response(np.zeros((4, 4), bool), (1.0, 1.0), Elasticity(MODULUS))
    assert linear_response(np.ones((4, 4), bool), (1.0, 1.0), Elasticity(MODULUS)) == (0, 0)
    # a strip of half the width: d(mean gap)/dp = -(2 L / pi E*) ln sin(pi a / 2), a = share in contact
    # (periodic flat punches, half-plane: Johnson 1985, section 2.8, by superposition of Westergaard's waves)
    n, length = 2048, 1e-3
    strip = np.zeros((1, n), bool)
    strip[0, : n // 2] = True
    exact = -2 * length / (np.pi * MODULUS) * np.log(np.sin(np.pi / 4))
    assert linear_response(strip, (length / n, length / n), Elasticity(MODULUS), 1e-4)[0] == pytest.approx(
        exact, rel=2e-3
    )


def test_load_plans():
    window = rough()
    assert plan_loads(window, contact_modulus=MODULUS, mean_pressure=3e6) == [3e6]
    planned = np.array(plan_loads(window, contact_modulus=MODULUS)) / (MODULUS * 0.1)
    area = scipy.special.erf(np.sqrt(2) * np.array(DEFAULT_PLAN))
    suitable = (area * window.size >= 200) & (np.array(DEFAULT_PLAN) * 0.1 / area < 0.1)
    np.testing.assert_allclose(planned, np.array(DEFAULT_PLAN)[suitable], rtol=1e-12)
    relative = plan_loads(window, contact_modulus=MODULUS, relative_pressure=[0.1, 0.2])
    np.testing.assert_allclose(relative, [0.1 * MODULUS * 0.1, 0.2 * MODULUS * 0.1], rtol=1e-12)
    with pytest.raises(rc.SettingsError, match="both"):
        plan_loads(window, contact_modulus=MODULUS, mean_pressure=1.0, relative_pressure=1.0)
    flat = height_map(np.zeros((4, 4)), 1.0)
    with pytest.raises(rc.HeightMapError, match="flat"):
        plan_loads(flat, contact_modulus=MODULUS)


@pytest.mark.parametrize(
    ("gradient", "modulus", "last"), [(0.02, 1e11, 1.0), (0.12, 1e11, 0.5), (0.5, 5e6, 1.0)]
)
def test_planned_loads_end_where_every_material_flows(gradient, modulus, last):
    """No material but rubber bears a mean pressure in contact of 0.1 E* (Ashby 2011)."""
    window = rough(gradient=gradient)
    loads = plan_loads(window, contact_modulus=modulus)
    assert loads[-1] == pytest.approx(last * modulus * gradient)
    solved = rc.contact_statistics(rc.solve_contact(window, contact_modulus=modulus, mean_pressure=loads))
    assert (solved["relative_contact_area_pixels"] * window.size >= 100).all()
    in_contact = solved["mean_contact_pressure"].values / modulus
    assert (in_contact < 0.1).all() or modulus < 1e8


def test_a_load_gives_what_it_does_alone_and_shares_the_cost_of_the_setup():
    window = rough()
    loads = [3e6, 3.006e6, 3.012e6]
    together = rc.solve_contact(window, contact_modulus=MODULUS, mean_pressure=loads)
    for number, load in enumerate(loads):
        single_load = rc.solve_contact(window, contact_modulus=MODULUS, mean_pressure=load)
        # the gradient's transform, and the pressure of full contact, which is looked at once
        setup = 0.0 if number == 0 else 0.5 + 1.0
        applications = float(together["operator_applications"][number])
        assert applications == pytest.approx(
            float(single_load["operator_applications"][0]) - setup, abs=1e-12
        )
        np.testing.assert_array_equal(together["pressure"][number], single_load["pressure"][0])


def test_deep_pits_in_lines_far_apart_converge_by_safe_steps():
    # the fast steps fail here again and again: what converges are the projected ones between them
    height = -(np.abs(np.random.default_rng(3).standard_normal((11, 10))) ** 3)
    window = height_map(height, (1e-3, 2.5))
    contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=35.0, tolerance=1e-8)
    assert float(contact["error_bound"][0]) <= 1e-8
    assert float(contact["max_penetration"][0]) < 1e-6


@pytest.mark.parametrize("load", [1e-8, 1e-7, 1e-6, 1e-5])
def test_a_load_that_rounding_hides_behind_the_residual_is_carried(load):
    # a chessboard of pixels in lines far apart: the first steps move a million times the load to and fro
    window = height_map(np.indices((15, 15)).sum(0) % 2 * 1.0, (1.0, 3.5))
    contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=load, tolerance=1e-6)
    assert float(contact["error_bound"][0]) <= 1e-6
    np.testing.assert_allclose(contact["pressure"].mean(), load, rtol=1e-14)


@pytest.mark.parametrize("aspect", [1000.0, 30.0, 1 / 30, 1e-3])
@pytest.mark.parametrize("relative", [0.01, 0.1, 1.0])
def test_elongated_pixels_need_no_more_than_a_few_times_the_work(aspect, relative):
    square = self_affine((128, 128), 1.0, (8.0, 64.0), rms_gradient=0.1, seed=2)
    window = height_map(square.values, (aspect, 1.0))
    loads = plan_loads(window, contact_modulus=1.0, relative_pressure=relative)
    contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=loads, tolerance=1e-6)
    assert float(contact["converged"][0]) == 1
    assert float(contact["operator_applications"][0]) < 30


@pytest.mark.parametrize(("rows", "seed", "relative"), [(16, 0, 0.3), (16, 3, 0.1), (32, 0, 0.3)])
def test_a_cell_much_longer_than_wide_takes_no_more_work_than_a_square_one(rows, seed, relative):
    """A spectrum down to the pixel, whose load the projection moves far along the cell."""
    waves = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.rfftfreq(4096))
    waves[0, 0] = np.inf
    noise = np.random.default_rng(seed).standard_normal((rows, 4096))
    window = height_map(np.fft.irfft2(waves**-1.8 * np.fft.rfft2(noise), s=noise.shape), 1.0)
    loads = plan_loads(window, contact_modulus=1.0, relative_pressure=relative)
    contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=loads, fields=False)
    assert float(contact["operator_applications"][0]) <= 14


AWKWARD = {
    "prime sides": self_affine((61, 53), 1.0, (6.0, 50.0), rms_gradient=0.1, seed=1).values,
    "two rows": self_affine((2, 256), 1.0, (6.0, 200.0), rms_gradient=0.1, seed=1).values,
    "white noise": np.random.default_rng(0).standard_normal((64, 64)),
    "plateaus": np.round(np.random.default_rng(0).standard_normal((64, 64))),
    "checkerboard": np.indices((64, 64)).sum(axis=0) % 2.0,
    "one spike": np.where(np.arange(64 * 64) == 700, 1.0, 0.0).reshape(64, 64),
    "one pit": np.where(np.arange(64 * 64) == 700, -1.0, 0.0).reshape(64, 64),
}


@pytest.mark.parametrize("name", AWKWARD)
@pytest.mark.parametrize("share_of_full_contact", [1e-4, 0.1, 0.999, 1.0, 10.0])
def test_awkward_maps_simply_work(name, share_of_full_contact):
    heights = AWKWARD[name]
    threshold = -full_contact_fluctuation(heights, (1.0, 1.0), 1.0).min()
    contact = rc.solve_contact(
        height_map(heights, 1.0),
        contact_modulus=1.0,
        mean_pressure=share_of_full_contact * threshold,
        tolerance=1e-8,
    )
    touching = contact["contact"].values > 0
    if share_of_full_contact != 1.0:  # there the last digit decides
        assert touching.all() == (share_of_full_contact > 1)
    assert touching.any()
    assert float(contact["error_bound"][0]) <= 1e-8


@pytest.fixture(params=["array_api_strict", "unnamed", "cupy", "torch", "torch on a GPU"])
def arrays(request, monkeypatch):
    """The function that brings an array of NumPy into another library.

    array_api_strict has nothing but what the Python array API promises; without the name of its library in
    its arrays it is as CuPy and PyTorch are, known to array-api-compat alone. CuPy needs a GPU.
    """
    unnamed, on_gpu = request.param == "unnamed", request.param in ("cupy", "torch on a GPU")
    library = pytest.importorskip("array_api_strict" if unnamed else request.param.split()[0])
    if on_gpu and not library.cuda.is_available():
        pytest.skip("no GPU")
    if unnamed:
        kind = type(library.asarray(0.0))
        original = array_api_compat.array_namespace
        monkeypatch.delattr(kind, "__array_namespace__")
        monkeypatch.setattr(
            array_api_compat,
            "array_namespace",
            lambda field: library if isinstance(field, kind) else original(field),
        )
    return partial(library.asarray, device="cuda") if "GPU" in request.param else library.asarray


POLYMER = {"youngs_modulus": 4e9, "poissons_ratio": 0.3}
FILM = {"thickness": 5e-6, "youngs_modulus": 1.2e10, "poissons_ratio": 0.2}
ELASTICITY = {
    "half-space": {"contact_modulus": MODULUS},
    "layers": {"bodies": [POLYMER | {"layers": [FILM]}, POLYMER]},
}


@pytest.mark.parametrize("elasticity", list(ELASTICITY.values()), ids=list(ELASTICITY))
@pytest.mark.parametrize(
    ("mean_pressure", "limit"), [([2e6, 8e7], 3e8), (4e9, 4.05e9)], ids=["two loads", "full contact"]
)
@pytest.mark.parametrize("hard", [False, True], ids=["elastic", "hardness"])
def test_the_solve_runs_in_the_library_of_the_arrays(mean_pressure, limit, hard, elasticity, arrays):
    window, hardness = rough(), limit if hard else None
    options = {"mean_pressure": mean_pressure, "hardness": hardness, "tolerance": 1e-8} | elasticity
    actual, expected = (
        rc.solve_contact(window, arrays=library_arrays, **options) for library_arrays in (arrays, None)
    )
    assert isinstance(actual["pressure"].data, np.ndarray)
    assert set(actual.variables) == set(expected.variables)
    size = np.sqrt((expected["pressure"] ** 2).mean())
    assert np.sqrt(((actual["pressure"] - expected["pressure"]) ** 2).mean()) < 1e-7 * size
    assert float(actual["error_bound"].max()) <= 1e-8
    np.testing.assert_array_equal(actual["operator_applications"], expected["operator_applications"])
    assert (expected["yielded_area"].max() > 0) == hard


def test_heights_of_another_library_are_solved_by_it():
    library = pytest.importorskip("array_api_strict")
    window = rough()
    elsewhere = window.copy(data=library.asarray(window.values))
    options = {"contact_modulus": MODULUS, "mean_pressure": 8e7, "tolerance": 1e-8}
    actual, expected = (rc.solve_contact(heights, **options) for heights in (elsewhere, window))
    assert isinstance(actual["pressure"].data, np.ndarray)
    size = np.sqrt((expected["pressure"] ** 2).mean())
    assert np.sqrt(((actual["pressure"] - expected["pressure"]) ** 2).mean()) < 1e-7 * size


def test_a_large_map_without_its_workspace_between_the_loads_has_the_same_solutions(monkeypatch):
    height, loads = synthetic.rough_reference_surface(128), [0.01, 0.05, 2.0]  # the last one closes the gap
    reference = rc.solve_contact(height, contact_modulus=1.0, mean_pressure=loads)
    monkeypatch.setattr("roughcontact.contact.sweep.MAX_KEPT_POINTS", 0)
    xr.testing.assert_identical(rc.solve_contact(height, contact_modulus=1.0, mean_pressure=loads), reference)


@pytest.mark.parametrize("kind", ["u1", "i1", "u2", "i2"])
def test_whole_numbers_of_a_narrow_type_have_the_statistics_of_doubles(kind):
    """Differences of small integers wrap around."""
    rough = synthetic.rough_reference_surface(40).values
    limits = np.iinfo(kind)
    heights = np.interp(rough, [rough.min(), rough.max()], [limits.min + 1, limits.max]).round()
    of_whole, of_double = (
        rc.contact_statistics(
            rc.solve_contact(
                height_map(np.zeros(heights.shape), 1e3, unit="m").copy(data=heights.astype(dtype)),
                contact_modulus=1e9,
                mean_pressure=1e8,
            )
        )
        for dtype in (kind, float)
    )
    xr.testing.assert_identical(of_whole, of_double)
