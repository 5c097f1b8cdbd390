"""Checks of the solved contact: convergence, resolution of the patches, pressure against material.

`statistics` is always as `contact_statistics` returns it.
"""

import numpy as np
import xarray as xr

from roughcontact.arguments import materials
from roughcontact.arguments.answers import AREA
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import number, percent, quantity
from roughcontact.arguments.variables import Numbers
from roughcontact.contact.dataset import recorded_medium
from roughcontact.statistics.conductance import knudsen_resistance_ratio
from roughcontact.statistics.decisions import is_lifted
from roughcontact.statistics.kinds import load_in_words, unit_of_pressures
from roughcontact.statistics.outcome import Check, failed, not_made, noted, passed, review
from roughcontact.statistics.sealing.gas import MIN_INVERSE_KNUDSEN, path_at_mean_pressure
from roughcontact.statistics.selected_loads import Statistics

CONTACT_POINTS = 100  # fewer contact points are too few for statistics
LAYER_PIXELS = 4  # thickness from which the contact of a pixel is that of a half-space
_BALLISTIC = 0.1  # of the resistance, added by the mean free path: less hides in most intervals
# Ohm m2, resistivity times mean free path of the electrons: 3e-16 to 9e-16 in metals of contacts (Gall 2016,
# J. Appl. Phys. 119, 085101)
_RESISTIVITY_TIMES_PATH = 7e-16
_GAS = 5e-5  # Pa s; air has 1.8e-5, the thinnest liquids that are sealed 1e-4
_RUBBER = quantity(materials.RUBBER, "Pa", digits=1)
_ROUGHNESS_OF_FORM = 0.05  # rms height over Hertz's approach
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
    misses, loads = int((statistics["converged"] == 0).sum()), statistics.sizes["load"]
    bound = number(float(statistics["error_bound"].max()), digits=2)
    tolerance = number(float(statistics.attrs["tolerance"]), digits=1)
    if misses:
        return failed(
            f"{misses} of {loads} loads missed the tolerance of {tolerance}; the error bound reaches {bound}."
        )
    return passed(f"All loads converged: error bound at most {bound}, tolerance {tolerance}.")


def contact_points(statistics: Statistics, points: int) -> Check:
    """Check that more than a handful of the `points` of the window are in contact at every load."""
    # whole numbers again, after the share was rounded
    counts = np.rint(statistics["relative_contact_area_pixels"].values * points).astype(int)
    if few_loads := int((counts < CONTACT_POINTS).sum()):
        loads = f"At {few_loads} of {counts.size} loads fewer" if counts.size > 1 else "Fewer"
        return review(
            f"{loads} than {CONTACT_POINTS} points are in contact (down to {counts.min()}): areas and "
            "pressures are coarse there.",
            advice="Use higher loads or a finer map.",
        )
    return passed(f"At least {counts.min()} points in contact at every load.")


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
    resolution = float(statistics["points_per_shortest_wavelength"][0])
    if np.isnan(resolution):
        return passed("The map is flat: there is no wave to resolve.")
    excess = overcount(statistics)
    largest_excess = percent(excess.max())
    waves = f"The shortest wave of the map has {number(resolution, digits=2)} points."
    if coarse := int((excess > OVERCOUNT).sum()):
        loads = f"At {coarse} of {excess.size} loads the" if excess.size > 1 else "The"
        return review(
            f"{loads} contact patches are only a few points across: counting points overstates the area by "
            f"up to {largest_excess}, and the correction is coarse.",
            explanation=waves,
            advice="Measure with finer pixels.",
        )
    return passed(
        f"Counting points overstates the area by at most {largest_excess}; this is corrected. {waves}"
    )


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
    if "first_yield_pressure" in statistics:
        load = " of ".join(load_in_words(float(statistics["first_yield_pressure"]), statistics))
        yield_text = f" First yield at a {load}."
    bears = f"the hardness of {unit_of_pressures(statistics).text(hardness)}"
    yields = area_share > 0
    if not yields.any():
        largest = percent(float(statistics["max_pressure"].max()) / hardness)
        return passed(f"No point carries {bears}: at most {largest} of it.{yield_text}")
    worst = int(np.argmax(load_share))
    index = modulus * float(statistics["rms_gradient"]) / hardness
    return review(
        f"{_loads(yields, statistics)} points carry {bears} and flow: up to {percent(load_share[worst])} of "
        f"the load on {percent(area_share[worst])} of the contact area.",
        explanation=f"The pressure is limited there, the shape after yielding is not known.{yield_text} "
        f"Plasticity index E* g / H = {number(index, digits=2)} (mostly elastic below 0.3, mostly plastic "
        "above 3).",
    )


