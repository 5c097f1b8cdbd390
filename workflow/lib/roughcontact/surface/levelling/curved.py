"""Sphere and cylinder as the form of a map: least-squares or robust fit of the vertical distances."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from roughcontact.arguments.maps import dimensions
from roughcontact.errors import HeightMapError
from roughcontact.surface.levelling.polynomial import fit_polynomial
from roughcontact.surface.levelling.robust import biweight, robust_scale

_ITERATIONS = 60
_CONVERGED = 1e-9  # change of the form between iterations, in standard deviations of the residual
_CONVERGED_ROBUST = 1e-6  # the same for the robust fit
_DERIVATIVE_STEP = 1e-6  # of the numerical derivatives; lengths are in half the longer side of the map
_START_POINTS = 50_000  # sufficient for the initial fit of a large map
_CHUNK = 200_000  # points processed at a time
_MAX_ROTATION = 0.3  # rad per step; the axis of a nearly flat cylinder is poorly determined and must not jump
_MAX_ASPECT_RATIO = 1e3  # range of heights over half the longer side


def fit_curved_form(
    values: np.ndarray, coordinates: Sequence[np.ndarray], *, shape: str, robust: bool = False
) -> tuple[np.ndarray, dict[str, dict]]:
    """Fit a sphere or cylinder to a map (ny, nx; m; NaN missing); return form (ny, nx; m) and parameters.

    With r the vector from the point (x0, y0, z0) in the middle of the map, n the normal there, 1/kappa the
    distance of centre or axis along n and d the direction of the axis (0 for a sphere), kappa (|r|^2 - (r .
    d)^2) - 2 n . r = 0 for z(x, y). The sum of (h - z)^2, with `robust` of Tukey's biweight, is minimised by
    the method of Levenberg and Marquardt (Marquardt 1963, SIAM J. Appl. Math. 11, 431); `curvature` (1/m) is
    negative for a hill, `radius` (m) absent for a flat map.
    """
    if dimensions(values.shape) == 1:
        shape = "sphere"  # of a profile: a circle, the cross-section of both shapes
    y, x = (np.asarray(c, dtype=float) for c in coordinates)
    middle_y, middle_x = ((c[0] + c[-1]) / 2 for c in (y, x))
    half = max(np.ptp(y), np.ptp(x)) / 2
    is_measured = ~np.isnan(values)
    if (heights := np.ptp(values[is_measured])) > _MAX_ASPECT_RATIO * half:
        raise HeightMapError(
            f"level.form = {shape!r}: a {shape} cannot have a range of heights of {heights:g} m on sides of "
            f"{2 * half:g} m: check the unit, or use level.form: polynomial"
        )
    start_form, start = fit_polynomial(values, coordinates, order=2, robust=robust)
    reference = start["mean"]["value"]
    rows, columns = np.nonzero(is_measured)
    # in half the longer side, so that all parameters are of order one
    unit_y, unit_x = (y - middle_y) / half, (x - middle_x) / half
    points = unit_y[rows], unit_x[columns], (values[is_measured] - reference) / half
    parameters = _start(start, start_form, reference, half, shape)
    # a first fit to some points, the same in every run, saves most steps on all of them
    if points[0].size > 2 * _START_POINTS:
        start_points = np.random.default_rng(0).choice(points[0].size, _START_POINTS, replace=False)
        parameters = _least_squares(parameters, [c[start_points] for c in points], robust=robust)
    parameters = _least_squares(parameters, points, robust=robust)
    unit_form, inside = _surface(parameters, unit_y[:, None], unit_x)
    if points_outside := np.count_nonzero(is_measured & ~inside):
        raise HeightMapError(
            f"level.form = {shape!r}: {points_outside} points lie beyond the rim of the fitted {shape}, "
            "where it has no height: cut the map to the curved part, or use level.form: polynomial"
        )
    form = reference + half * unit_form
    return form, _record(parameters, form, reference, half, (middle_y, middle_x))


def curved_form_from_record(record: Mapping[str, Mapping], y: npt.ArrayLike, x: npt.ArrayLike) -> np.ndarray:
    """Return the form (ny, nx; m) that `fit_curved_form` recorded, at the coordinates y and x (m)."""
    value = {name: entry["value"] for name, entry in record.items()}
    a, b = value["slope_x"], value["slope_y"]
    azimuth = [np.deg2rad(value["axis_azimuth"])] if "axis_azimuth" in value else []
    parameters = [0.0, a, b, value["curvature"] * np.sqrt(1 + a**2 + b**2), *azimuth]
    y, x = (np.asarray(c, dtype=float) for c in (y, x))
    form, _ = _surface(parameters, y[:, None] - value["middle_y"], x - value["middle_x"])
    return value["height_middle"] + form


def _surface(
    parameters: Sequence[float] | np.ndarray, y: np.ndarray, x: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return z(x, y) and where it exists; parameters z0, a, b, k = kappa sqrt(1 + a^2 + b^2), azimuth."""
    z0, a, b, k, *azimuth = parameters
    along, dz = 0.0, 0.0
    if azimuth:
        cosine, sine = np.cos(azimuth[0]), np.sin(azimuth[0])
        rise = a * cosine + b * sine  # the axis lies in the tangent plane
        length = np.sqrt(1 + rise**2)
        along, dz = (cosine * x + sine * y) / length, rise / length
    # (k (1 - dz^2)) z^2 - 2 (1 + k along dz) z + c = 0; the root that vanishes with c
    c = k * (x**2 + y**2 - along**2) + 2 * (a * x + b * y)
    minus_half_b = 1 + k * along * dz
    discriminant = minus_half_b**2 - k * (1 - dz**2) * c
    # this form of the root has no cancellation, down to a plane (k = 0)
    return z0 + c / (minus_half_b + np.sqrt(np.maximum(discriminant, 0.0))), discriminant >= 0


