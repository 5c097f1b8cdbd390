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

Truths: of *the surface* the mean of the other parts, of *the next map* each of them, of *one octave shorter*
the part itself, its evaluation being that of the part with pixels merged 2 x 2. For *this map* windows of
measured maps and synthetic surfaces are taken for one period of a periodic surface, and measured from another
first point, tilted, with spots missing.

Arms are quantiles of error over expected size, each map with the same weight; the size is fitted to the
logarithm of the errors by least squares. Coverage, width and score (Winkler 1972, J. Am. Stat. Assoc. 67,
187) are those of maps left out one after the other.
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

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.arguments.maps import height_map, refined, spacing
from roughcontact.contact.loads import plan_loads
from roughcontact.errors import RoughContactError
from roughcontact.statistics.precision import precision
from roughcontact.surface.roughness.texture import texture_parameters
from roughcontact.uncertainty import calibration as calibrated
from roughcontact.uncertainty.discretisation import extrapolated
from roughcontact.uncertainty.ensemble import Result, solve_member
from roughcontact.uncertainty.improvement import half_width_of_mean
from roughcontact.uncertainty.random_effects import moderated, random_effects, student
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
from roughcontact.uncertainty.unresolved import remove_shortest_waves, shortest_wave
from validation.masters import KINDS, master_surface

