"""Arms of the intervals, by quantiles of the errors of a bank of measured and synthetic surfaces.

Every part of each map was evaluated as the measurement; its error e = t(truth) - t(part) on the scale of the
quantity is that against the mean of the other parts (`surface`), each of them (`next`), or pixels half as
large (`octave`). The arms are quantiles of e/s, s = exp(b0 + sum b_i f_i) with
features f of `subwindows`, each file with the same weight: split conformal prediction (Vovk, Gammerman and
Shafer 2005, Algorithmic Learning in a Random World; Lei, G'Sell, Rinaldo, Tibshirani and Wasserman 2018, J.
Am. Stat. Assoc. 113, 1094, for scaled errors). They hold for a map that could be one of the bank's.
`calibration.json` is written by `benchmarks/calibrate.py`, `two_magnifications.py` and `profiles.py`.
"""

import json
import math
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any, Literal, get_args

import numpy as np
import scipy

from roughcontact.uncertainty.scales import APPROACH, AREA, CONSTRICTIONS, GAP, PRESSURE, inverse_erf_area

Measurand = Literal["surface", "next", "map", "alone", "joint"]
ALONE: Literal["alone"] = "alone"  # the surface by the fine map alone, where there is an overview
JOINT: Literal["joint"] = "joint"  # as large as the overview
MEASURANDS: tuple[Measurand, ...] = get_args(Measurand)[:-2]
Features = Mapping[str, np.ndarray | float]  # feature -> number, or array (load)
_COARSER = 1.25  # pixels of an overview over the coarsest ones of the bank


@cache
def table() -> dict[str, Any]:
    """Return the content of `calibration.json`."""
    return json.loads(resources.files(__package__).joinpath("calibration.json").read_text())


def entry(name: str) -> str:
    """Return the name under which a quantity stands in the table; lengths of one kind have one entry."""
    return "critical_constriction" if name in CONSTRICTIONS else GAP if name == APPROACH else name


def scatter_between_maps(name: str, half_width: np.ndarray | float) -> tuple[np.ndarray, float]:
    """Return the standard deviation that maps of a surface are expected to have, and its degrees of freedom.

    `half_width` is that of the source `window` of a map, on the scale of the quantity; so many degrees of
    freedom does it count for beside the scatter of measured maps.
    """
    # the pressure in contact is the load over the area
    key, groups = entry(AREA if name == PRESSURE else name), table()["groups"]
    return np.asarray(half_width) / groups["half_width"][key], groups["freedom"][key]


def arms(
    measurand: Measurand, name: str, features: Features, area: np.ndarray, gap: np.ndarray | float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far the truth lies below and above a result (load), on its scale; negative if it is apart.

    `area` (load) tells the loads of the bank apart. The trend, the mean of the subwindows less the result,
    moves both where the features have it. `gap` is the mean gap over the rms height, by which that of the
    truth is limited (`limit_of_gap`), alone for the joint, of which a map says nothing else.
    """
    key: Measurand = "surface" if measurand == ALONE else measurand
    lower = upper = np.full(np.shape(area), np.inf)
    if key != JOINT:
        lower, upper = look_up(table()["arms"][key][entry(name)], area)
    slopes = table()["size"][entry(name)]
    size = np.exp(sum(slope * np.asarray(features.get(key, 1.0)) for key, slope in slopes.items()))
    shift = 0.0 if key == "map" else features.get("trend", 0.0)
    limit = limit_of_gap(key, area, gap) if name == GAP else np.inf
    return lower * size - shift, np.fmin(upper * size + shift, limit)


def overview_arms(
    measurand: Measurand, name: str, pixels: float, area: np.ndarray, sees_map: bool = True
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return by how much the changes that an overview shows count, and its arms down and up (load).

    The first is of the quantity, further ones of its counterparts. The arms are over the expected size,
    `pixels` those of the overview over those of the fine map: between those of the bank arms are
    interpolated in their logarithm, finer ones have the nearest. Of much coarser ones nothing is known
    (inf).
    """
    by_pixels = table()["overview" if sees_map else "elsewhere"].get(measurand, {}).get(name, {})
    x, logarithms = math.log(pixels), np.log([float(key) for key in by_pixels])
    if not by_pixels or x > logarithms[-1] + math.log(_COARSER):
        return np.zeros(1), *np.full((2, *np.shape(area)), np.inf)
    numbers = [(arm["shares"], look_up(arm, area)) for arm in by_pixels.values()]
    inside = np.clip(x, *logarithms[[0, -1]])
    shares, arms_of_bank = (
        scipy.interpolate.make_interp_spline(logarithms, values, k=1)(inside)
        for values in zip(*numbers, strict=True)
    )
    return shares, *arms_of_bank


def limit_of_gap(measurand: Measurand, area: np.ndarray, gap: np.ndarray | float) -> np.ndarray:
    """Return how far the mean gap of the truth may lie above that of a map at most, on its scale (load).

    `gap` is over the rms height of the map: on the logarithm the errors of the gap grow without end as it
    closes, in rms heights they do not. Below the lightest load of the bank nothing is known (inf).
    """
    limits = table()["limit_of_gap"].get(measurand, {"load": [math.inf], "up": [math.inf]})
    larger = np.interp(_logarithm_of_load(area), limits["load"], limits["up"], left=np.inf)
    with np.errstate(divide="ignore"):
        return np.log1p(larger / gap)


def look_up(
    numbers_by_load: Mapping[str, list[float]], area: np.ndarray, keys: Sequence[str] = ("down", "up")
) -> list[np.ndarray]:
    """Return calibrated numbers, known by "load" (the scale of the area), at contact areas (load)."""
    x = _logarithm_of_load(area)
    return [np.interp(x, numbers_by_load["load"], numbers_by_load[key]) for key in keys]


def _logarithm_of_load(area: np.ndarray) -> np.ndarray:
    """Return the scale of contact areas, by which the loads of the bank are known."""
    return np.log(np.maximum(inverse_erf_area(area), 1e-12))
