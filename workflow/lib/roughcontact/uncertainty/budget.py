"""The error budget: uncertainty of each headline quantity, by source and combined."""

import json
from collections.abc import Mapping, Sequence
from typing import Any, get_args

import numpy as np
import xarray as xr

from roughcontact.checking import check_choice
from roughcontact.choices import UncertaintySource
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import HeightMapError
from roughcontact.io.read import read_height_map
from roughcontact.levelling.level import level
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.uncertainty.answers import (
    ANSWERS,
    answers_present,
    half_length_constrictions,
    headline_and_answers,
)
from roughcontact.uncertainty.discretisation import discretisation_uncertainty, resolution_indicators
from roughcontact.uncertainty.headline import QUANTITIES
from roughcontact.uncertainty.instrument import instrument_uncertainty
from roughcontact.uncertainty.magnification import magnification_curve
from roughcontact.uncertainty.processing import processing_uncertainty
from roughcontact.uncertainty.rejected import rejected_load_share
from roughcontact.uncertainty.scaling import scaling_uncertainty
from roughcontact.uncertainty.solver import solver_uncertainty
from roughcontact.uncertainty.transfer import eroded, reliability_length, restored, shortest_transmitted
from roughcontact.uncertainty.unresolved import (
    Growth,
    expected_growth,
    growth_by_finer_spectrum,
    unresolved_uncertainty,
)
from roughcontact.uncertainty.window_sampling import window_uncertainty

SOURCES: tuple[UncertaintySource, ...] = get_args(UncertaintySource)
COMBINED = "combined"
# endings of the variables that hold the results of ensemble members
_ENSEMBLES: dict[UncertaintySource, str] = {"window": "parts", "processing": "choices"}
# sources of the interval of this map in the band of waves that it holds
_OF_THE_MAP: tuple[UncertaintySource, ...] = (
    "solver",
    "discretisation",
    "processing",
    "instrument",
    "material",
)
# settings of the contact that are uncertainties -> the input whose they are
MATERIAL_UNCERTAINTIES = {
    "contact_modulus_uncertainty": "contact_modulus",
    "mean_pressure_uncertainty": "mean_pressure",
}
_CHOSEN_BAND = (
    2.0  # shortest wave that the settings keep, over two pixels, from which on it defines the result
)
INSTRUMENT = (
    "noise",
    "resolution",
    "numerical_aperture",
    "wavelength",
    "tip_radius",
    "amplification_z",
    "amplification_xy",
    "finer_spectrum",
)
_COMMENT = (
    "half-widths of 95 % intervals, in the unit of the quantity; the larger one where an interval is "
    "asymmetric; combined: root of the sum of squares of the sources given (for the pressure in contact the "
    "known bias of whole pixels is added linearly); NaN: not requested, not available from this map, or not "
    "bounded above by it"
)
_ENDS = {
    "lower": "lower end of the 95 % interval, all sources combined",
    "upper": "upper end of the 95 % interval, all sources combined; NaN beside a lower end: not bounded",
    "map_lower": "lower end of the 95 % interval of this map, for the waves that it holds",
    "map_upper": "upper end of the 95 % interval of this map, for the waves that it holds; NaN: not bounded",
}


