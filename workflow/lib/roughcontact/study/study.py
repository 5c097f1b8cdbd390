"""Settings and table of surfaces together: all mistakes in both are reported at once, before a run begins."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from roughcontact.arguments.kinds import PERIODIC_MAP
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.errors import SettingsError
from roughcontact.study.places import find_file
from roughcontact.study.table.columns import GROUP, PAIR
from roughcontact.study.table.groups import first_rows
from roughcontact.study.table.read import read_surfaces
from roughcontact.study.table.row import Surface
from roughcontact.study.yaml_text import check_size


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
    check_size(config)
    cases: dict[str, dict[str, Any]] = {}
    surfaces: dict[str, Surface] = {}
    errors: list[SettingsError] = []
    try:
        cases = resolve(config, origin=origin)
    except SettingsError as error:
        errors.append(error)
    table = config.get("surfaces", Settings.model_fields["surfaces"].default)
    if isinstance(table, str) and table:  # otherwise it is among the mistakes in the settings
        try:
            path = find_file(table, folders) or table
            surfaces = read_surfaces(path, measured_in, files_exist=not checked)
        except SettingsError as error:
            errors.append(error)
    errors += [
        SettingsError(
            f"{row.origin}, {GROUP} = {name}: a case of the settings has this name as well; rename one",
            place=f"rows.{row.line}.{GROUP}",
        )
        for name, row in first_rows(surfaces).items()
        if name in cases
    ]
    errors += [
        SettingsError(f"{row.origin}, {PAIR}: {reason}", place=f"rows.{row.line}.{PAIR}")
        for section, key in (("wear", "coefficient"), ("sliding", "speed"))
        for row in surfaces.values()
        if (reason := PERIODIC_MAP.reason_against(section, row.properties))
        and any(settings[section][key] for settings in cases.values())
    ]
    if errors:
        mistakes = [mistake for error in errors for mistake in error.mistakes or (error,)]
        raise SettingsError("\n".join(map(str, errors)), mistakes=mistakes)
    return cases, surfaces
