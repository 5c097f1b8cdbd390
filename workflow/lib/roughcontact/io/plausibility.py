"""Warnings about implausible properties of a map that was read. They change no number."""

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from roughcontact.arguments.checking import MAX_GRADIENT
from roughcontact.arguments.quantities import number, percent, quantity
from roughcontact.io.guards import sentence
from roughcontact.io.instrument_kinds import UNKNOWN, Kind

_SAMPLE = 2**18  # quantiles and distinct values are estimated from about this many points
_MAX_PIXEL_RATIO = 4.04  # ratio of the steps above which a slip is more likely than a choice
_FLATTEST = 1e-8  # rms gradient below that of polished optics
_PLATEAU = 0.005  # share of the points at one height
_FEW_LEVELS = 64
_NEIGHBOURS = 40  # levels on either side of one that tell how many points chance brings there
_SINGLE = (5e-8, 1.3e-7)  # smallest and largest step of single precision over the number
_CENTRAL_QUANTILES = (0.005, 0.995)  # quantiles that enclose nearly all heights


class Suspicion(NamedTuple):
    """One implausible property: what it concerns, a sentence with numbers, and what to do.

    The kind ``pixels`` is that of pixels that are not square, which are usual.
    """

    kind: Literal["pixels", "units", "spikes", "heights"]
    finding: str
    advice: str = ""

    def __str__(self) -> str:
        return f"{self.finding}; {self.advice}" if self.advice else self.finding


def suspicions(height: np.ndarray, dx: float, dy: float, *, kind: Kind = UNKNOWN) -> list[Suspicion]:
    """Return the implausible properties of a map (ny, nx; m; steps in m), with the numbers they rest on."""
    finite = height[np.isfinite(height)]
    low, high = finite.min(), finite.max()
    levels, counts = counted_levels(finite)
    spikes = list(_extremes(finite, isolated_ends(levels), low, high))
    doubts = _geometry(height.shape, dx, dy)
    # a few points far from all others determine the span: they have a warning of their own
    span = np.ptp(np.quantile(_sample(finite), _CENTRAL_QUANTILES)) if spikes else high - low
    units = list(_ranges(height.shape, span, dx, dy, kind))
    if low == high:
        heights = [f"all heights are equal ({quantity(low, 'm')}): the map is flat or holds no measurement"]
    else:
        units += _slopes(height, dx, dy)
        heights = [*_levels(height, finite, levels, counts), *_lines(height), *_noise(height)]
    doubts += [Suspicion("units", finding) for finding in units]
    doubts += [Suspicion("spikes", text, "level.outlier_threshold finds isolated ones") for text in spikes]
    return doubts + [Suspicion("heights", finding) for finding in heights]


def roughness_off_plane(height: np.ndarray, dx: float, dy: float) -> tuple[float, float]:
    """Return rms height (m) and rms gradient of a map (ny, nx; m) off its least-squares plane.

    The gradient, sqrt(var(dh/dx) + var(dh/dy)), is between measured neighbours, NaN where there are none.
    """
    is_finite = np.isfinite(height)
    count = np.count_nonzero(is_finite)
    z = np.where(is_finite, height, 0.0)
    z = np.where(is_finite, z - z.sum() / count, 0.0)
    y, x = (np.arange(n) - (n - 1) / 2 for n in height.shape)
    # normal equations of 1, x, y from sums along rows and columns, without map-sized arrays for x and y
    columns, rows = is_finite.sum(axis=0), is_finite.sum(axis=1)
    sum_x, sum_y, sum_xy = columns @ x, rows @ y, y @ (is_finite @ x)
    normal = [[count, sum_x, sum_y], [sum_x, columns @ x**2, sum_xy], [sum_y, sum_xy, rows @ y**2]]
    plane = np.linalg.lstsq(normal, [0.0, z.sum(axis=0) @ x, z.sum(axis=1) @ y], rcond=None)[0]
    residual = np.where(is_finite, z - plane[0] - plane[1] * x - (plane[2] * y)[:, None], 0.0)
    slopes = [np.diff(height, axis=1) / dx, np.diff(height, axis=0) / dy]
    spread = [slope[np.isfinite(slope)].var() for slope in slopes if np.isfinite(slope).any()]
    return float(np.sqrt((residual**2).sum() / count)), float(np.sqrt(sum(spread))) if spread else np.nan


