"""The parts of the validation, by name, and the verb that computes one."""

from importlib import import_module

from roughcontact.errors import SettingsError
from roughcontact.validation.lines import Part

# in the order of the page; each is a module of this package with a function `part`
PARTS = ("paper", "waves", "hertz", "full_contact", "convergence", "rough", "consistency")


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
    from roughcontact.validation import (  # noqa: F401 - named here so that an edit of one reruns the job
        consistency,
        convergence,
        full_contact,
        hertz,
        paper,
        rough,
        waves,
    )

    if part not in PARTS:
        raise SettingsError(f"part = {part!r} of the validation; there are {', '.join(PARTS)}")
    if finest_grid < 256 or finest_grid & (finest_grid - 1):
        raise SettingsError(
            f"validation.finest_grid = {finest_grid}: must be a power of 2, 256 or more (2048 takes a minute "
            f"or two)"
        )
    module = import_module(f"roughcontact.validation.{part}")
    given = {"sample": sample} if part == "paper" else {}
    return module.part(finest_grid=finest_grid, **given)
