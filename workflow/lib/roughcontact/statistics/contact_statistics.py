"""Numbers of each load of a contact solution: areas, clusters, pressures, gaps, energy, stiffness, theory."""

from collections.abc import Callable, Hashable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, CONDUCTANCE, ENDS, GAP, OPPOSITE_ENDS, PEAK
from roughcontact.arguments.bodies import check_bodies
from roughcontact.arguments.checking import check_keys, check_solution, warn_of_map
from roughcontact.arguments.choices import Extra
from roughcontact.arguments.finite_body import recover_roughness
from roughcontact.arguments.kinds import FINITE_BODY, KindFacts, facts_of
from roughcontact.arguments.maps import areal_only, spacing
from roughcontact.arguments.named_materials import named_bodies
from roughcontact.arguments.settings.needs import check_needs
from roughcontact.arguments.si import as_si
from roughcontact.arguments.stacks import properties_of_bodies, top_material
from roughcontact.arguments.variables import describe
from roughcontact.contact.dataset import carrying, joined, recorded_elasticity, recorded_medium
from roughcontact.contact.elasticity.energy import elastic_energy
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.media import elastic_medium
from roughcontact.contact.response import linear_response
from roughcontact.errors import SettingsError
from roughcontact.kernels.waves import wave_power
from roughcontact.statistics import conductance, densities, subsurface, theory
from roughcontact.statistics.adhesion import adhesion_numbers
from roughcontact.statistics.contact_geometry import contact_perimeter, point_area, relative_contact_area
from roughcontact.statistics.decisions import TIGHT, gap_is_closed, is_lifted
from roughcontact.statistics.finite_body import finite_body_columns
from roughcontact.statistics.friction import friction_statistics
from roughcontact.statistics.precision import widened
from roughcontact.statistics.sealing.connectivity import region_sizes
from roughcontact.statistics.sealing.gas import path_at_mean_pressure, slip_factor
from roughcontact.statistics.sealing.percolation import percolation_columns
from roughcontact.surface.roughness.heights import HEIGHT_PARAMETERS, renew_parameters
from roughcontact.surface.roughness.parameters import roughness_parameters
from roughcontact.surface.roughness.summits import summit_statistics
from roughcontact.surface.roughness.texture import texture_parameters

# variables of the solver, copied for each load
SOLVER_COLUMNS = (
    *("approach", "iterations", "operator_applications", "error_bound", "rounding_floor", "yielded_area"),
    *("max_penetration", "load_error", "converged"),
)
# variables of contact.nc without maps
SOLUTION_COLUMNS = (*SOLVER_COLUMNS, "relative_pressure", "contact_modulus")

# tolerance of the response to further loading: its error is about that, of an elastic one its square
_OF_LOADING = 1e-3

# kind of problem -> its numbers of a load that others do not have, or have in another way
_OF_KINDS = {FINITE_BODY.name: finite_body_columns}

_AS_SOLVED = "_as_solved"  # ends the names of quantities that the budget corrects
_FLASH_TEMPERATURES = ("mean_flash_temperature", "max_flash_temperature")
_FURTHER_DIM = {  # of variables, beside the load
    "pressure_density": ("pressure_bin",),
    "gap_density": ("gap_bin",),
    "patch_area_density": ("patch_bin",),
    **{f"{quantity}_share_above_ratio": ("hardness_over_modulus",) for quantity in ("load", "area")},
    **{f"material_von_mises_{quantity}": ("material",) for quantity in ("stress", "depth")},
    **{f"interface_{component}_stress": ("interface",) for component in ("shear", "normal")},
    "von_mises_profile": ("depth",),
}