def _check_by_classes(statistics: Statistics) -> Check:
    """Return the check of the pressure where no hardness is stated, by classes of materials."""
    modulus, (mean, largest) = float(statistics["contact_modulus"]), _over_modulus(statistics)
    beyond_materials, flowing = mean > materials.MAX_HARDNESS, _metals_flow(mean, largest)
    figures = f"the mean pressure in contact reaches {number(mean.max(), digits=2)} E*"
    figures += f", the largest {number(largest.max(), digits=2)} E*"
    limits = "{:g} to {:g} E*".format(*materials.METALS)
    not_stated = "no hardness is stated"
    state = "State the hardness (contact.hardness, or that of the bodies)."
    if rubber_like(statistics):
        if mean.max() > 1:  # rubber is elastic to large strains, but not beyond its own modulus
            return review(f"More than rubber bears: {figures}.")
        text = f"{not_stated}; {figures}; rubber-like solids (E* below {_RUBBER}) bear that."
        # the modulus of a gel may be one in MPa that was taken for Pa
        if modulus < materials.GEL and flowing.any():
            text = (
                f"{not_stated}; {figures}; gels bear that, and E* = {quantity(modulus, 'Pa')} is that of "
                f"one. If it was given in MPa, it is {quantity(1e6 * modulus, 'Pa')}, and metals flow there."
            )
        return not_made(text)
    if beyond_materials.any():
        return failed(
            f"{_loads(beyond_materials, statistics)} the contact is beyond what any material bears, "
            f"{materials.MAX_HARDNESS:g} E*: {figures}.",
            explanation="An elastic result means nothing there.",
            advice=state,
        )
    if flowing.any():
        return review(
            f"{_loads(flowing, statistics)} metals would flow, which they do at {limits}: {figures}.",
            explanation="No hardness is stated, and the result is elastic whatever the pressure.",
            advice=state,
        )
    return not_made(f"{not_stated}; {figures}; metals flow at {limits}.", advice=state)


def rubber_like(statistics: Numbers) -> bool:
    """Return whether the contact modulus is that of a solid which does not flow as metals do.

    Examples
    --------
    >>> import xarray as xr
    >>> rubber_like(xr.Dataset({"contact_modulus": 5e6})), rubber_like(xr.Dataset({"contact_modulus": 1e11}))
    (True, False)
    """
    return float(statistics["contact_modulus"]) < materials.RUBBER


def yield_flags(load: Numbers) -> list[str]:
    """Return the warnings of one load: "points flow", or by class "metals flow", "beyond hardness"."""
    if "hardness" in load:
        return ["points flow"] if load["area_share_above_hardness"] > 0 else []
    if rubber_like(load):
        return []
    mean, largest = _over_modulus(load)
    if mean > materials.MAX_HARDNESS:  # that of any material
        return ["beyond hardness"]
    return ["metals flow"] if _metals_flow(mean, largest) else []


def _over_modulus(numbers: Numbers) -> list[np.ndarray]:
    """Return the mean pressure in contact and the largest one over the modulus."""
    modulus = float(numbers["contact_modulus"])
    return [np.asarray(numbers[name]) / modulus for name in ("mean_contact_pressure", "max_pressure")]


