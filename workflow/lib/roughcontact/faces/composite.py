"""Two measured faces that touch: one composite map for each way in which they lie on one another."""

import json

import numpy as np
import xarray as xr

from roughcontact.checking import check_map
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.levelling.forms import form_from_record
from roughcontact.levelling.polynomial import fit_polynomial
from roughcontact.maps import spacing
from roughcontact.roughness.parameters import height_parameters
from roughcontact.window.band import reliable_wavelength
from roughcontact.window.periodisation import periodic_heights

_MOST_POINTS = 2**27  # as many as are read of one file
_ON_POINT = 1e-6  # of a step: so near to a point, its height is taken as it is
_SAME_STEP = 1e-6  # relative difference of two steps that are one
_RIGHT_ANGLE = 1e-9  # sine or cosine below which two axes count as parallel


def composite(
    face: xr.DataArray,
    counter_face: xr.DataArray,
    *,
    shift: tuple[float, float] = (0.0, 0.0),
    rotation: float = 0.0,
) -> xr.DataArray:
    """Lay one measured face on another and return the height map whose contact with a flat is theirs.

    Both heights count outwards, so that the gap of the rigid faces is (approach) - h1 - h2: what stands out
    on either closes it, and the composite height is the sum. The counter-face looks the other way, so it is
    turned over about y before it is laid on, which mirrors it along x:

        h(x, y) = h1(x, y) + h2(x2, y2) - mean plane,
        x2 = -(u cos t + v sin t),  y2 = v cos t - u sin t,  (u, v) = (x, y) - shift,

    positions counted from the middle of each map, t the rotation. With the composite contact modulus the
    problem of the two elastic faces is that of h on a flat.

    The result covers what both maps cover, with a plane taken off: the mean planes of the faces lie on one
    another there. A map that is periodic goes on beyond its edges; two periodic maps of the same period, at
    right angles, make a periodic one, and only the mean is taken off. The points are those of `face`, closer
    ones along an axis where the counter-face has them closer. Where points of one map fall between those of
    the other it is interpolated by a cubic spline.

    Parameters
    ----------
    face, counter_face : DataArray (y, x), m
        from `level`; NaN where missing. Both maps, or both profiles.
    shift : (y, x), m
        where the middle of the counter-face lies, seen from the middle of the face.
    rotation : float, degrees
        of the counter-face about its middle, from x towards y, as it lies on the face. Profiles: 0.

    Returns
    -------
    DataArray (y, x), m
        NaN where one of the two is missing; the coordinate `filled` is 1 where one of the two was filled in.
        Attributes of `face`, with those of levelling for the sum (form, filled and rejected points of both,
        height parameters), `source_file` and `source_sha256` of both, `instrument` of the one that resolves
        less, and `counter_face` (file), `shift_y`, `shift_x` (m), `rotation` (degrees), `covered_share` (of
        the face).

    Raises
    ------
    HeightMapError
        maps that do not overlap by two points, or a map and a profile.
    SettingsError
        a shift or rotation that has no meaning.

    Notes
    -----
    Greenwood & Tripp, Proc. Inst. Mech. Eng. 185 (1970) 625; Johnson, Contact Mechanics (1985), section 13.4.
    """
    lower, upper = _Face(face), _Face(counter_face)
    name = f"{lower.name} + {upper.name}"
    _check(lower, upper, name, shift, rotation)
    turn = _turn(rotation)
    whole = _common_period(lower, upper, turn)
    positions = _common_grid(lower, upper, turn, shift, name)
    own = lower.at(*np.meshgrid(*positions, indexing="ij"))
    v, u = np.meshgrid(*(p - s for p, s in zip(positions, shift, strict=True)), indexing="ij")
    cosine, sine = turn
    other = upper.at(v * cosine - u * sine, -(u * cosine + v * sine))
    values = own[0] + other[0]
    measured = np.isfinite(values)
    if np.count_nonzero(measured) < 2:
        raise HeightMapError(
            f"{name}: the faces share no two points that are measured on both: choose a smaller shift"
        )
    coordinates = [p + c for p, c in zip(positions, lower.middle, strict=True)]
    form, removed = fit_polynomial(values, coordinates, order=0 if whole else 1)
    values = values - form
    filled = (own[1] | other[1]) & measured
    attrs = _attributes(lower, upper, filled)
    attrs |= {
        "source_file": name,
        "form": "mean" if whole else "plane",
        "form_removed": json.dumps(removed),
        "shift_y": float(shift[0]),
        "shift_x": float(shift[1]),
        "rotation": float(rotation),
        "covered_share": float(measured.mean() * _covered(lower, positions)),
    }
    coords = {
        "y": ("y", coordinates[0], {"units": "m"}),
        "x": ("x", coordinates[1], {"units": "m"}),
        "filled": (("y", "x"), filled.astype(np.int8)),
    }
    result = xr.DataArray(values, dims=("y", "x"), coords=coords, name="height", attrs=attrs)
    return result.assign_attrs(height_parameters(result))


