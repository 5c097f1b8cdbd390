"""What a run was made from, beside its results: settings, table of surfaces and measured files."""

import json
import shutil
from pathlib import Path

from roughcontact.configuration.models import Settings
from roughcontact.configuration.surfaces import PAIR, find, read_table
from roughcontact.configuration.yaml_text import check_yaml
from roughcontact.errors import InputFileError, SettingsError
from roughcontact.io.guards import sha256
from roughcontact.results.storage import write_text

FOLDER = "run_inputs"  # no surface has this name: `_` is not admitted


def copy_inputs(results: Path, configuration: Path, read_checksums: set[str]) -> Path:
    """Copy settings, table and measured files of a run into its results; return the path of the settings.

    Measured files must have one of the checksums (SHA-256) of `read_checksums`: those that the run has read.
    """
    import yaml  # comes with Snakemake

    if not configuration.is_file():
        raise SettingsError(f"{configuration}: no such file; name the settings of the run")
    check_yaml(configuration)
    config = yaml.safe_load(configuration.read_text(encoding="utf-8"))
    # paths are looked up beside the results, then beside the file that names them
    search_path = [results.resolve().parent, configuration.resolve().parent]
    named = config.get("surfaces", Settings.model_fields["surfaces"].default)
    table = find(named, search_path)
    if table is None:
        raise SettingsError(f"surfaces = {named}: no such file beside {results} or {configuration}")
    header, rows = read_table(table)
    target = results / FOLDER
    shutil.rmtree(target, ignore_errors=True)

    def copied(path: str, folders: list[Path], *, recorded: bool = True) -> str:
        """Copy a file into a folder named after its content, so that no other file has its path."""
        file = find(path, folders)
        if file is None:
            raise InputFileError(
                f"{path}: no such file beside {results} or {table}; put it back where it was"
            )
        checksum = sha256(file)
        if recorded and checksum not in read_checksums:
            raise InputFileError(f"{file}: is not the file that the run has read; repeat the run first")
        copy = target / "measured" / checksum[:12] / file.name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(file, copy)
        return copy.relative_to(target).as_posix()

    columns = [number for number, name in enumerate(header) if name in ("path", PAIR)]
    for _, cells in rows:
        for number in columns:
            if number < len(cells) and cells[number]:
                cells[number] = copied(cells[number], [search_path[0], table.parent])
    lines = ["\t".join(cells) for cells in (header, *(cells for _, cells in rows))]
    tables = target / "surfaces.tsv"
    write_text("\n".join(lines) + "\n", tables)
    renamed = tables.rename(tables.with_name(f"surfaces-{sha256(tables)[:12]}.tsv"))
    for section in (config, *(config.get("cases") or {}).values()):
        instrument = section.get("instrument") or {}
        if path := instrument.get("finer_spectrum"):
            instrument["finer_spectrum"] = copied(path, search_path, recorded=False)
    write_text(
        json.dumps(config | {"surfaces": renamed.name}, indent=2, default=str) + "\n", target / "config.yaml"
    )
    return target / "config.yaml"
