"""Probability densities over logarithmic bins that do not depend on the loads, and shares above a limit."""

import numpy as np

from roughcontact.contact.dataset import carrying

PRESSURE_DECADES = (-3, 3)  # in units of E* g
GAP_DECADES = (-4, 0)  # in units of the peak-to-valley height, which no gap exceeds
PATCH_BINS = 5  # per factor of ten of the area of a patch, from one pixel on
PATCH_DECADES = (0, 9)  # up to more points than a map can have, so that the bins of all maps are as many

# hardness over contact modulus of classes of materials, for a run that states none: annealed pure metals;
# structural steels and aluminium alloys; hardened steels and carbides; ceramics, glasses, glassy polymers
# (Ashby 2011, Materials Selection in Mechanical Design, with H = 3 Y of Tabor 1951, The Hardness of Metals)
HARDNESS_OVER_MODULUS = np.array([0.003, 0.01, 0.03, 0.1])


def logarithmic_edges(decades: tuple[int, int], per_decade: int) -> np.ndarray:
    """Return the bounds of bins: 0, then `per_decade` per factor of ten between two powers of ten."""
    low, high = decades
    return np.concatenate([[0.0], 10.0 ** np.linspace(low, high, (high - low) * int(per_decade) + 1)])


def density(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the probability density of values in bins with rising `edges`; NaN where there are no values.

    Values beyond the bounds count in the first and last bin, those on a bound above it: it always integrates
    to 1.
    """
    if values.size == 0:
        return np.full(edges.size - 1, np.nan)
    counts, _ = np.histogram(values, [-np.inf, *edges[1:-1], np.inf])
    return counts / (values.size * np.diff(edges))


def shares_above(pressures: np.ndarray, limit: float) -> tuple[float, float]:
    """Return the shares (0 to 1) of load and of contact area on points at a pressure limit (Pa) or above.

    `pressures` has the pressures of the points in contact; rounding counts as reaching the limit.

    Examples
    --------
    >>> import numpy as np
    >>> shares_above(np.array([1.0, 2.0, 5.0]), 2.0)
    (0.875, 0.6666666666666666)
    """
    above = carrying(pressures, limit)
    # one sum for both, so that all of it is exactly 1
    load = pressures.sum(where=above, dtype=float) / pressures.sum(dtype=float) if not above.all() else 1.0
    return float(load), float(above.mean())


def bearing_numbers(
    pressures: np.ndarray, *, contact_modulus: float, hardness: float | None
) -> dict[str, float | np.ndarray]:
    """Return the pressures (Pa) of the points in contact over the modulus, and the shares above a strength.

    This is the `hardness` (Pa), or each of `HARDNESS_OVER_MODULUS` times the modulus; shares of load and of
    contact area.

    Examples
    --------
    >>> import numpy as np
    >>> found = bearing_numbers(np.array([1e9, 3e9]), contact_modulus=1e11, hardness=None)
    >>> found["max_pressure_over_modulus"], found["load_share_above_ratio"]
    (0.03, array([1.  , 1.  , 0.75, 0.  ]))
    """
    largest = float(pressures.max()) / contact_modulus
    numbers: dict[str, float | np.ndarray] = {"max_pressure_over_modulus": largest}
    if hardness is not None:
        load, area = shares_above(pressures, hardness)
        return numbers | {"load_share_above_hardness": load, "area_share_above_hardness": area}
    shares = np.array([shares_above(pressures, ratio * contact_modulus) for ratio in HARDNESS_OVER_MODULUS])
    return numbers | {"load_share_above_ratio": shares[:, 0], "area_share_above_ratio": shares[:, 1]}
