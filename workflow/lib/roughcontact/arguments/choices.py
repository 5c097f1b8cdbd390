"""The words and limits that settings, verbs and schema share; each stands here once.

The settings are read before anything is computed, so this module imports nothing heavy.
"""

from typing import Literal

LevelForm = Literal["none", "mean", "plane", "polynomial", "sphere", "cylinder"]
LineAlignment = Literal["auto", "none", "jitter", "median", "matched-steps"]
Fill = Literal["harmonic", "none"]

Placement = Literal["largest", "whole-periods"]
WindowMethod = Literal["smooth-cross-fade", "periodic-plus-smooth", "cross-fade", "mirror", "taper", "raw"]

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
