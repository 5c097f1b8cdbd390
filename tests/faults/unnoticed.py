"""Damage files, read them, and count how often other heights come without a word.

    .venv/bin/python tests/faults/unnoticed.py                  # 5 000 mutants
    .venv/bin/python tests/faults/unnoticed.py --mutants 300
    .venv/bin/python tests/faults/unnoticed.py --write          # the tables, and the page that shows them

The files are those of `fuzz_readers.py`, with a sample of the project as map, once as measured (multiples of
0.1 nm) and once without its mean plane, and real ones up to 2.5 MB. Each is damaged in one way, all ways
equally often. Each mutant is read in a process of its own (10 s, 2 GB) and compared with the whole file:
shape, steps and every height, to the last bit. A word is a refusal or a warning whose sentence, apart from
its numbers, the whole file does not have.
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

sys.path.insert(0, str(Path(__file__).parents[1]))

from fuzz_readers import GIVEN, outcome_of, whole_files, writing

from roughcontact.errors import RoughContactError
from roughcontact.io.read import read_height_map

ROOT = Path(__file__).resolve().parents[2]
_LARGEST = 2_500_000  # bytes of a real file
_LARGEST_WHOLE = 5_000_000  # where every file is damaged in few ways
_BLOCK = 4096  # bytes; the longest that is inserted, lost, doubled or exchanged
_FAULTS = ("exception", "message", "time", "memory", "signal")
_SMALL = 0.01  # of the rms height
_COMBINED = 1000  # texts of random dialects


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
            "of": differs.size,
            "change": float("inf") if gone.any() else float(change / rms),
        }
    )


def _originals(folder: Path, largest: int = _LARGEST) -> dict[str, Whole]:
    """Return the whole files: every kind with the sample as measured and levelled, and the real ones.

    These have `largest` bytes at most.
    """
    measured = read_height_map(ROOT / "data_samples/ground.txt").values[40:64, 40:64]
    y, x = np.indices(measured.shape)
    plane = np.column_stack([np.ones(measured.size), x.ravel(), y.ravel()])
    fitted = plane @ np.linalg.lstsq(plane, measured.ravel(), rcond=None)[0]
    levelled = measured - fitted.reshape(measured.shape)
    originals: dict[str, Whole] = {}
    for words, heights in {"": measured, ", levelled": levelled}.items():
        with writing(heights):
            for name, (data, _) in whole_files(folder, 0 if words else largest).items():
                path = folder / "whole"
                path.write_bytes(data)
                if (original := whole(path)) is not None:
                    originals[name + words] = original
                path.unlink()
    return originals


def fuzz(
    mutants: int, seed: int, folder: Path, records_at: Path | None = None, largest: int = _LARGEST
) -> list[dict]:
    """Damage files so many times; return a record of each mutant, and keep the files that went wrong.

    The records are added to a file of JSON lines as they come, where one is named. Real files have `largest`
    bytes at most.
    """
    originals = _originals(folder, largest)
    real = [name for name in originals if "." in name]
    made = [name for name in originals if name not in real]
    records = []
    for number in range(mutants):
        choose = random.Random(f"{seed} {number}")  # the same mutant whatever was done to those before
        name = choose.choice(real if real and number % 2 else made)
        way = choose.choice(list(WAYS))
        original = originals[name]
        path = folder / f"mutant-{number}"
        path.write_bytes(WAYS[way](original.data, choose))
        found = outcome_of(path, lambda path, original=original: compared(path, original))
        record = {"file": name, "real": name in real, "way": way, "kind": found.kind, "said": found.said}
        if found.kind == "map":
            record |= json.loads(found.said)
            record["kind"] = "same" if not record["other"] else ("warned" if record["word"] else "silent")
        records.append(record)
        if records_at is not None:
            with records_at.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(record) + "\n")
        if found.kind in _FAULTS:
            print(f"{found.kind}: {path} (of {name}, {way}): {found.said[-1500:]}", flush=True)
        else:
            path.unlink()
    return records


def reason(record: dict) -> str:
    """Return why a mutant was read with other heights in silence."""
    if record["other"] == "steps":
        return "a digit of a size or step: the file says it once"
    if record["other"] == "shape":
        return "a text cut or joined between two rows or points: nothing says their number"
    if record["way"] == "bits flipped" or record["points"] <= 3:
        return f"{_SIZES[record['change'] > _SMALL]} in {_FEW_POINTS}"
    if record["points"] > 0.9 * record["of"]:
        return "a digit of the height scale: the file says it once"
    return "heights in other places of a file whose size stays, in a format without checksum"


_FEW_POINTS = "one to three heights, in a format without checksum"
_SIZES = {False: "a change below 1 % of the rms height", True: "a change within the scatter of the heights"}


def counts(records: list[dict], by: str) -> pd.DataFrame:
    """Return the counts by a column of the records."""
    rows = []
    for name in dict.fromkeys(record[by] for record in records):
        kinds = Counter(record["kind"] for record in records if record[by] == name)
        rows.append({by: name} | _counted(kinds))
    return pd.DataFrame(rows).sort_values(by, key=lambda column: column.str.lower())


def _counted(kinds: Counter) -> dict:
    return {
        "mutants": kinds.total(),
        "refused": kinds["refused"],
        "same heights": kinds["same"],
        "other, with a warning": kinds["warned"],
        "other, silent": kinds["silent"],
        "exceptions": kinds["exception"] + kinds["message"],
        "hangs": kinds["time"],
        "crashes": kinds["signal"] + kinds["memory"],
    }


def tables(records: list[dict]) -> dict[str, pd.DataFrame]:
    """Return the tables of the page: by way, by format, and the reasons of what came in silence."""
    silent = [record for record in records if record["kind"] == "silent"]
    for record in records:
        record["format"] = _format(record)
        record["way of damage"] = record["way"]
    by_format = counts(records, "format")
    by_format["why silent"] = [
        "; ".join(
            f"{count} {why}"
            for why, count in Counter(
                _SHORT[reason(record)] for record in silent if record["format"] == name
            ).most_common()
        )
        for name in by_format["format"]
    ]
    reasons = Counter(reason(record) for record in silent).most_common()
    return {
        "ways": counts(records, "way of damage"),
        "formats": by_format,
        "reasons": pd.DataFrame(reasons, columns=["reason", "mutants"]),
    }


_SHORT = {
    "a digit of a size or step: the file says it once": "digit of a size",
    "a text cut or joined between two rows or points: nothing says their number": "number of rows",
    f"{_SIZES[False]} in {_FEW_POINTS}": "small flip",
    f"{_SIZES[True]} in {_FEW_POINTS}": "flip",
    "a digit of the height scale: the file says it once": "digit of a scale",
    "heights in other places of a file whose size stays, in a format without checksum": "exchange",
}


def _format(record: dict) -> str:
    """Return the format of a record's file: the reader of a made one, the ending of a real one."""
    name = record["file"].removesuffix(", levelled")
    if record["real"]:
        ending = Path(name).suffix.removeprefix(".")
        return {"003": "di", "txt": "text", "csv": "text", "h5-jpk": "jpk_hdf5", "dat": "metropro"}.get(
            ending, ending
        )
    return "text" if name.startswith("text") else "own result" if name == "own result" else name


