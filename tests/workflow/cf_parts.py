"""Divide netCDF files into files of some forty variables, with all that these refer to, as they are stored.

    python tests/workflow/cf_parts.py FOLDER FILE ...

The time of the checker of the CF conventions rises faster than the square of the number of variables: it
takes minutes for a file of statistics, seconds for its parts.
"""

import sys
from pathlib import Path

import netCDF4

AT_ONCE = 40
REFERENCES = ("coordinates", "bounds")  # attributes that name other variables


def with_references(file: netCDF4.Dataset, names: list[str]) -> list[str]:
    """Return names of variables, and those of the variables that they refer to."""
    needed = [*names]
    for name in needed:  # it grows
        words = [str(getattr(file[name], attribute, "")) for attribute in REFERENCES]
        mentioned = dict.fromkeys([*file[name].dimensions, *" ".join(words).split()])
        needed += [
            variable for variable in mentioned if variable in file.variables and variable not in needed
        ]
    return needed


def divide(path: Path, folder: Path) -> None:
    """Write the parts of a file to a folder, each with the attributes of the whole."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        names = [*file.variables]
        for start in range(0, len(names), AT_ONCE):
            written = folder / f"{'-'.join(path.with_suffix('').parts)}-{start}.nc"
            with netCDF4.Dataset(written, "w") as part:
                part.setncatts(file.__dict__)
                for dimension in file.dimensions.values():
                    part.createDimension(dimension.name, dimension.size)
                for name in with_references(file, names[start : start + AT_ONCE]):
                    source, attributes = file[name], dict(file[name].__dict__)
                    fill = attributes.pop("_FillValue", None)
                    variable = part.createVariable(name, source.dtype, source.dimensions, fill_value=fill)
                    variable.set_auto_maskandscale(False)
                    variable.setncatts(attributes)
                    variable[...] = source[...]


if __name__ == "__main__":
    target = Path(sys.argv[1])
    target.mkdir()
    for argument in sys.argv[2:]:
        divide(Path(argument), target)
