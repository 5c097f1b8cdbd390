"""Words with heights that are left open in the part of a surface, until the page knows the unit of them all.

That unit suits all surfaces of a page together, and is not known while the part of a single one is written.
"""


def left_open(kind: str, *values: float) -> str:
    """Return in place of a word with heights what `filled` makes that word of.

    Parameters
    ----------
    kind : {"n", "i", "t", "r", "u"}
        a number, one with its interval, the value at a tick, one for a script to read, the unit.
    *values : float, m

    Returns
    -------
    str
        of characters that stay what they are in HTML and in the address of an image.
    """
    return f"~height-{kind}-{'_'.join(repr(float(value)) for value in values)}~"


OPEN_UNIT = left_open("u")