def _metals_flow(mean: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """Return where metals would flow at these pressures over E*: in the mean, or, hardened, at the peak."""
    return (mean > materials.METALS[0]) | (largest > materials.METALS[1])


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
    pixels = number(medium.thinnest / pixel, digits=2)
    share = number(medium.thickest / max(sides), digits=2)
    if medium.thinnest < LAYER_PIXELS * pixel:
        return review(
            f"The thinnest layer ({quantity(medium.thinnest, 'm')}) is {pixels} pixels thick: the area is "
            f"corrected by the perimeter as on a half-space, which holds from {LAYER_PIXELS} pixels on.",
            advice="Use a finer map, or take the difference to the pixels counted for the error.",
        )
    if medium.thickest > max(sides):
        return review(
            f"The layers ({quantity(medium.thickest, 'm')}) are {share} times as thick as the window is "
            "long: what longer waves do to the base is left out.",
            advice="Use a larger map, or leave the base out.",
        )
    return passed(
        f"The thinnest layer is {pixels} pixels thick, all at most {share} of the window's length. Not "
        "judged with layers: theories."
    )


def local_scale(statistics: Statistics) -> Check | None:
    """Check that the rms height is below 0.05 of the approach of a form (Johnson 1985, section 13.5)."""
    if "local_contact_area" not in statistics:
        return None
    last = statistics.isel(load=int(statistics["force"].values.argmax()))
    # the least approach: under the smallest force roughness is largest against the form
    ratio = float(statistics["rms_height"] / statistics["hertz_approach"].min())
    share = float(last["local_contact_area"] / (np.pi * last["hertz_radius"] ** 2))
    force, radius = quantity(float(last["force"]), "N"), quantity(float(last["hertz_radius"]), "m")
    gap = quantity(float(last["local_mean_gap"]), "m")
    text = (
        "Each place of the smooth contact (Hertz) has the contact of this map under the nominal pressure "
        f"there: at {force}, radius {radius}, {percent(share)} of the area and a mean gap of {gap}. "
        f"Roughness has to be small against the form: its rms height is {percent(ratio)} of the least "
        "approach."
    )
    lengths = [statistics[f"window_length_{axis}"] for axis in "xy"]
    # a map as large as the contact does not see a pressure that is the same all over
    if ratio <= _ROUGHNESS_OF_FORM and np.nanmax(lengths) < 2 * statistics["hertz_radius"].min():
        return noted(text)
    return review(text, advice="Solve a map that is larger than the contact, with boundary: free.")


def units(statistics: Statistics) -> Check:
    """Check that modulus and loads are those of real materials: else a unit is likely to be wrong."""
    modulus, loads = float(statistics["contact_modulus"]), statistics["mean_pressure"].values
    # a problem in units of its own, which cannot be checked
    if modulus == 1:
        return not_made("the contact modulus is 1, so that pressures are in units of it.")
    if doubt := materials.doubt_of_modulus(modulus):
        return review(f"Contact modulus: {doubt.question().rstrip('.')}")
    if text := _friction_doubt(statistics) or _temperature_doubt(statistics):
        return review(text)
    description = f"A contact modulus of {quantity(modulus, 'Pa')}"
    # loads that nobody stated have no unit to be wrong
    if statistics.attrs.get("loads") == "planned":
        return passed(f"{description} is that of real materials; no load is stated.")
    if doubts := [doubt for load in loads if (doubt := materials.doubt_of_load(float(load), modulus))]:
        text = f"At {len(doubts)} of {loads.size} loads the mean pressure is implausible: "
        return review(text + doubts[0].question())
    low, high = (unit_of_pressures(statistics).text(float(f(loads))) for f in (np.min, np.max))
    span = low if low == high else f"{low} to {high}"
    return passed(f"{description} and loads of {span} are those of real materials.")


def _friction_doubt(statistics: Statistics) -> str:
    """Return in a sentence that friction or its warmth is that of no solid, empty if neither is."""
    for name, limit, text in (
        ("friction_coefficient", materials.MAX_FRICTION, "The coefficient of friction by the area is {}"),
        ("max_flash_temperature", materials.HOTTEST, "Sliding warms by {} K, which no solid bears"),
    ):
        if name in statistics and (largest := float(statistics[name].max())) > limit:
            return f"{text.format(number(largest))}: check the units of the friction (statistics.friction)."
    return ""


def _temperature_doubt(statistics: Statistics) -> str:
    """Return in a sentence that a named material is beyond its range of temperatures, empty if none is."""
    names = [name for name in ("max_flash_temperature", "temperature_drop") if name in statistics]
    rise = max((float(statistics[name].max()) for name in names), default=0.0)
    for name, limits in json_attribute(statistics.attrs, "temperatures").items():
        lowest, highest, stated = limits["lowest"], limits["highest"], limits.get("stated", materials.ROOM)
        # the mean temperature is taken for that of a room, where nothing else is stated
        if materials.ROOM + rise > highest:
            return (
                f"Warming by {number(rise)} K takes {name} from room temperature beyond {highest:g} °C, "
                "where its properties are others: state those at that temperature, or check the units."
            )
        # one of both scales may be meant
        if not any(lowest <= temperature <= highest for temperature in (stated, stated - 273.15)):
            return (
                f"The relaxation of {name} is stated at {stated:g}, in °C and in K beyond its range of use, "
                f"{lowest:g} to {highest:g} °C: check relaxation.temperature."
            )
    return ""


def _loads(mask: np.ndarray | xr.DataArray, statistics: Statistics) -> str:
    """Return the loads concerned, as the beginning of a sentence."""
    pressures = statistics["mean_pressure"].values
    chosen = pressures[np.asarray(mask)]
    _, lightest = load_in_words(float(chosen.min()), statistics)
    if pressures.size == 1:
        return f"At {lightest}"
    if chosen.size == pressures.size:
        return "At every load"
    return f"At {chosen.size} of {pressures.size} loads, from {lightest} on,"


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
    length, radius = (quantity(value, "m", digits=2) for value in (path, path / knudsen))
    text = (
        f"The spots conduct like round ones of a radius of {radius} at the least; electrons of a metal of "
        f"this resistivity go {length} without a collision (Knudsen number {number(knudsen, digits=2)}), "
        f"which adds up to {percent(increase)} to the resistance"
    )
    if increase < _BALLISTIC:
        return passed(f"{text}.")
    return review(f"{text} and is not in the ±.", advice="Add it.")


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
    difference, viscosity = (statistics.attrs[f"seal_{key}"] for key in ("pressure_difference", "viscosity"))
    text = f"The fluid presses with up to {quantity(difference, 'Pa')}"
    # the fluid would push the bodies apart
    if (lifts := is_lifted(statistics)).any():
        text += f", more than the bodies at {lifts.sum()} of {lifts.size} loads: it would lift them."
        return review(text, advice="State the load that presses them together while the fluid is there.")
    if "seal_outlet_pressure" in statistics.attrs:
        text += " above its outlet, less than the bodies, and expands as an ideal gas"
        return _slip(statistics, text)
    if viscosity >= _GAS:
        return passed(f"{text}, less than the bodies.")
    return review(
        f"The fluid has the viscosity of a gas, {quantity(viscosity, 'Pa s')}; the leak rate is that of an "
        "incompressible fluid.",
        ("sealing",),
        advice="State outlet pressure and mean free path of the gas (statistics.seal).",
    )


def _slip(statistics: Statistics, text: str) -> Check:
    """Return the check that the slip of a gas is known, by its mean free path over the narrowest place."""
    names = [f"critical_constriction_{axis}" for axis in "xy"]
    # where it is closed no gas flows
    narrowest = [float(statistics[name].where(statistics[name] > 0).min()) for name in names]
    if not (path := path_at_mean_pressure(statistics.attrs)):
        advice = "State its mean free path, 68 nm for air at 1 bar (statistics.seal)."
        return review(f"{text}; slip is left out, and it leaks more.", ("sealing",), advice=advice)
    if np.isnan(narrowest).all():
        return passed(f"{text}.")
    knudsen = path / np.nanmin(narrowest)
    text += f"; its Knudsen number at the narrowest place is up to {number(knudsen, digits=2)}"
    # D = sqrt(pi)/2 over the Knudsen number is the argument of the fit
    if knudsen * MIN_INVERSE_KNUDSEN <= np.sqrt(np.pi) / 2:
        return passed(f"{text}, and the leak rate includes its slip.")
    return review(f"{text}, beyond what is known of its flow; it leaks more.", ("sealing",))


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
    full = int((statistics["relative_contact_area_pixels"] == 1).sum())
    loads = statistics.sizes["load"]
    if full == loads:
        where = "Full contact at every load" if loads > 1 else "Full contact"
        return noted(f"{where}.", advice="Lower loads would show how it comes about.")
    low, high = (float(f(statistics["relative_contact_area"])) for f in (np.min, np.max))
    return passed(f"The contact covers {percent(low)} to {percent(high)} of the area.")