def _start(
    polynomial: Mapping[str, Mapping], form: np.ndarray, reference: float, half: float, shape: str
) -> np.ndarray:
    """Return the parameters of the shape that touches the second-order polynomial in the middle."""
    value = {name: entry["value"] for name, entry in polynomial.items()}
    twist = value.get("c_1_1", 0.0) / (value["half_length_x"] * value["half_length_y"])
    hessian = np.array([[value["curvature_x"], twist], [twist, value["curvature_y"]]])
    curvatures, directions = np.linalg.eigh(hessian)
    z0 = (form[form.shape[0] // 2, form.shape[1] // 2] - reference) / half
    slopes = [value["slope_x"], value["slope_y"]]
    if shape == "sphere":
        inverse_radii = np.diag(hessian)[[n > 1 for n in form.shape[::-1]]]
        return np.array([z0, *slopes, half * np.mean(inverse_radii[::-1])])
    strongest = int(np.argmax(np.abs(curvatures)))
    along = directions[:, 1 - strongest]  # the axis lies across the strongest curvature
    return np.array([z0, *slopes, half * curvatures[strongest], np.arctan2(along[1], along[0])])


def _least_squares(parameters: np.ndarray, points: Sequence[np.ndarray], *, robust: bool) -> np.ndarray:
    """Return the least-squares or robust parameters; points are (y, x, z), each (n,)."""
    y, x, z = points
    damping = 1e-3
    residual = z - _surface(parameters, y, x)[0]
    for _ in range(_ITERATIONS):
        if robust:
            scale = robust_scale(residual)
            if not scale > 1e-12 * np.ptp(z):
                return parameters  # more than half of the points lie on the form
            weights = biweight(residual, scale)
        else:
            scale, weights = np.sqrt(np.mean(residual**2)), np.ones(z.size)
        matrix, rhs = _normal_equations(parameters, y, x, weights, residual)
        size = np.sqrt(np.diag(matrix))
        size = np.maximum(size, 1e-12 * size.max())  # parameters without influence do not change
        cost = np.sum(weights * residual**2)
        # Levenberg and Marquardt: more damping until a step lowers the cost
        for _ in range(12):
            # with a diagonal of 1: lengths, slopes and angles have unlike sizes
            damped_matrix = matrix / np.outer(size, size) + damping * np.eye(len(size))
            step = np.linalg.lstsq(damped_matrix, rhs / size, rcond=1e-14)[0] / size
            step[4:] = np.clip(step[4:], -_MAX_ROTATION, _MAX_ROTATION)
            trial = z - _surface(parameters + step, y, x)[0]
            if np.sum(weights * trial**2) <= cost:
                break
            damping *= 10
        else:
            return parameters  # no step reduces the cost: limit of rounding
        change = np.abs(trial - residual).max()
        parameters, residual, damping = parameters + step, trial, max(damping / 30, 1e-12)
        convergence = _CONVERGED_ROBUST if robust else _CONVERGED
        if change <= convergence * scale + 1e-15 * np.abs(z).max():
            break
    return parameters


def _normal_equations(
    parameters: np.ndarray, y: np.ndarray, x: np.ndarray, weights: np.ndarray, residual: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return J^T W J and J^T W residual, with J the derivatives of the heights."""
    count = len(parameters)
    matrix, rhs = np.zeros((count, count)), np.zeros(count)
    for start in range(0, y.size, _CHUNK):
        block = slice(start, start + _CHUNK)
        columns = []
        for step in _DERIVATIVE_STEP * np.eye(count):
            forward, backward = (_surface(parameters + s, y[block], x[block])[0] for s in (step, -step))
            columns.append((forward - backward) / (2 * _DERIVATIVE_STEP))
        jacobian = np.stack(columns)
        weighted_jacobian = jacobian * weights[block]
        matrix += weighted_jacobian @ jacobian.T
        rhs += weighted_jacobian @ residual[block]
    return matrix, rhs


def _record(
    parameters: np.ndarray, form: np.ndarray, reference: float, half: float, middle: tuple[float, float]
) -> dict[str, dict]:
    """Return the record of a sphere or cylinder in SI units."""
    z0, a, b, k, *azimuth = map(float, parameters)
    (middle_y, middle_x), height = middle, reference + half * z0
    steepness = np.sqrt(1 + a**2 + b**2)
    curvature = k / steepness / half
    quantity: dict[str, tuple[float, str]] = {"mean": (form.mean(), "m")}
    if curvature:
        quantity["radius"] = (1 / abs(curvature), "m")
    quantity |= {"curvature": (curvature, "m-1"), "height_middle": (height, "m")}
    quantity |= {"slope_x": (a, "1"), "slope_y": (b, "1")}
    quantity |= {"middle_x": (middle_x, "m"), "middle_y": (middle_y, "m")}
    if azimuth:
        # an axis has no sense of direction: within 90 degrees of x
        angle = (azimuth[0] + np.pi / 2) % np.pi - np.pi / 2
        rise = a * np.cos(angle) + b * np.sin(angle)
        quantity["axis_azimuth"] = (np.rad2deg(angle), "degree")
        quantity["axis_inclination"] = (np.rad2deg(np.arctan(rise)), "degree")
    elif curvature:
        centre = np.array([middle_x, middle_y, height]) + np.array([-a, -b, 1.0]) / steepness / curvature
        quantity |= {f"centre_{axis}": (position, "m") for axis, position in zip("xyz", centre, strict=True)}
    return {name: {"value": float(value), "units": units} for name, (value, units) in quantity.items()}
