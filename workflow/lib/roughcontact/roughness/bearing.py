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
    """Return core height, peak and dale heights and areas, material ratios, volumes and a height difference.

    The curve c(mr), the height exceeded by a share mr of the measured points, is linear between their heights
    (m, in any order). Its central region, 40 % wide, is where its secant has the smallest slope (the first
    one if several are equal). The least-squares line through this region, extended from 0 to 100 %, bounds
    the core [1]_. The parts of the curve above and below the core are replaced by triangles of equal area:

    * `Sk`: height of the core, `Spk`, `Svk`: heights of the triangles, m
    * `Spkx`, `Svkx`: heights of the highest point above and of the lowest one below the core, m
    * `Sak1`, `Sak2`: areas of the triangles, with the material ratio as a share (0 to 1), m
    * `Smr1`, `Smr2`: material ratios (0 to 1, NaN where all heights are equal) where the curve enters and
      leaves the core; `Smrk1` and `Smrk2` in the edition of 2021
    * `Vmp`, `Vmc`: material volume above the ratio 10 %, and from there to 80 %, per area, m
    * `Vvc`, `Vvv`: void volume between the ratios 10 % and 80 %, and below 80 %, per area, m
    * `Sdc`: height between the ratios 2.5 % and 50 %, m; with these ratios `Sxp` in the edition of 2012

    References
    ----------
    .. [1] ISO 25178-2:2021, 4.5.3 (Sdc), 4.5.4 (of the core), 4.5.6, 4.5.7 (volumes); ISO 13565-2:1996.

    Examples
    --------
    Uniformly distributed heights have a straight curve, which is all core:

    >>> import numpy as np
    >>> found = bearing_parameters(np.linspace(0.0, 1e-6, 1001))
    >>> print(f"Sk {found['Sk']:.3g} m, Spk {found['Spk']:.3f} m, Vvv {found['Vvv']:.3g} m")
    Sk 1e-06 m, Spk 0.000 m, Vvv 2e-08 m
    """
    curve = np.negative(heights)
    curve.sort()
    np.negative(curve, out=curve)  # contiguous in memory, in descending order
    curve -= curve[-1]
    if curve[0] == 0:
        return dict.fromkeys(BEARING_PARAMETERS, 0.0) | {"Smr1": math.nan, "Smr2": math.nan}
    ratio = np.linspace(0, 1, curve.size)
    # positions where the window still fits; the allowance for rounding keeps the last one
    count = int(np.searchsorted(ratio, 1 - _CENTRAL_WIDTH + 1e-12, side="right"))
    fall = np.interp(ratio[:count] + _CENTRAL_WIDTH, ratio, curve)
    np.subtract(curve[:count], fall, out=fall)
    start = ratio[int(fall.argmin())]
    del fall  # memory may not hold more than is needed of a large map
    begin = int(np.searchsorted(ratio, start))
    end = int(np.searchsorted(ratio, start + _CENTRAL_WIDTH + 1e-12, side="right"))
    middle, y = ratio[begin:end].mean(), curve[begin:end]
    x = ratio[begin:end] - middle
    slope = float(x @ y / (x @ x)) if x.size > 1 else 0.0
    del x
    upper = float(y.mean() - slope * middle)
    lower = upper + slope
    enters, leaves = (_ratio_of(height, ratio, curve) for height in (upper, lower))
    peaks = _material(enters, ratio, curve)
    dales = _void(leaves, ratio, curve)
    material = {
        material_ratio: _material(material_ratio, ratio, curve)
        for material_ratio in (_PEAK_RATIO, _DALE_RATIO)
    }
    void = {
        material_ratio: _void(material_ratio, ratio, curve) for material_ratio in (_PEAK_RATIO, _DALE_RATIO)
    }
    extreme, middle = np.interp([_EXTREME_RATIO, _MIDDLE_RATIO], ratio, curve)
    return {
        "Sk": upper - lower,
        "Spk": 2 * peaks / enters if enters > 0 else 0.0,
        "Svk": 2 * dales / (1 - leaves) if leaves < 1 else 0.0,
        "Spkx": max(float(curve[0]) - upper, 0.0),
        "Svkx": max(lower, 0.0),  # the lowest point is at 0
        "Sak1": peaks,
        "Sak2": dales,
        "Smr1": enters,
        "Smr2": leaves,
        "Vmp": material[_PEAK_RATIO],
        "Vmc": material[_DALE_RATIO] - material[_PEAK_RATIO],
        "Vvc": void[_PEAK_RATIO] - void[_DALE_RATIO],
        "Vvv": void[_DALE_RATIO],
        "Sdc": float(extreme - middle),
    }


def _ratio_of(height: float, ratio: np.ndarray, curve: np.ndarray) -> float:
    """Return the material ratio at which the curve has a height; 0 above and 1 below the curve."""
    return float(np.interp(height, curve[::-1], ratio[::-1]))


def _material(material_ratio: float, ratio: np.ndarray, curve: np.ndarray) -> float:
    """Return the area between the curve and its height at a material ratio, at smaller ratios."""
    height = float(np.interp(material_ratio, ratio, curve))
    left = int(np.searchsorted(ratio, material_ratio))
    above = np.append(curve[:left], height)
    above -= height
    return float(np.trapezoid(above, np.append(ratio[:left], material_ratio)))


def _void(material_ratio: float, ratio: np.ndarray, curve: np.ndarray) -> float:
    """Return the area between the curve and its height at a material ratio, at larger ratios."""
    height = float(np.interp(material_ratio, ratio, curve))
    right = int(np.searchsorted(ratio, material_ratio, side="right"))
    below = np.insert(curve[right:], 0, height)
    np.subtract(height, below, out=below)
    return float(np.trapezoid(below, np.insert(ratio[right:], 0, material_ratio)))