def error_budget(
    levelled: xr.DataArray,
    window: xr.DataArray,
    settings: Mapping[str, Mapping[str, Any]],
    *,
    sources: Sequence[UncertaintySource] = SOURCES,
    windows: int = 9,
    extent: float = 3.0,
) -> xr.Dataset:
    """Return the uncertainty of the headline quantities and the answers, by source and combined.

    The headline quantities are contact area, mean gap, largest and mean pressure in contact; the answers are
    conductance and critical constrictions of the gap (`roughcontact.uncertainty.answers`).

    The interval is for the surface over `extent` times the length of the map, under the same mean pressure.
    Sources: `solver` (error bound), `discretisation` (pixels half as large), `window` (ensemble of subwindows
    and growth of the heights with the length), `processing` (alternative ways to level, fill and make
    periodic). They are independent: U² = sum of U_i² ([1]_, 5.1.2), separately below and above the result.

    Parameters
    ----------
    levelled, window : DataArray (y, x), m
        the levelled map and its periodic window.
    settings : dict
        `level`, `window`, `contact`: the keyword arguments of `level`, `periodic_window` and `solve_contact`
        (loads included) that led to the result.
    sources : list of str
        uncertainty sources to evaluate; an empty list gives no intervals.
    windows : int
        maximum number of subwindows that are solved; 4 or more.
    extent : float
        length of the surface that the intervals are for, over that of the map; 1 or more.

    Returns
    -------
    Dataset
        dims (load, source): `{quantity}_uncertainty`, the half-width of the 95 % interval in the unit of the
        quantity (the larger one of both sides), `source` being the four and `combined`; NaN for a source that
        was not requested or that this map does not allow. Along `load` the ends of the combined interval,
        `{quantity}_lower` and `{quantity}_upper`. Along (member, load) and (choice, load) the results of the
        members of the two ensembles, `{quantity}_parts` and `{quantity}_choices`. For any sources:
        `rejected_load_share` (load), from `roughcontact.uncertainty.rejected`. Attributes: `window_reason`
        and `processing_reason` describe the two ensembles, `window_flag` and `processing_flag` their
        deficiencies.

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
    material = {key: settings["contact"].get(name) for name, key in MATERIAL_UNCERTAINTIES.items()}
    coordinates = {"mean_pressure": ("load", np.asarray(contact["mean_pressure"], float))}
    # a load that does not converge gives NaN instead of ending the job
    lenient = {**contact, "on_failure": "flag"}
    rejected = rejected_load_share(levelled, window=settings["window"], contact=lenient)
    if not sources:
        return xr.Dataset({rejected.name: rejected}, coords=coordinates)
    solved = solve_contact(window, **contact, reduce=_count)
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
    if "instrument" in sources:
        found["instrument"] = instrument_uncertainty(
            window,
            contact=lenient,
            solved=solved,
            instrument=instrument,
            s_filter=settings.get("level", {}).get("s_filter"),
        )
    if "material" in sources:
        found["material"] = _material_uncertainty(solved, material)
    curve = magnification_curve(window, contact=lenient, solved=solved) if "unresolved" in sources else None
    if curve is not None:
        found["unresolved"] = _unresolved(window, curve, solved, settings, instrument)
    found = {source: found[source] for source in SOURCES if source in sources}
    budget = (
        combine(found, solved, hardness=contact.get("hardness"))
        .assign_coords(coordinates)
        .assign({rejected.name: rejected})
    )
    if curve is not None:
        budget = budget.merge(curve.drop_vars("mean_pressure", errors="ignore"))
    for source, ending in _ENSEMBLES.items():
        if source in found:
            names = {f"{name}_members": f"{name}_{ending}" for name in (*QUANTITIES, *ANSWERS)}
            kept = found[source][list(names)].rename(names)
            budget = budget.merge(kept.drop_vars("mean_pressure"))
            budget.attrs |= {
                f"{source}_{key}": found[source].attrs[key]
                for key in ("reason", "flag")
                if key in found[source].attrs
            }
    return budget


def combine(
    found: Mapping[UncertaintySource, xr.Dataset], result: xr.Dataset, *, hardness: float | None = None
) -> xr.Dataset:
    """Return combined uncertainties and interval ends from the half-widths of each source.

    Below the result U = sqrt(sum (U_i - b_i)²), above it U = b + sqrt(sum (U_i - b_i)²), b = sum b_i; a
    source that is absent, or NaN at a load, does not count. b_i is the amount by which the result is known to
    be too low ([1]_, F.2.4.5); only the pressure in contact, a mean over whole pixels, has such a bias. The
    interval is limited to physical values: the area lies between 0 and 1, the pressure in contact is at least
    the load, and no pressure exceeds the hardness.

    Parameters
    ----------
    found : dict
        source -> Dataset (load) with the half-widths of `QUANTITIES`, also as `{name}_down` and `{name}_up`
        where they differ, and the known bias b_i as `{name}_bias`.
    result : Dataset
        `QUANTITIES` (load), and `mean_pressure`.
    hardness : float, Pa, optional
        upper limit of the pressure.

    Returns
    -------
    Dataset
        `{name}_uncertainty` with dims (load, source), `source` being the four and `combined`: the larger
        half-width; NaN where none is known or where one side is unbounded (infinite). Along `load` the ends
        of the combined interval, `{name}_lower` and `{name}_upper`, NaN for an unbounded end.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement.

    Examples
    --------
    >>> import xarray as xr
    >>> solver, pixels = (xr.Dataset({name: ("load", [u]) for name in QUANTITIES}) for u in (0.3, 0.4))
    >>> result = xr.Dataset({name: ("load", [0.6]) for name in QUANTITIES})
    >>> result["mean_pressure"] = ("load", [0.2])
    >>> found = combine({"solver": solver, "discretisation": pixels}, result)
    >>> found["mean_gap_uncertainty"].values
    array([[0.3, 0.4, nan, nan, nan, nan, nan, 0.5]])
    >>> [round(found[f"relative_contact_area_{end}"].item(), 2) for end in ("lower", "upper")]
    [0.1, 1.0]
    """
    load = result["mean_pressure"].values
    least = {"mean_contact_pressure": load, "max_pressure": load}
    limit = np.inf if hardness is None else hardness
    most = {"relative_contact_area": 1.0, "max_pressure": limit, "mean_contact_pressure": limit}
    columns: dict[str, tuple] = {}
    for name in (*QUANTITIES, *answers_present(result)):
        value = result[name].values
        parts = _components(name, found, load.size)
        # a result at a physical limit, up to rounding, stays inside its own interval
        low, high = np.minimum(value, least.get(name, 0.0)), np.maximum(value, most.get(name, np.inf))
        for ending, sources in (("", SOURCES), ("map_", _OF_THE_MAP)):
            lower, upper = _ends(value, parts, [SOURCES.index(source) for source in sources])
            if not ending:
                both = np.maximum(value - lower, upper - value)
                shown = _bounded(np.column_stack([parts["shown"], both]))
                columns[_uncertainty(name)] = (("load", "source"), shown, {"comment": _COMMENT})
            ends = {"lower": np.maximum(lower, low), "upper": np.minimum(upper, high)}
            for end, values in ends.items():
                comment = {"comment": _ENDS[f"{ending}{end}"]}
                columns[f"{name}_{ending}{end}"] = ("load", _bounded(values), comment)
    return xr.Dataset(columns, coords={"source": [*SOURCES, COMBINED]})


def _components(
    name: str, found: Mapping[UncertaintySource, xr.Dataset], loads: int
) -> dict[str, np.ndarray]:
    """Return the parts (load, source) of the uncertainty of one quantity, NaN where a source says nothing.

    `shown` is the larger half-width; `down` and `up` are the half-widths without the known `bias`, which is
    added linearly above; `shift_down` and `shift_up` are one-sided.
    """
    parts = {key: np.zeros((loads, len(SOURCES))) for key in ("down", "up", "bias", "shift_down", "shift_up")}
    parts["shown"] = np.full((loads, len(SOURCES)), np.nan)
    for source, dataset in found.items():
        if name not in dataset:  # the answers have no solver uncertainty
            continue
        column = SOURCES.index(source)
        parts["shown"][:, column] = dataset[name].values
        if f"{name}_bias" in dataset:
            parts["bias"][:, column] = dataset[f"{name}_bias"].values
        for side in ("down", "up"):
            shift = dataset.get(f"{name}_shift_{side}")
            if shift is not None:
                parts[f"shift_{side}"][:, column] = shift.values
            symmetric = dataset[name] if shift is None else xr.zeros_like(dataset[name])
            width = dataset.get(f"{name}_{side}", symmetric)
            parts[side][:, column] = width.values - parts["bias"][:, column]
    absent = np.isnan(parts["shown"])
    return {key: np.where(absent, 0.0, part) if key != "shown" else part for key, part in parts.items()}


def _ends(
    value: np.ndarray, parts: Mapping[str, np.ndarray], columns: list[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the interval of some sources; NaN where none of them says anything."""
    down, up = (np.sqrt(np.sum(parts[side][:, columns] ** 2, axis=1)) for side in ("down", "up"))
    up = up + parts["bias"][:, columns].sum(axis=1)
    lower, upper = value - down, value + up
    positive = np.where(value > 0, value, 1.0)
    with np.errstate(invalid="ignore"):
        lower = np.where(
            value > 0,
            lower * np.prod(np.maximum(1 - parts["shift_down"][:, columns] / positive[:, None], 0.0), axis=1),
            lower - parts["shift_down"][:, columns].sum(axis=1),
        )
        upper = np.where(
            value > 0,
            upper * np.prod(1 + parts["shift_up"][:, columns] / positive[:, None], axis=1),
            upper + parts["shift_up"][:, columns].sum(axis=1),
        )
    nothing = np.isnan(parts["shown"][:, columns]).all(axis=1)
    return np.where(nothing, np.nan, lower), np.where(nothing, np.nan, upper)


