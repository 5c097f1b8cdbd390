"""Write a known map as texts of many dialects, and count how they are read.

    .venv/bin/python tests/faults/dialects.py                  # 1 000 texts
    .venv/bin/python tests/faults/dialects.py --texts 100 --seed 3

Each text is a random combination of what programs write: layout, decimal sign, separator, form of numbers,
header and its words, unit, mark of missing points, encoding, line ends, and what stands behind the last
number. It is read right, read with a question, refused, or read wrong in silence.
"""

import argparse
import json
import random
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from roughcontact.errors import RoughContactError
from roughcontact.io.read import read_height_map

# nm, without symmetry; of one to four digits before the decimal sign
HEIGHTS = np.round(400.0 * np.random.default_rng(7).standard_normal((9, 14)), 2)
STEPS = 1.0, 0.5  # µm, along y and x: of no other ratio, which causes a warning
_MISSING = ((2, 3), (5, 0), (7, 13))
MARKS = ("NaN", "nan", "BAD", "-", "***", "1.#QNAN", "n/a", "Masked", "9.91E+37", "1E+38", "-9999", "NA", "")
MARKS += ("No data", "out of range")
FORMS = {
    "plain": "{:g}",
    "two digits": "{:.2f}",
    "exponent": "{:.5e}",
    "large exponent": "{:.5E}",
    "signed": "{:+.3f}",
}
UNITS = {"nm": 1.0, "µm": 1e3, "um": 1e3, "m": 1e9, "mm": 1e6}
WORDS = {  # of width, height and the unit of the values
    "English": ("Width", "Height", "Value units"),
    "German": ("Breite", "Höhe", "Werteinheiten"),
    "French": ("Largeur", "Hauteur", "Unité Z"),
    "of axes": ("X size", "Y size", "Z unit"),
}


class Text(NamedTuple):
    """A text: its bytes, the arguments with which it is read, the right heights (m, first row lowest)."""

    data: bytes
    arguments: dict
    heights: np.ndarray
    dialect: dict


def text_of(number: int, seed: int = 1) -> Text:
    """Return a text of a random dialect."""
    choose = random.Random(f"{seed} {number}")
    decimal = choose.choice(".,")
    dialect = {
        "layout": choose.choice(["matrix", "matrix", "points", "points, y first", "profile"]),
        "decimal": decimal,
        "separator": choose.choice(["\t", ";", " ", "   ", *([",", ", "] if decimal == "." else [])]),
        "form": choose.choice(list(FORMS)),
        "header": choose.choice(["none", "# {}: {}", "{}: {}", "{} = {}", "{}\t{}"]),
        "words": choose.choice(list(WORDS)),
        "unit": choose.choice(list(UNITS)),
        "missing": choose.choice([None, None, *MARKS]),
        "encoding": choose.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "latin-1"]),
        "newline": choose.choice(["\n", "\n", "\r\n", "\r"]),
        "ends": choose.choice(["", "", "separator", "blank lines", "no newline"]),
        "heading": choose.choice([True, False]),
        "cells": choose.choice(["plain", "plain", "quoted", "between blanks", "filled up"]),
    }
    if not dialect["separator"].strip() and "\t" not in dialect["separator"] and dialect["missing"] == "":
        dialect["missing"] = "NaN"  # between spaces nothing is no cell
    heights = HEIGHTS[:1] if dialect["layout"] == "profile" else HEIGHTS
    written = heights / UNITS[dialect["unit"]]

    def cell(value: float, form: str = FORMS[dialect["form"]]) -> str:
        # of a large unit that form may leave no digit
        return (form if UNITS[dialect["unit"]] == 1 else "{:.9g}").format(value).replace(".", decimal)

    known = np.array([[float(cell(value).replace(",", ".")) for value in row] for row in written])
    cells = [[cell(value) for value in row] for row in written]
    for row, column in _MISSING if dialect["missing"] is not None else ():
        if row < len(cells):
            cells[row][column], known[row, column] = dialect["missing"], np.nan
    lines = _lines(dialect, cells)
    header, arguments = _header(dialect, heights.shape)
    if dialect["separator"].strip(" "):
        header, lines = _dressed(dialect, header, lines)
    newline = dialect["newline"]
    end = {"blank lines": 3 * newline, "no newline": ""}.get(dialect["ends"], newline)
    if dialect["ends"] == "separator":
        lines = [line + dialect["separator"] for line in lines]
    data = (newline.join([*header, *lines]) + end).encode(dialect["encoding"])
    first_row_top = dialect["layout"] == "matrix"
    right = known[::-1] if first_row_top else known
    return Text(data, arguments, right * UNITS[dialect["unit"]] * 1e-9, dialect)


