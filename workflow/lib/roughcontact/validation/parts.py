"""The verb that computes one part of the validation."""

from roughcontact.errors import SettingsError
from roughcontact.validation import (
    PARTS,
    consistency,
    convergence,
    coverage,
    full_contact,
    hertz,
    paper,
    rough,
    waves,
)
from roughcontact.validation.lines import Part

_SMALLEST_GRID = 256


def validate(part: str, sample=None, *, finest_grid: int = 2048) -> Part:
    """Compute one part of the validation.

    Parameters
    ----------
    part : str
        one of `PARTS`.
    sample : path
        measured file of the paper's three steps; no other part needs it.
    finest_grid : int
        points along the finest grid, a power of 2 of at least 256. Rows are solved with so many points,
        single maps with half, ensembles with a quarter; tolerances follow the grid.

    Raises
    ------
    SettingsError
        for a part that there is not, or a grid of another size.
    """
    if part not in PARTS:
        raise SettingsError(f"part = {part!r} of the validation; there are {', '.join(PARTS)}")
    if finest_grid < _SMALLEST_GRID or finest_grid & (finest_grid - 1):
        raise SettingsError(
            f"validation.finest_grid = {finest_grid}: must be a power of 2, {_SMALLEST_GRID} or more; 2048 "
            f"takes a "
            "minute or two"
        )
    if part == "paper":
        return paper.part(sample, finest_grid=finest_grid)
    modules = {
        "waves": waves,
        "hertz": hertz,
        "full_contact": full_contact,
        "convergence": convergence,
        "rough": rough,
        "consistency": consistency,
        "coverage": coverage,
    }
    return modules[part].part(finest_grid=finest_grid)
