"""What the other maps of a place, its repeat and those of before and after, say of a measured map."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from xarray import DataArray

from roughcontact.arguments.measurement import Instrument, add_remark
from roughcontact.surface.faces.registration import common_part, measured_in_all
from roughcontact.surface.levelling.repeats import check_repeat, noise_of_repeats
from roughcontact.surface.preparation.region import read_region


def with_repeats(height: DataArray, name: str, rows: Sequence[Mapping[str, Any]]) -> DataArray:
    """Return of a map what its repeats show as well, with the noise by the first one, unless it has one."""
    measured = height.notnull()
    for row in rows:
        cells = dict(row)
        name_of_repeat = cells.pop("name")
        repeat = read_region(**cells)
        check_repeat(height, repeat)
        if row is rows[0] and Instrument.read(height.attrs).noise is None:
            noise, remark = noise_of_repeats(height, repeat)
            # what the noise leaves out is a fact, what is no noise a warning
            is_noise = not math.isnan(noise)
            if is_noise:
                height = height.assign_attrs(Instrument(noise=noise).attributes())
            if remark:
                text = f"the repeats {name} and {name_of_repeat} differ {remark}"
                height = height.assign_attrs(add_remark(height.attrs, text, fact=is_noise))
        measured &= repeat.notnull().values
    return measured_in_all(height, measured)


def part_of_place(height: DataArray, name: str, rows: Sequence[Mapping[str, Any]]) -> DataArray:
    """Return what of a map all maps of its place show; `rows` of them are in the order of time."""
    arguments = {row["name"]: {key: cell for key, cell in row.items() if key != "name"} for row in rows}
    earlier = {key: cells.pop("earlier") for key, cells in arguments.items() if "earlier" in cells}
    maps = {key: height if key == name else read_region(**cells) for key, cells in arguments.items()}
    return common_part(maps, earlier, name)
