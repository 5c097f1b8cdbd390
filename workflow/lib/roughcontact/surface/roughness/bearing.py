"""Material ratio curve of a levelled map and its ISO 25178-2 parameters: core, peaks, dales."""

import math

import numpy as np

_CENTRAL_WIDTH = 0.4  # of the central region of the curve, in material ratio
_PEAK_RATIO, _DALE_RATIO = 0.1, 0.8  # material ratios that bound the core in the volume parameters
_EXTREME_RATIO, _MIDDLE_RATIO = 0.025, 0.5  # of Sdc

BEARING_PARAMETERS = (
    *("Sk", "Spk", "Svk", "Spkx", "Svkx", "Sak1", "Sak2", "Smr1", "Smr2"),
    *("Vmp", "Vmc", "Vvc", "Vvv", "Sdc"),
)


def bearing_parameters(heights: np.ndarray) -> dict[str, float]:
    """Return the ISO 25178-2:2021 parameters of the material ratio curve of heights (m, in any order).

    The curve c(mr), the height exceeded by a share mr of the points, is linear between their heights. `Sk`,
    `Spk`, `Svk`, `Spkx`, `Svkx` (4.5.4), `Vmp`, `Vmc`, `Vvc`, `Vvv` (volumes per area, 4.5.6 and 4.5.7),
    `Sdc` (4.5.3; `Sxp` in the edition of 2012) and the areas of the triangles `Sak1`, `Sak2` are in m, the
    material ratios `Smr1`, `Smr2` (`Smrk1`, `Smrk2` in that of 2021) from 0 to 1, NaN where all heights are
    equal; the core is that of ISO 13565-2:1996.
    """
    curve = np.negative(heights)
    curve.sort()
    np.negative(curve, out=curve)  # contiguous in memory, in descending order
    curve -= curve[-1]  # heights above the lowest point
    if curve[0] == 0:
        return dict.fromkeys(BEARING_PARAMETERS, 0.0) | {"Smr1": math.nan, "Smr2": math.nan}
    ratio = np.linspace(0, 1, curve.size)
    # the central region is where the secant of 40 % has the smallest slope, the first one if several are
    # equal, among positions where it still fits; the allowance for rounding keeps the last one
    count = int(np.searchsorted(ratio, 1 - _CENTRAL_WIDTH + 1e-12, side="right"))
    fall = np.interp(ratio[:count] + _CENTRAL_WIDTH, ratio, curve)
    np.subtract(curve[:count], fall, out=fall)
    start = int(fall.argmin())
    del fall  # memory may not hold more than is needed of a large map
    # rounding must not drop the last point
    stop = int(np.searchsorted(ratio, ratio[start] + _CENTRAL_WIDTH + 1e-12, side="right"))
    # the least-squares line through it, extended from 0 to 100 %, bounds the core; triangles of equal area
    # replace the curve above and below
    middle, y = ratio[start:stop].mean(), curve[start:stop]
    x = ratio[start:stop] - middle
    slope = float(x @ y / (x @ x)) if x.size > 1 else 0.0
    del x
    upper = float(y.mean() - slope * middle)
    lower = upper + slope
    # the material ratios at these heights, 0 above the curve and 1 below it
    enters, leaves = map(float, np.interp([upper, lower], curve[::-1], ratio[::-1]))
    peaks = _area(enters, ratio, curve, above=True)
    dales = _area(leaves, ratio, curve, above=False)
    bounds = _PEAK_RATIO, _DALE_RATIO
    peak_material, core_material = (_area(bound, ratio, curve, above=True) for bound in bounds)
    core_void, dale_void = (_area(bound, ratio, curve, above=False) for bound in bounds)
    extreme, middle = np.interp([_EXTREME_RATIO, _MIDDLE_RATIO], ratio, curve)
    return {
        "Sk": upper - lower,
        # a triangle of the same area over the ratio where peaks begin
        "Spk": 2 * peaks / enters if enters > 0 else 0.0,
        "Svk": 2 * dales / (1 - leaves) if leaves < 1 else 0.0,
        "Spkx": max(float(curve[0]) - upper, 0.0),
        "Svkx": max(lower, 0.0),  # the lowest point is at 0
        "Sak1": peaks,
        "Sak2": dales,
        "Smr1": enters,
        "Smr2": leaves,
        "Vmp": peak_material,
        "Vmc": core_material - peak_material,
        "Vvc": core_void - dale_void,
        "Vvv": dale_void,
        "Sdc": float(extreme - middle),
    }


def _area(material_ratio: float, ratio: np.ndarray, curve: np.ndarray, *, above: bool) -> float:
    """Return the area between the curve and its height at a material ratio, above or below that height."""
    height = float(np.interp(material_ratio, ratio, curve))
    index = int(np.searchsorted(ratio, material_ratio, side="left" if above else "right"))
    side, end = (slice(index), index) if above else (slice(index, None), 0)
    distance = np.insert(curve[side], end, height)
    distance -= height
    return float(np.trapezoid(np.abs(distance, out=distance), np.insert(ratio[side], end, material_ratio)))
