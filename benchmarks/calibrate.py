"""Calibrate the ± on a bank of surfaces: errors of parts of measured and synthetic maps, and what told them.

    python benchmarks/calibrate.py FOLDER ... --write          # the bank, the calibration, the tables
    python benchmarks/calibrate.py --fit --write               # calibration and tables from the bank as it is
    python benchmarks/calibrate.py FOLDER ... --held-out       # coverage on maps that are not in the bank

Every map in the folders that is read without being told anything, with 192 points or more along each side,
is cut into 3 x 3 and, where these have 128 points, into 2 x 2 parts. Each part is processed by default
settings as if it were the measurement, at mean pressures p/(E* g) of the whole map. The bank
(`results/bank`) keeps, for each part and load, the results on their scales
(`roughcontact.uncertainty.scales`) and the features of `roughcontact.uncertainty.subwindows`; no heights.
Synthetic surfaces of the kinds of `validation.masters` and of `instruments.other_surface` are treated alike.

Truths: of *the surface* the mean of the other parts, of *the next map* each of them, of the *longer* surface
the whole map, of *one octave shorter* the part itself, its evaluation being that of the part with pixels
merged 2 x 2. For *this map* windows of measured maps and synthetic surfaces are taken for one period of a
periodic surface, and measured from another first point, tilted, with spots missing.

Arms are quantiles of error over expected size, each map with the same weight; the size is fitted so that the
score of the intervals (Winkler 1972, J. Am. Stat. Assoc. 67, 187) is lowest. Coverage, width and score are
those of maps left out one after the other.
"""

import argparse
import itertools
import json
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import instruments
import numpy as np
import pages
import pandas as pd
from scipy.optimize import minimize

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.contact.loads import plan_loads
from roughcontact.errors import RoughContactError
from roughcontact.maps import height_map, refined, spacing
from roughcontact.statistics.precision import precision
from roughcontact.uncertainty.calibration import MAP_SCATTER
from roughcontact.uncertainty.discretisation import extrapolated
from roughcontact.uncertainty.ensemble import Result, solve_member
from roughcontact.uncertainty.improvement import half_width_of_mean, median_of_chi
from roughcontact.uncertainty.random_effects import student
from roughcontact.uncertainty.scales import (
    AREA,
    CONDUCTANCE,
    CONSTRICTIONS,
    GAP,
    PEAK,
    from_scale,
    to_scale,
)
from roughcontact.uncertainty.subwindows import scatter_of_subwindows
from roughcontact.uncertainty.unresolved import shortest_wave, without_shortest_waves
from validation.masters import KINDS, master_surface

LOADS = (0.005, 0.02, 0.1, 0.4, 1.0)  # of E* times the rms gradient of the whole map
SMALLEST, LARGEST = 192, 540  # points along the sides of a map; larger ones are cut to their middle
CUTS = (3, 2)
LEAST_PART = {3: 64, 2: 128}  # points
PIXELS = 128  # points along the sides of windows that are solved with finer pixels
MADE_SIDE = 160  # points of a part of a synthetic surface
LONGEST = (1 / 8, 1 / 3, 1.0)  # waves of synthetic surfaces, of the length of a part
OTHER_KINDS = ("cratered", "conical", "stretched", "lognormal")
NAMES = (AREA, GAP, PEAK, CONDUCTANCE, *CONSTRICTIONS)
SHORT = {
    AREA: "area",
    GAP: "gap",
    PEAK: "peak",
    CONDUCTANCE: "conductance",
    "critical_constriction": "narrowest",
}
NARROWEST = {CONSTRICTIONS[0]: "narrowest_x", CONSTRICTIONS[1]: "narrowest_y"}
OF_EACH = ("scatter", "trend")  # features of each quantity and load; narrowest places have none
FEATURES = ("scatter", "gradient", "lay")
# those that the size of the error is fitted to: the others do not lower the score of measured maps left out
SIZED_BY = {"area": FEATURES, **dict.fromkeys(("gap", "peak", "conductance"), FEATURES[1:]), "narrowest": ()}
MOVED_BY_TREND = ("peak",)
COVERAGE = 0.95
JUDGED_LOADS = LOADS[1:4]
LEVEL = 0.975  # of the arms, so that some 95 % hold on measured maps left out: errors have long tails
FREEDOM = 4.0  # of Student's t for the errors of the area
RIDGE = 0.05  # on the slopes of the features, in their standard deviations
SAME = 0.01  # of a logarithm, within which results are those of one map
LARGEST_ERROR = 6.0  # of a logarithm; more is a closed gap
HALVED_LOAD = 0.1  # at which the scatter of maps is fitted
CLASSES = {
    "percent": "to ± 30 % or less",
    "factor": "to a factor of 3 or less",
    "magnitude": "order of magnitude",
    "at most": "a bound",
}
BANK = Path(__file__).parent / "results" / "bank"
WORK = Path(__file__).parent / "work" / "bank"
TABLE = Path(__file__).parents[1] / "workflow/lib/roughcontact/uncertainty/calibration.json"


