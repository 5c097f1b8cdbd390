"""Uncertainty from the window: what the surface beyond the map would give.

A map is a sample: it shows one place, and waves up to its own length. The interval is for the surface, here
or elsewhere, over `extent` times the length of the map, under the same mean pressure. Two things are asked.

* Scatter: what would another place give? The window is cut into parts (3 x 3), each levelled, made periodic
  and solved like the window. With s the standard deviation of the logarithm of their results and r the
  length of the window over that of a part, the result of the window scatters by s r^(-(1 - H) D/2). Where
  parts are longer than the waves they are independent samples, H = 0: in the plane, D = 2, that is s/r, the
  s/sqrt(m) of m = r^2 parts. Where the surface has waves of all lengths the step from the window to a
  longer surface looks like that from a part to the window, H = 1, and nothing is gained from the number of
  parts. H is the exponent by which the heights grow with the length (`growth`), at least 0.25: no real
  surface is as even as a stationary random one. D is 2, less where there is a lay: parts along it show the
  same ridges.
  The surface itself, `extent` times as long, scatters as well, which makes the factor sqrt(1 + extent^(-(1 -
  H) D)).
* Growth: what do longer waves add? The heights of the longer surface are extent^a times those of the map, a
  the exponent before it is bounded. The window is solved once more with its heights so many times as large:
  that is how far up the mean gap may be, and by a quarter of it more, since a is an estimate. It grows by
  more than the heights, since the same pressure closes less of it: with u(p) the gap of the map, n times the
  heights have the gap n u(p/n), whose logarithm grows 1 + p/(K u) times as fast as that of n, K = -dp/du the
  stiffness. Area and pressure in contact go on to change as they did from the parts to the window, H times,
  in a direction that is not known.

What scatters is the logarithm of a quantity; of the area A that of x = erfinv(A), which is A at low loads up
to a factor. A = erf(sqrt(2) p/(E* g)) of Persson (2001) says why: of other places with another gradient g
the logarithm of x is off by the same at all loads, A itself only while it is small, and never above 1. The
pressure in contact is the load over the area, and as uncertain.

The largest pressure is no mean: it grows with the surface without end. It is that of the largest of
extent^D maps: the largest of n normal numbers lies at sqrt(2 ln n) and scatters as 1/sqrt(2 ln n) standard
deviations (Gumbel, Statistics of Extremes, 1958), so that the scatter of its logarithm is that of the
parts' peaks, and it grows by the scale of the Gumbel distribution, s sqrt(6)/pi, times the logarithm of
the number of maps.

All constants are measured on real surfaces and made ones (docs/explanation/uncertainty.md).
"""

import json
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.special import erf, erfinv, stdtrit

from roughcontact.checking import check_map
from roughcontact.errors import SettingsError
from roughcontact.levelling.polynomial import fit_polynomial, without_form
from roughcontact.maps import spacing
from roughcontact.quantities import number, percent
from roughcontact.roughness.texture import texture_parameters
from roughcontact.uncertainty.answers import answers_in, grooved, headline_and_answers, of_other_places
from roughcontact.uncertainty.ensemble import shown_part, solve_member
from roughcontact.uncertainty.growth import form_order, growth_exponent
from roughcontact.uncertainty.headline import QUANTITIES, headline
from roughcontact.window.periodic_window import periodic_window

_TOLERANCE = 1e-2  # of the pressure: 0.4 % of a part's area (rms), where parts differ by 5 % and more
_LEAST_POINTS = 12  # along the side of a part
_LEAST_WAVES = 2  # of the shortest wavelength that is kept, along the side of a part
_COVERAGE = 0.95
_EXTENT = 3.0
_LEAST_EXPONENT = 0.25  # by which the scatter of real surfaces is wider than that of stationary ones
_GROWTH_REACH = 1.25  # of what the expected growth of the heights adds to the mean gap
_LEAST_FREEDOM = 2.0  # degrees of freedom, however strong the lay
_NEXT_TO_NOTHING = 1e-2  # of the window's result: less is no gap to take a logarithm of
_FULL = 1 - 1e-6  # area of which a part has hardly a point left to close
_STILL_GROWING = 0.25  # logarithm of the growth of the heights: waves are then as long as the map
_FEW_STRIPS = 2.5  # degrees of freedom: with fewer a lay leaves three independent parts
_ISOLATED = 8.0  # kurtosis from which a few places hold most of the mean square height

