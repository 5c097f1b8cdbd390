"""Yes or no of a seal: how many answers are decided, and how many decided ones are right of other places.

    python benchmarks/sealing.py FILE ... [--keep FOLDER] [--write TABLE.csv]

The rule, which was there before any answer was looked at: an answer *closed* or *open* (`gap_is_closed`) is
right where the solved numbers of other places agree with it, by the definition that the product documents. A
gap is closed where its narrowest place is at most 1 nm, or where it leaks at most 1e-12 m2/s; it is open
where neither holds. An answer that is not decided is neither right nor wrong, and is counted.

Each map asks for a seal at four pressures (p' of the whole map), along x and along y: eight answers a map.
Its four quarters ask the same at the same pressures (Pa), each by its own ± alone. What is decided of a
quarter is held against the whole map, and against each of the three quarters that it has not seen. Both are
counted with the leak, as of a stated seal, and by the narrowest place alone, as where no seal is stated.
"""

import argparse
import sys
import warnings
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.statistics.decisions import CLOSED, TIGHT, gap_is_closed

RELATIVE_PRESSURES = [0.01, 0.03, 0.1, 0.2]
MODULUS = "8 MPa"  # of rubber, 6 MPa, on a rigid face
WATER = {"viscosity": "1 mPa s", "pressure_difference": "5 bar", "width": "5 mm"}


def solved(height, **load):
    """Return the statistics of a seal on a map, with their ±."""
    statistics = rc.evaluate(height, contact={"contact_modulus": MODULUS, **load}, statistics={"seal": WATER})
    return statistics.drop_dims([dim for dim in statistics.dims if dim not in ("load", "source", "member")])


def results_of(path, keep):
    """Return the statistics of a map and of its four quarters, kept in a folder or read from there."""
    files = [keep / f"{path.name}-{place}.nc" for place in range(5)] if keep else []
    if files and all(file.exists() for file in files):
        return [xr.load_dataset(file) for file in files]
    height = rc.read_height_map(path)
    results = [solved(height, relative_pressure=RELATIVE_PRESSURES)]
    pressures = results[0]["mean_pressure"].values.tolist()
    middle_y, middle_x = (size // 2 for size in height.shape)
    halves = product((slice(0, middle_y), slice(middle_y, None)), (slice(0, middle_x), slice(middle_x, None)))
    results += [solved(height.isel(y=y, x=x), mean_pressure=pressures) for y, x in halves]
    for file, result in zip(files, results, strict=False):
        result.to_netcdf(file)
    return results


def is_closed(numbers, axis):
    """Return by the solved numbers alone whether a gap is closed (load)."""
    narrowest = numbers[f"critical_constriction_{axis}"].values
    leak = numbers[f"leak_rate_{axis}"].values if f"leak_rate_{axis}" in numbers else np.inf
    return (narrowest <= CLOSED) | (leak <= TIGHT)


def records(name, results):
    """Yield each answer of a map and of its quarters, with what the whole and other quarters say of it."""
    without_leak = [
        result.drop_vars([key for key in result if str(key).startswith("leak")]) for result in results
    ]
    for rule, numbers in (("seal", results), ("narrowest place", without_leak)):
        for axis in "xy":
            truth = [is_closed(result, axis) for result in numbers]
            for place, result in enumerate(numbers):
                others = [truth[other] for other in range(1, 5) if other != place]
                for load, decision in enumerate(gap_is_closed(result, axis)):
                    yield {
                        "map": name,
                        "rule": rule,
                        "axis": axis,
                        "place": place,  # 0 the whole, 1 to 4 a quarter
                        "relative_pressure": RELATIVE_PRESSURES[load],
                        "decision": decision,
                        "whole": int(truth[0][load]),
                        "others_closed": int(sum(other[load] for other in others)) if place else np.nan,
                        "area": float(result["relative_contact_area"][load]),
                    }


def table_of(answers):
    """Return for each rule and map how many answers are not decided, and how many decided ones are right."""
    rows = []
    for (rule, name), group in answers.groupby(["rule", "map"], sort=False):
        whole, quarters = group[group["place"] == 0], group[group["place"] > 0]
        decided = quarters[quarters["decision"].notna()]
        agree = np.where(decided["decision"] == 1, decided["others_closed"], 3 - decided["others_closed"])
        rows.append(
            {
                "rule": rule,
                "map": name,
                "answers": len(whole),
                "not decided": int(whole["decision"].isna().sum()),
                "whole: wrong": int((whole["decision"] == 1 - whole["whole"]).sum()),
                "of quarters": len(quarters),
                "decided": len(decided),
                "right of the whole": int((decided["decision"] == decided["whole"]).sum()),
                "of other quarters": 3 * len(decided),
                "right": int(agree.sum()),
            }
        )
    table = pd.DataFrame(rows)
    total = table.drop(columns="map").groupby("rule", sort=False).sum().reset_index()
    return pd.concat([table, total.assign(map="all")])


def main():
    """Solve the maps, print the table, write all answers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path, help="measured maps")
    parser.add_argument(
        "--keep", type=Path, help="folder of the solved statistics, which are read from it again"
    )
    parser.add_argument("--write", type=Path, help="table of all answers")
    options = parser.parse_args()
    if options.keep:
        options.keep.mkdir(exist_ok=True, parents=True)
    warnings.simplefilter("ignore")
    rows = []
    for path in options.files:
        print(path.name, file=sys.stderr, flush=True)
        rows += records(path.name, results_of(path, options.keep))
    answers = pd.DataFrame(rows)
    print(table_of(answers).to_string(index=False))
    for rule, total in table_of(answers).query("map == 'all'").groupby("rule"):
        of_whole = total["right of the whole"].item() / total["decided"].item()
        of_others = total["right"].item() / total["of other quarters"].item()
        print(f"{rule}: {of_whole:.3f} of the decided right of the whole, {of_others:.3f} of other quarters")
    if options.write:
        answers.to_csv(options.write, index=False, float_format="%.4g")


if __name__ == "__main__":
    main()
