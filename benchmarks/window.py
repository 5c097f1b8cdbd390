"""Compare the ways to make a cut-out periodic, and to place the window, with the truth.

    python benchmarks/window.py --write
    python benchmarks/window.py --quick      # a minute, too few windows to decide by

The truth is known where the map is cut out of a larger surface that is periodic: that one is solved whole.
Periodic surfaces of four kinds are cut into windows without rest, so that what one window has too much
another one has too little. Every window is made periodic by every method and solved twice: under the mean
pressure of the whole surface, as a user would do, and under the mean pressure that this very part carries on
the large surface, which leaves out most of the scatter between windows.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import get_args

import numpy as np
import pages
import pandas as pd
from scipy.ndimage import fourier_gaussian

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.choices import WindowMethod
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.statistics.contact_geometry import PERIMETER_CORRECTION
from validation.masters import grooves

METHODS = get_args(WindowMethod)
KINDS = ("isotropic", "anisotropic", "turned", "bimodal")
LOADS = (0.02, 0.1, 0.4)  # mean pressure / (E* rms gradient)
TOLERANCE = 1e-3
KINDS_LOAD = 0.1  # of the table by kind of surface
RATIOS = ["area, same load", "peak", "gradient", "rim"]  # to the true values
RIM = 0.03  # of each side, at both ends
FIRST_SEED = 50
MARKS = {"area, same load": 0.01, "peak": 0.1, "rim": 0.1}  # what a good method keeps
PARTS = ("methods", "placements")
DEFECTS = ("", "hole", "bump")
DEFECT_WIDTH = 0.2  # of a hole or a bump over the least side
BUMP_HEIGHT = 3.0  # over the rms height


def master(kind: str, seed: int, points: int, *, longest: float | None = None, shortest: float = 8.0):
    """Return a periodic surface of unit pitch and unit rms gradient, points x points.

    isotropic: self-affine, Hurst exponent 0.8, waves up to `longest`, or half of the side; anisotropic: up to
    half of that, six times as long along y; turned: parabolic grooves of scattered depth along y,
    self-affine roughness on them; bimodal: fine roughness on long waves that carry nearly all of the height.
    """
    shape = (points, points)
    longest = longest or points / 2

    def waves(first, last, seed=seed, **options):
        options = {"rms_height": 1.0} | options
        return self_affine_surface(
            shape, 1.0, hurst=0.8, shortest=first, longest=last, seed=seed, **options
        ).values

    if kind == "isotropic":
        heights = waves(shortest, longest)
    elif kind == "anisotropic":
        heights = waves(shortest, longest / 2, stretch=6.0)
    elif kind == "turned":
        count = round(points / (4.7 * shortest))  # a whole number of grooves
        turned = grooves(points, count, 0.1, np.random.default_rng(seed))
        heights = waves(shortest, 8 * shortest, rms_height=0.25) + turned
        heights = np.fft.ifft2(fourier_gaussian(np.fft.fft2(heights), shortest / 4)).real
    else:
        heights = waves(12.5 * shortest, 32 * shortest) + waves(
            shortest, 3 * shortest, seed=seed + 1000, rms_height=0.1
        )
    surface = height_map(heights - heights.mean(), 1.0)
    return surface / rms_gradient(surface)


def solve(window, loads) -> np.ndarray:
    """Return the pressures (load, y, x) over E*; zero where the load is."""
    loads = np.asarray(loads, dtype=float)
    pressure = np.zeros((loads.size, *window.shape))
    some = loads > 1e-4
    if some.any():
        contact = rc.solve_contact(
            window, contact_modulus=1.0, mean_pressure=list(loads[some]), tolerance=TOLERANCE
        )
        pressure[some] = contact["pressure"].values
    return pressure


def area(pressure, *, periodic=True) -> float:
    """Return the contact area, corrected by the perimeter, in parts of the whole."""
    touching = np.pad(pressure > 0, (0, 1), mode="wrap" if periodic else "edge")
    switches = np.diff(touching[:, :-1], axis=0).sum() + np.diff(touching[:-1], axis=1).sum()
    return (np.count_nonzero(pressure > 0) - PERIMETER_CORRECTION * switches) / pressure.size


def rim_load(pressure) -> float:
    """Return the mean pressure on the rim, the outer 3 % of each side at both ends."""
    width = [max(1, round(RIM * n)) for n in pressure.shape]
    rim = np.ones(pressure.shape, dtype=bool)
    rim[width[0] : -width[0], width[1] : -width[1]] = False
    return float(pressure[rim].mean())


def compare_methods(kind, seed, *, points, side) -> list[dict]:
    """Return a row for each window, method and load of one periodic surface."""
    surface = master(kind, seed, points)
    truth = solve(surface, LOADS)
    whole = [area(pressure) for pressure in truth]
    rows = []
    for y0 in range(0, points, side):
        for x0 in range(0, points, side):
            levelled = rc.level(surface[y0 : y0 + side, x0 : x0 + side], outlier_threshold=None)
            for method in METHODS:
                window = rc.periodic_window(levelled, method=method)
                images = 2 if method == "mirror" else 1
                size = [n // images for n in window.shape]
                top, left = (round(window.attrs[f"window_offset_{axis}"]) for axis in "yx")
                part = truth[:, y0 + top :, x0 + left :][:, : size[0], : size[1]]
                carried = part.mean(axis=(1, 2))
                given, same = solve(window, LOADS), solve(window, carried)
                for i, load in enumerate(LOADS):
                    own = given[i, : size[0], : size[1]]
                    rows.append(
                        {
                            "kind": kind,
                            "seed": seed,
                            "method": method,
                            "load": load,
                            "area": area(given[i]) / whole[i],
                            "same_area": area(same[i]),
                            "part_area": area(part[i], periodic=False),
                            "peak": float(own.max() / part[i].max()) if part[i].any() and own.any() else None,
                            "gradient": float(window.attrs["rms_gradient_after"]),
                            "rim": rim_load(own) / load,
                            "part_rim": rim_load(part[i]) / load,
                        }
                    )
    return rows


def natural_windows(kind, seeds, *, points, side, whole) -> list[dict]:
    """Return rows for windows that are periodic by nature: what the size alone does.

    They hold the same waves as a surface of `points` x `points`, as far as these fit in.
    """
    rows = []
    for seed in seeds:
        pressure = solve(master(kind, seed, side, longest=points / 2), LOADS)
        rows += [
            {"kind": kind, "method": "periodic by nature", "load": load, "area": area(p) / a}
            for load, p, a in zip(LOADS, pressure, whole, strict=True)
        ]
    return rows


def compare_placements(kind, seed, *, points, side, defect="") -> list[dict]:
    """Return a row for each map and way to place the window: the largest rectangle, or a search."""
    surface = master(kind, seed, points)
    truth = area(solve(surface, [0.1])[0])
    generator = np.random.default_rng([7, seed])
    rows = []
    for _ in range(8):
        ny, nx = generator.integers(side, round(1.3 * side), 2)
        rolled = surface.roll(y=generator.integers(points), x=generator.integers(points))
        measured = height_map(rolled.values[:ny, :nx], 1.0)
        if defect:
            y, x = np.indices(measured.shape)
            cy, cx = (generator.uniform(0, n) for n in measured.shape)
            distance = np.hypot(y - cy, x - cx) / (DEFECT_WIDTH * side / 2)
            height = np.nan if defect == "hole" else BUMP_HEIGHT * measured.values.std() * (1 - distance**2)
            values = np.where(distance < 1, measured.values + height, measured.values)
            measured = height_map(values, 1.0)
        levelled = rc.level(measured, outlier_threshold=None)
        for placement in ("largest", "search"):
            begin = time.perf_counter()
            window = rc.periodic_window(levelled, placement=placement)
            placing = time.perf_counter() - begin
            begin = time.perf_counter()
            pressure = solve(window, [0.1])[0]
            rows.append(
                {
                    "kind": f"{kind}, {defect}" if defect else kind,
                    "placement": placement,
                    "area": area(pressure) / truth,
                    "gradient": float(window.attrs["rms_gradient_after"]),
                    "points": window.size / measured.size,
                    "placing": placing,
                    "solving": time.perf_counter() - begin,
                }
            )
    return rows


def run(part, *, points, side, seeds, say=print) -> list[dict]:
    """Return the rows of one comparison, "methods" or "placements"."""
    rows = []
    for kind in KINDS:
        for seed in seeds:
            begin = time.perf_counter()
            if part == "methods":
                rows += compare_methods(kind, seed, points=points, side=side)
            else:
                for defect in DEFECTS:
                    rows += compare_placements(kind, seed, points=points, side=side, defect=defect)
            say(f"{part}, {kind}, seed {seed}: {time.perf_counter() - begin:.0f} s", flush=True)
        if part == "methods":  # as many windows as were cut out
            whole = [area(p) for p in solve(master(kind, seeds[0], points), LOADS)]
            more = range(1000, 1000 + len(seeds) * (points // side) ** 2)
            rows += natural_windows(kind, more, points=points, side=side, whole=whole)
    return rows


def summary(rows: pd.DataFrame, by: list[str]) -> pd.DataFrame:
    """Return area, its scatter, and the ratios to the true values, of the windows of each group."""
    groups = rows.groupby(by, sort=False)
    sums = groups.sum(min_count=1, numeric_only=True)
    return pd.DataFrame(
        {
            "area, same load": sums["same_area"] / sums["part_area"],
            "area": groups["area"].mean(),
            "scatter": groups["area"].std(ddof=0),
            "peak": groups["peak"].median(),
            "gradient": groups["gradient"].mean(),
            "rim": sums["rim"] / sums["part_rim"],
        }
    )


def misses(rows: pd.DataFrame) -> pd.DataFrame:
    """Return how far each method is from the truth: rms over kinds and loads."""
    found = summary(rows[rows["same_area"].notna()], ["kind", "load", "method"])
    off = found[RATIOS] - 1
    return (off**2).groupby("method", sort=False).mean() ** 0.5


def best_method(missed: pd.DataFrame) -> str:
    """Return the method with the least sum of squared misses in units of the marks.

    Left out is `mirror`, which solves a larger map than was measured.
    """
    return str((missed[list(MARKS)] / pd.Series(MARKS)).pow(2).sum(axis=1).drop("mirror").idxmin())


def placement_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return area, scatter and error of both placements, and the cost of the search, by kind of map."""
    found = {}
    for placement in ("largest", "search"):
        areas = rows[rows["placement"] == placement].groupby("kind", sort=False)["area"]
        found[f"area, {placement}"] = areas.mean()
        found[f"scatter, {placement}"] = areas.std(ddof=0)
        found[f"error, {placement} (%)"] = areas.agg(rms_error)
    found["cost of the search"] = {kind: search_cost(some) for kind, some in rows.groupby("kind", sort=False)}
    return pd.DataFrame(found).reset_index(names="maps")


