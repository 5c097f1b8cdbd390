"""Calibrate the ± of a map with an overview, a second and coarser map of a larger field around it.

    python benchmarks/two_magnifications.py FOLDER ... --write    # the bank, the calibration, the tables
    python benchmarks/two_magnifications.py --fit --write    # calibration and tables from the bank

The middle of every map of `calibrate.py`'s kind is cut into 3 x 3 parts, each solved as if it were the fine
map. The overview is the whole of it with pixels merged 2 x 2, 4 x 4 or 8 x 8, seen through another lens
(Gaussian of 0.6 of its pixels) with white noise of 1 % of Sq. Mean pressures are p/(E* g), g the rms
gradient of the whole map; the windows of an overview are solved at seven loads, between which results are
interpolated on their scales.

Truths: of *the surface* the mean of the other parts; of *the joint* the whole fine map. An overview of
another position is of the two rows of parts in which the fine map is not, which are then the surface. Every
number is of maps left out one after the other.
"""

import argparse
import itertools
import json
import sys
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pages
import pandas as pd
import scipy

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import calibrate

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.contact.loads import plan_loads
from roughcontact.errors import RoughContactError
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.uncertainty import calibration as calibrated
from roughcontact.uncertainty import overview
from roughcontact.uncertainty.calibration import JOINT
from roughcontact.uncertainty.ensemble import measured_slices, solve_member
from roughcontact.uncertainty.scales import AREA, CONDUCTANCE, GAP, PEAK, from_scale, to_scale
from roughcontact.uncertainty.subwindows import gradient_scatter

JUDGED = (0.02, 0.1, 0.4)  # of E* times the rms gradient of the whole map
LOADS = (0.005, 0.02, 0.05, 0.1, 0.2, 0.4, 1.0)  # of the windows of an overview
FACTORS = (2, 4, 8)  # pixels of the overview over those of the fine map
LENS, NOISE = 0.6, 0.01  # sigma in pixels of the overview; of Sq
LEAST_WINDOW = 16  # points along the sides of a window of an overview
NAMES = (AREA, GAP, PEAK, CONDUCTANCE)
WHOLE = -1  # the number of the whole map among its parts
LEVELS = {
    "surface": 0.95,
    "next": 0.95,
    JOINT: 0.975,
}  # of the arms; of joints the bank has one for nine parts
LEVEL_ELSEWHERE = 0.97  # whose errors differ more from map to map
LEVEL_OF_FEW = 0.96  # with the coarsest pixels, of 15 maps: with 0.95 too few conductances lie inside
LIMIT_LEVEL = 0.995  # of the limits of the gap, with which no coverage is lost
LARGEST_CHANGE = 3.0  # of a logarithm, in the fit of the coefficients
RIDGE = 3.0  # beside the weight of a map at a load: 0.5 to 4 score alike
WORK = Path(__file__).parent / "work" / "two_magnifications"
RESULTS = Path(__file__).parent / "results" / "overview"
BANK = [RESULTS / f"{name}.csv" for name in ("fine", "overviews", "elsewhere")]


def evaluated(height, loads: np.ndarray) -> dict | None:
    """Return results (load) on their scales, rms gradient, its scatter and Sq of a map, E* being 1."""
    try:
        levelled = rc.level(height)
        window = rc.periodic_window(levelled)
        values = solve_member(window, {"contact_modulus": 1.0, "mean_pressure": loads}, names=NAMES)
    except RoughContactError:
        return None
    with np.errstate(all="ignore"):
        results = {name: to_scale(name, values[name]).tolist() for name in NAMES}
    results |= {"gradient": float(rms_gradient(window)), "Sq": float(window.values.std())}
    return results | {"scatter": gradient_scatter(levelled.isel(measured_slices(levelled, window)))}