@as_si
def contact_statistics(
    contact: xr.Dataset,
    *,
    pressure_bins: int = 20,
    gap_bins: int = 20,
    flow: Extra = "auto",
    stress: Extra = "auto",
    work_of_adhesion: float | None = None,
    seal: Mapping[str, float] | None = None,
    joint: Mapping[str, float | None] | None = None,
    friction: Mapping[str, Any] | None = None,
    allowed_pressure: float | None = None,
    requirement: Mapping[str, float] | None = None,
    bodies: conductance.Bodies | None = None,
    surface: "SurfaceNumbers | None" = None,
) -> xr.Dataset:
    """Return the statistics of each load of a contact solution.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it: `pressure` (load, y, x) Pa, `gap` (load, y, x) m, `height` (y, x) m
        with the optional coordinate `filled`, `contact_modulus` Pa, `hardness` Pa where the pressure was
        limited to one, coordinate `mean_pressure` (load) Pa. Of an open file (`opened_dataset`) the maps of
        one load at a time are read, and no heights where `surface` is given.
    pressure_bins, gap_bins : int
        bins per factor of ten. Pressures: [0, 1e-3], then logarithmic to 1e3, in units of E* g. Gaps: [0,
        1e-4], then logarithmic to 1, in units of the peak-to-valley height. The bounds depend on the
        surface and on E* alone, never on the loads; a value above the last bound is counted in the last
        bin, so nothing is lost.
    flow : {"auto", "always", "never"}
        whether the flow of a fluid through the gap is solved for, which takes longer than the contact:
        ``auto`` where a seal is given.
    stress : {"auto", "always", "never"}
        whether the stresses below the surface are computed, of the body with the lowest yield stress (else
        the one with layers, else the softer): ``auto`` where a body or a layer states its `yield_stress`.
    work_of_adhesion : float, J/m2, optional
        of flat surfaces: the effective work of adhesion is added.
    seal : mapping, optional
        `viscosity` (Pa s), `pressure_difference` (Pa) and `width` (m) of a seal that leaks through the gap,
        of a gas `outlet_pressure` (Pa) and `mean_free_path` (m).
    joint : mapping, optional
        `gas_conductivity` (W m-1 K-1) and `temperature_jump` (m) of the gas in the gap, and `film_thickness`
        (m) and `film_conductivity` (W m-1 K-1) of a film on the spots: heat through the joint.
    friction : mapping, optional
        as in the settings, `statistics.friction`.
    allowed_pressure, requirement : float, Pa; mapping; optional
        as areas, perimeters and other allowed values of seal and joint: for `evaluate` (`with_allowed`,
        `with_largest_roughness`).
    bodies : sequence of two mappings, optional
        as in the settings, `contact.bodies`: where both state conductivity or resistivity, the conductance of
        the contact is added; `poissons_ratio`, `yield_stress` and `layers` are for the stresses.
    surface : SurfaceNumbers, optional
        of the map, from `surface_numbers`, where they are known already: else they are computed.

    Returns
    -------
    Dataset
        dims (load, pressure_bin, gap_bin, patch_bin), SI units; `arguments.variables` explains each name.
        Perimeter and areas of patches are NaN for a single row or column, which has no width.

    Raises
    ------
    SettingsError
        where a number of bins is no whole number of at least 1, or stresses are asked for without bodies; for
        anything else than a solution with its maps.

    Warns
    -----
    HeightMapWarning
        as `solve_contact`, where the numbers of the surface are computed here.

    Examples
    --------
    A wave under 30 % of the load that flattens it touches over (2/π) asin √0.3 = 0.369 of its length.

    >>> import numpy as np
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.arguments.maps import height_map
    >>> wave = height_map(0.01 * np.cos(2 * np.pi * np.arange(512) / 512)[None, :], 1 / 512)
    >>> contact = solve_contact(wave, contact_modulus=1.0, mean_pressure=0.3 * np.pi * 0.01)
    >>> statistics = contact_statistics(contact)
    >>> f"{statistics['relative_contact_area'].item():.3f}, {statistics['contact_clusters'].item()} patch"
    '0.369, 1 patch'
    """
    for name, bins in {"pressure_bins": pressure_bins, "gap_bins": gap_bins}.items():
        if int(bins) != bins or bins < 1:
            raise SettingsError(
                f"{name} = {bins!r} is no number of bins per factor of ten; give 1, 2, 3, ..."
            )
    check_solution(contact)
    check_keys("friction", friction, friction_statistics)
    check_needs("friction", friction)
    bodies = bodies and named_bodies(bodies)
    kind, medium = facts_of(contact.attrs), recorded_medium(contact.attrs)
    body = _body_to_strain(stress, bodies, kind)
    height, modulus = contact["height"], float(contact["contact_modulus"])
    steps = spacing(height)
    if surface is None:
        surface = surface_numbers(height, Elasticity(modulus, medium=medium), work_of_adhesion)
        warn_of_map(height.shape, surface.parameters["rms_gradient"])
    parameters = dict(surface.parameters)
    # a flat map has neither gradient nor heights to set the scale of the bins
    edges = {
        "pressure": (modulus * parameters["rms_gradient"] or modulus)
        * densities.logarithmic_edges(densities.PRESSURE_DECADES, pressure_bins),
        "gap": (surface.peak_to_valley or steps[1])
        * densities.logarithmic_edges(densities.GAP_DECADES, gap_bins),
        "patch": point_area(height.shape, steps)
        * densities.logarithmic_edges(densities.PATCH_DECADES, densities.PATCH_BINS),
    }
    # a solution of its own: unasked only where there is a seal
    with_flow = kind.has_flow and (flow == "always" or (flow == "auto" and seal is not None))
    conducting = conductance.conductors(bodies, recorded_elasticity(contact))
    gas = conductance.gas_arguments(joint)
    rows = [
        _one_load(contact, load, edges, with_flow=with_flow, body=body, conducting=conducting, gas=gas)
        for load in range(contact.sizes["load"])
    ]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    columns |= {name: contact[name].values for name in SOLVER_COLUMNS if name in contact}
    # layers conduct in another way than they yield, which is solved by itself
    stiffness = columns["contact_stiffness"] * (1.0 if medium.is_homogeneous else np.nan)
    columns |= conductance.conductance_columns(stiffness, contact_modulus=modulus, bodies=bodies)
    columns |= conductance.resistances_and_joint(columns, joint)
    if seal is not None and with_flow:
        leaks, numbers_of_seal = leaks_of_seal(columns, seal)
        columns |= leaks
        parameters |= numbers_of_seal
    columns |= _theory_columns(contact, surface)
    # a number of the map, repeated for each load beside the other measures of reliability
    name = "points_per_shortest_wavelength"
    columns[name] = np.full(contact.sizes["load"], parameters.pop(name))
    # a finite body has both: its force, and that over the area of the map
    loads = [name for name in ("mean_pressure", "force") if name in contact]
    coordinates = _bins(edges) | {name: ("load", contact[name].values) for name in loads}
    attrs = contact.attrs | {
        f"{section}_{key}": value
        for section, of_section in (("seal", seal), ("joint", joint))
        for key, value in (of_section or {}).items()
        if value is not None
    }
    if body is not None:
        coordinates |= subsurface.depth_coordinates(height.shape, steps, body)
        for axis in ("x", "y"):  # a profile has no position across it
            columns[f"max_von_mises_{axis}"] += height[axis].values[0] if height[axis].size > 1 else np.nan
        attrs["stresses_of"] = subsurface.strained_body_in_words(bodies or ())
    if "hardness" not in contact:
        coordinates["hardness_over_modulus"] = ("hardness_over_modulus", densities.HARDNESS_OVER_MODULUS)
    variables = {name: (("load", *_FURTHER_DIM.get(name, ())), values) for name, values in columns.items()}
    material = {name: float(contact[name]) for name in ("contact_modulus", "hardness") if name in contact}
    for name, values in conductance.conductivity_ranges(bodies).items():
        material |= {f"{name}{end}": value for end, value in zip(ENDS, values, strict=True)}
    statistics = xr.Dataset(variables | parameters | material, coordinates, attrs)
    if friction is not None:
        frictions = [
            friction_statistics(contact.isel(load=[load]), area, bodies, **friction)
            for load, area in enumerate(columns["relative_contact_area"])
        ]
        if frictions[0].variables:  # a coefficient alone adds nothing
            statistics = statistics.merge(joined(frictions)).assign_attrs(frictions[0].attrs)
    return describe(statistics)