def quantisation_step(height: np.ndarray) -> float | None:
    """Return the step (m) of which all heights (m, NaN where not measured) are multiples, or None.

    It is the usual distance of neighbouring levels, if the levels lie on its lattice to a tenth of it.
    """
    sample = _sample(height.reshape(-1))  # large maps leave no room for a copy
    levels = np.unique(sample[np.isfinite(sample)])
    largest, gaps = np.abs(levels).max(initial=0.0), np.diff(levels)
    # far from zero, single precision itself rounds to steps
    if gaps.size > 1 and max(_SINGLE[0] * largest, 1e-3 * levels.std()) < gaps.min() < _SINGLE[1] * largest:
        return float(gaps.min())
    # levels that single precision cannot distinguish are one level
    rounding = 4e-7 * largest
    gaps = gaps[gaps > rounding]
    if gaps.size < 2:
        return None
    step = np.median(gaps[gaps < 1.5 * gaps.min()])
    # a chance result for continuous heights is far smaller than their mean distance
    level_numbers = (levels - levels[0]) / step
    drift = np.abs(level_numbers - np.rint(level_numbers))
    return float(step) if step >= 2 * rounding and np.mean(drift < 0.1) >= 0.9 else None


def counted_levels(heights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the different values of heights, rising, and how many heights have each, of a sample."""
    return np.unique(_sample(heights), return_counts=True)


def frequent_levels(levels: np.ndarray, counts: np.ndarray, minimum: int = 4) -> list[tuple[float, float]]:
    """Return the levels with far more of the heights than chance brings there, and their shares.

    They have the `minimum` of points and more, and three times as many as each of the forty levels on either
    side.

    Examples
    --------
    >>> frequent_levels(*counted_levels(np.append(np.arange(0.5, 90.0), [7.0] * 10)))
    [(7.0, 0.1)]
    """
    shares = counts / counts.sum()
    candidates = np.flatnonzero((counts >= minimum) & (shares > _PLATEAU))
    padded = np.pad(counts, _NEIGHBOURS, constant_values=1)
    around = np.delete(np.arange(2 * _NEIGHBOURS + 1), _NEIGHBOURS)  # of each in the padded counts
    frequent = candidates[counts[candidates] >= 3 * padded[candidates[:, None] + around].max(axis=1)]
    return [*zip(levels[frequent].tolist(), shares[frequent].tolist(), strict=True)]


def isolated_ends(levels: np.ndarray) -> list[float]:
    """Return the lowest and the highest of rising levels, where it is further from all others than they span.

    Examples
    --------
    >>> isolated_ends(np.append(np.arange(9.0), 40.0)), isolated_ends(np.arange(9.0))
    ([40.0], [])
    """
    extremes = zip(levels[[0, -1]], np.diff(levels)[[0, -1]], strict=True) if levels.size > 3 else ()
    return [float(height) for height, gap in extremes if 2 * gap > np.ptp(levels)]


def _sample(heights: np.ndarray) -> np.ndarray:
    """Return about `_SAMPLE` of the heights, evenly taken."""
    return heights[:: max(1, heights.size // _SAMPLE)]


def _geometry(shape: tuple[int, ...], dx: float, dy: float) -> list[Suspicion]:
    """Suspect pixels that are not square."""
    ny, nx = shape
    ratio = max(dx / dy, dy / dx)
    # one step a small multiple of the other is a user's choice; an odd ratio suggests a file that was cut off
    if ny == 1 or (ratio < _MAX_PIXEL_RATIO and abs(ratio / round(ratio) - 1) <= 0.01):
        return []
    steps = "dx = {}, dy = {}".format(*(quantity(step, "m", digits=4) for step in (dx, dy)))
    doubts = f"the pixels are not square: {steps}: "
    if abs(nx * dx / ny / (ny * dy / nx) - 1) <= 0.01:
        swap = "rows and columns, or the two sizes, were exchanged"
        return [Suspicion("units", f"{doubts}they would be with {nx} rows of {ny} points: {swap}")]
    if ratio > _MAX_PIXEL_RATIO:
        advice = f"one is {number(ratio)} times the other: check both, and their units"
        return [Suspicion("units", doubts + advice)]
    return [Suspicion("pixels", doubts + "check the size of the map, or whether the file was cut")]


def _ranges(shape: tuple[int, ...], span: float, dx: float, dy: float, kind: Kind) -> Iterator[str]:
    """Compare steps, field and heights with each other and with the ranges of the kind of instrument."""
    ny, nx = shape
    steps, fields = [dx, dy][:ny], [nx * dx, ny * dy][:ny]
    if span > max(fields):
        relation = f"{quantity(span, 'm')}, more than the field of {quantity(max(fields), 'm')}"
        yield f"the heights span {relation}: check the height unit"
    for values, (low, high), quantity_name, unit in (
        (steps, kind.step, "steps of {} are", "lateral"),
        (fields, kind.field, "a field of {} is", "lateral"),
        ([span] if span > 0 else [], kind.span, "heights that span {} are", "height"),
    ):
        for wrong in [value for value in values if not low <= value <= high][:1]:
            usual = f"unusual for {kind.words} ({quantity(low, 'm')} to {quantity(high, 'm')})"
            yield f"{quantity_name.format(quantity(wrong, 'm'))} {usual}: check the {unit} unit"


def _slopes(height: np.ndarray, dx: float, dy: float) -> Iterator[str]:
    """Suspect slopes that no instrument measures."""
    _, gradient = roughness_off_plane(height, dx, dy)
    size = f"rms gradient {number(gradient)}"
    wrong = f"smaller than those of polished optics ({size})" if 0 < gradient < _FLATTEST else ""
    if gradient > MAX_GRADIENT:
        wrong = f"steeper than anything that is measured ({size}, {np.degrees(np.arctan(gradient)):.0f}°)"
    if wrong:
        yield f"the slopes are {wrong}: check the units of heights and steps"


def _extremes(heights: np.ndarray, isolated: list[float], low: float, high: float) -> Iterator[str]:
    """Suspect points far from all others, among them the `isolated` ones."""
    if heights.size < (_NEIGHBOURS if isolated else 100):
        return
    is_far = np.isin(heights, isolated)
    lower, upper = np.quantile(_sample(heights[~is_far] if isolated else heights), _CENTRAL_QUANTILES)
    reach = 3 * (upper - lower)
    is_far |= (heights < lower - reach) | (heights > upper + reach)
    for is_side, where in (
        (heights < lower, f"below all others (down to {quantity(low, 'm')}"),
        (heights > upper, f"above all others (up to {quantity(high, 'm')}"),
    ):
        if count := np.count_nonzero(is_far & is_side):
            points = f"{count} points lie" if count > 1 else "1 point lies"
            between = quantity(lower, "m"), quantity(upper, "m")
            yield sentence("far points", points=points, where=where, between=between)


def _levels(height: np.ndarray, heights: np.ndarray, levels: np.ndarray, counts: np.ndarray) -> Iterator[str]:
    """Suspect few levels that are no multiples of a step, and plateaus; of a step the statistics judge."""
    low, high = heights.min(), heights.max()
    is_large = heights.size >= 100
    has_many = is_large and levels.size >= _FEW_LEVELS
    if is_large and not has_many and quantisation_step(height) is None:
        yield f"only {levels.size} different heights occur, at odd distances"
    if heights.size < _NEIGHBOURS or (not has_many and 2 * levels.size < heights.size):
        return  # what chance brings to few levels is not known
    for value, name in ((low, "lowest"), (high, "highest")) if has_many else ():
        count = np.count_nonzero(heights == value)
        share = count / heights.size
        if count > 1 and share > _PLATEAU:  # one point is always at the extreme
            yield sentence("saturated", share=percent(share), name=name, value=quantity(value, "m"))
    candidates = [pair for pair in frequent_levels(levels, counts) if not has_many or low < pair[0] < high]
    for level, level_share in sorted(candidates, key=lambda pair: pair[1])[-1:]:
        yield sentence("plateau", share=percent(level_share), value=quantity(level, "m"))


def _lines(height: np.ndarray) -> Iterator[str]:
    """Suspect rows and columns that are constant or equal to the preceding one."""
    for values, name in ((height, "rows"), (height.T, "columns")):
        count, length = values.shape
        if count < 4 or length < 4:
            continue
        finite = np.isfinite(values)
        reference = np.take_along_axis(values, np.argmax(finite, axis=1)[:, None], axis=1)
        long_enough = finite.sum(axis=1) > max(3, length // 100)  # lines of three points are inconclusive
        flat = np.all((values == reference) | ~finite, axis=1) & long_enough
        repeats = np.all((values[1:] == values[:-1]) | ~(finite[1:] | finite[:-1]), axis=1) & long_enough[1:]
        if 0 < flat.sum() < count / 2:
            yield f"{flat.sum()} of {count} {name} are constant: lost lines or a marker for missing points"
        elif 0 < repeats.sum() < count / 2:
            yield f"{repeats.sum()} of {count} {name} repeat the one before exactly: lost lines"
        elif not repeats.any() and np.array_equal(values[: count // 2], values[count // 2 :], equal_nan=True):
            yield f"the second half of the {name} repeats the first exactly: exported twice, or periodic"


def _noise(height: np.ndarray) -> Iterator[str]:
    """Suspect a map with neighbours uncorrelated along x and y, as in files damaged by a transfer."""
    correlations = []
    for a, b in ((height[:, :-1], height[:, 1:]), (height[:-1], height[1:])):
        both_finite = np.isfinite(a) & np.isfinite(b)
        if both_finite.sum() < 1000:
            return
        with np.errstate(all="ignore"):  # equal heights have no correlation
            correlations.append(np.corrcoef(a[both_finite], b[both_finite])[0, 1])
    if np.max(correlations) < 0.1:
        yield sentence("unrelated neighbours", x=correlations[0], y=correlations[1])
