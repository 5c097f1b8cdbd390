"""Uncertainty from processing choices: outliers, row alignment, form, periodisation, filling of holes.

Alternatives that another careful user might choose are solved one at a time. Within a group of alternatives
the true result is taken to be uniformly distributed around the user's result, with the largest deviation of
the group as half-width a, hence the standard uncertainty a / sqrt(3) (JCGM 100:2008, 4.3.7). The groups are
independent.
"""

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.levelling.filling import fill_harmonic, find_holes
from roughcontact.levelling.forms import form_from_record
from roughcontact.levelling.outliers import find_outliers
from roughcontact.levelling.polynomial import fit_polynomial, share_of_form
from roughcontact.levelling.rejected import rejected_points, with_rejected
from roughcontact.levelling.row_jitter import find_row_jitter
from roughcontact.maps import spacing
from roughcontact.statistics.checks import FORM
from roughcontact.uncertainty.answers import counter_of, quantities_in
from roughcontact.uncertainty.ensemble import Member, measured_slices, rescaled_to, solve_member
from roughcontact.uncertainty.headline import QUANTITIES
from roughcontact.window.periodic_window import periodic_window

COVERAGE_FACTOR = 2.0  # of the expanded uncertainty: about 95 %
# periodisation methods without bias in contact area and peak pressure: docs/explanation/surface.md
_UNBIASED_METHODS = ("smooth-cross-fade", "periodic-plus-smooth")
_MIN_COARSE_POINTS = 64  # along the shorter side of a coarsened map
_CERTAIN_FACTOR = 2.0  # in units of the outlier threshold: points farther off are certainly outliers
_TOLERANCE = 1e-3  # of the pressure: alternatives may differ by less than a percent


def processing_uncertainty(
    levelled: xr.DataArray,
    *,
    level: Mapping[str, Any],
    window: Mapping[str, Any],
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    chosen: xr.DataArray | None = None,
) -> xr.Dataset:
    """Return the expanded uncertainty of a result due to processing choices.

    U = 2 sqrt(sum over groups a^2 / 3) [1]_, a = largest deviation from the user's result within a group:

    * form: the polynomial of the next higher order, and of the next lower order unless the remaining bow
      contributes more to the mean square height than the check "Form" allows
    * periodisation: `smooth-cross-fade` and `periodic-plus-smooth`
    * filling: holes filled with the roughness of the map on top of the harmonic surface
    * outliers: rejected points that twice the threshold would keep are restored; narrow bumps are rejected
      as well
    * rows: shifted at random by the residual error of their alignment; aligned, where there is evidence of
      random shifts and they were not aligned or aligned by another method.

    Groups that do not affect a map are omitted: filling where nothing was filled, form and periodisation
    where the map is periodic, outliers where none are doubtful, rows without evidence of shifts. Forms, which
    are long waves, are compared on a grid with half the points along each axis (block means) if at least 64
    remain, and their deviations are rescaled to the result.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.
    level, window, contact : dict
        keyword arguments of `level`, `periodic_window` and `solve_contact` (loads included) that led to the
        result.
    solved : Dataset
        the result: `QUANTITIES` along `load`.
    chosen : DataArray (y, x), m, optional
        result of `periodic_window` for the map; computed where it is not given.

    Returns
    -------
    Dataset
        along `load` the expanded uncertainty of `relative_contact_area`, `mean_gap` (m), `max_pressure` and
        `mean_contact_pressure` (Pa); along (choice, load) the results of the alternatives, rescaled to that
        of the main window, as `{name}_members`; `choice` describes them, the user's own first. Attributes:
        `coverage_factor`, `reason` (list of the alternatives), `flag` (deficiency of the ensemble, empty for
        none), `work` (FFT pairs times points).

    Raises
    ------
    ConvergenceError
        where the solution of an alternative misses its tolerance.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement, 4.3.7.

    Examples
    --------
    A periodic map has no alternatives.

    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.uncertainty.headline import headline
    >>> levelled = level(rough_reference_surface(64))
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> solved = solve_contact(levelled, **problem, reduce=headline)
    >>> found = processing_uncertainty(levelled, level={}, window={}, contact=problem, solved=solved)
    >>> found.attrs["reason"]
    'The map is periodic and has no doubtful points: no alternative processing changes the result.'
    """
    count = counter_of(solved)
    chosen = periodic_window(levelled, **window) if chosen is None else chosen
    known = {name: solved[name].values for name in quantities_in(solved)}
    choices, members = [], []
    for choice, other in _choices(levelled, chosen, level, window):
        choices.append(choice)
        if other is None:
            members.append(Member(known, 0.0))
            continue
        members.append(solve_member(other, contact, tolerance=_TOLERANCE, count=count, result=solved))
        del other  # before the next one is made: memory may not hold two large maps
    groups = np.array([choice.group for choice in choices])
    on_coarse_grid = np.isin(groups, ("own", "form"))
    result: dict[str, tuple] = {}
    for name, main in known.items():
        values = np.array([member.values[name] for member in members])
        values[on_coarse_grid] = rescaled_to(main, values[on_coarse_grid], base=values[0])
        farthest = [np.abs(values[groups == group] - main).max(axis=0) for group in np.unique(groups)]
        result[name] = ("load", COVERAGE_FACTOR * np.sqrt(np.sum(np.square(farthest), axis=0) / 3))
        result[f"{name}_members"] = (("choice", "load"), values)
    names = [choice.name for choice in choices]
    return xr.Dataset(
        result,
        coords={
            "mean_pressure": ("load", np.asarray(solved["mean_pressure"].values, float)),
            "choice": names,
        },
        attrs={
            "coverage_factor": COVERAGE_FACTOR,
            "reason": _reason(names[1:]),
            "flag": _flag(members),
            "work": sum(member.work for member in members),
        },
    )


