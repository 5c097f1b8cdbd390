"""The scale of a map: steps and units from the file, and from the user.

The user overrides the file, with a note where they differ. Missing values are never guessed.
"""

from collections.abc import Iterator

from roughcontact.arguments.checking import check_positive
from roughcontact.arguments.si import convert_quantity
from roughcontact.arguments.units import carries_unit
from roughcontact.errors import InputFileError, SettingsError
from roughcontact.io.channels import Channel
from roughcontact.io.guards import refusal
from roughcontact.io.request import Request
from roughcontact.io.sources import quoted, says_another_unit
from roughcontact.io.units import is_length, metres

_SHORTEST = 1e-30  # m; steps from this to its inverse cause no overflow
_WIDE_PIXEL = 1.5  # dx over dy of lines that may be halves of longer ones
_MIN_LINES = 10  # of a matrix whose pixels reveal that it was cut off


def decide_scale(channel: Channel, request: Request) -> tuple[tuple[float, float], float, list[str]]:
    """Return the steps (dx, dy; m) of a channel on an even grid, the metres per unit of its heights, notes.

    They are those of the user, else of the file; the notes are arguments that contradict it. Of a profile
    without a step along y both steps are that along x.

    Examples
    --------
    >>> said = Channel("height", (3, 4), lambda: None, height_unit="nm", dx=2.0, dy=2.0, lateral_unit="um")
    >>> decide_scale(said, Request(dx=5.0, unit="um"))[:2]
    ((4.9999999999999996e-06, 2e-06), 1e-09)
    >>> decide_scale(said, Request(dx=5.0, unit="um"))[2]
    ['dx = 5e-06 m as given by the user, where the file says 2e-06 m']
    """
    if channel.no_height and request.height_unit is None and not is_length(channel.height_unit):
        raise refusal("no heights in a channel", name=channel.name, why=channel.no_height)
    notes: list[str] = []
    dx, dy = _steps(channel, request, notes)
    # the width of a profile is never used; a step along y keeps its array like that of a map
    dy = dx if channel.is_line and dy is None else dy
    if dx is None or dy is None or _is_half_stated(channel, request):
        raise _missing_steps(channel, request)
    if not (_SHORTEST < dx < 1 / _SHORTEST and _SHORTEST < dy < 1 / _SHORTEST):
        raise refusal("impossible steps", dx=dx, dy=dy)
    if channel.size_rounding is not None and request.dx is None and request.dy is None:
        _refuse_cut_matrix(channel, dx, dy)
        if dx > _WIDE_PIXEL * dy:
            notes.append(f"pixels of {dx / dy:.3g} : 1 by the size alone: check whether lines were wrapped")
    return (dx, dy), _height_factor(channel, request, (dx, dy), notes), notes


def given_step(name: str, request: Request) -> float | None:
    """Return the step `dx` or `dy` (m) that the user gives, with its own unit or in `unit`; None: none.

    Examples
    --------
    >>> [given_step(name, Request(dx="1.5 um", dy=2.0, unit="mm")) for name in ("dx", "dy")]
    [1.5e-06, 0.002]
    """
    if (value := getattr(request, name)) is None:
        return None
    number = check_positive(name, convert_quantity("m", name, value), unit=request.unit or "m")
    if carries_unit(value):
        return number
    if request.unit is None:
        raise SettingsError(f"{name} = {value} is given without a unit; append it, or give unit")
    return number * metres(request.unit, where="unit", error=SettingsError)


def _steps(channel: Channel, request: Request, notes: list[str]) -> Iterator[float | None]:
    """Yield the steps along x and y in m, None if unknown; add notes where file and user differ."""
    factor, file_unit, is_needed = None, channel.lateral_unit, request.dx is None or request.dy is None
    if request.unit is not None:
        conflict = file_unit if is_needed and channel.dx is not None else None
        factor = _given_factor("unit", request.unit, "steps", conflict, notes)
    elif file_unit is not None and is_needed:
        factor = metres(file_unit, where="lateral unit")
    stated_unit = file_unit or request.unit
    for name, file_step in (("dx", channel.dx), ("dy", channel.dy)):
        step = given_step(name, request)
        if step and file_step is not None and is_length(stated_unit):
            in_file = file_step * metres(stated_unit)
            if abs(in_file / step - 1) > 1e-3:
                where = f"where the file says {in_file:.6g} m"
                notes.append(f"{name} = {step:.6g} m as given by the user, {where}")
        yield file_step * factor if step is None and file_step is not None and factor is not None else step


