"""The page of the benchmark of windows: tables, figure, and what follows from them."""

from pathlib import Path

import numpy as np

FIGURE_LOAD = 0.1
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
# bias of the area, of the peak, of the rim's load: what a good method keeps
MARKS = {"bias": 0.01, "peak": 0.1, "rim": 0.1}

INTRODUCTION = """
Written by `python benchmarks/window.py --page docs/explanation/window.md`; `benchmarks/README.md` says
how to repeat it.

The solver needs a periodic map, a measurement is none. What making it periodic does to the result is known
where the "measurement" is cut out of a larger surface that is periodic and can be solved whole.

**Surfaces.** {points} × {points} points, eight points per shortest wavelength, unit rms gradient, {seeds} of
each kind: *isotropic* (self-affine, Hurst exponent 0.8, waves up to twice the window), *anisotropic* (waves
six times as long along y), *turned* (grooves of scattered depth with fine roughness on them, 6.8 of them in a
window), *bimodal* (fine roughness on long waves that carry nearly all of the height). Each is cut into
{tiles} maps of {side} × {side} points without rest; a map is levelled by a plane and made periodic: {windows}
windows for each method and load."""

COLUMNS = """
**Columns.** *Area, same load*: contact area of all windows over that of the same parts of the large surface,
when each window carries the mean pressure that its part carries there. This is the error of making it
periodic. *Area*: contact area over that of the whole large surface, both under the same mean pressure, mean ±
scatter from window to window. This is what a user sees; a single window that is small against the longest
waves scatters that much whatever the method. *Peak*: highest pressure over that of the same part of the large
surface, median. *Gradient*: rms gradient over the true one. *Rim*: load on the outer 3 % of each side over
that on the same strips of the large surface."""

NATURAL = """
*Periodic by nature*: windows of the same size that were made periodic from the start, with the same waves as
far as these fit in. Their bias comes from the size alone."""

PLACING = """
Maps of {side} to {longest} points along each side, cut out at random, without and with a defect: a hole,
which levelling fills, or a bump three times as high as the rms height, both {width} points wide. The truth is
the large surface without defect, p̄ = {load:g} E\\* g. *Error*: rms of area / true − 1 over the maps. *Cost*:
time that the search takes beyond the largest rectangle, over that of one solve at one load."""


VERDICT = """
**`{best}` comes nearest to the truth**, misses of area, peak and load on the rim weighed against marks
of 1 %, 10 % and 10 % (the default of the program: `{default}`). `mirror` is left out of the choice: it
solves four times as many points. Waves longer than the window are the hard case: unrelated ends have to meet
somewhere. What keeps their heights at the rim loads it more than is fair, what flattens them less."""

NEARER = """
Over all {count} maps the error is {largest:.2f} % with the largest rectangle and {search:.2f} % with the
search, which costs {cost:.2f} of one solve. The mean square error of the search, less that of the largest
rectangle, is ({difference:.1f} ± {uncertainty:.1f}) × 10⁻⁴ (standard error).

**{words}** (the default of the program: `{default}`)."""


