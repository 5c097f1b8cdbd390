"""Settings and table of surfaces together: all mistakes in both are reported at once, before a run begins."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from roughcontact.checking import check_choice, check_lay, marker_values
from roughcontact.choices import Checksum, FirstRow, Resampling
from roughcontact.configuration.models import Composite, Settings
from roughcontact.configuration.resolve import resolve
from roughcontact.configuration.surfaces import PAIR_FIRST_ROW, Surface, find, first_rows, read_surfaces
from roughcontact.configuration.yaml_text import MAX_VALUES
from roughcontact.errors import SettingsError
from roughcontact.units import unknown_unit, value_of


def read_study(
    config: Mapping[str, Any],
    folders: Sequence[str | Path],
    *,
    measured_in: Sequence[str | Path],
    origin: str = "the settings",
    checked: bool = False,
) -> tuple[dict[str, dict[str, Any]], dict[str, Surface]]:
    r"""Return the settings of every case (as `resolve`) and the table of surfaces (as `read_surfaces`).

    `folders` and `measured_in` are search paths of table and measured files, which may have gone where they
    were `checked` when the run began. A `SettingsError` from `origin` lists all mistakes in both.
    """
    _check_size(config)
    cases: dict[str, dict[str, Any]] = {}
    surfaces: dict[str, Surface] = {}
    mistakes = []
    try:
        cases = resolve(config, origin=origin)
    except SettingsError as error:
        mistakes.append(str(error))
    finer = dict.fromkeys(settings["instrument"]["finer_spectrum"] for settings in cases.values())
    mistakes += [
        f"instrument.finer_spectrum = {path}: no such file; correct the path (from the working folder)"
        for path in finer
        if path and not checked and find(path, ["."]) is None
    ]
    table = config.get("surfaces", Settings.model_fields["surfaces"].default)
    if isinstance(table, str) and table:  # otherwise it is among the mistakes in the settings
        try:
            path, count = find(table, folders) or table, _placements_each(config)
            surfaces = read_surfaces(
                path, measured_in, check=None if checked else _mistakes_in, placements_each=count
            )
        except SettingsError as error:
            mistakes.append(str(error))
    mistakes += [
        f"{row.origin}, group = {name}: a case of the settings has this name as well; rename one"
        for name, row in first_rows(surfaces).items()
        if name in cases
    ]
    if mistakes:
        raise SettingsError("\n".join(mistakes))
    return cases, surfaces


def _placements_each(config: Mapping[str, Any]) -> int:
    """Return the number of placements of each pair; 1 where the settings of pairs have mistakes."""
    try:
        composite = Composite.model_validate(config.get("composite", {}))
    except ValidationError:
        return 1
    return composite.shifts * len(composite.rotations)


def _check_size(config: Mapping[str, Any]) -> None:
    """Reject more values than any study has: a few lines of aliases can stand for a billion."""
    waiting: list[Any] = [config]
    for _ in range(MAX_VALUES):
        if not waiting:
            return
        value = waiting.pop()
        if isinstance(value, Mapping):
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
    raise SettingsError(
        f"the configuration has more than {MAX_VALUES} values: look for aliases (*name) that stand for one "
        "another, and write out their values"
    )


def _mistakes_in(row: Surface) -> list[str]:
    """Return the mistakes in the files, units and choices of a row."""
    paths = {"path": row.path, "counter_face": row.counter_face}
    mistakes = [
        f"{key} = {path}: no such file; correct the path or put # before the row"
        for key, path in paths.items()
        if path is not None and path != Path() and find(path, ["."]) is None
    ]
    mistakes += [
        f"{key}: {unknown_unit(row.read_arguments[key], 'm')}"
        for key in ("unit", "height_unit")
        if key in row.read_arguments and value_of(row.read_arguments[key], "m") is None
    ]
    checks: dict[str, Callable[[Any], object]] = {
        "missing_value": marker_values,
        "lay": lambda cell: check_lay("across" if cell == "along" else cell),  # of one group
        "resample": lambda cell: check_choice("resample", cell, Resampling),
        "checksum": lambda cell: check_choice("checksum", cell, Checksum),
        "first_row": lambda cell: check_choice("first_row", cell, FirstRow),
        PAIR_FIRST_ROW: lambda cell: check_choice(PAIR_FIRST_ROW, cell, FirstRow),
    }
    cells = {**row.read_arguments, PAIR_FIRST_ROW: row.counter_face_first_row}
    for key, check in checks.items():
        try:
            if cells.get(key):
                check(cells[key])
        except SettingsError as error:
            mistakes.append(str(error))
    return mistakes