def rms_error(areas) -> float:
    """Return the rms error of areas over the true one, in percent."""
    return float(100 * np.sqrt(np.mean((areas - 1) ** 2)))


def search_cost(rows: pd.DataFrame) -> float:
    """Return the time of the search beyond that of the largest rectangle, over one solve (medians)."""
    placing = rows.groupby("placement")["placing"].median()
    return float((placing["search"] - placing["largest"]) / rows["solving"].median())


def tables(results: dict) -> dict[str, pd.DataFrame]:
    """Return the tables of the page."""
    methods, placements = (pd.DataFrame(results[part]["rows"]) for part in PARTS)
    forms = dict.fromkeys(("area, same load", "area", "scatter"), ".3f") | dict.fromkeys(RATIOS[1:], ".2f")
    cut = methods[methods["same_area"].notna()].sort_values("load", kind="stable")
    by_load = summary(cut, ["load", "method"])
    by_kind = summary(methods[methods["load"] == KINDS_LOAD], ["kind", "method"])
    placed = placement_table(placements)
    percent = (100 * misses(methods)).add_suffix(" (%)")
    decimals = {name: ".1f" if "%" in name else ".2f" if "cost" in name else ".3f" for name in placed}
    return {
        "methods": pages.text(by_load.reset_index(names=["p̄ / E* g", "method"]), forms),
        "kinds": pages.text(by_kind.reset_index(names=["surface", "method"]), forms),
        "misses": pages.text(percent.reset_index(), dict.fromkeys(percent, ".1f")),
        "placements": pages.text(placed, decimals),
    }