def relative_positions(
    face: xr.DataArray,
    counter_face: xr.DataArray,
    *,
    shifts: int = 5,
    rotations: list[float] | tuple[float, ...] = (0.0,),
    overlap: float = 0.75,
    seed: int = 0,
) -> list[dict]:
    """Draw an ensemble of ways in which one face can lie on another: `shifts` random ones for each rotation.

    A shift is uniform up to |a - b| / 2 + (1 - overlap) min(a, b) along each axis, a the side of the face and
    b that of the counter-face through its middle, as it lies on the face; over its whole period where the
    counter-face is periodic. Where the points of both maps can fall on one another they do, so that nothing
    is interpolated.

    Parameters
    ----------
    face, counter_face : DataArray (y, x), m
    shifts : int
    rotations : list of float, degrees
    overlap : float, 0 to 1
        least share of each side of the smaller map that the other one covers.
    seed : int
        more shifts or rotations leave those that were drawn before as they are.

    Returns
    -------
    list of dict, `shift` (y, x) in m and `rotation` in degrees: the keyword arguments of `composite`.

    Raises
    ------
    SettingsError
        an option that has no meaning.
    """
    if shifts < 1 or not len(rotations):
        raise SettingsError(
            f"composite.shifts = {shifts!r}, composite.rotations = {rotations!r}: give at least one of each"
        )
    if not 0 < overlap <= 1:
        raise SettingsError(f"composite.overlap = {overlap!r}: give a share above 0, up to 1")
    lower, upper = _Face(face), _Face(counter_face)
    _check(lower, upper, f"{lower.name} + {upper.name}", (0.0, 0.0), rotations[0])
    members = []
    for number, rotation in enumerate(rotations):
        turn = _turn(rotation)
        drawn = np.random.default_rng([seed, number]).uniform(-1, 1, (shifts, 2))
        reach = _reach(lower, upper, turn, overlap)
        members += [
            {"shift": _on_points(lower, upper, turn, row * reach), "rotation": float(rotation)}
            for row in drawn
        ]
    return members


