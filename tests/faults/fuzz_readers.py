"""Damage files of every reader at random, and see that each gives a map or one clear error, soon and small.

    .venv/bin/python tests/faults/fuzz_readers.py                    # 5 000 mutants and the hostile files
    .venv/bin/python tests/faults/fuzz_readers.py --mutants 200
    .venv/bin/python tests/faults/fuzz_readers.py --write docs/explanation/damaged-files.csv

The files that are damaged are written by code; with the folder of real instrument files (see
tests/shared_data.py) these are damaged as well. A tenth of the mutants are the project's own results, which
are read as a run reads them.

Every mutant is read in a process of its own, with a limit of its CPU time and of its memory. Wrong are an
exception that is not the project's own, a message without the name of the file or of more than 600
characters, a signal, more than 10 s, and more than 2 GB. Returns 1 where anything went wrong, and keeps
those files. Maps whose heights or positions differ from those of the whole file are counted too: a damaged
number in a file without checksum is a number.
"""

import argparse
import csv
import faulthandler
import hashlib
import io
import os
import pickle
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.io
import sdfio
import x3pio
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1]))

from hostile import FILES as HOSTILE
from measured_files import gsf, gwy, jpk, tmd
from shared_data import DATA

from roughcontact.errors import InputFileError, RoughContactError
from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map
from roughcontact.results.storage import read_dataset, write_dataset

LONGEST = 10  # seconds of CPU time
LARGEST = 2 * 10**9  # bytes
_HARD = 6 * 2**30  # bytes of address space above what a process has, so that the machine stays well
_MAX_MESSAGE_LENGTH = 600
_MAX_SEED = 600_000  # bytes
GIVEN = {"dx": 1.0, "dy": 1.5, "unit": "um", "height_unit": "nm"}


class Outcome(NamedTuple):
    """What reading a file came to.

    Attributes
    ----------
    kind : str
        ``map``, ``refused``, or what went wrong: ``exception``, ``message``, ``signal``, ``time``,
        ``memory``.
    seconds : float
        CPU time.
    peak : int
        bytes.
    said : str
    """

    kind: str
    seconds: float
    peak: int
    said: str


def heights(n: int = 24) -> np.ndarray:
    """Return a smooth random map of about 1 µm."""
    rng = np.random.default_rng(1)
    return 1e-6 * np.cumsum(np.cumsum(rng.standard_normal((n, n)), axis=0), axis=1) / n


def _text(path: Path, text: str, encoding: str = "utf-8") -> None:
    path.write_bytes(text.encode(encoding))


def _rows(separator: str) -> str:
    return "\n".join(separator.join(f"{1e6 * value:.5f}" for value in row) for row in heights()) + "\n"


def _points(separator: str) -> str:
    z = heights()
    cells = ((f"{i:g}", f"{j:g}", f"{1e6 * z[j, i]:.4f}") for j in range(len(z)) for i in range(len(z)))
    return "\n".join(separator.join(row) for row in cells)


def _netcdf(path: Path, kind: str) -> None:
    axes = {axis: (axis, 1e-6 * np.arange(24), {"units": "m"}) for axis in ("y", "x")}
    array = xr.DataArray(heights(), coords=axes, dims=("y", "x"), name="z", attrs={"units": "m"})
    array.to_netcdf(path, format=kind, engine="netcdf4")


def _x3p(path: Path) -> None:
    x3pio.write(path, heights(), x_scale=1e-6, y_scale=1e-6)


_COUNTS = (1e12 * heights()).astype(np.int32).reshape(-1, 1)

