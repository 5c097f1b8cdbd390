"""The table of numbers of a text file: where it starts, how it is separated, what its tokens mean."""

import re
from collections import Counter
from pathlib import Path

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.guards import check_points

_MISSING = {"nan", "na", "n/a", "bad", "null", "none", "-", "--", "***", "void", "inf", "+inf", "-inf", ""}


def split_header(lines: list[str], path: Path) -> tuple[list[str], list[str]]:
    """Return the lines of the header and those of the table.

    Parameters
    ----------
    lines : list of str
    path : Path
        Named by the message.

    Returns
    -------
    tuple of list of str

    Raises
    ------
    InputFileError
        Where no line holds numbers.

    Examples
    --------
    >>> split_header(["Width: 2 mm", "1 2", "3 4"], Path("map.txt"))
    (['Width: 2 mm'], ['1 2', '3 4'])
    """
    start = next((number for number, line in enumerate(lines) if _is_data(line)), None)
    if start is None:
        first = next((line.strip() for line in lines if line.strip()), "")
        raise InputFileError(f"{path}: text without a table of numbers; it starts with {first[:60]!r}")
    return lines[:start], lines[start:]


def separators(body: list[str], path: Path) -> tuple[str | None, bool]:
    """Return what separates the columns, and whether the decimal sign is a comma.

    Parameters
    ----------
    body : list of str
        Lines of the table.
    path : Path
        Named by the message.

    Returns
    -------
    delimiter : str or None
        None for white space.
    decimal_comma : bool

    Raises
    ------
    InputFileError
        Where a comma may be both.

    Examples
    --------
    >>> separators(["1,5;2,5"], Path("map.txt")), separators(["1.5, 2.5", "3.0, 4.0"], Path("map.txt"))
    ((';', True), (',', False))
    """
    sample = [line.strip() for line in body[:50] if line.strip()]
    joined = "\n".join(sample)
    if ";" in joined:
        return ";", "," in joined
    if "\t" in joined:
        return "\t", "," in joined
    if "," not in joined:
        return None, False
    words = [line.split() for line in sample]
    if any(len(row) > 1 for row in words) and not any(word.endswith(",") for row in words for word in row):
        return None, True
    if all(line.count(",") == 1 and "." not in line for line in sample) and len(sample) > 1:
        raise InputFileError(
            f"{path}: the comma in {sample[0]!r} may be a decimal sign or a separator; "
            "write decimals with a point, or separate columns with a tab or a semicolon"
        )
    return ",", False


def parse_table(
    body: list[str], delimiter: str | None, decimal_comma: bool, path: Path, *, first: int = 1
) -> np.ndarray:
    """Return the numbers of a table.

    Parameters
    ----------
    body : list of str
        Its lines; empty ones and comments are left out.
    delimiter : str or None
        What separates the columns; None for white space.
    decimal_comma : bool
        Whether the decimal sign is a comma.
    path : Path
        Named by the messages.
    first : int
        Number of the first line in the file, for the messages.

    Returns
    -------
    array (rows, columns)
        NaN for words that stand for a missing point.

    Raises
    ------
    InputFileError
        For a line that is no row of numbers, and for rows of different lengths.

    Examples
    --------
    >>> parse_table(["1,5;BAD", "2,5;3"], ";", True, Path("map.txt"))
    array([[1.5, nan],
           [2.5, 3. ]])
    """
    rows = []
    for number, line in enumerate(body, start=first):
        text = line.strip(" \r\f" if delimiter == "\t" else None)
        if not text.strip() or text.lstrip()[0] in "#%":
            continue
        if decimal_comma:
            text = text.replace(",", ".")
        if delimiter is not None:
            text = text.rstrip().removesuffix(delimiter)  # a separator at the end of a line closes it
        try:
            rows.append([_number(token) for token in text.split(delimiter)])
        except ValueError as error:
            raise InputFileError(f"{path}: line {number} is no row of numbers ({error})") from error
    counts = Counter(map(len, rows))
    if len(counts) > 1:
        width = counts.most_common(1)[0][0]
        bad = next(index for index, row in enumerate(rows) if len(row) != width)
        cut = "; the last line is not whole: the file was cut off" if bad == len(rows) - 1 else ""
        raise InputFileError(
            f"{path}: row {bad + 1} has {len(rows[bad])} numbers where the others have {width}{cut}"
        )
    check_points((len(rows), len(rows[0])), path)
    return np.array(rows, dtype=float)


def _is_data(line: str) -> bool:
    """Return whether a line is a row of numbers."""
    if not line.strip() or line.lstrip()[0] in "#%;!\\*/":
        return False
    tokens = re.split(r"[;\t,\s]+", line.strip().strip(";,"))
    try:
        values = [_number(token) for token in tokens]
    except ValueError:
        return False
    return bool(np.isfinite(values).any()) or len(values) > 1


def _number(token: str) -> float:
    """Return the value of a token, NaN for a word that stands for a missing point."""
    token = token.strip()
    if token.lower() in _MISSING:
        return np.nan
    if "_" in token:  # Python would read 1_000
        raise ValueError(f"no number: {token!r}")
    return float(token)
