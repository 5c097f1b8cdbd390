"""Cases that stand in tables, `tests/cases/NAME.tsv`: a block for each test.

The second line of a block names its columns. The cases of a test that is marked `cases` are the rows of the
block of its name (conftest.py).
"""

import ast
from pathlib import Path

FOLDER = Path(__file__).with_name("cases")


def cases_of(module, block):
    """Return the names of the columns and the rows of a block; what stands beyond its columns is a remark."""
    blocks = (FOLDER / f"{module}.tsv").read_text(encoding="utf-8").split("\n\n")
    (text,) = (text for text in blocks if text.startswith(f"[{block}]\n"))
    names, *rows = (line.split("\t") for line in text.strip("\n").split("\n")[1:])
    return names, [tuple(value_of(cell) for cell in row[: len(names)]) for row in rows]


def value_of(cell):
    """Return what a cell holds: a literal of Python, `nan`, `inf`, or else a text as it is."""
    try:
        return ast.literal_eval(cell)
    except (ValueError, SyntaxError):
        return float(cell) if cell in ("nan", "inf", "-inf") else cell
