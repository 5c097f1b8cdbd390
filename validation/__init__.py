"""Validation: what the program computes, compared line by line with closed forms and other codes.

Every line states what is compared, the reference, the computed value, their deviation, its tolerance, and
where formula, source and test are. The texts stand in `tables`. `lines` makes lines and sections of them,
each section is a module with a function `add_lines`, `problems` has what several of them solve, `sections`
computes one by its name, `drawing` has the figures, and `page` writes page and table.
"""

from typing import Literal, get_args

# in the order of the page; each is a module of this package with a function `add_lines`
SectionName = Literal[
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
    "cycles",
    "adhesion",
    "formats",
]
SECTIONS: tuple[SectionName, ...] = get_args(SectionName)
