"""The columns of the table of surfaces: what each means, and what its cells may be."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from functools import partial
from typing import get_args

from roughcontact.arguments.checking import marker_values
from roughcontact.arguments.choices import LayInGroup, check_choice
from roughcontact.arguments.rectangles import parse_rectangles
from roughcontact.arguments.rows import rows_beside
from roughcontact.arguments.settings.models import Instrument
from roughcontact.arguments.units import convert_to_base_unit, unit_factor, unknown_unit
from roughcontact.errors import SettingsError
from roughcontact.io.request import CHOICES, FILE_OPTIONS, Request
from roughcontact.study.table.row import Mistake

REQUIRED = ("surface", "path")
PAIR, PAIR_FIRST_ROW = "counter_face", "counter_face_first_row"
GROUP, SPECIMEN, TILES = "group", "part", "parts"
BEFORE, REPEAT = "before", "repeat_of"
OF_SURFACES = (GROUP, REPEAT, BEFORE, TILES)  # whose cells are the properties of `Surface` with these names
OVERVIEW, OVERVIEW_POSITION = "overview", "overview_position"
OF_ALL_FILES = ("lay", TILES, PAIR, OVERVIEW)  # which the files of a new table may have alike
NUMBERS = ("dx", "dy")
UNITS = ("unit", "height_unit")
REGION = ("crop", "mask")
TEXTS = (*(entry.name for entry in fields(Request) if entry.name not in NUMBERS), *REGION)
INSTRUMENT = tuple(key for key in Instrument.model_fields if key != "correct")  # prevail over the settings
_CHOICES = CHOICES | {"lay": LayInGroup, PAIR_FIRST_ROW: CHOICES["first_row"]}
_MEANINGS = dict(rows_beside(__file__, "columns.tsv"))  # of columns that no option of the program has
_OWN = (GROUP, SPECIMEN, TILES, PAIR, PAIR_FIRST_ROW, BEFORE, REPEAT, OVERVIEW, OVERVIEW_POSITION)
COLUMNS = (*REQUIRED, *_OWN, *TEXTS, *NUMBERS, *INSTRUMENT)

# a column, another that excludes it in a row, and why
_OF_SINGLE_MAPS = "is of single maps; leave it or {other} empty"
_EXCLUSIVE = {
    **{(key, other): _OF_SINGLE_MAPS for key in REGION for other in (PAIR, "lay")},
    (TILES, PAIR): "{name} is a pair of faces ({other}), which has several placements instead "
    "(composite.shifts); leave one of the two cells empty",
    (TILES, "lay"): "profiles with lay = {cell} are solved together; leave the cell empty, or name some of "
    "them in a row of its own",
    (OVERVIEW, PAIR): "{name} is a pair ({other}); leave one of the two cells empty",
}


def column_meaning(name: str) -> str:
    """Return the sentence of a column of the table, in the words of the options of the program or its own.

    Examples
    --------
    >>> column_meaning("height_unit"), column_meaning("noise")
    ('unit of the heights', 'measurement noise N_M, rms; a number alone is in m')
    """
    option = FILE_OPTIONS.get(name.replace("_", "-"), "").replace("--", "").replace("height-", "height_")
    field = Instrument.model_fields.get(name)
    return option or _MEANINGS.get(name) or (field.description if field else None) or ""


def column_choices(name: str) -> list[str]:
    """Return the words that a cell of a column may be; none where any text may stand.

    Examples
    --------
    >>> column_choices("lay"), column_choices("counter_face_first_row"), column_choices("unit")
    (['across', 'along', 'none'], ['top', 'bottom'], [])
    """
    return list(get_args(_CHOICES.get(name)))


def length(text: str) -> float:
    """Return a length in `unit`, or in m if it has its own unit; NaN for any other text.

    Examples
    --------
    >>> length("0.5"), length("2 um"), length("wide")
    (0.5, 2e-06, nan)
    """
    try:
        return float(convert_to_base_unit(text, "m"))
    except ValueError:
        return math.nan


def _check_length(key: str, text: str) -> None:
    if not 0 < length(text) < math.inf:
        rule = "a number greater than 0 (decimal point), in `unit` or with its own unit behind it (1.5 um)"
        raise SettingsError(f"{key} = {text!r}: must be {rule}")


def _check_unit(key: str, text: str) -> None:
    if unit_factor(text, "m") is None:
        raise SettingsError(f"{key}: {unknown_unit(text, 'm')}")


_CHECKS: dict[str, Callable[[str], object]] = {
    **{key: partial(_check_length, key) for key in NUMBERS},
    **{key: partial(parse_rectangles, key) for key in REGION},
    **{key: partial(check_choice, key, choices=words) for key, words in _CHOICES.items()},
    **{key: partial(_check_unit, key) for key in UNITS},
    **{key: partial(marker_values, where=key) for key in ("missing_value", "ignore_lines")},
}


def mistakes_in_cells(row: Mapping[str, str]) -> Iterator[Mistake]:
    """Yield what is wrong with the cells of a row, each by itself and beside another that excludes it."""
    for (key, excluded), why in _EXCLUSIVE.items():
        if row[key] and row[excluded]:
            sentence = why.format(name=row["surface"], other=excluded, cell=row[excluded])
            yield key, f"{key} = {row[key]}: {sentence}"
    if row[PAIR_FIRST_ROW] and not row[PAIR]:
        yield PAIR_FIRST_ROW, f"{PAIR_FIRST_ROW}: is of a {PAIR}; name its file, or use first_row"
    for key, check in _CHECKS.items():
        try:
            if row[key]:
                check(row[key])
        except SettingsError as error:
            yield key, str(error)