def evaluated(height, loads: list[float]) -> dict | None:
    """Return results and features (load) of a map by default settings (E* = 1); None where it is refused."""
    try:
        levelled = rc.level(height)
        window = rc.periodic_window(levelled)
        contact = {"contact_modulus": 1.0, "mean_pressure": loads}
        values = solve_member(window, contact, tolerance=1e-4, names=NAMES)
        scatter = scatter_of_subwindows(Result(window, contact, values), levelled, arguments={})
        shorter = without_shortest_waves(window, 2 * shortest_wave(window))
        coarse = solve_member(shorter, contact, tolerance=1e-3, names=NAMES)
    except RoughContactError:
        return None
    found = {"shape": levelled.shape}
    with np.errstate(all="ignore"):
        for name in NAMES:
            key = NARROWEST.get(name) or SHORT[name]
            unit = values[GAP] if name in NARROWEST else 1.0
            found[key] = to_scale(name, values[name]) / unit
            found[f"{key}_octave"] = found[key] - to_scale(name, coarse[name]) / unit
            features = scatter.features[name] if scatter.features else {}
            for feature in OF_EACH:
                found[f"{key}_{feature}"] = features.get(feature, np.full(len(loads), np.nan))
            for feature in FEATURES[1:]:
                found[feature] = np.full(len(loads), features.get(feature, np.nan))
    return found


def refined_results(height, loads: list[float], factor: int) -> dict | None:
    """Return the results (load) of the window of a map at so many times as many points along each axis."""
    try:
        window = refined(rc.periodic_window(rc.level(height)), factor)
    except RoughContactError:
        return None
    contact = {"contact_modulus": 1.0, "mean_pressure": loads}
    values = solve_member(window, contact, tolerance=1e-4, names=NAMES)
    with np.errstate(all="ignore"):
        return {
            NARROWEST.get(name) or SHORT[name]: to_scale(name, values[name])
            / (values[GAP] if name in NARROWEST else 1.0)
            for name in NAMES
        }


