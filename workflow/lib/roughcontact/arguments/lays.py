"""The lay of a surface as it is stated of profiles of it, and what follows from each."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import xarray as xr

from roughcontact.arguments.checking import check_choice
from roughcontact.arguments.choices import Lay
from roughcontact.arguments.maps import dimensions
from roughcontact.arguments.quantities import counted_noun
from roughcontact.errors import HeightMapError, SettingsError

ACROSS, ISOTROPIC, BOTH = "across", "none", "both"


class LayFacts(NamedTuple):
    """What is known of profiles by their stated lay."""

    has_surface_behind: bool  # which is solved, instead of the profile as ridges
    finding: str  # of the check, with the attributes of the window
    takes_profiles_along: bool = False  # whether others at right angles tell how long the waves are there
    ensemble: str = ""  # the surfaces of which a drawn one is an example, in words
    refusal: str = ""  # why such a profile is not solved, and the way out


_ENSEMBLE = "the surfaces with the spectrum, heights and slopes of {profiles}"
_LAYS = {
    ACROSS: LayFacts(
        False, "The profile runs across a lay, as stated: its ridges are endless.", takes_profiles_along=True
    ),
    ISOTROPIC: LayFacts(
        True,
        "No lay, as stated: the numbers are those of isotropic surfaces with this spectrum.",
        ensemble=_ENSEMBLE,
    ),
    BOTH: LayFacts(True, "Waves along the lay are {stretch} times as long as across.", ensemble=_ENSEMBLE),
    "along": LayFacts(
        False,
        "",
        refusal="lay = 'along': a profile along the lay runs on one ridge and shows nothing of the others, "
        "which carry the load; give it as one of `along` beside those across the lay (in a table in one "
        "group)",
    ),
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


def are_lines(height: xr.DataArray) -> bool:
    """Return whether the rows of a map (y, x) are profiles, no surface behind them and no areal map."""
    is_window = "window_reason" in height.attrs
    return dimensions(height.shape) == 1 or (lay_facts(height.attrs).has_surface_behind and not is_window)


def have_lines(height: xr.DataArray) -> bool:
    """Return whether the rows of an array are profiles, one or several."""
    return dimensions(height.shape) == 1 or "profiles" in height.attrs


def check_lines(height: xr.DataArray) -> None:
    """Raise HeightMapError for an areal map with a lay, which profiles have."""
    lay = height.attrs.get("lay")
    if lay and not have_lines(height):
        points = f"{height.shape[1]} x {height.shape[0]}"
        raise HeightMapError(
            f"lay = {lay}: is of profiles, and this is a map of {points} points; leave it out"
        )


def check_single_map(height: xr.DataArray) -> None:
    """Raise an error for a map with a lay, which profiles have, and for profiles without a surface behind."""
    check_lines(height)
    if height.attrs.get("profiles", 1) > 1:
        lay = height.attrs.get("lay", "not stated")
        raise HeightMapError(
            f"lay = {lay}: several profiles have one answer where lay = none, or with others "
            "along the lay; name these as well, or one profile"
        )


def ensemble_in_words(synthetic: xr.DataArray | xr.Dataset) -> str:
    """Return the surfaces of which a synthetic one, or its statistics, is an example; else nothing."""
    attrs = synthetic.attrs
    return lay_facts(attrs).ensemble.format(profiles=counted_noun(attrs.get("profiles", 1), "profile"))