def rough_filling(levelled: xr.DataArray) -> xr.DataArray:
    """Return a levelled map whose holes are filled with the roughness of its measured part.

    A harmonic surface is the smoothest filling. Roughness is added to it from another part of the map: the
    map is rotated or mirrored, so that measured heights come to lie in the holes, and the difference between
    these heights and their own harmonic filling is added. Of the half turn and the two mirror images, the one
    with the most measured heights in the holes is used.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`, with the coordinate `filled`.

    Returns
    -------
    DataArray (y, x), m
        unchanged outside the holes.

    Examples
    --------
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> height[10:16, 20:26] = float("nan")
    >>> levelled = level(height)
    >>> changed = rough_filling(levelled) != levelled
    >>> bool((changed == (levelled["filled"] == 1)).all())
    True
    """
    from scipy import ndimage

    values, filled = levelled.values, levelled["filled"].values != 0
    unknown = filled | np.isnan(values)
    axes = min(((0, 1), (0,), (1,)), key=lambda axes: np.count_nonzero(np.flip(unknown, axes)[filled]))
    other = np.flip(values, axes)
    labels, _ = find_holes(filled)
    # a hole whose rim is missing in the rotated or mirrored map has no harmonic filling there
    lost = np.zeros(labels.max() + 1, dtype=bool)
    lost[labels[ndimage.binary_dilation(np.isnan(other))]] = True
    labels[lost[labels]] = 0
    smooth = fill_harmonic(np.where(labels > 0, np.nan, other), labels, spacing(levelled))
    rough, holes = values.copy(), labels > 0
    rough[holes] = values[holes] + other[holes] - smooth[holes]
    return levelled.copy(data=rough)


class _Choice(NamedTuple):
    """One way to process the map: its group, and a description."""

    group: str
    name: str


