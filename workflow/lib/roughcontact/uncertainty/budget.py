"""The error budget: uncertainty of each headline quantity, by source and combined."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.checking import check_choice
from roughcontact.choices import UncertaintySource
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import HeightMapError
from roughcontact.si import in_si
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.uncertainty.answers import (
    ANSWERS,
    answers_of,
    half_length_constrictions,
    quantities_in,
)
from roughcontact.uncertainty.combination import SOURCES, combine
from roughcontact.uncertainty.discretisation import discretisation_uncertainty, resolution_indicators
from roughcontact.uncertainty.headline import QUANTITIES
from roughcontact.uncertainty.inputs import AMPLIFICATIONS, STIFFNESS, input_uncertainty
from roughcontact.uncertainty.instrument import added_up, instrument_uncertainty
from roughcontact.uncertainty.magnification import magnification_curve
from roughcontact.uncertainty.processing import processing_uncertainty
from roughcontact.uncertainty.rejected import rejected_load_share
from roughcontact.uncertainty.solver import solver_uncertainty
from roughcontact.uncertainty.unresolved import waves_not_resolved
from roughcontact.uncertainty.window_sampling import window_uncertainty
from roughcontact.window.instrument import stated_instrument
from roughcontact.window.periodic_window import periodic_window
from roughcontact.window.transfer import undone

# endings of the variables that hold the results of ensemble members
_ENSEMBLES: dict[UncertaintySource, str] = {"window": "parts", "processing": "choices"}
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
    extent: float = 3.0,
    solved: xr.Dataset | None = None,
) -> xr.Dataset:
    """Return the uncertainty of the headline quantities and the answers, by source and combined.

    The headline quantities are contact area, mean gap, largest and mean pressure in contact; the answers are
    conductance and critical constrictions of the gap (`roughcontact.uncertainty.answers`).

    The interval is for the surface over `extent` times the length of the map, under the same mean pressure.
    Sources: `solver` (error bound), `discretisation` (pixels half as large), `window` (ensemble of subwindows
    and growth of the heights with the length), `processing` (alternative ways to level, fill and make
    periodic), `instrument` (what is stated of it), `material` (contact modulus and load), `unresolved` (waves
    that the map does not show). They are independent: U² = sum of U_i² ([1]_, 5.1.2), separately below and
    above the result; known biases are added on their side (`roughcontact.uncertainty.combination`).

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
        uncertainty sources to evaluate; an empty list gives no intervals.
    windows : int
        maximum number of subwindows that are solved; 4 or more.
    extent : float
        length of the surface that the intervals are for, over that of the map; 1 or more.
    solved : Dataset, optional
        `budget_inputs` of the solution of the window; it is solved here where they are not given.

    Returns
    -------
    Dataset
        of `combine`: half-widths, their components, the ends of both intervals; a source that was not
        requested or that this map does not allow is NaN. `{quantity}_as_measured` (load): of a map that was
        corrected, the result without the correction. `{quantity}_at_cutoff` (load, cutoff): the magnification
        curve; `{quantity}_sensitivity` (load, input). Along (member, load) and (choice, load) the results of
        the members of the two ensembles,
        `{quantity}_parts` and `{quantity}_choices`. For any sources: `rejected_load_share` (load), from
        `roughcontact.uncertainty.rejected`. Attributes: `window_reason` and `processing_reason` describe the
        two ensembles, `window_flag` and `processing_flag` their deficiencies.

    Raises
    ------
    SettingsError
        for an unknown source, or too few windows.
    HeightMapError
        for a map that has not been levelled.
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
    for source in sources:
        check_choice("uncertainty.sources", source, UncertaintySource)
    if "processing" in sources and "filled" not in levelled.coords and "periodisation" in window.attrs:
        raise HeightMapError(
            "error_budget needs the map as `level` returns it, with its record of filled points: pass "
            "level(height, ...), or leave the source 'processing' out"
        )
    contact = {key: value for key, value in settings["contact"].items() if key not in MATERIAL_UNCERTAINTIES}
    stated = settings["contact"]
    coordinates = {"mean_pressure": ("load", np.atleast_1d(np.asarray(contact["mean_pressure"], float)))}
    # a load that does not converge gives NaN instead of ending the job
    lenient = {**contact, "on_failure": "flag"}
    rejected = rejected_load_share(levelled, window=settings["window"], contact=lenient)
    if not sources:
        return xr.Dataset({rejected.name: rejected}, coords=coordinates)
    if solved is None:
        solved = solve_contact(window, **contact, reduce=budget_inputs)
    # a map that is its own window has no record of a periodisation
    chosen = window if "periodisation" in window.attrs else None
    found: dict[UncertaintySource, xr.Dataset] = {
        "solver": solved[[_uncertainty(name) for name in QUANTITIES]]
    }
    found["solver"] = found["solver"].rename({_uncertainty(name): name for name in QUANTITIES})
    if "discretisation" in sources:
        found["discretisation"] = discretisation_uncertainty(window, contact=lenient, solved=solved)
    if "window" in sources:
        found["window"] = window_uncertainty(
            levelled,
            window=settings["window"],
            contact=lenient,
            solved=solved,
            number=windows,
            extent=extent,
            chosen=chosen,
        )
    if "processing" in sources:
        found["processing"] = processing_uncertainty(
            levelled,
            level=settings["level"],
            window=settings["window"],
            contact=lenient,
            solved=solved,
            chosen=chosen,
        )
    instrument = stated_instrument(levelled, settings.get("instrument"))
    scales = {key: instrument[key] for key in AMPLIFICATIONS if instrument.get(key)}
    material = {key: stated[name] for name, key in MATERIAL_UNCERTAINTIES.items() if stated.get(name)}
    propagated = (material if "material" in sources else {}) | (scales if "instrument" in sources else {})
    inputs = input_uncertainty(window, contact=lenient, solved=solved, stated=propagated)
    true_shapes = undone(window, instrument) if {"instrument", "unresolved"} & {*sources} else {}
    if "instrument" in sources:
        uncorrected = {key: value for key, value in settings["window"].items() if key != "correct_for"}
        as_corrected = "corrected_for" in window.attrs
        found["instrument"] = instrument_uncertainty(
            window,
            contact=lenient,
            solved=solved,
            instrument=instrument,
            scales=[inputs.sel(input=key, drop=True) for key in scales],
            as_measured=periodic_window(levelled, **uncorrected) if as_corrected else None,
            true_shapes=true_shapes,
        )
    if "material" in sources:
        parts = [inputs.sel(input=key, drop=True) for key in material]
        found["material"] = added_up(parts, quantities_in(solved), solved)
    curve = magnification_curve(window, contact=lenient, solved=solved) if "unresolved" in sources else None
    if curve is not None:
        found["unresolved"] = waves_not_resolved(window, curve, solved, settings, instrument, true_shapes)
    found = {source: found[source] for source in SOURCES if source in sources}
    budget = (
        combine(found, solved, hardness=contact.get("hardness"))
        .assign_coords(coordinates)
        .assign({rejected.name: rejected})
        .merge(inputs[[f"{name}_sensitivity" for name in quantities_in(solved)]])
    )
    if curve is not None:
        budget = budget.merge(curve.drop_vars("mean_pressure", errors="ignore"))
    budget = budget.merge(_as_measured(found.get("instrument", xr.Dataset())))
    return _with_members(budget, found)