class _Face:
    """A map with what lies between its points and, where it is periodic, beyond its edges."""

    def __init__(self, height):
        values = check_map(height)
        removed = json.loads(height.attrs.get("form_removed", "{}"))
        form = form_from_record(removed, height["y"].values, height["x"].values)
        periodic = periodic_heights(values, form)
        self.height, self.name = height, height.attrs.get("source_file") or "the map"
        self.periodic = periodic is not None
        self.values = values if periodic is None else periodic[0]
        self.filled = np.asarray(height.coords.get("filled", np.zeros(values.shape))) > 0
        self.shape, self.step = values.shape, spacing(height)
        self.lengths = tuple(n * d for n, d in zip(self.shape, self.step, strict=True))
        self.middle = tuple(float(height[d].values[[0, -1]].mean()) for d in ("y", "x"))

    def at(self, y, x):
        """Return heights (NaN: not measured) and flags of filled points at positions off the middle, m."""
        places = [p / d + (n - 1) / 2 for p, d, n in zip((y, x), self.step, self.shape, strict=True)]
        places = [np.where(np.abs(p - np.rint(p)) < _ON_POINT, np.rint(p), p) for p in places]
        if self.periodic:
            inside = np.ones(places[0].shape, dtype=bool)
            places = [p % n for p, n in zip(places, self.shape, strict=True)]
        else:
            inside = np.logical_and.reduce(
                [(p >= 0) & (p <= n - 1) for p, n in zip(places, self.shape, strict=True)]
            )
            places = [np.clip(p, 0, n - 1) for p, n in zip(places, self.shape, strict=True)]
        if all(np.array_equal(p, np.rint(p)) for p in places):
            index = tuple(p.astype(int) for p in places)
            values, filled = self.values[index], self.filled[index]
        else:
            values, filled = self._between(places)
        return np.where(inside, values, np.nan), filled & inside

    def _between(self, places):
        """Return heights and flags between the points; a point next to a missing one is missing."""
        from scipy.ndimage import distance_transform_edt, map_coordinates

        beyond = "grid-wrap" if self.periodic else "mirror"
        missing = np.isnan(self.values)
        values = self.values
        if missing.any():  # the spline needs a height everywhere; these are masked again
            nearest = distance_transform_edt(missing, return_distances=False, return_indices=True)
            values = values[tuple(nearest)]
        between = map_coordinates(values, places, order=3, mode=beyond)
        near = [
            map_coordinates(flags.astype(float), places, order=1, mode=beyond) > _ON_POINT
            for flags in (missing, self.filled)
        ]
        return np.where(near[0], np.nan, between), near[1]


def _check(lower, upper, name, shift, rotation):
    """Say why two faces cannot lie on one another in this way."""
    across = [n == 1 for n in lower.shape]
    if across != [n == 1 for n in upper.shape]:
        raise HeightMapError(f"{name}: a map and a profile make no composite: measure both alike")
    if len(shift) != 2 or not np.isfinite(shift).all():
        raise SettingsError(f"shift = {shift!r}: give two lengths (y, x) in m")
    if not np.isfinite(rotation):
        raise SettingsError(f"rotation = {rotation!r}: give an angle in degrees")
    if any(across) and (rotation or any(s for s, single in zip(shift, across, strict=True) if single)):
        raise SettingsError(
            f"{name}: profiles can only be shifted along their length (composite.rotations: [0])"
        )


def _turn(rotation) -> tuple[float, float]:
    """Return (cosine, sine), exact at right angles."""
    angle = np.radians(rotation)
    cosine, sine = (0.0 if abs(v) < _RIGHT_ANGLE else float(v) for v in (np.cos(angle), np.sin(angle)))
    return (np.sign(cosine), 0.0) if sine == 0 else (0.0, np.sign(sine)) if cosine == 0 else (cosine, sine)


def _turned(pair, turn):
    """Return a pair (y, x) of the counter-face as it lies along the axes of the face; None askew."""
    return tuple(pair) if turn[1] == 0 else tuple(pair[::-1]) if turn[0] == 0 else None


def _covered(lower, positions) -> float:
    """Return the share of the lower face that the common grid spans."""
    shares = [
        1.0 if n == 1 else (p[-1] - p[0] + p[1] - p[0]) / ((n - 1) * d + p[1] - p[0])
        for p, n, d in zip(positions, lower.shape, lower.step, strict=True)
    ]
    return min(1.0, float(np.prod(shares)))


def _common_period(lower, upper, turn) -> bool:
    """Return whether the sum is periodic with the period of the lower face."""
    lengths = _turned(upper.lengths, turn)
    return bool(
        lower.periodic and upper.periodic and lengths and np.allclose(lengths, lower.lengths, rtol=_SAME_STEP)
    )


