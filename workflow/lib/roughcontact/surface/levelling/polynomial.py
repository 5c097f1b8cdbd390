"""Form of a map: polynomials fitted by least squares or robustly, in a well-conditioned basis."""

import copy
from collections.abc import Mapping, Sequence

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
    axes = [_Axis(c, min(order, n - 1)) for c, n in zip(coordinates, values.shape, strict=True)]
    terms = [(j, i) for j in range(axes[0].order + 1) for i in range(axes[1].order + 1) if i + j <= order]
    if order == 0 and not robust:
        coefficients = np.full((1, 1), heights.sum() / is_measured.sum())
    elif robust:
        coefficients = _fit_robust(heights, is_measured, axes, terms)
    else:
        coefficients = _fit_weighted(heights, is_measured.astype(float), axes, terms)
    del heights  # memory may not hold more than is needed of a large map
    form = _evaluate(coefficients, axes)
    form += reference
    coefficients = coefficients.copy()
    coefficients[0, 0] += reference
    return form, _record(coefficients, axes, order)


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
    slope_y, slope_x = value.get("slope_y", 0.0), value.get("slope_x", 0.0)
    return (
        value.get("mean", 0.0)
        + slope_y * (y - (y[0] + y[-1]) / 2)[:, None]
        + slope_x * (x - (x[0] + x[-1]) / 2)[None, :]
    )


class _Axis:
    """Legendre polynomials along one axis, on its coordinates mapped to [-1, 1]."""

    def __init__(self, coordinate: np.ndarray, order: int):
        coordinate = np.asarray(coordinate, dtype=float)
        self.order = order
        self.middle = (coordinate[0] + coordinate[-1]) / 2
        # 1 for a single line
        self.half = (coordinate[-1] - coordinate[0]) / 2 or 1.0
        self.basis = legendre.legvander((coordinate - self.middle) / self.half, order)  # (n, order + 1)
        # all products P_a P_b, for the normal equations
        self.products = (self.basis[:, :, None] * self.basis[:, None, :]).reshape(coordinate.size, -1)

    def thinned(self, stride: int) -> "_Axis":
        """Return the same polynomials at every n-th point."""
        thin = copy.copy(self)
        thin.basis, thin.products = self.basis[::stride], self.products[::stride]
        return thin


def _evaluate(coefficients: np.ndarray, axes: list[_Axis]) -> np.ndarray:
    """Return the polynomial at the grid points of both axes."""
    return axes[0].basis @ coefficients @ axes[1].basis.T


def _fit_weighted(
    heights: np.ndarray, weights: np.ndarray, axes: list[_Axis], terms: list[tuple[int, int]]
) -> np.ndarray:
    """Return c (j, i) that minimises sum w (h - form)^2; a second pass corrects rounding errors."""
    y, x = axes
    ky, kx = y.order + 1, x.order + 1
    # moments of all products, axis by axis: two matrix products for all sums over the map
    moments = (y.products.T @ weights @ x.products).reshape(ky, ky, kx, kx)
    index_y, index_x = (np.array(index) for index in zip(*terms, strict=True))
    matrix = moments[index_y[:, None], index_y[None, :], index_x[:, None], index_x[None, :]]
    coefficients = np.zeros((ky, kx))
    weighted_heights = weights * heights
    for refining in (False, True):
        if refining:
            np.subtract(heights, _evaluate(coefficients, axes), out=weighted_heights)
            weighted_heights *= weights
        rhs = (y.basis.T @ weighted_heights @ x.basis)[index_y, index_x]
        coefficients[index_y, index_x] += np.linalg.lstsq(matrix, rhs, rcond=1e-13)[0]
    return coefficients


def _fit_robust(
    heights: np.ndarray, is_measured: np.ndarray, axes: list[_Axis], terms: list[tuple[int, int]]
) -> np.ndarray:
    """Return the robust coefficients, started from a fit to a thinned map if the map is large."""
    stride = int(np.sqrt(heights.size / _START_POINTS))
    if stride > 1 and is_measured[::stride, ::stride].sum() > _START_POINTS / 4:
        start = _fit_robust(
            heights[::stride, ::stride],
            is_measured[::stride, ::stride],
            [axis.thinned(stride) for axis in axes],
            terms,
        )
        # so near the solution the biweight needs no start by absolute values
        return _reweight(heights, is_measured, axes, terms, start, least_absolute=False)
    start = _fit_weighted(heights, is_measured.astype(float), axes, terms)
    return _reweight(heights, is_measured, axes, terms, start, least_absolute=True)


def _reweight(
    heights: np.ndarray,
    is_measured: np.ndarray,
    axes: list[_Axis],
    terms: list[tuple[int, int]],
    coefficients: np.ndarray,
    *,
    least_absolute: bool,
) -> np.ndarray:
    """Return the coefficients of iteratively reweighted least squares after convergence."""
    negligible = 1e-12 * np.ptp(heights[is_measured])
    for iteration in range(_ITERATIONS):
        residual = _evaluate(coefficients, axes)
        np.subtract(heights, residual, out=residual)
        scale = robust_scale(residual[is_measured], overwrite=True)
        if not scale > negligible:
            return coefficients  # more than half of the points lie on the form
        if least_absolute:
            # least absolute values; the limit keeps points on the form from an infinite weight
            weights = 1 / np.maximum(np.abs(residual), 1e-3 * scale)
        else:
            weights = biweight(residual, scale)
        del residual
        weights[~is_measured] = 0
        previous, coefficients = coefficients, _fit_weighted(heights, weights, axes, terms)
        change = np.abs(coefficients - previous).max()
        if least_absolute and (change <= 1e-2 * scale or iteration == 20):
            least_absolute = False
        elif not least_absolute and change <= _CONVERGED * scale:
            break
    return coefficients


def _record(coefficients: np.ndarray, axes: list[_Axis], order: int) -> dict[str, dict]:
    """Return the record of a polynomial: mean, slopes and curvatures at the middle, coefficients."""
    y, x = axes
    quantity = {"mean": (coefficients[0, 0], "m")}

    def derivative(nth, along):
        orders = (nth, 0) if along == "y" else (0, nth)
        py, px = (
            [
                legendre.legval(0.0, legendre.legder(np.eye(axis.order + 1)[k], m))
                for k in range(axis.order + 1)
            ]
            for axis, m in zip(axes, orders, strict=True)
        )
        at_middle = np.outer(py, px)
        half = y.half if along == "y" else x.half
        return float((coefficients * at_middle).sum() / half**nth)

    for nth, name, units in ((1, "slope", "1"), (2, "curvature", "m-1")):
        if order >= nth:
            for along in "xy":
                quantity[f"{name}_{along}"] = (derivative(nth, along), units)
    if order >= 2:
        for along, axis in (("x", x), ("y", y)):
            quantity[f"middle_{along}"] = (axis.middle, "m")
            quantity[f"half_length_{along}"] = (axis.half, "m")
        for j in range(y.order + 1):
            for i in range(x.order + 1):
                if i + j <= order:
                    quantity[f"c_{i}_{j}"] = (coefficients[j, i], "m")
    return {name: {"value": float(value), "units": units} for name, (value, units) in quantity.items()}