def _choices(
    levelled: xr.DataArray, chosen: xr.DataArray, level: Mapping[str, Any], window: Mapping[str, Any]
) -> Iterator[tuple[_Choice, xr.DataArray | None]]:
    """Yield the user's own choice and each alternative that affects this map, with its periodic window.

    To save memory, windows are made one at a time and not kept here; shallow copies are passed on, so that
    heights loaded from a file are freed with the window. The user's own choice has a window only where
    forms are compared with it; otherwise its result is known.
    """
    with_forms = chosen.attrs["periodisation"] != "none"
    coarse = {**window, "correct_for": None}  # forms are long waves, and block means have other noise
    yield _Choice("own", "as chosen"), periodic_window(_coarsened(levelled), **coarse) if with_forms else None
    if with_forms:
        for name, other in _other_forms(levelled, level):
            yield _Choice("form", name), periodic_window(other, **coarse)
        for method in _UNBIASED_METHODS:
            if method != chosen.attrs["periodisation"]:
                made = _Choice("periodisation", f"made periodic by {method}")
                yield made, _periodic_by_method(levelled.copy(deep=False), chosen, window, method)
    if chosen["filled"].any():
        choice = _Choice("filling", "holes filled with roughness")
        yield choice, periodic_window(rough_filling(levelled.copy(deep=False)), **window)
    for group, others in (("outliers", _other_outliers(levelled, level)), ("rows", _other_rows(levelled))):
        for name, other in others:
            # popped from a list when yielded, so that no reference to the window stays here
            solved = [periodic_window(other, **window)]
            del other
            if not np.array_equal(solved[0].values, chosen.values):  # the points may lie outside the window
                yield _Choice(group, name), solved.pop()


def _other_rows(levelled: xr.DataArray) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield (name, levelled map) with other row offsets, where there is evidence of random row shifts."""
    evidence = levelled.attrs.get("row_jitter_evidence", "none")
    aligned = "line_offset" in levelled.coords
    if evidence == "none" or "counter_face" in levelled.attrs:
        return  # no row shifts, or a composite map of two faces whose scan directions may differ
    taken = levelled["line_offset"].values if aligned else np.zeros(len(levelled))
    found = find_row_jitter(levelled.values + taken[:, None], scanned=evidence == "doubtful")
    if levelled.attrs["line_alignment"] == "jitter":
        yield (
            "rows shifted by the residual error of their alignment",
            levelled + found.residual_offsets[:, None],
        )
    else:
        yield "rows aligned as jitter", levelled + (taken - found.offsets)[:, None]


def _other_outliers(levelled: xr.DataArray, level: Mapping[str, Any]) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield (name, levelled map) for each doubtful decision on outliers, reversed."""
    threshold = level.get("outlier_threshold", 6.0)
    if threshold is None:
        return
    for name, make in (
        ("doubtful outliers kept", _with_doubtful_points),
        ("narrow bumps rejected", _without_bumps),
    ):
        other = make(levelled.copy(deep=False), threshold)
        if other is not None:
            made = [other]  # popped when yielded, so that no reference stays here
            del other
            yield name, made.pop()


def _with_doubtful_points(levelled: xr.DataArray, threshold: float) -> xr.DataArray | None:
    """Return the map with those rejected points restored that twice the threshold would keep, or None."""
    rejected = rejected_points(levelled)
    if not rejected.any():
        return None
    sure, _ = find_outliers(with_rejected(levelled).values, threshold=_CERTAIN_FACTOR * threshold)
    return with_rejected(levelled, ~sure) if (rejected & ~sure).any() else None


def _without_bumps(levelled: xr.DataArray, threshold: float) -> xr.DataArray | None:
    """Return the map with narrow bumps rejected as well, or None without such bumps."""
    bumps, _ = find_outliers(levelled.values, threshold=threshold, bumps=True)
    bumps &= levelled["filled"].values == 0
    labels, _ = find_holes(bumps)
    if not labels.any():
        return None
    values = np.where(labels > 0, np.nan, levelled.values)
    filled = np.where(labels > 0, 1, levelled["filled"].values).astype(np.int8)
    without = levelled.copy(data=fill_harmonic(values, labels, spacing(levelled)))
    return without.assign_coords(filled=(("y", "x"), filled))


