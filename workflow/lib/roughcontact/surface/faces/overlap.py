"""Overlap of two faces: the angle between their axes, and their common grid."""

from collections.abc import Sequence

import numpy as np

from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.surface.faces.face import POINT_TOLERANCE, Face

STEP_TOLERANCE = 1e-6  # relative difference of two steps that count as equal
_MAX_POINTS = 2**27  # the same limit as for a file
_ANGLE_DIGITS = 12  # of cosine and sine: two axes that differ by less count as parallel


def cosine_and_sine(rotation: float) -> tuple[float, float]:
    """Return cosine and sine of an angle, exact at right angles.

    Examples
    --------
    >>> [tuple(map(float, cosine_and_sine(angle))) for angle in (0, 90, 180)]
    [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)]
    """
    # cosines of right angles are 6e-17 otherwise, and points would not meet
    turn = np.exp(1j * np.radians(rotation)).round(_ANGLE_DIGITS)
    return float(turn.real), float(turn.imag)


def axis_order(pair: Sequence, turn: tuple[float, float]) -> tuple | None:
    """Return sides, steps or points (y, x) of the counter-face in the order of the axes of the face.

    `turn` is (cosine, sine) of its rotation; None at an oblique angle.

    Examples
    --------
    >>> axis_order((3, 1), (0.0, 1.0)), axis_order((3, 1), (0.6, 0.8))
    ((1, 3), None)
    """
    if turn[1] == 0:
        return tuple(pair)
    return tuple(pair[::-1]) if turn[0] == 0 else None


class Pair:
    """Two faces, the upper one turned over and placed on the lower one.

    `name` has those of both files; `rotation` (degree) and `shift` (y, x; m) are those of the middle of the
    upper face, `turn` is (cosine, sine) of the rotation.
    """

    def __init__(self, lower: Face, upper: Face, rotation: float, shift: Sequence[float] = (0.0, 0.0)):
        """Refuse a map and a profile, and an invalid shift or rotation."""
        self.lower, self.upper, self.shift = lower, upper, shift
        self.name = f"{lower.name} + {upper.name}"
        across = [n == 1 for n in lower.shape]
        if across != [n == 1 for n in upper.shape]:
            raise HeightMapError(
                f"{self.name}: a map and a profile have no composite height: measure two maps or two profiles"
            )
        if len(shift) != 2 or not np.isfinite(shift).all():
            raise SettingsError(f"shift = {shift!r}: give two lengths (y, x) in m")
        if not np.isfinite(rotation):
            raise SettingsError(f"rotation = {rotation!r}: give an angle in degrees")
        # a profile has no second direction, along which a shift would mean something
        if any(across) and (rotation or any(s for s, single in zip(shift, across, strict=True) if single)):
            raise SettingsError(
                f"{self.name}: profiles can only be shifted along their length (composite.rotations: [0])"
            )
        self.turn = cosine_and_sine(rotation)

    def has_common(self, sides: str) -> bool:
        """Return whether both faces have the same `lengths` or `step` along each axis of the lower one."""
        # turned by other angles a square period does not repeat along the axes
        of_upper = axis_order(getattr(self.upper, sides), self.turn)
        of_lower = getattr(self.lower, sides)
        return of_upper is not None and np.allclose(of_upper, of_lower, rtol=STEP_TOLERANCE, atol=0)

    def is_periodic(self) -> bool:
        """Return whether the sum of both faces is periodic with the period of the lower one."""
        return self.lower.periodic and self.upper.periodic and self.has_common("lengths")

    def grid(self) -> list[np.ndarray]:
        """Return the grid [y, x] (m, from the middle of the lower face) on the overlap of both faces.

        It is that of the lower face, refined along an axis where the upper face has the smaller step.
        """
        lower, upper = self.lower, self.upper
        # at other angles points never meet: the finer of both steps decides
        steps = axis_order(upper.step, self.turn) or (min(upper.step),) * 2
        half_y, half_x = ((n - 1) * d / 2 for n, d in zip(upper.shape, upper.step, strict=True))
        cosine, sine = (abs(v) for v in self.turn)
        # half sides of the rectangle around the turned face
        half = half_y * cosine + half_x * sine, half_x * cosine + half_y * sine
        ranges = []
        for axis, points in enumerate(lower.shape):
            number, step = points, lower.step[axis]
            origin = -(points - 1) * step / 2
            if points > 1 and steps[axis] < step * (1 - STEP_TOLERANCE):  # refined evenly
                # a period has as many intervals as points, a line one less
                length = (points - (not lower.periodic)) * step
                intervals = int(np.ceil(length / steps[axis] - POINT_TOLERANCE))
                number, step = intervals + (not lower.periodic), length / intervals
            start, stop = 0, number
            if not upper.periodic:
                # points on the border belong to the overlap, whatever their rounding
                low, high = (self.shift[axis] + side * half[axis] - origin for side in (-1, 1))
                start = max(0, int(np.ceil((low - POINT_TOLERANCE * step) / step)))
                stop = min(number, int(np.floor((high + POINT_TOLERANCE * step) / step)) + 1)
            if stop - start < min(number, 2):
                raise HeightMapError(f"{self.name}: the faces do not overlap: choose a smaller shift")
            ranges.append((start, stop, origin, step))
        ny, nx = (stop - start for start, stop, _, _ in ranges)
        if ny * nx > _MAX_POINTS:
            raise HeightMapError(
                f"{self.name}: the common grid has {ny} x {nx} points, more than the limit of {_MAX_POINTS}: "
                "the steps of the two maps are too different; crop one of them"
            )
        return [origin + step * np.arange(start, stop) for start, stop, origin, step in ranges]

    def covered_share(self, positions: Sequence[np.ndarray]) -> float:
        """Return the share (0 to 1) of the lower face that the positions of its `grid` span."""
        shares = [
            # cells, not points: the last point has a cell, too
            1.0 if n == 1 else (p[-1] - p[0] + p[1] - p[0]) / ((n - 1) * d + p[1] - p[0])
            for p, n, d in zip(positions, self.lower.shape, self.lower.step, strict=True)
        ]
        return min(1.0, float(np.prod(shares)))
