"""Excel workbooks of one sheet: its table, read as that of a text would be."""

from pathlib import Path

from roughcontact.io.channels import MeasuredFile
from roughcontact.io.guards import ARCHIVE_ERRORS, MAX_POINTS, refuse_more, refusing
from roughcontact.io.instruments.containers import list_sheets
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.readers import text
from roughcontact.io.text.lines import plain

_MITUTOYO = "DATA"  # sheet of Mitutoyo's workbooks, which have a reader of their own


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is a workbook with one sheet that is none of Mitutoyo's."""
    if not head.startswith(b"PK"):
        return False
    try:
        return len(sheets := list_sheets(path)) == 1 and sheets != [_MITUTOYO]
    except (*ARCHIVE_ERRORS, KeyError):  # no archive, or one of another kind
        return False


def read(path: Path) -> MeasuredFile:
    """Open a workbook: the values of its cells, with decimal points, between tabs."""
    import openpyxl

    lines: list[str] = []
    cells = 0
    with refusing("a damaged Excel workbook"), path.open("rb") as stream:
        sheet = openpyxl.load_workbook(stream, read_only=True, data_only=True).worksheets[0]
        sheet.reset_dimensions()  # which a file may state far too large
        for row in sheet.iter_rows(values_only=True):
            cells += len(row)
            refuse_more(f"{cells} cells", cells, MAX_POINTS)
            line = "\t".join("" if cell is None else " ".join(str(cell).split()) for cell in row)
            if line or not lines or lines[-1]:  # a cell far below is no million of lines
                lines.append(line)
    file = text.parsed(plain("\n".join([*lines, ""])))
    file.format = f"Excel workbook ({file.format})"
    return file


READER = Reader(RecognisedBy.CONTENTS, recognises, read, memory_per_byte=100)
