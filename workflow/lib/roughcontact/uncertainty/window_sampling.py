"""Sampling uncertainty of a window: the result of a map as an estimate for a larger surface.

A map is a sample: it covers one place, and contains waves up to its own length. The interval is for the
surface, here or elsewhere, over `extent` times the length of the map, under the same mean pressure. It has
two contributions.

* Scatter between places. The window is divided into subwindows (3 x 3), each levelled, made periodic and
  solved like the window. Let s be the standard deviation of the logarithm of their results and r the length
  of the window over that of a subwindow. The standard deviation of the window's result is s r^(-(1 - H)
  D/2). Subwindows longer than the longest wave are independent samples, H = 0: in two dimensions, D = 2,
  this is s/r, the s/sqrt(m) of m = r^2 samples. On a surface with waves of all lengths a longer surface
  differs from the window as the window does from a subwindow, H = 1, and the number of subwindows does not
  reduce the uncertainty. H is the growth exponent of the heights (`growth`), at least 0.25, because real
  surfaces are less uniform than stationary random ones. D is 2, or less on a surface with a lay, where
  subwindows along the lay contain the same ridges.
  The surface of `extent` times the length scatters as well: factor sqrt(1 + extent^(-(1 - H) D)).
* Growth from longer waves. The heights of the longer surface are extent^a times those of the map, where a is
  the growth exponent without its lower limit. The window is solved again with its heights scaled by this
  factor; the resulting increase of the mean gap, plus a quarter of it because a is an estimate, is the
  upper half-width due to growth. The gap grows faster than the heights, because the same pressure closes a
  smaller share of it: with u(p) the gap of the map, heights n times as large give the gap n u(p/n), and
  d ln(n u)/d ln n = 1 + p/(K u), where K = -dp/du is the stiffness. Area and pressure in contact may continue
  to change as they did from the subwindows to the window, H times, in either direction.

Scatter is evaluated on the logarithm of a quantity; for the area A on the logarithm of x = erfinv(A), which
is proportional to A at low loads. The reason is A = erf(sqrt(2) p/(E* g)) of Persson (2001): where the
gradient g differs from place to place, ln x is shifted equally at all loads, whereas A follows only while it
is small and never exceeds 1. The pressure in contact is the load over the area and has its relative
uncertainty.

The largest pressure is an extreme value and grows with the surface without limit. It is taken as the maximum
over extent^D maps. The maximum of n normal variates lies near sqrt(2 ln n) standard deviations with a scatter
of order 1/sqrt(2 ln n) (Gumbel, Statistics of Extremes, 1958). Accordingly, the scatter of its logarithm is
that of the subwindows' peaks, and it grows by the scale of the Gumbel distribution, s sqrt(6)/pi, times the
logarithm of the number of maps.

All constants are calibrated on measured and synthetic surfaces (docs/explanation/uncertainty.md).
"""

import json
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import scipy
import xarray as xr

from roughcontact.checking import check_map
from roughcontact.errors import SettingsError
from roughcontact.levelling.polynomial import fit_polynomial, without_form
from roughcontact.maps import spacing
from roughcontact.quantities import number, percent
from roughcontact.roughness.texture import texture_parameters
from roughcontact.uncertainty.answers import (
    CONSTRICTIONS,
    answers_present,
    constrictions_in_grooves,
    counter_of,
    interval_from_subwindows,
    quantities_in,
    with_common_lower_end,
)
from roughcontact.uncertainty.ensemble import Member, at_all_loads, measured_slices, solve_member
from roughcontact.uncertainty.growth import form_order, growth_exponent
from roughcontact.uncertainty.headline import QUANTITIES
from roughcontact.uncertainty.representative_loads import (
    interpolate_over_loads,
    ratio,
    representative_loads,
)
from roughcontact.uncertainty.scaling import CONDUCTANCE, effort
from roughcontact.window.periodic_window import periodic_window

