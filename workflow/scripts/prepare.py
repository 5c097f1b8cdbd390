"""Read, level and cut out the window of one surface: a measured file to height.nc, levelled.nc, window.nc."""

import json
import math

from _job import check_sources, save, say, snakemake
from _window import write_window

from roughcontact.configuration.tiles import Tile, cut
from roughcontact.errors import RoughContactError
from roughcontact.io.read import read_height_map
from roughcontact.levelling.repeats import noise_of_repeats
from roughcontact.profiles.surface import levelled_heights, stacked
from roughcontact.results.storage import read_dataset

settings, row, output = snakemake.params.settings, snakemake.params.row, snakemake.output
arguments = dict(settings["height"]["surface"])
name, repeat = arguments.pop("name"), dict(arguments.pop("repeat", {}))
try:
    tile, along = arguments.pop("parts", None), arguments.pop("along", ())
    height = read_height_map(row["path"], **arguments)
    if along:
        height = stacked(height, [read_height_map(**profile) for profile in along])
    if tile:
        height = cut(height, Tile(*tile))
    if repeat and "instrument_noise" not in height.attrs:
        name_of_repeat = repeat.pop("name")
        noise, remark = noise_of_repeats(height, read_height_map(**repeat))
        # what the noise leaves out is a fact, what is no noise a warning
        noisy = not math.isnan(noise)
        attrs = {"instrument_noise": noise} if noisy else {}
        for key in ("ingest_warnings", *(["ingest_facts"] if noisy else [])) if remark else ():
            remarks = [
                *json.loads(height.attrs[key]),
                f"the repeats {name} and {name_of_repeat} differ {remark}",
            ]
            attrs[key] = json.dumps(remarks, ensure_ascii=False)
        height.attrs |= attrs
except RoughContactError as error:
    raise type(error)(f"{error} ({row['origin']})") from error
facts = json.loads(height.attrs["ingest_facts"])
for text in json.loads(height.attrs["ingest_warnings"]):
    say(f"{'note' if text in facts else 'warning'}: {text}")
save(height, output.height, settings["height"], source=height.attrs)
del height  # large maps leave no room for two
measured = read_dataset(output.height)["height"]
save(
    levelled_heights(measured, settings["levelled"]["level"]),
    output.levelled,
    settings["levelled"],
    source=measured.attrs,
)
del measured
if "window" in dict(output.items()):  # a face is windowed together with its counter-face
    write_window(settings["window"])
check_sources()
