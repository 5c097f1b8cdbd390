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
from roughcontact.arguments.choices import Placement, WindowMethod
from roughcontact.arguments.maps import height_map
from roughcontact.statistics.contact_geometry import PERIMETER_CORRECTION
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import self_affine_surface
from validation.masters import grooves

METHODS = get_args(WindowMethod)
KINDS = ("isotropic", "anisotropic", "turned", "bimodal")
REPEATING = ("feed marks", "ground", "dimples")  # textures with a period; of placements alone
PERIOD = 36.5  # points, of feed marks and dimples, about: a window of 256 points has seven of them
LOADS = (0.02, 0.1, 0.4)  # mean pressure / (E* rms gradient)
TOLERANCE = 1e-3
KINDS_LOAD = 0.1  # of the table by kind of surface
RATIOS = ["area, same load", "peak", "gradient", "rim"]  # to the true values
RIM = 0.03  # of each side, at both ends
FIRST_SEED = 50
MARKS = {"area, same load": 0.01, "peak": 0.1, "rim": 0.1}  # what a good method keeps
PARTS = ("methods", "placements")
PLACEMENTS = get_args(Placement)


def master(kind: str, seed: int, points: int, *, longest: float | None = None, shortest: float = 8.0):
    """Return a periodic surface of unit pitch and unit rms gradient, points x points.

    isotropic: self-affine, Hurst exponent 0.8, waves up to `longest`, or half of the side; anisotropic: up to
    half of that, six times as long along y; turned: parabolic grooves of scattered depth along y,
    self-affine roughness on them; bimodal: fine roughness on long waves that carry nearly all of the height;
    feed marks: equal parabolic grooves along y, roughness on them; ground: roughness forty times as long
    along y; dimples: equal pits on a square lattice in a rough plane.
    """
    shape = (points, points)
    longest = longest or points / 2

    def waves(shortest, last, seed=seed, **options):
        options = {"rms_height": 1.0} | options
        return self_affine_surface(
            shape, 1.0, hurst=0.8, shortest=shortest, longest=last, seed=seed, **options
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
    elif kind == "feed marks":
        equal = grooves(points, round(points / PERIOD), 0.0, np.random.default_rng(seed))
        heights = waves(shortest, 8 * shortest, rms_height=0.1) + equal
        heights = np.fft.ifft2(fourier_gaussian(np.fft.fft2(heights), shortest / 4)).real
    elif kind == "ground":
        heights = waves(shortest, longest / 2, stretch=40.0)
    elif kind == "dimples":
        count = round(points / PERIOD)
        phase = np.arange(points) * count / points % 1 - 0.5
        radius = np.hypot(phase[:, None], phase[None, :]) / 0.3
        heights = waves(shortest, 8 * shortest, rms_height=0.1) - 2 * np.clip(1 - radius**2, 0, None)
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
    is_loaded = loads > 1e-4
    if is_loaded.any():
        contact = rc.solve_contact(
            window, contact_modulus=1.0, mean_pressure=list(loads[is_loaded]), tolerance=TOLERANCE
        )
        pressure[is_loaded] = contact["pressure"].values
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
    areas = [area(pressure) for pressure in truth]
    rows = []
    for y0 in range(0, points, side):
        for x0 in range(0, points, side):
            levelled = rc.level(surface[y0 : y0 + side, x0 : x0 + side], outlier_threshold=None)
            for method in METHODS:
                window = rc.periodic_window(levelled, method=method)
                images = 2 if method == "mirror" else 1
                size = [n // images for n in window.shape]
                top, left_column = (round(window.attrs[f"window_offset_{axis}"]) for axis in "yx")
                part = truth[:, y0 + top :, x0 + left_column :][:, : size[0], : size[1]]
                carried = part.mean(axis=(1, 2))
                pressure, same = solve(window, LOADS), solve(window, carried)
                for i, load in enumerate(LOADS):
                    window_pressure = pressure[i, : size[0], : size[1]]
                    rows.append(
                        {
                            "kind": kind,
                            "seed": seed,
                            "method": method,
                            "load": load,
                            "area": area(pressure[i]) / areas[i],
                            "same_area": area(same[i]),
                            "part_area": area(part[i], periodic=False),
                            "peak": float(window_pressure.max() / part[i].max())
                            if part[i].any() and window_pressure.any()
                            else None,
                            "gradient": float(window.attrs["rms_gradient_after"]),
                            "rim": rim_load(window_pressure) / load,
                            "part_rim": rim_load(part[i]) / load,
                        }
                    )
    return rows


def natural_windows(kind, seeds, *, points, side, areas) -> list[dict]:
    """Return rows for windows that are periodic by nature: what the size alone does.

    They hold the same waves as a surface of `points` x `points`, as far as these fit in.
    """
    rows = []
    for seed in seeds:
        pressure = solve(master(kind, seed, side, longest=points / 2), LOADS)
        rows += [
            {"kind": kind, "method": "periodic by nature", "load": load, "area": area(p) / a}
            for load, p, a in zip(LOADS, pressure, areas, strict=True)
        ]
    return rows


def compare_placements(kind, seed, *, points, side) -> list[dict]:
    """Return a row for each map, cut out at random, and way to place the window."""
    surface = master(kind, seed, points)
    truth = area(solve(surface, [0.1])[0])
    generator = np.random.default_rng([7, seed])
    rows = []
    for _ in range(8):
        ny, nx = generator.integers(side, round(1.3 * side), 2)
        rolled = surface.roll(y=generator.integers(points), x=generator.integers(points))
        measured = height_map(rolled.values[:ny, :nx], 1.0)
        levelled = rc.level(measured, outlier_threshold=None)
        for placement in PLACEMENTS:
            window = rc.periodic_window(levelled, placement=placement)
            pressure = solve(window, [0.1])[0]
            rows.append(
                {
                    "kind": kind,
                    "placement": placement,
                    "area": area(pressure) / truth,
                    "gradient": float(window.attrs["rms_gradient_after"]),
                    "points": window.size / measured.size,
                }
            )
    return rows


def run(part, *, points, side, seeds, say=print) -> list[dict]:
    """Return the rows of one comparison, "methods" or "placements"."""
    rows = []
    for kind in KINDS if part == "methods" else (*KINDS, *REPEATING):
        for seed in seeds:
            start = time.perf_counter()
            if part == "methods":
                rows += compare_methods(kind, seed, points=points, side=side)
            else:
                rows += compare_placements(kind, seed, points=points, side=side)
            say(f"{part}, {kind}, seed {seed}: {time.perf_counter() - start:.0f} s", flush=True)
        if part == "methods":  # as many windows as were cut out
            areas = [area(p) for p in solve(master(kind, seeds[0], points), LOADS)]
            further_seeds = range(1000, 1000 + len(seeds) * (points // side) ** 2)
            rows += natural_windows(kind, further_seeds, points=points, side=side, areas=areas)
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
    deviations = summary(rows[rows["same_area"].notna()], ["kind", "load", "method"])
    deviation = deviations[RATIOS] - 1
    return (deviation**2).groupby("method", sort=False).mean() ** 0.5


def best_method(missed: pd.DataFrame) -> str:
    """Return the method with the least sum of squared misses in units of the marks.

    Left out is `mirror`, which solves a larger map than was measured.
    """
    return str((missed[list(MARKS)] / pd.Series(MARKS)).pow(2).sum(axis=1).drop("mirror").idxmin())


def placement_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return mean and error of the area by both placements, and by how much their squares differ, by kind."""
    return pd.DataFrame(
        [placement_row(kind, rows_of_kind) for kind, rows_of_kind in rows.groupby("kind", sort=False)]
    )


def placement_row(kind: str, rows: pd.DataFrame) -> dict:
    """Return the row of one kind; `gain` is the difference of the squared errors of a map, over its error."""
    areas = {name: rows[rows["placement"] == name]["area"].values for name in PLACEMENTS}
    gain = (areas["largest"] - 1) ** 2 - (areas["whole-periods"] - 1) ** 2
    scatter = gain.std(ddof=1) / np.sqrt(gain.size)
    return (
        {"maps": kind}
        | {f"area, {name}": values.mean() for name, values in areas.items()}
        | {f"error, {name} (%)": rms_error(values) for name, values in areas.items()}
        | {"gain over its standard error": gain.mean() / scatter if scatter else 0.0}
    )


def rms_error(areas) -> float:
    """Return the rms error of areas over the true one, in percent."""
    return float(100 * np.sqrt(np.mean((areas - 1) ** 2)))


def method_tables(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the tables of the methods."""
    forms = dict.fromkeys(("area, same load", "area", "scatter"), ".3f") | dict.fromkeys(RATIOS[1:], ".2f")
    cut = rows[rows["same_area"].notna()].sort_values("load", kind="stable")
    by_load = summary(cut, ["load", "method"])
    by_kind = summary(rows[rows["load"] == KINDS_LOAD], ["kind", "method"])
    percent = (100 * misses(rows)).add_suffix(" (%)")
    return {
        "methods": pages.text(by_load.reset_index(names=["p̄ / E* g", "method"]), forms),
        "kinds": pages.text(by_kind.reset_index(names=["surface", "method"]), forms),
        "misses": pages.text(percent.reset_index(), dict.fromkeys(percent, ".1f")),
    }


def tables(results: dict) -> dict[str, pd.DataFrame]:
    """Return the tables of the parts that were measured."""
    tables_by_name = method_tables(pd.DataFrame(results["methods"]["rows"])) if "methods" in results else {}
    if "placements" in results:
        placed = placement_table(pd.DataFrame(results["placements"]["rows"]))
        decimals = {name: ".3f" if name.startswith("area") else ".1f" for name in placed.columns[1:]}
        tables_by_name["placements"] = pages.text(placed, decimals)
    return tables_by_name


def about(results: dict) -> dict:
    """Return sizes, the nearest method, and numbers of maps, of the parts that were measured."""
    facts_found: dict = {}
    if "methods" in results:
        methods = pd.DataFrame(results["methods"]["rows"])
        facts_found |= {
            "points": results["methods"]["points"],
            "side": results["methods"]["side"],
            "surfaces of each kind": results["methods"]["seeds"],
            "windows": int(methods.groupby(["method", "load"]).size().iloc[0]),
            "nearest method": best_method(misses(methods)),
        }
    if "placements" in results:
        placements = pd.DataFrame(results["placements"]["rows"])
        facts_found |= {
            "maps of each kind": int(placements.groupby(["kind", "placement"]).size().iloc[0]),
            "longest side": round(1.3 * results["placements"]["side"]),
        }
    return facts_found


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
        facts = pages.RESULTS / "window/about.json"
        facts_kept = json.loads(facts.read_text("utf-8")) if facts.is_file() else {}
        pages.publish("window", tables(results), facts_kept | about(results))
    else:
        pages.show(tables(results))


if __name__ == "__main__":
    main()
