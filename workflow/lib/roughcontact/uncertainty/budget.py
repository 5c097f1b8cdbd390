"""The error budget: corrections, intervals and their components for each headline quantity and answer."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import xarray as xr

from roughcontact.arguments.checking import check_labelled
from roughcontact.arguments.choices import UncertaintySource, check_choice
from roughcontact.arguments.ranges import ends, name_of_range
from roughcontact.arguments.si import as_si
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import HeightMapError
from roughcontact.surface.window.instrument import stated_instrument
from roughcontact.surface.window.periodic_window import periodic_window
from roughcontact.surface.window.transfer import undone
from roughcontact.uncertainty import inputs
from roughcontact.uncertainty.budget_inputs import budget_inputs, solver_components
from roughcontact.uncertainty.combination import COMBINED, SIDES, SOURCES, Components, sum_of_causes
from roughcontact.uncertainty.discretisation import Refinement, discretisation_error, periodic_interpolant
from roughcontact.uncertainty.ensemble import Result, loads_of, measured_slices, rejected_load_share
from roughcontact.uncertainty.intervals import add_pressure, area_for_the_load, interval_columns
from roughcontact.uncertainty.scales import AREA, PRESSURE, headline_names, to_scale
from roughcontact.uncertainty.subwindows import Scatter, sample_attributes, scatter_of_subwindows
from roughcontact.uncertainty.unresolved import band_is_chosen, hidden_waves, magnification_curve, next_octave

# input of the contact that may be uncertain -> the source that it is a part of
OF_MATERIAL: dict[str, UncertaintySource] = {
    "contact_modulus": "material",
    "mean_pressure": "material",
    inputs.HARDNESS: "hardness",
}
MATERIAL_UNCERTAINTIES = {name_of_range(name): name for name in OF_MATERIAL}
_LABELS: dict[str, Any] = {"source": [*SOURCES, COMBINED], "component": [*SIDES], "input": [*inputs.INPUTS]}


@as_si
def error_budget(
    levelled: xr.DataArray,
    window: xr.DataArray,
    settings: Mapping[str, Mapping[str, Any]],
    *,
    sources: Sequence[UncertaintySource] = SOURCES,
    windows: int = 9,
    solved: xr.Dataset | None = None,
    scatter_of: Callable[..., Scatter] = scatter_of_subwindows,
    refine: Refinement = periodic_interpolant,
) -> xr.Dataset:
    """Return the intervals of the headline quantities and the answers, and what they are made of.

    The headline quantities are contact area, mean gap, largest and mean pressure in contact; the answers are
    conductance and narrowest places of the gap. Known biases are corrected ([1]_, 3.2.4); the sources are
    combined as the root of the sum of squares ([1]_, 5.1.2) on the scale of each quantity
    (`roughcontact.uncertainty.scales`), separately below and above. There is an interval for each of four
    measurands, all in the band of waves of the map but one:

    * the surface: the mean of what maps of this size would show all over it
    * the next map of this size, elsewhere on it
    * the surface with waves one octave shorter
    * this map, between its own borders

    Parameters
    ----------
    levelled, window : DataArray (y, x), m
        the levelled map and its periodic window.
    settings : dict
        `level`, `window`, `contact`: the keyword arguments of `level`, `periodic_window` and `solve_contact`
        (loads included) that led to the result; `contact` may also hold `contact_modulus_uncertainty`,
        `mean_pressure_uncertainty` and `hardness_uncertainty` (relative, expanded; of the hardness one
        number, or one below and one above), and `instrument` what is stated of the instrument
        (`roughcontact.uncertainty.inputs`).
    sources : list of str
        `solver` (error bound), `discretisation` (finer pixels), `window` (scatter of subwindows, calibrated),
        `instrument` (what is stated of it; always for a window that is corrected for it), `material` (modulus
        and load), `hardness` (its range, where points flow), `unresolved` (waves that it hides, and the next
        octave). An empty list gives no intervals.
    windows : int
        maximum number of subwindows that are solved; 4 or more.
    solved : Dataset, optional
        `budget_inputs` of the solution of the window; it is solved here where they are not given.
    scatter_of : callable, optional
        what the source `window` is made of, with the arguments of `scatter_of_subwindows`.
    refine : callable, optional
        what the source `discretisation` solves: window -> a part of it, and the same on pixels half as large.

    Returns
    -------
    Dataset
        along `load`, for each quantity the ends of its intervals: `{quantity}_lower`, `_upper` (the surface),
        `_next_lower`, `_next_upper`, `_octave_lower`, `_octave_upper`, `_map_lower`, `_map_upper`; NaN for an
        upper end that nothing bounds, and for the next map without `window`. `{quantity}_estimate`: the
        corrected result, `{quantity}_as_solved` the result before the correction. With dims (load, source)
        the half-widths `{quantity}_uncertainty`, `source` being the seven and `combined`, and
        `{quantity}_components`, along `component` down, up, shift_down and shift_up; a source that was not
        requested, or that this map does not allow, is NaN. `{quantity}_as_measured` (load): of a map that was
        corrected for its instrument, the result without that. `{quantity}_at_cutoff` (load, cutoff): the
        magnification curve; `{quantity}_sensitivity` (load, input); `{quantity}_parts` (member, load): the
        results of the subwindows. For any sources `rejected_load_share` (load). Attributes: `window_reason`
        describes the subwindows, `window_flag` their deficiency, at its end `window_advice`.

    Raises
    ------
    SettingsError
        for an unknown source, or too few windows.
    HeightMapError
        for a map with missing points, or one that was not levelled as the window was.
    ConvergenceError
        where the solution of the window misses its tolerance.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)  # periodic, hence its own window
    >>> settings = {"window": {}, "contact": {"contact_modulus": 1.0, "mean_pressure": [0.1]}}
    >>> budget = error_budget(height, height, settings, sources=["solver"])
    >>> budget["mean_gap_uncertainty"].sel(source="combined").item() < 1e-5
    True
    """
    _check(levelled, window, sources)
    contact = {key: value for key, value in settings["contact"].items() if key not in MATERIAL_UNCERTAINTIES}
    # a load that does not converge gives NaN instead of ending the job
    lenient, load = {**contact, "on_failure": "flag"}, loads_of(contact)
    rejected = rejected_load_share(levelled, window=settings["window"], contact=lenient)
    columns: dict[str, tuple] = {"rejected_load_share": ("load", rejected)}
    if not (sources := inputs.add_correction_source(sources, window)):
        return xr.Dataset(columns, {"mean_pressure": ("load", load)})
    solved = solve_contact(window, **contact, reduce=budget_inputs) if solved is None else solved
    as_solved = {name: solved[name].values for name in headline_names(solved)}
    result = Result(window, lenient, {name: as_solved[name] for name in as_solved if name != PRESSURE})
    middle = {name: to_scale(name, value) for name, value in result.values.items()}
    components: dict[UncertaintySource, Components] = {}
    scatter: Scatter | None = None
    octave: Components | None = None
    attrs: dict[str, Any] = {}
    if "solver" in sources:
        components["solver"] = solver_components(solved)
    if "discretisation" in sources:
        correction, components["discretisation"] = discretisation_error(
            result, pixel_share=load / as_solved[PRESSURE], refine=refine
        )
        middle = {name: centre + correction[name] for name, centre in middle.items()}
    if "window" in sources:
        half_ways = {name: f"{name}_half_way" for name in middle if f"{name}_half_way" in solved}
        scatter = scatter_of(result, levelled, arguments=settings["window"], number=windows)._replace(
            open_ended={name: solved[level].values > 0 for name, level in half_ways.items()}
        )
        middle |= {name: middle[name] + offset for name, offset in scatter.shift.items()}
        attrs = sample_attributes(scatter, levelled, aspect=float(solved["Str"]))
        members = {**scatter.members, PRESSURE: load / scatter.members[AREA]}
        columns |= {f"{name}_parts": (("member", "load"), numbers) for name, numbers in members.items()}
    instrument = stated_instrument(levelled, settings.get("instrument"))
    uncertain = {key: source for key, source in OF_MATERIAL.items() if source in sources}
    ranges = {key: settings["contact"].get(name_of_range(key)) for key in uncertain}
    ranges |= instrument if "instrument" in sources else {}
    hardness = ends(result.hardness, ranges.get(inputs.HARDNESS))
    sensitivities, of_inputs = inputs.input_uncertainty(result, solved, ranges)
    columns |= {f"{name}_sensitivity": (("load", "input"), slopes) for name, slopes in sensitivities.items()}
    if hardness[0] < hardness[1]:
        columns |= {"hardness_lower": ((), hardness[0]), "hardness_upper": ((), hardness[1])}
    true_shapes = undone(window, instrument) if {"instrument", "unresolved"} & {*sources} else {}
    for source in dict.fromkeys(uncertain.values()):
        components[source] = sum_of_causes(of_inputs[key] for key in uncertain if uncertain[key] == source)
    if "instrument" in sources:
        as_measured = _before_correction(levelled, window, settings["window"])
        causes, uncorrected = inputs.instrument_components(result, instrument, as_measured, true_shapes)
        # amplifications have components of the pressure in contact of their own
        causes = [add_pressure(sum_of_causes(causes), area_for_the_load(result, middle))]
        components["instrument"] = sum_of_causes(causes + [of_inputs[key] for key in inputs.AMPLIFICATIONS])
        columns |= {f"{name}_as_measured": ("load", value) for name, value in uncorrected.items()}
    if "unresolved" in sources:
        columns |= (curve := magnification_curve(result))
        is_chosen = band_is_chosen(settings, window)
        octave = {} if is_chosen else next_octave(curve)
        components["unresolved"] = {} if is_chosen else hidden_waves(window, curve, instrument, true_shapes)
    columns |= interval_columns(result, as_solved, middle, components, scatter, octave, hardness[1])
    return xr.Dataset(columns, {"mean_pressure": ("load", load)} | _LABELS, attrs)


def _check(levelled_map: xr.DataArray, window: xr.DataArray, sources: Sequence[UncertaintySource]) -> None:
    """Refuse unknown sources, and a map that `level` has not returned, or whose part the window is not."""
    for source in sources:
        check_choice("uncertainty.sources", source, UncertaintySource)
    for height in (levelled_map, window):
        check_labelled(height)
    wrong = ""
    if "form" in window.attrs and "form" not in levelled_map.attrs:
        wrong = "the window is of a levelled map, and this map was not levelled"
    if missing := int(levelled_map.isel(measured_slices(levelled_map, window)).isnull().sum()):
        wrong = f"the levelled map has {missing} missing points where the window lies"
    if wrong:
        raise HeightMapError(
            f"error_budget: {wrong}: pass the map that level returned, of which the window is a part"
        )


def _before_correction(
    levelled: xr.DataArray, window: xr.DataArray, arguments: Mapping[str, Any]
) -> xr.DataArray | None:
    """Return the window without the correction for its instrument; None without one."""
    is_corrected = "corrected_for" in window.attrs
    return periodic_window(levelled, **{**arguments, "correct_for": None}) if is_corrected else None
