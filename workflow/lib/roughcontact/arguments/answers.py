"""What a load is asked for: one table behind page, screen, groups, cases, methods and files.

A row has all that is known of an answer, or of a quantity with an interval, before anything is solved: its
words, heading and unit, its scale, limits and trend. The rows are in the order in which people read them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from roughcontact.arguments.rows import rows_beside

AREA, GAP, PEAK, PRESSURE = "relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure"
CONDUCTANCE, FRICTION = "conductance_per_conductivity", "hysteretic_friction_coefficient"
APPROACH = "mutual_approach"
ENDS = ("", "_lower", "_upper")  # of the names of a quantity: the value, and the ends of its interval
OPPOSITE_ENDS = dict(zip(ENDS, ("", "_upper", "_lower"), strict=True))  # those of the inverse of it

Limits = Callable[[np.ndarray, float], tuple[np.ndarray | float, float]]  # of load and hardness (Pa)


class Column(NamedTuple):
    """A number against load, in the tables of the page."""

    table: str  # its title; empty for the load, which is in all of them
    name: str
    heading: str
    unit: str  # "%" for a share, "m" for heights and gaps, "m along" for other lengths


COLUMNS = [Column(*row) for row in rows_beside(__file__, "tables.tsv")]
TITLES = {column.name: column.heading for column in COLUMNS}
UNITS = {column.name: column.unit for column in COLUMNS}
TABLES = {column.name: column.table for column in COLUMNS}


@dataclass(frozen=True)
class Quantity:
    """A number of a load that has an interval of its own."""

    words: str  # in descriptions
    trend: int = 0  # 1 where it rises with the load, so that the ends of its interval do, -1 where it falls
    scale: str = "logarithm"  # on which it scatters alike at all loads (`uncertainty.scales`)
    limits: Limits | None = None  # lowest and highest value, where the hardness bounds it


def _pressure_limits(load: np.ndarray, hardness: float) -> tuple[np.ndarray, float]:
    """Return the limits of a pressure in contact: the load spread over all of the area, and the hardness."""
    return load, hardness


QUANTITIES = {
    AREA: Quantity("contact area", 1, "load", lambda load, hardness: (load / hardness, 1.0)),
    GAP: Quantity("mean gap", -1),
    PEAK: Quantity("largest pressure", 1, limits=_pressure_limits),
    # more load brings new patches, which carry less: it may fall
    PRESSURE: Quantity("pressure in contact", 0, limits=_pressure_limits),
    CONDUCTANCE: Quantity("conductance over the mean conductivity", 1),
    APPROACH: Quantity("approach", 1),  # of a body of finite size
    # they may be closed, and a closed one has no logarithm
    "critical_constriction_x": Quantity("narrowest place along x", -1, "length"),
    "critical_constriction_y": Quantity("narrowest place along y", -1, "length"),
}


@dataclass(frozen=True)
class Answer:
    """What a load is asked for: with a column, a verdict (`{name}_verdict`), a precision (`{name}_known`)."""

    words: str  # in a sentence
    heading: str  # of its column
    quantity: str = ""  # whose interval tells how well it is known; none of a yes or no
    starts: tuple[str, ...] = ()  # of the names of the variables that belong to it
    main: bool = False  # whether the verdict on the load is its own


ANSWERS = {
    AREA: Answer("contact area", TITLES[AREA], AREA, (AREA,), main=True),
    PRESSURE: Answer("pressure in contact", TITLES[PRESSURE], PRESSURE, (PRESSURE,), main=True),
    GAP: Answer("mean gap", TITLES[GAP], GAP, (GAP,)),
    "sealing": Answer("sealing", "seals?", starts=("critical_constriction", "leak", "total_leak")),
    "yield": Answer("yield", "yields?"),
    PEAK: Answer("largest pressure", TITLES[PEAK], PEAK, (PEAK,)),
    "conductance": Answer(
        "conductance",
        "conductance",
        CONDUCTANCE,
        ("conductance", "thermal", "electrical", "total_", "joint", "temperature"),
    ),
}

# total -> the number of a load that it is in proportion to, and the powers of what seal or joint state
TOTALS: dict[str, tuple[str, dict[str, int]]] = {
    "total_leak_rate_x": ("leak_rate_x", {"perimeter": 1}),
    "total_leak_rate_y": ("leak_rate_y", {"perimeter": 1}),
    "total_electrical_resistance": ("electrical_resistance", {"area": -1}),
    "total_thermal_resistance": ("resistance_of_joint", {"area": -1}),
    "temperature_drop": ("resistance_of_joint", {"area": -1, "heat_flow": 1}),
    "total_force": ("mean_pressure", {"area": 1}),
    "joint_resistance": ("resistance_of_joint", {"allowed_thermal_resistance": 0}),  # where it is asked for
}


@dataclass(frozen=True)
class AllowedValue:
    """What a number may be at most, or has to be at least: answered by `{name}_holds` (load).

    It is the setting `allowed_{name}` of `statistics`, `seal` or `joint`, or `name` of `requirement`.
    """

    words: str  # in a sentence
    numbers: tuple[str, ...]  # what is compared: the largest of those that there are
    unit: str  # as in `tables.tsv`
    answer: str  # that it belongs to
    trend: int = -1  # 1 where the number rises with the load, so that it holds up to one
    sense: int = 1  # -1 where the number has to be at least this large
    power: int = 0  # of heights and load, which grow together, in the number of linear bodies

    @property
    def bound(self) -> str:
        """Say on which side of the allowed value the number has to be."""
        return "most" if self.sense > 0 else "least"


ALLOWED_VALUES = {
    "leak": AllowedValue("leak", ("total_leak_rate_x", "total_leak_rate_y"), "m3 s-1", "sealing", power=3),
    "resistance": AllowedValue("resistance", ("total_electrical_resistance",), "Ohm", "conductance"),
    "temperature_drop": AllowedValue("temperature drop", ("temperature_drop",), "K", "conductance"),
    "pressure": AllowedValue("largest pressure", (PEAK,), "Pa", PEAK, trend=1, power=1),
    "thermal_resistance": AllowedValue(
        "thermal resistance times area", ("joint_resistance",), "m2 K W-1", "conductance"
    ),
    "contact_resistance": AllowedValue(
        "specific contact resistance", ("electrical_resistance",), "Ohm m2", "conductance"
    ),
    "gap": AllowedValue("mean gap", (GAP,), "m", GAP, power=1),
    "contact_area": AllowedValue("relative contact area", (AREA,), "1", AREA, sense=-1),
}
# what is known of bodies that have crept under a constant load
CREEPING = (
    *(AREA, GAP, "contact_radius", CONDUCTANCE, "thermal_conductance", "electrical_conductance"),
    *("joint_conductance", "leak_rate_x", "leak_rate_y"),
)
USUAL = (AREA, PRESSURE, GAP)  # what is shown where nothing in particular is asked for
# column of a table at a glance -> the numbers of which any shows that it is asked for
ASKED_BY = {
    "contact_radius": ("contact_radius",),
    APPROACH: (APPROACH,),
    "sealing": ("leak_rate_x",),
    PEAK: ("contact_radius", "allowed_pressure"),
    "conductance": ("joint_conductance", "joint_area", "temperature_drop", "allowed_resistance"),
    "friction_coefficient": ("friction_coefficient",),
    "max_flash_temperature": ("max_flash_temperature",),
}
COMPARED = tuple(name for name, answer in ANSWERS.items() if answer.quantity == name)  # numbers of each load


def answer_name(name: str) -> str:
    """Return the answer that a variable belongs to; empty for none.

    Examples
    --------
    >>> answer_name("thermal_resistance"), answer_name("mean_gap_lower"), answer_name("elastic_energy")
    ('conductance', 'mean_gap', '')
    """
    return next((key for key, answer in ANSWERS.items() if name.startswith(answer.starts)), "")
