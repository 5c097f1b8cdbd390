"""The page of the benchmark of speed, its figure, and the sentence of it in the README."""

import math
import re
import statistics
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

RIVALS = ("ASPHER", "Tamaas")
COLOURS = {"roughcontact": "#0b6e8f", "ASPHER": "#c8553d", "Tamaas": "#7a7a7a"}
BEGIN, END = "<!-- speed: written by benchmarks/speed.py -->", "<!-- end of speed -->"
COMMAND = "python benchmarks/speed.py FOLDER ... --page docs/explanation/benchmark.md --readme README.md"
HARDEST = 5
QUIET = 2.5  # load average: more than an earlier part of the measurement leaves behind
TRIED = Path(__file__).with_name("tried.md")  # written by hand: trials leave no records
AS_IT_IS = ("#", "|", "- ", "![")  # paragraphs that are not prose

RACE = """\
Every code solves the same square periodic maps on an elastic half-space and is timed at the loosest of its
own tolerances, a factor of 2 apart, that brings its pressure within 1e-4 of the truth (relative L2 error;
the truth is a solution with a proven error below 1e-10, to which all three converge:
`benchmarks/agreement.py`). Times are medians of repeated solves in warm processes, the codes taking turns,
from heights in memory to the pressure, with whatever a solve sets up anew. Each code solves the case,
untimed, for half a second right before a timed solve of less than 2 s: a process that has waited for the
others is slow at first. *Made × n* are self-affine maps, Hurst exponent 0.8, 4 to N/8 waves per
side; times and ratios are geometric means over n of them with other random phases. Measured maps are the
largest square in the middle of each file, levelled and made periodic by default. p′ = p̄ / (E\\* g),
where g is the rms gradient. ASPHER works in single precision where that suffices, the fastest of its
settings here; roughcontact ends in double; the wheel of Tamaas uses one thread, and sides of more than
512 points would take it minutes."""

PAIRS = """\
A pair is one forward and one inverse Fourier transform of the map, by far the longest part of a solve. All
are counted: those of the preconditioner, of coarse grids (by their share of the points) and of the set-up.
An iteration takes two, one for the displacement and one for the preconditioner, so that the numbers go in
steps of two. The tolerance is that of the proven error bound."""

GPU = """\
The solver also takes arrays of CuPy and of other libraries that keep to the array API, and computes where
they are. No GPU could be had for this benchmark: what one gains is not measured."""


def write(results: dict, path: Path) -> None:
    """Write the page, and its figure beside it."""
    drawing = path.with_suffix(".png")
    figure(results, drawing)
    path.write_text(page(results, drawing.name), encoding="utf-8")


def write_sentence(results: dict, path: Path) -> None:
    """Put the sentence of speed between its marks in a file."""
    text = path.read_text(encoding="utf-8")
    if not re.search(f"{BEGIN}.*{END}", text, re.DOTALL):
        raise ValueError(f"{path} has no lines {BEGIN} and {END}")
    before, _, rest = text.partition(BEGIN)
    path.write_text(f"{before}{BEGIN}\n{sentence(results)}\n{END}{rest.partition(END)[2]}", encoding="utf-8")


def page(results: dict, drawing: str) -> str:
    """Return the page as text."""
    about = results["about"]
    machine = about["machine"]
    versions = "; ".join(
        ", ".join(f"{name} {number}" for name, number in group.items())
        for group in about.get("versions", {}).values()
    )
    parts = [
        "# Benchmark",
        f"""Written by `{COMMAND}`, FOLDER being any folders of measured maps; `benchmarks/README.md` says
        how to repeat it, in pieces too.""",
        sentence(results),
        f"""**Machine.** {machine["processor"]}, {machine["cores"]} cores, {machine["memory_GiB"]} GiB;
        {machine["system"]}, Python {machine["python"]}. **Versions.** {versions}.""",
    ]
    if load := busy(results):
        parts.append(
            f"""Other programs ran when the times were taken (load average {load:.0f} before the start): on a
            machine at rest they are shorter, and ratios may differ."""
        )
    if results.get("race") or results.get("maps"):
        parts.append(f"![Time of one load by size of the map, and work on measured maps]({drawing})")
    for name, section in SECTIONS.items():
        if results.get(name):
            parts += section(list(results[name].values()))
    parts += ["## On a GPU", GPU]
    parts += [
        "## What is not met, and what was tried",
        *TRIED.read_text(encoding="utf-8").strip().split("\n\n"),
    ]
    return "\n\n".join(part if part.startswith(AS_IT_IS) else wrapped(part) for part in parts) + "\n"


