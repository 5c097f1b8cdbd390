"""The page of the benchmark: tables and a figure from the results that `speed.py` keeps.

python benchmarks/page.py benchmarks/work/results.json docs/explanation/benchmark.md
"""

import argparse
import json
import math
import statistics
from pathlib import Path

from cases import TRUE_ERROR

RIVALS = ("ASPHER", "Tamaas")
SINGLE = "roughcontact, single precision"
COLOURS = {"roughcontact": "#0b6e8f", "ASPHER": "#c8553d", "Tamaas": "#7a7a7a"}
MARKERS = "osD^vP"

PROBLEM = """\
**Problem.** A periodic self-affine surface with random phases, Hurst exponent 0.8, 4 to N/8 waves per side,
unit rms gradient, is pressed on an elastic half-space of E* = 1. **True error** is the relative L2 error of
the pressure against a solution with a certified error below 1e-10. Every code is timed at the loosest of its
own tolerances (a ladder of factor 2) that brings it below 1e-4; in brackets the error it then has. Ratios are
times of the other code over times of roughcontact (geometric mean over seeds). Times are medians of repeated
solves in warm processes, the codes taking turns: from heights in memory to the pressure, with whatever a
solve sets up anew. Every code solves the case, untimed, for half a second (once, if that takes longer) right
before each timed solve that takes less than 10 s: a process that has waited for the others' turns is slow at
first. ASPHER works in single precision where that suffices, the fastest of its configurations here,
roughcontact in double at the end, unless its column says otherwise; the wheel of Tamaas uses one thread."""

WORK = """\
Forward and inverse transform pairs to the true error, all grids and the preconditioner counted, one pair on a
grid a quarter the size counting a quarter. Growth is from the smallest to the largest size."""


def timed(solves: list[dict]) -> dict[tuple, dict]:
    """Return median seconds and largest true error per (threads, size, load, seed, code)."""
    groups = {}
    for solve in solves:
        if solve["purpose"] == "timed" and "failure" not in solve:
            key = tuple(solve[name] for name in ("threads", "size", "load", "seed", "code"))
            groups.setdefault(key, []).append(solve)
    return {
        key: {
            "seconds": statistics.median(solve["seconds"] for solve in group),
            "true_error": max(solve["true_error"] for solve in group),
            "repeats": len(group),
        }
        for key, group in groups.items()
    }


def ratios(solves: list[dict], rival: str, threads: int, *, own: str = "roughcontact") -> dict[tuple, float]:
    """Return seconds of `rival` over seconds of this solver for every case (size, load, seed)."""
    medians = timed(solves)
    return {
        key[1:4]: medians[key]["seconds"] / medians[*key[:4], own]["seconds"]
        for key in medians
        if key[0] == threads and key[4] == rival and (*key[:4], own) in medians
    }


def geometric_mean(values) -> float:
    return math.exp(statistics.fmean(math.log(value) for value in values))


def pairs_to_truth(solves: list[dict]) -> dict[tuple, dict]:
    """Return the solve on the loosest rung that meets the true error, per (size, load, seed)."""
    best = {}
    for solve in solves:
        if solve["code"] == "roughcontact" and solve.get("true_error", math.inf) <= TRUE_ERROR:
            key = (solve["size"], solve["load"], solve["seed"])
            if key not in best or solve["tolerance"] > best[key]["tolerance"]:
                best[key] = solve
    return best


def table(results: dict) -> str:
    """Return the table of times and ratios, one part for each number of threads."""
    medians = timed(results["solves"])
    codes = [code for code in ("roughcontact", SINGLE, *RIVALS) if any(key[4] == code for key in medians)]
    lines = []
    for threads in sorted({key[0] for key in medians}):
        lines += [
            f"**{threads} thread{'s' if threads > 1 else ''}**",
            "",
            f"| points | p̄/E* | seeds | {' | '.join(codes)} | ASPHER ratio | Tamaas ratio |",
            "| --- |" + " --- |" * (len(codes) + 4),
        ]
        cases = sorted({key[1:3] for key in medians if key[0] == threads})
        for size, load in cases:
            seeds = sorted({key[3] for key in medians if key[:3] == (threads, size, load)})
            cells = [f"{size}²", f"{load:g}", str(len(seeds))]
            for code in codes:
                group = [medians.get((threads, size, load, seed, code)) for seed in seeds]
                cells.append(_seconds([entry for entry in group if entry]))
            for rival in RIVALS:
                found = ratios(results["solves"], rival, threads)
                found = [value for (s, p, _), value in found.items() if (s, p) == (size, load)]
                cells.append(f"**{geometric_mean(found):.1f}**" if found else "-")
            lines.append("| " + " | ".join(cells) + " |")
        lines.append("")
        for rival, own in [(rival, own) for rival in RIVALS for own in ("roughcontact", SINGLE)]:
            found = ratios(results["solves"], rival, threads, own=own)
            if found:
                (size, load, seed), least = min(found.items(), key=lambda item: item[1])
                lines.append(
                    f"- {rival} / {own}: geometric mean **{geometric_mean(found.values()):.1f}** over "
                    f"{len(found)} cases, least **{least:.1f}** ({size}², p̄/E* = {load:g}, seed {seed})."
                )
        lines.append("")
    return "\n".join(lines)


