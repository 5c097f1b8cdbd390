"""The error budget: uncertainty of each headline quantity, by source and combined."""

from collections.abc import Mapping, Sequence
from typing import Any, get_args

import numpy as np
import xarray as xr

from roughcontact.checking import check_choice
from roughcontact.choices import UncertaintySource
from roughcontact.contact.solve import solve_contact
from roughcontact.uncertainty.answers import (
    ANSWERS,
    answers_present,
    half_length_constrictions,
    headline_and_answers,
)
from roughcontact.uncertainty.discretisation import discretisation_uncertainty, resolution_indicators
from roughcontact.uncertainty.headline import QUANTITIES
from roughcontact.uncertainty.processing import processing_uncertainty
from roughcontact.uncertainty.rejected import rejected_load_share
from roughcontact.uncertainty.solver import solver_uncertainty
from roughcontact.uncertainty.window_sampling import window_uncertainty

SOURCES: tuple[UncertaintySource, ...] = get_args(UncertaintySource)
COMBINED = "combined"
# endings of the variables that hold the results of ensemble members
_ENSEMBLES: dict[UncertaintySource, str] = {"window": "parts", "processing": "choices"}
_COMMENT = (
    "half-widths of 95 % intervals, in the unit of the quantity; the larger one where an interval is "
    "asymmetric; combined: root of the sum of squares of the sources given (for the pressure in contact the "
    "known bias of whole pixels is added linearly); NaN: not requested, not available from this map, or not "
    "bounded above by it"
)
_ENDS = {
    "lower": "lower end of the 95 % interval, all sources combined",
    "upper": "upper end of the 95 % interval, all sources combined; NaN beside a lower end: not bounded",
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
    contact = settings["contact"]
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
    found = {source: found[source] for source in SOURCES if source in sources}
    budget = (
        combine(found, solved, hardness=contact.get("hardness"))
        .assign_coords(coordinates)
        .assign({rejected.name: rejected})
    )
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
    array([[0.3, 0.4, nan, nan, 0.5]])
    >>> [round(found[f"relative_contact_area_{end}"].item(), 2) for end in ("lower", "upper")]
    [0.1, 1.0]
    """
    load = result["mean_pressure"].values
    least = {"mean_contact_pressure": load, "max_pressure": load}
    limit = np.inf if hardness is None else hardness
    most = {"relative_contact_area": 1.0, "max_pressure": limit, "mean_contact_pressure": limit}
    columns: dict[str, tuple] = {}
    for name in (*QUANTITIES, *answers_present(result)):
        shown = np.full((load.size, len(SOURCES)), np.nan)
        below, above, bias = np.zeros((3, *shown.shape))
        for source, dataset in found.items():
            if name not in dataset:  # the answers have no solver uncertainty
                continue
            column = SOURCES.index(source)
            shown[:, column] = dataset[name].values
            off = dataset[f"{name}_bias"].values if f"{name}_bias" in dataset else np.zeros(load.size)
            bias[:, column] = off
            for side, values in (("down", below), ("up", above)):
                half_width = dataset.get(f"{name}_{side}", dataset[name]).values
                values[:, column] = half_width - off
        absent = np.isnan(shown)
        down, up = (np.sqrt(np.sum(np.where(absent, 0, v) ** 2, axis=1)) for v in (below, above))
        up = up + np.where(absent, 0, bias).sum(axis=1)
        nothing = absent.all(axis=1)
        down, up = (np.where(nothing, np.nan, half_width) for half_width in (down, up))
        value = result[name].values
        # a result at a physical limit, up to rounding, stays inside its own interval
        lower = np.maximum(value - down, np.minimum(value, least.get(name, 0.0)))
        upper = np.minimum(value + up, np.maximum(value, most.get(name, np.inf)))
        columns[_uncertainty(name)] = (
            ("load", "source"),
            _bounded(np.column_stack([shown, np.maximum(down, up)])),
            {"comment": _COMMENT},
        )
        for end, values in (("lower", lower), ("upper", upper)):
            columns[f"{name}_{end}"] = ("load", _bounded(values), {"comment": _ENDS[end]})
    return xr.Dataset(columns, coords={"source": [*SOURCES, COMBINED]})


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
