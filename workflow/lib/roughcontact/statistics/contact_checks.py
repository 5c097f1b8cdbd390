"""Checks of the solved contact: convergence, resolution of the patches, pressure against material.

`statistics` is always as `contact_statistics` returns it.
"""

from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments import materials
from roughcontact.arguments.answers import AREA, PEAK, PRESSURE
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.variables import Numbers
from roughcontact.contact.dataset import recorded_medium
from roughcontact.statistics.conductance import knudsen_resistance_ratio
from roughcontact.statistics.decisions import is_lifted
from roughcontact.statistics.kinds import load_in_words, unit_of_pressures
from roughcontact.statistics.outcome import Check, judge
from roughcontact.statistics.sealing.gas import MIN_INVERSE_KNUDSEN, path_at_mean_pressure
from roughcontact.statistics.selected_loads import Statistics, largest_of_loads

CONTACT_POINTS = 100  # fewer contact points are too few for statistics
LAYER_PIXELS = 4  # thickness from which the contact of a pixel is that of a half-space
_BALLISTIC = 0.1  # of the resistance, added by the mean free path: less hides in most intervals
# Ohm m2, resistivity times mean free path of the electrons: 3e-16 to 9e-16 in metals of contacts (Gall 2016,
# J. Appl. Phys. 119, 085101)
_RESISTIVITY_TIMES_PATH = 7e-16
_GAS = 5e-5  # Pa s; air has 1.8e-5, the thinnest liquids that are sealed 1e-4
OVERCOUNT = 0.2  # excess of the counted over the corrected area: patches are a few pixels across


def convergence(statistics: Statistics) -> Check:
    """Check that every load reached the tolerance of the solver.

    Examples
    --------
    >>> import xarray as xr
    >>> reached = {"converged": ("load", [1]), "error_bound": ("load", [3e-5])}
    >>> one = xr.Dataset(reached, attrs={"tolerance": 1e-4})
    >>> convergence(one).sentence
    'All loads converged: error bound at most 3.0×10⁻⁵, tolerance 1×10⁻⁴.'
    """
    misses, loads = int((statistics["converged"].values == 0).sum()), statistics.sizes["load"]
    facts = {"bound": largest_of_loads(statistics["error_bound"]), "tolerance": statistics.attrs["tolerance"]}
    return judge("Solver", {"missed": misses}, misses=misses, loads=loads, **facts)


def contact_points(statistics: Statistics, points: int) -> Check:
    """Check that more than a handful of the `points` of the window are in contact at every load."""
    # whole numbers again, after the share was rounded
    counts = np.rint(statistics["relative_contact_area_pixels"].values * points).astype(int)
    is_sparse = counts < CONTACT_POINTS
    facts = {"loads": _some_loads(is_sparse, "fewer"), "limit": CONTACT_POINTS, "least": counts.min()}
    return judge("Points in contact", {"few": is_sparse.any()}, **facts)


def overcount(statistics: Numbers) -> np.ndarray:
    """Return the relative excess of the counted pixels over the corrected area; infinite where that is zero.

    Examples
    --------
    >>> import xarray as xr
    >>> areas = {"relative_contact_area_pixels": ("load", [0.11]), "relative_contact_area": ("load", [0.1])}
    >>> overcount(xr.Dataset(areas)).round(3)
    array([0.1])
    """
    pixels, corrected = (np.asarray(statistics[f"{AREA}{suffix}"]) for suffix in ("_pixels", ""))
    # no corrected area is left of patches of single points
    return np.divide(pixels, corrected, out=np.full(pixels.shape, np.inf), where=corrected > 0) - 1


def resolution(statistics: Statistics) -> Check:
    """Check that the contact patches are more than a few points across."""
    points, excess = float(statistics["points_per_shortest_wavelength"][0]), overcount(statistics)
    is_coarse = excess > OVERCOUNT
    cases = {"flat": np.isnan(points), "coarse": is_coarse.any()}
    facts = {"loads": _some_loads(is_coarse, "the"), "excess": excess.max(), "points": points}
    return judge("Resolution", cases, **facts)