def leaks_of_seal(
    columns: Mapping[str, np.ndarray], seal: Mapping[str, Any]
) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Return the leak rates of the loads (m2/s), and of the seal what does not depend on the load.

    That is the pressure of the fluid, and the leak rate of smooth plates over their gap cubed, without slip.

    Parameters
    ----------
    columns : mapping
        `mean_gap` (m), flow factors and critical constrictions of the loads.
    seal : mapping
        as for `contact_statistics`.

    Returns
    -------
    leaks : dict
        `leak_rate_x`, `leak_rate_y` (load), m2/s.
    numbers : dict
        `fluid_pressure` (Pa), `leak_rate_by_cube` (1/(m s)).
    """
    from roughcontact.statistics.sealing.flow import leak_columns

    fluid = {key: value for key, value in seal.items() if key not in ("perimeter", "allowed_leak")}
    check_keys("seal", fluid, leak_columns)
    plates = {"flow_factor_xx": 1.0, "flow_factor_yy": 1.0}
    by_cube = float(leak_columns(1.0, plates, **fluid | {"mean_free_path": None})["leak_rate_x"])
    numbers = {"fluid_pressure": float(seal["pressure_difference"]), "leak_rate_by_cube": by_cube}
    return leak_columns(columns["mean_gap"], columns, **fluid), numbers


# variable -> the quantity and its power that it goes with, where the budget corrects that
_PROPORTIONAL = {
    **dict.fromkeys(("contact_stiffness", "thermal_conductance", "electrical_conductance"), (CONDUCTANCE, 1)),
    **dict.fromkeys(("thermal_resistance", "electrical_resistance"), (CONDUCTANCE, -1)),
    **dict.fromkeys(("friction_coefficient", *_FLASH_TEMPERATURES, "contact_area"), (AREA, 1)),
    "contact_radius": (AREA, 0.5),
}


def with_uncertainty(statistics: xr.Dataset, budget: xr.Dataset) -> xr.Dataset:
    """Return the statistics with the error budget: half-widths by source, ends of the interval.

    The share of the load that rejected points would carry, `rejected_load_share`, is included.

    Parameters
    ----------
    statistics : Dataset
        from `contact_statistics`.
    budget : Dataset
        from `error_budget`, for the same loads; it may be empty. Its attributes `window_flag` and
        `window_reason` are kept. A quantity that it corrects (`{name}_as_solved`) takes the corrected value.

    Returns
    -------
    Dataset

    Raises
    ------
    SettingsError
        where the two are for different loads.

    Examples
    --------
    >>> import xarray as xr
    >>> loads = {"mean_pressure": ("load", [1e6])}
    >>> statistics = xr.Dataset({"mean_gap": ("load", [2e-7])}, coords=loads)
    >>> budget = xr.Dataset({"mean_gap_uncertainty": ("load", [1e-8])}, coords=loads)
    >>> sorted(with_uncertainty(statistics, budget).data_vars)
    ['mean_gap', 'mean_gap_uncertainty']
    """
    if not np.array_equal(statistics["mean_pressure"].values, budget["mean_pressure"].values):
        raise SettingsError("the error budget is for other loads than the statistics; compute both again")
    attrs = {key: text for key, text in budget.attrs.items() if key.startswith(("window_", "overview_"))}
    corrected = [name.removesuffix(_AS_SOLVED) for name in map(str, budget) if name.endswith(_AS_SOLVED)]
    estimates = {name: budget[f"{name}_estimate"].variable for name in corrected}
    complete = statistics.assign(estimates).merge(budget, compat="override", join="override")
    complete = complete.assign_attrs(attrs)
    # by an overview; what is the same number in another unit follows
    ratios = {name: complete[name] / complete[f"{name}{_AS_SOLVED}"] for name in corrected}
    # flash temperatures may be by a coefficient of friction that follows the area
    constant = () if "flash_temperature_by" in complete.attrs else _FLASH_TEMPERATURES
    following = {
        name: complete[name] * ratios[quantity] ** power
        for name, (quantity, power) in _PROPORTIONAL.items()
        if name in complete and quantity in ratios and name not in constant
    }
    if PEAK in ratios and "max_pressure_over_modulus" in complete:
        following["max_pressure_over_modulus"] = complete[PEAK] / complete["contact_modulus"]
    complete = complete.assign(following)
    # after the corrections, which the ends in other units follow
    bounds = _ends_in_other_units(complete) | _ends_of_the_leak(complete)
    if "joint_conductance" in complete:
        bounds |= _joint(complete.assign(bounds), ratios)
    return complete.assign(bounds)


def _joint(statistics: xr.Dataset, ratios: Mapping[str, xr.DataArray]) -> dict[str, xr.DataArray]:
    """Return the conductance of a joint with its ends: those of spots, film and gas together.

    They share their causes: more contact has a smaller gap. The gas conducts as 1/(ū + M) at the most, the
    film as the contact area. `ratios` are what the corrections of quantities have multiplied.
    """
    spots, gas = statistics["thermal_resistance"], statistics["gas_conductance"]
    jump = statistics.attrs.get("joint_temperature_jump", 0.0)
    with np.errstate(divide="ignore"):  # full contact without a film
        spots_as_solved = spots * ratios.get(CONDUCTANCE, 1.0)
        film = (1 / (statistics["joint_conductance"] - gas) - spots_as_solved) / ratios.get(AREA, 1.0)
        if "mean_gap_alone" in statistics:  # the gap that an overview shows holds other gas
            gas = gas * (statistics["mean_gap_alone"] + jump) / (statistics[GAP] + jump)
        results = {"gas_conductance": gas, "joint_conductance": 1 / (spots + film) + gas}
        for suffix in ENDS[1:]:
            opposite = OPPOSITE_ENDS[suffix]
            names = f"{AREA}{suffix}", f"{GAP}{opposite}", f"thermal_resistance{opposite}"
            if {*names} <= {*statistics}:
                area, gap, spots_at_end = (statistics[name] for name in names)
                of_spots = 1 / (spots_at_end + film * statistics[AREA] / area)
                of_gas = gas * (statistics[GAP] + jump) / (gap + jump)
                # of spots or gas without a lower end none at the least; nothing bounds two smooth faces
                if suffix == "_lower":
                    of_spots, of_gas = of_spots.fillna(0.0), of_gas.fillna(0.0)
                together = of_spots + of_gas
                results[f"joint_conductance{suffix}"] = together.where(np.isfinite(together))
    return results


def _factors(statistics: xr.Dataset, name: str) -> tuple[xr.DataArray | float, xr.DataArray | float]:
    """Return the ends of a property over its value; 1 where it has no range."""
    if f"{name}_lower" not in statistics:
        return 1.0, 1.0
    return statistics[f"{name}_lower"] / statistics[name], statistics[f"{name}_upper"] / statistics[name]


def _ends_in_other_units(statistics: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return the ends of sizes, of area or K/E* times a property of the bodies, and of resistances."""
    lowest, most = _factors(statistics, "electrical_resistivity")
    factors_of_properties = {
        "thermal_conductance": _factors(statistics, "thermal_conductivity"),
        "electrical_conductance": (1 / most, 1 / lowest),
        "friction_coefficient": _factors(statistics, "shear_strength"),
        **dict.fromkeys(("contact_area", "contact_radius"), (1.0, 1.0)),  # of a finite body
    }
    bounds: dict[str, xr.DataArray] = {}
    for name, factors in factors_of_properties.items():
        base, power = _PROPORTIONAL[name]
        if not {name, f"{base}_lower"} <= {*statistics} or statistics[base].isnull().all():
            continue
        # the same factor at value and ends
        ratios = (statistics[f"{base}{suffix}"] / statistics[base] for suffix in ENDS[1:])
        ends = (statistics[name] * ratio**power for ratio in ratios)
        lower, upper = widened((statistics[name], *ends), factors)
        bounds |= {f"{name}_lower": lower, f"{name}_upper": upper}
        if base == CONDUCTANCE:
            resistance = name.replace("conductance", "resistance")
            # a conductance without an upper end leaves a resistance down to none
            bounds[f"{resistance}_lower"] = (1 / upper).fillna(0.0).where(lower.notnull())
            bounds[f"{resistance}_upper"] = (1 / lower).where(lower > 0)
    return bounds


