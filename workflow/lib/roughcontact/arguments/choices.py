"""The words and limits that settings, verbs and schema share; each stands here once.

The settings are read before anything is computed, so this module imports nothing heavy.
"""

import difflib
from typing import Any, Literal, get_args

from roughcontact.errors import SettingsError

LevelForm = Literal["none", "mean", "plane", "polynomial", "sphere", "cylinder"]
LineAlignment = Literal["auto", "none", "jitter", "median", "matched-steps"]
Fill = Literal["harmonic", "none"]

Placement = Literal["largest", "whole-periods"]
WindowMethod = Literal["smooth-cross-fade", "periodic-plus-smooth", "cross-fade", "mirror", "taper", "raw"]
# ways to make a window periodic, in words
PERIODIC_BY = {
    "smooth-cross-fade": "blending opposite edges",
    "cross-fade": "blending opposite edges",
    "periodic-plus-smooth": "subtracting the step between opposite edges",
    "mirror": "adding its mirror images",
    "taper": "fading the heights out at the edges",
}

ZeroFrequency = Literal["zero", "nogi-kato", "lattice"]
Influence = Literal["sampled", "elements"]
Boundary = Literal["periodic", "free"]
Precision = Literal["double", "single"]
OnFailure = Literal["raise", "flag"]
LoadTarget = Literal["percolation", "first_yield"]
# what rounding leaves of the error bound of the smallest maps; that of a larger one is higher, and the solver
# says so where it meets it
MIN_TOLERANCE = 1e-15
MAX_ORDER = 12  # of a polynomial form: 91 terms; what is bent more often is waviness

Extra = Literal["auto", "always", "never"]  # what is computed beside the contact

UncertaintySource = Literal[
    "solver", "discretisation", "window", "instrument", "material", "hardness", "unresolved"
]
Resampling = Literal["linear"]
Checksum = Literal["ignore"]
Lay = Literal["across", "none"]  # of a profile
LayInGroup = Literal["across", "along", "none"]  # of a row of the table: one along serves those across
FirstRow = Literal["top", "bottom"]  # of a file, in the picture that programs show of it


def check_choice(key: str, value: object, choices: Any) -> None:
    """Raise a SettingsError, with the nearest valid word, where a value is not among the choices."""
    choices_allowed = get_args(choices)
    if value in choices_allowed:
        return
    # the nearest one, as most mistakes are of spelling
    close_matches = difflib.get_close_matches(str(value), choices_allowed, n=1)
    hint = f"did you mean {close_matches[0]!r}? " if close_matches else ""
    valid = " or ".join(", ".join(choices_allowed).rsplit(", ", 1))
    raise SettingsError(f"{key} = {value!r}: {hint}choose {valid}", keys=[key])
