"""Ensemble of random relative positions of two faces."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.si import as_si
from roughcontact.errors import SettingsError
from roughcontact.surface.faces.face import Face
from roughcontact.surface.faces.overlap import STEP_TOLERANCE, axis_order, check_pair, cosine_and_sine


@as_si
def relative_positions(
    face: xr.DataArray,
    counter_face: xr.DataArray,
    *,
    shifts: int = 5,
    rotations: Sequence[float] = (0.0,),
    overlap: float = 0.75,
    seed: int = 0,
) -> list[dict]:
    """Draw an ensemble of relative positions of two faces: `shifts` random shifts for each rotation.

    Shifts are uniformly distributed up to |a - b| / 2 + (1 - overlap) min(a, b) along each axis, where a is
    the side of the face and b the length of the rotated counter-face through its middle; a periodic
    counter-face is shifted over its whole period. If the points of both maps can coincide, shifts are rounded
    so that they do, and nothing is interpolated.

    Parameters
    ----------
    face, counter_face : DataArray (y, x), m
        from `level`.
    shifts : int
        number of shifts for each rotation.
    rotations : sequence of float, degree
        of the counter-face about its middle.
    overlap : float, 0 to 1
        minimum share of each side of the smaller map that the other one covers.
    seed : int
        of the random numbers; additional shifts or rotations do not change those drawn before.

    Returns
    -------
    list of dict
        `shift` (y, x) in m and `rotation` in degrees: the keyword arguments of `composite`.

    Raises
    ------
    HeightMapError
        for a map and a profile.
    SettingsError
        for an invalid option.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact.arguments.maps import height_map
    >>> face = height_map(np.random.default_rng(0).standard_normal((20, 30)), 1.0)
    >>> for position in rc.relative_positions(face, face, shifts=2, overlap=0.5):
    ...     print(position)
    {'shift': (3.0, -7.0), 'rotation': 0.0}
    {'shift': (-9.0, -15.0), 'rotation': 0.0}
    """
    if seed < 0:
        raise SettingsError(f"composite.seed = {seed!r}: give a whole number of 0 or more")
    if shifts < 1 or not len(rotations):
        raise SettingsError(
            f"composite.shifts = {shifts!r}, composite.rotations = {rotations!r}: give at least one of each"
        )
    if not 0 < overlap <= 1:
        raise SettingsError(f"composite.overlap = {overlap!r}: give a share above 0, up to 1")
    lower, upper = Face(face), Face(counter_face)
    check_pair(lower, upper, (0.0, 0.0), rotations[0])
    placements = []
    for number, rotation in enumerate(rotations):
        turn = cosine_and_sine(rotation)
        # a stream for each rotation: more of them change no earlier ones
        samples = np.random.default_rng([seed, number]).uniform(-1, 1, (shifts, 2))
        reach = _max_shift(lower, upper, turn, overlap)
        placements += [
            {"shift": _aligned_shift(lower, upper, turn, row * reach), "rotation": float(rotation)}
            for row in samples
        ]
    return placements


def _max_shift(lower: Face, upper: Face, turn: tuple[float, float], overlap: float) -> np.ndarray:
    """Return the largest shift (y, x), m."""
    cosine, sine = (abs(v) for v in turn)
    reach = []
    for axis in (0, 1):
        along, across = upper.lengths[axis], upper.lengths[1 - axis]
        # length of the rotated rectangle through its middle
        side = min(along / cosine if cosine else np.inf, across / sine if sine else np.inf)
        face_length = lower.lengths[axis]
        # the shorter side stays covered to its share
        free = abs(face_length - side) / 2 + (1 - overlap) * min(face_length, side)
        if upper.periodic:  # any shift within half a period
            free = side / 2
        reach.append(0.0 if lower.shape[axis] == 1 else free)  # a profile does not move across itself
    return np.array(reach)


def _aligned_shift(
    lower: Face, upper: Face, turn: tuple[float, float], shift: np.ndarray
) -> tuple[float, ...]:
    """Return the nearest shift for which the points of both maps coincide, or `shift` if there is none."""
    steps, points = axis_order(upper.step, turn), axis_order(upper.shape, turn)
    if steps is None or points is None or not np.allclose(steps, lower.step, rtol=STEP_TOLERANCE, atol=0):
        return tuple(map(float, shift))
    # of unlike numbers of points the middles lie half a pixel apart
    odd = [(n - m) % 2 / 2 for n, m in zip(lower.shape, points, strict=True)]
    return tuple(
        float((np.rint(s / d - half) + half) * d) for s, d, half in zip(shift, lower.step, odd, strict=True)
    )
