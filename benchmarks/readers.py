"""Measured files as this project, SurfaceTopography and surfalize read them: size, steps, missing points, Sq.

    python -m venv OTHER && OTHER/bin/pip install SurfaceTopography==1.27.1 surfalize==0.19.2
    python benchmarks/readers.py FOLDER ... --rivals OTHER/bin/python [--write]

Files that this project does not read without arguments are left out. Exit status 1 where no other reader that
reads a file agrees, but for those that `results/readers.md` explains.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from pages import publish, show
from rival_readers import facts

from roughcontact.errors import RoughContactError
from roughcontact.io.read import read_height_map

HERE = Path(__file__).resolve().parent
CLOSE = 1e-5  # relative; readers round units and steps in single precision
# files that are read otherwise than by any other reader, as `results/readers.md` says
EXPLAINED = {"frt-1.frt", "dektak-1.csv"}


def ours(path: Path) -> tuple[dict, str] | None:
    """Return size, steps, missing points and Sq of a file, and its channel; None where it asks for more."""
    try:
        height = read_height_map(path)
    except RoughContactError:
        return None
    dx, dy = (float(np.diff(height[axis][:2])[0]) if height.sizes[axis] > 1 else None for axis in "xy")
    return facts(height.values, dx, dy), height.attrs["channel"]


def difference(mine: dict, theirs: dict | str) -> str:
    """Return what another reader reads otherwise, `equal`, or why it does not read a file."""
    if isinstance(theirs, str):
        return f"not read ({theirs.partition(':')[0]})"
    if theirs["shape"] != mine["shape"]:
        return f"{theirs['shape'][0]} x {theirs['shape'][1]} points"
    ratios = {name: theirs[name] / mine[name] for name in ("dx", "dy", "Sq") if mine[name] and theirs[name]}
    wrong = [f"{name} × {ratio:.6g}" for name, ratio in ratios.items() if abs(ratio - 1) > CLOSE]
    if theirs["missing"] != mine["missing"]:
        wrong.append(f"{theirs['missing']} missing")
    return ", ".join(wrong) or "equal"


def compared(paths: list[Path], python: str) -> tuple[pd.DataFrame, dict]:
    """Return the table of the comparison, and the versions of the other readers."""
    read = {path: found for path in paths if (found := ours(path))}
    arguments = [word for path, (_, channel) in read.items() for word in (str(path), channel)]
    command = [python, str(HERE / "rival_readers.py"), *arguments]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    versions, *theirs = map(json.loads, output)
    rows = []
    for (path, (mine, _)), others in zip(read.items(), theirs, strict=True):
        rows.append(
            {
                "file": path.name,
                "points": f"{mine['shape'][0]} x {mine['shape'][1]}",
                "step": f"{mine['dx']:.6g} m",
                "missing": str(mine["missing"]),
                "Sq": f"{mine['Sq']:.6g} m",
                **{reader: difference(mine, found) for reader, found in others.items()},
            }
        )
    return pd.DataFrame(rows), versions


def main() -> int:
    """Compare the files of folders, print the table, and write it where asked."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--rivals", required=True, help="Python of the environment with the other readers")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    paths = [path for folder in options.folders for path in sorted(folder.iterdir()) if path.is_file()]
    files, versions = compared(paths, options.rivals)
    show({"files": files})
    if options.write:
        publish("readers", {"files": files}, versions)
    alone = [
        row["file"]
        for row in files.to_dict("records")
        if "equal" not in (others := [row[reader] for reader in versions])
        and not all(each.startswith("not read") for each in others)
    ]
    print("no other reader agrees:", ", ".join(alone) or "none")
    return int(bool({*alone} - EXPLAINED))


if __name__ == "__main__":
    sys.exit(main())
