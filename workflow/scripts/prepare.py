"""Read, level and cut out the window of one surface: a measured file to height.nc, levelled.nc, window.nc.

With a coarser map around it, its overview, also overview.nc.
"""

from _job import check_sources, save, say, snakemake, warn
from _other_maps import part_of_place, with_repeats
from _overviews import write_overviews
from _window import write_window

from roughcontact.arguments.measurement import json_attribute
from roughcontact.errors import RoughContactError
from roughcontact.io.read import read_height_map
from roughcontact.results.storage import read_dataset
from roughcontact.study.tiles import Tile, cut
from roughcontact.surface.faces.placing import middle_of
from roughcontact.surface.preparation import preparation_of
from roughcontact.surface.preparation.region import read_region
from roughcontact.surface.profiles.surface import stacked

settings, row, output = snakemake.params.settings, snakemake.params.row, snakemake.output
arguments = dict(settings["height"]["surface"])
name, repeats = arguments.pop("name"), arguments.pop("repeats", ())
try:
    tile, along = arguments.pop("parts", None), arguments.pop("along", ())
    overviews, maps_of_place = arguments.pop("overview", ()), arguments.pop("place", ())
    height = read_region(row["path"], **arguments)
    middle = middle_of(height)  # which a stated position in an overview is of
    if along:
        height = stacked(height, [read_height_map(**profile) for profile in along])
    if tile:
        height = cut(height, Tile(*tile))
    if repeats:
        height = with_repeats(height, name, repeats)
    if maps_of_place:
        height = part_of_place(height, name, maps_of_place)
except RoughContactError as error:
    raise type(error)(f"{error} ({row['origin']})") from error
facts = json_attribute(height.attrs, "ingest_facts")
for text in json_attribute(height.attrs, "ingest_warnings"):
    say(f"note: {text}") if text in facts else warn(text)
save(height, output.height, settings["height"], source=height.attrs)
del height  # large maps leave no room for two
measured = read_dataset(output.height)["height"]
levelled = preparation_of(measured, settings["levelled"]).level(measured, settings["levelled"]["level"])
if overviews:  # one that does not show the map is known before anything is solved
    write_overviews(measured, levelled, overviews, middle)
save(levelled, output.levelled, settings["levelled"], source=measured.attrs)
del measured, levelled
if "window" in dict(output.items()):  # a face is windowed together with its counter-face
    write_window(settings["window"])
check_sources()