# name of a reader's module, with what is special -> what writes a file that it reads
SEEDS: dict[str, Callable[[Path], object]] = {
    "x3p": _x3p,
    "sdf": lambda path: sdfio.write(path, heights(), x_scale=1e-6, y_scale=1e-6),
    "npy": lambda path: np.save(path, heights()),
    "netcdf 4": lambda path: _netcdf(path, "NETCDF4"),
    "netcdf 3": lambda path: _netcdf(path, "NETCDF3_CLASSIC"),
    "netcdf 5": lambda path: _netcdf(path, "NETCDF3_64BIT_DATA"),
    "jpk_hdf5": lambda path: path.write_bytes(
        jpk(_COUNTS, ilength=24, jlength=24, ulength=1e-6, vlength=1e-6)
    ),
    "tmd": lambda path: path.write_bytes(tmd(1e3 * heights(), (0.024, 0.024), b"comment")),
    "gsf": lambda path: path.write_bytes(gsf(heights(), XReal=2.4e-5, YReal=2.4e-5)),
    "gwy": lambda path: path.write_bytes(gwy({"a": (heights(), "m")}, (2.4e-5, 2.4e-5))),
    "matlab": lambda path: scipy.io.savemat(path, {"z": heights(), "name": "a"}),
    "matlab packed": lambda path: scipy.io.savemat(path, {"z": heights()}, do_compression=True),
    "text matrix": lambda path: _text(
        path, "# Width: 24 µm\n# Height: 24 µm\n# Value units: µm\n" + _rows("\t")
    ),
    "text matrix, decimal commas, UTF-16": lambda path: _text(path, _rows(";").replace(".", ","), "utf-16"),
    "text points": lambda path: _text(path, "x (µm),y (µm),z (µm)\n" + _points(",")),
    "text profile": lambda path: _text(
        path, "Lateral um;Raw um\n" + "".join(f"{i};{i % 7}\n" for i in range(99))
    ),
}


def whole_files(folder: Path) -> dict[str, tuple[bytes, bool]]:
    """Return the whole files: name -> content, and whether it is one of the project's own results."""
    seeds = {}
    for name, write in SEEDS.items():
        write(folder / "seed.npy")
        seeds[name] = (folder / "seed.npy").read_bytes(), False
    surface = xr.DataArray(
        heights(),
        dims=("y", "x"),
        coords={axis: (axis, 1e-6 * np.arange(24), {"units": "m"}) for axis in ("y", "x")},
        name="height",
    )
    write_dataset(surface, folder / "result.nc")
    seeds["own result"] = (folder / "result.nc").read_bytes(), True
    if DATA.is_dir():
        for folder_of_files in (DATA, DATA.parent / "more_data"):
            for path in sorted(folder_of_files.glob("*.*")):
                is_seed = path.suffix not in (".md", ".tsv", ".json")
                if is_seed and 0 < path.stat().st_size <= _MAX_SEED:
                    seeds[path.name] = path.read_bytes(), False
    return seeds


def mutant(data: bytes, choose: random.Random) -> bytes:
    """Return a file damaged in one to three ways."""
    if data[:2] == b"PK" and choose.random() < 0.5:  # within the archive, so that its checksums are right
        inside = _damaged_member(data, choose)
        if inside is not None:
            return inside
    for _ in range(choose.choice([1, 1, 2, 3])):
        if len(data) < 2:
            break
        data = choose.choice(_WAYS)(data, choose)
    return data


def _damaged_member(data: bytes, choose: random.Random) -> bytes | None:
    packed = io.BytesIO()
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(packed, "w") as new:
            names = old.namelist()
            chosen = choose.choice(names)
            for name in names:
                content = old.read(name)
                new.writestr(name, choose.choice(_WAYS)(content, choose) if name == chosen else content)
    except (zipfile.BadZipFile, OSError):
        return None
    return packed.getvalue()


def _place(data: bytes, choose: random.Random) -> int:
    """Return a place, every other time in the first 512 bytes, where headers are."""
    return choose.randrange(min(len(data), 512) if choose.random() < 0.5 else len(data)) if data else 0


def _flip(data, choose):
    changed, position = bytearray(data), _place(data, choose)
    if changed:
        changed[position] ^= 1 << choose.randrange(8)
    return bytes(changed)


def _random_bytes(data, choose):
    position = _place(data, choose)
    return (
        data[:position] + choose.randbytes(choose.randint(1, 16)) + data[position + choose.randint(0, 16) :]
    )


def _extreme_number(data, choose):
    position = _place(data, choose)
    number = choose.choice([0, 1, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1])
    size = choose.choice([size for size in (2, 4, 8) if number < 256**size])
    written = number.to_bytes(size, choose.choice(["little", "big"]))
    return data[:position] + written + data[position + size :]


