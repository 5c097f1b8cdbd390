"""Read, level and cut out the window of one surface: a measured file to height.nc, levelled.nc, window.nc.

With a coarser map around it, its overview, also overview.nc.
"""

import math

from _job import check_sources, save, say, snakemake, warn
from _overviews import write_overviews
from _window import write_window

from roughcontact.arguments.measurement import Instrument, Measurement, add_remark
from roughcontact.errors import RoughContactError
from roughcontact.io.read import read_height_map
from roughcontact.results.storage import read_dataset
from roughcontact.study.tiles import Tile, cut
from roughcontact.surface.faces.registration import common_part
from roughcontact.surface.levelling.repeats import noise_of_repeats
from roughcontact.surface.preparation import preparation_of
from roughcontact.surface.preparation.region import read_region
from roughcontact.surface.profiles.surface import stacked


def _maps_of_place(rows, name, height):
    """Return the maps of a place in the order of time, and the name of the earlier one of each."""
    rows = {row["name"]: {key: cell for key, cell in row.items() if key != "name"} for row in rows}
    earlier = {other: cells.pop("earlier") for other, cells in rows.items() if "earlier" in cells}
    maps = {other: height if other == name else read_region(**cells) for other, cells in rows.items()}
    return maps, earlier


settings, row, output = snakemake.params.settings, snakemake.params.row, snakemake.output
arguments = dict(settings["height"]["surface"])
name, repeat = arguments.pop("name"), dict(arguments.pop("repeat", {}))
try:
    tile, along = arguments.pop("parts", None), arguments.pop("along", ())
    overviews, maps_of_place = arguments.pop("overview", ()), arguments.pop("place", ())
    height = read_region(row["path"], **arguments)
    if along:
        height = stacked(height, [read_height_map(**profile) for profile in along])
    if tile:
        height = cut(height, Tile(*tile))
    if repeat and Instrument.read(height.attrs).noise is None:
        name_of_repeat = repeat.pop("name")
        noise, remark = noise_of_repeats(height, read_region(**repeat))
        # what the noise leaves out is a fact, what is no noise a warning
        noisy = not math.isnan(noise)
        height.attrs |= Instrument(noise=noise).attributes() if noisy else {}
        if remark:
            text = f"the repeats {name} and {name_of_repeat} differ {remark}"
            height.attrs |= add_remark(height.attrs, text, fact=noisy)
    if maps_of_place:
        height = common_part(*_maps_of_place(maps_of_place, name, height), name)
except RoughContactError as error:
    raise type(error)(f"{error} ({row['origin']})") from error
reading = Measurement.read(height.attrs)
for text in reading.warnings:
    say(f"note: {text}") if text in reading.facts else warn(text)
save(height, output.height, settings["height"], source=height.attrs)
del height  # large maps leave no room for two
measured = read_dataset(output.height)["height"]
levelled = preparation_of(measured, settings["levelled"]).level(measured, settings["levelled"]["level"])
if overviews:  # one that does not show the map is known before anything is solved
    write_overviews(measured, levelled, overviews)
save(levelled, output.levelled, settings["levelled"], source=measured.attrs)
del measured, levelled
if "window" in dict(output.items()):  # a face is windowed together with its counter-face
    write_window(settings["window"])
check_sources()
