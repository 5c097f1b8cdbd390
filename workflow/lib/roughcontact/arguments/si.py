"""Arguments of the public functions in SI: maps by their attribute `units`, numbers by the unit in the text.

What carries no unit is in SI already.
"""

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import wraps
from inspect import signature
from types import UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin

import numpy as np
import xarray as xr

from roughcontact.arguments.choices import check_choice
from roughcontact.arguments.ranges import both_ends
from roughcontact.arguments.units import BASES, convert_to_base_unit, unit_factor, unknown_unit
from roughcontact.errors import HeightMapError, HeightMapWarning, SettingsError

_Function = TypeVar("_Function", bound=Callable[..., Any])
_Labelled = TypeVar("_Labelled", xr.DataArray, xr.Dataset)

# variables that have to be in a unit of this kind; a map alone is named as its heights are spoken of
_HEIGHTS = "the heights"
_FIELDS: dict[Any, str] = dict.fromkeys((_HEIGHTS, "y", "x", "height", "gap"), "m")
_WIDEST, _ROUGHEST = 1.0, 1e-3  # m, field and rms height beyond those of instruments for roughness
_FIELDS |= dict.fromkeys(("pressure", "mean_pressure"), "Pa")


def as_si(function: _Function) -> _Function:
    """Return a public function whose arguments are brought into SI, and of their kinds, before it begins.

    Examples
    --------
    >>> as_si(lambda hardness: hardness)(hardness="2 GPa")
    2000000000.0
    """
    return as_declared(function, _as_si)


def as_declared(
    function: _Function, convert: Callable[[str, Any], Any] = lambda _, value: value
) -> _Function:
    """Return a public function that refuses arguments of another kind than it declares.

    Examples
    --------
    >>> def tilted(angle: float | None = None):
    ...     return angle
    >>> as_declared(tilted)(angle="steep")
    Traceback (most recent call last):
    ...
    roughcontact.errors.SettingsError: angle = 'steep': give a number
    """
    kinds = {name: _kind(argument.annotation) for name, argument in signature(function).parameters.items()}

    def taken(name: str, value: Any) -> Any:
        kind, may_be_none = kinds.get(name, (None, True))
        result = convert(name, value)
        return result if kind is None or (may_be_none and value is None) else _of_kind(name, result, kind)

    # names of the arguments by position
    @wraps(function)
    def converted(*args: Any, **options: Any) -> Any:
        values = [taken(name, value) for name, value in zip(kinds, args, strict=False)]
        remaining = args[len(values) :]  # for the function to refuse
        return function(*values, *remaining, **{name: taken(name, value) for name, value in options.items()})

    return cast("_Function", converted)


_NUMBERS = (Sequence[float], tuple[float, float])
# kind that an argument may declare -> what to give
_KINDS = {bool: "True or False", int: "a whole number", float: "a number", Mapping: "a mapping"}
_KINDS |= dict.fromkeys(_NUMBERS, "a list of numbers")


def _kind(annotation: Any) -> tuple[Any, bool]:
    """Return the words, or the one of `_KINDS`, that an annotation names, and whether it admits None."""
    if get_origin(annotation) is Literal:
        return annotation, False
    named = get_args(annotation) if get_origin(annotation) in (UnionType, Union) else [annotation]
    kinds = {kind if kind in _NUMBERS else get_origin(kind) or kind for kind in named}
    others = kinds - {type(None)}
    return next(iter(others)) if len(others) == 1 and others <= {*_KINDS} else None, others < kinds


def _of_kind(name: str, value: Any, kind: Any) -> Any:
    """Return a value of a kind, or raise SettingsError; a number may be text or of any library."""
    if get_origin(kind) is Literal:
        check_choice(name, value, kind)
        return value
    if kind in (bool, Mapping):
        fits = isinstance(value, (bool, np.bool_) if kind is bool else Mapping)
    elif kind in _NUMBERS:
        value = listed(value)
        array = np.asarray(value, object)
        fits = array.ndim == 1 and all(getattr(np.asarray(item).dtype, "kind", "") in "fiu" for item in array)
    else:
        with suppress(ValueError):
            value = float(value) if isinstance(value, str) else value
        # a truth value is no number, and neither are several
        fits = np.ndim(value) == 0 and getattr(np.asarray(value).dtype, "kind", "") in "fiu"
        fits = bool(fits and (float(value).is_integer() if kind is int else not np.isnan(value)))
        value = int(value) if fits and kind is int else value
    if not fits:
        raise SettingsError(f"{name} = {value!r}: give {_KINDS[kind]}", keys=[name])
    return value


def _as_si(name: str, value: Any) -> Any:
    """Return the value of an argument in SI, or raise SettingsError for text with an unknown unit."""
    if isinstance(value, xr.DataArray):
        return _as_si(name, listed(value)) if name in BASES else labelled_in_si(value)
    if isinstance(value, xr.Dataset):
        return labelled_in_si(value)
    if isinstance(value, Mapping):
        inside = f"{name}." if name in ("seal", "joint", "requirement") else ""
        # keys of these sections are names of other quantities elsewhere
        return {key: _as_si(f"{inside}{key}", entry) for key, entry in value.items()}
    if isinstance(value, str) and name in BASES:
        value = both_ends(value) or value  # a range in text: both ends are converted
    if type(value) in (list, tuple):
        return type(value)(_as_si(name, entry) for entry in value)
    return convert_quantity(BASES[name], name, value) if name in BASES else value


