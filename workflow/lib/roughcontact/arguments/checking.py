"""Checks of height maps and of arguments that the public functions make first."""

import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from inspect import signature
from typing import TYPE_CHECKING, Any, cast

from roughcontact.arguments.kinds import facts_of, properties_of_map
from roughcontact.errors import HeightMapError, HeightMapWarning, SettingsError

if TYPE_CHECKING:  # a run with nothing to do imports this module, but no large library
    import numpy as np
    import xarray as xr

# limits of every length, pressure and ratio, so far within the range of floats that squares of products are
# finite
SMALLEST, LARGEST = 1e-100, 1e100
MAX_GRADIENT = 3.0  # rms gradient (72°) above all that are measured: a unit is wrong
_LABEL = "label it by roughcontact.height_map(values, spacing)"
MIN_MAP_POINTS = 16  # of a map whose contact may mean something


def check_labelled(height: object) -> "xr.DataArray":
    """Return a height map as it is, or refuse one without labels, real numbers, even positions or two points.

    The attribute `source_file` names it in the message.

    Examples
    --------
    >>> import numpy as np
    >>> check_labelled(np.zeros((4, 4)))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    roughcontact.errors.HeightMapError: the map is of type ndarray, its pixel size is unknown; label it by ...
    """
    if problem := next(_problems(height), ""):
        raise HeightMapError(problem)
    return cast("xr.DataArray", height)


def _problems(height: Any) -> Iterator[str]:
    """Yield what a height map lacks; only the first counts, since the next ones take it for granted."""
    import xarray as xr

    if not isinstance(height, xr.DataArray):
        yield f"the map is of type {type(height).__name__}, its pixel size is unknown; {_LABEL}"
    name = height.attrs.get("source_file") or "the map"
    if hasattr(height.data, "magnitude"):
        yield f"{name} holds quantities of pint: give height.pint.dequantify(), with its units"
    dtype_kind = getattr(height.dtype, "kind", None)  # of NumPy's types
    # dtypes of other libraries have no kind
    if dtype_kind not in ("f", "i", "u") and (
        dtype_kind or str(height.dtype).startswith(("bool", "complex"))
    ):
        yield f"{name} holds values of type {height.dtype}: heights are real numbers"
    if height.dims != ("y", "x"):
        yield f"{name} has the dimensions {height.dims}: {_suggest_way(height)}"
    if height.size < 2:
        points = "a single point" if height.size else "no points"
        yield f"{name} has {points}: at least two are needed; check how the file was cut or read"
    for axis in height.dims:
        coordinate = f"coordinate {axis!r} of {name}"
        if axis not in height.coords:
            yield f"{name} has no coordinate {axis!r}: its pixel size is unknown; {_LABEL}"
        if (dtype := height.coords.variables[axis].dtype).kind not in "fiu":
            yield f"{coordinate} holds values of type {dtype}: positions are real numbers, in metres"
        positions = height.get_index(axis).values
        steps = positions[1:] - positions[:-1]
        # without `numpy.diff`: this module is imported before NumPy is needed
        if steps.size and not (steps > 0).all():
            yield f"{coordinate} does not increase strictly; sort the map, height.sortby(['y', 'x'])"
        # coordinates are sums of rounded steps: allow for their rounding, not for uneven sampling
        if steps.size and steps.max() - steps.min() > 1e-3 * steps.mean():
            uneven = f"(steps {steps.min():g} to {steps.max():g})"
            yield f"{coordinate} is not evenly spaced {uneven}; resample the map first"


def _suggest_way(height: "xr.DataArray") -> str:
    """Return what makes a map (y, x) of an array of other dimensions."""
    if height.ndim < 2:
        return _LABEL.replace("it", "the values", 1)
    rows_and_columns = zip(height.dims[-2:], "yx", strict=True)  # the last two
    if missing := {old: new for old, new in rows_and_columns if old not in ("y", "x")}:
        return f"rename them, height.rename({missing})"
    further = ", ".join(f"{dim}=0" for dim in height.dims if dim not in ("y", "x"))
    return f"select one map, height.isel({further})" if further else "transpose it to ('y', 'x')"


def check_solution(contact: object, *, of_loads: bool = True) -> None:
    """Raise SettingsError, with what is wrong, unless it is a solution with its maps, `of_loads` or one."""
    import xarray as xr

    problem = f"this is of type {type(contact).__name__}"
    if isinstance(contact, xr.Dataset):
        names = ("height", "pressure", "gap")
        problem = next((f"the dataset has no {name}" for name in names if name not in contact), "")
        if of_loads and not problem and "load" not in contact["pressure"].dims:
            raise SettingsError("the dataset has no dimension load: select by a list, contact.isel(load=[0])")
        if not problem and contact["pressure"].dims[-2:] != ("y", "x"):
            problem = f"the pressure has the dimensions {contact['pressure'].dims}"
    if problem:
        raise SettingsError(
            f"{problem}: give the solution of solve_contact, or contact.nc (contact.keep_fields: true)"
        )


