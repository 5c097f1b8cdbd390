"""The steps of `prepare`: each makes one file of a surface from those before it."""

import json
import math

from _job import FILES, save, say, snakemake

from roughcontact.errors import RoughContactError
from roughcontact.faces.composite import composite
from roughcontact.faces.positions import relative_positions
from roughcontact.io.read import read_height_map
from roughcontact.levelling.level import level
from roughcontact.levelling.repeats import noise_of_repeats
from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.window.finite_body import solved_map


def height(settings: dict) -> None:
    """Read the measured file: metres, NaN where not measured, metadata and checksum of the file."""
    file = snakemake.params.file
    given = dict(settings["surface"])
    name, repeat = given.pop("name"), dict(given.pop("repeat", {}))
    try:
        found = read_height_map(file["path"], **given)
        if repeat and "instrument_noise" not in found.attrs:
            other = repeat.pop("name")
            noise, remark = noise_of_repeats(found, read_height_map(**repeat))
            # what the noise leaves out is a fact, what is no noise a warning
            known = {} if math.isnan(noise) else {"instrument_noise": noise}
            for key in ("ingest_warnings", *(["ingest_facts"] if known else [])) if remark else ():
                sentences = [*json.loads(found.attrs[key]), f"the repeats {name} and {other} differ {remark}"]
                known[key] = json.dumps(sentences, ensure_ascii=False)
            found.attrs |= known
    except RoughContactError as error:
        raise type(error)(f"{error} ({file['origin']})") from error
    for warning in json.loads(found.attrs["ingest_warnings"]):
        say(f"warning: {warning}")
    save(found, FILES["height"], settings, source=found.attrs)


def levelled(settings: dict) -> None:
    """Remove form and outliers and fill in missing points; for a pair, add up its two faces."""
    if "face" in FILES:
        faces = [read_dataset(FILES[name])["height"] for name in ("face", "facing")]
        pair = settings["surface"]
        position = relative_positions(*faces, **pair["composite"])[pair["number"] - 1]
        found = composite(*faces, **position)
        save(found, FILES["levelled"], settings, source=found.attrs)
        return
    measured = read_dataset(FILES["height"])["height"]
    save(level(measured, **settings["level"]), FILES["levelled"], settings, source=measured.attrs)


def window(settings: dict) -> None:
    """Cut out a window without missing points and make it periodic."""
    with opened_dataset(FILES["levelled"]) as file:  # without the rejected heights, which are as large
        plane = file["height"].drop_vars("rejected_height", errors="ignore").load()
    found = solved_map(plane, settings)
    save(found, FILES["window"], settings, source=plane.attrs)


STEPS = {"height": height, "levelled": levelled, "window": window}


def prepare() -> None:
    """Run the steps of this job, one after the other."""
    for name, step in STEPS.items():
        if name in snakemake.params.steps:
            step(snakemake.params.settings[name])