def _cut(data, choose):
    return data[: choose.randrange(1, len(data))] if len(data) > 1 else data


def _left_out(data, choose):
    position = _place(data, choose)
    return data[:position] + data[position + choose.randint(1, max(1, len(data) // 8)) :]


def _doubled(data, choose):
    position = _place(data, choose)
    piece = data[position : position + choose.randint(1, 4096)]
    return data[:position] + piece * choose.randint(2, 20) + data[position:]


def _words(data, choose):
    position = _place(data, choose)
    word = choose.choice(
        [b"nan", b"-", b";", b",", b"\t", b"\n", b"1e999", b"\xb5m", b"[", b"=", b"\0" * 8, b" " * 99]
    )
    return data[:position] + word + data[position:]


_WAYS = (_flip, _flip, _random_bytes, _extreme_number, _cut, _left_out, _doubled, _words)


def outcome_of(path: Path, read: Callable[[Path], str | None]) -> Outcome:
    """Return what reading a file comes to, in a process of its own."""
    read_end, tell = os.pipe()
    process = os.fork()
    if process == 0:
        os.close(read_end)
        _read_and_tell(path, read, tell)
    os.close(tell)
    with os.fdopen(read_end, "rb") as stream:
        words = stream.read().decode("utf-8", "replace")
    _, status, usage = os.wait4(process, 0)
    kind, _, text = words.partition("\n")
    seconds, peak = usage.ru_utime + usage.ru_stime, 1024 * usage.ru_maxrss
    if seconds >= LONGEST or (os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU):
        kind = "time"
    elif os.WIFSIGNALED(status) or not kind:
        kind, text = "signal", f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else "no word"
    elif peak > LARGEST:
        kind = "memory"
    return Outcome(kind, seconds, peak, text)


def _read_and_tell(path: Path, read: Callable[[Path], str | None], tell: int) -> None:
    """Read a file within limits, write kind and words, and end this process."""
    words = "exception\nnothing was said"
    try:
        faulthandler.disable()
        sys.stderr = open(os.devnull, "w")  # noqa: PTH123, SIM115
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + _HARD, used + _HARD))
        resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        warnings.filterwarnings("error", category=RuntimeWarning, module="roughcontact")
        try:
            words = f"map\n{read(path) or ''}"
        except RoughContactError as error:
            named = path.name in str(error) and len(str(error)) <= _MAX_MESSAGE_LENGTH
            words = f"{'refused' if named else 'message'}\n{error}"
        except BaseException:
            words = f"exception\n{traceback.format_exc()}"
        os.write(tell, words.encode()[:60_000])
    finally:
        os._exit(0)


def read_foreign(path: Path) -> str:
    """Read a measured file as it is, which looks at all its channels, and with everything given.

    Returns checksum of heights and positions, and the warnings without their numbers.
    """
    problem = inspect_file(path)["problem"] or str(path)
    if path.name not in problem or len(problem) > _MAX_MESSAGE_LENGTH:
        raise InputFileError(problem)
    height = read_height_map(path, **GIVEN)
    digest = hashlib.sha256(b"".join(array.values.tobytes() for array in (height, height.x, height.y)))
    return f"{digest.hexdigest()}\n{re.sub(r'[0-9.,]+', '#', height.attrs['ingest_warnings'])}"


def read_own(path: Path) -> str:
    """Read a result as a run does; returns its checksum."""
    return hashlib.sha256(pickle.dumps(read_dataset(path).to_dict())).hexdigest() + "\n"


def fuzz(mutants: int, seed: int, folder: Path) -> dict[str, Counter]:
    """Damage files so many times; return the counts of every reader's or real file, and keep what went wrong.

    Parameters
    ----------
    mutants : int
    seed : int
        of the damages.
    folder : Path
        an empty folder, in which the files that went wrong stay.
    """
    choose = random.Random(seed)
    seeds = whole_files(folder)
    right: dict[str, str] = {}
    for name, (data, result) in seeds.items():  # also so that no process has to import anything
        (folder / "whole").write_bytes(data)
        with suppress(RoughContactError):
            right[name] = (read_own if result else read_foreign)(folder / "whole")
    (folder / "whole").unlink()
    own_results = [name for name, (_, result) in seeds.items() if result]
    written = list(SEEDS)
    real = [name for name in seeds if name not in SEEDS and name not in own_results]
    counts: dict[str, Counter] = {}
    for number in range(mutants):
        if number % 10 == 0:
            name = choose.choice(own_results)
        else:
            name = choose.choice(real if real and number % 2 else written)
        path = folder / f"mutant-{number}"
        path.write_bytes(mutant(seeds[name][0], choose))
        outcome = outcome_of(path, read_own if name in own_results else read_foreign)
        label = name if name not in real else "real file of an instrument"
        _count(counts.setdefault(label, Counter()), outcome, path, name)
        if outcome.kind == "map":
            digest, _, message = outcome.said.partition("\n")
            right_digest, _, usual = right.get(name, "").partition("\n")
            counts[label]["other"] += digest != right_digest
            counts[label]["silent"] += digest != right_digest and message == usual
    return counts


def _read(path: Path) -> None:
    """Read a file as a user would who knows its size."""
    read_height_map(path, **GIVEN)


def hostile(folder: Path) -> dict[str, Counter]:
    """Read the files that are made to do harm; return their counts."""
    counts: dict[str, Counter] = {}
    for number, (name, (write, refused)) in enumerate(HOSTILE.items()):
        path = folder / f"hostile-{number}"
        write(path)
        outcome = outcome_of(path, _read)
        if refused and outcome.kind == "map":
            outcome = outcome._replace(kind="exception", said="it was read, and should be refused")
        _count(counts.setdefault(name, Counter()), outcome, path, name)
    return counts


def _count(counts: Counter, outcome: Outcome, path: Path, name: str) -> None:
    """Add an outcome to counts; say what went wrong and keep its file, else remove it."""
    counts[outcome.kind] += 1
    counts["files"] += 1
    counts["largest"] = max(counts["largest"], outcome.peak)
    counts["longest"] = max(counts["longest"], outcome.seconds)
    if outcome.kind in ("map", "refused"):
        path.unlink()
        return
    print(f"{outcome.kind}: {path} (of {name}): {outcome.said[-1500:]}", flush=True)


def rows(counts: dict[str, Counter]) -> list[dict[str, str]]:
    """Return counts as lines of a table."""
    return [
        {
            "file": name,
            "files": str(count["files"]),
            "maps": str(count["map"]),
            "with other heights": str(count["other"]),
            "of these without a new warning": str(count["silent"]),
            "refused": str(count["refused"]),
            "other exceptions": str(count["exception"] + count["message"]),
            "crashes": str(count["signal"]),
            "over 10 s": str(count["time"]),
            "over 2 GB": str(count["memory"]),
            "longest (s)": f"{count['longest']:.1f}",
            "largest (MB)": f"{count['largest'] / 1e6:.0f}",
        }
        for name, count in counts.items()
    ]


def main() -> int:
    """Run it, and say what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--mutants", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", type=Path, help="write the counts as CSV")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    import SurfaceTopography.IO  # noqa: F401  # before any process is forked: it takes a second

    folder = Path(tempfile.mkdtemp(prefix="fuzzed-"))
    counts = hostile(folder) | fuzz(options.mutants, options.seed, folder)
    lines = rows(counts)
    wrong = sum(int(line[kind]) for line in lines for kind in list(lines[0])[6:10])
    if options.write:
        with options.write.open("w", newline="", encoding="utf-8") as stream:
            table = csv.DictWriter(stream, list(lines[0]), lineterminator="\n")
            table.writeheader()
            table.writerows(lines)
    for line in lines:
        print("; ".join(f"{key}: {value}" for key, value in line.items()))
    files = sum(int(line["files"]) for line in lines)
    print(f"{files} files, {wrong} went wrong" + (f"; they are in {folder}" if wrong else ""))
    if not wrong:
        shutil.rmtree(folder)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