def plasticity(statistics: Statistics) -> Check:
    """Check that no point carries the hardness, or that pressures are below the strength of their class.

    The plasticity index E* g / H is mostly elastic below 0.3, mostly plastic above 3 (Mikić 1974, Int. J.
    Heat Mass Transfer 17, 205); metals flow at a mean contact pressure of 0.01 to 0.03 E*, only rubber bears
    0.1 E*.
    """
    return _hardness_check(statistics) if "hardness" in statistics else _check_by_classes(statistics)


def _hardness_check(statistics: Statistics) -> Check:
    """Return the check of the pressure against the hardness that limits it."""
    hardness, modulus = (float(statistics[name]) for name in ("hardness", "contact_modulus"))
    load_share, area_share = (statistics[f"{name}_share_above_hardness"].values for name in ("load", "area"))
    yield_text = ""
    if may_yield(statistics):
        load = " of ".join(load_in_words(float(statistics["first_yield_pressure"]), statistics))
        yield_text = f" First yield at a {load}."
    worst, yields = np.argmax(load_share), area_share > 0
    # the plasticity index
    index = modulus * float(statistics["rms_gradient"]) / hardness
    numbers = {"largest": largest_of_loads(statistics["max_pressure"]) / hardness, "index": index}
    numbers |= {"load_share": load_share[worst], "area_share": area_share[worst]}
    words = {"loads": _loads(yields, statistics), "hardness": unit_of_pressures(statistics).text(hardness)}
    cases = {"flows": yields.any(), "elastic": True}
    return judge("Plasticity", cases, **numbers, **words, first_yield=yield_text)


def may_yield(statistics: Numbers) -> bool:
    """Return whether the load of first yield is one that these bodies can carry: one below their modulus.

    Examples
    --------
    >>> rubber_on_steel = {"first_yield_pressure": 1.4e9, "contact_modulus": 8e6}
    >>> may_yield(rubber_on_steel), may_yield(rubber_on_steel | {"contact_modulus": 1e11})
    (False, True)
    """
    first_yield = float(statistics.get("first_yield_pressure", np.inf))
    return first_yield < float(statistics["contact_modulus"])


def _check_by_classes(statistics: Statistics) -> Check:
    """Return the check of the pressure where no hardness is stated, by classes of materials."""
    modulus, (mean, largest, is_flowing) = float(statistics["contact_modulus"]), _over_modulus(statistics)
    beyond_materials = mean > materials.MAX_HARDNESS
    is_rubber = rubber_like(statistics)
    cases = {
        # rubber is elastic to large strains, but not beyond its own modulus
        "beyond rubber": is_rubber and mean.max() > 1,
        # the modulus of a gel may be one in MPa that was taken for Pa
        "gel": is_rubber and modulus < materials.GEL and is_flowing.any(),
        "rubber": is_rubber,
        "beyond materials": beyond_materials.any(),
        "metals flow": is_flowing.any(),
    }
    loads = _loads(beyond_materials if beyond_materials.any() else is_flowing, statistics)
    facts = {"mean": mean.max(), "largest": largest.max(), "modulus": modulus, "if_in_mpa": 1e6 * modulus}
    return judge("Plasticity", cases, loads=loads, limits=materials, **facts)


def rubber_like(statistics: Numbers) -> bool:
    """Return whether the contact modulus is that of a solid which does not flow as metals do.

    Examples
    --------
    >>> import xarray as xr
    >>> rubber_like(xr.Dataset({"contact_modulus": 5e6})), rubber_like(xr.Dataset({"contact_modulus": 1e11}))
    (True, False)
    """
    return float(statistics["contact_modulus"]) < materials.RUBBER


def yielding(load: Numbers) -> str:
    """Return in words what yields at one load at the stated hardness, or would without one; else nothing."""
    if "hardness" in load:
        return "asperities yield" if load["area_share_above_hardness"] > 0 else ""
    if rubber_like(load):
        return ""
    mean, _, is_flowing = _over_modulus(load)
    if mean > materials.MAX_HARDNESS:
        return "any material would yield"
    return "metals would yield" if is_flowing else ""