LOADS = (0.005, 0.02, 0.1, 0.4, 1.0)  # of E* times the rms gradient of the whole map
SMALLEST, LARGEST = 192, 540  # points along the sides of a map; larger ones are cut to their middle
CUTS = (3, 2)
MIN_PART = {3: 64, 2: 128}  # points
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
FEATURES = ("scatter", "gradient", "lay")  # the first of each load
# those that the size of the error is fitted to: the others do not lower the score of measured maps left out
SIZED_BY = {**dict.fromkeys(("area", "gap", "conductance"), FEATURES[:2]), "peak": (), "narrowest": ()}
MOVED_BY_TREND = ["peak"]  # whose interval is about the mean of the subwindows
FLOOR = {"area": 0.005, "gap": 0.15, "conductance": 0.07, "peak": 0.15}  # of an error: less is chance
COVERAGE = 0.95
JUDGED_LOADS = LOADS[1:4]
LEVEL = 0.975  # of the arms, so that some 95 % hold on measured maps left out: errors have long tails
SAME = 0.01  # of a logarithm, within which results are those of one map
MAX_ERROR = 6.0  # of a logarithm; more is a closed gap
HALVED_LOAD = 0.1  # at which the promise of more places is judged
GROUPS = (2, 3, 5)  # maps
DRAWS = 20  # of groups of each map and load
# degrees of freedom that the expected scatter of maps counts for: half or twice as many score alike, and the
# more they are of the area, the better a promise comes true
EXPECTED_FREEDOM = {"area": 12.0, **dict.fromkeys(("gap", "peak", "conductance", "narrowest"), 5.0)}
DIVISORS = np.arange(1.5, 4.01, 0.25)
CLASSES = {
    "percent": "to ± 30 % or less",
    "factor": "to a factor of 3 or less",
    "magnitude": "order of magnitude",
    "not": "a bound",
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
        shorter = remove_shortest_waves(window, 2 * shortest_wave(window))
        coarse = solve_member(shorter, contact, tolerance=1e-3, names=NAMES)
    except RoughContactError:
        return None
    results = {"shape": levelled.shape}
    with np.errstate(all="ignore"):
        for name in NAMES:
            key = NARROWEST.get(name) or SHORT[name]
            unit = values[GAP] if name in NARROWEST else 1.0
            results[key] = to_scale(name, values[name]) / unit
            results[f"{key}_octave"] = results[key] - to_scale(name, coarse[name]) / unit
            if name == PEAK:
                features = scatter.features[name] if scatter.features else {}
                features |= {"lay": np.nan_to_num(texture_parameters(window)["Str"], nan=0.5)}
                for column, feature in (("peak_trend", "trend"), *zip(FEATURES, FEATURES, strict=True)):
                    results[column] = features.get(feature, np.nan) + np.zeros(len(loads))
    return results


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

    def add(what: str, number: int, results: dict | None) -> None:
        for index, load in enumerate(LOADS if results else ()):
            numbers = {key: column[index] for key, column in results.items() if key != "shape"}
            rows.append({"map": name, "kind": kind, "what": what, "part": number, "load": load} | numbers)

    add("whole", 0, evaluated(height, loads))
    for cuts in CUTS:
        edges = [np.arange(cuts + 1) * n // cuts for n in height.shape]
        if min(height.shape) // cuts < MIN_PART[cuts]:
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
    cases_made = []
    for number, (kind, longest) in enumerate(itertools.product((*KINDS, *OTHER_KINDS), LONGEST)):
        cases_made.append(
            (f"{kind}, longest {longest:.2g}, seed {number}", partial(make, kind, longest, number))
        )
    return cases_made


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


def bank_of(folders: list[Path], work: Path, *, include_synthetic: bool) -> pd.DataFrame:
    """Return the rows of all maps, those of finished ones from the folder `work`."""
    work.mkdir(parents=True, exist_ok=True)
    files = sorted({path for folder in folders for path in folder.iterdir() if path.is_file()})
    jobs = [(path.name, of_file, path) for path in files]
    jobs += [(case[0], of_synthetic, case) for case in synthetic()] if include_synthetic else []
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
    distinct: list[tuple[np.ndarray, pd.DataFrame]] = []
    for table in tables:
        numbers = table.loc[table["what"] == "whole", [*SHORT.values()][:4]].to_numpy()
        if not any(
            np.allclose(numbers, known_numbers, rtol=0, atol=SAME, equal_nan=True)
            for known_numbers, _ in distinct
        ):
            distinct.append((numbers, table))
    return pd.concat([table for _, table in distinct], ignore_index=True)


def errors_of(bank: pd.DataFrame, quantity: str, measurand: str) -> pd.DataFrame:
    """Return the errors of a quantity about the truths of a measurand, with their features, one row each."""
    keys = {"narrowest": tuple(NARROWEST.values())}.get(quantity, (quantity,))
    rows, is_moved = [], quantity in MOVED_BY_TREND and measurand in ("surface", "next")
    for (name, kind), of_map in bank.groupby(["map", "kind"], sort=False):
        for key in keys:
            for what in {"map": ("measured period",), "octave": ("merged",)}.get(measurand, ("3x3", "2x2")):
                for load, parts in of_map[of_map["what"] == what].groupby("load"):
                    truths = _truths(of_map, parts, key, load, measurand)
                    for row, truth in zip(parts.itertuples(), truths, strict=True):
                        base = {"map": name, "kind": kind, "load": load, "area": row.area}
                        base |= {"what": what, "key": key, "value": getattr(row, key)}
                        base |= {f: getattr(row, f) for f in FEATURES} | {"quantity": quantity}
                        base["trend"] = getattr(row, f"{key}_trend", 0.0) if is_moved else 0.0
                        if measurand == "octave":
                            base["octave"] = getattr(row, f"{key}_octave")
                        rows += [base | {"error": value - getattr(row, key)} for value in truth]
    used = {"error", "area", "trend", *SIZED_BY[quantity]}
    if measurand == "octave":  # in full contact there is no change to scale the error by
        used.add("octave")
    errors = pd.DataFrame(rows).dropna(subset=[*used])
    errors["error"] = errors["error"].clip(-MAX_ERROR, MAX_ERROR)
    count = errors.groupby(["map", "load"])["error"].transform("size")
    errors["weight"] = 1 / count
    return errors


def _truths(
    of_map: pd.DataFrame, parts: pd.DataFrame, key: str, load: float, measurand: str
) -> list[list[float]]:
    """Return for each row of some parts the truths that it is held against, on the scale."""
    values = parts[key].to_numpy()
    if measurand in ("surface", "next"):
        remaining_values = [np.delete(values, index) for index in range(values.size)]
        return [list(o) if measurand == "next" else [o.mean()] for o in remaining_values]
    what = {"map": "period", "octave": "3x3"}[measurand]
    truth = of_map[(of_map["what"] == what) & (of_map["load"] == load)]
    if measurand == "octave":
        return [list(truth.loc[truth["part"] == part, key]) for part in parts["part"]]
    return [list(truth[key])] * values.size


def fitted(errors: pd.DataFrame) -> pd.Series:
    """Return b of the expected size s = exp(sum b f) of some errors, by feature f.

    The features are those of `SIZED_BY`, and a constant 1: least squares of ln(|error| + floor), each map
    with the same weight. Without features the size is 1.
    """
    quantity = errors["quantity"].iloc[0]
    if not SIZED_BY[quantity]:
        return pd.Series({"constant": 0.0})
    errors = errors[errors["load"].isin(JUDGED_LOADS)]
    design = errors[list(SIZED_BY[quantity])].assign(constant=1.0)
    target = np.log((errors["error"] - errors["trend"]).abs().to_numpy() + FLOOR[quantity])
    root = np.sqrt(errors["weight"].to_numpy())
    slopes = np.linalg.lstsq(design.to_numpy() * root[:, None], target * root, rcond=None)[0]
    return pd.Series(slopes, design.columns)


def size_of(b: pd.Series, errors: pd.DataFrame) -> np.ndarray:
    """Return the expected size of errors from their features."""
    return np.exp(errors.assign(constant=1.0)[list(b.index)].to_numpy() @ b.to_numpy())


def quantiles(values: np.ndarray, weight: np.ndarray, level: float) -> tuple[float, float]:
    """Return the weighted quantiles that leave (1 - level)/2 out on each side."""
    order = np.argsort(values)
    share = (np.cumsum(weight[order]) - 0.5 * weight[order]) / weight.sum()
    low, high = np.interp([(1 - level) / 2, (1 + level) / 2], share, values[order])
    return float(low), float(high)


def arms_of(errors: pd.DataFrame, size: np.ndarray) -> dict[str, list[float]]:
    """Return the arms down and up at the loads of the bank, by their medians of ln erfinv(A)."""
    arms: dict[str, list[float]] = {"load": [], "down": [], "up": []}
    ratio = (errors["error"] - errors["trend"]).to_numpy() / size
    for load in LOADS:
        at_load = (errors["load"] == load).to_numpy()
        if not at_load.any():
            continue
        low, high = quantiles(ratio[at_load], errors["weight"].to_numpy()[at_load], LEVEL)
        arms["load"].append(float(np.median(errors["area"][at_load])))
        arms["down"].append(-low)
        arms["up"].append(high)
    return arms


def interval_score(low: np.ndarray, high: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Return the score of Winkler (1972) of intervals of `COVERAGE` about errors."""
    return high - low + 2 / (1 - COVERAGE) * (np.maximum(low - error, 0) + np.maximum(error - high, 0))


def ends_by(
    training: pd.DataFrame, judged: pd.DataFrame, sizes: pd.DataFrame, *, constant: bool = False
) -> pd.DataFrame:
    """Return errors with the ends of their intervals, calibrated on others.

    `sizes` are errors of the surface, to which the size is fitted; `constant` arms are those of a size of 1.
    """
    b = pd.Series({"constant": 0.0}) if constant else fitted(sizes)
    size, bounds = size_of(b, training), np.zeros((len(judged), 2))
    for load in LOADS:
        at_load, is_judged = ((frame["load"] == load).to_numpy() for frame in (training, judged))
        if at_load.any() and is_judged.any():
            ratio = (training["error"] - training["trend"]).to_numpy()[at_load] / size[at_load]
            arms = quantiles(ratio, training["weight"].to_numpy()[at_load], LEVEL)
            rows = judged[is_judged]
            bounds[is_judged] = np.outer(size_of(b, rows), arms) + rows["trend"].to_numpy()[:, None]
    return judged.assign(low=np.minimum(bounds[:, 0], 0.0), high=np.maximum(bounds[:, 1], 0.0))


def left_out(errors: pd.DataFrame, sizes: pd.DataFrame, *, constant: bool = False) -> pd.DataFrame:
    """Return errors with the ends of their intervals, each map calibrated without itself."""
    return pd.concat(
        ends_by(errors[errors["map"] != name], own, sizes[sizes["map"] != name], constant=constant)
        for name, own in errors.groupby("map", sort=False)
    )


def shares(frame: pd.DataFrame) -> dict[str, float]:
    """Return coverage (percent), median half-width and mean score of intervals, maps weighted alike."""
    weight = frame["weight"].to_numpy()
    inside = frame["error"].between(frame["low"] - 1e-12, frame["high"] + 1e-12)
    score = interval_score(*(frame[c].to_numpy() for c in ("low", "high", "error")))
    return {
        "inside (%)": 100 * np.average(inside, weights=weight),
        "half-width": float((frame["high"] - frame["low"]).median() / 2),
        "score": np.average(score, weights=weight),
    }


def discretisation_floor(bank: pd.DataFrame, name: str) -> float:
    """Return the least half-width with which 95 % of the extrapolations to no pixels hold.

    The truth is extrapolated from pixels half and a quarter as large.
    """
    quantity = SHORT[name]
    keys = {"narrowest": tuple(NARROWEST.values())}.get(quantity, (quantity,))
    remaining_errors, widths = [], []
    for key in keys:
        levels = [
            bank[bank["what"] == f"pixel / {factor}"].set_index(["map", "load"])[key] for factor in (1, 2, 4)
        ]
        difference, finer_difference = levels[1] - levels[0], levels[2] - levels[1]
        truth = levels[2] + finer_difference / 3
        correction, width = extrapolated(name, difference)
        remaining_errors.append((truth - levels[0] - correction).abs())
        widths.append(width)
    frame = pd.DataFrame({"left": pd.concat(remaining_errors), "width": pd.concat(widths)}).dropna()
    excess = np.sqrt(np.maximum(frame["left"] ** 2 - frame["width"] ** 2, 0.0))
    return float(np.quantile(excess, COVERAGE))


def calibration(bank: pd.DataFrame) -> dict:
    """Return the content of `calibration.json`."""
    table: dict = {"size": {}, "arms": {}, "octave": {}, "discretisation": {}}
    for name, quantity in SHORT.items():
        surface = errors_of(bank, quantity, "surface")
        b = fitted(surface)
        table["size"][name] = b.to_dict()
        for measurand in ("surface", "next", "map"):
            errors = surface if measurand == "surface" else errors_of(bank, quantity, measurand)
            table["arms"].setdefault(measurand, {})[name] = arms_of(errors, size_of(b, errors))
        octave = errors_of(bank, quantity, "octave")
        ratio = octave["error"] / np.hypot(octave["octave"], 1.0)
        low, high = quantiles(ratio.to_numpy(), octave["weight"].to_numpy(), LEVEL)
        table["octave"][name] = {"down": -low, "up": high}
        table["discretisation"][name] = discretisation_floor(bank, name)
    groups = {name: groups_of_parts(bank, quantity) for name, quantity in SHORT.items()}
    divisors = {name: float(scores_of_divisors(of_name).mean().idxmin()) for name, of_name in groups.items()}
    freedom = {name: EXPECTED_FREEDOM[quantity] for name, quantity in SHORT.items()}
    table["groups"] = {"freedom": freedom, "half_width": divisors, "other_places": other_places(groups[AREA])}
    return rounded(table)


def groups_of_parts(bank: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """Return groups of parts of each map, drawn at random: the error of their mean, and what is known of it.

    The half-width is the mean of those of the parts, by the other maps. Errors against the mean of all other
    parts are reduced to those against that of ever so many.
    """
    errors = errors_of(bank, quantity, "surface")
    intervals = left_out(errors, errors)
    intervals = intervals[(intervals["what"] == "3x3") & intervals["load"].isin(JUDGED_LOADS)]
    intervals = intervals.assign(half_width=(intervals["high"] - intervals["low"]) / 2)
    draws, rows = np.random.default_rng(0), []
    for (kind, name, load, _), parts in intervals.groupby(["kind", "map", "load", "key"], sort=False):
        values, widths = parts["value"].to_numpy(), parts["half_width"].to_numpy()
        for maps, _ in itertools.product(GROUPS if len(parts) > max(GROUPS) + 1 else (), range(DRAWS)):
            order = draws.permutation(len(parts))
            chosen, others = values[order[:maps]], values[order[maps:]]
            error = (others.mean() - chosen.mean()) / np.sqrt(1 + maps / others.size)
            row = {"kind": kind, "map": name, "load": load, "maps": maps, "error": error}
            row |= {
                "freedom": EXPECTED_FREEDOM[quantity],
                "deviation": chosen.std(ddof=1),
                "half_width": widths[order[:maps]].mean(),
            }
            rows.append(row | {"first": widths[order[0]], "range": np.ptp(chosen) / 2})
    return pd.DataFrame(rows)


def width_of_groups(groups: pd.DataFrame, divisor: float | None) -> np.ndarray:
    """Return the half-widths of the means of groups, by half-width over expected scatter, if any."""
    effects = random_effects(np.zeros((2, len(groups))), "ab")._replace(
        units=groups["maps"].to_numpy(),
        error=(groups["deviation"] / np.sqrt(groups["maps"])).to_numpy(),
        freedom=groups["maps"].to_numpy() - 1.0,
    )
    if divisor:
        scatter, freedom = groups["half_width"] / divisor, groups["freedom"]
        effects = moderated(effects, scatter.to_numpy(), freedom.to_numpy())
    return student(effects.freedom) * effects.error


def scores_of_divisors(groups: pd.DataFrame) -> pd.DataFrame:
    """Return the mean score of the groups of each measured map, by half-width over expected scatter."""
    groups = groups[groups["kind"] == "measured"]
    scores = {divisor: _score_of_groups(groups, width_of_groups(groups, divisor)) for divisor in DIVISORS}
    return pd.DataFrame(scores).groupby(groups["map"]).mean()


def _score_of_groups(groups: pd.DataFrame, width: np.ndarray) -> pd.Series:
    """Return the scores of intervals of some half-width about the means of groups."""
    return pd.Series(interval_score(-width, width, groups["error"].to_numpy()), groups.index)


def of_groups(bank: pd.DataFrame) -> pd.DataFrame:
    """Return coverage and score of the mean of n parts of a map, each map left out, and without the bank."""
    rows = []
    for quantity in SHORT.values():
        groups = groups_of_parts(bank, quantity)
        scores, width = scores_of_divisors(groups), np.empty(len(groups))
        for name, index in groups.groupby("map").indices.items():
            divisor = scores.drop(index=name, errors="ignore").mean().idxmin()
            width[index] = width_of_groups(groups.iloc[index], divisor)
        plain = np.where(groups["maps"] == GROUPS[0], groups["range"], width_of_groups(groups, None))
        groups = groups.assign(width=width, plain=plain)
        for (kind, maps), group in groups.groupby(["kind", "maps"]):
            row = {"quantity": quantity, "maps": kind, "n": maps}
            for words, key in (("", "width"), ("range or Student: ", "plain")):
                half = group[key].to_numpy()
                inside = 100 * np.mean(group["error"].abs() <= half + 1e-12)
                score = _score_of_groups(group, half).mean()
                row |= {f"{words}inside (%)": f"{inside:.1f}", f"{words}half-width": f"{np.median(half):.2f}"}
                row[f"{words}score"] = f"{score:.2f}"
            rows.append(row)
    return pd.DataFrame(rows)


def other_places(groups: pd.DataFrame) -> list[float]:
    """Return constant and power of the half-width at other places over that at one, each map alike.

    A place that is known badly lies among better ones, and one known well among worse.
    """
    largest = groups[(groups["maps"] == GROUPS[-1]) & (groups["load"] == HALVED_LOAD)]
    others = (largest["maps"] * largest["half_width"] - largest["first"]) / (largest["maps"] - 1)
    power, constant = np.polyfit(np.log(largest["first"]), np.log(others), 1)
    return [float(constant), float(power)]


def halving(bank: pd.DataFrame) -> pd.DataFrame:
    """Return how wide the interval of the mean area of n parts of a map is, over what one of them promised.

    Half-widths of single maps, and those at other places, are by the other maps.
    """
    groups = groups_of_parts(bank, SHORT[AREA])
    groups, promised = groups[groups["load"] == HALVED_LOAD], pd.Series(dtype=float)
    for name, own in groups.groupby("map"):
        constant, power = other_places(groups[groups["map"] != name])
        elsewhere = np.exp(constant) * own["first"] ** power
        of_map = [
            half_width_of_mean(pair, maps, 0.0)
            for *pair, maps in zip(own["first"], elsewhere, own["maps"], strict=True)
        ]
        promised = pd.concat([promised, pd.Series(of_map, own.index)])
    divisor = calibrated.table()["groups"]["half_width"][AREA]
    groups = groups.assign(ratio=width_of_groups(groups, divisor) / promised[groups.index])
    return pd.DataFrame(
        {
            "maps": kind,
            "n": maps,
            "surfaces": part["map"].nunique(),
            "width over promise": f"{part['ratio'].median():.2f}",
            "of nine in ten groups": "{:.2f} to {:.2f}".format(*part["ratio"].quantile([0.05, 0.95])),
            "off by a factor, median": f"{factor_off(part['ratio']).median():.2f}",
            "nine in ten": f"{factor_off(part['ratio']).quantile(0.9):.2f}",
        }
        for (kind, maps), part in groups.groupby(["kind", "maps"])
    )


def factor_off(ratio: pd.Series) -> pd.Series:
    """Return by which factor numbers differ from 1."""
    return np.exp(np.log(ratio).abs())


def claims(bank: pd.DataFrame) -> pd.DataFrame:
    """Return how many of the answers hold as their words say, each map left out once, by class of words."""
    rows = []
    for quantity in [*SHORT.values()][:4]:
        errors = errors_of(bank, quantity, "surface")
        intervals = left_out(errors, errors)
        intervals = intervals[intervals["load"].isin(JUDGED_LOADS)]
        scales = {quantity: 1.0}
        if quantity == SHORT[AREA]:
            scales["pressure in contact"] = -1.0  # the load over the area
        for name, power in scales.items():
            value, truth, low, high = (
                _on_scale(quantity, intervals, shift) ** power
                for shift in (0.0, *(intervals[key] for key in ("error", "low", "high")))
            )
            for index, cells in enumerate(zip(value, low, high, truth, strict=True)):
                kind, weight = intervals["kind"].iloc[index], intervals["weight"].iloc[index]
                word, holds = _claim(*cells)
                rows.append({"answer": name, "kind": kind, "class": word, "holds": holds, "weight": weight})
    table = pd.DataFrame(rows)
    shown_rows = []
    for word in CLASSES.values():
        row: dict = {"known": word}
        for kind in ("measured", "synthetic"):
            answers = table[(table["class"] == word) & (table["kind"] == kind)]
            row[f"{kind}: answers"] = str(len(answers))
            row[f"{kind}: hold (%)"] = f"{100 * np.average(answers['holds'], weights=answers['weight']):.1f}"
        shown_rows.append(row)
    return pd.DataFrame(shown_rows)


def _on_scale(quantity: str, intervals: pd.DataFrame, shift) -> np.ndarray:
    """Return a quantity moved on its scale; all but the area over the result."""
    if quantity == SHORT[AREA]:
        return from_scale(AREA, (intervals["area"] + shift).to_numpy())
    return np.exp(np.zeros(len(intervals)) + shift)


def _claim(value: float, a: float, b: float, truth: float) -> tuple[str, bool]:
    """Return the class of words of an answer with an interval, and whether the truth is as they say."""
    word, limit = precision(value, min(a, b), max(a, b))
    ratio = max(truth / value, value / truth)
    holds = {
        "percent": abs(truth / value - 1) <= limit / 100,
        "exactly": abs(truth / value - 1) <= 1e-4,
        "factor": ratio <= limit,
        "magnitude": ratio <= limit,
        "not": truth <= max(a, b),
    }[word]
    return CLASSES["percent" if word == "exactly" else word], bool(holds)


def needed(bank: pd.DataFrame) -> pd.DataFrame:
    """Return the bank without numbers that no error is made of, widths about those of the whole map."""
    bank = bank.copy()
    reference = bank[bank["what"] == "whole"].set_index(["map", "load"])
    for key in ("gap", "peak", "conductance"):
        bank[key] -= reference[key].reindex(pd.MultiIndex.from_frame(bank[["map", "load"]])).to_numpy()
    octaves = [name for name in bank if name.endswith("_octave")]
    bank.loc[bank["what"] != "merged", octaves] = np.nan
    features = [name for name in bank if name.endswith("trend") or name in FEATURES]
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
    licences = pd.concat(catalogues)[["file", "repository", "licence"]].rename(columns={"file": "map"})
    measured = bank.loc[bank["kind"] == "measured", ["map"]].drop_duplicates()
    return measured.merge(licences, how="left").fillna("")


def rounded(value):
    """Return nested numbers with four digits."""
    if isinstance(value, dict):
        return {key: rounded(value) for key, value in value.items()}
    if isinstance(value, list):
        return [rounded(value) for value in value]
    return float(f"{value:.4g}") if isinstance(value, float) else value


def coverage(bank: pd.DataFrame, further_bank: pd.DataFrame | None = None) -> pd.DataFrame:
    """Return coverage, width and score of maps left out, or of others, by quantity and measurand."""
    rows = []
    for quantity in SHORT.values():
        surface = errors_of(bank, quantity, "surface")
        for measurand in ("surface", "next"):
            errors = surface if measurand == "surface" else errors_of(bank, quantity, measurand)
            errors_judged = None if further_bank is None else errors_of(further_bank, quantity, measurand)
            for how in ("fitted", "constant"):
                intervals = (
                    left_out(errors, surface, constant=how == "constant")
                    if errors_judged is None
                    else ends_by(errors, errors_judged, surface, constant=how == "constant")
                )
                intervals = intervals[intervals["load"].isin(JUDGED_LOADS)]
                for kind, intervals_of_kind in intervals.groupby("kind"):
                    by_load = {
                        f"inside at {load} (%)": shares(part)["inside (%)"]
                        for load, part in intervals_of_kind.groupby("load")
                    }
                    labels = {"quantity": quantity, "measurand": measurand, "arms": how, "maps": kind}
                    rows.append(labels | by_load | shares(intervals_of_kind))
    return pd.DataFrame(rows)


def shown(coverages: pd.DataFrame) -> pd.DataFrame:
    """Return the table of a page: coverage at the loads, and scores beside those of two constants."""
    rows = []
    for (quantity, kind), rows_of_kind in coverages.groupby(["quantity", "maps"], sort=False):
        row_by_kind = {(row["measurand"], row["arms"]): row for row in rows_of_kind.to_dict("records")}
        row = {"quantity": quantity, "maps": kind}
        for measurand, words in (("surface", "surface"), ("next", "next map")):
            calibrated, constant = row_by_kind[measurand, "fitted"], row_by_kind[measurand, "constant"]
            loads = ", ".join(f"{calibrated[f'inside at {load} (%)']:.0f}" for load in JUDGED_LOADS)
            row |= {
                f"{words}: inside at {', '.join(map(str, JUDGED_LOADS))} (%)": loads,
                f"{words}: half-width": f"{calibrated['half-width']:.2f}",
                f"{words}: score (constant)": f"{calibrated['score']:.2f} ({constant['score']:.2f})",
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
        errors = errors_of(bank, quantity, "surface").dropna(subset=[*FEATURES])
        for feature in (*FEATURES, *(["trend"] if quantity in MOVED_BY_TREND else [])):
            chosen, is_trend = SIZED_BY[quantity], feature == "trend"
            is_used = is_trend or feature in chosen
            toggled = tuple(f for f in FEATURES if (f in chosen) != (f == feature))
            scores = []
            for features in (chosen, chosen if is_trend else toggled):
                SIZED_BY[quantity] = features
                scores.append(_score_of_maps(errors.assign(trend=0.0) if is_trend and scores else errors))
            SIZED_BY[quantity] = chosen
            row = {"quantity": quantity, "feature": feature, "used": "yes" if is_used else "no"}
            row["parts to solve"] = solves.get(feature, "none")
            for kind in ("measured", "synthetic"):
                row[f"{kind}: change of the score by it (%)"] = _change(
                    *(score[kind] for score in (scores[::-1] if is_used else scores))
                )
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
                    bounds = quantiles(values.to_numpy(), of_kind["weight"].to_numpy(), COVERAGE)
                    row[f"{kind}: {heading}"] = f"{np.ptp(bounds) / 2:.2f}"
            rows.append(row)
    return pd.DataFrame(rows)


def _residuals_over_area(errors: pd.DataFrame) -> pd.Series:
    """Return errors less their line over those of the area, fitted to the other maps."""
    residuals = errors["error"].copy()
    for name, of_map in errors.groupby("map"):
        errors_of_others = errors[errors["map"] != name]
        line = np.polyfit(
            errors_of_others["area_error"],
            errors_of_others["error"],
            1,
            w=np.sqrt(errors_of_others["weight"]),
        )
        residuals[of_map.index] -= np.polyval(line, of_map["area_error"])
    return residuals


def _score_of_maps(errors: pd.DataFrame) -> pd.Series:
    """Return the mean score (kind, map) of the interval of the surface, each map left out once."""
    intervals = left_out(errors, errors)
    intervals = intervals[intervals["load"].isin(JUDGED_LOADS)]
    score = interval_score(*(intervals[column].to_numpy() for column in ("low", "high", "error")))
    sums = (
        intervals.assign(score=score * intervals["weight"])
        .groupby(["kind", "map"])[["score", "weight"]]
        .sum()
    )
    return sums["score"] / sums["weight"]


def _change(score_without: pd.Series, with_it: pd.Series) -> str:
    """Return the relative change of a mean score in percent, with its 95 % interval."""
    index = np.random.default_rng(0).integers(0, len(score_without), (2000, len(score_without)))
    changes = 100 * (
        with_it.to_numpy()[index].mean(axis=1) / score_without.to_numpy()[index].mean(axis=1) - 1
    )
    low, high = np.quantile(changes, [0.025, 0.975])
    return f"{100 * (with_it.mean() / score_without.mean() - 1):+.0f} ({low:+.0f} to {high:+.0f})".replace(
        "-", "−"
    )


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
        further_bank = bank_of(arguments.folders, arguments.work, include_synthetic=False)
        pages.show({"held out": shown(coverage(read_bank(), further_bank))})
        return
    bank = (
        read_bank() if arguments.fit else bank_of(arguments.folders, arguments.work, include_synthetic=True)
    )
    if not arguments.write:
        pages.show({"coverage": shown(coverage(bank))})
        return
    if not arguments.fit:
        write_bank(bank)
        sources(arguments.folders, bank).to_csv(BANK / "sources.csv", index=False)
    bank = read_bank()
    # two_magnifications.py writes entries of its own
    content = json.loads(TABLE.read_text()) | calibration(bank)
    TABLE.write_text(json.dumps(content, indent=1) + "\n")
    tables = {"coverage": shown(coverage(bank)), "features": worth(bank), "groups": of_groups(bank)}
    tables |= {"claims": claims(bank), "halving": halving(bank), "shared": shared_with_area(bank)}
    pages.publish("bank", tables)


if __name__ == "__main__":
    main()
