"""The tables of the benchmark of speed, from the records that `speed.py` keeps."""

import re

import numpy as np
import pandas as pd
from pages import text
from race import CODES

QUIET = 2.5  # load average: more than an earlier part of the measurement leaves behind
BOUNDS = {1e-4: "1e-4", 1e-8: "1e-8"}


def tables(results: dict) -> dict[str, pd.DataFrame]:
    """Return the tables of all parts that were measured, with numbers as text."""
    tables_by_name: dict[str, pd.DataFrame] = {}
    for part, make in PARTS.items():
        if results.get(part):
            tables_by_name |= make(list(results[part].values()))
    return tables_by_name


def about(results: dict) -> dict | None:
    """Return machine, versions, and the time of one load on the largest synthetic map up to 1024 points."""
    about_codes = results["about"]
    if not (results.get("race") and results.get("maps")):
        return None
    synthetic_cases = [
        case for case in results["race"].values() if case["group"] == "made" and case["threads"] == 1
    ]
    points = min(1024, max(case["size"] for case in synthetic_cases))
    times = [case["codes"]["roughcontact"]["seconds"] for case in synthetic_cases if case["size"] == points]
    return {
        "machine": about_codes["machine"],
        "versions": {
            name: version for code in about_codes["versions"].values() for name, version in code.items()
        },
        "busy": max(about_codes.get("load", {}).values(), default=0.0) > QUIET,
        "points": points,
        "one load (ms)": f"{1000 * np.median(times):.3g}",
        "maps": len(results["maps"]),
    }


def geometric_mean(values: pd.Series) -> float:
    """Return the geometric mean, NaN where a value is missing."""
    return float(np.exp(np.log(values).mean(skipna=False)))


