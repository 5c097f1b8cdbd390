"""Form of a map: polynomials fitted by least squares or robustly, in a well-conditioned basis."""

import copy
from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from roughcontact.surface.levelling.robust import biweight, robust_scale

_ITERATIONS = 100
_START_POINTS = 250_000  # sufficient for the initial fit
_ROUNDING = 16 * np.finfo(float).eps  # error of height less form, relative to the form
_CONVERGED = 1e-6  # change of the form between iterations, in standard deviations of the residual


def fit_polynomial(
    values: np.ndarray, coordinates: Sequence[np.ndarray], *, order: int, robust: bool = False
) -> tuple[np.ndarray, dict[str, dict]]:
    """Fit a polynomial to a map (ny, nx; m; NaN missing); return form (ny, nx; m) and parameters.

    form(x, y) = sum c_ij P_i(X) P_j(Y), i + j <= order, with Legendre polynomials of coordinates mapped to
    [-1, 1]; slopes and curvatures are those at the middle. `robust` minimises Tukey's biweight by iteratively
    reweighted least squares (Beaton and Tukey 1974, Technometrics 16, 147) with the weights of ISO
    16610-31:2016.
    """
    is_measured = ~np.isnan(values)
    # subtracted first, so that a map far from zero keeps its digits
    reference = float(np.median(values[is_measured], overwrite_input=True))
    heights = values - reference
    heights[~is_measured] = 0.0
    basis = _Basis(coordinates, order)
    if robust:
        coefficients = _fit_robust(basis, heights, is_measured)
    elif order == 0:
        coefficients = np.full((1, 1), heights.sum() / is_measured.sum())
    else:
        coefficients = basis.fit(heights, is_measured.astype(float))
    del heights  # memory may not hold more than is needed of a large map
    form = basis.at_points(coefficients)
    form += reference
    coefficients[0, 0] += reference
    return form, _record(coefficients, basis, order)


def subtract_form(values: np.ndarray, form: np.ndarray) -> np.ndarray:
    """Return heights less form (m), overwriting the form; exactly zero if only rounding remains.

    Examples
    --------
    >>> import numpy as np
    >>> form = np.linspace(0.0, 1.0, 5)
    >>> subtract_form(np.nextafter(form, 2.0), form)
    array([0., 0., 0., 0., 0.])
    """
    rounding = _ROUNDING * max(np.nanmax(form), -np.nanmin(form))
    residual = np.subtract(values, form, out=form)
    if max(np.nanmax(residual), -np.nanmin(residual)) <= rounding:
        residual[~np.isnan(values)] = 0.0
    return residual


def share_of_form(values: np.ndarray, coordinates: Sequence[np.ndarray]) -> float:
    """Return the share (0 to 1) of a second-order polynomial in the mean square height; 0 if flat.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(8.0)
    >>> print(round(share_of_form((x**2)[None, :], (np.zeros(1), x)), 6))
    1.0
    """
    rough = values - values.flat[0]  # exactly zero for a flat map, whatever its height
    rough -= rough.mean()
    total = float(np.mean(rough**2))
    if total == 0:
        return 0.0
    form, _ = fit_polynomial(rough, coordinates, order=2)
    return float(np.mean(form**2)) / total


def polynomial_from_record(record: Mapping[str, Mapping], y: npt.ArrayLike, x: npt.ArrayLike) -> np.ndarray:
    """Return the form (ny, nx; m) that `fit_polynomial` recorded, at y and x (m); zero for no record.

    Examples
    --------
    >>> import numpy as np
    >>> y, x = np.arange(2.0), np.arange(3.0)
    >>> form, removed = fit_polynomial(y[:, None] + x**2, (y, x), order=2)
    >>> print(np.round(polynomial_from_record(removed, y, x), 6))
    [[0. 1. 4.]
     [1. 2. 5.]]
    """
    value = {name: entry["value"] for name, entry in record.items()}
    y, x = np.asarray(y, dtype=float), np.asarray(x, dtype=float)
    if "c_0_0" in value:
        terms = [tuple(map(int, name[2:].split("_"))) for name in value if name.startswith("c_")]
        coefficients = np.zeros([1 + max(t[k] for t in terms) for k in (1, 0)])
        for i, j in terms:
            coefficients[j, i] = value[f"c_{i}_{j}"]
        scaled_y, scaled_x = (
            (c - value[f"middle_{d}"]) / value[f"half_length_{d}"] for c, d in ((y, "y"), (x, "x"))
        )
        return np.asarray(legendre.leggrid2d(scaled_y, scaled_x, coefficients))
    rise_y, rise_x = (
        value.get(f"slope_{axis}", 0.0) * (c - (c[0] + c[-1]) / 2) for axis, c in (("y", y), ("x", x))
    )
    return value.get("mean", 0.0) + rise_y[:, None] + rise_x


