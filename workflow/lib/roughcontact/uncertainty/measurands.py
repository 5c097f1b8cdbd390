"""What the intervals are for, in words."""

from roughcontact.quantities import number


def measurand_in_words(extent: float | None) -> str:
    """Return what the ± is for: the surface in the band of the map, or one `extent` times as long."""
    if extent is None:
        return "the mean of maps of this size all over the surface, in the band of waves of this map"
    return f"the surface over {number(extent, digits=2)} times the length of the map"


def beyond_the_map(extent: float) -> dict[str, str]:
    """Return the keys of the intervals for what lies beyond the band or the map, and what they are for."""
    longer = f"{number(extent, digits=2)} times the length"
    return {"octave": "waves one octave shorter", "longer": longer, "next": "the next map"}