Part = dict[str, slice]  # rows ("y") and columns ("x") of a map


def window_uncertainty(
    levelled: xr.DataArray,
    *,
    window: Mapping[str, Any],
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    number: int = 9,
    extent: float = _EXTENT,
    chosen: xr.DataArray | None = None,
) -> xr.Dataset:
    """Return the expanded uncertainty of the result of a window as a sample of its surface.

    In the logarithm, of the area A in that of erfinv(A) [3]_, downwards t s r^(-(1 - H) D/2) sqrt(1 +
    extent^(-(1 - H) D)), upwards the root of the sum of squares of this and of the growth; t of Student for
    95 % and r^D - 1 degrees of freedom [1]_; s of the parts, r, H, D and the growth as the head of this
    module explains them, the largest pressure after [2]_.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.
    window, contact : dict
        keyword arguments of `periodic_window` and `solve_contact` (loads included) that led to the result.
    solved : Dataset
        the result: `QUANTITIES` along `load`.
    number : int
        parts at most, 4 or more; 9 cut a map into 3 x 3 and a profile into 9.
    extent : float
        length of the surface that the interval is for, over that of the map; 1 or more.
    chosen : DataArray (y, x), m, optional
        what `periodic_window` makes of the map, where it is known already.

    Returns
    -------
    Dataset
        along `load`, for each of the four quantities the expanded uncertainty `{name}_down` and `{name}_up`
        below and above the result, `{name}` the larger of them; NaN where the window is too small to be cut.
        The same for the answers that `solved` has, infinite above where nothing in the map bounds them.
        Along (member, load) the results of the parts as they are, `{name}_members`; along `member` the
        parts' `member_offset_y`, `member_offset_x`, `member_length_y`, `member_length_x` (m, in the map, with
        the band that making them periodic takes). Attributes: `extent`, `coverage_factor` (t),
        `degrees_of_freedom`, `growth` (of the heights, a factor), `map_share` (of the map that the parts
        cover), `reason` (what was done, in words), `flag` (what is wrong with it, in words; empty where
        nothing is), `work` (FFT pairs times points).

    Raises
    ------
    SettingsError
        where `number` is below 4 or `extent` below 1.
    ConvergenceError
        where the solve of a part misses its tolerance.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement, G.3.
    .. [2] Gumbel (1958), Statistics of Extremes.
    .. [3] Persson (2001), J. Chem. Phys. 115, 3840.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.uncertainty.headline import headline
    >>> levelled = level(rough_reference_surface(64))
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> solved = solve_contact(levelled, **problem, reduce=headline)
    >>> found = window_uncertainty(levelled, window={}, contact=problem, solved=solved)
    >>> found.sizes["member"], round(found.attrs["coverage_factor"], 2)
    (9, 2.31)
    """
    if number != int(number) or number < 4:
        raise SettingsError(f"windows = {number!r}: give a whole number of 4 or more")
    if not extent >= 1:
        raise SettingsError(f"extent = {extent!r}: give a number of 1 or more")
    chosen = periodic_window(levelled, **window) if chosen is None else chosen
    whole = shown_part(levelled, chosen)
    parts = _cut(whole, spacing(levelled), int(number), window.get("shortest_wavelength") or 0.0)
    own = {**window, "placement": "largest", "min_share": 0.0}
    count = headline_and_answers if answers_in(solved) else headline
    members = []
    for part in parts:
        periodic = periodic_window(_levelled_again(levelled.isel(part), form_order(levelled)), **own)
        members.append(solve_member(periodic, contact, tolerance=_TOLERANCE, count=count))
    step = _step(chosen, levelled.isel(whole), parts=len(parts), extent=extent)
    values = {name: np.array([member.values[name] for member in members]) for name in QUANTITIES}
    widths, work = _half_widths(values, solved, step), sum(member.work for member in members)
    grown: dict[str, np.ndarray] = {}
    if step.growth > 0 and len(parts) > 1:
        higher = chosen.copy(data=chosen.values * math.exp(step.growth))
        member = solve_member(higher, contact, tolerance=_TOLERANCE, count=count)
        grown, work = member.values, work + member.work
        down, up = widths["mean_gap"]
        added = np.maximum(grown["mean_gap"] - solved["mean_gap"].values, 0.0)
        widths["mean_gap"] = down, np.hypot(up, _GROWTH_REACH * added)
    result: dict[str, tuple] = {}
    for name in QUANTITIES:
        down, up = widths[name]
        result |= {
            name: ("load", np.maximum(down, up)),
            f"{name}_down": ("load", down),
            f"{name}_up": ("load", up),
            f"{name}_members": (("member", "load"), values[name]),
        }
    into_the_open = grooved(chosen) if answers_in(solved) else []
    for name in answers_in(solved):
        of_parts = np.array([member.values[name] for member in members])
        half_way = solved[f"{name}_half_way"].values if f"{name}_half_way" in solved else None
        down, up = of_other_places(
            name,
            of_parts,
            solved[name].values,
            factor=step.scatter,
            going_on=step.going_on,
            grown=grown.get(name),
            half_way=half_way,
        )
        if name in into_the_open and half_way is not None:
            up = np.where(half_way > 0, np.inf, up)
        result |= {
            name: ("load", np.maximum(down, up)),
            f"{name}_down": ("load", down),
            f"{name}_up": ("load", up),
            f"{name}_members": (("member", "load"), of_parts),
        }
    covered = sum(math.prod(levelled.isel(part).shape) for part in parts) / levelled.size
    incomplete = any(np.isnan(member.values["mean_gap"]).any() for member in members)
    return xr.Dataset(
        result | _places(levelled, parts),
        coords={"mean_pressure": ("load", np.asarray(solved["mean_pressure"].values, float))},
        attrs={
            "extent": float(extent),
            "coverage_factor": step.factor,
            "degrees_of_freedom": step.freedom,
            "growth": math.exp(step.growth),
            "map_share": covered,
            "reason": _reason(levelled, parts, covered, step) + _open_ways(into_the_open),
            "flag": _flag(levelled, parts, incomplete, step),
            "work": work,
        },
    )


