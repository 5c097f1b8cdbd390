"""Hold the ± against surfaces whose results are known: real maps, cut into parts, and made ones.

    python benchmarks/intervals.py FOLDER ... --write
    python benchmarks/intervals.py FOLDER --only plu-1.plu      # one map, printed
    python benchmarks/intervals.py --answers --seeds 1 2 3      # conductance and narrowest places
    python benchmarks/intervals.py FOLDER ... --whole           # verdicts on whole maps

Every map in the folders that is read without being told anything, and has at least 400 points along each
side, is solved whole, by default settings: that is the truth, of the pressure in contact the load over the
contact area. It is cut into 3 x 3 parts, and each part is processed as if it were the measurement, its own
error budget included, at the same mean pressures. Maps that are smaller, from 192 points on, make a second
group. Made surfaces of eight kinds, with waves from an eighth to three times the length of the map, are cut
in the same way, some with faults.

`--answers` holds the ± of conductance and narrowest places against such made surfaces, two small maps of
each, and counts the intervals without an upper end, which hold the truth where it is not below the lower one.
`--whole` counts the verdicts on every map that is read without being told anything, steel on PEEK, at contact
areas that a user would choose.

The truth has the pixels of the map: what shorter waves would change is in the intervals, not in the error.
Shares and widths are therefore given for the intervals without the source *unresolved* as well.
"""

import argparse
import itertools
import json
import sys
import warnings
from functools import partial
from pathlib import Path

import instruments
import numpy as np
import pages
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.contact.loads import plan_loads
from roughcontact.errors import RoughContactError
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.statistics import checks
from roughcontact.statistics.contact_statistics import with_uncertainty
from roughcontact.uncertainty.answers import ANSWERS, headline_and_answers
from roughcontact.uncertainty.headline import QUANTITIES
from roughcontact.validation.masters import FAULTS, KINDS, cut_out, master_surface

SHOWN = {  # quantities: names in the tables; all but the last are the headline
    "relative_contact_area": "area",
    "mean_gap": "gap",
    "mean_contact_pressure": "pressure",
    "max_pressure": "peak",
}
JUDGED = ("inside of these (%)", "misses to review (%)")
LOADS = (0.02, 0.1, 0.4)  # of E* times the rms gradient of the whole map
CUTS = 3
LARGE, SMALL = 400, 192  # points along each side, at least
LONGEST = (1 / 8, 1 / 3, 1, 3)  # waves of made surfaces, of the length of the map
MADE_SIDE, ANSWERS_SIDE = 192, 96
PLACES, ANSWERS_PLACES = 4, 2  # maps of each made surface
GROOVED = ("ground", "honed")
CELLULAR = "cratered"
BODIES = (
    {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "hardness": 2e9},
    {"youngs_modulus": 3.6e9, "poissons_ratio": 0.38, "hardness": 3e8},
)
AREAS = (0.003, 0.01, 0.03, 0.1, 0.2, 0.3)  # of the whole maps
WORK = Path(__file__).parent / "work" / "coverage.json"


def solve(height, loads) -> dict:
    """Return window and statistics of a map by default settings, at the given mean pressures (E* = 1)."""
    levelled = rc.level(height)
    window = rc.periodic_window(levelled)
    contact = {"contact_modulus": 1.0, "mean_pressure": list(loads)}
    statistics = rc.solve_contact(window, **contact, reduce=rc.contact_statistics)
    return {"levelled": levelled, "window": window, "contact": contact, "statistics": statistics}


def measure(height, loads, truth) -> dict:
    """Return results, intervals and errors of one map; the message where it is refused."""
    try:
        found = solve(height, loads)
    except RoughContactError as error:
        return {"refused": str(error)}
    levelled, window = found["levelled"], found["window"]
    settings = {"level": {}, "window": {}, "contact": found["contact"]}
    statistics = with_uncertainty(found["statistics"], rc.error_budget(levelled, window, settings))
    judged = checks.with_verdicts(statistics, window)
    row: dict = {"reasons": [reason["check"] for reason in json.loads(judged.attrs["reasons"])]}
    for name in QUANTITIES:
        columns = {"result": "", "lower": "_lower", "upper": "_upper", "verdict": "_verdict"}
        found = {key: judged[name + ending].values.tolist() for key, ending in columns.items()}
        row[name] = {"truth": truth[name]} | found | resolved_ends(judged, name)
    return row