def merged(height):
    """Return a map with its pixels merged 2 x 2."""
    ny, nx = (n // 2 * 2 for n in height.shape)
    dy, dx = spacing(height)
    values = height.values[:ny, :nx].reshape(ny // 2, 2, nx // 2, 2).mean(axis=(1, 3))
    return height_map(values, (2 * dy, 2 * dx))


def rows_of(name: str, kind: str, height) -> list[dict]:
    """Return the rows of the bank of one map: the whole, its parts, these with merged pixels, one period."""
    start = [max(0, (n - LARGEST) // 2) for n in height.shape]
    height = height[start[0] : start[0] + LARGEST, start[1] : start[1] + LARGEST]
    try:
        window = rc.periodic_window(rc.level(height))
    except RoughContactError:
        return []
    loads = [float(p) for p in plan_loads(window, contact_modulus=1.0, relative_pressure=list(LOADS))]
    rows: list[dict] = []

    def add(what: str, number: int, found: dict | None) -> None:
        for index, load in enumerate(LOADS if found else ()):
            numbers = {key: column[index] for key, column in found.items() if key != "shape"}
            rows.append({"map": name, "kind": kind, "what": what, "part": number, "load": load} | numbers)

    add("whole", 0, evaluated(height, loads))
    for cuts in CUTS:
        edges = [np.arange(cuts + 1) * n // cuts for n in height.shape]
        if min(height.shape) // cuts < LEAST_PART[cuts]:
            continue
        for number, (i, j) in enumerate(itertools.product(range(cuts), repeat=2)):
            piece = height[edges[0][i] : edges[0][i + 1], edges[1][j] : edges[1][j + 1]]
            add(f"{cuts}x{cuts}", number, evaluated(piece, loads))
            if cuts == CUTS[0] and min(piece.shape) >= 96:
                add("merged", number, evaluated(merged(piece), loads))
    start = [(n - PIXELS) // 2 for n in height.shape]
    middle = height[start[0] : start[0] + PIXELS, start[1] : start[1] + PIXELS]
    for factor in (1, 2, 4):
        add(f"pixel / {factor}", 0, refined_results(middle, loads, factor))
    add("period", 0, evaluated(window, loads))
    generator = np.random.default_rng(len(rows))
    for number in range(2):
        add("measured period", number, evaluated(of_one_period(window, generator), loads))
    return rows


def of_one_period(window, generator):
    """Return one period of a periodic surface as it would be measured: from any point, tilted, with holes."""
    values = np.roll(window.values, generator.integers(0, window.shape), (0, 1)).copy()
    rms = values.std()
    tilt = generator.normal(0, 2 * rms, 2)
    values += sum(
        t * np.linspace(-1, 1, n).reshape([-1, 1] if axis == 0 else [1, -1])
        for axis, (t, n) in enumerate(zip(tilt, values.shape, strict=True))
    )
    values[generator.random(values.shape) < 0.01] = np.nan
    return height_map(values, spacing(window))


def synthetic() -> list[tuple[str, object]]:
    """Return names of synthetic surfaces, and functions that make them."""
    made = []
    for number, (kind, longest) in enumerate(itertools.product((*KINDS, *OTHER_KINDS), LONGEST)):
        made.append((f"{kind}, longest {longest:.2g}, seed {number}", partial(make, kind, longest, number)))
    return made


def make(kind: str, longest: float, seed: int):
    """Return a synthetic surface three times as long as its parts."""
    side, hurst = CUTS[0] * MADE_SIDE, (0.5, 0.7, 0.9)[seed % 3]
    if kind in OTHER_KINDS:
        return instruments.other_surface(kind, side, longest * MADE_SIDE, hurst=hurst, seed=seed)
    return master_surface(kind, side, longest=longest / CUTS[0], seed=seed, hurst=hurst)


def of_file(path: Path) -> list[dict]:
    """Return the rows of one file; none where it is no map, or too small a one."""
    warnings.simplefilter("ignore")
    try:
        height = rc.read_height_map(path).astype(float)
    except RoughContactError:
        return []
    return rows_of(path.name, "measured", height) if min(height.shape) >= SMALLEST else []


def of_synthetic(case: tuple) -> list[dict]:
    """Return the rows of one synthetic surface."""
    warnings.simplefilter("ignore")
    return rows_of(case[0], "synthetic", case[1]())


def bank_of(folders: list[Path], work: Path, *, made: bool) -> pd.DataFrame:
    """Return the rows of all maps, those of finished ones from the folder `work`."""
    work.mkdir(parents=True, exist_ok=True)
    files = sorted({path for folder in folders for path in folder.iterdir() if path.is_file()})
    jobs = [(path.name, of_file, path) for path in files]
    jobs += [(case[0], of_synthetic, case) for case in synthetic()] if made else []
    with ProcessPoolExecutor(2) as pool:
        pending = {}
        for name, function, argument in jobs:
            if not (work / f"{name}.json").exists():
                pending[name] = pool.submit(function, argument)
        for name, future in pending.items():
            rows = future.result()
            (work / f"{name}.json").write_text(pd.DataFrame(rows).to_json(orient="records"))
            print(name, len(rows), flush=True)
    tables = [pd.DataFrame(json.loads((work / f"{name}.json").read_text())) for name, *_ in jobs]
    return without_copies([table for table in tables if len(table)])


def without_copies(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """Return all rows, those of maps of equal results (the same heights in two files, rounded) once."""
    kept: list[tuple[np.ndarray, pd.DataFrame]] = []
    for table in tables:
        whole = table.loc[table["what"] == "whole", [*SHORT.values()][:4]].to_numpy()
        if not any(np.allclose(whole, other, rtol=0, atol=SAME, equal_nan=True) for other, _ in kept):
            kept.append((whole, table))
    return pd.concat([table for _, table in kept], ignore_index=True)


def errors_of(bank: pd.DataFrame, quantity: str, measurand: str) -> pd.DataFrame:
    """Return the errors of a quantity about the truths of a measurand, with their features, one row each."""
    keys = {"narrowest": tuple(NARROWEST.values())}.get(quantity, (quantity,))
    rows = []
    for (name, kind), of_map in bank.groupby(["map", "kind"], sort=False):
        for key in keys:
            for what in {"map": ("measured period",), "octave": ("merged",)}.get(measurand, ("3x3", "2x2")):
                if measurand == "longer" and what != "3x3":
                    continue
                for load, some in of_map[of_map["what"] == what].groupby("load"):
                    truths = _truths(of_map, some, key, load, measurand)
                    for row, truth in zip(some.itertuples(), truths, strict=True):
                        features = {f: getattr(row, f) for f in FEATURES[1:]}
                        own = (*OF_EACH, "octave") if measurand == "octave" else OF_EACH
                        features |= {f: getattr(row, f"{key}_{f}", 0.0) for f in own}
                        base = (
                            {"map": name, "kind": kind, "load": load, "area": row.area}
                            | features
                            | {"quantity": quantity}
                        )
                        rows += [base | {"error": value - getattr(row, key)} for value in truth]
    used = {*SIZED_BY[quantity], *(["trend"] if quantity in MOVED_BY_TREND else [])}
    if measurand == "octave":  # in full contact there is no change to scale the error by
        used.add("octave")
    found = pd.DataFrame(rows).dropna(subset=["error", "area", *used])
    found[list(OF_EACH)] = found[list(OF_EACH)].fillna(0.0)
    found["error"] = found["error"].clip(-LARGEST_ERROR, LARGEST_ERROR)
    count = found.groupby(["map", "load"])["error"].transform("size")
    found["weight"] = 1 / count
    return found


def _truths(
    of_map: pd.DataFrame, some: pd.DataFrame, key: str, load: float, measurand: str
) -> list[list[float]]:
    """Return for each row of some parts the truths that it is held against, on the scale."""
    own = some[key].to_numpy()
    if measurand in ("surface", "next"):
        others = [np.delete(own, index) for index in range(own.size)]
        return [list(o) if measurand == "next" else [o.mean()] for o in others]
    what = {"longer": "whole", "map": "period", "octave": "3x3"}[measurand]
    truth = of_map[(of_map["what"] == what) & (of_map["load"] == load)]
    if measurand == "octave":
        return [list(truth.loc[truth["part"] == part, key]) for part in some["part"]]
    return [list(truth[key])] * own.size


def fitted(errors: pd.DataFrame) -> tuple[float, pd.Series]:
    """Return the share c of the trend, and b of the size s = exp(sum b f), of some errors; b by feature.

    The features are those of `SIZED_BY`, and a constant 1. Errors of the area are Student's t, scaled by s:
    maximum likelihood. All others have longer tails: theirs are those of the lowest score of intervals whose
    arms are quantiles of (error - c trend)/s at each load. A small penalty is on the slopes, in standard
    deviations of the features; the arms take up any constant.
    """
    quantity = errors["quantity"].iloc[0]
    names, by_trend = list(SIZED_BY[quantity]), quantity in MOVED_BY_TREND
    if not names:
        return 0.0, pd.Series({"constant": 0.0})
    errors = errors[errors["load"].isin(JUDGED_LOADS)]
    features, trend, error = (errors[key].to_numpy() for key in (names, "trend", "error"))
    weight, loads = errors["weight"].to_numpy(), errors["load"].to_numpy()
    middle = np.average(features, axis=0, weights=weight)
    spread = np.sqrt(np.average((features - middle) ** 2, axis=0, weights=weight))
    scaled, groups = (features - middle) / spread, [loads == load for load in JUDGED_LOADS]

    def likelihood(b: np.ndarray) -> float:
        size = b[1] + scaled @ b[2:]
        ratio = (error - b[0]) * np.exp(-size)
        terms = size + (FREEDOM + 1) / 2 * np.log1p(ratio**2 / FREEDOM)
        return float(np.average(terms, weights=weight) + RIDGE * np.sum(b[2:] ** 2))

    def score(b: np.ndarray) -> float:
        slopes = b[1:] if by_trend else b
        size, remaining, scores = np.exp(scaled @ slopes), error - (b[0] * trend if by_trend else 0.0), []
        for some in groups:
            low, high = quantiles(remaining[some] / size[some], weight[some], LEVEL)
            of_some = interval_score(low * size[some], high * size[some], remaining[some])
            scores.append(np.average(of_some, weights=weight[some]))
        return float(np.mean(scores) + RIDGE * np.sum(slopes**2))

    share = 0.0
    if quantity == SHORT[AREA]:
        slopes = minimize(likelihood, np.r_[0.0, -1.0, np.zeros(len(names))], method="BFGS").x[2:] / spread
    else:
        options = {"maxfev": 300, "xatol": 0.02, "fatol": 0.003}
        start = np.array([-0.1 if name == "lay" else 0.3 for name in names])
        b = minimize(score, np.r_[0.1, start] if by_trend else start, method="Nelder-Mead", options=options).x
        share, slopes = (float(b[0]), b[1:] / spread) if by_trend else (0.0, b / spread)
    return share, pd.Series({"constant": -middle @ slopes} | dict(zip(names, slopes, strict=True)))


def size_of(b: pd.Series, errors: pd.DataFrame) -> np.ndarray:
    """Return the expected size of errors from their features."""
    return np.exp(errors.assign(constant=1.0)[list(b.index)].to_numpy() @ b.to_numpy())


def quantiles(values: np.ndarray, weight: np.ndarray, level: float) -> tuple[float, float]:
    """Return the weighted quantiles that leave (1 - level)/2 out on each side."""
    order = np.argsort(values)
    share = (np.cumsum(weight[order]) - 0.5 * weight[order]) / weight.sum()
    low, high = np.interp([(1 - level) / 2, (1 + level) / 2], share, values[order])
    return float(low), float(high)


def arms_of(errors: pd.DataFrame, share: float, size: np.ndarray, level: float) -> dict[str, list[float]]:
    """Return the arms down and up at the loads of the bank, by their medians of ln erfinv(A)."""
    known: dict[str, list[float]] = {"load": [], "down": [], "up": []}
    ratio = (errors["error"] - share * errors["trend"]).to_numpy() / size
    for load in LOADS:
        some = (errors["load"] == load).to_numpy()
        if not some.any():
            continue
        low, high = quantiles(ratio[some], errors["weight"].to_numpy()[some], level)
        known["load"].append(float(np.median(errors["area"][some])))
        known["down"].append(-low)
        known["up"].append(high)
    return known


def interval_score(low: np.ndarray, high: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Return the score of Winkler (1972) of intervals of `COVERAGE` about errors."""
    return high - low + 2 / (1 - COVERAGE) * (np.maximum(low - error, 0) + np.maximum(error - high, 0))


def ends_by(
    rest: pd.DataFrame, own: pd.DataFrame, sizes: pd.DataFrame, level: float, how: str = "fitted"
) -> pd.DataFrame:
    """Return errors with the ends of their intervals, calibrated on others.

    `sizes` are errors of the surface, to which the size is fitted; `how` is "fitted", "scatter" (the bare
    scatter) or "constant" (two constants, whatever the map).
    """
    share, of_rest, of_own = 0.0, np.ones(len(rest)), np.ones(len(own))
    if how == "fitted":
        share, b = fitted(sizes)
        of_rest, of_own = size_of(b, rest), size_of(b, own)
    elif how == "scatter":
        of_rest, of_own = (np.exp(some["scatter"].to_numpy()) for some in (rest, own))
    ends = np.zeros((len(own), 2))
    for load in LOADS:
        known, here = (rest["load"] == load).to_numpy(), (own["load"] == load).to_numpy()
        if known.any() and here.any():
            ratio = (rest["error"] - share * rest["trend"]).to_numpy()[known] / of_rest[known]
            arms = quantiles(ratio, rest["weight"].to_numpy()[known], level)
            ends[here] = np.outer(of_own[here], arms) + share * own["trend"].to_numpy()[here, None]
    return own.assign(low=np.minimum(ends[:, 0], 0.0), high=np.maximum(ends[:, 1], 0.0))


def left_out(errors: pd.DataFrame, sizes: pd.DataFrame, level: float, how: str = "fitted") -> pd.DataFrame:
    """Return errors with the ends of their intervals, each map calibrated without itself."""
    return pd.concat(
        ends_by(errors[errors["map"] != name], some, sizes[sizes["map"] != name], level, how)
        for name, some in errors.groupby("map", sort=False)
    )


def shares(found: pd.DataFrame) -> dict[str, float]:
    """Return coverage (percent), median half-width and mean score of intervals, maps weighted alike."""
    weight = found["weight"].to_numpy()
    inside = found["error"].between(found["low"] - 1e-12, found["high"] + 1e-12)
    score = interval_score(*(found[c].to_numpy() for c in ("low", "high", "error")))
    return {
        "inside (%)": 100 * np.average(inside, weights=weight),
        "half-width": float((found["high"] - found["low"]).median() / 2),
        "score": np.average(score, weights=weight),
    }


def discretisation_floor(bank: pd.DataFrame, name: str) -> float:
    """Return the least half-width with which 95 % of the extrapolations to no pixels hold.

    The truth is extrapolated from pixels half and a quarter as large.
    """
    quantity = SHORT[name]
    keys = {"narrowest": tuple(NARROWEST.values())}.get(quantity, (quantity,))
    left, widths = [], []
    for key in keys:
        levels = [
            bank[bank["what"] == f"pixel / {factor}"].set_index(["map", "load"])[key] for factor in (1, 2, 4)
        ]
        first, second = levels[1] - levels[0], levels[2] - levels[1]
        truth = levels[2] + second / 3
        correction, width = extrapolated(name, first)
        left.append((truth - levels[0] - correction).abs())
        widths.append(width)
    both = pd.DataFrame({"left": pd.concat(left), "width": pd.concat(widths)}).dropna()
    beyond = np.sqrt(np.maximum(both["left"] ** 2 - both["width"] ** 2, 0.0))
    return float(np.quantile(beyond, COVERAGE))


def calibration(bank: pd.DataFrame) -> dict:
    """Return the content of `calibration.json`."""
    table: dict = {"extent": float(CUTS[0]), "size": {}, "trend": {}, "arms": {}, "octave": {}}
    table["discretisation"] = {}
    for name, quantity in SHORT.items():
        surface = errors_of(bank, quantity, "surface")
        share, b = fitted(surface)
        table["size"][name], table["trend"][name] = b.to_dict(), share
        for measurand in ("surface", "next", "longer", "map"):
            errors = surface if measurand == "surface" else errors_of(bank, quantity, measurand)
            trend = 0.0 if measurand == "map" else share
            arms = arms_of(errors, trend, size_of(b, errors), LEVEL)
            table["arms"].setdefault(measurand, {})[name] = arms
        octave = errors_of(bank, quantity, "octave")
        ratio = octave["error"] / np.hypot(octave["octave"], 1.0)
        low, high = quantiles(ratio.to_numpy(), octave["weight"].to_numpy(), LEVEL)
        table["octave"][name] = {"down": -low, "up": high}
        table["discretisation"][name] = discretisation_floor(bank, name)
    table[MAP_SCATTER] = fitted_scatter(scatter_of_maps(bank)).to_dict()
    return rounded(table)


def scatter_of_maps(bank: pd.DataFrame) -> pd.DataFrame:
    """Return the standard deviation between the parts of each map, of the area at one load, with features.

    That of a few parts is mostly smaller than that of many, by the median of chi, and divided by it.
    """
    rows = bank[(bank["what"] == "3x3") & (bank["load"] == HALVED_LOAD)]
    rows = rows.dropna(subset=["area", "area_scatter", *FEATURES[1:]])
    rows = rows.rename(columns={"area_scatter": "scatter", "area_trend": "trend"})
    of_parts = rows.groupby("map")["area"]
    freedom = of_parts.transform("size") - 1
    rows = rows.assign(deviation=of_parts.transform("std") / median_of_chi(freedom))[freedom > 2]
    of_map = rows.groupby(["kind", "map"])["area"].transform("size")
    share = 1 / rows.groupby("kind")["map"].transform("nunique")
    return rows.assign(weight=share / of_map * rows["kind"].map({"measured": 2.0, "synthetic": 1.0}))


def fitted_scatter(rows: pd.DataFrame) -> pd.Series:
    """Return the slopes of the logarithm of the scatter between maps; measured ones weigh twice."""
    design, root = rows[list(FEATURES)].assign(constant=1.0), np.sqrt(rows["weight"].to_numpy())
    target = np.log(rows["deviation"].to_numpy()) * root
    slopes = np.linalg.lstsq(design.to_numpy() * root[:, None], target, rcond=None)[0]
    return pd.Series(slopes, design.columns)


def halving(bank: pd.DataFrame) -> pd.DataFrame:
    """Return how wide the interval of the mean of n parts of a map is, over what one part had promised.

    Each map is left out of the fit once; its ratio is the median over draws of n of its parts.
    """
    rows, draws, ratios = scatter_of_maps(bank), np.random.default_rng(0), []
    for (kind, name), some in rows.groupby(["kind", "map"]):
        promised = size_of(fitted_scatter(rows[rows["map"] != name]), some)
        area = some["area"].to_numpy()
        count = len(area)
        for maps in (3, 5, 9):
            widths = []
            for _ in range(200 if maps <= count else 0):
                chosen = draws.choice(count, maps, replace=False)
                deviation = area[chosen].std(ddof=1)
                width = float(student(np.array(maps - 1.0))) * deviation / np.sqrt(maps)
                expected = half_width_of_mean(promised[chosen[0]], maps, 0.0)
                widths.append(width / expected)
            if widths:
                ratios.append({"kind": kind, "n": maps, "map": name, "ratio": np.median(widths)})
    groups = pd.DataFrame(ratios).groupby(["kind", "n"])["ratio"]
    return pd.DataFrame(
        [
            {
                "maps": kind,
                "n": maps,
                "surfaces": len(some),
                "width over promise": f"{some.median():.2f}",
                "of nine in ten surfaces": "{:.2f} to {:.2f}".format(*some.quantile([0.05, 0.95])),
            }
            for (kind, maps), some in groups
        ]
    )


def claims(bank: pd.DataFrame) -> pd.DataFrame:
    """Return how many of the answers hold as their words say, each map left out once, by class of words."""
    rows = []
    for quantity in [*SHORT.values()][:4]:
        errors = errors_of(bank, quantity, "surface")
        ends = left_out(errors, errors, LEVEL)
        ends = ends[ends["load"].isin(JUDGED_LOADS)]
        scales = {quantity: 1.0}
        if quantity == SHORT[AREA]:
            scales["pressure in contact"] = -1.0  # the load over the area
        for name, power in scales.items():
            value, truth, low, high = (
                _on_scale(quantity, ends, shift) ** power
                for shift in (0.0, *(ends[key] for key in ("error", "low", "high")))
            )
            for index, cells in enumerate(zip(value, low, high, truth, strict=True)):
                kind, weight = ends["kind"].iloc[index], ends["weight"].iloc[index]
                word, holds = _claim(*cells)
                rows.append({"answer": name, "kind": kind, "class": word, "holds": holds, "weight": weight})
    table = pd.DataFrame(rows)
    shown_rows = []
    for word in CLASSES.values():
        row: dict = {"known": word}
        for kind in ("measured", "synthetic"):
            some = table[(table["class"] == word) & (table["kind"] == kind)]
            row[f"{kind}: answers"] = str(len(some))
            row[f"{kind}: hold (%)"] = f"{100 * np.average(some['holds'], weights=some['weight']):.1f}"
        shown_rows.append(row)
    return pd.DataFrame(shown_rows)


def _on_scale(quantity: str, ends: pd.DataFrame, shift) -> np.ndarray:
    """Return a quantity moved on its scale; all but the area over the result."""
    if quantity == SHORT[AREA]:
        return from_scale(AREA, (ends["area"] + shift).to_numpy())
    return np.exp(np.zeros(len(ends)) + shift)


def _claim(value: float, first: float, second: float, truth: float) -> tuple[str, bool]:
    """Return the class of words of an answer with an interval, and whether the truth is as they say."""
    word, limit = precision(value, min(first, second), max(first, second))
    ratio = max(truth / value, value / truth)
    holds = {
        "percent": abs(truth / value - 1) <= limit / 100,
        "exactly": abs(truth / value - 1) <= 1e-4,
        "factor": ratio <= limit,
        "magnitude": ratio <= limit,
        "at most": truth <= limit,
    }[word]
    return CLASSES["percent" if word == "exactly" else word], bool(holds)


def needed(bank: pd.DataFrame) -> pd.DataFrame:
    """Return the bank without numbers that no error is made of, widths about those of the whole map."""
    bank = bank.copy()
    whole = bank[bank["what"] == "whole"].set_index(["map", "load"])
    for key in ("gap", "peak", "conductance"):
        bank[key] -= whole[key].reindex(pd.MultiIndex.from_frame(bank[["map", "load"]])).to_numpy()
    octaves = [name for name in bank if name.endswith("_octave")]
    bank.loc[bank["what"] != "merged", octaves] = np.nan
    features = [name for name in bank if name.endswith(OF_EACH) or name in FEATURES]
    bank.loc[bank["what"].isin(["whole", "period"]), features] = np.nan
    return bank.round(3)


def write_bank(bank: pd.DataFrame) -> None:
    """Write the bank, a file for each kind of map."""
    BANK.mkdir(parents=True, exist_ok=True)
    for kind, rows in needed(bank).groupby("kind"):
        rows.to_csv(BANK / f"{kind}.csv", index=False, float_format="%.6g")


def read_bank() -> pd.DataFrame:
    """Return the bank as it was written."""
    return pd.concat([pd.read_csv(BANK / f"{kind}.csv") for kind in ("measured", "synthetic")])


def sources(folders: list[Path], bank: pd.DataFrame) -> pd.DataFrame:
    """Return repository and licence of the measured maps of the bank, by the catalogues of the folders."""
    catalogues = [pd.read_csv(path, sep="\t", dtype=str) for f in folders for path in f.glob("CATALOG.tsv")]
    known = pd.concat(catalogues)[["file", "repository", "licence"]].rename(columns={"file": "map"})
    measured = bank.loc[bank["kind"] == "measured", ["map"]].drop_duplicates()
    return measured.merge(known, how="left").fillna("")


def rounded(found):
    """Return nested numbers with four digits."""
    if isinstance(found, dict):
        return {key: rounded(value) for key, value in found.items()}
    if isinstance(found, list):
        return [rounded(value) for value in found]
    return float(f"{found:.4g}") if isinstance(found, float) else found


def coverage(bank: pd.DataFrame, others: pd.DataFrame | None = None) -> pd.DataFrame:
    """Return coverage, width and score of maps left out, or of others, by quantity and measurand."""
    rows = []
    for quantity in SHORT.values():
        surface = errors_of(bank, quantity, "surface")
        for measurand in ("surface", "next"):
            errors = surface if measurand == "surface" else errors_of(bank, quantity, measurand)
            own = None if others is None else errors_of(others, quantity, measurand)
            for how, level in (("fitted", LEVEL), ("constant", COVERAGE)):
                found = (
                    left_out(errors, surface, level, how)
                    if own is None
                    else ends_by(errors, own, surface, level, how)
                )
                found = found[found["load"].isin(JUDGED_LOADS)]
                for kind, some in found.groupby("kind"):
                    by_load = {
                        f"inside at {load} (%)": shares(part)["inside (%)"]
                        for load, part in some.groupby("load")
                    }
                    first = {"quantity": quantity, "measurand": measurand, "arms": how, "maps": kind}
                    rows.append(first | by_load | shares(some))
    return pd.DataFrame(rows)


def shown(found: pd.DataFrame) -> pd.DataFrame:
    """Return the table of a page: coverage at the loads, and scores beside those of two constants."""
    rows = []
    for (quantity, kind), some in found.groupby(["quantity", "maps"], sort=False):
        of = {(row["measurand"], row["arms"]): row for row in some.to_dict("records")}
        row = {"quantity": quantity, "maps": kind}
        for measurand, words in (("surface", "surface"), ("next", "next map")):
            own, constant = of[measurand, "fitted"], of[measurand, "constant"]
            loads = ", ".join(f"{own[f'inside at {load} (%)']:.0f}" for load in JUDGED_LOADS)
            row |= {
                f"{words}: inside at {', '.join(map(str, JUDGED_LOADS))} (%)": loads,
                f"{words}: half-width": f"{own['half-width']:.2f}",
                f"{words}: score (constant)": f"{own['score']:.2f} ({constant['score']:.2f})",
            }
        rows.append(row)
    return pd.DataFrame(rows)


def worth(bank: pd.DataFrame) -> pd.DataFrame:
    """Return what each feature changes of the score of the interval of the surface, maps left out.

    A feature that is used is left out, another one is added; the interval of the change is by a bootstrap of
    the maps.
    """
    rows, solves = [], {"scatter": "9", "trend": "9"}
    for quantity in [*SHORT.values()][:4]:
        errors = errors_of(bank, quantity, "surface")
        chosen = _score_of_maps(errors, quantity)
        for feature in FEATURES if quantity == SHORT[AREA] else (*FEATURES, "trend"):
            used = (SIZED_BY[quantity], MOVED_BY_TREND)
            is_used = feature in SIZED_BY[quantity] or (feature == "trend" and quantity in MOVED_BY_TREND)
            if feature == "trend":
                _use(quantity, used[0], () if is_used else (quantity,))
            else:
                kept = tuple(f for f in FEATURES if (f in used[0]) != (f == feature))
                _use(quantity, kept, used[1])
            toggled = _score_of_maps(errors, quantity)
            _use(quantity, *used)
            row = {"quantity": quantity, "feature": feature, "used": "yes" if is_used else "no"}
            row["parts to solve"] = solves.get(feature, "none")
            for kind in ("measured", "synthetic"):
                pair = (toggled, chosen) if is_used else (chosen, toggled)
                row[f"{kind}: change of the score by it (%)"] = _change(*(scores[kind] for scores in pair))
            rows.append(row)
    return pd.DataFrame(rows)


def shared_with_area(bank: pd.DataFrame) -> pd.DataFrame:
    """Return how much of the errors of gap and conductance goes with that of the area of the same part.

    Half the range of 95 % of the errors stands beside that of what a straight line through those of the area
    leaves.
    """
    area_errors = errors_of(bank, SHORT[AREA], "surface")["error"]  # with the same index by part and load
    rows = []
    for quantity in ("gap", "conductance"):
        errors = errors_of(bank, quantity, "surface").assign(area_error=area_errors)
        errors = errors[errors["load"].isin(JUDGED_LOADS)].dropna(subset="area_error")
        for load, at_load in errors.groupby("load"):
            row = {"quantity": quantity, "p/(E* g)": f"{load:g}"}
            for kind, of_kind in at_load.groupby("kind"):
                correlation = of_kind["error"].corr(of_kind["area_error"])
                residuals = _residuals_over_area(of_kind)
                row[f"{kind}: correlation"] = f"{correlation:+.2f}".replace("-", "−")
                for heading, values in (("half-width", of_kind["error"]), ("given the area", residuals)):
                    ends = quantiles(values.to_numpy(), of_kind["weight"].to_numpy(), COVERAGE)
                    row[f"{kind}: {heading}"] = f"{np.ptp(ends) / 2:.2f}"
            rows.append(row)
    return pd.DataFrame(rows)


def _residuals_over_area(errors: pd.DataFrame) -> pd.Series:
    """Return errors less their line over those of the area, fitted to the other maps."""
    residuals = errors["error"].copy()
    for name, of_map in errors.groupby("map"):
        others = errors[errors["map"] != name]
        line = np.polyfit(others["area_error"], others["error"], 1, w=np.sqrt(others["weight"]))
        residuals[of_map.index] -= np.polyval(line, of_map["area_error"])
    return residuals


def _use(quantity: str, features: tuple[str, ...], by_trend: tuple[str, ...]) -> None:
    """Fit the size of the error of a quantity to some features from now on."""
    global MOVED_BY_TREND
    SIZED_BY[quantity], MOVED_BY_TREND = features, by_trend


def _score_of_maps(errors: pd.DataFrame, quantity: str) -> pd.Series:
    """Return the mean score (kind, map) of the interval of the surface, each map left out once."""
    ends = left_out(errors, errors, LEVEL)
    ends = ends[ends["load"].isin(JUDGED_LOADS)]
    score = interval_score(*(ends[column].to_numpy() for column in ("low", "high", "error")))
    sums = ends.assign(score=score * ends["weight"]).groupby(["kind", "map"])[["score", "weight"]].sum()
    return sums["score"] / sums["weight"]


def _change(without: pd.Series, with_it: pd.Series) -> str:
    """Return the relative change of a mean score in percent, with its 95 % interval."""
    index = np.random.default_rng(0).integers(0, len(without), (2000, len(without)))
    changes = 100 * (with_it.to_numpy()[index].mean(axis=1) / without.to_numpy()[index].mean(axis=1) - 1)
    low, high = np.quantile(changes, [0.025, 0.975])
    return f"{100 * (with_it.mean() / without.mean() - 1):+.0f} ({low:+.0f} to {high:+.0f})".replace("-", "−")


def main() -> None:
    """Make the bank, fit the calibration, print or write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folders", nargs="*", type=Path, help="folders of instrument files")
    parser.add_argument("--fit", action="store_true", help="from the bank as it is")
    parser.add_argument("--held-out", action="store_true", help="hold the calibration against these folders")
    parser.add_argument("--work", type=Path, default=WORK, help="where finished maps are kept")
    parser.add_argument("--write", action="store_true", help="write bank, calibration and tables; else print")
    arguments = parser.parse_args()
    if arguments.held_out:
        others = bank_of(arguments.folders, arguments.work, made=False)
        pages.show({"held out": shown(coverage(read_bank(), others))})
        return
    bank = read_bank() if arguments.fit else bank_of(arguments.folders, arguments.work, made=True)
    if not arguments.write:
        pages.show({"coverage": shown(coverage(bank))})
        return
    if not arguments.fit:
        write_bank(bank)
        sources(arguments.folders, bank).to_csv(BANK / "sources.csv", index=False)
    bank = read_bank()
    tables = {"coverage": shown(coverage(bank)), "features": worth(bank)}
    tables |= {"claims": claims(bank), "halving": halving(bank), "shared": shared_with_area(bank)}
    TABLE.write_text(json.dumps(calibration(bank), indent=1) + "\n")
    pages.publish("bank", tables)


if __name__ == "__main__":
    main()
