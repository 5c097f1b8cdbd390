"""Damage files, read them, and count how often other heights come without a word.

    .venv/bin/python tests/faults/unnoticed.py                  # 5 000 mutants
    .venv/bin/python tests/faults/unnoticed.py --mutants 300
    .venv/bin/python tests/faults/unnoticed.py --write          # the tables, and the page that shows them

The files are those of `fuzz_readers.py`, real ones up to 2.5 MB, each damaged in one way; every way is equally
frequent. Each mutant is read in a process of its own (10 s, 2 GB) and compared with the whole file: shape,
steps and every height, to the last bit. A word is a refusal or a warning whose sentence, apart from its
numbers, the whole file does not have.
"""

import argparse
import json
import random
import re
import shutil
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]

from fuzz_readers import GIVEN, outcome_of, whole_files, writing

from roughcontact.errors import RoughContactError
from roughcontact.io.read import read_height_map

ROOT = Path(__file__).resolve().parents[2]
_LARGEST = 2_500_000  # bytes of a real file
_BLOCK = 4096  # bytes; the longest that is inserted, lost, doubled or exchanged
_FAULTS = ("exception", "message", "time", "memory", "signal")
_SMALL = 0.01  # of the rms height


class Whole(NamedTuple):
    """A file that is whole: content, arguments, heights (m), steps (m) and the kinds of its warnings."""

    data: bytes
    arguments: dict
    heights: np.ndarray
    steps: tuple[float, float]
    words: set[str]


def _place(data: bytes, choose: random.Random) -> int:
    return choose.randrange(len(data))