class _Basis:
    """Legendre polynomials P_j(Y) P_i(X), j + i <= order, of coordinates (y, x) mapped to [-1, 1]."""

    def __init__(self, coordinates: Sequence[np.ndarray], order: int):
        limits = [(float(c[0]), float(c[-1])) for c in coordinates]
        self.middle = [(start + stop) / 2 for start, stop in limits]
        self.half = [(stop - start) / 2 or 1.0 for start, stop in limits]  # 1 for a single line
        self.axes = [  # (points, orders along the axis)
            legendre.legvander((np.asarray(c, dtype=float) - middle) / half, min(order, len(c) - 1))
            for c, middle, half in zip(coordinates, self.middle, self.half, strict=True)
        ]
        ky, kx = (axis.shape[1] for axis in self.axes)
        self.terms = np.array([(j, i) for j in range(ky) for i in range(kx) if i + j <= order]).T

    def thinned(self, stride: int) -> "_Basis":
        """Return the same polynomials at every n-th point."""
        thin = copy.copy(self)
        thin.axes = [axis[::stride] for axis in self.axes]
        return thin

    def at_points(self, coefficients: np.ndarray) -> np.ndarray:
        """Return the polynomial of coefficients (j, i) at the grid points of both axes."""
        y, x = self.axes
        return y @ coefficients @ x.T

    def fit(self, heights: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Return c (j, i) that minimises sum w (h - form)^2; a second pass corrects rounding errors."""
        (y, x), (j, i) = self.axes, self.terms
        ky, kx = y.shape[1], x.shape[1]
        # moments of all products P_a P_b, axis by axis: two matrix products for all sums over the map
        products_y, products_x = ((p[:, :, None] * p[:, None, :]).reshape(len(p), -1) for p in (y, x))
        moments = (products_y.T @ weights @ products_x).reshape(ky, ky, kx, kx)
        matrix = moments[j[:, None], j[None, :], i[:, None], i[None, :]]
        coefficients = np.zeros((ky, kx))
        weighted_heights = weights * heights
        for refining in (False, True):
            if refining:
                np.subtract(heights, self.at_points(coefficients), out=weighted_heights)
                weighted_heights *= weights
            rhs = (y.T @ weighted_heights @ x)[j, i]
            coefficients[j, i] += np.linalg.lstsq(matrix, rhs, rcond=1e-13)[0]
        return coefficients


def _fit_robust(basis: _Basis, heights: np.ndarray, is_measured: np.ndarray) -> np.ndarray:
    """Return the coefficients of iteratively reweighted least squares after convergence."""
    stride = int(np.sqrt(heights.size / _START_POINTS))
    # a large map is fitted from a thinned one, so near the solution that no least absolute values are needed
    least_absolute = not (stride > 1 and is_measured[::stride, ::stride].sum() > _START_POINTS / 4)
    if least_absolute:
        coefficients = basis.fit(heights, is_measured.astype(float))
    else:
        thin = slice(None, None, stride)
        coefficients = _fit_robust(basis.thinned(stride), heights[thin, thin], is_measured[thin, thin])
    negligible = 1e-12 * np.ptp(heights[is_measured])
    for iteration in range(_ITERATIONS):
        residual = basis.at_points(coefficients)
        np.subtract(heights, residual, out=residual)
        scale = robust_scale(residual[is_measured], overwrite=True)
        if not scale > negligible:
            return coefficients  # more than half of the points lie on the form
        if least_absolute:
            # the limit keeps points on the form from an infinite weight
            weights = 1 / np.maximum(np.abs(residual), 1e-3 * scale)
        else:
            weights = biweight(residual, scale)
        del residual
        weights[~is_measured] = 0
        previous, coefficients = coefficients, basis.fit(heights, weights)
        change = np.abs(coefficients - previous).max()
        if least_absolute and (change <= 1e-2 * scale or iteration == 20):
            least_absolute = False
        elif not least_absolute and change <= _CONVERGED * scale:
            break
    return coefficients


def _record(coefficients: np.ndarray, basis: _Basis, order: int) -> dict[str, dict]:
    """Return the record of a polynomial: mean, slopes and curvatures at the middle, coefficients."""
    quantity = {"mean": (coefficients[0, 0], "m")}
    derivatives = ((1, "slope", "1"), (2, "curvature", "m-1"))[:order]
    for (nth, name, units), (axis, along) in product(derivatives, ((1, "x"), (0, "y"))):
        # at the middle, where the polynomials of the other axis are not differentiated
        py, px = (
            legendre.legval(0.0, legendre.legder(np.eye(count), nth if axis == k else 0))
            for k, count in enumerate(coefficients.shape)
        )
        derivative = float((coefficients * np.outer(py, px)).sum() / basis.half[axis] ** nth)
        quantity[f"{name}_{along}"] = (derivative, units)
    if order >= 2:
        for axis, along in ((1, "x"), (0, "y")):
            quantity[f"middle_{along}"] = (basis.middle[axis], "m")
            quantity[f"half_length_{along}"] = (basis.half[axis], "m")
        for j, i in basis.terms.T:
            quantity[f"c_{i}_{j}"] = (coefficients[j, i], "m")
    return {name: {"value": float(value), "units": units} for name, (value, units) in quantity.items()}
