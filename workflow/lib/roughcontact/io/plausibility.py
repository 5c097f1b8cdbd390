"""Suspicions about a map that was read well, in words for the user. None of them changes a number."""

import numpy as np

from roughcontact.quantities import quantity

_SAMPLE = 2**18  # quantiles and distinct values are estimated from about this many points


def suspicions(height: np.ndarray, dx: float, dy: float) -> list[str]:
    """Return what looks wrong in a map.

    Parameters
    ----------
    height : array (ny, nx)
        Heights, m; NaN where not measured; at least one point is measured.
    dx, dy : float
        Steps, m.

    Returns
    -------
    list of str
        One sentence per suspicion, each with the numbers it rests on.
    """
    measured = height[np.isfinite(height)]
    low, high = measured.min(), measured.max()
    found = _geometry(height.shape, high - low, dx, dy)
    if low == high:
        return [
            *found,
            f"all heights are equal ({quantity(low, 'm')}): the map is flat or holds no measurement",
        ]
    found += _extremes(measured, low, high)
    found += _lines(height)
    found += _noise(height)
    return found


def _geometry(shape, span, dx, dy):
    found = []
    ny, nx = shape
    field = max(nx * dx, ny * dy if ny > 1 else 0)
    if span > field:
        found.append(
            f"the heights span {quantity(span, 'm')}, more than the field of {quantity(field, 'm')}: check "
            "the height unit"
        )
    # a step that is a multiple of the other was chosen by the user; an odd one comes of a file that was cut
    ratio = max(dx / dy, dy / dx)
    if ny > 1 and abs(ratio / round(ratio) - 1) > 0.01:
        found.append(
            f"the pixels are not square: dx = {quantity(dx, 'm', digits=4)}, "
            f"dy = {quantity(dy, 'm', digits=4)}: check the size of the map, or whether the file was cut"
        )
    if not 1e-11 < min(dx, dy) < 1e-2 or field > 1:
        found.append(
            f"steps of {quantity(dx, 'm')} and a field of {quantity(field, 'm')} are unusual for a roughness "
            "measurement: "
            "check the lateral unit"
        )
    return found


def _extremes(measured, low, high):
    found = []
    if measured.size < 100:
        return found
    sample = measured[:: max(1, measured.size // _SAMPLE)]
    lower, upper = np.quantile(sample, [0.005, 0.995])
    reach = 3 * (upper - lower)
    for count, side, worst in (
        (np.count_nonzero(measured < lower - reach), "below", f"down to {quantity(low, 'm')}"),
        (np.count_nonzero(measured > upper + reach), "above", f"up to {quantity(high, 'm')}"),
    ):
        if count:
            found.append(
                f"{count} points lie far {side} all others ({worst}, where 99 % lie between "
                f"{quantity(lower, 'm')} and {quantity(upper, 'm')}): spikes, dust, or a marker for missing "
                "points that was taken for a height; level.outlier_threshold finds isolated ones"
            )
    levels = np.unique(sample).size
    if levels < 64:
        found.append(f"only {levels} different heights occur: the height is coarsely quantised")
        return found
    for value, name in ((low, "lowest"), (high, "highest")):
        share = np.count_nonzero(measured == value) / measured.size
        if share > 0.005:
            found.append(
                f"{share:.1%} of the points have exactly the {name} height ({quantity(value, 'm')}): "
                "the instrument was saturated there, or this marks missing points"
            )
    return found


def _lines(height):
    found = []
    for values, name in ((height, "rows"), (height.T, "columns")):
        count, length = values.shape
        if count < 4 or length < 4:
            continue
        first = np.take_along_axis(values, np.argmax(np.isfinite(values), axis=1)[:, None], axis=1)
        finite = np.isfinite(values)
        flat = np.all((values == first) | ~finite, axis=1) & (finite.sum(axis=1) > 1)
        if 0 < flat.sum() < count / 2:
            found.append(
                f"{flat.sum()} of {count} {name} are constant: lost lines or a marker for missing points"
            )
            continue
        same = np.all((values[1:] == values[:-1]) | (~finite[1:] & ~finite[:-1]), axis=1) & finite[1:].any(
            axis=1
        )
        if 0 < same.sum() < count / 2:
            found.append(f"{same.sum()} of {count} {name} repeat the one before exactly: lost lines")
    return found


def _noise(height):
    """Suspect a map whose neighbours are unrelated both ways: so look files that were damaged on the way."""
    correlations = []
    for first, second in ((height[:, :-1], height[:, 1:]), (height[:-1], height[1:])):
        both = np.isfinite(first) & np.isfinite(second)
        if both.sum() < 1000:
            return []
        a, b = first[both], second[both]
        a, b = a - a.mean(), b - b.mean()
        norm = np.sqrt(np.dot(a, a) * np.dot(b, b))
        correlations.append(np.dot(a, b) / norm if norm > 0 else 1.0)
    if max(correlations) < 0.1:
        return [
            f"neighbouring points are unrelated (correlation {correlations[0]:.2f} along x, "
            f"{correlations[1]:.2f} along y): pure noise, or a binary file whose line ends were converted"
        ]
    return []