def resolved_ends(statistics, name: str) -> dict:
    """Return the ends (load) of an interval without the source of waves that are not resolved."""
    value = statistics[name]
    parts = statistics[f"{name}_components"].drop_sel(source=["unresolved", "combined"]).fillna(np.inf)
    down, up, bias, less, more = (parts.sel(component=each, drop=True) for each in parts["component"].values)
    share = 1 / value.where(value > 0)
    lower = (value - np.sqrt((down**2).sum("source"))) * (1 - less * share).clip(min=0).prod("source")
    upper = (value + bias.sum("source") + np.sqrt((up**2).sum("source"))) * (1 + more * share).prod("source")
    most = 1.0 if name == "relative_contact_area" else np.inf
    ends = {"resolved_lower": lower.clip(min=0), "resolved_upper": upper.clip(max=most)}
    return {end: values.values.tolist() for end, values in ends.items()}


def truth_of(statistics) -> dict:
    """Return the four quantities (load) as plain lists.

    The mean over whole pixels is known to fall short of the pressure in contact. What its interval is for is
    the load over the area.
    """
    found = {name: statistics[name].values.tolist() for name in QUANTITIES}
    over_area = statistics["mean_pressure"] / statistics["relative_contact_area"]
    return found | {"mean_contact_pressure": over_area.values.tolist()}