_TOLERANCE = 1e-2  # of the pressure: 0.4 % of the area (rms), where subwindows differ by 5 % and more
_MIN_POINTS_PER_SIDE = 12  # of a subwindow
_MIN_WAVES_PER_SIDE = 2  # side of a subwindow over the shortest wavelength that is kept
_COVERAGE = 0.95
_DEFAULT_EXTENT = 3.0
_GAP_MARGIN = 1.25  # on the scatter of the mean gap: the largest of a few valleys decide it
_MIN_EXPONENT = 0.25  # real surfaces scatter more than stationary ones, which have 0
_GROWTH_MARGIN = 1.25  # factor on the increase of the mean gap expected from growing heights
_CLOSE_LOADS = 2.0  # ratio of two loads between which the gap is interpolated, within 2 % of its growth
_MIN_DEGREES_OF_FREEDOM = 2.0  # however strong the lay
_LOGARITHM_FLOOR = 1e-2  # of the window's result: the logarithm of smaller gaps is meaningless
_FEW_DEGREES_OF_FREEDOM = 2.5  # below this limit a lay leaves about three independent subwindows
_KURTOSIS_FLAG_LIMIT = 8.0  # above this limit a few places hold most of the mean square height

Subwindow = dict[str, slice]  # rows ("y") and columns ("x") of a map