def summary(records: list[dict]) -> dict[str, str]:
    """Return the numbers of the page that are no table."""
    kinds = Counter(record["kind"] for record in records)
    other, read = kinds["warned"] + kinds["silent"], kinds["warned"] + kinds["silent"] + kinds["same"]
    return {
        "mutants": str(len(records)),
        "faults": str(sum(kinds[fault] for fault in _FAULTS)),
        "refused": str(kinds["refused"]),
        "same": str(kinds["same"]),
        "other": str(other),
        "silent": str(kinds["silent"]),
        "silent of those read (%)": f"{100 * kinds['silent'] / max(read, 1):.1f}",
        "silent of those with other heights (%)": f"{100 * kinds['silent'] / max(other, 1):.1f}",
        "silent of all (%)": f"{100 * kinds['silent'] / len(records):.1f}",
    }


def _inserted_at_60(data: bytes) -> bytes:
    place = 6 * len(data) // 10
    return data[:place] + random.Random(place).randbytes(1000) + data[place:]


def _lost_at_60(data: bytes) -> bytes:
    place = 6 * len(data) // 10
    return data[:place] + data[place + 100 :]


SIZES: dict[str, Callable[[bytes], bytes]] = {
    "1000 bytes inserted": _inserted_at_60,
    "100 bytes lost": _lost_at_60,
    "last 1 % cut off": lambda data: data[: -max(1, len(data) // 100)],
    "512 zeros added": lambda data: data + bytes(512),
}


def sizes(folder: Path) -> pd.DataFrame:
    """Return what is said of every file of 500 bytes and more with bytes too many or too few, by format."""
    found: dict[str, dict[str, Counter]] = {}
    for name, original in _originals(folder, _LARGEST_WHOLE).items():
        if len(original.data) < 500 or name.endswith("levelled"):
            continue
        kind = _format({"file": name, "real": "." in name})
        for way, damage in SIZES.items():
            path = folder / "damaged"
            path.write_bytes(damage(original.data))
            try:
                said = json.loads(compared(path, original))
                outcome = (
                    "warned" if said["word"] else "other heights, silent" if said["other"] else "same heights"
                )
            except RoughContactError:
                outcome = "refused"
            found.setdefault(kind, {}).setdefault(way, Counter())[outcome] += 1
            path.unlink()
    rows = [
        {"format": kind, "files": sum(next(iter(ways.values())).values())}
        | {
            way: ", ".join(_times(outcome, n) for outcome, n in each.most_common())
            for way, each in ways.items()
        }
        for kind, ways in sorted(found.items(), key=lambda item: item[0].lower())
    ]
    return pd.DataFrame(rows)


def _times(outcome: str, count: int) -> str:
    return outcome if count == 1 else f"{count} {outcome}"


def dialects(folder: Path) -> pd.DataFrame:
    """Return how often a text with a known map is read right, with a question, refused, or wrong silently."""
    sys.path.append(str(ROOT / "tests/unit"))
    from dialects import counted
    from test_io_text_dialects import DIALECTS, DOUBTS

    kinds: Counter = Counter()
    path = folder / "dialect.txt"
    for text, right, warning in DIALECTS.values():
        path.write_text(text, encoding="utf-8")
        try:
            height = read_height_map(path, dx=1, dy=1, unit="um", height_unit="nm")
        except RoughContactError:
            kinds["refused"] += 1
            continue
        said = " | ".join(json.loads(height.attrs["ingest_warnings"]))
        asked = any(doubt in said for doubt in DOUBTS)
        same = not isinstance(right, str) and np.allclose(height.values[::-1], right * 1e-9, equal_nan=True)
        kinds[
            "read with a question" if asked or warning else "read right" if same else "wrong in silence"
        ] += 1
    path.unlink()
    combined, _ = counted(_COMBINED, 1, folder)
    names = ("read right", "read with a question", "refused", "wrong in silence")
    return pd.DataFrame(
        [{"texts": found.total()} | {name: found[name] for name in names} for found in (kinds, combined)]
    )


def main() -> int:
    """Run it, and say what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--mutants", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--records", type=Path, help="add a record of each mutant to this file")
    parser.add_argument("--write", action="store_true", help="write the tables and the page that shows them")
    parser.add_argument("--of", type=Path, help="take the records of such a file, and damage nothing")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    folder = Path(tempfile.mkdtemp(prefix="unnoticed-"))
    if options.of:
        records = [json.loads(line) for line in options.of.read_text().splitlines()]
    else:
        import SurfaceTopography.IO  # noqa: F401  # before any process is forked: it takes a second

        records = fuzz(options.mutants, options.seed, folder, options.records)
    found, said = tables(records), summary(records)
    found |= {"sizes": sizes(folder), "dialects": dialects(folder)}
    if options.write:
        sys.path.append(str(ROOT / "benchmarks"))
        from pages import publish

        publish("damage", found, said | {"seed": str(options.seed)})
    for frame in found.values():
        print(frame.to_string(index=False), end="\n\n")
    print("; ".join(f"{name}: {value}" for name, value in said.items()))
    if said["faults"] == "0":
        shutil.rmtree(folder)
    return int(said["faults"] != "0")


if __name__ == "__main__":
    sys.exit(main())