class _Step(NamedTuple):
    """The step from a window to the surface.

    Attributes
    ----------
    extent : float
        length of the surface over that of the window.
    ratio : float
        length of the window over that of a part.
    dimensions : float
        D: 2 without a lay, 1 for a strong one and for a profile.
    exponent : float
        H, from 0.25 to 1.
    growth : float
        logarithm of the growth of the heights.
    freedom, factor : float
        degrees of freedom of the scatter of the parts, and t for them; NaN for a single part.
    """

    extent: float
    ratio: float
    dimensions: float
    exponent: float
    growth: float
    freedom: float
    factor: float

    @property
    def scatter(self) -> float:
        """What the standard deviation among the parts is multiplied by, t included."""
        each = (1 - self.exponent) * self.dimensions
        return self.factor * self.ratio ** (-each / 2) * math.sqrt(1 + self.extent**-each)

    @property
    def going_on(self) -> float:
        """How much of a change from the parts to the window goes on to the surface; 0 for a single part."""
        return self.exponent * math.log(self.extent) / math.log(self.ratio) if self.ratio > 1 else 0.0


def _step(chosen: xr.DataArray, measured: xr.DataArray, *, parts: int, extent: float) -> _Step:
    """Return the step from a window, `chosen`, of the points `measured`, to the surface."""
    most = sum(n > 1 for n in measured.shape)
    ratio = parts ** (1 / most)
    isotropy = float(texture_parameters(chosen)["Str"])
    # a profile and a flat map have no lay, nor is one known of a window too narrow to tell
    dimensions = float(most) if math.isnan(isotropy) else 1.0 + min(1.0, 2.0 * isotropy)
    exponent = growth_exponent(measured)
    freedom, factor = math.nan, math.nan
    if parts > 1:
        freedom = max(_LEAST_FREEDOM, parts ** (dimensions / most) - 1)
        factor = float(stdtrit(freedom, (1 + _COVERAGE) / 2))
    return _Step(
        extent,
        ratio,
        dimensions,
        min(1.0, max(_LEAST_EXPONENT, exponent)),
        exponent * math.log(extent),
        freedom,
        factor,
    )


