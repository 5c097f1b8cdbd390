"""NumPy arrays (`.npy`): heights without units. Row 0 is assumed to be the lowest line."""

from pathlib import Path

import numpy as np

from roughcontact.io.channels import Channel, MeasuredFile, as_heights
from roughcontact.io.guards import refusal, refusing
from roughcontact.io.interface import Reader, RecognisedBy, begins_with
from roughcontact.io.text.axes import refuse_points


def read(path: Path) -> MeasuredFile:
    """Open a file of one real array, (ny, nx) or (nx,), without pickle; it has no steps and units."""
    with refusing("not readable as a NumPy array", "; save a plain float64 array with numpy.save"):
        values = np.load(path, mmap_mode="r", allow_pickle=False)
    shape = (1, *values.shape) if values.ndim == 1 else values.shape
    if len(shape) != 2 or 0 in shape:
        raise refusal("shape of an array", shape=values.shape)
    channel = Channel("height", shape, lambda: as_heights(values))
    if values.dtype.kind in "iuf":
        refuse_points(values)
    # NumPy ignores bytes behind the array, which a damaged header leaves there
    size = getattr(values, "offset", 0) + values.nbytes
    return MeasuredFile("NumPy array", [channel], "bottom", first_row_assumed=True, required_size=size)


READER = Reader(RecognisedBy.MARK, begins_with(b"\x93NUMPY"), read)
