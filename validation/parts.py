"""The verb that computes one part of the validation."""

from pathlib import Path

from roughcontact.checking import check_choice
from roughcontact.errors import SettingsError
from validation import (
    PartName,
    adhesion,
    conductance,
    consistency,
    convergence,
    coverage,
    formats,
    full_contact,
    hertz,
    layers,
    paper,
    patches,
    rough,
    sealing,
    subsurface,
    targets,
    waves,
)
from validation.lines import Part, empty_part

_GRIDS = (256, 16384)  # smallest and largest
_MODULES = {
    "waves": waves,
    "hertz": hertz,
    "layers": layers,
    "full_contact": full_contact,
    "convergence": convergence,
    "rough": rough,
    "consistency": consistency,
    "coverage": coverage,
    "conductance": conductance,
    "sealing": sealing,
    "subsurface": subsurface,
    "targets": targets,
    "patches": patches,
    "adhesion": adhesion,
    "formats": formats,
}


def validate(part: PartName, sample: str | Path | None = None, *, finest_grid: int = 2048) -> Part:
    """Compute one part of the validation.

    Parameters
    ----------
    part : str
        one of `validation.PARTS`.
    sample : str or Path, optional
        measured file of the paper's three steps; only the part ``paper`` needs it.
    finest_grid : int
        points along the finest grid, a power of 2 from 256 to 16384. Rows are solved with so many points,
        single maps with half, ensembles with a quarter; tolerances follow the grid.

    Returns
    -------
    Part

    Raises
    ------
    SettingsError
        for a part that does not exist, a grid of another size, or the part ``paper`` without a sample.

    Examples
    --------
    >>> part = validate("full_contact", finest_grid=256)
    >>> len(part.lines), all(line.holds for line in part.lines)
    (18, True)
    """
    check_choice("part", part, PartName)
    if not _GRIDS[0] <= finest_grid <= _GRIDS[1] or finest_grid & (finest_grid - 1):
        raise SettingsError(
            f"finest_grid = {finest_grid}: must be a power of 2 from {_GRIDS[0]} to {_GRIDS[1]}; 2048 "
            "takes a minute or two"
        )
    found = empty_part(part)
    if part != "paper":
        _MODULES[part].add_lines(found, finest_grid=finest_grid)
    elif sample is None:
        raise SettingsError("part = 'paper' needs a sample: give a measured file")
    else:
        paper.add_lines(found, sample, finest_grid=finest_grid)
    return found
