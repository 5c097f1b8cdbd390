"""A finished run as an RO-Crate 1.1 with the profile Process Run Crate 0.5: content and origin of its files.

The program is the instrument of one action, measured files and settings its objects, the files its results.
"""

import json
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.arguments.measurement import json_attribute
from roughcontact.errors import InputFileError, SettingsError
from roughcontact.results.storage import opened_dataset, read_attributes, write_text
from roughcontact.study.inputs import FOLDER as INPUTS
from roughcontact.study.inputs import copy_inputs
from roughcontact.study.places import stale_results

if TYPE_CHECKING:
    from rocrate.rocrate import ROCrate

_NAME = "ro-crate-metadata.json"
_PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
_NO_TERMS = "Not stated: ask whoever made this run."
# not in the terms of RO-Crate 1.1
_TERMS = {"sha256": "http://schema.org/sha256"}
_MEDIA_TYPES = {
    ".nc": "application/netcdf",
    ".csv": "text/csv",
    ".html": "text/html",
    ".json": "application/json",
    ".tsv": "text/tab-separated-values",
    ".yaml": "application/yaml",
}


def write_crate(
    folder: str | Path,
    *,
    configuration: str | Path | None = None,
    terms: str = _NO_TERMS,
    author: str = "",
    publisher: str = "",
) -> Path:
    """Write `ro-crate-metadata.json` into the folder of a finished run and return its path.

    It has the types, sizes and checksums of all files, and the program with commit and packages (Leo et al.,
    PLoS ONE 19 (2024) e0309210). The `configuration` and all it names are copied to `run_inputs`, to repeat
    the run. `author` and `publisher` may end with their ORCID or ROR in angle brackets.

    Examples
    --------
    >>> write_crate("nowhere")
    Traceback (most recent call last):
    roughcontact.errors.InputFileError: nowhere: no statistics.nc is in it; name the folder of a finished run
    """
    folder = Path(folder)
    if not (folder / "statistics.nc").is_file():
        raise InputFileError(f"{folder}: no statistics.nc is in it; name the folder of a finished run")
    if find_spec("rocrate") is None:
        raise SettingsError("the package rocrate is not installed: pip install 'roughcontact[crate]'")
    from rocrate.rocrate import ROCrate

    _check_results(folder)
    files, inputs = sorted(_files(folder)), []
    # no other clock is read: an unchanged folder gives an unchanged crate
    end_time = datetime.fromtimestamp(int(max(path.stat().st_mtime for path in files)), UTC).isoformat()
    crate = ROCrate(version="1.1")
    crate.metadata.extra_terms |= _TERMS
    root = crate.root_dataset
    root["name"], root["license"] = "True contact area and contact pressures of measured surfaces", terms
    root["description"] = "Results of roughcontact: maps and numbers of each surface, and of all together."
    if terms.startswith("http"):
        text = f"Licence of the results: {terms}"
        root["license"] = _add(crate, terms, "CreativeWork", name="Licence", description=text)
    root["datePublished"] = end_time
    root["conformsTo"] = _add(crate, _PROFILE, "CreativeWork", name="Process Run Crate", version="0.5")
    results, measurements, programs = [], {}, {}
    for path in files:
        name = path.relative_to(folder).as_posix()
        about = _about(path) | {"name": name}
        if path.suffix == ".nc":
            with opened_dataset(path) as dataset:
                about["name"] = dataset.attrs.get("title", name)
                if path.stem == "height":
                    source = dataset["height"].attrs
                    measurements[source["source_sha256"]] = source
                for checksum in dataset.attrs.get("further_sha256", "").split():
                    measurements.setdefault(checksum, {})
                program = {name: dataset.attrs.get(name, "") for name in ("versions", "commit")}
                programs[tuple(program.values())] = program
        results.append(crate.add_file(dest_path=name, properties=about))
    if configuration is not None:
        copy_inputs(folder, Path(configuration), read_checksums=set(measurements))
        copies = sorted(path for path in (folder / INPUTS).rglob("*") if path.is_file())
        inputs = [
            crate.add_file(dest_path=path.relative_to(folder).as_posix(), properties=_about(path))
            for path in copies
        ]
    run = _add(
        crate,
        "#run",
        "CreateAction",
        name="Run of roughcontact",
        description="Height maps were read, levelled and made periodic, and their contact was solved.",
        endTime=end_time,
        actionStatus="http://schema.org/CompletedActionStatus",
    )
    instruments = [_add_program(crate, **program) for program in programs.values()]
    run["instrument"] = instruments if len(instruments) > 1 else instruments[0]
    settings = read_attributes(folder / "statistics.nc")["settings"]
    run["object"] = [
        *(_add_measured(crate, source) for source in measurements.values() if source),
        *inputs,
        _add(crate, "#settings", "PropertyValue", name="settings", value=settings),
    ]
    run["result"] = results
    root["mentions"] = run
    if author:
        root["author"] = run["agent"] = _add_named(crate, "Person", author)
    if publisher:
        root["publisher"] = _add_named(crate, "Organization", publisher)
    write_text(json.dumps(crate.metadata.generate(), indent=2, sort_keys=True) + "\n", folder / _NAME)
    return folder / _NAME