def _ends_of_the_leak(statistics: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return the ends of the intervals of the leak rates, which go as the cube of the narrowest place.

    One place carries most of the pressure drop (Persson and Yang 2008). For a closed gap the upper end is
    that of plates at the upper end of the narrowest place, `TIGHT` at most where it is decided that it is
    closed; nothing bounds what leaks where the fluid lifts the bodies.
    """
    bounds: dict[str, xr.DataArray] = {}
    path = path_at_mean_pressure(statistics.attrs)
    for axis in "xy":
        name, narrowest = f"leak_rate_{axis}", f"critical_constriction_{axis}"
        if name in statistics and f"{narrowest}_lower" in statistics:
            leak, height, of_plates = (statistics[key] for key in (name, narrowest, "leak_rate_by_cube"))
            # where it is closed there is no leak to scale from: that of smooth plates
            by_cube = (leak / height**3 / slip_factor(height, path)).where(height > 0, of_plates)
            for suffix in ENDS[1:]:
                opening = statistics[f"{narrowest}{suffix}"]
                bounds[f"{name}{suffix}"] = by_cube * opening**3 * slip_factor(opening, path)
            upper = bounds[f"{name}_upper"].where(~is_lifted(statistics))
            # closed for certain, it leaks no more than what counts as nothing
            is_bound = (gap_is_closed(statistics, axis) != 1) | (upper <= TIGHT)
            bounds[f"{name}_upper"] = upper.where(is_bound, leak.clip(min=TIGHT))
    return bounds


class SurfaceNumbers(NamedTuple):
    """Numbers of a map that do not depend on the load.

    Attributes
    ----------
    parameters : dict
        those of `surface_statistics`, and of `adhesion_numbers`.
    summits : dict
        those of `summit_statistics`.
    peak_to_valley : float, m
        from the lowest to the highest point.
    """

    parameters: dict[str, float]
    summits: dict[str, float]
    peak_to_valley: float


def surface_numbers(
    height: xr.DataArray, elasticity: Elasticity, work_of_adhesion: float | None = None
) -> SurfaceNumbers:
    """Return the numbers of a map that the statistics of all its loads share.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.
    elasticity : Elasticity
        E*, that of the surfaces of the bodies, and their medium.
    work_of_adhesion : float, J/m2, optional
        of flat surfaces.

    Returns
    -------
    SurfaceNumbers

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> found = surface_numbers(rough_reference_surface(64), Elasticity(1.0))
    >>> sorted(found.summits), "conforming_energy" in found.parameters
    (['density', 'height_std', 'mean_height', 'mean_radius'], True)
    """
    # of a finite body the roughness alone is described, not its form
    roughness = recover_roughness(height)
    power = wave_power(roughness.values)
    parameters = surface_statistics(roughness, power)
    parameters |= adhesion_numbers(roughness, elasticity, work_of_adhesion=work_of_adhesion, power=power)
    del power
    return SurfaceNumbers(parameters, summit_statistics(roughness), float(np.ptp(height.values)))


def statistics_function(
    height: xr.DataArray, *, contact_modulus: float, **settings: Any
) -> Callable[[xr.Dataset], xr.Dataset]:
    """Return `contact_statistics` for solutions of one map, whose own numbers are computed once.

    Parameters
    ----------
    height : DataArray (y, x), m
        the map that is solved.
    contact_modulus : float, Pa
        E*.
    **settings
        keyword arguments of `contact_statistics`.

    Returns
    -------
    callable
        to be given to `solve_contact` as `reduce`.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> count = statistics_function(height, contact_modulus=1.0, flow="never")
    >>> found = solve_contact(height, contact_modulus=1.0, mean_pressure=[0.1, 0.2], reduce=count)
    >>> found["rms_gradient"].dims, found["mean_gap"].dims
    ((), ('load',))
    """
    # named once for all loads, and for the medium below
    if settings.get("bodies"):
        settings["bodies"] = named_bodies(settings["bodies"])
    elasticity = Elasticity(contact_modulus, medium=elastic_medium(settings.get("bodies")))
    surface = surface_numbers(height, elasticity, settings.get("work_of_adhesion"))
    return partial(contact_statistics, surface=surface, **settings)


def surface_statistics(height: xr.DataArray, power: np.ndarray | None = None) -> dict[str, float]:
    """Return the numbers of the solved window: roughness, texture, height parameters, size and position.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic; its attributes say where the window lies, and hold the height parameters of the levelled
        map. Those of other heights, as after arithmetic, are not taken: they are then those of the window.
    power : array (ny, nx // 2 + 1), m2, optional
        of its waves (`roughcontact.kernels.waves.wave_power`), where that is known already.

    Returns
    -------
    dict
        name -> number in SI units (`Std`: degree), as `arguments.variables` explains it. Roughness
        parameters are spectral. NaN for the length of the window across a single row or column.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> wave = height_map(1e-6 * np.cos(2 * np.pi * np.arange(64) / 64)[None, :], 1e-6)
    >>> found = surface_statistics(wave)
    >>> f"{found['rms_height']:.3g} m in {found['window_length_x']:.3g} m"
    '7.07e-07 m in 6.4e-05 m'
    """
    (ny, nx), (dy, dx) = height.shape, spacing(height)
    power = wave_power(height.values) if power is None else power
    attrs = renew_parameters(height).attrs
    parameters = {name: float(attrs[name]) for name in (*HEIGHT_PARAMETERS, "row_jitter") if name in attrs}
    parameters |= roughness_parameters(height, power) | texture_parameters(height, power)
    return parameters | {
        # a profile has no width
        "window_length_x": nx * dx if nx > 1 else np.nan,
        "window_length_y": ny * dy if ny > 1 else np.nan,
        **{name: float(height.attrs.get(name, 0.0)) for name in ("window_offset_x", "window_offset_y")},
    }


def _theory_columns(contact: xr.Dataset, surface: SurfaceNumbers) -> dict[str, np.ndarray]:
    """Return the relative pressure p' = p̄/(E* g) of each load, and the contact area of each theory at it.

    NaN where a theory does not apply: all to others than endless half-spaces, those of asperities to a single
    row or column, which has ridges and no summits, and where they exceed full contact. p' is infinite for a
    flat map.
    """
    kind, pressure = facts_of(contact.attrs), np.asarray(contact["mean_pressure"].values, float)
    modulus, asperities = float(contact["contact_modulus"]), areal_only(contact["height"].shape)
    with np.errstate(divide="ignore"):  # of a flat map
        relative = pressure / np.float64(modulus * surface.parameters["rms_gradient"])
    areas = {
        "area_persson": theory.persson_area(relative),
        "area_xu": theory.xu_area(relative),
        "area_bush_gibson_thomas": asperities * theory.bush_gibson_thomas_area(relative),
        "area_greenwood_williamson": theory.greenwood_williamson_area(
            pressure, surface.summits, contact_modulus=modulus
        ),
    }
    if not (kind.has_theories and recorded_medium(contact.attrs).is_homogeneous):
        areas = {name: np.full(pressure.shape, np.nan) for name in areas}
    # that of the solution, whose gradient is summed in another order
    of_solution = {name: contact[name].values for name in kind.scaled_columns if name in contact}
    return {"relative_pressure": relative} | areas | of_solution


def _one_load(
    contact: xr.Dataset,
    load: int,
    edges: Mapping[str, np.ndarray],
    *,
    with_flow: bool,
    body: Mapping[str, Any] | None,
    conducting: Mapping[str, Elasticity],
    gas: Mapping[str, float] | None,
) -> dict[str, object]:
    """Return all numbers of one load; of an open file no more than one of its maps is in memory at a time."""
    height, border = contact["height"], facts_of(contact.attrs).border
    elasticity, steps = recorded_elasticity(contact), spacing(height)
    hardness = float(contact["hardness"]) if "hardness" in contact else None
    filled_points = height["filled"].values != 0 if "filled" in height.coords else np.False_
    pressure = contact["pressure"].isel(load=load).values
    touching = pressure > 0
    contact_pressures = pressure[touching]
    points = contact_pressures.size
    mean, largest, spread = contact_pressures.mean(), contact_pressures.max(), contact_pressures.std()
    of_map = {
        **({} if body is None else subsurface.stress_columns(pressure, steps, border=border, **body)),
        "elastic_energy": elastic_energy(pressure, steps, elasticity),
        "pressure_density": densities.density(contact_pressures, edges["pressure"]),
    }
    bearing = densities.bearing_numbers(
        contact_pressures, contact_modulus=elasticity.modulus, hardness=hardness
    )
    at_hardness = None if hardness is None else carrying(pressure, hardness)
    del pressure, contact_pressures  # before the gap is read: one map at a time
    gap = contact["gap"].isel(load=load).values
    gap_density = densities.density(gap[~touching], edges["gap"])
    # within the contact the gap is rounding: the solver keeps its mean there at zero
    open_gap = np.where(touching, 0.0, gap)
    del gap
    mean_gap = open_gap.mean()
    passage: dict[str, float] = percolation_columns(open_gap)
    if with_flow:  # imports sparse matrices, which takes as long as all other imports here
        from roughcontact.statistics.sealing.flow import flow_columns

        passage |= flow_columns(open_gap, steps)
    if gas is not None:
        passage |= conductance.gas_columns(open_gap, **gas)
    del open_gap
    # the contact of a body ends at its edges, that of a periodic map goes on beyond its seams
    area = np.pad(touching, border)
    patches = region_sizes(area) * point_area(touching.shape, steps)
    columns = {
        "relative_contact_area": relative_contact_area(touching, border=border),
        "relative_contact_area_pixels": points / touching.size,
        "contact_perimeter": contact_perimeter(area, steps),
        "contact_clusters": patches.size,
        "largest_patch_area": patches.max(initial=0.0),
        "contact_on_filled_points": np.count_nonzero(touching & filled_points) / points,
        "mean_contact_pressure": mean,
        "max_pressure": largest,
        "pressure_std": spread,
        "mean_gap": mean_gap,
        **_stiffness(touching, at_hardness, steps, elasticity),
        **{
            name: _inverse(linear_response(touching, steps, bodies)[0]) for name, bodies in conducting.items()
        },
        **passage,
        **of_map,
        "patch_area_density": densities.density(patches, edges["patch"]),
        "gap_density": gap_density,
        **bearing,
    }
    of_kind = _OF_KINDS.get(facts_of(contact.attrs).name)
    return columns | (of_kind(columns, contact, load) if of_kind else {})


def _stiffness(
    touching: np.ndarray, at_hardness: np.ndarray | None, steps: tuple[float, float], elasticity: Elasticity
) -> dict[str, float]:
    """Return the stiffness of a contact as an elastic one, and that of further loading where points yield."""
    # certified, because conductance is this number
    compliance, bound = linear_response(touching, steps, elasticity, certify=True)
    elastic = _inverse(compliance)
    columns = {"contact_stiffness": elastic, "conductance_error_bound": bound}
    if at_hardness is None:
        return columns
    if not at_hardness.any():
        loading = elastic
    elif (touching & ~at_hardness).any():
        compliance, _ = linear_response(touching, steps, elasticity, _OF_LOADING, yielding=at_hardness)
        loading = _inverse(compliance)
    else:  # further load is carried by points that do not touch yet
        loading = np.nan
    return columns | {"loading_stiffness": loading}


def _inverse(compliance: float) -> float:
    """Return the stiffness of a compliance, infinite in full contact."""
    return 1 / compliance if compliance > 0 else np.inf


def _body_to_strain(
    stress: Extra, bodies: conductance.Bodies | None, kind: KindFacts
) -> Mapping[str, Any] | None:
    """Return the body whose stresses below the surface are computed; None where they are not wanted."""
    if bodies and properties_of_bodies(bodies):
        bodies = check_bodies(bodies)
    body = subsurface.strained_body(bodies) or {}
    deformable = top_material(body).get("poissons_ratio") is not None
    if stress == "always" and not deformable:
        raise SettingsError("stress = 'always' needs bodies, for their Poisson's ratios", keys=["stress"])
    reason = kind.reason_against("statistics.stress = 'always'", properties_of_bodies([body]))
    if stress == "always" and reason:
        raise SettingsError(f"stress = 'always': {reason}", keys=["stress"])
    has_limit = bool(body) and min(subsurface.yield_stresses(body)) < np.inf
    is_required = stress == "always" or (stress == "auto" and deformable and has_limit and not reason)
    return body if is_required else None


def _bins(edges: dict[str, np.ndarray]) -> dict[Hashable, tuple]:
    """Return the coordinates that the bins have in a file: their centres, and their bounds.

    Neither is the coordinate of the dimension, which would keep the bins of two surfaces apart.
    """
    coordinates: dict[Hashable, tuple] = {}
    for name, bounds in edges.items():
        bins = np.column_stack([bounds[:-1], bounds[1:]])
        coordinates[f"{name}_bin_centre"] = f"{name}_bin", bins.mean(axis=1), {"bounds": f"{name}_bin_bounds"}
        coordinates[f"{name}_bin_bounds"] = (f"{name}_bin", "bounds"), bins
    return coordinates