Widths = tuple[np.ndarray, np.ndarray]  # below and above the result, along the loads


def _half_widths(values: dict[str, np.ndarray], solved: xr.Dataset, step: _Step) -> dict[str, Widths]:
    """Return the half-widths of each quantity, without the growth of the gap, from values (member, load)."""
    result = {name: solved[name].values for name in QUANTITIES}
    if len(values["mean_gap"]) < 2:
        return {name: (np.full(each.shape, np.nan),) * 2 for name, each in result.items()}
    area, load = result["relative_contact_area"], solved["mean_pressure"].values
    down, up = _of_the_area(values["relative_contact_area"], area, step)
    some = np.where(area > 0, area, 1.0)
    return {
        "relative_contact_area": (down, up),
        "mean_gap": _of_the_gap(values["mean_gap"], result["mean_gap"], step),
        "max_pressure": _of_the_peak(values["max_pressure"], result["max_pressure"], step),
        # the load over either end of the area
        "mean_contact_pressure": (load / some * up / (some + up), load / some * down / (some - down)),
    }


def _of_the_area(values: np.ndarray, result: np.ndarray, step: _Step) -> Widths:
    """Return the half-widths of the contact area."""
    base = np.where(result > 0, result, 1.0)
    whole, parts = (_effort(np.maximum(v, _NEXT_TO_NOTHING * base)) for v in (base, values))
    change = np.abs(whole - parts.mean(axis=0))
    half_width = np.hypot(step.scatter * parts.std(axis=0, ddof=1), step.going_on * change)
    ends = (erf(np.exp(whole + side * half_width)) for side in (-1, 1))
    down, up = (np.abs(end / erf(np.exp(whole)) - 1) for end in ends)
    return result * down, result * up


def _effort(area: np.ndarray) -> np.ndarray:
    """Return ln erfinv(A), which is the logarithm of the load over E* g by Persson's law."""
    return np.log(erfinv(np.minimum(area, _FULL)))


def _of_the_gap(values: np.ndarray, result: np.ndarray, step: _Step) -> Widths:
    """Return the half-widths of the mean gap, as far as it scatters."""
    # where nothing is left of the result (no gap in full contact) its logarithm says nothing
    base = np.where(result > 0, result, 1.0)
    half_width = step.scatter * np.log(np.maximum(values, _NEXT_TO_NOTHING * base)).std(axis=0, ddof=1)
    alone = step.scatter * values.std(axis=0, ddof=1)
    return -result * np.expm1(-half_width), np.where(result > 0, result * np.expm1(half_width), alone)


def _of_the_peak(values: np.ndarray, result: np.ndarray, step: _Step) -> Widths:
    """Return the half-widths of the largest pressure, as that of the largest of several maps."""
    deviation = np.log(np.maximum(values, _NEXT_TO_NOTHING * result)).std(axis=0, ddof=1)
    maps = math.log(step.extent) * step.dimensions
    down = step.factor * deviation
    up = down + math.sqrt(6) / math.pi * deviation * maps
    return -result * np.expm1(-down), result * np.expm1(up)


def _levelled_again(part: xr.DataArray, order: int) -> xr.DataArray:
    """Return a part of a levelled map, levelled by itself like the map; nothing else is done to it."""
    if not order:
        return part.assign_attrs(form="none", form_removed="{}")
    heights = check_map(part)
    form, removed = fit_polynomial(heights, (part["y"].values, part["x"].values), order=order)
    record = {"form": "polynomial", "form_removed": json.dumps(removed)}
    return part.copy(data=without_form(heights, form)).assign_attrs(record)


def _sides(part: Part) -> list[int]:
    """Return the points (ny, nx) of a part."""
    return [part[d].stop - part[d].start for d in "yx"]