def real_map(path: Path) -> dict | None:
    """Return the rows of the parts of one file; None where it is no map, or too small a one."""
    try:
        height = rc.read_height_map(path).astype(float)
        if min(height.shape) < SMALL:
            return None
        window = rc.periodic_window(rc.level(height))
    except RoughContactError:
        return None
    loads = plan_loads(window, contact_modulus=1.0, relative_pressure=list(LOADS))
    truth = truth_of(solve(height, loads)["statistics"])
    edges = [np.arange(CUTS + 1) * n // CUTS for n in height.shape]
    rows = [
        measure(height[top:bottom, left:right], loads, truth)
        for top, bottom in zip(edges[0][:-1], edges[0][1:], strict=True)
        for left, right in zip(edges[1][:-1], edges[1][1:], strict=True)
    ]
    return {"group": "large" if min(height.shape) >= LARGE else "small", "name": path.name, "parts": rows}


def made_surface(kind: str, longest: float, seed: int, side: int) -> tuple:
    """Return a synthetic surface three times as long as maps of `side` points, and its loads (E* = 1)."""
    hurst = (0.5, 0.7, 0.9)[seed % 3]
    if kind == CELLULAR:
        surface = instruments.other_surface(kind, CUTS * side, longest * side, hurst=hurst, seed=seed)
        surface = surface * (0.1 / rms_gradient(surface))
    else:
        surface = master_surface(kind, CUTS * side, longest=longest / CUTS, seed=seed, hurst=hurst)
    return surface, list(plan_loads(surface, contact_modulus=1.0, relative_pressure=list(LOADS)))


def made_map(kind: str, longest: float, seed: int) -> dict:
    """Return the rows of maps cut out of a synthetic surface."""
    surface, loads = made_surface(kind, longest, seed, MADE_SIDE)
    contact = {"contact_modulus": 1.0, "mean_pressure": loads}
    truth = truth_of(rc.solve_contact(surface, **contact, reduce=rc.contact_statistics))
    generator = np.random.default_rng(seed)
    rows = [
        measure(cut_out(surface, MADE_SIDE, generator, fault=FAULTS[place % len(FAULTS)]), loads, truth)
        for place in range(PLACES)
    ]
    return {"group": "made", "name": kind, "longest": longest, "seed": seed, "parts": rows}


def answers_held(kind: str, longest: float, seed: int) -> list[dict]:
    """Return for each answer and load of some maps whether the interval holds, and has no upper end."""
    surface, loads = made_surface(kind, longest, seed, ANSWERS_SIDE)
    problem = {"contact_modulus": 1.0, "mean_pressure": loads}
    truth = rc.solve_contact(surface, **problem, tolerance=1e-3, reduce=headline_and_answers)
    generator = np.random.default_rng(seed)
    waves = "up to the map" if longest <= 1 else "three times the map"
    rows = []
    for _ in range(ANSWERS_PLACES):
        levelled = rc.level(cut_out(surface, ANSWERS_SIDE, generator, fault="none"))
        settings = {"level": {}, "window": {}, "contact": problem}
        budget = rc.error_budget(levelled, rc.periodic_window(levelled), settings)
        for name in (*ANSWERS, "mean_gap"):
            ends = (budget[f"{name}_{end}"].values for end in ("lower", "upper"))
            for lower, upper, true in zip(*ends, truth[name].values, strict=True):
                if np.isfinite(true) and np.isfinite(lower):  # the conductance of full contact is not
                    held = {"inside": lower <= true and not upper < true, "open": np.isnan(upper)}
                    rows.append({"quantity": shown(name, kind), "waves": waves} | held)
    return rows


def shown(name: str, kind: str) -> str:
    """Return the name of an answer in the table: narrowest places by what the kind has, grooves or cells."""
    if name.startswith("critical_constriction"):
        words = "cells" if kind == CELLULAR else f"{'with' if kind in GROOVED else 'without'} grooves"
        return f"narrowest places, {words}"
    return "mean gap" if name == "mean_gap" else "conductance"


def answers(seeds: list[int]) -> dict[str, pd.DataFrame]:
    """Return the table of the answers, of all kinds and longest waves."""
    cases = [*itertools.product(KINDS, LONGEST, seeds), *itertools.product([CELLULAR], LONGEST[:2], seeds)]
    rows = pd.DataFrame([row for case in cases for row in answers_held(*case)])
    shares = 100 * rows.groupby(["quantity", "waves"])[["inside", "open"]].mean()
    table = shares.rename(columns={"inside": "inside (%)", "open": "without an upper end (%)"}).reset_index()
    return {"answers": pages.text(table, dict.fromkeys(table.columns[2:], ".0f"))}


def results_of(found: list[dict], which: str = "") -> pd.DataFrame:
    """Return one row for each result of all parts that were not refused: part, quantity and load.

    `which` is "resolved_" for the intervals of `resolved_ends`.
    """
    names = ("truth", "result", "lower", "upper", "verdict")
    keys = ("truth", "result", f"{which}lower", f"{which}upper", "verdict")
    rows = [
        {
            "group": each["group"],
            "surface": each["name"],
            "longest": each.get("longest"),
            "part": (number, place),
        }
        | {"quantity": shown, "load": load}
        | dict(zip(names, values, strict=True))
        for number, each in enumerate(found)
        for place, part in enumerate(each["parts"])
        if "refused" not in part
        for name, shown in SHOWN.items()
        for load, *values in zip(LOADS, *(part[name][key] for key in keys), strict=True)
    ]
    results = pd.DataFrame(rows).replace({"group": {"made": "synthetic"}})
    results["flagged"] = results["verdict"] > 0
    rounding, base = 1e-9 * results["result"].abs(), results["result"].where(results["result"] > 0, 1.0)
    upper = results["upper"].fillna(np.inf).where(results["lower"].notna())  # without an end: *or more*
    results["inside"] = results["truth"].between(results["lower"] - rounding, upper + rounding)
    results["half_width"] = (results["upper"] - results["lower"]) / 2 / base
    results["error"] = (results["truth"] - results["result"]).abs() / base
    return results


def counted(results: pd.DataFrame) -> dict:
    """Return shares inside, widths, verdicts and silent misses of some results.

    A width is the median half-width over the 95 % quantile of the error. A miss is silent where the verdict
    on that quantity at that load is *use*.
    """
    row = {"parts": results["part"].nunique()}
    for quantity, some in results.groupby("quantity", sort=False):
        row[f"{quantity} inside (%)"] = 100 * some["inside"].mean()
        if quantity != "peak":
            row[f"{quantity} width"] = some["half_width"].median() / some["error"].quantile(0.95)
    row["use (%)"] = 100 * (~results["flagged"]).mean()
    row["silent (%)"] = 100 * (~results["inside"] & ~results["flagged"]).mean()
    return row


def judged(results: pd.DataFrame) -> dict:
    """Return the share of results with the verdict *use*, and what it is worth."""
    use = ~results["flagged"]
    shares = (results["inside"][use].mean(), results["flagged"][~results["inside"]].mean())
    return {"use (%)": 100 * use.mean()} | {
        name: 100 * share for name, share in zip(JUDGED, shares, strict=True)
    }


def tables(found: list[dict]) -> dict[str, pd.DataFrame]:
    """Return shares and widths by surface and by load, and the medians of the widths of the surfaces."""
    results = results_of(found)
    made = results[results["longest"].notna()]
    by_length = made.assign(group="synthetic, by longest wave", surface=made["longest"].map("{:.3g}".format))
    rows, widths, loads, verdicts = [], [], [], []
    for group, of_group in pd.concat([results, by_length]).groupby("group", sort=False):
        surfaces = [
            counted(some) | {"surface": name} for name, some in of_group.groupby("surface", sort=False)
        ]
        rows += [{"group": group} | row for row in (*surfaces, counted(of_group) | {"surface": "all"})]
        medians = pd.DataFrame(surfaces).filter(like=" width").median()
        medians = {name.removesuffix(" width"): width for name, width in medians.items()}
        widths.append({"group": group} | medians)
        if group in results["group"].values:
            shares = 100 * of_group.groupby(["quantity", "load"], sort=False)["inside"].mean().unstack()
            loads.append(shares.rename(columns=str).reset_index().assign(group=group))
            verdicts += [
                {"group": group, "quantity": quantity} | judged(some)
                for quantity, some in (
                    *of_group.groupby("quantity", sort=False),
                    ("area and pressure", of_group[of_group["quantity"].isin(["area", "pressure"])]),
                    ("all", of_group),
                )
            ]
    by_surface, by_load = pd.DataFrame(rows), pd.concat(loads)
    first = ["group", "surface", "parts"]
    by_surface = by_surface[[*first, *by_surface.columns.drop(first)]]
    decimals = {
        name: ".1f" if name.endswith(("width", "silent (%)")) else ".0f" for name in by_surface.columns[3:]
    }
    return {
        "surfaces": pages.text(by_surface, decimals),
        "resolved": pages.text(of_resolved_waves(found), dict.fromkeys(SHOWN.values(), ".1f")),
        "loads": pages.text(
            by_load[["group", "quantity", *map(str, LOADS)]], dict.fromkeys(map(str, LOADS), ".0f")
        ),
        "widths": pages.text(
            pd.DataFrame(widths),
            dict.fromkeys(list(SHOWN.values()), ".1f"),
        ),
        "verdicts": pages.text(pd.DataFrame(verdicts), dict.fromkeys(["use (%)", *JUDGED], ".1f")),
    }


def of_resolved_waves(found: list[dict]) -> pd.DataFrame:
    """Return by group the shares inside and the median widths of the intervals without waves not resolved."""
    rows = []
    for group, of_group in results_of(found, "resolved_").groupby("group", sort=False):
        surfaces = pd.DataFrame([counted(some) for _, some in of_group.groupby("surface", sort=False)])
        inside = {key: f"{share:.0f}" for key, share in counted(of_group).items() if "inside" in key}
        widths = surfaces.filter(like=" width").median()
        rows.append({"group": group} | inside | {n.removesuffix(" width"): w for n, w in widths.items()})
    return pd.DataFrame(rows)


def whole_map(path: Path) -> list[dict]:
    """Return for one file how many loads there are and have the verdict *use*, and why not; or nothing."""
    try:
        found = rc.evaluate(path, contact={"bodies": BODIES, "target_area": list(AREAS)})
    except RoughContactError:
        return []
    why = "; ".join(reason["check"] for reason in json.loads(found.attrs["reasons"]))
    use = int((found["verdict"] == 0).sum())
    return [{"map": path.name, "loads": found.sizes["load"], "use": use, "reasons": why}]


def whole(files: list[Path]) -> dict[str, pd.DataFrame]:
    """Return the table of the verdicts on whole maps, and their sums."""
    table = pd.DataFrame([row for path in files for row in whole_map(path)])
    of_all = {"map": f"all {len(table)}", "loads": table["loads"].sum(), "use": table["use"].sum()}
    return {"whole": pd.concat([table, pd.DataFrame([of_all])]).fillna("")}


def main() -> None:
    """Measure what is asked for, keep the rows, print or write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folders", nargs="*", type=Path, help="folders of instrument files")
    parser.add_argument("--only", nargs="+", help="names of files; they are printed and not kept")
    parser.add_argument("--answers", action="store_true", help="conductance and narrowest places alone")
    parser.add_argument("--whole", action="store_true", help="verdicts on whole maps alone")
    parser.add_argument("--seeds", nargs="*", type=int, default=[1], help="of the made surfaces")
    parser.add_argument("--work", type=Path, default=WORK, help="where the rows are kept")
    parser.add_argument("--write", action="store_true", help="write the tables and their page; else print")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    finish = partial(pages.publish, "coverage") if arguments.write else pages.show
    if arguments.answers:
        finish(answers(arguments.seeds))
        return
    files = sorted({path for folder in arguments.folders for path in folder.iterdir() if path.is_file()})
    if arguments.whole:
        finish(whole(files))
        return
    if arguments.only:
        found = [real_map(path) for path in files if path.name in arguments.only]
        pages.show(tables([each for each in found if each]))
        return
    kept = json.loads(arguments.work.read_text()) if arguments.work.exists() else []
    jobs = [(path.name, partial(real_map, path)) for path in files]
    for seed, kind, longest in itertools.product(arguments.seeds, KINDS, LONGEST):
        name = f"{kind}, waves of {longest:.3g}, seed {seed}"
        jobs.append((name, partial(made_map, kind, longest, seed)))
    done = {each["job"] for each in kept}
    arguments.work.parent.mkdir(parents=True, exist_ok=True)
    for job, run in jobs:
        if job in done:
            continue
        rows = run() or {"group": "none"}
        kept.append(rows | {"job": job})
        print(job, rows["group"], flush=True)
        arguments.work.write_text(json.dumps(kept))
    finish(tables([each for each in kept if each["group"] != "none"]))


if __name__ == "__main__":
    main()
