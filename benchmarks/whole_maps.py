"""Count the verdicts on whole measured maps, and how wide their ± is.

    python benchmarks/whole_maps.py FOLDER ... --write
    python benchmarks/whole_maps.py FOLDER ... --planned --write     # default settings, E* alone is stated

Every map in the folders that is read without being told anything is evaluated by default settings, steel on
PEEK, at contact areas that a user would choose. Half-widths are those of the surface, relative to the result,
at loads with 2 to 50 % in contact: medians of a map, and of all maps and loads. Coverage is measured by
`calibrate.py` and `measurement.py`. With `--planned` the loads are those that the program plans, and files
that are refused are listed with the reason: a map is red for its loads alone if others of them are not.
"""

import argparse
import json
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pages
import pandas as pd
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.errors import RoughContactError
from roughcontact.statistics.precision import precision_in_words

BODIES = (
    {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "hardness": 2e9},
    {"youngs_modulus": 3.6e9, "poissons_ratio": 0.38, "hardness": 3e8},
)
AREAS = (0.003, 0.01, 0.03, 0.1, 0.2, 0.3)  # of the whole maps
JUDGED = (0.02, 0.5)  # contact areas at which widths are judged
WIDTHS = {
    "area ± (%)": "relative_contact_area",
    "pressure ± (%)": "mean_contact_pressure",
    "gap ± (%)": "mean_gap",
}
BOUNDED = "peak bounded (%)"  # loads at which the largest pressure has an upper end
NARROW = 30  # percent
PLANNED = {"contact_modulus": "115 GPa"}  # steel on steel
FAILING = ("Plasticity", "Slopes", "Reading the file", "Points in contact", "Periodic window")
NO_MAPS = ("CATALOG.tsv", "README.md", "cross_solver_reference.json")  # of a folder of maps
TYPICAL = 0.1  # contact area at which the planned results are compared
AREA = "relative_contact_area"


def evaluated(path: Path) -> xr.Dataset | None:
    """Return the statistics of one file; None where it is no map that is read without further words."""
    warnings.simplefilter("ignore")
    try:
        return rc.evaluate(path, contact={"bodies": BODIES, "target_area": list(AREAS)})
    except RoughContactError:
        return None


def planned(path: Path) -> xr.Dataset | str:
    """Return the statistics of one file at planned loads, or why it is refused."""
    warnings.simplefilter("ignore")
    try:
        return rc.evaluate(path, contact=PLANNED)
    except RoughContactError as error:
        return str(error).replace(str(path), path.name).split(";")[0].split("\n")[0]


def row_of_planned(name: str, statistics: xr.Dataset | str) -> dict[str, str]:
    """Return what a default run says of a file: verdicts, what is red and why, how well the area is known."""
    if isinstance(statistics, str):
        return {"map": name, "refused": statistics}
    red = statistics["verdict"].values == 2
    reasons = [
        reason["text"].split(". ")[0]
        for reason in json.loads(statistics.attrs["reasons"])
        if red.all() and reason["check"] in FAILING
    ]
    area = statistics[AREA].values
    typical = int(np.abs(np.log(area / TYPICAL)).argmin())
    interval = (float(statistics[f"{AREA}{suffix}"][typical]) for suffix in ("", "_lower", "_upper"))
    return {
        "map": name,
        "loads": str(red.size),
        "red": str(red.sum()),
        "for planned loads alone": "yes" if red.any() and not red.all() else "no",
        "why": "; ".join(reasons),
        "area (%)": f"{100 * area[typical]:.3g}",
        "known": precision_in_words(*interval),
        "halve": statistics.attrs.get("halve", ""),
        "refused": "",
    }


def half_widths(statistics: xr.Dataset) -> dict[str, np.ndarray]:
    """Return half-widths (percent of the result) at the judged loads; infinite without an upper end."""
    area = statistics["relative_contact_area"].values
    judged = (area >= JUDGED[0]) & (area <= JUDGED[1])
    widths = {}
    for column, name in WIDTHS.items():
        value, lower, upper = (
            statistics[name + suffix].values[judged] for suffix in ("", "_lower", "_upper")
        )
        widths[column] = 50 * np.where(np.isnan(upper), np.inf, upper - lower) / value
    widths[BOUNDED] = 100.0 * np.isfinite(statistics["max_pressure_upper"].values[judged])
    return widths


def tables(statistics_by_map: dict[str, xr.Dataset]) -> dict[str, pd.DataFrame]:
    """Return the table of verdicts, widths and reasons by map, and of all."""
    rows, widths = [], []
    for name, statistics in statistics_by_map.items():
        reasons = "; ".join(reason["check"] for reason in json.loads(statistics.attrs["reasons"]))
        verdicts = {"loads": statistics.sizes["load"], "use": int((statistics["verdict"] == 0).sum())}
        widths.append(pd.DataFrame(half_widths(statistics)))
        rows.append({"map": name} | verdicts | _of_loads(widths[-1]) | {"reasons": reasons})
    table, every = pd.DataFrame(rows), pd.concat(widths)
    narrow = 100 * (every[[*WIDTHS]] <= NARROW).mean()
    words = "; ".join(f"{column[:-4]} {NARROW} % for {share:.0f} %" for column, share in narrow.items())
    of_all = {"map": f"all {len(table)}", "loads": table["loads"].sum(), "use": table["use"].sum()}
    table = pd.concat([table, pd.DataFrame([of_all | _of_loads(every) | {"reasons": words}])])
    return {"maps": pages.text(table, dict.fromkeys([*WIDTHS, BOUNDED], ".0f"))}


def _of_loads(widths: pd.DataFrame) -> dict[str, float]:
    """Return the median half-widths of some loads, and the share of them with a bounded largest pressure."""
    return {**widths[[*WIDTHS]].median(), BOUNDED: widths[BOUNDED].mean()}


def main() -> None:
    """Evaluate the maps, print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folders", nargs="+", type=Path, help="folders of instrument files")
    parser.add_argument("--write", action="store_true", help="write the table; else print")
    parser.add_argument("--planned", action="store_true", help="at the loads that the program plans")
    arguments = parser.parse_args()
    files = sorted({path for folder in arguments.folders for path in folder.iterdir() if path.is_file()})
    if arguments.planned:
        files = [path for path in files if path.name not in NO_MAPS]
        with ProcessPoolExecutor(2) as pool:
            rows = [
                row_of_planned(path.name, statistics)
                for path, statistics in zip(files, pool.map(planned, files), strict=True)
            ]
        by_name = {"planned": pd.DataFrame(rows).fillna("")}
        if arguments.write:
            pages.publish("whole_maps", by_name)
        else:
            pages.show(by_name)
        return
    with ProcessPoolExecutor(2) as pool:
        every = zip(files, pool.map(evaluated, files), strict=True)
        statistics_by_map = {path.name: statistics for path, statistics in every if statistics is not None}
    if arguments.write:
        pages.publish("whole_maps", tables(statistics_by_map))
    else:
        pages.show(tables(statistics_by_map))


if __name__ == "__main__":
    main()
