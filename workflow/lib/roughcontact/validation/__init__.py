"""Validation: what the program computes, held line by line against what is known from elsewhere.

Every line states what was compared, the reference, our value, their deviation, its tolerance, and where
formula, source and test are. Rooms: `lines` (a line, a part, what holds), one module for each part, `parts`
(the public verb that computes one), `drawing` (figures), `page` (the page for people, and what fails).
"""

from typing import Literal, get_args

# in the order of the page; each is a module of this package with a function `part`
PartName = Literal[
    "paper",
    "waves",
    "hertz",
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