def window_uncertainty(
    levelled: xr.DataArray,
    *,
    window: Mapping[str, Any],
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    number: int = 9,
    extent: float = _DEFAULT_EXTENT,
    chosen: xr.DataArray | None = None,
) -> xr.Dataset:
    """Return the expanded uncertainty of a window's result as a sample of its surface.

    In the logarithm (of erfinv(A) for the area A [3]_) the lower half-width is t s r^(-(1 - H) D/2) sqrt(1 +
    extent^(-(1 - H) D)), the upper one the root of the sum of squares of this and of the growth; t is
    Student's factor for 95 % and r^D - 1 degrees of freedom [1]_. The module docstring explains s, r, H, D
    and the growth. The largest pressure follows extreme-value statistics [2]_.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.
    window, contact : dict
        keyword arguments of `periodic_window` and `solve_contact` (loads included) that led to the result.
    solved : Dataset
        the result: `QUANTITIES` along `load`.
    number : int
        maximum number of subwindows, 4 or more; 9 divides a map into 3 x 3 and a profile into 9.
    extent : float
        length of the surface that the interval is for, over that of the map; 1 or more.
    chosen : DataArray (y, x), m, optional
        result of `periodic_window` for the map; computed where it is not given.

    Returns
    -------
    Dataset
        along `load`, for each of the four quantities the expanded uncertainty `{name}_down` and `{name}_up`
        below and above the result, `{name}` the larger of them; NaN where the window is too small to be
        divided. The same for the answers that `solved` contains, `{name}_up` infinite where nothing in the
        map bounds them. Along (member, load) the unscaled results of the subwindows, `{name}_members`, NaN at
        loads between closely spaced ones, where the relative half-widths are interpolated; along
        `member` their `member_offset_y`, `member_offset_x`, `member_length_y`, `member_length_x` (m, in the
        map, including the band that periodisation blends). Attributes: `extent`, `coverage_factor` (t),
        `degrees_of_freedom`, `growth` (factor on the heights), `map_share` (share of the map that the
        subwindows cover), `reason` (description of the ensemble), `flag` (its deficiency, empty for none),
        `work` (FFT pairs times points).

    Raises
    ------
    SettingsError
        where `number` is below 4 or `extent` below 1.
    ConvergenceError
        where the solution of a subwindow misses its tolerance.

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
    whole = measured_slices(levelled, chosen)
    parts = _subwindows(whole, spacing(levelled), int(number), window.get("shortest_wavelength") or 0.0)
    own = {**window, "placement": "largest", "min_share": 0.0}
    count, load = counter_of(solved), solved["mean_pressure"].values
    # members differ by more than a result changes between closely spaced loads
    some = representative_loads(load, solved["relative_contact_area"].values)
    result, contact = solved.isel(load=some), {**contact, "mean_pressure": load[some]}
    members = []
    for part in parts:
        periodic = periodic_window(_relevelled(levelled.isel(part), form_order(levelled)), **own)
        members.append(solve_member(periodic, contact, tolerance=_TOLERANCE, count=count))
    extrapolation = _extrapolation(chosen, levelled.isel(whole), parts=len(parts), extent=extent)
    names = quantities_in(solved)
    values = {name: np.array([member.values[name] for member in members]) for name in names}
    widths, work = _half_widths(values, result, extrapolation), sum(member.work for member in members)
    grown: dict[str, np.ndarray] = {}
    if extrapolation.growth > 0 and len(parts) > 1:
        member = _solve_grown(chosen, contact, solved, math.exp(extrapolation.growth))
        grown, work = member.values, work + member.work
        down, up = widths["mean_gap"]
        added = np.maximum(grown["mean_gap"] - result["mean_gap"].values, 0.0)
        widths["mean_gap"] = down, np.hypot(up, _GROWTH_MARGIN * added)
    open_directions = constrictions_in_grooves(chosen) if answers_present(solved) else []
    for name in answers_present(solved):
        half_way = result[f"{name}_half_way"].values if f"{name}_half_way" in result else None
        down, up = interval_from_subwindows(
            name,
            values[name],
            result[name].values,
            factor=extrapolation.scatter,
            extent_factor=extrapolation.extent_factor,
            grown=grown.get(name),
            half_way=half_way,
        )
        if name in open_directions and half_way is not None:
            up = np.where(half_way > 0, np.inf, up)
        widths[name] = down, up
    if extrapolation.dimensions == 2:  # no lay
        widths |= with_common_lower_end(widths, result)
    below, above = (at_all_loads({n: w[side] for n, w in widths.items()}, some, solved) for side in (0, 1))
    for name in (name for name in CONSTRICTIONS if name in widths):  # the share that may be closed
        share = ratio(widths[name][0], result[name].values)
        below[name] = solved[name].values * interpolate_over_loads(share, some, load, np.ones(load.shape))
    found: dict[str, tuple] = {}
    for name in names:
        down, up = below[name], above[name]
        of_members = np.full((len(parts), load.size), np.nan)
        of_members[:, some] = values[name]
        found |= {
            name: ("load", np.maximum(down, up)),
            f"{name}_down": ("load", down),
            f"{name}_up": ("load", up),
            f"{name}_members": (("member", "load"), of_members),
        }
    covered = sum(math.prod(levelled.isel(part).shape) for part in parts) / levelled.size
    incomplete = any(np.isnan(member.values["mean_gap"]).any() for member in members)
    return xr.Dataset(
        found | _subwindow_positions(levelled, parts),
        coords={"mean_pressure": ("load", load)},
        attrs={
            "extent": float(extent),
            "coverage_factor": extrapolation.factor,
            "degrees_of_freedom": extrapolation.degrees_of_freedom,
            "growth": math.exp(extrapolation.growth),
            "map_share": covered,
            "reason": _reason(levelled, parts, covered, extrapolation)
            + _open_directions_sentence(open_directions),
            "flag": _flag(levelled, parts, incomplete, extrapolation),
            "work": work,
        },
    )


def _solve_grown(
    window: xr.DataArray, contact: Mapping[str, Any], solved: xr.Dataset, factor: float
) -> Member:
    """Return mean gap and answers of a window, its heights multiplied by a factor, at the loads of `contact`.

    By the scaling law (`roughcontact.uncertainty.scaling`) they are those of the window itself at lower
    loads. Between closely spaced loads of the result they are interpolated, linearly in the logarithm of the
    load.
    """
    count, wanted = counter_of(solved), np.asarray(contact["mean_pressure"], float)
    if contact.get("hardness") is not None:  # it does not grow with the heights
        higher = window.copy(data=window.values * factor)
        return solve_member(higher, contact, tolerance=_TOLERANCE, count=count)
    rising = np.sort(solved["mean_pressure"].values)
    alone = rising[rising > _CLOSE_LOADS * np.r_[0.0, rising[:-1]]]
    lower = {**contact, "mean_pressure": alone / factor}
    member = solve_member(window, lower, tolerance=_TOLERANCE, count=count)
    load = np.r_[alone / factor, solved["mean_pressure"].values]
    order = np.argsort(load)
    values = {}
    for name in ("mean_gap", *answers_present(solved)):
        curve = np.r_[member.values[name], solved[name].values][order]
        at_lower = np.interp(np.log(wanted / factor), np.log(load[order]), curve)
        values[name] = at_lower if name == CONDUCTANCE else factor * at_lower
    return Member(values, member.work)


class _Extrapolation(NamedTuple):
    """Parameters of the extrapolation from a window to the surface.

    Attributes
    ----------
    extent : float
        length of the surface over that of the window.
    ratio : float
        r, length of the window over that of a subwindow.
    dimensions : float
        D: 2 without a lay, 1 for a strong lay and for a profile.
    exponent : float
        H, from 0.25 to 1.
    growth : float
        logarithm of the growth factor of the heights.
    degrees_of_freedom, factor : float
        degrees of freedom of the subwindows' scatter, and their Student factor; NaN for one subwindow.
    """

    extent: float
    ratio: float
    dimensions: float
    exponent: float
    growth: float
    degrees_of_freedom: float
    factor: float

    @property
    def scatter(self) -> float:
        """Half-width over the standard deviation of the subwindows, Student's factor included."""
        each = (1 - self.exponent) * self.dimensions
        return self.factor * self.ratio ** (-each / 2) * math.sqrt(1 + self.extent**-each)

    @property
    def extent_factor(self) -> float:
        """Change from window to surface over that from subwindows to window; 0 for one subwindow."""
        return self.exponent * math.log(self.extent) / math.log(self.ratio) if self.ratio > 1 else 0.0


