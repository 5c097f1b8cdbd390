"""Arms of the intervals, by quantiles of the errors of a bank of measured and synthetic surfaces.

Each map of the bank was cut into parts; every part was evaluated as if it were the measurement, and its error
e = t(truth) - t(part), on the scale of the quantity, taken against the mean of the other parts (`surface`),
each of the others (`next`), the whole map (`longer`), or the part with pixels half as large (`octave`). The
expected size of the error is

    s = exp(b0 + sum b_i f_i)

with the features f of `roughcontact.uncertainty.subwindows`; the arms are quantiles of e/s, each file with
the same weight (split conformal prediction). They hold for a map that could be one of the bank's.

`calibration.json` is written by `benchmarks/calibrate.py`; the bank is `benchmarks/results/bank.csv`.

References
----------
Vovk, Gammerman and Shafer (2005), Algorithmic Learning in a Random World; Lei, G'Sell, Rinaldo, Tibshirani
and Wasserman (2018), J. Am. Stat. Assoc. 113, 1094, for errors scaled by their expected size.
"""

import json
import math
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any, Literal

import numpy as np

from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, PRESSURE, inverse_erf_area

Measurand = Literal["surface", "next", "longer", "map"]
CONSTRICTION = "critical_constriction"  # both axes in one entry
BANK_EXTENT = 3.0  # length of a whole map of the bank over that of its parts


@cache
def table() -> dict[str, Any]:
    """Return the content of `calibration.json`."""
    return json.loads(resources.files(__package__).joinpath("calibration.json").read_text())


def entry(name: str) -> str:
    """Return the name under which a quantity stands in the table."""
    return CONSTRICTION if name in CONSTRICTIONS else AREA if name == PRESSURE else name


def expected_error(name: str, features: Mapping[str, np.ndarray | float]) -> np.ndarray:
    """Return the expected size of the error of a quantity of a map, on its scale; of places in mean gaps.

    Parameters
    ----------
    name : str
    features : mapping
        feature -> number, or array (load).
    """
    constant, *slopes = table()["size"][entry(name)]
    return np.exp(
        constant + sum(b * np.asarray(features[f]) for f, b in zip(table()["features"], slopes, strict=True))
    )


def arms(
    measurand: Measurand, name: str, features: Mapping[str, np.ndarray | float], area: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far the truth lies below and above a result, on its scale; negative if it is apart.

    A share of the trend, of the mean of the subwindows less the result, moves both: a largest pressure far
    above those of the subwindows is an outlier, and the surface shows less.

    Parameters
    ----------
    measurand : str
    name : str
        of the quantity.
    features : mapping
        feature -> number, or array (load).
    area : array (load)
        relative contact area, which tells the loads of the bank from one another.
    """
    known = table()["arms"][measurand][entry(name)]
    x = np.log(np.maximum(inverse_erf_area(area), 1e-12))
    size, shift = expected_error(name, features), known["trend"] * np.asarray(features["trend"])
    down, up = (np.interp(x, known["load"], known[side]) for side in ("down", "up"))
    return down * size - shift, up * size + shift


def arms_of_longer(
    name: str, features: Mapping[str, np.ndarray | float], area: np.ndarray, extent: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return `arms` for the surface over `extent` times the length of the map.

    They are those of the bank's extent, and of the surface in the band of the map at 1, linear in ln(extent).
    """
    share = math.log(extent) / math.log(BANK_EXTENT)
    near, far = arms("surface", name, features, area), arms("longer", name, features, area)
    down, up = ((1 - share) * a + share * b for a, b in zip(near, far, strict=True))
    return down, up


def octave_arms(name: str) -> tuple[float, float, float]:
    """Return the share of the last octave's change that the next one adds, and the arms about it."""
    known = table()["octave"][entry(name)]
    return known["share"], known["down"], known["up"]


def discretisation_floor(name: str) -> float:
    """Return the least half-width that stays after the extrapolation to no pixels, on the scale."""
    return table()["discretisation"][entry(name)]
