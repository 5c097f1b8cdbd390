"""What a run was made from, beside its results: settings, table of surfaces and measured files."""

import hashlib
import json
import os
import shutil
from contextlib import chdir
from pathlib import Path

from roughcontact.arguments.bodies import relaxation_table
from roughcontact.errors import InputFileError, SettingsError
from roughcontact.io.guards import sha256
from roughcontact.results.storage import read_attributes, write_text
from roughcontact.study.places import find_file
from roughcontact.study.plan import Plan
from roughcontact.study.study import read_study
from roughcontact.study.table.columns import OVERVIEW, PAIR
from roughcontact.study.table.text import read_table, separate_files, table_text
from roughcontact.study.yaml_text import check_yaml

FOLDER = "run_inputs"  # no surface has this name: `_` is not admitted


def copy_inputs(results: Path, configuration: Path, read_checksums: set[str]) -> Path:
    """Copy settings, table and measured files of a run into its results; return the path of the settings.

    All must be as the run has read them: settings and rows as the results record them, files by one of the
    checksums (SHA-256) of `read_checksums`.
    """
    if not configuration.is_file():
        raise SettingsError(f"{configuration}: no such file; name the settings of the run")
    config = check_yaml(configuration)
    # paths are looked up beside the results, then beside the file that names them, where these stand, not
    # where links lead to: a run does so as well
    search_path = [Path(os.path.abspath(path)).parent for path in (results, configuration)]  # noqa: PTH100
    with chdir(search_path[0]):
        plan = Plan(*read_study(config, [".", search_path[1]], measured_in=["."], origin=str(configuration)))
    for result in plan.results:
        settings_of_result = json.loads(read_attributes(results / result / "statistics.nc")["settings"])
        if settings_of_result != json.loads(json.dumps(plan.settings("statistics", result))):
            raise InputFileError(f"{result}: its settings, or its row, have changed; repeat the run first")
    table = find_file(plan.common["surfaces"], search_path) or Path()
    header, rows = read_table(table)
    target = results / FOLDER
    shutil.rmtree(target, ignore_errors=True)

    def copied(path: str, folders: list[Path]) -> str:
        """Copy a file into a folder named after its content, so that no other file has its path."""
        file = find_file(path, folders) or Path(path)
        checksum = sha256(file)
        if checksum not in read_checksums:
            raise InputFileError(f"{file}: is not the file that the run has read; repeat the run first")
        copy = target / "measured" / checksum[:12] / file.name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(file, copy)
        return copy.relative_to(target).as_posix()

    surfaces = [dict(zip(header, cells, strict=False)) for _, cells in rows]
    for row in surfaces:
        paths = {name: row[name] for name in ("path", PAIR) if row.get(name)}
        folders = [search_path[0], table.parent]
        row |= {name: copied(path, folders) for name, path in paths.items()}
        row |= {OVERVIEW: "; ".join(copied(file, folders) for file in separate_files(row.get(OVERVIEW, "")))}
    text = table_text(surfaces)
    name = f"surfaces-{hashlib.sha256(text.encode()).hexdigest()[:12]}.tsv"
    write_text(text, target / name)
    for section in (config, *(config.get("cases") or {}).values()):
        for body in (section.get("contact") or {}).get("bodies") or ():
            if path := isinstance(body, dict) and relaxation_table([body]):
                relaxation = {} if path == body["relaxation"] else body["relaxation"]
                body["relaxation"] = relaxation | {"table": copied(path, search_path)}
    write_text(json.dumps(config | {"surfaces": name}, indent=2, default=str) + "\n", target / "config.yaml")
    return target / "config.yaml"
