"""The page of the benchmark of coverage: a table for real maps, one for made ones, and what follows."""

from pathlib import Path

import numpy as np

NAMES = ("relative_contact_area", "mean_gap", "mean_contact_pressure", "max_pressure")
WORDS = ("contact area", "mean gap", "pressure in contact", "largest pressure")
HEADLINE = 3  # of these, the ones that the goals are for
FLAG = "Sample"  # the check that speaks of the surface beyond the map

INTRODUCTION = """
Written by `python benchmarks/intervals.py FOLDER ... --page docs/explanation/coverage.md`, FOLDER being any
folders of instrument files; `benchmarks/README.md` says how to repeat it. How the interval is made:
{doc}`uncertainty`.

**What is asked.** The ± is for this surface over three times the length of the map. A measured map that is
cut into 3 × 3 parts shows whether it holds: each part is processed by default settings as if it were the
measurement, the truth is the result of the whole map at the same mean pressure (p̄ = 0.02 · 0.1 · 0.4 E\\* g,
g of the whole map). All maps of at least 400 points along each side that are read without being told anything
are in the first table, those from 192 points in the second, with parts of 64 points and more. The true
pressure in contact is the load over the contact area: the mean over whole pixels falls short of it, for which
the intervals make up.

**Columns.** *Inside*: share of the results whose interval holds the truth, at the three loads together.
*Width*: median half-width (half the interval) over the 95 % quantile of the error; 1 is as wide as it must
be. *Flag*: share of the parts for which the check *Sample* asks for a look. *Silent*: share of all results
that are outside without it.

The constants of the method were chosen on the maps of the first table and on made surfaces of other seeds;
nothing was chosen on those of the second. What the choice itself brings was measured by leaving each map of
the first table out in turn, the two constants chosen anew on the others: {doc}`uncertainty`."""


def write(found: list[dict], path: Path) -> None:
    """Write the page."""
    lines = ["# Does the ± hold? Real surfaces and made ones", INTRODUCTION, ""]
    path.write_text("\n".join(lines) + "\n" + tables(found) + "\n", encoding="utf-8")


def tables(found: list[dict]) -> str:
    """Return the tables of what was found, as text."""
    lines = []
    for group, title in (
        ("large", "Real maps of 400 points and more along each side"),
        ("small", "Real maps of 192 to 400 points"),
    ):
        chosen = [each for each in found if each["group"] == group]
        if chosen:
            lines += [f"## {title}", "", *_per_surface([(each["name"], [each]) for each in chosen]), ""]
            lines += [*_per_load(chosen), "", *_goals(chosen), ""]
    made = [each for each in found if each["group"] == "made"]
    if made:
        lines += ["## Made surfaces", "", *_made_words(), ""]
        kinds = dict.fromkeys(each["name"] for each in made)
        lines += _per_surface([(kind, [each for each in made if each["name"] == kind]) for kind in kinds])
        lines += ["", "The same by the length of the longest waves, of the length of the map:", ""]
        lengths = sorted({each["longest"] for each in made})
        by_length = [
            (f"{length:.3g}", [each for each in made if each["longest"] == length]) for length in lengths
        ]
        lines += [*_per_surface(by_length), "", *_per_load(made), ""]
    return "\n".join(lines).rstrip()


def _made_words() -> list[str]:
    """Return what the made surfaces are."""
    return [
        "Eight kinds (`roughcontact.validation.masters`), 576 points along each side, each with waves up to",
        "1/8, 1/3, 1 and 3 times the length of the map; maps of 192 points, tilted, 1 % of the points",
        "missing, one in four with a bow, one with spikes. Truth: the whole surface without faults.",
    ]


def _rows(chosen: list[dict]) -> list[dict]:
    """Return the parts that were not refused."""
    return [part for each in chosen for part in each["parts"] if "refused" not in part]