def write(results: dict, path: Path) -> None:
    """Write the page, and its figure beside it."""
    methods, placements = results["methods"], results["placements"]
    drawing = path.with_suffix(".png")
    figure(methods["rows"], drawing)
    tiles = (methods["points"] // methods["side"]) ** 2
    sizes = {
        "points": methods["points"],
        "side": methods["side"],
        "seeds": methods["seeds"],
        "tiles": tiles,
        "windows": tiles * methods["seeds"] * len(_unique(methods["rows"], "kind")),
    }
    parts = [
        "# The periodic window: which method, which place",
        INTRODUCTION.strip().format(**sizes),
        "## Methods, all surfaces together",
        COLUMNS.strip(),
        *(_load_table(methods["rows"], load) for load in _unique(methods["rows"], "load")),
        f"![Errors of the methods by kind of surface]({drawing.name})",
        _verdict(methods["rows"]),
        f"## By kind of surface, p̄ = {FIGURE_LOAD:g} E\\* g",
        _kind_table(methods["rows"]),
        NATURAL.strip(),
        "## Place and size",
        PLACING.strip().format(
            side=placements["side"],
            longest=round(1.3 * placements["side"]),
            width=round(0.2 * placements["side"]),
            load=FIGURE_LOAD,
        ),
        _placement_table(placements["rows"]),
        _placement_verdict(placements["rows"]),
    ]
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def summary(rows: list[dict]) -> dict:
    """Return the numbers of one method from its rows: biases as ratios, scatter, error of the mean."""
    areas = np.array([row["area"] for row in rows])
    found = {"area": areas.mean(), "scatter": areas.std(), "windows": areas.size}
    if "same_area" in rows[0]:
        found["same"] = sum(row["same_area"] for row in rows) / sum(row["part_area"] for row in rows)
        found["peak"] = np.median([row["peak"] for row in rows if row["peak"]])
        found["gradient"] = np.mean([row["gradient"] for row in rows])
        found["rim"] = sum(row["rim"] for row in rows) / sum(row["part_rim"] for row in rows)
    return found


def _unique(rows, key):
    return list(dict.fromkeys(row[key] for row in rows))


def _cut_methods(rows):
    """Return the methods that were tried on cut-out windows."""
    return _unique([row for row in rows if "same_area" in row], "method")


def _select(rows, **wanted):
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def _load_table(rows, load) -> str:
    table = []
    for method in _cut_methods(rows):
        found = summary(_select(rows, method=method, load=load))
        table.append((f"`{method}`", *_numbers(found)))
    head = ("method", "area, same load", "area", "peak", "gradient", "rim")
    return f"p̄ = {load:g} E\\* g:\n\n{_table(head, table)}"


def _numbers(found):
    cells = [f"{found['area']:.3f} ± {found['scatter']:.3f}"]
    if "same" not in found:
        return ["–", *cells, "–", "–", "–"]
    return [f"{found['same']:.3f}", *cells, *(f"{found[name]:.2f}" for name in ("peak", "gradient", "rim"))]


def _kind_table(rows) -> str:
    table = []
    for kind in _unique(rows, "kind"):
        for method in _unique(rows, "method"):
            found = summary(_select(rows, kind=kind, method=method, load=FIGURE_LOAD))
            name = f"`{method}`" if "same" in found else method
            table.append((kind, name, *_numbers(found)))
    return _table(("surface", "method", "area, same load", "area", "peak", "gradient", "rim"), table)


def worst_misses(rows) -> dict[str, dict[str, float]]:
    """Return for each method how far it misses in area, peak and rim: rms over kinds and loads."""
    misses = {}
    for method in _cut_methods(rows):
        found = [
            summary(_select(rows, kind=kind, method=method, load=load))
            for kind in _unique(rows, "kind")
            for load in _unique(rows, "load")
        ]
        misses[method] = {
            name: float(np.sqrt(np.mean([(f[key] - 1) ** 2 for f in found])))
            for name, key in (("bias", "same"), ("peak", "peak"), ("gradient", "gradient"), ("rim", "rim"))
        }
    return misses


def best_method(rows) -> str:
    """Return the method whose misses, in units of the marks, have the least sum of squares; those that solve
    a larger map than was measured (mirror) are left out.
    """
    misses = worst_misses(rows)
    misses.pop("mirror", None)
    return min(misses, key=lambda m: sum((misses[m][name] / mark) ** 2 for name, mark in MARKS.items()))


def _verdict(rows) -> str:
    misses = worst_misses(rows)
    table = [
        (f"`{method}`", *(f"{100 * miss[name]:.1f} %" for name in ("bias", "peak", "gradient", "rim")))
        for method, miss in misses.items()
    ]
    head = ("method", "area, same load", "peak", "gradient", "rim")
    verdict = VERDICT.format(best=best_method(rows), default=_default("method"))
    title = "Distance from the truth, rms over all kinds of surfaces and loads:"
    return f"{title}\n\n{_table(head, table)}\n{verdict}"


def _default(name) -> str:
    """Return the default of an option of the window."""
    import inspect

    from roughcontact.window.periodic_window import periodic_window

    return inspect.signature(periodic_window).parameters[name].default


def _placement_table(rows) -> str:
    table = []
    for kind in _unique(rows, "kind"):
        cells = [kind]
        for placement in ("largest", "search"):
            some = _select(rows, kind=kind, placement=placement)
            areas = np.array([row["area"] for row in some])
            cells += [
                f"{areas.mean():.3f} ± {areas.std():.3f}",
                f"{100 * np.sqrt(np.mean((areas - 1) ** 2)):.1f} %",
            ]
        cells.append(f"{search_cost(_select(rows, kind=kind)):.2f}")
        table.append(cells)
    head = ("maps", "area, largest", "error", "area, search", "error", "cost of the search")
    return _table(head, table)


def search_cost(rows) -> float:
    """Return the time of the search beyond that of the largest rectangle, over one solve (medians)."""
    placing = {
        placement: np.median([row["placing"] for row in _select(rows, placement=placement)])
        for placement in ("largest", "search")
    }
    return float((placing["search"] - placing["largest"]) / np.median([row["solving"] for row in rows]))


def placement_errors(rows) -> dict[str, float]:
    """Return the rms error of the area of both placements, over all maps."""
    return {
        placement: float(
            np.sqrt(np.mean([(row["area"] - 1) ** 2 for row in rows if row["placement"] == placement]))
        )
        for placement in ("largest", "search")
    }


def _placement_verdict(rows) -> str:
    errors = placement_errors(rows)
    difference, uncertainty = search_gain(rows)
    if abs(difference) < 2 * uncertainty:
        words = "On such maps there is nothing to choose between them; the simpler one is taken"
    else:
        words = f"`{'search' if difference < 0 else 'largest'}` comes nearer to the truth"
    return NEARER.strip().format(
        count=len(_select(rows, placement="search")),
        cost=search_cost(rows),
        difference=1e4 * difference,
        uncertainty=1e4 * uncertainty,
        words=words,
        default=_default("placement"),
        **{placement: 100 * error for placement, error in errors.items()},
    )


def search_gain(rows) -> tuple[float, float]:
    """Return the mean square error of the area with the search less that with the largest rectangle, map by
    map, and its standard error.
    """
    squares = [
        np.array([(row["area"] - 1) ** 2 for row in _select(rows, placement=placement)])
        for placement in ("search", "largest")
    ]
    difference = squares[0] - squares[1]
    return float(difference.mean()), float(difference.std(ddof=1) / np.sqrt(difference.size))


def _table(head, rows) -> str:
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (head, *rows)]
    return "\n".join([lines[0], "|" + " --- |" * len(head), *lines[1:]])


