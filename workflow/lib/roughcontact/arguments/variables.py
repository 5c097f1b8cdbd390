"""The output variables, with unit and meaning: those of `variables.tsv`, and those derived from them.

`describe` adds units and a sentence to every variable of a dataset, so that each file has them.
"""

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ALLOWED_VALUES, ANSWERS, ASKED_BY, CREEPING, QUANTITIES, TOTALS
from roughcontact.arguments.rows import rows_beside
from roughcontact.errors import RoughContactError

Numbers = xr.Dataset | Mapping[str, Any]  # statistics, or their plain values by name


# name -> unit in UDUNITS spelling, and meaning
VARIABLES: dict[str, tuple[str | None, str]] = {
    name: (unit or None, meaning) for name, unit, meaning in rows_beside(__file__, "variables.tsv")
}
for _name, _allowed in ALLOWED_VALUES.items():
    _side = "from which on" if _allowed.trend < 0 else "up to which"
    _holds = f"the {_allowed.words} is at {_allowed.bound} what is allowed"
    VARIABLES |= {
        f"allowed_{_name}": (_allowed.unit, f"largest {_allowed.words} that is allowed"),
        f"{_name}_holds": ("1", f"1: {_holds} in all of its interval, 0: in none of it; none: not decided"),
        f"{_name}_holds_from": ("Pa", f"mean pressure {_side} {_holds}"),
        f"{_name}_largest_Sq": ("m", f"largest Sq of this texture with which {_holds}"),
    }

# whose interval follows from another one
_DERIVED = [
    *("leak_rate_x", "leak_rate_y", "friction_coefficient", "mean_pressure", "contact_stiffness"),
    *("running_in_distance", "hysteretic_friction_coefficient", "adhesive_friction_coefficient"),
    *(f"{name}_{number}" for name in ALLOWED_VALUES for number in ("holds_from", "largest_Sq")),
    *("joint_conductance", "contact_area", "contact_radius", *TOTALS),
    *(f"{name}_after" for name in CREEPING),
    *("pressure_flow_factor_x", "pressure_flow_factor_y", "shear_flow_factor_x", "shear_flow_factor_y"),
    *("thermal_conductance", "thermal_resistance", "electrical_conductance", "electrical_resistance"),
    *(name for name in VARIABLES if name.startswith("local_")),
]
_RANGES = ("hardness", "thermal_conductivity", "electrical_resistivity", "shear_strength")
# what has the endings of `endings.tsv` -> names of the variables, and their words
_WORDS: dict[str, dict[str, str]] = {
    "creeping": {name: VARIABLES[name][1] for name in CREEPING},
    "derived": {name: name.replace("_", " ") for name in _DERIVED},
    "range": {name: name.replace("_", " ") for name in _RANGES},
    "quantity": {name: quantity.words for name, quantity in QUANTITIES.items()},
    "number": {name: answer.words for name, answer in ANSWERS.items() if answer.quantity},
    "decision": {name: answer.words for name, answer in ANSWERS.items() if not answer.quantity},
}
for _name, _quantity in QUANTITIES.items():  # by its scale: a length is its own, all others have none
    _WORDS.setdefault(_quantity.scale, {})[_name] = _quantity.words
_ENDINGS = rows_beside(__file__, "endings.tsv")
for _kind, _words in _WORDS.items():
    _of_kind = [row for of, *row in _ENDINGS if _kind in of.split(", ")]
    for (_name, _in_words), (_ending, _unit, _meaning) in product(_words.items(), _of_kind):
        VARIABLES[f"{_name}_{_ending}"] = _unit or VARIABLES[_name][0], _meaning.format(_in_words)

# comments of variables that need more than a line
_COMMENTS = {
    "approach": (
        "gap = displacement - height + approach, the displacement positive into the half-space. Its mean is "
        "what the setting zero_frequency makes of the load: nothing by the rule zero, by which the approach "
        "is the mean gap plus the mean height where no point yields."
    )
}

# meanings of the values 0, 1, 2 ... of a flag
_FLAGS = {name: ("use", "review", "do_not_use") for name in VARIABLES if name.endswith("verdict")}

# CF has this standard name for distances on a plane; without it checkers take an axis for a longitude
_AXES = {
    "x": {"axis": "X", "standard_name": "projection_x_coordinate"},
    "y": {"axis": "Y", "standard_name": "projection_y_coordinate"},
    "depth": {"axis": "Z", "positive": "down"},
}


def values_at_load(statistics: xr.Dataset, index: int) -> dict[str, np.ndarray]:
    """Return the plain values of all variables at one load; those of no load as they are.

    Examples
    --------
    >>> statistics = xr.Dataset({"contact_modulus": 1e9, "mean_gap": ("load", [2e-7, 1e-7])})
    >>> values_at_load(statistics, 1)["mean_gap"].item()
    1e-07
    """
    # looking up a variable of a dataset, with its coordinates, takes a hundred times as long
    return {
        str(name): variable.values.take(index, variable.dims.index("load"))
        if "load" in variable.dims
        else variable.values
        for name, variable in statistics.variables.items()
    }


def describe(dataset: xr.Dataset) -> xr.Dataset:
    """Return a copy of a dataset with `units` and `long_name` of `VARIABLES` on every variable (CF).

    A variable that is not in the table keeps its own `units` and `long_name`, and is refused without. Longer
    explanations are in `comment`; `x`, `y` and `depth`
    get their `axis`, flags their `flag_values` and `flag_meanings`, and bins describe their bounds.
    """
    metadata = {name: variable.attrs for name, variable in dataset.variables.items() if name not in VARIABLES}
    if nameless := [name for name, attrs in metadata.items() if not {"units", "long_name"} <= {*attrs}]:
        raise RoughContactError(
            f"no description for the output variables {nameless}: give them the attributes units (1 for a "
            "plain number) and long_name"
        )
    dataset = dataset.copy()
    bounds = {variable.attrs.get("bounds") for variable in dataset.variables.values()}
    for name, variable in dataset.variables.items():
        units, long_name = VARIABLES.get(str(name), (None, variable.attrs.get("long_name")))
        if name not in bounds:
            variable.attrs["long_name"] = long_name
        if units is not None:
            variable.attrs["units"] = units
        if name in _COMMENTS:
            variable.attrs["comment"] = _COMMENTS[str(name)]
        if name in _FLAGS:
            variable.attrs["flag_values"] = np.arange(len(_FLAGS[str(name)]), dtype=variable.dtype)
            variable.attrs["flag_meanings"] = " ".join(_FLAGS[str(name)])
        if name in dataset.dims:
            variable.attrs |= _AXES.get(str(name), {})
    return dataset


def has_number(numbers: Numbers, name: str) -> bool:
    """Return whether a number is present, at one load at least."""
    return name in numbers and bool(np.isfinite(np.asarray(numbers[name], float)).any())


def names_asked(numbers: Numbers) -> set[str]:
    """Return the columns of `ASKED_BY` that a result is asked for in particular.

    Examples
    --------
    >>> names_asked({"leak_rate_x": [1e-9]}), names_asked({"mean_gap": [1e-7]})
    ({'sealing'}, set())
    """
    return {key for key, by in ASKED_BY.items() if any(has_number(numbers, name) for name in by)}