def _seconds(entries: list[dict]) -> str:
    if not entries:
        return "-"
    seconds = statistics.median(entry["seconds"] for entry in entries)
    error = max(entry["true_error"] for entry in entries)
    return f"{seconds:.3g} s ({error:.0e})"


def work_table(results: dict) -> str:
    """Return the transform pairs to the true error against size."""
    best = pairs_to_truth(results["solves"])
    sizes = sorted({key[0] for key in best})
    lines = [
        "| p̄/E* | contact | " + " | ".join(f"{size}²" for size in sizes) + " | growth |",
        "| --- | --- |" + " --- |" * (len(sizes) + 1),
    ]
    for load in sorted({key[1] for key in best}):
        counts = {
            size: statistics.fmean(
                solve["operator_applications"] for key, solve in best.items() if key[:2] == (size, load)
            )
            for size in sizes
            if any(key[:2] == (size, load) for key in best)
        }
        share = statistics.fmean(solve["contact_share"] for key, solve in best.items() if key[1] == load)
        cells = [f"{load:g}", f"{share:.1%}"]
        cells += [f"{counts[size]:.0f}" if size in counts else "-" for size in sizes]
        cells.append(f"{counts[max(counts)] / counts[min(counts)]:.2f}" if len(counts) > 1 else "-")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _fastest(points: list[dict]) -> list[dict]:
    """Return one point per true error, the fastest: neighbouring rungs often end on the same iterate."""
    best = {}
    for point in sorted(points, key=lambda point: point["seconds"], reverse=True):
        best[f"{point['true_error']:.2e}"] = point
    return sorted(best.values(), key=lambda point: -point["true_error"])