def _lines(dialect: dict, cells: list[list[str]]) -> list[str]:
    """Return the lines of the table."""
    if dialect["layout"] == "matrix":
        return [dialect["separator"].join(row) for row in cells]

    def place(index: int, step: float) -> str:
        return f"{index * step:.3f}".replace(".", dialect["decimal"])

    order = [(j, i) for j in range(len(cells)) for i in range(len(cells[0]))]
    if dialect["layout"] == "points, y first":
        order.sort(key=lambda each: each[::-1])
    rows = [[place(i, STEPS[1]), place(j, STEPS[0]), cells[j][i]] for j, i in order]
    names = ["X [um]", "Y [um]", f"Z [{dialect['unit']}]"]
    if dialect["layout"] == "profile":
        rows, names = [[x, z] for x, _, z in rows], [names[0], names[2]]
    heading = [dialect["separator"].join(names)] if dialect["heading"] else []
    return heading + [dialect["separator"].join(row) for row in rows]


def _dressed(dialect: dict, header: list[str], lines: list[str]) -> tuple[list[str], list[str]]:
    """Return lines as spreadsheets write them: cells in quotes or between blanks, all lines of one width."""
    separator = dialect["separator"].strip(" ")
    rows = [[cell.strip(" ") for cell in line.split(separator)] for line in lines]
    if dialect["cells"] == "quoted":
        lines = [dialect["separator"].join(f'"{cell}"' for cell in row) for row in rows]
    elif dialect["cells"] == "between blanks":
        lines = [f" {separator} ".join(row) for row in rows]
    elif dialect["cells"] == "filled up":
        header = [line + separator * (len(rows[-1]) - 1) for line in header]
    return header, lines


def _header(dialect: dict, shape: tuple[int, int]) -> tuple[list[str], dict]:
    """Return the lines above the table, and what has to be said beside the file."""
    sizes = [f"{n * step:.2f} µm" for n, step in zip(shape, STEPS, strict=True)]
    if dialect["layout"] != "matrix":
        named = dialect["heading"]
        return [], {} if named else {"unit": "um", "height_unit": dialect["unit"]}
    if dialect["header"] == "none":
        return [], {"dx": STEPS[1], "dy": STEPS[0], "unit": "um", "height_unit": dialect["unit"]}
    values = [sizes[1], sizes[0], dialect["unit"]]
    values = [value.replace(".", dialect["decimal"]) for value in values]
    pairs = zip(WORDS[dialect["words"]], values, strict=True)
    return [dialect["header"].format(*pair) for pair in pairs], {}


def outcome(text: Text, folder: Path) -> str:
    """Read a text, and return what came of it."""
    path = folder / "dialect.txt"
    path.write_bytes(text.data)
    try:
        height = read_height_map(path, **text.arguments)
    except RoughContactError:
        return "refused"
    finally:
        path.unlink()
    right = height.shape == text.heights.shape and np.allclose(
        height.values, text.heights, rtol=1e-9, atol=0.0, equal_nan=True
    )
    steps = [float(height[axis][1] - height[axis][0]) for axis in "yx" if height.sizes[axis] > 1]
    right = right and np.allclose(steps, [1e-6 * step for step in STEPS[-len(steps) :]], rtol=1e-6)
    if right:
        return "read right"
    return "read with a question" if json.loads(height.attrs["ingest_warnings"]) else "wrong in silence"


def counted(texts: int, seed: int, folder: Path) -> tuple[Counter, list[dict]]:
    """Return the outcomes of so many texts, and the dialects that were read wrong in silence."""
    found, wrong = Counter(), []
    for number in range(texts):
        text = text_of(number, seed)
        said = outcome(text, folder)
        found[said] += 1
        if said == "wrong in silence":
            wrong.append(text.dialect)
    return found, wrong


def main(
    doc: str, texts: int, count: Callable[[int, int, Path], tuple[Counter[str], list]], describe: Callable
) -> int:
    """Count the outcomes of so many texts by default, and print those that went wrong."""
    parser = argparse.ArgumentParser(description=doc.partition("\n")[0])
    parser.add_argument("--texts", type=int, default=texts)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        found, wrong = count(options.texts, options.seed, Path(folder))
    for text in wrong:
        print(describe(text))
    print("; ".join(f"{name}: {number}" for name, number in found.most_common()))
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main(__doc__, 1000, counted, str))
