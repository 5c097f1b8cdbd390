"""The text of the table of surfaces, lines of cells between tabs: read and written as spreadsheets do."""

import codecs
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from roughcontact.errors import SettingsError
from roughcontact.study.table.columns import COLUMNS, OVERVIEW, PAIR, REQUIRED

_NAMES_OF_OTHERS = ("path", PAIR, OVERVIEW, "channel")  # as files and instruments call them
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]")  # and bytes of a name that are no text
_QUOTED = re.compile(r'"(?:[^"]|"")*"')


def read_table(table: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return the header, and the cells of each further row with the number of its line, unchecked."""
    try:
        if table.exists() and not table.is_file():  # a pipe or a device may never end
            raise OSError("no regular file")
        content = table.read_bytes()
        has_mark = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))  # as spreadsheets write it
        lines = re.split(r"\r\n?|\n", content.decode("utf-16" if has_mark else "utf-8-sig"))
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise SettingsError(
            f"table of surfaces {table}, line {line}: is no text in UTF-8 ({error.reason}); save it as UTF-8"
        ) from error
    except (OSError, ValueError) as error:  # of a name with a null character
        why = "no such file" if isinstance(error, FileNotFoundError) else f"not readable ({error})"
        raise SettingsError(
            f"table of surfaces {table}: {why}; correct `surfaces` in the settings, or write the table, a "
            "tab-separated text (`roughcontact init` writes one to change)"
        ) from error
    rows = [(number, _cells(line)) for number, line in enumerate(lines, 1)]
    rows = [(number, cells) for number, cells in rows if any(cells) and not cells[0].startswith("#")]
    if not rows:
        raise SettingsError(
            f"table of surfaces {table}: is empty; write a header (surface, path) and one row each"
        )
    (_, header), *rows = rows
    return header, rows


def _cells(line: str) -> list[str]:
    """Return the cells of a line: in quotes, as spreadsheets write some, as they are, else without blanks."""
    cells = [_CONTROL.sub("\ufffd", cell.strip()) for cell in line.rstrip().split("\t")]
    return [cell[1:-1].replace('""', '"') if _QUOTED.fullmatch(cell) else cell for cell in cells]


def table_text(rows: Sequence[Mapping[str, str]]) -> str:
    r"""Return the text of a table with the columns that have a cell in any of the rows.

    Names in and of files stay as they are, if necessary in quotes; control characters, and bytes that are no
    text, are refused.

    Examples
    --------
    >>> table_text([{"surface": "ground", "path": "ground.txt", "unit": "", "dx": "1 um"}])
    'surface\tpath\tdx\nground\tground.txt\t1 um\n'
    """
    used = {column for row in rows for column, cell in row.items() if cell.strip()} - {*REQUIRED}
    header = [*REQUIRED, *(name for name in COLUMNS if name in used), *sorted(used - {*COLUMNS})]
    lines = [header, *([_written(name, row.get(name, "")) for name in header] for row in rows)]
    return "".join("\t".join(line) + "\n" for line in lines)


def _written(column: str, cell: str) -> str:
    """Return a cell of a column as it stands in a table."""
    cell = cell if column in _NAMES_OF_OTHERS else cell.strip()
    if _CONTROL.search(cell):
        raise SettingsError(f"{column} = {cell!r}: a cell is text without tabs or control marks; rename it")
    return cell if _cells(cell) == [cell] else '"' + cell.replace('"', '""') + '"'


def separate_files(cell: str) -> list[str]:
    """Return the names of the files in a cell, which semicolons separate.

    Examples
    --------
    >>> separate_files("a 10x.plu; b.plu"), separate_files("")
    (['a 10x.plu', 'b.plu'], [])
    """
    return [name.strip() for name in cell.split(";") if name.strip()]
