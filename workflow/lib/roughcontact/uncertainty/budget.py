"""The error budget: corrections, intervals and their components for each headline quantity and answer."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.checking import check_choice
from roughcontact.choices import HeadlineMeasurand, UncertaintySource
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import SettingsError
from roughcontact.maps import spacing
from roughcontact.si import in_si
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.combination import (
    SOURCES,
    Component,
    Components,
    component,
    component_from_units,
    labels,
)
from roughcontact.uncertainty.discretisation import CORRECTED, discretisation_error
from roughcontact.uncertainty.headline import quantities_in
from roughcontact.uncertainty.inputs import AMPLIFICATIONS, input_uncertainty
from roughcontact.uncertainty.instrument import added_up, instrument_components
from roughcontact.uncertainty.intervals import Intervals, Octave
from roughcontact.uncertainty.magnification import magnification_curve
from roughcontact.uncertainty.rejected import rejected_load_share
from roughcontact.uncertainty.sample import constrictions_in_grooves, deficiency, description
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, PRESSURE, QUANTITIES, to_scale
from roughcontact.uncertainty.subwindows import scatter_of_subwindows
from roughcontact.uncertainty.unresolved import band_is_chosen, hidden_waves, next_octave
from roughcontact.window.instrument import stated_instrument
from roughcontact.window.periodic_window import periodic_window
from roughcontact.window.transfer import undone

# settings of the contact that are uncertainties -> the input whose they are
MATERIAL_UNCERTAINTIES = {
    "contact_modulus_uncertainty": "contact_modulus",
    "mean_pressure_uncertainty": "mean_pressure",
}


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
        `instrument` (what is stated of it), `material` (contact modulus and load), `unresolved` (waves that
        the instrument hides, and the next octave). An empty list gives no intervals.
    windows : int
        maximum number of subwindows that are solved; 4 or more.
    measurand : str
        of `_lower`, `_upper` and the half-widths: `surface`, or `longer`, which has `extent`.
    extent : float
        length of the surface of the third measurand, over that of the map; 1 or more.
    solved : Dataset, optional
        `budget_inputs` of the solution of the window; it is solved here where they are not given.

    Returns
    -------
    Dataset
        along `load`, for each quantity the ends of its intervals: `{quantity}_lower`, `_upper` (`measurand`),
        `_next_lower`, `_next_upper`, `_longer_lower`, `_longer_upper`, `_octave_lower`, `_octave_upper`,
        `_map_lower`, `_map_upper`; NaN for an upper end that nothing bounds. `{quantity}_estimate`: the
        corrected result, `{quantity}_as_solved` the result before the correction. With dims (load, source)
        the half-widths `{quantity}_uncertainty`, `source` being the six and `combined`, and
        `{quantity}_components`, along `component` down, up, shift_down and shift_up; a source that was not
        requested, or that this map does not allow, is NaN. `{quantity}_as_measured` (load): of a map that was
        corrected for its instrument, the result without that. `{quantity}_at_cutoff` (load, cutoff): the
        magnification curve; `{quantity}_sensitivity` (load, input); `{quantity}_parts` (member, load): the
        results of the subwindows. For any sources `rejected_load_share` (load). Attributes: `window_reason`
        describes the subwindows, `window_flag` their deficiency.

    Raises
    ------
    SettingsError
        for an unknown source or measurand, too few windows, or an extent below 1.
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
    _check_arguments(sources, measurand, extent)
    stated = settings["contact"]
    contact = {key: value for key, value in stated.items() if key not in MATERIAL_UNCERTAINTIES}
    load = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    # a load that does not converge gives NaN instead of ending the job
    lenient = {**contact, "on_failure": "flag"}
    rejected = rejected_load_share(levelled, window=settings["window"], contact=lenient)
    if not sources:
        return xr.Dataset({rejected.name: rejected}, coords={"mean_pressure": ("load", load)})
    if solved is None:
        solved = solve_contact(window, **contact, reduce=budget_inputs)
    as_solved = {name: solved[name].values for name in quantities_in(solved)}
    values = {name: value for name, value in as_solved.items() if name != PRESSURE}
    middle = {name: to_scale(name, value) for name, value in values.items()}
    found: dict[UncertaintySource, Components] = {}
    columns: dict[str, tuple] = {}
    scatter, open_ended, attrs = None, {}, {}
    if "solver" in sources:
        found["solver"] = _of_solver(solved)
    if "discretisation" in sources:
        errors = discretisation_error(
            window,
            contact=lenient,
            values=values,
            pixel_share=load / as_solved[PRESSURE],
            peak_index=int(solved["index_of_the_peak"].values[-1]),
        )
        found["discretisation"] = {name: component(width, width) for name, (_, width) in errors.items()}
        middle |= {name: middle[name] + errors[name][0] for name in CORRECTED}
    if "window" in sources:
        scatter = scatter_of_subwindows(
            levelled,
            window,
            contact=lenient,
            arguments=settings["window"],
            values=values,
            number=windows,
        )
        grooves = constrictions_in_grooves(window) if CONSTRICTIONS[0] in values else []
        open_ended = {name: solved[f"{name}_half_way"].values > 0 for name in grooves}
        attrs = {
            "window_reason": description(
                levelled, scatter, grooves, extent if measurand == "longer" else None
            ),
            "window_flag": deficiency(levelled, scatter),
        }
        members = scatter.members | {PRESSURE: load / scatter.members[AREA]}
        columns |= {f"{name}_parts": (("member", "load"), v) for name, v in members.items()}
    instrument = stated_instrument(levelled, settings.get("instrument"))
    inputs = _stated_inputs(window, lenient, solved, sources, stated, instrument)
    columns |= {
        str(name): (("load", "input"), inputs[name].values)
        for name in inputs
        if str(name).endswith("_sensitivity")
    }
    of_inputs = {key: _of_input(inputs.sel(input=key), as_solved) for key in inputs["input"].values}
    if "material" in sources:
        found["material"] = added_up(of_inputs[key] for key in MATERIAL_UNCERTAINTIES.values())
    true_shapes = undone(window, instrument) if {"instrument", "unresolved"} & {*sources} else {}
    if "instrument" in sources:
        causes, before = instrument_components(
            window,
            contact=lenient,
            values=values,
            instrument=instrument,
            as_measured=_without_correction(levelled, window, settings["window"]),
            true_shapes=true_shapes,
        )
        found["instrument"] = added_up([*causes, *(of_inputs[key] for key in AMPLIFICATIONS)])
        before |= {PRESSURE: load / before[AREA]} if before else {}
        columns |= {f"{name}_as_measured": ("load", value) for name, value in before.items()}
    octave: Octave = {}
    if "unresolved" in sources:
        curve = magnification_curve(window, contact=lenient, solved=solved)
        columns |= {
            str(name): (v.dims, v.values) for name, v in curve.variables.items() if "cutoff" in v.dims
        }
        if not band_is_chosen(settings, 2 * max(spacing(window))):
            found["unresolved"] = hidden_waves(window, curve, instrument, true_shapes)
            octave = next_octave(window, curve, instrument.get("finer_spectrum"))
    intervals = Intervals(
        found, scatter, octave, open_ended, load, extent, contact.get("hardness"), measurand
    )
    for name in as_solved:
        columns |= intervals.columns(name, as_solved, middle)
    return xr.Dataset(
        columns | {str(rejected.name): ("load", rejected.values)},
        coords={"mean_pressure": ("load", load), **labels(), "input": list(inputs["input"].values)},
        attrs=attrs,
    )


def _check_arguments(
    sources: Sequence[UncertaintySource], measurand: HeadlineMeasurand, extent: float
) -> None:
    """Raise a SettingsError for an unknown source or measurand, or an extent below 1."""
    check_choice("uncertainty.measurand", measurand, HeadlineMeasurand)
    for source in sources:
        check_choice("uncertainty.sources", source, UncertaintySource)
    if not extent >= 1:
        raise SettingsError(f"extent = {extent!r}: give a number of 1 or more")


def _without_correction(
    levelled: xr.DataArray, window: xr.DataArray, arguments: Mapping[str, Any]
) -> xr.DataArray | None:
    """Return the window as measured of a map that was corrected for its instrument, else None."""
    if "corrected_for" not in window.attrs:
        return None
    return periodic_window(levelled, **{key: v for key, v in arguments.items() if key != "correct_for"})


def _stated_inputs(
    window: xr.DataArray,
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    sources: Sequence[UncertaintySource],
    stated: Mapping[str, Any],
    instrument: Mapping[str, Any],
) -> xr.Dataset:
    """Return `input_uncertainty` of load, modulus and scales, as far as the sources ask for them."""
    material = {key: stated[name] for name, key in MATERIAL_UNCERTAINTIES.items() if stated.get(name)}
    scales = {key: instrument[key] for key in AMPLIFICATIONS if instrument.get(key)}
    propagated = (material if "material" in sources else {}) | (scales if "instrument" in sources else {})
    return input_uncertainty(window, contact=contact, solved=solved, stated=propagated)


def _of_solver(solved: xr.Dataset) -> dict[str, Component]:
    """Return the components of the solver, whose half-widths are in the unit of each quantity."""
    found = {}
    for name in QUANTITIES:
        width = solved[f"{name}_uncertainty"].values
        found[name] = component_from_units(name, solved[name].values, {"down": width, "up": width})
    return found


def _of_input(inputs: xr.Dataset, values: Mapping[str, np.ndarray]) -> dict[str, Component]:
    """Return the components of one stated input; empty for one that is not stated."""
    found = {}
    for name, value in values.items():
        ends = {side: inputs[f"{name}_{side}"].values for side in ("down", "up")}
        if not np.isnan(ends["up"]).all():
            found[name] = component_from_units(name, value, ends)
    return found