def _is_half_stated(channel: Channel, request: Request) -> bool:
    """Return whether the user gives one step, a line the other, and a length is there that nothing uses.

    Length and width, of which either may be along x.
    """
    has_step = [request.dx is not None, request.dy is not None]
    source = channel.sources.get("dy" if has_step[0] else "dx", "")
    is_half = channel.shape[0] > 1 and any(has_step) != all(has_step) and "line" in source
    return is_half and bool(quoted(channel, request))


def _height_factor(channel: Channel, request: Request, steps: tuple[float, float], notes: list[str]) -> float:
    """Return the metres per unit of the file's heights."""
    file_unit = channel.height_unit
    if request.height_unit is not None:
        return _given_factor("height_unit", request.height_unit, "heights", file_unit, notes)
    if file_unit is not None:
        return metres(file_unit, where="height unit")
    lengths = [*steps, steps[0] * channel.shape[1], steps[1] * channel.shape[0]]
    # the unit of x and y serves for the heights only where no line of the file has another one
    unsaid = "the file does not say the unit of its heights"
    if request.unit is None or says_another_unit(channel, request, lengths):
        raise refusal("no unit of heights", unsaid=unsaid, lines=quoted(channel, request))
    notes.append(f"{unsaid}: they are taken in {request.unit}, as x and y")
    return metres(request.unit, where="unit", error=SettingsError)


def _given_factor(name: str, unit: str, what: str, file_unit: str | None, notes: list[str]) -> float:
    """Return the metres of a unit that the user gives; add a note where the file says another one."""
    factor = metres(unit, where=name, error=SettingsError)
    if file_unit is not None and (not is_length(file_unit) or metres(file_unit) != factor):
        notes.append(f"the {what} are taken in {unit} as given by the user, where the file says {file_unit}")
    return factor


def _missing_steps(channel: Channel, request: Request) -> InputFileError:
    """Return the error for missing steps, with all arguments that the user must give.

    A unit given for x and y alone would be that of the heights too: theirs is asked for in one question.
    """
    ny, nx = channel.shape
    description = f"a profile of {nx} points" if ny == 1 else f"a map of {ny} x {nx} points"
    steps = ["dx", "dy"][:ny]
    absent = [name for name in steps if getattr(channel, name) is None]
    lines = quoted(channel, request)
    if lines and absent and any("line" in channel.sources.get(name, "") for name in steps):
        absent = steps  # which side the other line means is not known
    needed, heights = [*absent, "unit"], ""
    if channel.height_unit is not None:
        heights = f" (its heights are in {channel.height_unit})"
    elif request.height_unit is None:
        needed, heights = [*needed, "height_unit"], ", nor the unit of its heights"
    wrong = f"{description} that does not say its {'size' if absent else 'lateral unit'}{heights}{lines}"
    way_out = f"give {', '.join(needed)} in the table of surfaces or as arguments"
    return InputFileError(f"{wrong}; {way_out}", keys=needed)


def _refuse_cut_matrix(channel: Channel, dx: float, dy: float) -> None:
    """Refuse a text matrix whose pixels would be square with more lines.

    Accepted are every second, third ... line, pixels of 3 : 2 and 4 : 3, numbers of lines that no square
    pixels explain, sizes from the first point to the last, and maps of less than ten lines, whose pixels may
    have any shape.
    """
    ny, nx = channel.shape
    ratio = dy / dx
    square_rows = ny * ratio  # number of lines of square pixels
    slack = square_rows * sum(channel.size_rounding or ())
    chosen = any(abs(ratio / simple - 1) <= 0.5 / ny for simple in (max(round(ratio), 1), 3 / 2, 4 / 3))
    if ny < _MIN_LINES or square_rows - ny <= 0.5 + slack or chosen:
        return
    from_first_to_last = (ny * dy) / (nx * dx) * (nx - 1) + 1
    from_ends = abs(from_first_to_last - ny) <= 0.01 + slack and abs(square_rows - ny - 1) > 0.01
    if from_ends or abs(square_rows - round(square_rows)) > 0.01 + slack:
        return
    name = "cut matrix" if channel.height_unit else "cut matrix without a unit"
    raise refusal(name, ny=ny, nx=nx, dx=dx, dy=dy)