def sentence(results: dict) -> str:
    """Return what page and README say of the speed; no times that were taken on a busy machine."""
    words = []
    timed = [] if busy(results) else list(results.get("race", {}).values())
    largest = max((case["size"] for case in timed if case["group"] == "made"), default=0)
    if shown := chosen(timed, threads=1, group="made", size=min(1024, largest)):
        own = statistics.median(case["codes"]["roughcontact"]["seconds"] for case in shown)
        size = shown[0]["size"]
        words.append(f"One load on a map of {size} × {size} points takes {seconds(own)} on one thread.")
    if compared := {rival: found for rival in RIVALS if (found := ratios(timed, rival, 1))}:
        times = " and ".join(
            f"{rival} takes {geometric_mean(found.values()):.2g} times" for rival, found in compared.items()
        )
        cases = " and ".join(str(len(found)) for found in compared.values())
        words.append(f"To the same true error {times} as long (geometric means over {cases} maps and loads).")
    if solves := default_solves(results.get("maps", {}).values(), 1e-4):
        pairs = [solve["pairs"] for solve in solves]
        words.append(
            f"""On {len(results["maps"])} measured maps a load takes a median of {np.median(pairs):.1f}
            pairs of Fourier transforms to a proven error of 1e-4 (90 % of them at most
            {np.quantile(pairs, 0.9):.1f}, all at most {max(pairs):.1f})."""
        )
    return wrapped(" ".join(words))


def busy(results: dict) -> float:
    """Return the load average before the times were taken, where it says that other programs ran; else 0."""
    load = max(results["about"].get("load", {}).values(), default=0.0)
    return load if load > QUIET else 0.0


def wrapped(text: str, width: int = 110) -> str:
    """Return words in lines of limited length."""
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) >= width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)


def chosen(records: Iterable[dict], **wanted) -> list[dict]:
    """Return the records that have the wanted values."""
    return [record for record in records if all(record[name] == value for name, value in wanted.items())]


def geometric_mean(values) -> float:
    """Return the geometric mean."""
    return math.exp(statistics.fmean(math.log(value) for value in values))


def ratios(timed: Iterable[dict], rival: str, threads: int) -> dict[tuple, float]:
    """Return seconds of `rival` over those of this solver by (name, load) of the case."""
    return {
        (case["name"], case["load"]): case["codes"][rival]["seconds"]
        / case["codes"]["roughcontact"]["seconds"]
        for case in chosen(timed, threads=threads)
        if {rival, "roughcontact"} <= case["codes"].keys()
    }


def race_section(timed: list[dict]) -> list[str]:
    """Return the tables of times, one for each number of threads."""
    parts = ["## Time to a true error of 1e-4", RACE]
    for threads in sorted({case["threads"] for case in timed}):
        here = chosen(timed, threads=threads)
        codes = [code for code in COLOURS if any(code in case["codes"] for case in here)]
        rivals = [code for code in codes if code in RIVALS]
        groups: dict[tuple, list[dict]] = {}
        for case in here:
            name = "made" if case["group"] == "made" else case["name"]
            groups.setdefault((case["group"], case["size"], name, case["load"]), []).append(case)
        rows = []
        for (_, size, name, load), group in sorted(groups.items()):
            own = [case["codes"]["roughcontact"]["seconds"] for case in group]
            shown = f"made × {len(group)}" if name == "made" else named(name)
            row = [shown, f"{size}²", f"{load:g}", seconds(geometric_mean(own))]
            for code in rivals:
                found = [case["codes"][code]["seconds"] for case in group if code in case["codes"]]
                row.append(seconds(geometric_mean(found)) if len(found) == len(group) else "–")
            for code in rivals:
                found = list(ratios(group, code, threads).values())
                row.append(f"**{geometric_mean(found):.1f}**" if len(found) == len(group) else "–")
            rows.append(row)
        parts += [
            f"**{threads} thread{'s' if threads > 1 else ''}**",
            table(("map", "points", "p′", *codes, *(f"{code} ratio" for code in rivals)), rows),
            "\n".join(line for rival in rivals for line in comparison(here, rival, threads)),
        ]
    return [*parts, slowest_ratio(timed)]


