"""Arms of the intervals, by quantiles of the errors of a bank of measured and synthetic surfaces.

Every part of each map was evaluated as the measurement; its error e = t(truth) - t(part) on the scale of the
quantity is that against the mean of the other parts (`surface`), each of them (`next`), the whole map
(`longer`), or pixels half as large (`octave`). The arms are quantiles of e/s, s = exp(b0 + sum b_i f_i) with
features f of `subwindows`, each file with the same weight: split conformal prediction (Vovk, Gammerman and
Shafer 2005, Algorithmic Learning in a Random World; Lei, G'Sell, Rinaldo, Tibshirani and Wasserman 2018, J.
Am. Stat. Assoc. 113, 1094, for scaled errors). They hold for a map that could be one of the bank's.
`calibration.json` is written by `benchmarks/calibrate.py`.
"""

import json
import math
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any, Literal

import numpy as np

from roughcontact.uncertainty.scales import CONSTRICTIONS, inverse_erf_area

Measurand = Literal["surface", "next", "longer", "map"]
Features = Mapping[str, np.ndarray | float]  # feature -> number, or array (load)
MAP_SCATTER = "map_scatter"  # attribute (load): standard deviation of the area between maps of this size


@cache
def table(package: str = __package__) -> dict[str, Any]:
    """Return the content of `calibration.json` of a package."""
    return json.loads(resources.files(package).joinpath("calibration.json").read_text())


def entry(name: str) -> str:
    """Return the name under which a quantity stands in the table, both narrowest places in one entry."""
    return "critical_constriction" if name in CONSTRICTIONS else name


def _expected_size(slopes: Mapping[str, float], features: Features) -> np.ndarray:
    """Return exp(sum of slope times feature), the expected size of an error or a scatter."""
    return np.exp(sum(slope * np.asarray(features.get(key, 1.0)) for key, slope in slopes.items()))


def scatter_of_maps(features: Features) -> dict[str, np.ndarray]:
    """Return the attribute with the scatter of the area between maps of this size, on its scale (load)."""
    return {MAP_SCATTER: _expected_size(table()[MAP_SCATTER], features)}


def arms(
    measurand: Measurand, name: str, features: Features, area: np.ndarray, *, extent: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far the truth lies below and above a result (load), on its scale; negative if it is apart.

    `area` (load) tells the loads of the bank apart. A share of the trend (mean of the subwindows less the
    result) moves both; arms of a surface `extent` times as long as the map are interpolated in ln(extent) to
    the bank's extent.
    """
    if measurand == "longer":
        share = math.log(extent) / math.log(table()["extent"])
        surface, longer = (at_area(table()["arms"][m][entry(name)], area) for m in ("surface", "longer"))
        lower, upper = ((1 - share) * a + share * b for a, b in zip(surface, longer, strict=True))
    else:
        lower, upper = at_area(table()["arms"][measurand][entry(name)], area)
    size = _expected_size(table()["size"][entry(name)], features)
    trend = 0.0 if measurand == "map" else table()["trend"][entry(name)]
    shift = trend * np.asarray(features["trend"]) if trend else 0.0
    return lower * size - shift, upper * size + shift


def at_area(
    calibrated: Mapping[str, list[float]], area: np.ndarray, keys: Sequence[str] = ("down", "up")
) -> list[np.ndarray]:
    """Return calibrated numbers, known by "load" (the scale of the area), at contact areas (load)."""
    x = np.log(np.maximum(inverse_erf_area(area), 1e-12))
    return [np.interp(x, calibrated["load"], calibrated[key]) for key in keys]


def octave_arms(name: str) -> tuple[float, float]:
    """Return the arms of one octave more, down and up, over the root of 1 + (change by the last one)^2."""
    octave = table()["octave"][entry(name)]
    return octave["down"], octave["up"]


def discretisation_floor(name: str) -> float:
    """Return the least half-width that stays after the extrapolation to no pixels, on the scale."""
    return table()["discretisation"][entry(name)]