def race(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return times and ratios of every map, and the mean ratios to each other code."""
    keys = ["threads", "group", "points per side", "map", "p′"]
    labels = [(case["threads"], case["group"], case["size"], case["name"], case["load"]) for case in records]
    seconds = [
        {code: tables_by_name["seconds"] for code, tables_by_name in case["codes"].items()}
        for case in records
    ]
    times = pd.DataFrame(seconds, index=pd.MultiIndex.from_tuples(labels, names=keys))
    codes = [code for code in CODES if code in times]
    ratios = times[codes[1:]].div(times[codes[0]], axis=0)
    cells = (1000 * times[codes]).add_suffix(" (ms)").join(ratios.add_suffix(" ratio"), validate="1:1")
    cells = cells.rename(index=lambda name: re.sub(r"made .*", "synthetic", str(name)), level="map")
    groups = cells.groupby(keys)
    means = groups.agg(geometric_mean).assign(cases=groups.size()).reset_index()
    means = means[["threads", "map", "cases", "points per side", "p′", *cells]]
    decimals = dict.fromkeys(means.filter(like=" ratio"), ".1f")
    tables_by_name = {"race": text(means, decimals)}
    return tables_by_name if ratios.empty else tables_by_name | {"ratios": _mean_ratios(ratios)}


def _mean_ratios(ratios: pd.DataFrame) -> pd.DataFrame:
    """Return mean and least ratio by threads, code and group of maps."""
    long = ratios.melt(var_name="code", value_name="ratio", ignore_index=False).dropna().reset_index()
    long["map"] = long["map"].str.replace(r"made (\d+) (\d+)", r"synthetic, \1², seed \2", regex=True)
    long["group"] = long["group"].replace("made", "synthetic")
    all_ratios = pd.concat([long, long.assign(group="all")], ignore_index=True)
    rows = []
    for (threads, code, maps), ratios_of_group in all_ratios.groupby(
        ["threads", "code", "group"], sort=False
    ):
        lowest = ratios_of_group.loc[ratios_of_group["ratio"].idxmin()]
        rows.append(
            {"threads": threads, "code": code, "maps": maps, "cases": len(ratios_of_group)}
            | {"geometric mean": geometric_mean(ratios_of_group["ratio"]), "least": lowest["ratio"]}
            | {"least map": lowest["map"], "least p′": lowest["p′"]}
        )
    table = pd.DataFrame(rows).sort_values(["threads", "code"], kind="stable")
    return text(table, {"geometric mean": ".1f", "least": ".1f"})


def solves_of(records: list[dict]) -> pd.DataFrame:
    """Return all solves of some maps."""
    solves = pd.DataFrame(
        [{"map": record["name"]} | solve for record in records for solve in record["solves"]]
    )
    return solves.assign(**{"error bound": solves["tolerance"].map(BOUNDS)})


def held_solves(records: list[dict]) -> pd.DataFrame:
    """Return all solves of some maps, and whether their bound is below the true error for certain."""
    solves = solves_of(records)
    below = solves["bound"] < solves["true_error"] - solves["reference_error"]
    return solves.assign(below=solves["resolved"].eq(True) & below)


def spread(groups) -> pd.DataFrame:
    """Return mean, median, 90 % quantile and largest of the pairs of some groups of solves."""
    pairs = groups["pairs"]
    return pd.DataFrame(
        {"mean": pairs.mean(), "median": pairs.median(), "90 %": pairs.quantile(0.9), "largest": pairs.max()}
    )


ONE_DECIMAL = dict.fromkeys(
    ("mean", "median", "90 %", "largest", "1e-4", "1e-8", "pairs", "solve / pair"), ".1f"
)


def maps(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return pairs by load, the maps with most, pairs of other settings, and bounds over true errors."""
    solves = held_solves(records)
    default = solves[solves["way"] == "default"].rename(columns={"load": "p′"})
    pairs = spread(
        pd.concat([default, default.assign(**{"p′": "all"})]).groupby(["error bound", "p′"], sort=False)
    )
    pairs = pairs.reset_index().sort_values("error bound", kind="stable")
    max_pairs = default.groupby(["map", "error bound"])["pairs"].max().unstack()
    at_most = (
        default[default["tolerance"] == 1e-4]
        .sort_values("pairs", ascending=False, kind="stable")
        .drop_duplicates("map")
    )
    shapes = {record["name"]: " × ".join(map(str, record["shape"])) for record in records}
    hardest = (
        at_most[["map", "p′"]].join(max_pairs, on="map").sort_values(list(BOUNDS.values()), ascending=False)
    )
    hardest.insert(1, "points", hardest["map"].map(shapes))
    variants = solves[solves["way"] != "default"].rename(columns={"way": "setting"})
    missed = ~variants["converged"]
    settings = spread(variants[~missed].groupby("setting")).reindex(variants["setting"].unique())
    settings["not reached"] = missed.groupby(variants["setting"]).sum()
    by_rounding = missed & (variants["floor"] > variants["tolerance"])
    settings["of these by rounding"] = by_rounding.groupby(variants["setting"]).sum()
    resolved_solves = default[default["resolved"].eq(True)].groupby("error bound")
    ratio = resolved_solves["ratio"]
    bounds = pd.DataFrame(
        {"solves": ratio.size(), "least": ratio.min(), "median": ratio.median(), "largest": ratio.max()}
        | {"bound below error": resolved_solves["below"].sum()}
    )
    return {
        "pairs": text(pairs, ONE_DECIMAL),
        "hardest": text(hardest.head(5), ONE_DECIMAL),
        "settings": text(settings.reset_index(names="setting"), ONE_DECIMAL),
        "bounds": text(
            bounds.reset_index(names="tolerance"), dict.fromkeys(("least", "median", "largest"), ".3f")
        ),
    }


def certificate(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the bound over the true error of random maps; the ratio where the reference resolves it."""
    solves = pd.DataFrame([solve for record in records for solve in record["solves"]])
    below = solves["bound"] < solves["true_error"] - solves["reference_error"]
    ratio = solves["ratio"][solves["resolved"]]
    row = {"solves": len(solves), "least": ratio.min(), "median": ratio.median(), "largest": ratio.max()}
    row |= {"bound below error": below.sum()}
    name = records[0]["name"]
    return {name: text(pd.DataFrame([row]), dict.fromkeys(("least", "median", "largest"), ".3f"))}


def made(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the pairs of made maps by size."""
    solves = solves_of(records)
    table = spread(pd.concat([solves, solves.assign(map="all")]).groupby(["error bound", "map"], sort=False))
    return {"made": text(table.reset_index(), ONE_DECIMAL)}


def hard(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the largest numbers of pairs on difficult maps."""
    solves = held_solves(records)
    default = solves[solves["way"] == "default"]
    table = (
        default.groupby(["map", "error bound"], sort=False)["pairs"].max().unstack()[list(BOUNDS.values())]
    )
    table["tolerance not reached"] = (~solves["converged"]).groupby(solves["map"]).sum()
    table["bound below error"] = solves["below"].groupby(solves["map"]).sum()
    return {"hard": text(table.reset_index(), ONE_DECIMAL)}


def growth(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the pairs by size of the map, and at 1e-4 how they grow."""
    rows = pd.DataFrame(
        [
            (
                "synthetic" if record["kind"] == "made" else record["kind"],
                record["load"],
                bound,
                record["size"],
                pairs,
            )
            for record in records
            for bound, pairs in zip(BOUNDS.values(), record["pairs"], strict=True)
        ],
        columns=["map", "p′", "error bound", "size", "pairs"],
    )
    table = rows.set_index(["map", "p′", "error bound", "size"])["pairs"].unstack()
    first_bound = table.index.get_level_values("error bound") == BOUNDS[1e-4]
    growth = (table.iloc[:, -1] / table.iloc[:, 0]).where(first_bound)
    table.columns = [f"{size}²" for size in table]
    table = table.sort_index(level="map", ascending=False, sort_remaining=False, kind="stable")
    growths = table.assign(growth=growth).reset_index()
    return {"growth": text(growths, dict.fromkeys(table, ".1f") | {"growth": ".2f"})}


def starts(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the times of installation and first process."""
    times = {what: 1000 * seconds for record in records for what, seconds in record.items()}
    return {"starts": text(pd.DataFrame({"what": times.keys(), "time (ms)": times.values()}))}


def pair(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the time of a solve over that of one pair of transforms."""
    return {"pair": text(pd.DataFrame(records), ONE_DECIMAL)}


def sweep(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the times of many loads in one call and in as many calls."""
    return {
        "sweep": text(
            pd.DataFrame(records), dict.fromkeys(("share of time (%)", "share of pairs (%)"), ".0f")
        )
    }


def memory(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the peak memory by code and size."""
    table = pd.DataFrame(records).pivot(index="code", columns="size", values="bytes_per_point")
    table = table.loc[list(dict.fromkeys(record["code"] for record in records))]
    table.columns = [f"{size}²" for size in table]
    return {"memory": text(table.reset_index(), dict.fromkeys(table, ".0f"))}


def agreement(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the largest true error of every code at a tight tolerance, by points and load."""
    table = pd.DataFrame(records).pivot_table("true_error", ["size", "load"], "code", aggfunc="max")
    return {"agreement": text(table.reset_index(), dict.fromkeys(table, ".0e"))}


PARTS = {
    part.__name__: part for part in (race, agreement, maps, made, hard, growth, starts, pair, sweep, memory)
}
PARTS |= dict.fromkeys(("random", "dense"), certificate)
