"""What the maps of a group are to one another, and what follows from it for their interval."""

from dataclasses import dataclass

from roughcontact.arguments.quantities import counted_noun

SHARED = ("discretisation", "instrument", "material", "hardness", "unresolved")


@dataclass(frozen=True)
class Members:
    """The maps of a group, by default periodic maps of different places.

    Attributes
    ----------
    noun : str
        one of them.
    whole : str
        what all of them are of, in words.
    shared : tuple of str
        sources of uncertainty that are alike in all, and are no smaller for their mean.
    interval : {"mean", "next_map"}
        whether the interval of the group is that of the mean or of one more member.
    has_calibrated_scatter : bool
        whether the bank of measured surfaces tells how such maps scatter.
    may_be_equal : bool
        whether equal results are no sign of a copy.
    is_compared : bool
        whether the group is compared with other groups.
    """

    noun: str = "map"
    whole: str = ""
    shared: tuple[str, ...] = SHARED
    interval: str = "mean"
    has_calibrated_scatter: bool = True
    may_be_equal: bool = False
    is_compared: bool = True

    def in_words(self, maps: int, parts: int) -> str:
        """Return so many members, and of how many parts they are, in words.

        Examples
        --------
        >>> MAPS.in_words(4, 2), PLACEMENTS.in_words(3, 1)
        ('4 maps of 2 parts', '3 placements of two faces')
        """
        whole = self.whole or (f" of {counted_noun(parts, 'part')}" if parts < maps else "")
        return counted_noun(maps, self.noun) + whole


MAPS = Members()
BODIES = Members(has_calibrated_scatter=False)  # the bank has periodic maps alone
PLACEMENTS = Members(
    noun="placement",
    whole=" of two faces",
    shared=(*SHARED, "window"),  # both faces, and with them the places where these were measured
    interval="next_map",
    has_calibrated_scatter=False,
    may_be_equal=True,  # on a smooth face
    is_compared=False,
)
# by the attribute `members` of the answer of a group
MEMBERS = {"maps": MAPS, "bodies": BODIES, "placements": PLACEMENTS}
