"""What can go wrong, one class per thing the user has to look at.

Every message names the file or the key, the value that is wrong, and the way out.
"""

import re
from collections.abc import Sequence

_TURNING = re.compile("[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")  # by Unicode's UAX 9


class RoughContactError(Exception):
    """Base of all errors raised on purpose by this package.

    Parameters
    ----------
    message : str
        what is wrong, and the way out.
    keys : sequence of str
        the settings, columns or arguments that `message` asks for, as it spells them: who offers them under
        other names, as options or fields, knows by these which ones are meant.
    place : str
        the setting or cell that is wrong, by its dotted name, ``contact.bodies[0].hardness``, or
        ``rows.7.dx`` for the column of a line of the table; empty where there is not just one.
    """

    def __init__(self, message: str = "", *, keys: Sequence[str] = (), place: str = "") -> None:
        super().__init__(message)
        self.keys = tuple(keys)
        self.place = place


class InputFileError(RoughContactError, ValueError):
    """A file that cannot be read, is no height map, or does not say its unit or its size."""


class SettingsError(RoughContactError, ValueError):
    """A setting, a table entry or a function argument that has no meaning.

    Parameters
    ----------
    message, keys, place
        As of `RoughContactError`.
    mistakes : sequence of SettingsError
        the single mistakes, where `message` lists several.

    Examples
    --------
    >>> error = SettingsError("level.order = 0: give a whole number of 1 or more", keys=["level.order"])
    >>> str(error), error.keys
    ('level.order = 0: give a whole number of 1 or more', ('level.order',))
    """

    def __init__(
        self,
        message: str = "",
        *,
        keys: Sequence[str] = (),
        place: str = "",
        mistakes: Sequence["SettingsError"] = (),
    ) -> None:
        super().__init__(message, keys=keys, place=place)
        self.mistakes = tuple(mistakes)


class OutputFileError(RoughContactError, OSError):
    """A result that cannot be written: the disk is full, the folder may not be written."""


class HeightMapError(RoughContactError, ValueError):
    """A height map that was read well but cannot be processed (all missing, one pixel, ...)."""


class ConvergenceError(RoughContactError, RuntimeError):
    """A load whose error bound did not reach the tolerance."""


class HeightMapWarning(UserWarning):
    """A map that is solved as asked, though no measured surface is like it: too few points, too steep."""


def path_message(error: Exception, path: str, origin: str = "") -> str:
    """Return the message about a map with the path of its file, and the line of the table that names it.

    Examples
    --------
    >>> path_message(HeightMapError("a.txt: all points are missing"), "maps/a.txt", "surfaces.tsv, line 2")
    'maps/a.txt: all points are missing (surfaces.tsv, line 2)'
    """
    text = str(error).removeprefix(f"{path}: ").removeprefix(f"{path.rpartition('/')[2]}: ")
    return f"{path}: {text}" + (f" ({origin})" if origin and origin not in text else "")


def turns_escaped(text: str) -> str:
    r"""Return a text in which marks that turn its direction, as of a file's name, are shown as escapes.

    Examples
    --------
    >>> turns_escaped("a\u202ecod.exe")
    'a\\u202ecod.exe'
    """
    return _TURNING.sub(lambda mark: f"\\u{ord(mark[0]):04x}", text)
