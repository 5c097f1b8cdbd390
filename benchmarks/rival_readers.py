"""Files as SurfaceTopography and surfalize read them, a line of JSON for each; run by `readers.py`.

PYTHON benchmarks/rival_readers.py FILE NAME_OF_CHANNEL [FILE NAME_OF_CHANNEL ...]
"""

import json
import logging
import sys
import warnings
from importlib.metadata import version

import numpy as np

METRES = {
    "m": 1.0,
    "mm": 1e-3,
    "µm": 1e-6,
    "μm": 1e-6,
    "um": 1e-6,
    "nm": 1e-9,
    "Å": 1e-10,
    "A": 1e-10,
    "pm": 1e-12,
}


def facts(heights, dx, dy):
    """Return shape (ny, nx), steps (m), missing points and Sq (m) of heights (m), NaN where missing."""
    heights = np.atleast_2d(heights)
    missing = int(np.isnan(heights).sum())
    shape = list(heights.shape)
    return {"shape": shape, "dx": dx, "dy": dy, "missing": missing, "Sq": float(np.nanstd(heights))}


def surface_topography(path, name):
    """Return the channel of that name, else the default one, in metres."""
    from SurfaceTopography import open_topography

    reader = open_topography(path)
    names = [channel.name for channel in reader.channels]
    channel = reader.channels[names.index(name)] if names.count(name) == 1 else reader.default_channel
    topography = channel.topography()
    unit = METRES[topography.unit]
    heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan) * unit
    steps = [
        size / points * unit for size, points in zip(topography.physical_sizes, heights.shape, strict=True)
    ]
    return facts(heights.T, *[*steps, None][:2])


def surfalize(path, name):
    """Return the only or first layer, in metres (it has micrometres)."""
    from surfalize import Surface

    surface = Surface.load(path)
    return facts(surface.data * 1e-6, surface.step_x * 1e-6, surface.step_y * 1e-6)


def main():
    """Print what both make of each file."""
    warnings.simplefilter("ignore")
    logging.disable(logging.CRITICAL)
    readers = {"SurfaceTopography": surface_topography, "surfalize": surfalize}
    print(json.dumps({name: version(name) for name in readers}))
    for path, name in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
        readings = {}
        for reader, read in readers.items():
            try:
                readings[reader] = read(path, name)
            except Exception as error:  # whatever a reader raises means that it does not read the file
                readings[reader] = f"{type(error).__name__}: {error}"
        print(json.dumps(readings))


if __name__ == "__main__":
    main()