def _extrapolation(
    chosen: xr.DataArray, measured: xr.DataArray, *, parts: int, extent: float
) -> _Extrapolation:
    """Return the extrapolation to the surface from the window `chosen` of the points `measured`."""
    most = sum(n > 1 for n in measured.shape)
    ratio = parts ** (1 / most)
    isotropy = float(texture_parameters(chosen)["Str"])
    # no lay is assumed for a profile, a flat map and a window too narrow for a texture aspect ratio
    dimensions = float(most) if math.isnan(isotropy) else 1.0 + min(1.0, 2.0 * isotropy)
    exponent = growth_exponent(measured)
    degrees_of_freedom, factor = math.nan, math.nan
    if parts > 1:
        degrees_of_freedom = max(_MIN_DEGREES_OF_FREEDOM, parts ** (dimensions / most) - 1)
        factor = float(scipy.special.stdtrit(degrees_of_freedom, (1 + _COVERAGE) / 2))
    return _Extrapolation(
        extent,
        ratio,
        dimensions,
        min(1.0, max(_MIN_EXPONENT, exponent)),
        exponent * math.log(extent),
        degrees_of_freedom,
        factor,
    )


HalfWidths = tuple[np.ndarray, np.ndarray]  # below and above the result, along `load`


def _half_widths(
    values: dict[str, np.ndarray], solved: xr.Dataset, extrapolation: _Extrapolation
) -> dict[str, HalfWidths]:
    """Return the half-widths of each quantity from values (member, load), without the growth of the gap."""
    result = {name: solved[name].values for name in QUANTITIES}
    if len(values["mean_gap"]) < 2:
        return {name: (np.full(each.shape, np.nan),) * 2 for name, each in result.items()}
    area, load = result["relative_contact_area"], solved["mean_pressure"].values
    down, up = _area_half_widths(values["relative_contact_area"], area, extrapolation)
    some = np.where(area > 0, area, 1.0)
    return {
        "relative_contact_area": (down, up),
        "mean_gap": _gap_half_widths(values["mean_gap"], result["mean_gap"], extrapolation),
        "max_pressure": _peak_half_widths(values["max_pressure"], result["max_pressure"], extrapolation),
        # the load divided by either end of the area
        "mean_contact_pressure": (load / some * up / (some + up), load / some * down / (some - down)),
    }


def _area_half_widths(values: np.ndarray, result: np.ndarray, extrapolation: _Extrapolation) -> HalfWidths:
    """Return the half-widths of the contact area."""
    base = np.where(result > 0, result, 1.0)
    whole, parts = (_log_erfinv(np.maximum(v, _LOGARITHM_FLOOR * base)) for v in (base, values))
    change = np.abs(whole - parts.mean(axis=0))
    half_width = np.hypot(
        extrapolation.scatter * parts.std(axis=0, ddof=1), extrapolation.extent_factor * change
    )
    ends = (scipy.special.erf(np.exp(whole + side * half_width)) for side in (-1, 1))
    down, up = (np.abs(end / scipy.special.erf(np.exp(whole)) - 1) for end in ends)
    return result * down, result * up


def _log_erfinv(area: np.ndarray) -> np.ndarray:
    """Return ln erfinv(A), in Persson's law ln(p/(E* g)) plus a constant."""
    return np.log(effort(area))


def _gap_half_widths(values: np.ndarray, result: np.ndarray, extrapolation: _Extrapolation) -> HalfWidths:
    """Return the half-widths of the mean gap due to scatter."""
    # the logarithm is meaningless where the gap vanishes (full contact)
    base = np.where(result > 0, result, 1.0)
    scatter = _GAP_MARGIN * extrapolation.scatter
    half_width = scatter * np.log(np.maximum(values, _LOGARITHM_FLOOR * base)).std(axis=0, ddof=1)
    alone = scatter * values.std(axis=0, ddof=1)
    return -result * np.expm1(-half_width), np.where(result > 0, result * np.expm1(half_width), alone)