def comparison(timed: list[dict], rival: str, threads: int) -> list[str]:
    """Return what the ratios to a code come to, on made maps, on measured ones and on all."""
    lines = []
    for group in ("made", "measured", None):
        found = ratios(chosen(timed, group=group) if group else timed, rival, threads)
        if found:
            (name, load), least = min(found.items(), key=lambda item: item[1])
            lines.append(
                f"- {rival} / roughcontact, {group or 'all'} maps: geometric mean "
                f"**{geometric_mean(found.values()):.1f}** over {len(found)} cases, least **{least:.1f}** "
                f"({named(name)}, p′ = {load:g})."
            )
    return lines if len(lines) > 2 else lines[:1]


def named(name: str) -> str:
    """Return the name of a case in words."""
    if made := re.fullmatch(r"made (\d+) (\d+)", name):
        return f"made, {made[1]}², seed {made[2]}"
    return name.replace("_", "\\_")


def slowest_ratio(timed: list[dict]) -> str:
    """Return why some ratios are smaller."""
    small = min(case["size"] for case in timed)
    return f"""The ratio grows with the map and the load: the number of iterations of the others does, this
solver's does not. It is least on small maps ({small}²), where setting up the grids and labelling
the result weigh as much as the transforms, and at low loads, where the others need few
iterations. Grids of fewer than 32 768 points take one thread, whatever is allowed."""


def default_solves(maps: Iterable[dict], tolerance: float) -> list[dict]:
    """Return the solves by default settings."""
    return [
        s for found in maps for s in found["solves"] if (s["way"], s["tolerance"]) == ("default", tolerance)
    ]


def spread(values: Sequence[float]) -> str:
    """Return median, 90 % quantile and largest value."""
    return f"{np.median(values):.1f} / {np.quantile(values, 0.9):.1f} / {max(values):.1f}"


def maps_section(maps: list[dict]) -> list[str]:
    """Return the tables of the work on measured maps, and of what the bound is worth on them."""
    loads = sorted({solve["load"] for found in maps for solve in found["solves"]})
    rows = []
    for tolerance in (1e-4, 1e-8):
        solves = default_solves(maps, tolerance)
        cells = [spread([s["pairs"] for s in chosen(solves, load=load)]) for load in loads]
        rows.append([short(tolerance), *cells, f"**{spread([s['pairs'] for s in solves])}**"])
    ways = dict.fromkeys(s["way"] for found in maps for s in found["solves"] if s["way"] != "default")
    with_options = []
    for way in ways:
        solves = [s for found in maps for s in chosen(found["solves"], way=way)]
        missed = [s for s in solves if not s["converged"]]
        reached = [s["pairs"] for s in solves if s["converged"]]
        by_rounding = sum(s["floor"] > s["tolerance"] for s in missed)
        words = f"{len(missed)} ({by_rounding} by rounding)" if missed else "none"
        with_options.append([way, spread(reached), words])
    return [
        "## Work on measured maps",
        f"""{len(maps)} maps: every file of the folders that can be read, levelled and cut out by default, of
1 000 points and more; of a file that says nothing of its scale the work is the same at any.""",
        PAIRS,
        "Transform pairs of one load: median / 90 % / largest.",
        table(("error bound", *(f"p′ = {load:g}" for load in loads), "all"), rows),
        *hardest(maps),
        "With other settings, to 1e-4, all four loads together:",
        table(("setting", "pairs: median / 90 % / largest", "tolerance not reached"), with_options),
        """*elements*: `influence: elements`. *Hardness*: the largest pressure allowed, over the mean
pressure. Points at the hardness are a second set that the solver has to find, beside that of the
points in contact, and the coarse grids foresee it less well. In single precision rounding can
stop a solve above the tolerance; by default it then says so before its first iteration.""",
        *bounds(maps),
    ]


