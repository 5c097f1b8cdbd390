"""Read a measured file into height.nc: metres, NaN where not measured, metadata and checksum of the file."""

import json

from _job import save, say, snakemake

from roughcontact.errors import RoughContactError
from roughcontact.io.read import read_height_map

file, settings = snakemake.params.file, snakemake.params.settings
given = {key: value for key, value in settings["surface"].items() if key != "name"}
try:
    height = read_height_map(file["path"], **given)
except RoughContactError as error:
    raise type(error)(f"{error} ({file['origin']})") from error
for warning in json.loads(height.attrs["ingest_warnings"]):
    say(f"warning: {warning}")
save(height, snakemake.output[0], settings, source=height.attrs)