def stated_instrument(levelled: xr.DataArray, settings: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return what is known of the instrument: from the settings, the table of surfaces, the file.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        whose attributes `instrument_{name}` hold what the table says of this map, and whose attribute
        `instrument` (JSON) what the file says; of the latter the numerical aperture counts.
    settings : mapping or None
        section `instrument`, over which the table prevails; the file comes last.

    Returns
    -------
    dict
        the names of `INSTRUMENT` that are known.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64).assign_attrs(instrument_noise=1e-9)
    >>> stated_instrument(height, {"noise": 2e-9, "tip_radius": None})
    {'noise': 1e-09}
    """
    known = dict(settings or {})
    of_file = json.loads(levelled.attrs.get("instrument", "{}") or "{}").get("numerical_aperture")
    optics = ("numerical_aperture", "resolution", "tip_radius")
    table = {
        key: levelled.attrs[f"instrument_{key}"]
        for key in INSTRUMENT
        if f"instrument_{key}" in levelled.attrs
    }
    known |= table
    if of_file and not any(known.get(key) for key in optics):
        known["numerical_aperture"] = float(of_file)
    return {key: value for key, value in known.items() if value is not None}


def _material_uncertainty(solved: xr.Dataset, material: Mapping[str, float | None]) -> xr.Dataset:
    """Return the uncertainty due to modulus and load; NaN where neither is stated."""
    inputs = {key: value for key, value in material.items() if value}
    if inputs:
        return scaling_uncertainty(solved, inputs)
    nothing = np.full(solved.sizes["load"], np.nan)
    return xr.Dataset(dict.fromkeys((*QUANTITIES, *answers_present(solved)), ("load", nothing)))


def _unresolved(
    window: xr.DataArray,
    curve: xr.Dataset,
    solved: xr.Dataset,
    settings: Mapping[str, Mapping[str, Any]],
    instrument: Mapping[str, Any],
) -> xr.Dataset:
    """Return the uncertainty due to waves that are not resolved; none where the settings leave them out."""
    shortest = float(curve["cutoff_wavelength"][0])
    band = [settings.get("level", {}).get("s_filter"), settings.get("window", {}).get("shortest_wavelength")]
    if max(each or 0.0 for each in band) >= _CHOSEN_BAND * shortest:
        zeros = {
            name: ("load", np.zeros(solved.sizes["load"])) for name in (*QUANTITIES, *answers_present(solved))
        }
        return xr.Dataset(zeros)
    resolved, reference = shortest_transmitted(instrument), window
    if resolved > shortest:
        reference = restored(window, instrument, noise=instrument.get("noise") or 0.0)
    if tip_radius := instrument.get("tip_radius"):
        resolved = max(resolved, reliability_length(window, tip_radius))
        reference = eroded(window, tip_radius)
    growth = expected_growth(curve, resolved=resolved, reference=rms_gradient(reference))
    finer = instrument.get("finer_spectrum")
    if finer is None:
        return unresolved_uncertainty(curve, solved, growth)
    if not isinstance(finer, xr.DataArray):
        finer = read_height_map(finer)
    known = growth_by_finer_spectrum(window, level(finer, form="plane"))
    last = growth.gradient / growth.octaves if growth.octaves else 0.0
    octaves = min(known / last, 4.0) if last > 0 else 0.0
    return unresolved_uncertainty(curve, solved, Growth(known, octaves, growth.level), known=True)


def _count(contact: xr.Dataset) -> xr.Dataset:
    """Return quantities, resolution indicators and solver uncertainties of each load."""
    open_by_solver = solver_uncertainty(contact)
    counted = resolution_indicators(contact).merge(headline_and_answers(contact)[list(ANSWERS)])
    return counted.merge(half_length_constrictions(contact)).merge(
        open_by_solver.rename({name: _uncertainty(name) for name in QUANTITIES})
    )


def _bounded(values: np.ndarray) -> np.ndarray:
    """Return the values with infinite ones replaced by NaN."""
    return np.where(np.isinf(values), np.nan, values)


def _uncertainty(name: str) -> str:
    """Return the name of the uncertainty of a quantity."""
    return f"{name}_uncertainty"