def _over_modulus(numbers: Numbers) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mean and largest pressure in contact over E*, and where metals would flow under them."""
    modulus = float(numbers["contact_modulus"])
    mean, largest = (np.asarray(numbers[name]) / modulus for name in (PRESSURE, PEAK))
    # in the mean, or, hardened, at the peak
    return mean, largest, (mean > materials.METALS[0]) | (largest > materials.METALS[1])


def layers(statistics: Statistics, points: int) -> Check | None:
    """Check that layers are not thinner than the grid can tell, nor thicker than the window; none: no check.

    Examples
    --------
    >>> import json
    >>> import xarray as xr
    >>> layers(xr.Dataset(), 4096) is None
    True
    >>> sheet = {"thickness": 1e-6, "youngs_modulus": 3e6, "poissons_ratio": 0.5}
    >>> bodies = json.dumps([{"base": "rigid", "layers": [sheet]}])
    >>> sides = {"window_length_x": 64e-6, "window_length_y": 64e-6}
    >>> layers(xr.Dataset(sides, attrs={"bodies": bodies}), 4096).sentence.split(":")[0]
    'The thinnest layer (1.00 µm) is 1.0 pixels thick'
    """
    medium = recorded_medium(statistics.attrs)
    if medium.is_homogeneous:
        return None
    lengths = [float(statistics[f"window_length_{axis}"]) for axis in "xy"]
    sides = [side for side in lengths if np.isfinite(side)]  # a profile has one
    # the mean pitch: of oblong pixels both sides count
    pixel = float(np.prod(sides) / points) ** (1 / len(sides))
    pixels, share = medium.thinnest / pixel, medium.thickest / max(sides)
    cases = {"thin": medium.thinnest < LAYER_PIXELS * pixel, "thick": medium.thickest > max(sides)}
    return judge("Layers", cases, medium=medium, pixels=pixels, share=share, limit=LAYER_PIXELS)


def units(statistics: Statistics) -> Check:
    """Check that modulus and loads are those of real materials: else a unit is likely to be wrong."""
    modulus, loads = float(statistics["contact_modulus"]), statistics["mean_pressure"].values
    of_modulus = materials.doubt_of_modulus(modulus)
    of_loads = [doubt for load in loads if (doubt := materials.doubt_of_load(float(load), modulus))]
    names = ("friction_coefficient", "max_flash_temperature", "temperature_drop")
    friction, flash, drop = (largest_of_loads(statistics.get(name, 0.0)) for name in names)
    rise = max(flash, drop)
    of_temperature, temperatures = _doubtful_temperature(statistics, rise)
    low, high = (unit_of_pressures(statistics).text(float(f(loads))) for f in (np.min, np.max))
    cases = {
        # a problem in units of its own, which cannot be checked
        "own": modulus == 1,
        "modulus": of_modulus,
        "friction": friction > materials.MAX_FRICTION,
        "flash": flash > materials.HOTTEST,
        "warmed": of_temperature == "warmed",
        "relaxation": of_temperature == "relaxation",
        # loads that nobody stated have no unit to be wrong
        "planned": statistics.attrs.get("loads") == "planned",
        "loads": of_loads,
    }
    questions = [doubt.question() for doubt in (of_modulus, *of_loads) if doubt]
    facts = {"modulus": modulus, "friction": friction, "flash": flash, "rise": rise} | temperatures
    facts |= {"doubtful": len(of_loads), "loads": loads.size, "questions": questions}
    return judge("Units", cases, **facts, span=low if low == high else f"{low} to {high}")


def _doubtful_temperature(statistics: Statistics, rise: float) -> tuple[str, dict[str, Any]]:
    """Return the case of a named material beyond its range of temperatures, and its facts; "" for none."""
    for name, limits in json_attribute(statistics.attrs, "temperatures").items():
        facts = {"stated": materials.ROOM} | limits | {"material": name}
        # the mean temperature is taken for that of a room, where nothing else is stated
        if materials.ROOM + rise > facts["highest"]:
            return "warmed", facts
        # one of both scales may be meant
        in_celsius = (facts["stated"], facts["stated"] - 273.15)
        if not any(facts["lowest"] <= temperature <= facts["highest"] for temperature in in_celsius):
            return "relaxation", facts
    return "", {}


def _loads(mask: np.ndarray | xr.DataArray, statistics: Statistics) -> str:
    """Return the loads concerned, as the beginning of a sentence; empty for none."""
    pressures = statistics["mean_pressure"].values
    chosen = pressures[np.asarray(mask)]
    if not chosen.size:
        return ""
    _, lightest = load_in_words(float(chosen.min()), statistics)
    if pressures.size == 1:
        return f"At {lightest}"
    if chosen.size == pressures.size:
        return "At every load"
    return f"At {chosen.size} of {pressures.size} loads, from {lightest} on,"


def _some_loads(mask: np.ndarray, word: str) -> str:
    """Return how many loads are concerned, and the word after them, as the beginning of a sentence."""
    return f"At {np.count_nonzero(mask)} of {mask.size} loads {word}" if mask.size > 1 else word.capitalize()


@np.errstate(invalid="ignore")  # full contact has no constriction
def mean_free_path(statistics: Statistics) -> Check | None:
    """Check that the spots that conduct a current are larger than the mean free path of the electrons.

    They count as round ones with the same ratio of Sharvin's resistance to that of the constriction. None of
    a contact that conducts no current, or through layers.
    """
    if "electrical_conductance" not in statistics:
        return None
    names = ("electrical_conductance", "conductance_per_conductivity", "relative_contact_area")
    conductance, of_constriction, area = (statistics[name].values for name in names)
    ratio = 4 / 3 * _RESISTIVITY_TIMES_PATH * conductance * (1 / area - 1)
    is_known = np.isfinite(ratio) & np.isfinite(of_constriction) & (ratio > 0)
    if not is_known.any():
        return None
    knudsen = 3 * np.pi / 8 * float(ratio[is_known].max())
    path = _RESISTIVITY_TIMES_PATH * float((conductance / of_constriction)[is_known].max())
    increase = float(knudsen_resistance_ratio(knudsen)) - 1
    facts = {"radius": path / knudsen, "path": path, "knudsen": knudsen, "increase": increase}
    return judge("Mean free path", {"ballistic": increase >= _BALLISTIC}, **facts)


def fluid(statistics: Statistics) -> Check | None:
    """Check that a sealed fluid presses less than the bodies, and that its flow is known; none: no seal.

    Examples
    --------
    >>> air = {"seal_pressure_difference": 1e5, "seal_viscosity": 1.8e-5}
    >>> statistics = xr.Dataset({"leak_rate_x": ("load", [0.0])}, {"mean_pressure": ("load", [1e6])}, air)
    >>> fluid(statistics).finding
    'The fluid has the viscosity of a gas, 1.80×10⁻⁵ Pa s; the leak rate is that of an incompressible fluid.'
    """
    if "leak_rate_x" not in statistics:
        return None
    pressure, viscosity = (statistics.attrs[f"seal_{key}"] for key in ("pressure_difference", "viscosity"))
    lifts, is_gas = is_lifted(statistics), "seal_outlet_pressure" in statistics.attrs
    knudsen = 0.0
    if path := path_at_mean_pressure(statistics.attrs):
        places = np.array([statistics[f"critical_constriction_{axis}"] for axis in "xy"])
        # where it is closed no gas flows
        knudsen = path / float(places[places > 0].min(initial=np.inf))
    cases = {
        # the fluid would push the bodies apart
        "lifts": lifts.any(),
        "gas without path": is_gas and not path,
        "gas at closed gap": is_gas and knudsen == 0,
        # D = sqrt(pi)/2 over the Knudsen number is the argument of the fit
        "gas": is_gas and knudsen * MIN_INVERSE_KNUDSEN <= np.sqrt(np.pi) / 2,
        "rarefied gas": is_gas,
        "viscosity of a gas": viscosity < _GAS,
    }
    facts = {"pressure": pressure, "viscosity": viscosity, "knudsen": knudsen}
    return judge("Fluid", cases, **facts, lifted=lifts.sum(), loads=lifts.size)


def load_range(statistics: Statistics) -> Check:
    """Check that not all loads are in full contact.

    Examples
    --------
    >>> import xarray as xr
    >>> areas = xr.DataArray([0.11, 1.0], dims="load")
    >>> both = xr.Dataset({"relative_contact_area_pixels": areas, "relative_contact_area": areas})
    >>> load_range(both).sentence
    'The contact covers 11.0 % to 100 % of the area.'
    """
    all_full = bool((statistics["relative_contact_area_pixels"].values == 1).all())
    low, high = (f.reduce(statistics["relative_contact_area"].values) for f in (np.fmin, np.fmax))
    cases = {"full": all_full and statistics.sizes["load"] == 1, "all full": all_full}
    return judge("Load range", cases, low=low, high=high)