def _periodic_by_method(
    levelled: xr.DataArray, chosen: xr.DataArray, window: Mapping[str, Any], method: str
) -> xr.DataArray:
    """Return the window made periodic by another method, from the same points if no band is blended."""
    other = {**window, "method": method}
    if method != "periodic-plus-smooth":
        return periodic_window(levelled, **other)
    part = levelled.isel(measured_slices(levelled, chosen))
    return periodic_window(part, **{**other, "placement": "largest"})


def _coarsened(levelled: xr.DataArray) -> xr.DataArray:
    """Return a map of block means where it has enough points, otherwise the map itself.

    A block is missing if one of its points is missing, and filled if one of its points is filled.
    """
    factors = tuple(2 if n > 1 else 1 for n in levelled.shape)
    if min(n // f for n, f in zip(levelled.shape, factors, strict=True) if f > 1) < _MIN_COARSE_POINTS:
        return levelled
    sides = [n // f for n, f in zip(levelled.shape, factors, strict=True)]
    whole = levelled[tuple(slice(n * f) for n, f in zip(sides, factors, strict=True))]
    split = (sides[0], factors[0], sides[1], factors[1])
    coords: dict[str, tuple] = {
        d: (d, whole[d].values.reshape(n, f).mean(axis=1), whole[d].attrs)
        for d, n, f in zip("yx", sides, factors, strict=True)
    }
    coords["filled"] = (("y", "x"), whole["filled"].values.reshape(split).max(axis=(1, 3)))
    heights = whole.values.reshape(split).mean(axis=(1, 3))
    return xr.DataArray(heights, dims=("y", "x"), coords=coords, name=levelled.name, attrs=levelled.attrs)


def _other_forms(levelled: xr.DataArray, level: Mapping[str, Any]) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield (name, coarsened levelled map) for the form polynomials of neighbouring order."""
    order = {"none": 0, "mean": 0, "plane": 1}.get(levelled.attrs["form"], level.get("order", 2))
    if levelled.attrs["form"] in ("sphere", "cylinder"):
        order = 1  # the closest polynomial is of second order
    robust = level.get("robust", False)
    yield f"form of order {order + 1}", _coarsened(_with_order(levelled.copy(deep=False), order + 1, robust))
    if order > 1:
        lower = _with_order(levelled.copy(deep=False), order - 1, robust)
        if share_of_form(lower.fillna(lower.mean()).values, _coordinates(lower)) <= FORM:
            yield f"form of order {order - 1}", _coarsened(lower)


def _with_order(levelled: xr.DataArray, order: int, robust: bool) -> xr.DataArray:
    """Return a map with its form restored and a polynomial, fitted to the measured points, removed."""
    coordinates = _coordinates(levelled)
    removed = json.loads(levelled.attrs["form_removed"])
    values = levelled.values + form_from_record(removed, *coordinates)
    measured = np.where(levelled["filled"].values == 0, values, np.nan)
    form, removed = fit_polynomial(measured, coordinates, order=order, robust=robust)
    other = {"form": "polynomial", "form_removed": json.dumps(removed)}
    return levelled.copy(data=values - form).assign_attrs(other)


def _coordinates(levelled: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    """Return the coordinates (y, x) of a map."""
    return levelled["y"].values, levelled["x"].values


def _reason(names: list[str]) -> str:
    """Return a sentence that lists the alternatives."""
    if not names:
        return "The map is periodic and has no doubtful points: no alternative processing changes the result."
    return f"Alternatives to the settings, solved one at a time: {'; '.join(names)}."


def _flag(members: list[Member]) -> str:
    """Return a sentence on a deficiency of the ensemble, empty for none."""
    if np.isnan([member.values[name] for member in members for name in QUANTITIES]).any():
        return "The solution of a processing alternative missed the tolerance."
    return ""