def _common_grid(lower, upper, turn, shift, name):
    """Return the positions (y, x) off the middle of the lower face that both maps reach, m."""
    steps = _turned(upper.step, turn) or (min(upper.step),) * 2
    half = [(n - 1) * d / 2 for n, d in zip(upper.shape, upper.step, strict=True)]
    cosine, sine = (abs(v) for v in turn)
    half = half[0] * cosine + half[1] * sine, half[1] * cosine + half[0] * sine
    positions = []
    for n, own, other, middle, reach in zip(lower.shape, lower.step, steps, shift, half, strict=True):
        low, high = (-np.inf, np.inf) if upper.periodic else (middle - reach, middle + reach)
        first = -(n - 1) * own / 2
        if n > 1 and other < own * (1 - _SAME_STEP):  # closer points, evenly over the same length
            intervals = n - (not lower.periodic)
            n, length = int(np.ceil(intervals * own / other - _ON_POINT)), intervals * own
            own = length / n
            n += not lower.periodic
        tolerance = _ON_POINT * own
        start = max(0, int(np.ceil((low - first - tolerance) / own))) if np.isfinite(low) else 0
        stop = min(n, int(np.floor((high - first + tolerance) / own)) + 1) if np.isfinite(high) else n
        if stop - start < min(n, 2):
            raise HeightMapError(f"{name}: the faces do not overlap: choose a smaller shift")
        positions.append((start, stop, first, own))
    ny, nx = (stop - start for start, stop, _, _ in positions)
    if ny * nx > _MOST_POINTS:
        raise HeightMapError(
            f"{name}: {ny} x {nx} points in the overlap, more than the {_MOST_POINTS} that are read: "
            "the steps of the two maps are too different; crop one of them"
        )
    return [first + own * np.arange(start, stop) for start, stop, first, own in positions]


def _reach(lower, upper, turn, overlap):
    """Return the largest shift (y, x), m."""
    cosine, sine = (abs(v) for v in turn)
    reach = []
    for axis in (0, 1):
        along, across = upper.lengths[axis], upper.lengths[1 - axis]
        # through the middle of the turned rectangle
        side = min(along / cosine if cosine else np.inf, across / sine if sine else np.inf)
        own = lower.lengths[axis]
        free = side / 2 if upper.periodic else abs(own - side) / 2 + (1 - overlap) * min(own, side)
        reach.append(0.0 if lower.shape[axis] == 1 else free)
    return np.array(reach)


def _on_points(lower, upper, turn, shift):
    """Return the nearest shift that lays points on points, where there is one."""
    steps, points = _turned(upper.step, turn), _turned(upper.shape, turn)
    if steps is None or not np.allclose(steps, lower.step, rtol=_SAME_STEP):
        return tuple(map(float, shift))
    odd = [(n - m) % 2 / 2 for n, m in zip(lower.shape, points, strict=True)]
    return tuple(
        float((np.rint(s / d - half) + half) * d) for s, d, half in zip(shift, lower.step, odd, strict=True)
    )


def _attributes(lower, upper, filled) -> dict:
    """Return the attributes of the face, where they can be said of both those of both."""
    one, other = lower.height.attrs, upper.height.attrs
    kinds = [json.loads(attrs.get("outlier_kinds", "{}")) for attrs in (one, other)]
    warnings = [
        f"{face.name}: {warning}"
        for face in (lower, upper)
        for warning in json.loads(face.height.attrs.get("ingest_warnings", "[]"))
    ]
    coarser = max((lower, upper), key=lambda face: reliable_wavelength(face.height)[0])
    return one | {
        "units": "m",
        "counter_face": upper.name,
        "source_sha256": " + ".join(attrs.get("source_sha256", "") for attrs in (one, other)),
        "instrument": coarser.height.attrs.get("instrument", "{}"),
        "ingest_warnings": json.dumps(warnings, ensure_ascii=False),
        "missing_share": max(attrs.get("missing_share", 0.0) for attrs in (one, other)),
        "outliers_rejected": sum(attrs.get("outliers_rejected", 0) for attrs in (one, other)),
        "outlier_kinds": json.dumps({k: sum(each.get(k, 0) for each in kinds) for k in kinds[0] | kinds[1]}),
        "filled_points": int(filled.sum()),
        "filled_share": float(filled.mean()),
        "largest_hole": max(attrs.get("largest_hole", 0) for attrs in (one, other)),
    }