def _peak_half_widths(values: np.ndarray, result: np.ndarray, extrapolation: _Extrapolation) -> HalfWidths:
    """Return the half-widths of the largest pressure, an extreme value over several maps."""
    deviation = np.log(np.maximum(values, _LOGARITHM_FLOOR * result)).std(axis=0, ddof=1)
    maps = math.log(extrapolation.extent) * extrapolation.dimensions
    down = extrapolation.factor * deviation
    up = down + math.sqrt(6) / math.pi * deviation * maps
    return -result * np.expm1(-down), result * np.expm1(up)


def _relevelled(part: xr.DataArray, order: int) -> xr.DataArray:
    """Return a subwindow of a levelled map with the same form removed again; no other step is repeated."""
    if not order:
        return part.assign_attrs(form="none", form_removed="{}")
    heights = check_map(part)
    form, removed = fit_polynomial(heights, (part["y"].values, part["x"].values), order=order)
    record = {"form": "polynomial", "form_removed": json.dumps(removed)}
    return part.copy(data=without_form(heights, form)).assign_attrs(record)


def _sides(part: Subwindow) -> list[int]:
    """Return the numbers of points (ny, nx) of a subwindow."""
    return [part[d].stop - part[d].start for d in "yx"]


def _subwindows(whole: Subwindow, step: tuple[float, float], number: int, shortest: float) -> list[Subwindow]:
    """Return the subwindows of a window, with the largest product of their number and squareness."""
    sides = _sides(whole)
    most = [
        max(1, int(n / max(_MIN_POINTS_PER_SIDE, _MIN_WAVES_PER_SIDE * shortest / s))) if n > 1 else 1
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
    """Return the shorter side of a subwindow over the longer one; 1 for a profile."""
    return 1.0 if 1 in sides else min(length_y, length_x) / max(length_y, length_x)


def _subwindow_positions(levelled: xr.DataArray, parts: list[Subwindow]) -> dict[str, tuple]:
    """Return offsets and lengths of the subwindows in the map, as variables along `member`."""
    found = {}
    for d, step in zip("yx", spacing(levelled), strict=True):
        found[f"member_offset_{d}"] = ("member", [part[d].start * step for part in parts])
        found[f"member_length_{d}"] = ("member", [(part[d].stop - part[d].start) * step for part in parts])
    return found


def _reason(
    levelled: xr.DataArray, parts: list[Subwindow], covered: float, extrapolation: _Extrapolation
) -> str:
    """Return sentences on the scope of the interval and on the ensemble."""
    ny, nx = levelled.isel(parts[0]).shape
    if len(parts) == 1:
        return f"The window of {nx} × {ny} points is too small to be divided into parts."
    return (
        f"The ± is for this surface over {number(extrapolation.extent)} times the length of the map, under "
        f"the same mean pressure. It includes the scatter of {len(parts)} parts of about {nx} × {ny} points, "
        f"{percent(covered)} of the map, each levelled, made periodic and solved separately, and the growth "
        f"of the heights with the length, by an expected factor of {number(math.exp(extrapolation.growth))}."
    )


def _open_directions_sentence(names: list[str]) -> str:
    """Return a sentence on the critical constrictions in grooves that leave the map, empty for none."""
    if not names:
        return ""
    axes = " and ".join(name[-1] for name in names)
    return (
        f" Grooves or valleys lead out of the map along {axes}: their narrowest place has no upper limit, as "
        "it may be wider elsewhere."
    )


def _flag(
    levelled: xr.DataArray, parts: list[Subwindow], incomplete: bool, extrapolation: _Extrapolation
) -> str:
    """Return a sentence on a deficiency of the ensemble, empty for none."""
    ny, nx = levelled.isel(parts[0]).shape
    if len(parts) == 1:
        return (
            f"The map is too small to estimate how well it represents the surface: {nx} × {ny} points cannot "
            "be divided into parts. Measure more places, or a larger one."
        )
    if incomplete:
        return "The solution of a part of the window missed the tolerance."
    kurtosis = levelled.attrs.get("Sku", 3.0)
    if kurtosis > _KURTOSIS_FLAG_LIMIT:
        return (
            "A few places, deep pits or high peaks, contribute most of the mean square height (Sku = "
            f"{number(kurtosis)}): a single map does not tell their number elsewhere. Measure more places."
        )
    if extrapolation.degrees_of_freedom < _FEW_DEGREES_OF_FREEDOM:
        return (
            f"The surface has a lay, and parts along it contain the same ridges: the {len(parts)} parts are "
            "worth no more than three independent ones. Measure a map that is longer across the lay, or more "
            "places."
        )
    return ""