def listed(value: Any) -> Any:
    """Return a setting with its arrays, at any depth, as lists or numbers: texts with the unit they state.

    Examples
    --------
    >>> listed(xr.DataArray([1.0, 2.0], attrs={"units": "MPa"})), listed(np.float32(0.5))
    (['1.0 MPa', '2.0 MPa'], 0.5)
    """
    if isinstance(value, Mapping):
        return {key: listed(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [listed(entry) for entry in value]
    if not hasattr(value, "__array__"):
        return value
    unit = unit_of(value.attrs) if isinstance(value, xr.DataArray) else None
    numbers = [f"{number!r} {unit}" if unit else number for number in np.ravel(value).tolist()]
    return numbers if np.ndim(value) else numbers[0]


def convert_quantity(base: str, name: str, value: Any) -> Any:
    """Return the value of an argument as `convert_to_base_unit`; SettingsError for an unknown unit."""
    try:
        return convert_to_base_unit(value, base)
    except ValueError as error:
        raise SettingsError(f"{name} = {value!r}: {error}", keys=[name]) from None


def labelled_in_si(map_or_dataset: _Labelled) -> _Labelled:
    """Return a map, or a dataset of maps, with lengths in m and pressures in Pa, by the attributes `units`.

    A unit of something else is refused; units on some of heights and positions alone give a warning.

    Examples
    --------
    >>> row = xr.DataArray([[1.0, 2.0]], {"y": [0.0], "x": ("x", [0.0, 5.0], {"units": "um"})}, ("y", "x"))
    >>> found = labelled_in_si(row.assign_attrs(units="nm"))
    >>> found.values, found["x"].values, found.attrs["units"]
    (array([[1.e-09, 2.e-09]]), array([0.e+00, 5.e-06]), 'm')
    """
    if isinstance(map_or_dataset, xr.DataArray):
        dataset = map_or_dataset.to_dataset(name=_HEIGHTS)
        converted_dataset = _dataset_in_si(dataset, map_or_dataset.attrs)
        if converted_dataset is dataset:
            return map_or_dataset
        return converted_dataset[_HEIGHTS].rename(map_or_dataset.name)
    return _dataset_in_si(map_or_dataset, map_or_dataset.attrs)


def _dataset_in_si(dataset: xr.Dataset, attrs: Mapping[Any, Any]) -> xr.Dataset:
    """Return a dataset of maps as `labelled_in_si`, itself where all is in SI; the `attrs` name it."""
    conversions: dict[Any, xr.Variable] = {}
    bare = []
    for name in (*dataset.coords, *dataset.data_vars):
        variable = dataset.variables[name]
        unit, base = unit_of(variable.attrs), _FIELDS.get(name)
        coordinate = name if name == _HEIGHTS else f"coordinate {name!r}"
        if unit is None and base and variable.size > 1:
            bare.append(coordinate)
        if unit is None or unit == base:
            continue
        # a variable of any name: by what its unit is of
        base = base or ("m" if unit_factor(unit, "m") else "Pa")
        factor = unit_factor(unit, base)
        if factor is None and name in _FIELDS:
            title = attrs.get("source_file") or "the map"
            raise HeightMapError(f"{coordinate} of {title}: {unknown_unit(unit, base)}")
        if factor not in (None, 1.0):  # not for a unit of something else, such as a flag
            further = {key: value for key, value in variable.attrs.items() if key != "unit"}
            # in double: integers and single precision would lose digits
            data = variable.data * np.float64(factor)
            conversions[name] = xr.Variable(variable.dims, data, further | {"units": base})
    # one of two that states its unit says nothing of the other
    if conversions and bare:
        warnings.warn(
            f"{' and '.join(bare)} of the map: no attribute units, taken in m, beside others that have one; "
            "state it",
            HeightMapWarning,
            stacklevel=5,
        )
    return dataset.assign(conversions) if conversions else dataset


def warn_of_metres(positions: Iterable[np.ndarray], heights: np.ndarray, *, stacklevel: int) -> None:
    """Warn the caller of a public function of a map without a unit, in metres larger than any measured."""
    field, finite_heights = max(map(np.ptp, positions)), heights[np.isfinite(heights)]
    with np.errstate(over="ignore"):
        rms_height = finite_heights.std() if finite_heights.size else 0.0
    if field > _WIDEST or rms_height > _ROUGHEST:
        warnings.warn(
            f"the map states no unit of heights or positions, taken in metres: a field of {field:.3g} m with "
            f"heights of {rms_height:.3g} m (rms); state it, by height_map(values, spacing, unit='um') or by "
            "the attributes `units` of heights and positions",
            HeightMapWarning,
            stacklevel=stacklevel,
        )


def unit_of(attrs: Mapping[Any, Any]) -> str | None:
    """Return the unit that the attributes of a variable state, or None."""
    unit = attrs.get("units", attrs.get("unit"))
    return None if unit is None else str(unit).strip() or None