def hardest(maps: list[dict]) -> list[str]:
    """Return the table of the maps that take most work."""
    worst = []
    for found in maps:
        at = {t: max(default_solves([found], t), key=lambda solve: solve["pairs"]) for t in (1e-4, 1e-8)}
        worst.append((at[1e-4]["pairs"], at[1e-8]["pairs"], at[1e-4]["load"], found))
    worst.sort(key=lambda each: each[:2], reverse=True)
    rows = [
        (
            found["name"].replace("_", "\\_"),
            " × ".join(map(str, found["shape"])),
            f"{load:g}",
            f"{one:.1f}",
            f"{two:.1f}",
        )
        for one, two, load, found in worst[:HARDEST]
    ]
    return [
        "The maps that take most, each at its hardest load:",
        table(("map", "points", "p′", "1e-4", "1e-8"), rows),
    ]


def bounds(maps: list[dict]) -> list[str]:
    """Return the table of error bounds over true errors."""
    rows = []
    for tolerance in (1e-4, 1e-8):
        solves = [s for s in default_solves(maps, tolerance) if s["resolved"]]
        ratio = [s["ratio"] for s in solves]
        below = sum(s["bound"] < s["true_error"] - s["reference_error"] for s in solves)
        rows.append(
            (
                short(tolerance),
                len(solves),
                f"{min(ratio):.3f}",
                f"{np.median(ratio):.3f}",
                f"{max(ratio):.3f}",
                below,
            )
        )
    return [
        "### Is the error bound true?",
        "Error bound over true error, that against a solution to 1e-12, in the norm of the elastic energy:",
        table(("tolerance", "solves", "least", "median", "largest", "bound below error"), rows),
        """The bound is proven; here it is also seen to be sharp. Left out are solves that met 1e-12, too,
where there is no error left to compare with. `benchmarks/certificate.py` asks the same of random
maps.""",
    ]


def hard_section(found: list[dict]) -> list[str]:
    """Return the table of the work on hard maps."""
    rows = []
    for one in found:
        most = [max(s["pairs"] for s in default_solves([one], t)) for t in (1e-4, 1e-8)]
        missed = sum(not s["converged"] for s in one["solves"])
        below = sum(
            s["resolved"] and s["bound"] < s["true_error"] - s["reference_error"] for s in one["solves"]
        )
        rows.append((one["name"], *(f"{pairs:.1f}" for pairs in most), missed, below))
    return [
        "## Work on hard maps",
        "Largest number of pairs of four loads (p′ = 0.003 to 1) and three seeds:",
        table(("map", "1e-4", "1e-8", "tolerance not reached", "bound below error"), rows),
        """Self-affine unless said otherwise, with waves from four points to a quarter of the shorter side.
Pixels that are very long and numbers of points that do not halve make coarse grids that foresee
less of the fine one; the transform of a prime number of points takes several times as long, too,
which default windows avoid.""",
    ]


def growth_section(found: list[dict]) -> list[str]:
    """Return the table of the work against the size of the map."""
    sizes = sorted({one["size"] for one in found})
    rows = []
    for kind in dict.fromkeys(one["kind"] for one in found):
        for load in sorted({one["load"] for one in found}):
            at = {one["size"]: one["pairs"] for one in chosen(found, kind=kind, load=load)}
            cells = [
                " / ".join(f"{pairs:.1f}" for pairs in at[size]) if size in at else "–" for size in sizes
            ]
            rows.append([kind, f"{load:g}", *cells, f"{at[max(at)][0] / at[min(at)][0]:.2f}"])
    return [
        "## Growth of the work",
        "Pairs to 1e-4 / 1e-8; the growth is that to 1e-4, from the smallest to the largest size.",
        table(("map", "p′", *(f"{size}²" for size in sizes), "growth"), rows),
        """*measured* is the largest measured map, enlarged by its own spectrum at the same pitch. The
number of pairs does not depend on the size, a step of one iteration up or down aside, so that the
time of a solve grows as that of a transform does. `--growth-sizes` takes other sizes, up to what
the memory holds.""",
    ]