def _cut(whole: Part, step: tuple[float, float], number: int, shortest: float) -> list[Part]:
    """Return the parts of a window as {dim: slice}: where their number times their squareness is largest."""
    sides = _sides(whole)
    most = [
        max(1, int(n / max(_LEAST_POINTS, _LEAST_WAVES * shortest / s))) if n > 1 else 1
        for n, s in zip(sides, step, strict=True)
    ]
    cuts = [
        (ky * kx * _squareness(sides[0] * step[0] / ky, sides[1] * step[1] / kx, sides), ky, kx)
        for ky in range(1, min(number, most[0]) + 1)
        for kx in range(1, min(number // ky, most[1]) + 1)
    ]
    _, *cut = max(cuts)
    edges = [whole[d].start + np.arange(k + 1) * n // k for d, n, k in zip("yx", sides, cut, strict=True)]
    return [
        {"y": slice(int(top), int(bottom)), "x": slice(int(left), int(right))}
        for top, bottom in zip(edges[0][:-1], edges[0][1:], strict=True)
        for left, right in zip(edges[1][:-1], edges[1][1:], strict=True)
    ]


def _squareness(length_y: float, length_x: float, sides: list[int]) -> float:
    """Return the shorter length of a part over the longer one; 1 for a profile."""
    return 1.0 if 1 in sides else min(length_y, length_x) / max(length_y, length_x)


def _places(levelled: xr.DataArray, parts: list[Part]) -> dict[str, tuple]:
    """Return the variables that say where the parts lie in the map."""
    found = {}
    for d, step in zip("yx", spacing(levelled), strict=True):
        found[f"member_offset_{d}"] = ("member", [part[d].start * step for part in parts])
        found[f"member_length_{d}"] = ("member", [(part[d].stop - part[d].start) * step for part in parts])
    return found


def _reason(levelled: xr.DataArray, parts: list[Part], covered: float, step: _Step) -> str:
    """Return what the interval is for, and what was done, in words."""
    ny, nx = levelled.isel(parts[0]).shape
    if len(parts) == 1:
        return f"The window of {nx} x {ny} points is too small to be cut into parts."
    return (
        f"The ± is for this surface over {number(step.extent)} times the length of the map, under the same "
        f"mean pressure: {len(parts)} parts of about {nx} x {ny} points, {percent(covered)} of the map, each "
        "levelled, made periodic and solved by itself, tell how results scatter; from how the heights grow "
        f"with the length they are expected to be {number(math.exp(step.growth))} times as large there."
    )


def _open_ways(names: list[str]) -> str:
    """Return which narrowest places lie in grooves that leave the map, in words."""
    if not names:
        return ""
    axes = " and ".join(name[-1] for name in names)
    return (
        f" Grooves or valleys lead out of the map along {axes}: how wide the narrowest place on them may be "
        "elsewhere is not judged."
    )


def _flag(levelled: xr.DataArray, parts: list[Part], incomplete: bool, step: _Step) -> str:
    """Return what is wrong with the ensemble, in words; empty where nothing is."""
    ny, nx = levelled.isel(parts[0]).shape
    if len(parts) == 1:
        return (
            f"The map is too small to tell how far its result stands for the surface: {nx} x {ny} points "
            "make no ensemble of windows. Measure more places, or a larger one."
        )
    if incomplete:
        return "Part of the ensemble of windows missed the tolerance."
    if step.growth > _STILL_GROWING:
        return (
            "The heights grow with the length of the map: the surface has waves about as long as the map, or "
            f"a form. Over {number(step.extent)} times the length they are expected to be "
            f"{number(math.exp(step.growth))} times as large, and the mean gap may be farther off than the "
            "interval says. Measure a larger field, or take long waves off (level.form, level.l_filter)."
        )
    kurtosis = levelled.attrs.get("Sku", 3.0)
    if kurtosis > _ISOLATED:
        return (
            f"A few places, deep pits or high peaks, hold most of the mean square height (Sku = "
            f"{number(kurtosis)}): how many there are elsewhere one map cannot tell. Measure more places."
        )
    if step.freedom < _FEW_STRIPS:
        return (
            f"The surface has a lay, and parts along it show the same ridges: the {len(parts)} parts tell no "
            "more than three would. Measure a map that is longer across the lay, or more places."
        )
    return ""
