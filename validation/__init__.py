"""Validation: what the program computes, held line by line against what is known from elsewhere.

Every line states what was compared, the reference, our value, their deviation, its tolerance, and where
formula, source and test are. The words stand in `tables`; `lines` makes lines and parts of them, `problems`
has what several parts solve, one module for each part computes its numbers, `parts` has the public verb,
`drawing` the figures, `page` the page for people and the message about lines that do not hold.
"""

from typing import Literal, get_args

# in the order of the page; each is a module of this package with a function `add_lines`
PartName = Literal[
    "paper",
    "waves",
    "hertz",
    "layers",
    "full_contact",
    "convergence",
    "rough",
    "consistency",
    "coverage",
    "conductance",
    "sealing",
    "subsurface",
    "targets",
    "patches",
    "adhesion",
    "formats",
]
PARTS: tuple[PartName, ...] = get_args(PartName)
