"""The coarser maps around a surface with its place in each, a file of the rule `prepare_with_overview`."""

from collections.abc import Mapping, Sequence

from _job import save, say, snakemake
from xarray import DataArray

from roughcontact.errors import RoughContactError
from roughcontact.surface.faces.placing import joined_overviews, place_in_words
from roughcontact.surface.preparation import preparation_of
from roughcontact.surface.preparation.region import read_overview


def write_overviews(
    measured: DataArray, levelled: DataArray, files: Sequence[Mapping], middle: tuple[float, float]
) -> None:
    """Read, level and place the overviews of a map (y, x; m): overview.nc.

    Each file has its position, which is of the `middle` (x, y; m) of the map of which this one may be a part.
    """
    settings = snakemake.params.settings["overview"]
    preparation, fields = preparation_of(measured, settings), []
    for file in files:
        arguments = dict(file)
        position = arguments.pop("position", "")
        try:
            overview = read_overview(**arguments)
            fields.append(preparation.overview(levelled, overview, settings["level"], position, middle))
        except RoughContactError as error:
            raise type(error)(f"{error} ({snakemake.params.row['origin']})") from error
        say(f"note: {file['path']}: {place_in_words(fields[-1])}")
    save(joined_overviews(fields), snakemake.output.overview, settings, source=measured.attrs)