def merged(height, factor: int):
    """Return a map with its pixels merged, of those that are not all measured the mean of the others."""
    ny, nx = (n // factor * factor for n in height.shape)
    dy, dx = spacing(height)
    blocks = height.values[:ny, :nx].reshape(ny // factor, factor, nx // factor, factor)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of blocks without a point
        return height_map(np.nanmean(blocks, axis=(1, 3)), (factor * dy, factor * dx))


def overview_of(height, factor: int, generator):
    """Return the map as a coarser instrument has it: another lens, larger pixels, noise."""
    missing = np.isnan(height.values)
    filled = np.where(missing, np.nanmean(height.values), height.values)
    blurred = scipy.ndimage.gaussian_filter(filled, LENS * factor, mode="nearest")
    coarse = merged(height.copy(data=np.where(missing, np.nan, blurred)), factor)
    sq = float(np.nanstd(rc.level(height).values))
    return coarse + generator.normal(0, NOISE * sq, coarse.shape)


def places(height) -> Iterator:
    """Yield the 3 x 3 parts of a map."""
    edges = [np.arange(4) * (n // 3) for n in height.shape]
    for i, j in itertools.product(range(3), repeat=2):
        yield height[edges[0][i] : edges[0][i + 1], edges[1][j] : edges[1][j + 1]]


def record_of(name: str, kind: str, height) -> dict | None:
    """Return what is kept of one map: fine parts, the whole, and the windows of its overviews."""
    start = [max(0, (n - calibrate.LARGEST) // 2) for n in height.shape]
    height = height[start[0] : start[0] + calibrate.LARGEST, start[1] : start[1] + calibrate.LARGEST]
    ny, nx = (n // 24 * 24 for n in height.shape)
    height = height[:ny, :nx]
    try:
        window = rc.periodic_window(rc.level(height))
    except RoughContactError:
        return None
    options = {"contact_modulus": 1.0, "relative_pressure": list(LOADS)}
    loads = np.array(plan_loads(window, **options), float)
    judged = loads[[LOADS.index(load) for load in JUDGED]]
    record = {"map": name, "kind": kind, "shape": height.shape, "gradient": float(rms_gradient(window))}
    record["whole"] = evaluated(height, judged)
    record["parts"] = [evaluated(part, judged) for part in places(height)]
    record["overviews"] = {}
    generator = np.random.default_rng(1)
    for factor in FACTORS:
        if min(height.shape) // 3 // factor < LEAST_WINDOW:
            continue
        coarse = overview_of(height, factor, generator)
        record["overviews"][factor] = {
            "whole": evaluated(coarse, loads),
            "places": [evaluated(place, loads) for place in places(coarse)],
            "octave": [evaluated(merged(place, 2), loads) for place in places(coarse)],
            "own": [evaluated(merged(part, factor), loads) for part in places(height)],
        }
    return record


def maps(folders: list[Path], *, made: bool) -> Iterator[tuple[str, str, object]]:
    """Yield name, kind, and a function that returns each map."""
    for path in sorted({path for folder in folders for path in folder.iterdir() if path.is_file()}):
        yield path.name, "measured", lambda path=path: rc.read_height_map(path).astype(float)
    if made:  # the longest waves are the most demanding ones
        yield from ((name, "synthetic", make) for name, make in calibrate.synthetic()[2::3])


def bank(folders: list[Path]) -> list[dict]:
    """Return the records of all maps; those that are there are not measured again."""
    WORK.mkdir(parents=True, exist_ok=True)
    for name, kind, read in maps(folders, made=bool(folders)):
        if (path := WORK / f"{name}.json").exists():
            continue
        began = time.process_time()
        try:
            height = read()
        except RoughContactError:
            continue
        if min(height.shape) < calibrate.SMALLEST:
            continue
        record = record_of(name, kind, height)
        path.write_text(json.dumps(record))
        print(name, height.shape, f"{time.process_time() - began:.0f} s", flush=True)
    return [json.loads(path.read_text()) for path in sorted(WORK.glob("*.json"))]


def on_curve(curve: list, logarithm: float) -> float:
    """Return a result of `LOADS` (None: closed) at ln of a load, straight beyond the solved ones."""
    values = np.array(curve, float)
    finite = np.isfinite(values)
    if finite.sum() < 2:
        return np.nan
    x, y = np.log(LOADS)[finite], values[finite]
    ends = ((0, 1) if logarithm < x[0] else (-1, -2)) if not x[0] <= logarithm <= x[-1] else ()
    if ends:
        a, b = ends
        return float(y[a] + (logarithm - x[a]) * (y[a] - y[b]) / (x[a] - x[b]))
    return float(np.interp(logarithm, x, y))


def rows_of(record: dict) -> tuple[list[dict], list[dict], list[dict]]:
    """Return the rows of the bank of one map: its parts, and what overviews around and elsewhere show."""
    parts, map_record = record["parts"], record["whole"]
    if map_record is None or None in parts:
        return [], [], []
    first = {"map": record["map"], "kind": record["kind"]}
    fine = [
        first
        | {"part": number, "load": load, "gradient": part["gradient"], "Sq": part["Sq"]}
        | {"scatter": part["scatter"]}
        | {name: part[name][index] for name in NAMES}
        for number, part in [*enumerate(parts), (WHOLE, map_record)]
        for index, load in enumerate(JUDGED)
    ]
    overviews = []
    for factor, overview_record in record["overviews"].items():
        if overview_record["whole"] is None or None in (
            *overview_record["places"],
            *overview_record["octave"],
        ):
            continue
        for (number, part), load in itertools.product(enumerate(parts), JUDGED):
            row = first | {"part": number, "factor": int(factor), "load": load}
            ratios = [
                overview_record[key][number]["gradient"] / part["gradient"] for key in ("places", "octave")
            ]
            for name in NAMES:
                here, coarser = (
                    np.array([on_curve(place[name], np.log(load * ratio)) for place in overview_record[key]])
                    for key, ratio in zip(("places", "octave"), ratios, strict=True)
                )
                row |= {
                    f"{name}_surface": np.delete(here, number).mean() - here[number],
                    f"{name}_{JOINT}": on_curve(overview_record["whole"][name], np.log(load * ratios[0]))
                    - here[number],
                    f"{name}_octave": (here - coarser).std(ddof=1),
                    f"{name}_places": here.std(ddof=1),
                }
            by_place = np.log([place["gradient"] for place in overview_record["places"]])
            row[f"{overview.GRADIENT}_surface"] = np.delete(by_place, number).mean() - by_place[number]
            whole = np.log(overview_record["whole"]["gradient"])
            row[f"{overview.GRADIENT}_{JOINT}"] = whole - by_place[number]
            overviews.append(row)
    gradients = [part["gradient"] for part in parts]
    return fine, overviews, rows_elsewhere(record, gradients)


def rows_elsewhere(record: dict, gradients: list[float]) -> list[dict]:
    """Return what overviews of other positions show: those rows of parts in which the fine map is not.

    `gradients` are those of the parts, whose pixels are merged to those of the overview.
    """
    rows = []
    for factor, shown in record["overviews"].items():
        if None in (*shown["places"], *shown["octave"], *shown["own"]):
            continue
        for (number, gradient), load in itertools.product(enumerate(gradients), JUDGED):
            row = {"map": record["map"], "kind": record["kind"], "part": number}
            row |= {"factor": int(factor), "load": load}
            ratios = [shown[key][number]["gradient"] / gradient for key in ("own", "octave")]
            for name in NAMES:
                here, coarser = (
                    np.array(
                        [on_curve(shown[key][part][name], np.log(load * ratio)) for part in elsewhere(number)]
                    )
                    for key, ratio in zip(("places", "octave"), ratios, strict=True)
                )
                own = on_curve(shown["own"][number][name], np.log(load * ratios[0]))
                row |= {
                    f"{name}_surface": here.mean() - own,
                    f"{name}_octave": (here - coarser).std(ddof=1),
                    f"{name}_places": here.std(ddof=1),
                }
            rows.append(row)
    return rows


def elsewhere(number: int) -> list[int]:
    """Return the parts that lie in other rows than this one."""
    return [part for part in range(9) if part // 3 != number // 3]


def errors_of(
    fine: pd.DataFrame, overviews: pd.DataFrame, name: str, measurand: str, *, around: bool = True
) -> pd.DataFrame:
    """Return the errors of a quantity: of the fine map alone, and the changes that the overview shows.

    An overview that is not `around` the map is of the parts `elsewhere`, which are then the truth; else it
    also shows that of the `overview.COUNTERPARTS`.
    """
    tables = []
    for (key, load), some in fine.groupby(["map", "load"], sort=False):
        parts = some[some["part"] != WHOLE]
        values = parts[name].to_numpy(float)
        for index, part in enumerate(parts.itertuples()):
            others = np.delete(values, index) if around else values[elsewhere(index)]
            if measurand == JOINT:
                truths = some.loc[some["part"] == WHOLE, name].to_numpy(float)
            else:
                truths = others if measurand == "next" else others.mean(keepdims=True)
            base = {"map": key, "kind": part.kind, "load": load, "part": part.part, "Sq": part.Sq}
            base |= {"area": getattr(part, AREA), "value": values[index], "scatter": part.scatter}
            tables += [base | {"alone": truth - values[index]} for truth in truths]
    alone = pd.DataFrame(tables)
    change = JOINT if measurand == JOINT else "surface"
    kept = {f"{name}_{change}": "change", f"{name}_octave": "octave", f"{name}_places": "places"}
    counterparts = overview.COUNTERPARTS.get(name, ()) if around else ()
    kept |= {f"{key}_{change}": f"counterpart {index}" for index, key in enumerate(counterparts)}
    shown = overviews.rename(columns=kept)[["map", "part", "load", "factor", *kept.values()]]
    both = alone.merge(shown, on=["map", "part", "load"]).dropna(subset=["alone", *kept.values()])
    return _weighted(both, ["map", "load", "factor"])


def _weighted(errors: pd.DataFrame, by: list[str]) -> pd.DataFrame:
    """Return rows, each map with the same weight at a load."""
    errors = errors.assign(alone=errors["alone"].clip(-calibrate.MAX_ERROR, calibrate.MAX_ERROR))
    return errors.assign(weight=1 / errors.groupby(by)["alone"].transform("size"))


def size_of(errors: pd.DataFrame, measurand: str) -> np.ndarray:
    """Return the expected size of errors, from what overview and map show."""
    shown = (errors[key].to_numpy() for key in ("change", "octave", "places", "scatter"))
    return overview.expected_size(measurand, *shown)


def changes_of(errors: pd.DataFrame) -> pd.DataFrame:
    """Return the changes that the overview shows of a quantity, and of its counterparts that count."""
    return errors[[key for key in errors if key.startswith(("change", "counterpart"))]]


def coefficients_of(errors: pd.DataFrame) -> np.ndarray:
    """Return by how much the changes that the overview shows count: least squares, a single one 0 to 1.

    Ridge regression (Hoerl and Kennard 1970) keeps those of counterparts small where few maps tell of them.
    """
    root, changes = np.sqrt(errors["weight"]), changes_of(errors).clip(-LARGEST_CHANGE, LARGEST_CHANGE)
    rows = np.vstack([changes.mul(root, axis=0), np.sqrt(RIDGE) * np.eye(changes.shape[1])[1:]])
    target = np.append(errors["alone"] * root, np.zeros(len(rows) - len(root)))
    shares = np.linalg.lstsq(rows, target, rcond=None)[0]
    return np.clip(shares, 0.0, 1.0) if shares.size == 1 else shares


def arms_of(errors: pd.DataFrame, measurand: str, level: float | None = None) -> dict:
    """Return the coefficients of the changes, and the arms down and up at each load, of one factor."""
    errors = errors[errors["kind"] == "measured"]
    shares = coefficients_of(errors)
    if level is None:
        is_of_few = measurand == "surface" and errors["factor"].iloc[0] == FACTORS[-1]
        level = LEVEL_OF_FEW if is_of_few else LEVELS[measurand]
    arms: dict = {"shares": shares.tolist(), "load": [], "down": [], "up": []}
    ratio = (errors["alone"] - changes_of(errors) @ shares) / size_of(errors, measurand)
    for load in JUDGED:
        some = (errors["load"] == load).to_numpy()
        weights = errors["weight"].to_numpy()[some]
        low, high = calibrate.quantiles(ratio.to_numpy()[some], weights, level)
        arms["load"].append(float(np.median(errors["area"].astype(float)[some])))
        arms["down"].append(-low)
        arms["up"].append(high)
    return arms


def left_out(errors: pd.DataFrame, measurand: str, level: float | None = None) -> pd.DataFrame:
    """Return errors of one factor with the ends of their intervals, each map calibrated without itself."""
    tables = []
    for name, some in errors.groupby("map", sort=False):
        arms = arms_of(errors[errors["map"] != name], measurand, level)
        size = size_of(some, measurand)
        index = some["load"].map({load: index for index, load in enumerate(JUDGED)}).to_numpy()
        low, high = (sign * np.array(arms[key])[index] * size for sign, key in ((-1, "down"), (1, "up")))
        error = some["alone"] - changes_of(some) @ arms["shares"]
        tables.append(some.assign(error=error, low=low, high=high))
    return pd.concat(tables)


def gap_limits(fine: pd.DataFrame, measurand: str, level: float = LIMIT_LEVEL) -> dict[str, list[float]]:
    """Return by how much the gap of the truth is larger, in Sq of the part, in a share of all parts."""
    errors = _alone(fine, GAP, measurand)
    errors = errors[errors["kind"] == "measured"]
    larger = np.exp(errors["value"]) * np.expm1(errors["alone"]) / errors["Sq"]
    limits: dict[str, list[float]] = {"load": [], "up": []}
    for load in JUDGED:
        some = (errors["load"] == load).to_numpy()
        weights = errors["weight"].to_numpy()[some]
        limits["load"].append(float(np.median(errors["area"].astype(float)[some])))
        limits["up"].append(calibrate.quantiles(larger.to_numpy()[some], weights, level)[1])
    return limits


def _alone(fine: pd.DataFrame, name: str, measurand: str) -> pd.DataFrame:
    """Return the errors of parts without any overview."""
    keys = ["map", "part", "load"]
    nothing = fine.loc[fine["part"] != WHOLE, keys].assign(factor=0)
    names = name, *overview.COUNTERPARTS.get(name, ())
    columns = {f"{key}_{suffix}": 0.0 for key in names for suffix in ("surface", JOINT, "octave", "places")}
    return errors_of(fine, nothing.assign(**columns), name, measurand)


def coverage(fine: pd.DataFrame, overviews: pd.DataFrame, *, around: bool = True) -> pd.DataFrame:
    """Return coverage, half-width and bias by quantity, measurand and factor, each map left out once."""
    rows = []
    measurands, level = (("surface", JOINT), None) if around else (("surface", "next"), LEVEL_ELSEWHERE)
    for name, measurand, factor in itertools.product(NAMES, measurands, FACTORS):
        errors = errors_of(fine, overviews[overviews["factor"] == factor], name, measurand, around=around)
        for kind, of_kind in left_out(errors, measurand, level).groupby("kind"):
            first = {"quantity": calibrate.SHORT[name], "measurand": measurand, "pixels": f"{factor} x"}
            row = first | {"maps": kind, "number": of_kind["map"].nunique()}
            for load in JUDGED:
                some = of_kind[of_kind["load"] == load]
                weight = some["weight"].to_numpy()
                inside = some["error"].between(some["low"] - 1e-12, some["high"] + 1e-12)
                ends, alone = (
                    calibrate.quantiles(some[key].to_numpy(), weight, calibrate.COVERAGE)
                    for key in ("error", "alone")
                )
                row |= {
                    f"inside at {load} (%)": 100 * np.average(inside, weights=weight),
                    f"half-width at {load}": float((some["high"] - some["low"]).median() / 2),
                    f"bias at {load}": np.average(some["error"], weights=weight),
                    f"half of 95 % at {load}": (ends[1] - ends[0]) / 2,
                    f"alone at {load}": (alone[1] - alone[0]) / 2,
                }
            rows.append(row)
    return pd.DataFrame(rows)


def alone_left_out(fine: pd.DataFrame, name: str) -> pd.DataFrame:
    """Return the intervals of measured maps alone, each left out; the limit of the gap as `limited`.

    They are those of `calibrate.py`, whose parts are these; maps that are not in its bank are missing.
    """
    errors = calibrate.errors_of(calibrate.read_bank(), calibrate.SHORT[name], "surface")
    held = calibrate.left_out(errors, errors)
    held = held[(held["kind"] == "measured") & held["load"].isin(JUDGED)]
    alone = _alone(fine, name, "surface")
    tables = []
    for key, some in held.groupby("map"):
        limits = gap_limits(fine[fine["map"] != key], "surface")["up"]
        for (load, rows), limit in zip(some.groupby("load"), limits, strict=True):
            own = alone[(alone["map"] == key) & (alone["load"] == load)]
            of_load = rows.iloc[: len(own)]  # parts of 1/9 come first
            if len(own) == len(of_load) > 0:
                reach = limit * own["Sq"].to_numpy() / np.exp(own["value"].to_numpy(float))
                limited = np.minimum(of_load["high"], np.log1p(reach)) if name == GAP else of_load["high"]
                tables.append(of_load.assign(limited=limited, part=own["part"].to_numpy()))
    return pd.concat(tables)


def of_limit(fine: pd.DataFrame) -> pd.DataFrame:
    """Return coverage and score of the gap of one map with and without its limit in Sq, each map left out."""
    errors = alone_left_out(fine, GAP)
    first = {"maps": errors["map"].nunique()}
    return pd.DataFrame(
        {"limit": words} | first | by_load(errors.assign(high=errors[high]))
        for words, high in (("none", "high"), ("in Sq", "limited"))
    )


def by_load(errors: pd.DataFrame) -> dict[str, float]:
    """Return coverage, half-width and score of intervals at each load."""
    return {
        f"{key} at {load}": value
        for load in JUDGED
        for key, value in calibrate.shares(errors[errors["load"] == load]).items()
    }


def as_used(fine: pd.DataFrame, overviews: pd.DataFrame) -> pd.DataFrame:
    """Return what the narrower one of the intervals with the overview and of the map alone would hold."""
    rows = []
    for name in NAMES:
        alone = alone_left_out(fine, name)[["map", "part", "load", "low", "limited"]]
        for factor in FACTORS:
            errors = errors_of(fine, overviews[overviews["factor"] == factor], name, "surface")
            intervals = left_out(errors[errors["kind"] == "measured"], "surface")
            intervals = intervals.merge(alone, on=["map", "part", "load"], suffixes=("", "_alone"))
            wider = intervals["high"] - intervals["low"] > intervals["limited"] - intervals["low_alone"]
            first = {"quantity": calibrate.SHORT[name], "pixels": f"{factor} x"}
            first |= {"maps": intervals["map"].nunique(), "alone counts (%)": 100 * wider.mean()}
            ends = {"low": "low_alone", "high": "limited", "error": "alone"}
            used = {key: np.where(wider, intervals[other], intervals[key]) for key, other in ends.items()}
            single = {key: intervals[other] for key, other in ends.items()}
            for words, some in (("alone", intervals.assign(**single)), ("the overview", intervals)):
                first[f"where {words} holds (%)"] = calibrate.shares(some[wider])["inside (%)"]
            for words, columns in (("map alone", single), ("with overview", used)):
                rows.append(first | {"what": words} | by_load(intervals.assign(**columns)))
    return pd.DataFrame(rows)


def promise(fine: pd.DataFrame, overviews: pd.DataFrame) -> tuple[list[float], pd.Series]:
    """Return constant and power of the half-width of the area with an overview, and the ratios to it.

    At the middle load, for pixels four times as large, ln(width) is a line over ln(width of the map alone),
    both by the calibration as it is.
    """
    keys, bank_rows = ["map", "part", "load"], calibrate.read_bank()
    bank_rows = bank_rows[(bank_rows["kind"] == "measured") & (bank_rows["what"] == "3x3")]
    rows = overviews[(overviews["factor"] == FACTORS[1]) & (overviews["load"] == JUDGED[1])]
    rows = rows.merge(fine[[*keys, AREA]], on=keys)
    rows = rows.merge(bank_rows[[*keys, *calibrate.FEATURES]], on=keys).dropna()
    alone, both = [], []
    for row in rows.itertuples():
        area = from_scale(AREA, np.array([getattr(row, AREA)]))
        features = {key: getattr(row, key) for key in calibrate.FEATURES}
        alone.append(float(sum(calibrated.arms("surface", AREA, features, area))[0]) / 2)
        _, *arms = calibrated.overview_arms("surface", AREA, FACTORS[1], area)
        shown = (np.array([getattr(row, f"{AREA}_{key}")]) for key in ("surface", "octave", "places"))
        size = overview.expected_size("surface", *shown, features["gradient"])
        both.append(float((sum(arms) * size)[0]) / 2)
    line = np.polyfit(np.log(alone), np.log(both), 1)[::-1]
    ratio = np.array(both) / np.exp(line[0] + line[1] * np.log(alone))
    return [round(float(number), 3) for number in line], pd.Series(ratio)


def of_several(fine: pd.DataFrame, overviews: pd.DataFrame) -> pd.DataFrame:
    """Return what the mean of two overviews of a field holds, by pixels 2 x and 4 x, each map left out."""
    rows, keys = [], ["map", "part", "load"]
    for name in (AREA, GAP, CONDUCTANCE):
        by_factor = [
            left_out(errors_of(fine, overviews[overviews["factor"] == factor], name, "surface"), "surface")
            for factor in FACTORS[:2]
        ]
        both = by_factor[0].merge(by_factor[1][[*keys, "error", "low", "high"]], on=keys, suffixes=("", "_2"))
        both = both[both["kind"] == "measured"]
        weights = [(both[f"high{end}"] - both[f"low{end}"]) ** -2.0 for end in ("", "_2")]
        mean = {
            key: sum(weight * both[f"{key}{end}"] for weight, end in zip(weights, ("", "_2"), strict=True))
            / sum(weights)
            for key in ("error", "low", "high")
        }
        first = {"quantity": calibrate.SHORT[name], "maps": both["map"].nunique()}
        rows.append(first | by_load(both.assign(**mean)))
    return pd.DataFrame(rows)


def calibration(fine: pd.DataFrame, overviews: pd.DataFrame, others: pd.DataFrame) -> dict:
    """Return the entries of `calibration.json` that are of overviews, and the limits of the gap.

    `others` are overviews of other positions.
    """
    table: dict = {"overview": {}, "elsewhere": {}, "limit_of_gap": {}}
    # of 15 maps with pixels 8 times as large 90 % of the gaps left out lay inside: too few
    for measurand, name, factor in itertools.product(
        ("surface", "next"), (AREA, GAP, CONDUCTANCE), FACTORS[:-1]
    ):
        errors = errors_of(fine, others[others["factor"] == factor], name, measurand, around=False)
        of_name = table["elsewhere"].setdefault(measurand, {}).setdefault(name, {})
        of_name[str(factor)] = arms_of(errors, measurand, LEVEL_ELSEWHERE)
    for measurand in ("surface", "next", JOINT):
        table["limit_of_gap"][measurand] = gap_limits(fine, measurand)
        # of joints 14 maps hold pixels 8 times as large: too few, 86 % of those left out lay inside
        factors = FACTORS[:-1] if measurand == JOINT else FACTORS
        for name, factor in itertools.product((AREA, GAP, CONDUCTANCE), factors):
            errors = errors_of(fine, overviews[overviews["factor"] == factor], name, measurand)
            of_name = table["overview"].setdefault(measurand, {}).setdefault(name, {})
            of_name[str(factor)] = arms_of(errors, measurand)
    return calibrate.rounded(table)


def without_copies(fine: pd.DataFrame, *others: pd.DataFrame) -> list[pd.DataFrame]:
    """Return the tables of the bank without the second of two files of the same heights."""
    whole = fine[fine["part"] == WHOLE].pivot_table(index="map", columns="load", values=list(NAMES))
    maps = whole.drop_duplicates().index
    return [table[table["map"].isin(maps)] for table in (fine, *others)]


def main() -> None:
    """Measure, and print or write the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", type=Path, nargs="*", help="folders of instrument files")
    parser.add_argument("--fit", action="store_true", help="from the bank as it is")
    parser.add_argument("--write", action="store_true", help="write bank, calibration and tables; else print")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    if not options.fit:
        pairs = [rows_of(record) for record in bank(options.folders) if record]
        for file, rows in zip(BANK, zip(*pairs, strict=True), strict=True):
            file.parent.mkdir(exist_ok=True)
            table = pd.DataFrame(itertools.chain.from_iterable(rows))
            digits = {"Sq": 4, "gradient": 4}
            text = {
                key: table[key].map(lambda v, n=n: f"{v:.{n}g}") for key, n in digits.items() if key in table
            }
            table.assign(**text).to_csv(file, index=False, float_format="%.3f")
    fine, overviews, others = without_copies(*map(pd.read_csv, BANK))
    tables = {"coverage": coverage(fine, overviews), "limit": of_limit(fine)}
    tables |= {"used": as_used(fine, overviews), "several": of_several(fine, overviews)}
    tables["other positions"] = coverage(fine, others, around=False)
    tables = {name: table.round(3) for name, table in tables.items()}
    if options.write:
        content = json.loads(calibrate.TABLE.read_text()) | calibration(fine, overviews, others)
        calibrate.TABLE.write_text(json.dumps(content, indent=1) + "\n")
        content["overview_promise"], ratio = promise(fine, overviews)
        calibrate.TABLE.write_text(json.dumps(content, indent=1) + "\n")
        of_ratio = {"width over promise": ratio, "off by a factor": calibrate.factor_off(ratio)}
        shares = pd.DataFrame(of_ratio).quantile([0.05, 0.25, 0.5, 0.75, 0.9, 0.95]).round(2)
        tables["promise"] = shares.rename_axis("share of parts").reset_index()
        for name, table in tables.items():
            table.to_csv(RESULTS / f"{name.replace(' ', '_')}.csv", index=False)
    pages.show(tables)


if __name__ == "__main__":
    main()