def _length(data: bytes, choose: random.Random) -> int:
    return choose.randint(1, max(1, min(_BLOCK, len(data) // 8)))


def _flipped(data: bytes, choose: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(choose.randint(1, 3)):
        changed[_place(data, choose)] ^= 1 << choose.randrange(8)
    return bytes(changed)


def _inserted(data: bytes, choose: random.Random) -> bytes:
    place = _place(data, choose)
    return data[:place] + choose.randbytes(_length(data, choose)) + data[place:]


def _lost(data: bytes, choose: random.Random) -> bytes:
    place = _place(data, choose)
    return data[:place] + data[place + _length(data, choose) :]


def _doubled(data: bytes, choose: random.Random) -> bytes:
    place = _place(data, choose)
    return data[: place + _length(data, choose)] + data[place:]


def _exchanged(data: bytes, choose: random.Random) -> bytes:
    length = _length(data, choose)
    first, second = sorted(choose.sample(range(0, len(data) - length, 1), 2))
    if second - first < length:
        length = second - first
    return b"".join(
        (
            data[:first],
            data[second : second + length],
            data[first + length : second],
            data[first : first + length],
            data[second + length :],
        )
    )


def _cut(data: bytes, choose: random.Random) -> bytes:
    return data[: choose.randrange(len(data) // 2, len(data))]


def _padded(data: bytes, choose: random.Random) -> bytes:
    return data + choose.choice([b"\0", b"\xff", b" ", b"\x1a"]) * choose.randint(1, _BLOCK)


def _header(data: bytes) -> int:
    """Return the length of the header: text before the first line of numbers or byte that is no text."""
    text = data.replace(b"\0", b" ") if data[:2] in (b"\xff\xfe", b"\xfe\xff") else data
    length = 0
    for line in text[:4096].splitlines(keepends=True):
        readable = re.match(rb"[\t\n\r\x20-\x7e\xb5\xc2]*", line).end()
        letters = re.search(rb"[A-Za-df-z]", line[:readable])
        length += readable if letters else 0
        if readable < len(line) or not letters:
            break
    return length if length >= 16 else 64


def _digit(data: bytes, choose: random.Random) -> bytes:
    """Change a digit of the header; a byte of it where it has none."""
    length = min(_header(data), len(data))
    digits = [place for place in range(length) if data[place] in b"0123456789"]
    changed = bytearray(data)
    place = choose.choice(digits or range(length))
    changed[place] = choose.choice([digit for digit in b"0123456789" if digit != changed[place]])
    return bytes(changed)


WAYS: dict[str, Callable[[bytes, random.Random], bytes]] = {
    "bits flipped": _flipped,
    "block inserted": _inserted,
    "block lost": _lost,
    "block doubled": _doubled,
    "blocks exchanged": _exchanged,
    "cut off": _cut,
    "padded": _padded,
    "digit of the header": _digit,
}


def _kinds(sentences: list[str]) -> set[str]:
    """Return sentences without their numbers, units and signs."""
    return {re.sub(r"[−+-]?\d[\d.,e]*(?:\s?[a-zµ%]{1,2}\b)?", "#", sentence) for sentence in sentences}


def whole(path: Path) -> Whole | None:
    """Return a file as it is read, with the usual arguments where it needs them; None where it is refused."""
    for arguments in ({}, GIVEN):
        with suppress(RoughContactError):
            height = read_height_map(path, **arguments)
            return Whole(path.read_bytes(), arguments, height.values, _steps(height), _said(height))
    return None


def _steps(height) -> tuple[float, float]:
    return tuple(
        float(height[axis][1] - height[axis][0]) if height.sizes[axis] > 1 else 0.0 for axis in ("y", "x")
    )


def _said(height) -> set[str]:
    return _kinds(json.loads(height.attrs["ingest_warnings"]))


def compared(path: Path, original: Whole) -> str:
    """Read a mutant, and return as JSON how it differs from the whole file."""
    height = read_height_map(path, **original.arguments)
    word = bool(_said(height) - original.words)
    if height.shape != original.heights.shape:
        return json.dumps({"other": "shape", "word": word})
    if not np.allclose(_steps(height), original.steps, rtol=1e-12, atol=0.0):
        return json.dumps({"other": "steps", "word": word})
    differs = ~((height.values == original.heights) | (np.isnan(height.values) & np.isnan(original.heights)))
    if not differs.any():
        return json.dumps({"other": "", "word": word})
    change = np.nanmax(np.abs(height.values - original.heights), initial=0.0)
    gone = np.isnan(height.values) != np.isnan(original.heights)
    rms = float(np.nanstd(original.heights)) or 1.0
    return json.dumps(
        {
            "other": "heights",
            "word": word,
            "points": int(differs.sum()),
            "change": float("inf") if gone.any() else float(change / rms),
        }
    )


def _originals(folder: Path) -> dict[str, Whole]:
    """Return the whole files: every kind with the sample as measured and levelled, and the real ones."""
    measured = read_height_map(ROOT / "data_samples/ground.txt").values[40:64, 40:64]
    y, x = np.indices(measured.shape)
    plane = np.column_stack([np.ones(measured.size), x.ravel(), y.ravel()])
    fitted = plane @ np.linalg.lstsq(plane, measured.ravel(), rcond=None)[0]
    levelled = measured - fitted.reshape(measured.shape)
    originals: dict[str, Whole] = {}
    for words, heights in {"": measured, ", levelled": levelled}.items():
        with writing(heights):
            for name, (data, _) in whole_files(folder, 0 if words else _LARGEST).items():
                path = folder / "whole"
                path.write_bytes(data)
                if (original := whole(path)) is not None:
                    originals[name + words] = original
                path.unlink()
    return originals


def fuzz(mutants: int, seed: int, folder: Path, ways: dict = WAYS) -> list[dict]:
    """Damage files so many times; return a record of each mutant, and keep the files that went wrong."""
    choose = random.Random(seed)
    originals = _originals(folder)
    real = [name for name in originals if "." in name]
    made = [name for name in originals if name not in real]
    records = []
    for number in range(mutants):
        name = choose.choice(real if real and number % 2 else made)
        way = choose.choice(list(ways))
        original = originals[name]
        path = folder / f"mutant-{number}"
        path.write_bytes(ways[way](original.data, choose))
        found = outcome_of(path, lambda path, original=original: compared(path, original))
        record = {"file": name, "real": name in real, "way": way, "kind": found.kind, "said": found.said}
        if found.kind == "map":
            record |= json.loads(found.said)
            record["kind"] = "same" if not record["other"] else ("warned" if record["word"] else "silent")
        records.append(record)
        if found.kind in _FAULTS:
            print(f"{found.kind}: {path} (of {name}, {way}): {found.said[-1500:]}", flush=True)
        else:
            path.unlink()
    return records


def counts(records: list[dict], by: str) -> pd.DataFrame:
    """Return the counts by a column of the records."""
    rows = []
    for name in dict.fromkeys(record[by] for record in records):
        kinds = Counter(record["kind"] for record in records if record[by] == name)
        rows.append(
            {
                by: name,
                "mutants": kinds.total(),
                "refused": kinds["refused"],
                "same heights": kinds["same"],
                "other, with a warning": kinds["warned"],
                "other, silent": kinds["silent"],
                "faults": sum(kinds[fault] for fault in _FAULTS),
            }
        )
    return pd.DataFrame(rows)


def main() -> int:
    """Run it, and say what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--mutants", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--records", type=Path, help="write a record of each mutant as JSON lines")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    import SurfaceTopography.IO  # noqa: F401  # before any process is forked: it takes a second

    folder = Path(tempfile.mkdtemp(prefix="unnoticed-"))
    records = fuzz(options.mutants, options.seed, folder)
    if options.records:
        options.records.write_text("".join(json.dumps(record) + "\n" for record in records))
    for by in ("way", "file"):
        print(counts(records, by).to_string(index=False))
    kinds = Counter(record["kind"] for record in records)
    print(dict(kinds))
    faults = sum(kinds[fault] for fault in _FAULTS)
    if not faults:
        shutil.rmtree(folder)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
