"""Damage result files, read them, and count how often other numbers come without a word.

    .venv/bin/python tests/faults/damaged_results.py

The files are those of a sample of the project, of 256 x 256 points: statistics.nc is damaged 400 times,
contact.nc 200 times. A damage changes, removes or inserts 1 to 64 bytes, or turns one bit, at a random place.
Each file is read by every function that reads results.
"""

import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.errors import InputFileError
from roughcontact.evaluation.evaluate import evaluate
from roughcontact.io.read import read_height_map
from roughcontact.results import storage
from roughcontact.results.selection import read_statistics
from roughcontact.surface.levelling.level import level
from roughcontact.surface.window.periodic_window import periodic_window

SAMPLE = Path(__file__).parents[2] / "data_samples/sandblasted.x3p"
CONTACT = {"contact_modulus": 1e9, "mean_pressure": [1e6, 5e6]}
_LONGEST = 64  # bytes


def write_results(folder: Path, height: xr.DataArray) -> list[Path]:
    """Write statistics.nc and contact.nc of a map to a folder."""
    statistics, contact = folder / "statistics.nc", folder / "contact.nc"
    storage.write_dataset(evaluate(height, contact=CONTACT, uncertainty={"sources": ["solver"]}), statistics)
    window = periodic_window(level(height))
    with storage.written_load_by_load(contact, CONTACT["mean_pressure"], window) as file:
        file.complete(solve_contact(window, **CONTACT, reduce=file.write_maps).assign(height=window))
    return [statistics, contact]


def damaged(data: bytes, choose: random.Random) -> bytes:
    """Return a file with a few bytes changed, removed or inserted, or with one bit turned."""
    length, kind = choose.randint(1, _LONGEST), choose.choice(["changed", "turned", "removed", "inserted"])
    start = choose.randrange(len(data))
    stop = min(start + length, len(data))
    if kind == "turned":
        return data[:start] + bytes([data[start] ^ 1 << choose.randrange(8)]) + data[start + 1 :]
    new = b"" if kind == "removed" else choose.randbytes(length if kind == "inserted" else stop - start)
    return data[:start] + new + data[start if kind == "inserted" else stop :]


def _opened(path: Path) -> xr.Dataset:
    with storage.opened_dataset(path) as dataset:
        return dataset.load()


def _statistics(path: Path) -> xr.Dataset:
    return read_statistics(path).drop_indexes("mean_pressure")


def outcomes(path: Path, *, damages: int, seed: int) -> Counter[str]:
    """Return how many damages are refused, harmless, or read with other numbers by any of the readers."""
    readers = [storage.read_dataset, _opened, *([_statistics] if path.stem == "statistics" else [])]
    data, expected, counts = path.read_bytes(), [read(path) for read in readers], Counter[str]()
    choose, copy = random.Random(seed), path.with_name(f"damaged-{path.name}")
    for _ in range(damages):
        copy.write_bytes(damaged(data, choose))
        kinds = {_outcome(read, copy, value) for read, value in zip(readers, expected, strict=True)}
        counts["other" if "other" in kinds else "+".join(sorted(kinds))] += 1
    return counts


def _outcome(read: Callable[[Path], xr.Dataset], path: Path, expected: xr.Dataset) -> str:
    try:
        return "harmless" if read(path).identical(expected) else "other"
    except InputFileError:
        return "refused"


def main() -> int:
    """Damage both files, print the counts and the time to read, and return how many were read as others."""
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        height = read_height_map(SAMPLE)
        points = {axis: slice(min(256, height.sizes[axis])) for axis in ("y", "x")}
        for path, damages in zip(write_results(Path(folder), height.isel(points)), (400, 200), strict=True):
            counts = outcomes(path, damages=damages, seed=1)
            start = time.perf_counter()
            storage.read_dataset(path)
            took = time.perf_counter() - start
            sizes = f"{path.stat().st_size} bytes, read in {1e3 * took:.1f} ms"
            print(f"{path.name} ({sizes}): {damages} damages, {dict(counts)}")
            wrong += counts["other"]
    return wrong


if __name__ == "__main__":
    sys.exit(np.sign(main()))
