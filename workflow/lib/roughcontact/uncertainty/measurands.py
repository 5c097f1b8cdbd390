"""What the intervals are for, in words."""


def measurand_in_words(extent: float | None) -> str:
    """Return what the ± is for: the surface in the band of the map, or one `extent` times as long."""
    if extent is None:
        return "the mean of maps of this size all over the surface, in the band of waves of this map"
    return f"the surface over {extent:g} times the length of the map"


def beyond_the_map(extent: float) -> dict[str, str]:
    """Return the keys of the intervals for what lies beyond the band or the map, and what they are for."""
    longer = f"over {extent:g} times the length"
    return {"octave": "with waves one octave shorter", "longer": longer, "next": "of the next map"}
