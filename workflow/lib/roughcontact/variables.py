"""The table of output variables: one entry per name that a result file can hold.

`describe` adds units and a sentence to every variable of a dataset, so that each file has them.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.errors import RoughContactError

Numbers = xr.Dataset | Mapping[str, Any]  # statistics, or their plain values by name

# what a load is asked for, each with a verdict of its own: words by the beginning of the variable's name
ANSWERS = {
    "relative_contact_area": "contact area",
    "mean_contact_pressure": "pressure in contact",
    "mean_gap": "mean gap",
    "sealing": "sealing",
    "yield": "yield",
    "max_pressure": "largest pressure",
    "conductance": "conductance",
}

# name: (unit in UDUNITS spelling, meaning)
VARIABLES: dict[str, tuple[str | None, str]] = {
    # maps
    "height": ("m", "surface height, positive outwards; NaN where not measured"),
    "filled": ("1", "1 where the height was not measured but filled in, 0 elsewhere"),
    "line_offset": ("m", "shift of each row (scan line) that levelling removed"),
    "rejected_height": ("m", "height of a point rejected by levelling, as if it were kept; NaN elsewhere"),
    "pressure": ("Pa", "contact pressure"),
    "gap": ("m", "gap between the deformed surfaces"),
    "contact": ("1", "1 where the surfaces touch (pressure > 0), 0 elsewhere"),
    # the solution, per load
    "mean_pressure": ("Pa", "nominal (applied, mean) pressure over the whole window"),
    "force": ("N", "force on a body of finite size"),
    "local_contact_area": ("m2", "contact area of all places of Hertz's contact, each as the map there"),
    "local_mean_gap": ("m", "mean gap within Hertz's contact, each place as the map there"),
    "contact_area": ("m2", "area of the contact of a body of finite size, corrected by the perimeter rule"),
    "contact_radius": ("m", "radius of the circle of that area"),
    "loaded_radius": ("m", "3F/(4 E* u), u the displacement in the middle: Hertz's radius of a smooth body"),
    "greenwood_tripp_contact_area": ("m2", "contact area of a rough ball after Greenwood and Tripp (1967)"),
    "greenwood_tripp_max_pressure": ("Pa", "largest nominal pressure after Greenwood and Tripp (1967)"),
    "greenwood_tripp_loaded_radius": ("m", "loaded_radius after Greenwood and Tripp (1967)"),
    "hertz_radius": ("m", "radius of the circle of the area in contact of the smooth body (Hertz)"),
    "hertz_max_pressure": ("Pa", "largest pressure of the smooth body (Hertz)"),
    "hertz_approach": ("m", "approach of the smooth body (Hertz)"),
    "relative_pressure": ("1", "mean pressure / (contact modulus x rms gradient)"),
    "approach": ("m", "place of the half-space on the scale of the heights; falls as the load rises"),
    "iterations": ("1", "outer iterations of the solver, all grids"),
    "operator_applications": ("1", "forward and inverse FFT pairs, one pair on the solved grid counting 1"),
    "error_bound": ("1", "rigorous bound of the relative pressure error in the energy norm"),
    "rounding_floor": (
        "1",
        "relative pressure error that rounding alone can cause, in the precision of the solver",
    ),
    "yielded_area": ("1", "share of the area whose pressure has reached the hardness, where one is given"),
    "residual_height": ("m", "heights that plastic flow has left after the load"),
    "plastic_depth": ("m", "by how much plastic flow has lowered the heights"),
    "mean_plastic_depth": ("m", "mean of that over the window"),
    "plastic_volume": ("m3", "volume that flow has lowered the heights by, over the window"),
    "max_plastic_depth": ("m", "largest of that"),
    "peak_pressure": ("Pa", "mean pressure from which the load was taken off"),
    "rms_height_before_load": ("m", "root mean square height of the window before the load"),
    "rms_gradient_before_load": ("1", "root mean square gradient of the window before the load"),
    "rms_curvature_before_load": ("m-1", "root mean square mean curvature of the window before the load"),
    "dissipated_energy": ("J m-2", "energy lost in one cycle of load by area: by plastic flow, or by slip"),
    "tangential_load": ("1", "tangential load over the friction coefficient times the normal one"),
    "shear_traction": ("Pa", "tangential traction in the direction of the load"),
    "stick": ("1", "1 where the surfaces stick, 0 where they slip or do not touch"),
    "stick_share": ("1", "share of the contact area that sticks"),
    "tangential_error_bound": ("1", "bound of the relative error of the traction in the energy norm"),
    "tangential_stiffness": ("Pa m-1", "tangential stiffness of the contact for further loading"),
    "friction_coefficient": ("1", "coefficient of friction of a contact of a stated shear strength"),
    "tangential_displacement": ("m", "tangential displacement of the bodies far from the contact"),
    "temperature_rise": ("K", "temperature above the mean one of the surfaces, by sliding"),
    "mean_flash_temperature": ("K", "mean of that over the contact"),
    "max_flash_temperature": ("K", "largest of that"),
    "max_penetration": ("m", "largest overlap of the surfaces in the solution"),
    "load_error": ("1", "relative difference of the mean of the pressure from the prescribed one"),
    "converged": ("1", "1 where error_bound <= tolerance, 0 elsewhere"),
    "verdict": (
        "1",
        "worst outcome of the checks of contact area and pressure in contact: 0 use, 1 review, 2 do not use",
    ),
    # statistics, per load
    "relative_contact_area": ("1", "share of the area in contact, corrected by the perimeter rule"),
    "relative_contact_area_pixels": ("1", "share of the pixels in contact, uncorrected"),
    "contact_perimeter": ("m", "length of the contact line; not defined for a profile"),
    "contact_clusters": ("1", "number of connected contact patches, counted over the periodic boundary"),
    "largest_patch_area": (
        "m2",
        "area of the largest connected contact patch, pixels counted; not defined for a profile",
    ),
    "contact_on_filled_points": ("1", "share of the contact pixels whose height was filled in"),
    "rejected_load_share": ("1", "share of the load that the rejected points would carry if they were kept"),
    "mean_contact_pressure": ("Pa", "mean pressure over the contact pixels"),
    "max_pressure": ("Pa", "largest pressure"),
    "pressure_std": ("Pa", "standard deviation of the pressure over the contact pixels"),
    "mean_gap": ("m", "mean of the gap over the window"),
    "contact_stiffness": (
        "Pa m-1",
        "elastic - d mean_pressure / d mean_gap; where points have yielded that of unloading",
    ),
    "loading_stiffness": (
        "Pa m-1",
        "- d mean_pressure / d mean_gap of further loading, where a hardness is given",
    ),
    "conductance_per_conductivity": ("m-1", "conductance of the contact over the mean conductivity, K/E*"),
    "thermal_conductance": ("W m-2 K-1", "thermal conductance of the contact per nominal area"),
    "gas_conductance": ("W m-2 K-1", "thermal conductance of the gas in the gap per nominal area"),
    "joint_conductance": ("W m-2 K-1", "that of the joint: contact with its film, and gas"),
    "electrical_conductance": ("S m-2", "electrical conductance of the contact per nominal area"),
    "thermal_resistance": ("m2 K W-1", "thermal resistance of the contact times nominal area"),
    "electrical_resistance": ("Ohm m2", "specific contact resistance: resistance times nominal area"),
    "gap_percolates_x": ("1", "1 where the gap is open from end to end along x, 0 where it is closed"),
    "gap_percolates_y": ("1", "1 where the gap is open from end to end along y, 0 where it is closed"),
    "critical_constriction_x": ("m", "largest height that a path through the gap along x keeps; 0: closed"),
    "critical_constriction_y": ("m", "largest height that a path through the gap along y keeps; 0: closed"),
    "flow_factor_xx": ("1", "flow along x over that between plates at the mean gap, gradient along x"),
    "flow_factor_yy": ("1", "flow along y over that between plates at the mean gap, gradient along y"),
    "flow_factor_xy": ("1", "flow along x over that between plates at the mean gap, gradient along y"),
    "shear_flow_x": (
        "1",
        "share of the mean gap whose fluid moves with a rough face sliding along x",
    ),
    "shear_flow_y": (
        "1",
        "share of the mean gap whose fluid moves with a rough face sliding along y",
    ),
    "pressure_flow_factor_x": ("1", "pressure flow factor of Patir and Cheng along x"),
    "pressure_flow_factor_y": ("1", "pressure flow factor of Patir and Cheng along y"),
    "shear_flow_factor_x": ("1", "shear flow factor of Patir and Cheng along x, of the sliding rough face"),
    "shear_flow_factor_y": ("1", "shear flow factor of Patir and Cheng along y, of the sliding rough face"),
    "leak_rate_x": ("m2 s-1", "leak rate by length of the seal, flow along x"),
    "leak_rate_y": ("m2 s-1", "leak rate by length of the seal, flow along y"),
    "leak_rate_by_cube": ("m-1 s-1", "leak rate between parallel plates, over the cube of their distance"),
    "max_von_mises_stress": ("Pa", "largest stress of von Mises in the body that stresses_of names"),
    "max_von_mises_depth": ("m", "depth of the largest stress of von Mises"),
    "max_von_mises_x": (
        "m",
        "place of the largest stress of von Mises along x; not defined across a profile",
    ),
    "max_von_mises_y": (
        "m",
        "place of the largest stress of von Mises along y; not defined across a profile",
    ),
    "max_tresca_stress": (
        "Pa",
        "largest difference of principal stresses in the body that stresses_of names",
    ),
    "von_mises_profile": (
        "Pa",
        "largest stress of von Mises at each depth of the body that stresses_of names",
    ),
    "volume_above_yield": ("m", "volume by area in which the stress of von Mises exceeds the yield stress"),
    "first_subsurface_yield_pressure": (
        "Pa",
        "mean pressure at which the stress of von Mises below the surface reaches the yield stress",
    ),
    "material_von_mises_stress": (
        "Pa",
        "largest stress of von Mises in each layer and the base of the body that stresses_of names",
    ),
    "material_von_mises_depth": ("m", "depth of the largest stress of von Mises in each layer and the base"),
    "material_first_yield_pressure": (
        "Pa",
        "mean pressure at which the stress of von Mises reaches the yield stress of each layer and the base",
    ),
    "interface_shear_stress": (
        "Pa",
        "largest shear traction at the lower face of each layer of the body that stresses_of names",
    ),
    "interface_normal_stress": (
        "Pa",
        "largest normal traction at the lower face of each layer, tension positive",
    ),
    "elastic_energy": ("J m-2", "elastic energy per nominal area, relative to uniform pressure"),
    "max_pressure_over_modulus": ("1", "largest pressure over the contact modulus"),
    "load_share_above_hardness": ("1", "share of the load on points that carry the hardness"),
    "area_share_above_hardness": ("1", "share of the contact pixels that carry the hardness"),
    "load_share_above_ratio": (
        "1",
        "share of the load on points at hardness_over_modulus x contact modulus or above",
    ),
    "area_share_above_ratio": (
        "1",
        "share of the contact pixels at hardness_over_modulus x contact modulus or above",
    ),
    "pressure_density": ("Pa-1", "probability density of the pressure over the contact pixels"),
    "gap_density": ("m-1", "probability density of the gap over the pixels out of contact"),
    "patch_area_density": (
        "m-2",
        "probability density of the areas of the contact patches; not defined for a profile",
    ),
    "points_per_shortest_wavelength": ("1", "pixels per shortest wavelength of the map"),
    "critical_constriction_x_half_way": (
        "m",
        "largest height that a way along x keeps which crosses half of the map",
    ),
    "critical_constriction_y_half_way": (
        "m",
        "largest height that a way along y keeps which crosses half of the map",
    ),
    "index_of_the_peak": ("1", "index of the largest pressure, counted row by row"),
    # theory beside the data
    "area_persson": ("1", "relative contact area after Persson (2001)"),
    "area_xu": ("1", "relative contact area after Xu et al. (2024)"),
    "area_bush_gibson_thomas": ("1", "relative contact area after Bush, Gibson and Thomas (1975), low load"),
    "area_greenwood_williamson": ("1", "relative contact area after Greenwood and Williamson (1966)"),
    # roughness, per surface
    "rms_height": ("m", "root mean square height of the solved window"),
    "rms_gradient": ("1", "spectral root mean square gradient of the solved window"),
    "rms_curvature": ("m-1", "spectral root mean square of the mean curvature of the solved window"),
    "conforming_energy": ("J m-2", "elastic energy by area of the solved window pressed flat"),
    "effective_work_of_adhesion": ("J m-2", "work of adhesion less the energy of the window pressed flat"),
    "nayak_parameter": ("1", "Nayak's bandwidth parameter m0 m4 / m2^2 of the solved window"),
    # ISO 25178-2, per surface: heights of the levelled map (measured points), texture of the solved window
    "row_jitter": (
        "1",
        "rms shift of the rows over the rms height of the map without it; 0 without evidence",
    ),
    "Sa": ("m", "arithmetical mean height of the levelled map"),
    "Sq": ("m", "root mean square height of the levelled map"),
    "Ssk": ("1", "skewness of the heights of the levelled map"),
    "Sku": ("1", "kurtosis of the heights of the levelled map"),
    "Sp": ("m", "maximum peak height of the levelled map"),
    "Sv": ("m", "maximum pit depth of the levelled map"),
    "Sz": ("m", "maximum height of the levelled map, Sp + Sv"),
    "Sdq": ("1", "root mean square gradient of the levelled map, from differences of neighbours"),
    "Sdr": ("1", "developed area of the levelled map over the projected one, less 1"),
    "Sk": ("m", "core height of the levelled map"),
    "Spk": ("m", "reduced peak height of the levelled map"),
    "Svk": ("m", "reduced dale depth of the levelled map"),
    "Spkx": ("m", "height of the highest point of the levelled map above its core"),
    "Svkx": ("m", "depth of the lowest point of the levelled map below its core"),
    "Sak1": ("m", "area of the triangle of the peaks of the levelled map, Spk Smr1 / 2"),
    "Sak2": ("m", "area of the triangle of the dales of the levelled map, Svk (1 - Smr2) / 2"),
    "Smr1": (
        "1",
        "material ratio at which peaks end and the core of the levelled map begins; Smrk1 since 2021",
    ),
    "Smr2": (
        "1",
        "material ratio at which the core of the levelled map ends and dales begin; Smrk2 since 2021",
    ),
    "Vmp": ("m", "peak material volume by area of the levelled map, up to 10 % material ratio"),
    "Vmc": ("m", "core material volume by area of the levelled map, from 10 % to 80 % material ratio"),
    "Vvc": ("m", "core void volume by area of the levelled map, from 10 % to 80 % material ratio"),
    "Vvv": ("m", "dale void volume by area of the levelled map, below 80 % material ratio"),
    "Sdc": ("m", "height between the material ratios 2.5 % and 50 % of the levelled map; Sxp before 2021"),
    "Sal": ("m", "autocorrelation length of the solved window: shortest decay to 0.2"),
    "Str": (
        "1",
        "texture aspect ratio of the solved window, none if it is too narrow: Sal over longest decay to 0.2",
    ),
    "Std": ("degree", "direction of the strongest waves of the solved window, from x towards y"),
    "Ssw": ("m", "dominant wavelength of the solved window, that of its strongest wave"),
    # coordinates and bins
    "x": ("m", "cell centres along x"),
    "y": ("m", "cell centres along y"),
    "pressure_bin_centre": ("Pa", "centres of the pressure bins"),
    "pressure_bin_bounds": ("Pa", "edges of the pressure bins"),
    "gap_bin_centre": ("m", "centres of the gap bins"),
    "gap_bin_bounds": ("m", "edges of the gap bins"),
    "patch_bin_centre": ("m2", "centres of the patch area bins"),
    "patch_bin_bounds": ("m2", "edges of the patch area bins"),
    "depth": ("m", "depth below the surface"),
    "profile_depth": ("m", "depth below the surface"),
    "interface_depth": ("m", "depth of the lower face of each layer"),
    # of a profile whose lay is not stated
    "relative_contact_area_if_isotropic": ("1", "contact area of an isotropic surface with this profile"),
    "mean_gap_if_isotropic": ("m", "mean gap of an isotropic surface with this profile"),
    # the window
    "window_length_x": ("m", "length of the window along x; not defined across a profile"),
    "window_length_y": ("m", "length of the window along y; not defined across a profile"),
    "window_offset_x": ("m", "distance of the window's first cell from the map's first cell along x"),
    "window_offset_y": ("m", "distance of the window's first cell from the map's first cell along y"),
    "contact_modulus": ("Pa", "plane-strain contact modulus E*"),
    "hardness": ("Pa", "largest pressure that the softer body bears before it flows, where one is given"),
    "first_yield_pressure": ("Pa", "mean pressure at which the largest pressure reaches the hardness"),
    "first_yield_pressure_by_ratio": (
        "Pa",
        "mean pressure at which the largest pressure reaches hardness_over_modulus x contact modulus",
    ),
    "hardness_over_modulus": (
        "1",
        "hardness / E* of annealed metals, structural steels, hardened steels, ceramics and glassy polymers",
    ),
    # the magnification curve
    "cutoff_wavelength": ("m", "shortest wave that is kept"),
    "gradient_at_cutoff": ("1", "spectral root mean square gradient of the waves that are kept"),
    # the components of the intervals
    "component": (None, "half-width down or up, shift of the end down or up"),
    "input": (None, "input that a result is sensitive to"),
    # labels
    "source": (None, "source of an uncertainty; combined: root of the sum of their squares"),
    "surface": (None, "name of the surface, as in the table of surfaces"),
    "surface_name": (None, "name of the surface, as in the table of surfaces"),
    "case": (None, "name of the case, as in the settings"),
    "case_name": (None, "name of the case, as in the settings"),
    # groups of maps
    "group": (None, "name of the group of maps, or of the pair of faces"),
    "group_name": (None, "name of the group of maps, or of the pair of faces"),
    "map": (None, "name of the map"),
    "map_name": (None, "name of the map; empty beyond the maps of a group"),
    "part": (None, "name of the part that the map is of"),
    "maps": ("1", "number of the maps of the group"),
    "stands_off": (
        "1",
        "1 for a map that stands off the others of its group (Grubbs's test, 1 %), 0 elsewhere",
    ),
}

# quantities that have an interval: unit, and what they are called in descriptions
_WITH_INTERVAL = {
    "relative_contact_area": ("1", "contact area"),
    "mean_gap": ("m", "mean gap"),
    "max_pressure": ("Pa", "largest pressure"),
    "mean_contact_pressure": ("Pa", "pressure in contact"),
    "conductance_per_conductivity": ("m-1", "conductance over the mean conductivity"),
    "critical_constriction_x": ("m", "narrowest place along x"),
    "critical_constriction_y": ("m", "narrowest place along y"),
}
_OF_INTERVALS = {
    "uncertainty": "half-width of the 95 % interval of the {}",
    "lower": "lower end of the 95 % interval of the {}, mean of maps of this size all over the surface",
    "upper": "upper end of the 95 % interval of the {}, as for its lower end; none where nothing bounds it",
    "estimate": "value of the {} that the components of its interval refer to",
    "as_solved": "{} of the pixels of the map, before the correction for their size",
    "components": "half-widths and one-sided shifts that the interval of the {} is made of",
    "map_lower": "lower end of the 95 % interval of the {}, of this map between its own borders",
    "map_upper": "upper end of the 95 % interval of the {}, of this map between its own borders",
    "next_lower": "lower end of the 95 % interval of the {} of the next map of this size",
    "next_upper": "upper end of the 95 % interval of the {} of the next map; none where nothing bounds it",
    "longer_lower": "lower end of the 95 % interval of the {}, of a surface `extent` times as long",
    "longer_upper": "upper end of the 95 % interval of the {}, of a surface `extent` times as long",
    "octave_lower": "lower end of the 95 % interval of the {}, with waves one octave shorter",
    "octave_upper": "upper end of the 95 % interval of the {}, with waves one octave shorter",
    "next_part_lower": "lower end of the 95 % interval of the mean {} of the next part",
    "next_part_upper": "upper end of the 95 % interval of the mean {} of the next part",
    "of_maps": "{} of each map of the group",
    "parts": "{} of each part of the window, solved by itself",
    "at_cutoff": "{} of the waves that are kept, by the shortest of them",
    "as_measured": "{} without the correction for the instrument",
}
# whose interval follows from another one
_DERIVED = ["leak_rate_x", "leak_rate_y", "friction_coefficient", "mean_pressure", "contact_stiffness"]
_DERIVED += [f"{name}_flow_factor_{axis}" for name in ("pressure", "shear") for axis in "xy"]
_DERIVED += [
    f"{property_name}_{quantity_name}"
    for property_name in ("thermal", "electrical")
    for quantity_name in ("conductance", "resistance")
]
VARIABLES |= {
    f"{name}_{end}": (VARIABLES[name][0], _OF_INTERVALS[end].format(name.replace("_", " ")))
    for name in _DERIVED
    for end in ("lower", "upper")
}
VARIABLES |= {
    f"{name}_sensitivity": ("1", f"d ln Q/d ln input of the {description}; NaN: not known")
    for name, (_, description) in _WITH_INTERVAL.items()
}
_OF_GROUPS = {
    "between": "standard deviation of the {} between parts, on its symmetric scale",
    "within": "standard deviation of the {} between the maps of a part, on its symmetric scale",
    "shared": "half-widths and shifts of the {} that the maps of a group share, on its symmetric scale",
}
VARIABLES |= {
    # heights are their own scale, all others have a logarithm
    f"{name}_{ending}": (unit if name.startswith("critical") else "1", text.format(description))
    for name, (unit, description) in _WITH_INTERVAL.items()
    for ending, text in _OF_GROUPS.items()
}
VARIABLES |= {
    f"{name}_{ending}": (unit, text.format(description))
    for name, (unit, description) in _WITH_INTERVAL.items()
    for ending, text in _OF_INTERVALS.items()
}

# comments of variables that need more than a line
_COMMENTS = {
    "approach": (
        "gap = displacement - height + approach, the displacement positive into the half-space. Its mean is "
        "what the setting zero_frequency makes of the load: nothing by the rule zero, by which the approach "
        "is the mean gap plus the mean height where no point yields."
    ),
}

# verdicts on single answers, beside `verdict`
VARIABLES |= {
    f"{name}_verdict": ("1", f"worst outcome of the checks that concern the {description}: as of verdict")
    for name, description in ANSWERS.items()
}

# how well answers are known
_YES_OR_NO = ("sealing", "yield")
VARIABLES |= {
    f"{name}_known": (
        "1",
        f"0 where the interval tells {description} from none, none where it holds both"
        if name in _YES_OR_NO
        else f"larger half-width of the 95 % interval of the {description} over its value; none if unbounded",
    )
    for name, description in ANSWERS.items()
}

# meanings of the values 0, 1, 2 ... of a flag
_FLAGS = {name: ("use", "review", "do_not_use") for name in VARIABLES if name.endswith("verdict")}

# CF has this standard name for distances on a plane; without it checkers take an axis for a longitude
_AXES = {
    "x": {"axis": "X", "standard_name": "projection_x_coordinate"},
    "y": {"axis": "Y", "standard_name": "projection_y_coordinate"},
    "depth": {"axis": "Z", "positive": "down"},
}


def values_at_load(statistics: xr.Dataset, index: int) -> dict[str, np.ndarray]:
    """Return the plain values of all variables at one load; those of no load as they are.

    Examples
    --------
    >>> statistics = xr.Dataset({"contact_modulus": 1e9, "mean_gap": ("load", [2e-7, 1e-7])})
    >>> values_at_load(statistics, 1)["mean_gap"].item()
    1e-07
    """
    # looking up a variable of a dataset, with its coordinates, takes a hundred times as long
    return {
        str(name): variable.values.take(index, variable.dims.index("load"))
        if "load" in variable.dims
        else variable.values
        for name, variable in statistics.variables.items()
    }


def describe(dataset: xr.Dataset) -> xr.Dataset:
    """Return a copy of a dataset with `units` and `long_name` of `VARIABLES` on every variable (CF).

    A variable that is not in the table is refused. Longer explanations are in `comment`; `x`, `y` and `depth`
    get their `axis`, flags their `flag_values` and `flag_meanings`, and bins describe their bounds.
    """
    unknown = [name for name in dataset.variables if name not in VARIABLES]
    if unknown:
        raise RoughContactError(
            f"no description for the output variables {unknown}: add them to variables.py"
        )
    dataset = dataset.copy()
    bounds = {variable.attrs.get("bounds") for variable in dataset.variables.values()}
    for name, variable in dataset.variables.items():
        units, long_name = VARIABLES[str(name)]
        if name not in bounds:
            variable.attrs["long_name"] = long_name
        if units is not None:
            variable.attrs["units"] = units
        if name in _COMMENTS:
            variable.attrs["comment"] = _COMMENTS[str(name)]
        if name in _FLAGS:
            variable.attrs["flag_values"] = np.arange(len(_FLAGS[str(name)]), dtype=variable.dtype)
            variable.attrs["flag_meanings"] = " ".join(_FLAGS[str(name)])
        if name in dataset.dims:
            variable.attrs |= _AXES.get(str(name), {})
    return dataset