def starts_section(found: list[dict]) -> list[str]:
    """Return the table of the first seconds."""
    installation, process = ({**one} for one in found)
    first, second = installation["first"], installation["second"]
    rows = [
        (
            "`pip install` of the package beside its dependencies, the compiled passes built",
            installation["pip_seconds"],
        ),
        ("its first process: imports, a solve of 256²", first["whole"]),
        ("its second process", second["whole"]),
        ("a process of an environment in use (median)", process["whole"]),
        ("– of which imports", process["imports"]),
        ("– of which the first solve", process["first"]),
        ("– the same solve again", process["second"]),
    ]
    return [
        "## From the first second",
        table(("what", "time"), [(what, seconds(time)) for what, time in rows]),
        """Nothing is compiled when the package is used. Most of a short process are the imports, and most of
these NumPy, SciPy, xarray and pandas; the rest starts and ends Python. Solve many maps in one
process where they are small.""",
    ]


def pair_section(found: list[dict]) -> list[str]:
    """Return the table of a solve over one pair of transforms."""
    rows = [
        (
            f"{one['size']}²",
            one["threads"],
            seconds(one["pair"]),
            seconds(one["solve"]),
            f"{one['pairs']:.1f}",
            f"**{one['solve'] / one['pair']:.1f}**",
        )
        for one in found
    ]
    return [
        "## A solve over one pair of transforms",
        """A made map at p′ = 0.03 to 1e-4, fields and labels included, over a pair of transforms in double
precision:""",
        table(("points", "threads", "pair", "solve", "pairs", "solve / pair"), rows),
        """Most transforms of a solve are in single precision, so that they take less time than pairs in
double. What comes on top are passes over the grid (active set, interpolation between grids, sums)
and the result with its labels, bound by the memory.""",
    ]


def sweep_section(found: list[dict]) -> list[str]:
    """Return the table of many loads in one call."""
    rows = [
        (
            f"{one['size']}²",
            one["threads"],
            seconds(one["one"]["seconds"]),
            seconds(one["many"]["seconds"]),
            f"{one['one']['seconds'] / one['many']['seconds']:.0%}",
            f"{one['one']['pairs'] / one['many']['pairs']:.0%}",
        )
        for one in found
    ]
    return [
        "## Many loads",
        "20 loads from p′ = 0.001 to 1, to 1e-4, no fields kept: one call for all against 20 calls.",
        table(("points", "threads", "one call", "20 calls", "share of time", "share of pairs"), rows),
        """What one call shares is the set-up: gradient, coarse grids, test of full contact. Every load
starts from the coarse grids, which is a better start than the load before.""",
    ]


def memory_section(found: list[dict]) -> list[str]:
    """Return the table of peak memory."""
    sizes = sorted({one["size"] for one in found})
    at = {(one["code"], one["size"]): f"{one['bytes_per_point']:.0f}" for one in found}
    rows = [
        (code, *(at.get((code, size), "–") for size in sizes))
        for code in dict.fromkeys(one["code"] for one in found)
    ]
    return [
        "## Memory",
        """Peak memory of one solve above what the process held before, in bytes per point (p′ = 0.03, one
thread):""",
        table(("code", *(f"{size}²" for size in sizes)), rows),
        """The heights that go in are not counted. One array in double precision is 8 bytes per point.""",
    ]


SECTIONS = {
    "race": race_section,
    "maps": maps_section,
    "hard": hard_section,
    "growth": growth_section,
    "starts": starts_section,
    "pair": pair_section,
    "sweep": sweep_section,
    "memory": memory_section,
}


def seconds(value: float) -> str:
    """Return a time with its unit, to three digits."""
    return f"{1000 * value:.3g} ms" if value < 1 else f"{value:.3g} s" if value < 1000 else f"{value:.0f} s"


def short(tolerance: float) -> str:
    """Return a power of ten as 1e-4."""
    return f"{tolerance:.0e}".replace("e-0", "e-")


