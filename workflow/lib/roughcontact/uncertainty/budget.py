"""The error budget: corrections, intervals and their components for each headline quantity and answer."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.checking import check_choice, check_labelled
from roughcontact.choices import HeadlineMeasurand, UncertaintySource
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.si import in_si
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.combination import (
    COMBINED,
    SIDES,
    SOURCES,
    Components,
    added_up,
    component_from_units,
    symmetric,
)
from roughcontact.uncertainty.discretisation import CORRECTED, discretisation_error
from roughcontact.uncertainty.ensemble import Result, loads_of, measured_slices
from roughcontact.uncertainty.headline import quantities_in
from roughcontact.uncertainty.inputs import AMPLIFICATIONS, INPUTS, input_uncertainty
from roughcontact.uncertainty.instrument import instrument_components, with_source_of_correction
from roughcontact.uncertainty.intervals import Octave, interval_columns
from roughcontact.uncertainty.rejected import rejected_load_share
from roughcontact.uncertainty.sample import attributes_of, constrictions_in_grooves
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, PEAK, PRESSURE, to_scale
from roughcontact.uncertainty.subwindows import Scatter, scatter_of_subwindows
from roughcontact.uncertainty.unresolved import band_is_chosen, hidden_waves, magnification_curve, next_octave
from roughcontact.window.instrument import stated_instrument
from roughcontact.window.periodic_window import periodic_window
from roughcontact.window.transfer import undone

# settings of the contact that are uncertainties -> the input whose they are
MATERIAL_UNCERTAINTIES = {f"{name}_uncertainty": name for name in ("contact_modulus", "mean_pressure")}


@in_si
def error_budget(
    levelled: xr.DataArray,
    window: xr.DataArray,
    settings: Mapping[str, Mapping[str, Any]],
    *,
    sources: Sequence[UncertaintySource] = SOURCES,
    windows: int = 9,
    measurand: HeadlineMeasurand = "surface",
    extent: float = 3.0,
    solved: xr.Dataset | None = None,
    scatter_of: Callable[..., Scatter] = scatter_of_subwindows,
) -> xr.Dataset:
    """Return the intervals of the headline quantities and the answers, and what they are made of.

    The headline quantities are contact area, mean gap, largest and mean pressure in contact; the answers are
    conductance and narrowest places of the gap. Known biases are corrected ([1]_, 3.2.4); the sources are
    combined as the root of the sum of squares ([1]_, 5.1.2) on the scale of each quantity
    (`roughcontact.uncertainty.scales`), separately below and above. There is an interval for each of five
    measurands, all in the band of waves of the map but one:

    * the surface: the mean of what maps of this size would show all over it
    * the next map of this size, elsewhere on it
    * the surface over `extent` times the length of the map
    * the surface with waves one octave shorter
    * this map, between its own borders

    Parameters
    ----------
    levelled, window : DataArray (y, x), m
        the levelled map and its periodic window.
    settings : dict
        `level`, `window`, `contact`: the keyword arguments of `level`, `periodic_window` and `solve_contact`
        (loads included) that led to the result; `contact` may also hold `contact_modulus_uncertainty` and
        `mean_pressure_uncertainty` (relative, expanded), and `instrument` what is stated of the instrument
        (`roughcontact.uncertainty.instrument`).
    sources : list of str
        `solver` (error bound), `discretisation` (finer pixels), `window` (scatter of subwindows, calibrated),
        `instrument` (what is stated of it; always for a window that is corrected for it), `material` (modulus
        and load), `unresolved` (waves that it hides, and the next octave). An empty list gives no intervals.
    windows : int
        maximum number of subwindows that are solved; 4 or more.
    measurand : str
        of `_lower`, `_upper` and the half-widths: `surface`, or `longer`, which has `extent`.
    extent : float
        length of the surface of the third measurand, over that of the map; 1 or more.
    solved : Dataset, optional
        `budget_inputs` of the solution of the window; it is solved here where they are not given.
    scatter_of : callable, optional
        what the source `window` is made of, with the arguments of `scatter_of_subwindows`.

    Returns
    -------
    Dataset
        along `load`, for each quantity the ends of its intervals: `{quantity}_lower`, `_upper` (`measurand`),
        `_next_lower`, `_next_upper`, `_longer_lower`, `_longer_upper`, `_octave_lower`, `_octave_upper`,
        `_map_lower`, `_map_upper`; NaN for an upper end that nothing bounds, and for next map and longer
        surface without `window`. `{quantity}_estimate`: the corrected result, `{quantity}_as_solved` the
        result before the correction. With dims (load, source) the half-widths `{quantity}_uncertainty`,
        `source` being the six and `combined`, and `{quantity}_components`, along `component` down, up,
        shift_down and shift_up; a source that was not requested, or that this map does not allow, is NaN.
        `{quantity}_as_measured` (load): of a map that was corrected for its instrument, the result without
        that. `{quantity}_at_cutoff` (load, cutoff): the magnification curve; `{quantity}_sensitivity` (load,
        input); `{quantity}_parts` (member, load): the results of the subwindows. For any sources
        `rejected_load_share` (load). Attributes: `window_reason` describes the subwindows, `window_flag`
        their deficiency.

    Raises
    ------
    SettingsError
        for an unknown source or measurand, too few windows, or an extent below 1.
    HeightMapError
        for a map with missing points, or one that was not levelled as the window was.
    ConvergenceError
        where the solution of the window misses its tolerance.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)  # periodic, hence its own window
    >>> settings = {"window": {}, "contact": {"contact_modulus": 1.0, "mean_pressure": [0.1]}}
    >>> budget = error_budget(height, height, settings, sources=["solver"])
    >>> budget["mean_gap_uncertainty"].sel(source="combined").item() < 1e-5
    True
    """
    _check_maps(levelled, window)
    _check_choices(sources, measurand, extent)
    contact = {key: value for key, value in settings["contact"].items() if key not in MATERIAL_UNCERTAINTIES}
    # a load that does not converge gives NaN instead of ending the job
    lenient, load = {**contact, "on_failure": "flag"}, loads_of(contact)
    rejected = rejected_load_share(levelled, window=settings["window"], contact=lenient)
    columns: dict[str, tuple] = {"rejected_load_share": ("load", rejected)}
    if not (sources := with_source_of_correction(sources, window)):
        return xr.Dataset(columns, {"mean_pressure": ("load", load)})
    solved = solve_contact(window, **contact, reduce=budget_inputs) if solved is None else solved
    as_solved = {name: solved[name].values for name in quantities_in(solved)}
    result = Result(window, lenient, {name: as_solved[name] for name in as_solved if name != PRESSURE})
    middle = {name: to_scale(name, value) for name, value in result.values.items()}
    components: dict[UncertaintySource, Components] = {}
    scatter: Scatter | None = None
    octave: Octave | None = None
    attrs: dict[str, Any] = {}
    if "solver" in sources:
        components["solver"] = _of_solver(solved)
    if "discretisation" in sources:
        correction, components["discretisation"] = discretisation_error(
            result,
            pixel_share=load / as_solved[PRESSURE],
            peak_index=_index_of_the_peak(solved, result.hardness),
        )
        middle = {name: centre + correction[name] for name, centre in middle.items()}
    if "window" in sources:
        scatter = scatter_of(result, levelled, arguments=settings["window"], number=windows)
        middle |= {name: middle[name] + offset for name, offset in scatter.shift.items()}
        grooves = constrictions_in_grooves(window) if CONSTRICTIONS[0] in middle else []
        scatter = scatter._replace(open_ended={key: solved[f"{key}_half_way"].values > 0 for key in grooves})
        attrs = attributes_of(scatter, levelled, extent if measurand == "longer" else None)
        columns |= _columns_of_members(result, scatter)
    instrument = stated_instrument(levelled, settings.get("instrument"))
    of_material = {key: settings["contact"].get(name) for name, key in MATERIAL_UNCERTAINTIES.items()}
    stated = (of_material if "material" in sources else {}) | (instrument if "instrument" in sources else {})
    sensitivities, of_inputs = input_uncertainty(result, solved, stated)
    columns |= {f"{name}_sensitivity": (("load", "input"), slopes) for name, slopes in sensitivities.items()}
    true_shapes = undone(window, instrument) if {"instrument", "unresolved"} & {*sources} else {}
    if "material" in sources:
        components["material"] = _summed(of_inputs[key] for key in of_material)
    if "instrument" in sources:
        as_measured = (
            periodic_window(levelled, **{**settings["window"], "correct_for": None})
            if "corrected_for" in window.attrs
            else None
        )
        causes, uncorrected = instrument_components(result, instrument, as_measured, true_shapes)
        components["instrument"] = _summed([*causes, *(of_inputs[key] for key in AMPLIFICATIONS)])
        columns |= {f"{name}_as_measured": ("load", value) for name, value in uncorrected.items()}
    if "unresolved" in sources:
        curve = magnification_curve(result)
        columns |= curve
        octave = {}
        if not band_is_chosen(settings, window):
            components["unresolved"] = hidden_waves(window, curve, instrument, true_shapes)
            octave = next_octave(window, curve, instrument.get("finer_spectrum"))
    columns |= interval_columns(
        result,
        as_solved,
        middle,
        components,
        scatter=scatter,
        octave=octave,
        measurand=measurand,
        extent=extent,
    )
    labels = {"source": [*SOURCES, COMBINED], "component": [*SIDES], "input": [*INPUTS]}
    return xr.Dataset(columns, {"mean_pressure": ("load", load), **labels}, attrs)


def _check_maps(levelled: xr.DataArray, window: xr.DataArray) -> None:
    """Refuse a map that `level` has not returned, or of which the window is not a part."""
    wrong = ""
    for height in (levelled, window):
        check_labelled(height)
    if missing := int(levelled.isel(measured_slices(levelled, window)).isnull().sum()):
        wrong = f"the levelled map has {missing} missing points where the window lies"
    elif "form" in window.attrs and "form" not in levelled.attrs:
        wrong = "the window is of a levelled map, and this map was not levelled"
    if wrong:
        raise HeightMapError(
            f"error_budget: {wrong}: pass the map that level returned, of which the window is a part"
        )


def _check_choices(sources: Sequence[UncertaintySource], measurand: HeadlineMeasurand, extent: float) -> None:
    """Refuse an unknown source or measurand, and an extent below 1."""
    check_choice("uncertainty.measurand", measurand, HeadlineMeasurand)
    for source in sources:
        check_choice("uncertainty.sources", source, UncertaintySource)
    if not extent >= 1:
        raise SettingsError(f"extent = {extent!r}: give a number of 1 or more")


def _columns_of_members(result: Result, scatter: Scatter) -> dict[str, tuple]:
    """Return `{quantity}_parts` (member, load), NaN but at the loads that are solved."""
    columns: dict[str, tuple] = {}
    pressure = result.load[result.few] / scatter.members[AREA]
    for name, results in {**scatter.members, PRESSURE: pressure}.items():
        at_loads = np.full((len(results), result.load.size), np.nan)
        at_loads[:, result.few] = results
        columns[f"{name}_parts"] = ("member", "load"), at_loads
    return columns


def _index_of_the_peak(solved: xr.Dataset, hardness: float) -> int:
    """Return the point of the highest pressure, row by row, under the heaviest load without plastic flow."""
    load = solved["mean_pressure"].values
    # points that flow share the hardness: where they do under all loads, the lightest has the fewest
    heaviest = np.where(solved[PEAK].values < hardness, load, -load).argmax()
    return int(solved["index_of_the_peak"].values[heaviest])


def _of_solver(solved: xr.Dataset) -> Components:
    """Return the components of the solver, whose half-widths are in the unit of each quantity."""
    widths = {name: symmetric(solved[f"{name}_uncertainty"].values) for name in CORRECTED}
    return {name: component_from_units(name, solved[name].values, width) for name, width in widths.items()}


def _summed(causes: Iterable[Components]) -> Components:
    """Return the components of independent causes of one source, added up."""
    causes = list(causes)
    names = {name for cause in causes for name in cause}
    return {name: added_up(cause[name] for cause in causes if name in cause) for name in names}