def about(results: dict) -> dict:
    """Return sizes, and which method and placement is nearest to the truth."""
    methods, placements = (pd.DataFrame(results[part]["rows"]) for part in PARTS)
    side = results["placements"]["side"]
    areas = {placement: some["area"].values for placement, some in placements.groupby("placement")}
    gain = (areas["search"] - 1) ** 2 - (areas["largest"] - 1) ** 2
    uncertainty = gain.std(ddof=1) / np.sqrt(gain.size)
    nearer = "search" if gain.mean() < 0 else "largest"
    return {
        "points": results["methods"]["points"],
        "side": side,
        "surfaces of each kind": results["methods"]["seeds"],
        "windows": int(methods.groupby(["method", "load"]).size().iloc[0]),
        "nearest method": best_method(misses(methods)),
        "maps": gain.size,
        "longest side": round(1.3 * side),
        "defect": round(DEFECT_WIDTH * side),
        "error, largest (%)": f"{rms_error(areas['largest']):.2f}",
        "error, search (%)": f"{rms_error(areas['search']):.2f}",
        "cost of the search": f"{search_cost(placements):.2f}",
        "squared error, search less largest (1e-4)": f"{1e4 * gain.mean():.1f}",
        "standard error (1e-4)": f"{1e4 * uncertainty:.1f}",
        "nearer placement": nearer if abs(gain.mean()) >= 2 * uncertainty else "neither",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--write", action="store_true", help="write tables and page; else print")
    parser.add_argument("--parts", nargs="*", default=list(PARTS), choices=PARTS, help="what is measured")
    parser.add_argument("--seeds", type=int, default=5, help="surfaces of each kind (default %(default)s)")
    parser.add_argument("--quick", action="store_true", help="small surfaces, one of each kind")
    parser.add_argument(
        "--results",
        type=Path,
        default=Path(__file__).parent / "work" / "window.json",
        help="JSON file in which the rows are kept; parts that are not measured again stay (%(default)s)",
    )
    options = parser.parse_args()
    results = json.loads(options.results.read_text("utf-8")) if options.results.is_file() else {}
    size = {"points": 256, "side": 128} if options.quick else {"points": 1024, "side": 256}
    # not those that parameters were found with
    seeds = range(FIRST_SEED, FIRST_SEED + (1 if options.quick else options.seeds))
    for part in options.parts:
        results[part] = size | {"seeds": len(seeds), "rows": run(part, seeds=seeds, **size)}
        options.results.parent.mkdir(parents=True, exist_ok=True)
        options.results.write_text(json.dumps(results), encoding="utf-8")
    if options.write:
        pages.publish("window", tables(results), about(results))
    else:
        pages.show(tables(results))


if __name__ == "__main__":
    main()