def table(header: Sequence[str], rows: Iterable[Sequence]) -> str:
    """Return a table in Markdown."""
    lines = ["| " + " | ".join(str(cell) for cell in row) + " |" for row in (header, *rows)]
    lines.insert(1, "|" + " --- |" * len(header))
    return "\n".join(lines)


def figure(results: dict, path: Path) -> None:
    """Draw the time of one load against the size of the map, and the work on measured maps."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    fig, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.2), layout="constrained")
    draw_times(left, list(results.get("race", {}).values()))
    draw_work(right, list(results.get("maps", {}).values()))
    for ax in (left, right):
        ax.spines[["top", "right"]].set_visible(False)
        ax.tick_params(labelsize=9)
    fig.savefig(path, dpi=110)
    plt.close(fig)


def draw_times(ax, timed: list[dict]) -> None:
    """Draw seconds against points per side on one thread: made maps as bands, measured ones as dots."""
    here = [case for case in timed if case["threads"] == 1]
    for code, colour in COLOURS.items():
        points = {
            group: [
                (c["size"], c["codes"][code]["seconds"])
                for c in here
                if c["group"] == group and code in c["codes"]
            ]
            for group in ("made", "measured")
        }
        sizes = sorted({size for size, _ in points["made"]})
        if sizes:
            at = [[time for s, time in points["made"] if s == size] for size in sizes]
            middle = [geometric_mean(each) for each in at]
            ax.fill_between(
                sizes, [min(e) for e in at], [max(e) for e in at], color=colour, alpha=0.2, linewidth=0
            )
            ax.plot(sizes, middle, color=colour, linewidth=1.5)
            ax.annotate(
                code,
                (sizes[-1], middle[-1]),
                (5, 0),
                textcoords="offset points",
                color=colour,
                va="center",
                fontsize=9,
            )
        if points["measured"]:
            ax.plot(*zip(*points["measured"], strict=True), ".", color=colour, markersize=5, alpha=0.7)
    ax.set(xscale="log", yscale="log")
    sizes = sorted({case["size"] for case in here if case["group"] == "made"})
    ax.set_xticks(sizes, [f"{size}²" for size in sizes])
    ax.minorticks_off()
    ax.set_xlim(right=max([*sizes, 1]) * 1.9)  # room for the names
    ax.set_xlabel("points of the map")
    ax.yaxis.set_major_formatter(lambda time, _: seconds(time))
    ax.set_ylabel("time of one load")
    ax.set_title(
        "Time to a true error of 1e-4, one thread\nline and band: made maps; dots: measured maps", fontsize=9
    )
    ax.grid(alpha=0.2)


def draw_work(ax, maps: list[dict]) -> None:
    """Draw the transform pairs of every measured map and load, with their medians."""
    loads = sorted({solve["load"] for found in maps for solve in found["solves"]})
    for tolerance, colour, shift in ((1e-4, "#0b6e8f", -0.18), (1e-8, "#c89b3d", 0.18)):
        for place, load in enumerate(loads):
            pairs = sorted(s["pairs"] for s in chosen(default_solves(maps, tolerance), load=load))
            aside = np.linspace(-0.12, 0.12, len(pairs))[np.argsort(np.arange(len(pairs)) * 0.618 % 1)]
            ax.plot(place + shift + aside, pairs, ".", color=colour, markersize=4, alpha=0.6)
            ax.plot(
                place + shift + np.array([-0.15, 0.15]), [np.median(pairs)] * 2, color=colour, linewidth=2
            )
        ax.plot([], [], ".", color=colour, label=f"to a proven error of {short(tolerance)}")
    ax.set_xticks(range(len(loads)), [f"{load:g}" for load in loads])
    ax.set_ylim(0, 1.15 * ax.get_ylim()[1])  # room for the legend
    ax.set_xlabel("p′ = mean pressure / (E* × rms gradient)")
    ax.set_ylabel("pairs of Fourier transforms")
    ax.set_title(
        f"Work of roughcontact for one load, {len(maps)} measured maps\ndots: maps; bars: medians", fontsize=9
    )
    ax.legend(fontsize=8, frameon=False, loc="upper right")
    ax.grid(alpha=0.2, axis="y")
