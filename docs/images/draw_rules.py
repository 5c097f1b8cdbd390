"""Draw rules.svg of this folder: the rules of the target `all`, as Snakemake gives them.

    python docs/images/draw_rules.py

The study has all kinds of jobs: a single surface, a pair of faces, three cases. An arrow that
follows from others is left out: where a → b → c is drawn, a → c is not.
"""

import re
import subprocess
import sys
import tempfile
from itertools import permutations, product
from pathlib import Path

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parents[2]
PICTURE = Path(__file__).with_name("rules.svg")
SETTINGS = {
    "surfaces": "surfaces.tsv",
    "contact": {"contact_modulus": 1e9},
    "composite": {"shifts": 1},
    "cases": {
        "first": {},
        "second": {"contact": {"contact_modulus": 2e9}},
        "third": {"statistics": {"gap_bins": 5}},
    },
}
TABLE = (
    "surface\tpath\tcounter_face\tunit\tdx\tdy",
    "single\ta.npy\t\tum\t1\t1",
    "pair\ta.npy\ta.npy\tum\t1\t1",
)
# pixels: width of the picture and of a letter, height of a box, from box to box, from row to row
WIDTH, LETTER, BOX, GAP, ROW = 360, 6.8, 28, 14, 64


def rule_graph() -> set[tuple[str, str]]:
    """Return the arrows of `snakemake all --rulegraph`, each from a rule to one that reads its files."""
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/a.npy", np.zeros((16, 16)))
        Path(folder, "settings.yaml").write_text(yaml.safe_dump(SETTINGS))
        Path(folder, "surfaces.tsv").write_text("\n".join(TABLE) + "\n")
        words = ["all", "--snakefile", ROOT / "Snakefile", "--configfile", "settings.yaml", "--rulegraph"]
        command = [sys.executable, "-m", "snakemake", *words]
        text = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout
    names = dict(re.findall(r'(\d+)\[label = "(\w+)"', text))
    return {(names[first], names[then]) for first, then in re.findall(r"(\d+) -> (\d+)", text)}


def reduced(arrows: set[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the arrows without loops, and without those that follow from others."""
    arrows = {(first, then) for first, then in arrows if first != then}
    reached = set(arrows)
    while longer := {(a, d) for (a, b), (c, d) in product(reached, arrows) if b == c} - reached:
        reached |= longer
    follows = {(a, d) for (a, b), (c, d) in product(reached, reached) if b == c}
    return sorted(arrows - follows)


def placed(arrows: list[tuple[str, str]]) -> dict[str, tuple[float, float, float]]:
    """Return the middle of each rule's box, and its width: the order in rows with the shortest arrows."""

    def steps_to_end(name):
        return max((1 + steps_to_end(then) for first, then in arrows if first == name), default=0)

    names = sorted({name for arrow in arrows for name in arrow})
    rows: list[list[str]] = [[] for _ in range(1 + max(map(steps_to_end, names)))]
    for name in names:
        rows[-1 - steps_to_end(name)].append(name)

    def places(order):
        found = {}
        for number, row in enumerate(order):
            widths = [LETTER * len(name) + 14 for name in row]
            left = (WIDTH - sum(widths) - GAP * (len(row) - 1)) / 2
            for name, width in zip(row, widths, strict=True):
                found[name] = (left + width / 2, ROW * number + BOX, width)
                left += width + GAP
        return found

    def length(order):
        at = places(order)
        return sum(abs(at[first][0] - at[then][0]) for first, then in arrows)

    return places(min(product(*map(permutations, rows)), key=length))


def drawing(arrows: set[tuple[str, str]]) -> str:
    """Return the picture, in SVG."""
    kept = reduced(arrows)
    at = placed(kept)
    height = max(y for _, y, _ in at.values()) + BOX
    size = f'width="{WIDTH}" height="{height:.0f}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} viewBox="0 0 {WIDTH} {height:.0f}">',
        '<marker id="end" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="5" orient="auto">',
        '<path d="M0 0L8 4L0 8z" fill="#555"/></marker>',
        f'<rect {size} rx="6" fill="#fff"/>',
        '<g stroke="#555" stroke-width="1.3" marker-end="url(#end)">',
    ]
    for first, then in kept:
        (x, y, _), (end, below, _) = at[first], at[then]
        lines.append(f'<path d="M{x:.0f} {y + BOX / 2:.0f}L{end:.0f} {below - BOX / 2 - 2:.0f}"/>')
    lines += ["</g>", '<g font-family="monospace" font-size="11" text-anchor="middle">']
    for name, (x, y, width) in at.items():
        box = f'x="{x - width / 2:.0f}" y="{y - BOX / 2:.0f}" width="{width:.0f}" height="{BOX}"'
        lines.append(f'<rect {box} rx="4" fill="#eaf2fb" stroke="#00519e"/>')
        lines.append(f'<text x="{x:.0f}" y="{y + 4:.0f}">{name}</text>')
    return "\n".join([*lines, "</g>", "</svg>"]) + "\n"


if __name__ == "__main__":
    PICTURE.write_text(drawing(rule_graph()), encoding="utf-8")
    print(PICTURE)
