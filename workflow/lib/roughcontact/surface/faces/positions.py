"""Ensemble of random relative positions of two faces."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.si import as_si
from roughcontact.errors import SettingsError
from roughcontact.surface.faces.face import Face
from roughcontact.surface.faces.overlap import Pair, axis_order


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
    placements = []
    for number, rotation in enumerate(rotations):
        pair = Pair(lower, upper, rotation)
        # a stream for each rotation: more of them change no earlier ones
        samples = np.random.default_rng([seed, number]).uniform(-1, 1, (shifts, 2))
        shifts_there = samples * _max_shift(pair, overlap)
        placements += [
            {"shift": _aligned_shift(pair, shift), "rotation": float(rotation)} for shift in shifts_there
        ]
    return placements


def _max_shift(pair: Pair, overlap: float) -> np.ndarray:
    """Return the largest shift (y, x), m."""
    lengths, of_upper = np.array(pair.lower.lengths), np.array(pair.upper.lengths)
    cosine, sine = np.abs(pair.turn)
    with np.errstate(divide="ignore"):  # at right angles
        # length of the rotated rectangle through its middle
        sides = np.minimum(of_upper / cosine, of_upper[::-1] / sine)
    # the shorter side stays covered to its share
    free = np.abs(lengths - sides) / 2 + (1 - overlap) * np.minimum(lengths, sides)
    if pair.upper.periodic:  # any shift within half a period
        free = sides / 2
    return np.where(np.array(pair.lower.shape) == 1, 0.0, free)  # a profile does not move across itself


def _aligned_shift(pair: Pair, shift: np.ndarray) -> tuple[float, ...]:
    """Return the nearest shift for which the points of both maps coincide, or `shift` if there is none."""
    points = axis_order(pair.upper.shape, pair.turn)
    if points is not None and pair.has_common("step"):
        steps = np.array(pair.lower.step)
        # of unlike numbers of points the middles lie half a pixel apart
        half = np.subtract(pair.lower.shape, points) % 2 / 2
        shift = (np.rint(shift / steps - half) + half) * steps
    return tuple(map(float, shift))
