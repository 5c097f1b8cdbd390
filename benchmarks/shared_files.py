"""Run every file of a catalogue of measured maps through the whole pipeline and print what came out.

    python benchmarks/shared_files.py ../shared/data [--contact-modulus 1e9] [--only NAME ...]

Read, level, cut and make periodic, solve at three relative loads, take the statistics. A file that says
neither its size nor its units gets them from the table below, as from a table of surfaces. One line per file:
what came out with the seconds of the whole and of a mere look at the file (`inspect`), or the message that a
user would see.
"""

import argparse
import csv
import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.contact.loads import plan_loads
from roughcontact.io.inspection import inspect_file

RELATIVE_PRESSURES = (0.01, 0.05, 0.2)

GIVEN = {
    "xyz-2.txt": {"unit": "um"},
    "test1.txt": {"unit": "mm", "height_unit": "um"},
    "AFM.txt": {"dx": 2, "dy": 2, "unit": "nm"},
    "csv-1.csv": {"height_unit": "um"},
}


def run(path: Path, *, contact_modulus: float) -> dict:
    """Return the numbers of one file, or the message and the stage at which it was refused."""
    start = time.perf_counter()
    found = {"file": path.name, "stage": "inspect"}
    try:
        inspect_file(path)
        found["inspection"] = time.perf_counter() - start
        found["stage"] = "read"
        height = rc.read_height_map(path, **GIVEN.get(path.name, {}))
        found |= {"size": "{1} x {0}".format(*height.shape), "missing": height.attrs["missing_share"]}
        found["warnings"] = json.loads(height.attrs["ingest_warnings"])
        found["stage"] = "level"
        levelled = rc.level(height)
        found["stage"] = "window"
        window = rc.periodic_window(levelled)
        found["window"] = "{1} x {0}".format(*window.shape)
        found["stage"] = "solve"
        pressures = plan_loads(
            window, contact_modulus=contact_modulus, relative_pressure=list(RELATIVE_PRESSURES)
        )
        contact = rc.solve_contact(window, contact_modulus=contact_modulus, mean_pressure=pressures)
        found["stage"] = "statistics"
        statistics = rc.contact_statistics(contact)
        found |= {
            "stage": "",
            "rms_height": float(statistics["rms_height"]),
            "rms_gradient": float(statistics["rms_gradient"]),
            "areas": [float(area) for area in statistics["relative_contact_area"]],
            "error_bound": float(contact["error_bound"].max()),
        }
    except rc.RoughContactError as error:
        found["message"] = str(error).replace(f"{path}: ", "").replace(f"{path.name}: ", "")
    found["seconds"] = time.perf_counter() - start
    return found


def line(found: dict) -> str:
    """Return one row of the table."""
    if "message" in found:
        return f"{found['file']:36s} refused ({found['stage']}): {found['message']}"
    areas = "  ".join(f"{area:7.4f}" for area in found["areas"])
    return (
        f"{found['file']:36s} {found['size']:>11s} {found['window']:>11s} {found['missing']:7.2%} "
        f"{found['rms_height']:10.3e} {found['rms_gradient']:9.3g}   {areas}  {found['error_bound']:8.1e} "
        f"{found['seconds']:6.1f} {found['inspection']:7.2f}"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path, help="folder with the files and CATALOG.tsv")
    parser.add_argument("--contact-modulus", type=float, default=1e9, help="Pa (areas do not depend on it)")
    parser.add_argument("--only", nargs="*", help="names of files, instead of the whole catalogue")
    parser.add_argument(
        "--warnings", action="store_true", help="print the suspicions about each file as well"
    )
    options = parser.parse_args()
    with (options.folder / "CATALOG.tsv").open(encoding="utf-8") as stream:
        names = [row["file"] for row in csv.DictReader(stream, delimiter="\t")]
    loads = "  ".join(f"A({pressure:g})" for pressure in RELATIVE_PRESSURES)
    print(
        f"{'file':36s} {'points':>11s} {'window':>11s} {'missing':>7s} {'rms / m':>10s} {'gradient':>9s}   "
        f"{loads}  {'bound':>8s} {'s':>6s} {'look/s':>7s}"
    )
    solved = 0
    for name in names:
        if options.only and name not in options.only:
            continue
        found = run(options.folder / name, contact_modulus=options.contact_modulus)
        solved += "message" not in found
        print(line(found), flush=True)
        if options.warnings:
            for warning in found.get("warnings", []):
                print(f"{'':36s}   - {warning}")
    print(f"{solved} files solved")


if __name__ == "__main__":
    main()