def check_periodic_solution(contact: "xr.Dataset") -> None:
    """Raise SettingsError for anything else than a solution of a periodic map, with its maps."""
    check_solution(contact)
    check_applies("solution", contact.attrs)


def check_applies(name: str, attrs: Mapping[Any, Any]) -> None:
    """Raise SettingsError where a function does not apply to the kind of a map, by its attributes."""
    if reason := facts_of(attrs).reason_against(name, properties_of_map(attrs)):
        raise SettingsError(reason)


def check_map(height: "xr.DataArray") -> "np.ndarray":
    """Return a copy of the heights (m) as float64, NaN where not finite, or raise a HeightMapError.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> check_map(height_map([[1, np.inf, 3]], 1e-6))
    array([[ 1., nan,  3.]])
    """
    name = check_labelled(height).attrs.get("source_file") or "the map"
    import numpy as np

    values = np.asarray(height.values, dtype=float)
    values = np.where(np.isfinite(values), values, np.nan)
    if np.isnan(values).all():
        raise HeightMapError(
            f"all {values.size} points of {name} are missing: choose another channel, or measure again"
        )
    # zero is a height like others
    if (largest := float(np.nanmax(np.abs(values)))) and not SMALLEST <= largest <= LARGEST:
        raise HeightMapError(f"{name} has heights of {largest:g} m: check the unit, or how the file was read")
    warn_of_unit(height, stacklevel=5)
    return values


def warn_of_unit(height: "xr.DataArray", *, stacklevel: int) -> None:
    """Warn the caller of a public function of a map (y, x) without all `units` that is no map in metres."""
    from roughcontact.arguments.si import unit_of, warn_of_metres

    positions = [height.coords.variables[axis] for axis in height.dims]
    if None in map(unit_of, [height.attrs, *(axis.attrs for axis in positions if axis.size > 1)]):
        warn_of_metres([axis.values for axis in positions], height.values, stacklevel=stacklevel + 1)


def warn_of_map(shape: tuple[int, ...], rms_gradient: float, *, stacklevel: int = 4) -> None:
    """Warn the caller of a public function of fewer than 16 points, or an rms gradient above 3.

    `stacklevel` is the distance of the caller to warn; 4 of functions that convert their arguments (`as_si`).
    """
    (ny, nx), doubts = shape, []
    if ny * nx < MIN_MAP_POINTS:
        contact = f"that is no rough surface, and its contact is that of {ny * nx} pixels"
        doubts.append(f"the map has {ny} x {nx} points: {contact}; check how it was cut or read")
    if rms_gradient > MAX_GRADIENT:
        doubts.append(
            f"the rms gradient of the map is {rms_gradient:.3g}, steeper than any measured surface: the "
            "units of heights and positions differ, or one of them is wrong"
        )
    for doubt in doubts:
        warnings.warn(doubt, HeightMapWarning, stacklevel=stacklevel)


def check_keys(section: str, values: Mapping[str, Any] | None, function: Callable[..., Any]) -> None:
    """Raise SettingsError where the keys of a section are no arguments by keyword of the function."""
    options = [
        option for option in signature(function).parameters.values() if option.kind is option.KEYWORD_ONLY
    ]
    required_names = {option.name for option in options if option.default is option.empty}
    names = [option.name for option in options]
    if values is not None and not required_names <= values.keys() <= {*names}:
        text = f"{section} has {', '.join(values) or 'no keys'}: takes {', '.join(names)}"
        missing = ", ".join(name for name in names if name in required_names - values.keys())
        raise SettingsError(text + (f"; needs {missing}" if missing else ""), keys=[section])


def check_positive(name: str, value: Any, *, unit: str) -> float:
    """Return a value, a number or text, as a float where it is a finite positive number in `unit`.

    Examples
    --------
    >>> check_positive("contact_modulus", "1e9", unit="Pa")
    1000000000.0
    """
    try:
        # a truth value of NumPy is told by its type's name: NumPy is not imported for settings
        truth = isinstance(value, bool) or str(getattr(value, "dtype", "")) == "bool"
        number = float("true or false" if truth else value)
        problem = (
            "" if math.isfinite(number) and number > 0 else f"must be a positive finite number in {unit}"
        )
        if not problem and not SMALLEST <= number <= LARGEST:
            problem = f"is beyond the computable range; check the number and its unit ({unit})"
        text = f"{number:g}"
    except (TypeError, ValueError):
        text, problem = repr(value), f"is not a number; give a positive number in {unit}"
    if problem:
        raise SettingsError(f"{name} = {text} {problem}", keys=[name])
    return number


def marker_values(marker_text: float | str | None, where: str = "missing_value") -> list[float]:
    """Return the numbers that the user states, as for missing points, one or several between blanks.

    Examples
    --------
    >>> marker_values("-9999 0"), marker_values(-25400), marker_values(None)
    ([-9999.0, 0.0], [-25400.0], [])
    """
    try:
        return [float(marker) for marker in str("" if marker_text is None else marker_text).split()]
    except ValueError as error:
        raise SettingsError(
            f"{where} = {marker_text!r}: give numbers, separated by blanks (a height in the unit of the file)"
        ) from error
