"""The verb that computes one section of the validation."""

from pathlib import Path

from roughcontact.arguments.choices import check_choice
from roughcontact.errors import SettingsError
from validation import (
    SectionName,
    adhesion,
    conductance,
    consistency,
    convergence,
    coverage,
    cycles,
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
from validation.lines import Section, empty_section

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
    "cycles": cycles,
    "adhesion": adhesion,
    "formats": formats,
}


def validate(section: SectionName, sample: str | Path | None = None, *, finest_grid: int = 2048) -> Section:
    """Compute one section of the validation.

    Parameters
    ----------
    section : str
        one of `validation.PARTS`.
    sample : str or Path, optional
        measured file of the paper's three steps; only the section ``paper`` needs it.
    finest_grid : int
        points along the finest grid, a power of 2 from 256 to 16384. Rows are solved with so many points,
        single maps with half, ensembles with a quarter; tolerances follow the grid.

    Returns
    -------
    Section

    Raises
    ------
    SettingsError
        for a section that does not exist, a grid of another size, or the section ``paper`` without a sample.

    Examples
    --------
    >>> section = validate("full_contact", finest_grid=256)
    >>> len(section.lines), all(line.holds for line in section.lines)
    (18, True)
    """
    check_choice("section", section, SectionName)
    if not _GRIDS[0] <= finest_grid <= _GRIDS[1] or finest_grid & (finest_grid - 1):
        raise SettingsError(
            f"finest_grid = {finest_grid}: must be a power of 2 from {_GRIDS[0]} to {_GRIDS[1]}; 2048 "
            "takes a minute or two"
        )
    computed = empty_section(section)
    if section != "paper":
        _MODULES[section].add_lines(computed, finest_grid=finest_grid)
    elif sample is None:
        raise SettingsError("section = 'paper' needs a sample: give a measured file")
    else:
        paper.add_lines(computed, sample, finest_grid=finest_grid)
    return computed