def figure(rows: list[dict], path: Path) -> None:
    """Draw bias of area, peak and rim of every method by kind of surface and load."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    kinds, loads, methods = _unique(rows, "kind"), _unique(rows, "load"), _cut_methods(rows)
    panels = (
        ("same", "contact area / true, same load", 0.01, (0.84, 1.1)),
        ("peak", "highest pressure / true", 0.1, (0.6, 2.2)),
        ("rim", "load on the rim / true", 0.1, (0.0, 2.2)),
    )
    fig, axes = plt.subplots(len(panels), 1, figsize=(8.2, 8.0), sharex=True, layout="constrained")
    ticks = np.arange(len(kinds) * len(loads))
    for ax, (name, label, mark, limits) in zip(axes, panels, strict=True):
        ax.axhspan(1 - mark, 1 + mark, color="#e4e4e4", linewidth=0)
        ax.axhline(1, color="0.5", linewidth=0.8)
        for index, method in enumerate(methods):
            values = [
                summary(_select(rows, kind=kind, method=method, load=load))[name]
                for kind in kinds
                for load in loads
            ]
            shift = (index - (len(methods) - 1) / 2) * 0.12
            inside = np.clip(values, *limits)
            ax.plot(
                ticks + shift,
                inside,
                "os^Dvp"[index],
                color=COLOURS[index],
                markersize=5,
                label=method,
                clip_on=False,
            )
        for place in range(1, len(kinds)):
            ax.axvline(place * len(loads) - 0.5, color="0.8", linewidth=0.8)
        ax.set_ylim(*limits)
        ax.set_ylabel(label, fontsize=9)
        ax.tick_params(labelsize=8)
        ax.spines[["top", "right"]].set_visible(False)
    axes[-1].set_xticks(
        ticks,
        [f"{load:g}\n{kind}" if i == 1 else f"{load:g}" for kind in kinds for i, load in enumerate(loads)],
    )
    axes[-1].set_xlabel(
        "mean pressure / (E* × rms gradient) and kind of surface; grey: the marks", fontsize=9
    )
    handles, labels = axes[0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside upper center", ncols=3, fontsize=8, frameon=False)
    fig.savefig(path, dpi=110)
    plt.close(fig)
