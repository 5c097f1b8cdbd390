"""Maps as pictures: values become a PNG with a palette, straight from the array."""

import base64
import math
import struct
import zlib

import numpy as np

# Every fifteenth of 256 colours, from low to high; between them the colours are interpolated. viridis and
# magma: van der Walt and Smith (2015); cividis: Nuñez, Anderton and Renslow (2018), PLoS ONE 13, e0199239.
# They rise evenly in lightness and are told apart by colour-blind people.
_ANCHORS = {
    "viridis": (
        "440154 481769 472a7a 433d84 3d4e8a 355e8d 2e6d8e 297b8e 23898e "
        "1f978b 21a585 2eb37c 46c06f 65cb5e 89d548 b0dd2f d8e219 fde725"
    ),
    "cividis": (
        "00224e 002d68 163770 2e416d 3f4c6c 4e566c 5c616e 696b71 767676 "
        "838179 928c78 a09875 afa471 bfb06b cfbd62 dfca57 f0d846 fee838"
    ),
}
# Of a picture, 1448 x 1448: those of one surface take 3 to 5 MB at 1024 x 1024 points, 8 MB at the most. Of
# finer maps several points make one.
POINTS = 2**21
_LONGEST = 8192  # points along a side, what every browser draws
_FEW_POINTS = 256  # along the longer side: fewer are shown as rectangles
_SHARES = 11  # steps of the share of bad points among those that make one


def colour_scale(name: str) -> list[str]:
    """Return the colours of a scale ("viridis" or "cividis"), evenly spaced from low to high.

    Examples
    --------
    >>> colour_scale("viridis")[0], colour_scale("viridis")[-1]
    ('#440154', '#fde725')
    """
    return [f"#{anchor}" for anchor in _ANCHORS[name].split()]


def coloured(
    values: np.ndarray, limits: tuple[float, float], colours: str, *, bad: str = "#ffffff"
) -> tuple[str, bool]:
    """Return an array as the data URI of a PNG, first row at the top, and whether its points are few.

    `limits` are values of the first and last colour, `bad` the colour of NaN.
    """
    missing = np.isnan(values)
    span = limits[1] - limits[0]
    level = values - limits[0]
    level /= span if span > 0 else 1.0  # in place: large maps leave no room for more
    np.clip(level, 0.0, 1.0, out=level)
    level[missing] = 0.0  # any valid colour: the palette has one for missing points
    together = max(math.ceil(math.sqrt(values.size / POINTS)), math.ceil(max(values.shape) / _LONGEST))
    share = missing
    # beyond two million points each of the picture is the mean of several, with its part of bad ones
    if together > 1:
        level, share = _averaged(level, missing, together)
    # colours of a byte, shared by levels and by shares of missing points
    steps = (_SHARES if together > 1 else 2) if missing.any() else 1
    of_colours = 256 // steps
    index = np.rint(level * (of_colours - 1)).astype(np.uint8)
    index += (np.rint(share * (steps - 1)) * of_colours).astype(np.uint8)
    picture = _png(index, _palette(colours, of_colours, bad, steps))
    source = "data:image/png;base64," + base64.b64encode(picture).decode()
    return source, max(index.shape) < _FEW_POINTS


def _png(index: np.ndarray, palette: bytes) -> bytes:
    """Return a PNG of places in a palette; as differences of rows ("up") heights take half the room.

    The default level of compression takes three times as long for a tenth less.
    """

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    height, width = index.shape
    # filter "up" of PNG (2), row by row
    rows = np.diff(index, axis=0, prepend=np.uint8(0))
    components = {
        b"IHDR": struct.pack(">2I5B", width, height, 8, 3, 0, 0, 0),
        b"PLTE": palette,
        b"IDAT": zlib.compress(np.insert(rows, 0, 2, axis=1).tobytes(), 4),
        b"IEND": b"",
    }
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*component) for component in components.items())


def _averaged(level: np.ndarray, missing: np.ndarray, together: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean of the good ones of so many points along either side, and the share of the bad ones."""
    rows, columns = (np.arange(0, n, together) for n in level.shape)
    sums = [
        np.add.reduceat(np.add.reduceat(source, rows, axis=0, dtype=float), columns, axis=1)
        for source in (level, missing)
    ]
    height, width = (np.diff([*starts, n]) for starts, n in zip((rows, columns), level.shape, strict=True))
    points = height[:, None] * width  # at the border fewer points make one
    return sums[0] / np.maximum(points - sums[1], 1), sums[1] / points


def _palette(name: str, of_colours: int, bad: str, steps: int) -> bytes:
    """Return so many colours of a scale, and after them their blends with the colour of bad points."""
    *anchors, missing_colour = (list(bytes.fromhex(colour[1:])) for colour in [*colour_scale(name), bad])
    indices = np.linspace(0, len(anchors) - 1, of_colours)
    # linear between the anchors, channel by channel
    channels = zip(*anchors, strict=True)
    scale = np.column_stack([np.interp(indices, np.arange(len(anchors)), channel) for channel in channels])
    shares = np.linspace(0, 1, steps)[:, None, None]
    blends = (1 - shares) * scale + shares * np.array(missing_colour)
    return np.rint(blends).astype(np.uint8).tobytes()