def _with_members(budget: xr.Dataset, found: Mapping[UncertaintySource, xr.Dataset]) -> xr.Dataset:
    """Return the budget with the results of the two ensembles' members, and what is said of them."""
    for source, ending in _ENSEMBLES.items():
        if source not in found:
            continue
        names = {f"{name}_members": f"{name}_{ending}" for name in (*QUANTITIES, *ANSWERS)}
        kept = found[source][list(names)].rename(names)
        budget = budget.merge(kept.drop_vars("mean_pressure"))
        said = found[source].attrs
        budget.attrs |= {f"{source}_{key}": said[key] for key in ("reason", "flag") if key in said}
    return budget


def _as_measured(instrument: xr.Dataset) -> xr.Dataset:
    """Return the results of a corrected map without the correction, where there is one."""
    return instrument[[name for name in instrument if str(name).endswith("_as_measured")]]


def budget_inputs(contact: xr.Dataset, statistics: xr.Dataset | None = None) -> xr.Dataset:
    """Return what the error budget takes from a solution, so that its fields need not be kept.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.
    statistics : Dataset, optional
        `contact_statistics` of the same loads, computed here where they are not given.

    Returns
    -------
    Dataset
        dim load: `QUANTITIES` and `ANSWERS`, resolution indicators, constrictions of paths half as long as
        the map, `loading_stiffness`, and `{quantity}_uncertainty` of the solver.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> contact = solve_contact(height, contact_modulus=1.0, mean_pressure=[0.1])
    >>> budget_inputs(contact)["relative_contact_area"].round(2).values
    array([0.34])
    """
    if statistics is None:
        statistics = contact_statistics(contact, flow="never", stress="never")
    loading = statistics[STIFFNESS if STIFFNESS in statistics else "contact_stiffness"]
    of_solver = solver_uncertainty(contact, energy=statistics["elastic_energy"].values)
    return (
        resolution_indicators(contact)
        .assign(answers_of(contact, statistics))
        .merge(half_length_constrictions(contact))
        .merge(of_solver.rename({name: _uncertainty(name) for name in QUANTITIES}))
        .assign_coords(mean_pressure=contact["mean_pressure"].variable)
        .assign({STIFFNESS: loading.variable})
        .assign(contact_modulus=contact["contact_modulus"].variable)
        .assign_attrs(contact.attrs)
    )


def _uncertainty(name: str) -> str:
    """Return the name of the uncertainty of a quantity."""
    return f"{name}_uncertainty"