class Shares:
    """What the tables show, counted over some parts.

    Attributes
    ----------
    inside : array (part, quantity, load)
    half_width, error : arrays alike, over the result
    flagged : array (part,)
        by the check of the surface beyond the map.
    """

    def __init__(self, parts: list[dict]):
        """Count."""
        truth, result, lower, upper = (
            np.array([[part[name][key] for name in NAMES] for part in parts], float)
            for key in ("truth", "result", "lower", "upper")
        )
        rounding = 1e-9 * np.abs(result)
        self.inside = (truth >= lower - rounding) & (truth <= upper + rounding)
        base = np.where(result > 0, result, 1.0)
        self.half_width, self.error = (upper - lower) / 2 / base, np.abs(truth - result) / base
        self.flagged = np.array([FLAG in part["asked"] for part in parts])

    def width(self, quantity: int) -> float:
        """Return the median half-width over the 95 % quantile of the error."""
        return float(np.median(self.half_width[:, quantity]) / np.quantile(self.error[:, quantity], 0.95))

    def silent(self) -> float:
        """Return the share of all headline results that are outside without a flag."""
        return float((~self.inside[:, :HEADLINE] & ~self.flagged[:, None, None]).mean())


def _per_surface(chosen: list[tuple[str, list[dict]]]) -> list[str]:
    """Return a table with a line for each of several (name, surfaces), and one for all."""
    header = [
        "surface",
        "parts",
        *(cell for words in WORDS[:HEADLINE] for cell in (f"{words}: inside", "width")),
        f"{WORDS[HEADLINE]}: inside",
        "flag",
        "silent",
    ]
    lines = ["| " + " | ".join(header) + " |"]
    lines.append("|" + " --- |" * len(header))
    widths = []
    for name, surfaces in [*chosen, ("**all**", [each for _, several in chosen for each in several])]:
        parts = _rows(surfaces)
        if not parts:
            lines.append(f"| {name} | every part is refused |")
            continue
        shares = Shares(parts)
        cells = [name, str(len(parts))]
        width = [shares.width(quantity) for quantity in range(HEADLINE)]
        for quantity in range(HEADLINE):
            cells += [_percent(shares.inside[:, quantity].mean()), f"{width[quantity]:.1f}"]
        cells += [
            _percent(shares.inside[:, HEADLINE].mean()),
            _percent(shares.flagged.mean()),
            f"{100 * shares.silent():.1f} %",
        ]
        if name == "**all**":
            calm = shares.inside[~shares.flagged][:, :HEADLINE]
            unflagged = _percent(calm.mean()) if calm.size else "–"
        else:
            widths.append(width)
        lines.append("| " + " | ".join(cells) + " |")
    middle = " · ".join(f"{value:.1f}" for value in np.median(widths, axis=0))
    lines += [
        "",
        f"Median width of the lines: {middle}. Of the results without a flag {unflagged} are inside.",
    ]
    return lines


def _per_load(chosen: list[dict]) -> list[str]:
    """Return the table of shares and widths by load."""
    shares = Shares(_rows(chosen))
    lines = ["| all, by load | 0.02 | 0.1 | 0.4 |", "| --- | --- | --- | --- |"]
    for quantity, words in enumerate(WORDS):
        cells = [_percent(shares.inside[:, quantity, load].mean()) for load in range(3)]
        lines.append(f"| {words} | {' | '.join(cells)} |")
    return lines


def _goals(chosen: list[dict]) -> list[str]:
    """Return what the ± is to reach, and what it does."""
    shares = Shares(_rows(chosen))
    inside = shares.inside[:, :HEADLINE]
    calm = inside[~shares.flagged]
    widths = [
        [Shares(parts).width(quantity) for quantity in range(HEADLINE)]
        for parts in (_rows([each]) for each in chosen)
        if parts
    ]
    found = (
        ("inside, least of the three", 0.90, inside.mean(axis=(0, 2)).min(), 1),
        ("the same, least of the loads", 0.85, inside.mean(axis=0).min(), 1),
        ("of the results without a flag", 0.92, calm.mean() if calm.size else np.nan, 1),
        ("silent, at most", 0.04, shares.silent(), -1),
        ("width, largest of the medians, at most", 1.5, np.median(widths, axis=0).max(), -1),
    )
    lines = ["| goal | wished for | found | |", "| --- | --- | --- | --- |"]
    for what, wished, reached, sense in found:
        shown = (f"{v:.1f}" if wished > 1 else f"{100 * v:.1f} %" for v in (wished, reached))
        met = "met" if sense * reached >= sense * wished else "not met"
        lines.append(f"| {what} | {' | '.join(shown)} | {met} |")
    return lines


def _percent(share: float) -> str:
    """Return a share in whole percent."""
    return f"{100 * share:.0f} %"