def figure(results: dict, path: Path) -> None:
    """Draw run time against true error for every code and size, and work against size."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    solves = [solve for solve in results["solves"] if "failure" not in solve]
    threads = min(solve["threads"] for solve in solves)
    seed = solves[0]["seed"]
    loads = sorted({solve["load"] for solve in solves})
    ladders = [
        s for s in solves if s["threads"] == threads and s["seed"] == seed and s["purpose"] == "ladder"
    ]
    compared = [s for s in ladders if s["code"] != "roughcontact"] or ladders
    sizes = sorted({solve["size"] for solve in compared})
    fig, axes = plt.subplots(1, len(loads) + 1, figsize=(3.4 * (len(loads) + 1), 3.9), layout="constrained")
    for ax, load in zip(axes, loads, strict=False):
        for code, colour in COLOURS.items():
            for size, marker in zip(sizes, MARKERS, strict=False):
                points = [s for s in ladders if (s["code"], s["size"], s["load"]) == (code, size, load)]
                points = _fastest(points)
                if points:
                    ax.loglog(
                        [s["true_error"] for s in points],
                        [s["seconds"] for s in points],
                        color=colour,
                        marker=marker,
                        markersize=4,
                        linewidth=1,
                        label=f"{code} {size}²",
                    )
        ax.axvline(TRUE_ERROR, color="0.6", linewidth=0.8, linestyle=":")
        ax.invert_xaxis()
        ax.set_title(f"mean pressure {load:g} E*", fontsize=9)
        ax.set_xlabel("true error of the pressure")
        ax.grid(alpha=0.2)
    axes[0].set_ylabel("time of one solve / s")
    handles, labels = axes[0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    best = pairs_to_truth(solves)
    for load, marker in zip(loads, MARKERS, strict=False):
        points = sorted(
            (
                size,
                statistics.fmean(
                    s["operator_applications"] for k, s in best.items() if k[:2] == (size, load)
                ),
            )
            for size in {key[0] for key in best if key[1] == load}
        )
        axes[-1].plot(
            *zip(*points, strict=True), marker=marker, color=COLOURS["roughcontact"], label=f"{load:g} E*"
        )
    axes[-1].set_xscale("log", base=2)
    axes[-1].set_ylim(0, 1.5 * axes[-1].get_ylim()[1])  # room for the legend
    axes[-1].set_xlabel("points per side")
    axes[-1].set_ylabel("transform pairs")
    axes[-1].set_title("work of roughcontact to 1e-4", fontsize=9)
    axes[-1].legend(fontsize=8, frameon=False)
    axes[-1].grid(alpha=0.2)
    for ax in axes:
        ax.spines[["top", "right"]].set_visible(False)
        ax.tick_params(labelsize=8)
    fig.savefig(path, dpi=110)
    plt.close(fig)


def write(results: dict, path: Path) -> None:
    """Write the page, and its figure beside it."""
    drawing = path.with_suffix(".png")
    figure(results, drawing)
    machine = results["machine"]
    versions = "; ".join(
        ", ".join(f"{name} {number}" for name, number in group.items())
        for group in results["versions"].values()
    )
    parts = [
        "# Benchmark",
        (
            "Written by `python benchmarks/speed.py --page docs/explanation/benchmark.md`; see\n"
            "`benchmarks/README.md`."
        ),
        (
            f"**Machine.** {machine['processor']}, {machine['cores']} cores, {machine['memory_GiB']} GiB;\n"
            f"{machine['system']}, Python {machine['python']}. **Versions.** {versions}."
        ),
        PROBLEM,
        "## Time to a true error of 1e-4",
        table(results).strip(),
        f"![Run time against true error, and work against size]({drawing.name})",
        "Points of the figure are single solves, not rehearsed, and slower than the medians of the table.",
        "## Work",
        WORK,
        work_table(results),
    ]
    if results["sweeps"]:
        parts += [
            "## Sweep of loads",
            (
                "20 loads, spaced evenly on a log scale from 0.1 % to 95 % contact, to an error bound "
                "of 1e-4:\none call for all against 20 calls."
            ),
            _rows(
                ("points", "threads", "one call", "20 calls", "share of time", "share of pairs"),
                [
                    (
                        f"{sweep['size']}²",
                        sweep["threads"],
                        f"{sweep['seconds']:.3g} s",
                        f"{sweep['cold_seconds']:.3g} s",
                        f"{sweep['seconds'] / sweep['cold_seconds']:.0%}",
                        f"{sweep['operator_applications'] / sweep['cold_operator_applications']:.0%}",
                    )
                    for sweep in results["sweeps"]
                ],
            ),
        ]
    if results["memory"]:
        sizes = sorted({entry["size"] for entry in results["memory"]})
        codes = sorted({entry["code"] for entry in results["memory"]}, key=lambda code: code.lower())
        cells = {(entry["code"], entry["size"]): entry["bytes_per_pixel"] for entry in results["memory"]}
        parts += [
            "## Memory",
            (
                "Peak memory of one solve (p̄/E* = 0.03, one thread) above what the process held before it, "
                "in\nbytes per point; the heights that go in are not counted. "
                "One array in double precision is 8."
            ),
            _rows(
                ("code", *(f"{size}²" for size in sizes)),
                [
                    (code, *(f"{cells[code, n]:.0f}" if (code, n) in cells else "-" for n in sizes))
                    for code in codes
                ],
            ),
        ]
    if results["shortcuts"]:
        parts += [
            "## What is skipped, and what that saves",
            _rows(
                ("with the shortcut", "against", "seconds", "pairs", "times faster"),
                [
                    (
                        entry["shortcut"],
                        entry["against"],
                        f"{entry['with']['seconds']:.2g} / {entry['without']['seconds']:.2g}",
                        (
                            f"{entry['with']['operator_applications']:.3g} / "
                            f"{entry['without']['operator_applications']:.3g}"
                        ),
                        f"{entry['without']['seconds'] / entry['with']['seconds']:.1f}",
                    )
                    for entry in results["shortcuts"]
                ],
            ),
            f"On {results['shortcuts'][0]['size']}² points.",
        ]
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _rows(header: tuple, rows: list[tuple]) -> str:
    lines = ["| " + " | ".join(str(cell) for cell in row) + " |" for row in (header, *rows)]
    lines.insert(1, "|" + " --- |" * len(header))
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description="Write the page of the benchmark from stored results.")
    parser.add_argument("results", type=Path, help="results.json, written by speed.py")
    parser.add_argument("page", type=Path, help="Markdown file to write; the figure goes beside it")
    options = parser.parse_args()
    write(json.loads(options.results.read_text(encoding="utf-8")), options.page)


if __name__ == "__main__":
    main()
