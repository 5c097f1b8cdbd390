"""The lay of a surface as it is stated of profiles of it, and what follows from each."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from roughcontact.arguments.choices import Lay, check_choice
from roughcontact.errors import SettingsError

MAX_POINTS = 512  # per side of a surface behind profiles, unless others are asked for
ACROSS, ISOTROPIC, BOTH = "across", "none", "both"


class LayFacts(NamedTuple):
    """What is known of profiles by their stated lay."""

    has_surface_behind: bool  # which is solved, instead of the profile as ridges
    finding: str  # of the check, with the attributes of the window
    takes_profiles_along: bool = False  # whether others at right angles tell how long the waves are there
    ensemble: str = ""  # the surfaces of which a drawn one is an example, in words
    refusal: str = ""  # why such a profile is not solved, and the way out


_ENSEMBLE = "the surfaces with the spectrum, heights and slopes of {profiles}"
_ALONG = (
    "lay = 'along': a profile along the lay runs on one ridge and shows nothing of the others, which carry "
    "the load; give it as one of `along` beside those across the lay (in a table in one group)"
)
_RIDGES = "The profile runs across a lay, as stated: its ridges are endless."
_NO_LAY = "No lay, as stated: the numbers are those of isotropic surfaces with this spectrum."
_LAYS = {
    ACROSS: LayFacts(False, _RIDGES, takes_profiles_along=True),
    ISOTROPIC: LayFacts(True, _NO_LAY, ensemble=_ENSEMBLE),
    BOTH: LayFacts(True, "Waves along the lay are {stretch} times as long as across.", ensemble=_ENSEMBLE),
    "along": LayFacts(False, "", refusal=_ALONG),
}
_NOT_STATED = LayFacts(False, "")


def lay_facts(attrs: Mapping[str, Any]) -> LayFacts:
    """Return what the attribute `lay` of a map, or the argument of a file, states; mostly nothing.

    Examples
    --------
    >>> lay_facts({"lay": "none"}).has_surface_behind, lay_facts({}).has_surface_behind
    (True, False)
    """
    return _LAYS.get(attrs.get("lay", ""), _NOT_STATED)


def check_lay(lay: object) -> None:
    """Raise SettingsError for an unknown lay of a profile, and for one along which it was measured."""
    facts = lay_facts({"lay": str(lay)})
    if facts.refusal:
        raise SettingsError(facts.refusal, keys=["lay"])
    check_choice("lay", lay, Lay)
