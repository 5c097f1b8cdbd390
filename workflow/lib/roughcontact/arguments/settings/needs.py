"""What settings need beside them, the rows of `needs.tsv`: one rule for files and functions."""

from collections.abc import Iterator, Mapping, Set
from typing import Any

from roughcontact.arguments.kinds import named_settings
from roughcontact.arguments.rows import rows_beside
from roughcontact.errors import SettingsError

# settings or values, what they need one of, and what is wrong without
_NEEDS = [
    (key, {*any_of.split(", ")}, text)
    for keys, any_of, text in rows_beside(__file__, "needs.tsv")
    for key in keys.split(", ")
]


def unmet_needs(
    settings: Mapping[str, Any], properties: Set[str] = frozenset(), *, section: str = ""
) -> Iterator[tuple[str, str]]:
    """Yield the settings, or values of them, that lack what they need, and what is wrong.

    `properties` are those that a body states. Only what a `section` needs, by its name, counts.

    Examples
    --------
    >>> list(unmet_needs({"statistics": {"joint": {"film_thickness": 5e-9}}}, section="statistics.joint"))
    [('statistics.joint.film_thickness', 'needs film_conductivity, or leave both out')]
    """
    present = {*properties}
    for name, value in named_settings(settings):
        present |= {name, f"{name} = {value!r}"} if value is not None else set()
    for key, any_of, text in _NEEDS:
        if key in present and not any_of & present and all(name.startswith(section) for name in any_of):
            yield key, text


def check_needs(section: str, options: Mapping[str, Any] | None) -> None:
    """Raise SettingsError where an option of a section of the statistics lacks another one of them."""
    for key, text in unmet_needs({"statistics": {section: options}}, section=f"statistics.{section}"):
        raise SettingsError(f"{key.removeprefix('statistics.')}: {text}", keys=[key])
