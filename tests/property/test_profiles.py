"""A profile that is sampled more finely keeps its numbers: none depends on how wide a row counts."""

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.arguments.maps import height_map, refined
from roughcontact.statistics.checks import add_verdicts
from roughcontact.statistics.contact_statistics import statistics_function, with_uncertainty
from roughcontact.statistics.subsurface import add_subsurface_yield
from roughcontact.statistics.targets import add_first_yield
from roughcontact.surface.synthetic import self_affine_surface

MODULUS, GRADIENT, PITCH, POINTS = 1.2e11, 0.1, 1e-6, 2048
BODY = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "yield_stress": 2e9}
CONDUCTING = {"thermal_conductivity": 50.0, "electrical_resistivity": 2e-7}
SEAL = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 0.01}

# what changes in proportion to the points
FACTORS = {"points_per_shortest_wavelength": 2.0}
# what tells of the solver, and of the rounding that it is left with
SOLVER = {
    "iterations",
    "operator_applications",
    "error_bound",
    "conductance_error_bound",
    "rounding_floor",
    "max_penetration",
    "load_error",
}
# from half a point below the surface on: compared where both are known
OF_DEPTH = {"depth", "von_mises_profile"}
NONE = {
    "contact_perimeter",
    "largest_patch_area",
    "patch_area_density",
    "patch_bin_centre",
    "patch_bin_bounds",
}
# of the error budget, sources that ask how fine the grid and how accurate the solver is
OF_THE_GRID = ["solver", "discretisation", "unresolved", "combined"]
BY_SOURCE = ("_sensitivity", "_uncertainty", "_components")


def statistics(heights, pitch, *, along, hardness):
    """Return all that a run writes into statistics.nc, from measured heights (points,)."""
    measured = height_map(heights[:, None] if along == "y" else heights[None, :], pitch)
    levelled = rc.level(measured, form="plane")
    window = rc.periodic_window(levelled)
    unit, bodies = MODULUS * GRADIENT, [BODY | CONDUCTING] * 2
    problem = {"contact_modulus": MODULUS, "mean_pressure": [0.02 * unit, 0.1 * unit], "tolerance": 1e-6}
    problem["hardness"] = None if hardness is None else hardness * unit
    extra = {"seal": SEAL, "work_of_adhesion": 0.05, "flow": "always", "stress": "always", "bodies": bodies}
    count = statistics_function(window, contact_modulus=MODULUS, **extra)
    settings = {"level": {"form": "plane"}, "window": {}, "contact": problem}
    solved = add_first_yield(
        rc.solve_contact(window, **problem, reduce=count), window, problem | {"bodies": bodies}
    )
    complete = with_uncertainty(solved, rc.error_budget(levelled, window, settings))
    return add_verdicts(add_subsurface_yield(complete, bodies), window)


def shares(numbers, name):
    """Return the shares up to the end of each bin of a density, of all loads."""
    bounds = numbers[f"{name.removesuffix('_density')}_bin_bounds"]
    return (numbers[name] * bounds.diff("bounds").isel(bounds=0)).cumsum(numbers[name].dims[-1]).values


def limit_of(name):
    """Return how far a number may be off that converges with the points; its interval comes of few parts."""
    return 0.15 if name.endswith(BY_SOURCE) else 0.06


@pytest.mark.slow
@pytest.mark.parametrize("along", ["x", "y"])
@pytest.mark.parametrize("hardness", [None, 0.5])
@pytest.mark.parametrize("seed", [1, 3])
def test_a_profile_that_is_sampled_more_finely_keeps_its_numbers(seed, hardness, along):
    waves = {"shortest": 64 * PITCH, "longest": POINTS / 4 * PITCH, "rms_gradient": GRADIENT}
    profile = self_affine_surface((1, POINTS), PITCH, hurst=0.8, seed=seed, **waves)
    coarse, fine = (
        statistics(map_.values[0], pitch, along=along, hardness=hardness)
        for map_, pitch in ((profile, PITCH), (refined(profile, 2), PITCH / 2))
    )
    across = "x" if along == "y" else "y"
    none = NONE | {f"window_length_{across}", f"max_von_mises_{across}"}
    assert set(coarse.variables) == set(fine.variables)
    assert {*FACTORS, *SOLVER, *OF_DEPTH, *none} <= set(coarse.variables)
    deviations = {}
    for name in map(str, coarse.variables):
        coarse_values, fine_values = coarse[name], fine[name]
        if coarse_values.dtype.kind in "OU":
            np.testing.assert_array_equal(coarse_values, fine_values, err_msg=name)
        elif name in none:
            assert all(result.isnull().all() for result in (coarse_values, fine_values)), name
        elif name == "von_mises_profile":
            depth = coarse["depth"].values[1:-1]
            coarse_values, fine_values = (
                np.array([np.interp(depth, result["depth"], row) for row in result[name].values])
                for result in (coarse, fine)
            )
            deviations[name] = float(np.abs(fine_values - coarse_values).max() / coarse_values.max())
        elif name in SOLVER | OF_DEPTH or "cutoff" in coarse_values.dims or name.endswith("_parts"):
            # in pixels, not in lengths; subwindows are solved coarsely
            continue
        elif name.endswith("_density"):
            deviations[name] = float(np.nanmax(np.abs(shares(fine, name) - shares(coarse, name))))
        else:
            if "source" in coarse_values.dims:
                coarse_values, fine_values = (
                    variable.drop_sel(source=OF_THE_GRID) for variable in (coarse_values, fine_values)
                )
            expected = coarse_values * FACTORS.get(name, 1.0)
            np.testing.assert_array_equal(np.isfinite(coarse_values), np.isfinite(fine_values), err_msg=name)
            scale = xr.where(expected == 0, 1.0, np.abs(expected))
            deviations[name] = float(
                (np.abs(fine_values - expected) / scale).where(np.isfinite(expected), 0.0).max()
            )
    # a wrong width would show as a half or as twice, its root as 0.3 or 0.4
    too_far = {name: value for name, value in deviations.items() if not value <= limit_of(name)}
    assert not too_far