def _check_results(folder: Path) -> None:
    """Raise an InputFileError where results of an earlier run, or other files, would go into the crate."""
    if link := next((path for path in folder.rglob("*") if path.is_symlink()), None):
        raise InputFileError(f"{link}: is a link, whose target an archive would hold; remove it")
    bands = json_attribute(read_attributes(folder / "statistics.nc"), "bands")
    results = [str(Path(case, surface)) for case, surfaces in bands.items() for surface in surfaces]
    if stale := stale_results(results, folder):
        raise InputFileError(
            f"{stale[0]}: is of an earlier run, statistics.nc does not have it; delete this folder, or name "
            "the surface in the table and run again"
        )


def _files(folder: Path) -> Iterator[Path]:
    """Yield the files of a run, without hidden ones and an earlier crate."""
    for path in folder.rglob("*"):
        inside = path.relative_to(folder)
        hidden = inside.parts[0] == INPUTS or any(folder_name[0] == "." for folder_name in inside.parts)
        if path.is_file() and inside != Path(_NAME) and not hidden:
            yield path


def _about(path: Path) -> dict[str, str]:
    """Return name, size and type of a file."""
    about = {"name": path.name, "contentSize": str(path.stat().st_size)}
    media_type = _MEDIA_TYPES.get(path.suffix)
    return about | ({"encodingFormat": media_type} if media_type else {})


def _add(crate: "ROCrate", identifier: str, entity_type: str, **properties: Any) -> Any:
    """Add to a crate an entity that is no file of it."""
    from rocrate.model.contextentity import ContextEntity

    return crate.add(ContextEntity(crate, identifier, properties={"@type": entity_type} | properties))


def _add_named(crate: "ROCrate", entity_type: str, text: str) -> Any:
    """Add a person or an organisation, ``Name`` or ``Name <address>``."""
    name, address = (field.strip(" >") for field in (*text.split("<", 1), "")[:2])
    identifier = address if address.startswith("http") else "#" + re.sub(r"\W+", "-", name)
    return _add(crate, identifier, entity_type, name=name or address)


def _add_measured(crate: "ROCrate", source: dict[str, Any]) -> Any:
    """Add a measured file, which lies elsewhere: its name, format and checksum."""
    checksum, text = source["source_sha256"], f"Measured height map, {source['source_format']}"
    about = {"name": source["source_file"], "description": text, "sha256": checksum}
    return _add(crate, f"#measured-{checksum}", "CreativeWork", **about)


def _add_program(crate: "ROCrate", *, versions: str, commit: str) -> Any:
    """Add this program at a version and a commit, with the packages that it computed with."""
    packages = json.loads(versions or "{}")
    program_version = packages.pop("roughcontact", "unknown")
    requirements = [
        _add(crate, f"#{name}-{version}", "SoftwareApplication", name=name, softwareVersion=version)
        for name, version in packages.items()
    ]
    return _add(
        crate,
        "#" + "-".join(filter(None, ["roughcontact", program_version, commit])),
        "SoftwareApplication",
        name="roughcontact",
        softwareVersion=f"{program_version}, commit {commit}" if commit else program_version,
        softwareRequirements=requirements,
    )
