"""Yes or no of a seal: how many answers are decided, and how many decided ones are right of other places.

    python benchmarks/sealing.py FILE ... [--keep FOLDER] [--write TABLE.csv]

The rule, which was there before any answer was looked at: an answer *closed* or *open* (`gap_is_closed`) is
right where the solved numbers of other places agree with it, by the definition that the product documents. A
gap is closed where its narrowest place is at most 1 nm, or where it leaks at most 1e-12 m2/s; it is open
where neither holds, and not known where the flow did not settle, which is not held against any answer. An
answer that is not decided is neither right nor wrong, and is counted.

Each map asks for a seal at four pressures (p' of the whole map), along x and along y: eight answers a map.
Its four quarters ask the same at the same pressures (Pa), each by its own ± alone. What is decided of a
quarter is held against the whole map, and against each of the three quarters that it has not seen. All are
counted for two seals, and by the narrowest place alone, as where no seal is stated. That a fluid lifts what
presses less than itself is left out: what is counted are answers of the gap.
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
SEALS = {  # what is counted -> its leak over that of `WATER`; none: the narrowest place alone
    "water, 5 bar over 5 mm": 1.0,
    "water, 50 bar over 0.5 mm": 100.0,
    "narrowest place": None,
}
OTHERS = ("the whole", "other quarters")  # what a quarter is held against


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
    """Return by the solved numbers alone whether a gap is closed (load): 1, 0, NaN without a leak."""
    narrowest = numbers[f"critical_constriction_{axis}"].values
    leak = (
        numbers[f"leak_rate_{axis}"].values
        if f"leak_rate_{axis}" in numbers
        else np.full(narrowest.shape, np.inf)
    )
    closed = (narrowest <= CLOSED) | (leak <= TIGHT)
    return np.where(np.isnan(leak) & ~closed, np.nan, closed)


def with_leak(result, factor):
    """Return statistics with so many times their leak; without it for None."""
    result = result.drop_vars("fluid_pressure", errors="ignore")
    leaks = [name for name in result if str(name).startswith("leak")]
    if factor is None:
        return result.drop_vars(leaks)
    return result.assign({name: result[name] * factor for name in leaks})


def records(name, results):
    """Yield each answer of a map and of its quarters, with what the whole and other quarters say of it."""
    for seal, factor in SEALS.items():
        numbers = [with_leak(result, factor) for result in results]
        for axis in "xy":
            truth = [is_closed(result, axis) for result in numbers]
            for place, result in enumerate(numbers):
                others = np.array([truth[other] for other in range(1, 5) if other != place])
                for load, decision in enumerate(gap_is_closed(result, axis)):
                    yield {
                        "map": name,
                        "seal": seal,
                        "place": place,  # 0 the whole, 1 to 4 a quarter
                        "decision": decision,
                        "whole": truth[0][load],
                        "known": np.isfinite(others[:, load]).sum(),
                        "right": (others[:, load] == decision).sum(),
                    }


def table_of(answers):
    """Return for each rule and map how many answers are not decided, and how many decided ones are right."""
    rows = []
    for (seal, name), group in answers.groupby(["seal", "map"], sort=False):
        whole, quarters = group[group["place"] == 0], group[group["place"] > 0]
        decided = quarters[quarters["decision"].notna()]
        rows.append(
            {
                "seal": seal,
                "map": name,
                "answers": len(whole),
                "not decided": int(whole["decision"].isna().sum()),
                "decided of quarters": len(decided),
                "against the whole": int(decided["whole"].notna().sum()),
                "right of the whole": int((decided["decision"] == decided["whole"]).sum()),
                "against other quarters": int(decided["known"].sum()),
                "right of other quarters": int(decided["right"].sum()),
            }
        )
    table = pd.DataFrame(rows)
    total = table.drop(columns="map").groupby("seal", sort=False).sum().reset_index()
    return pd.concat([table, total.assign(map="all")])


def main():
    """Solve the maps, print the table and write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path, help="measured maps")
    parser.add_argument(
        "--keep", type=Path, help="folder of the solved statistics, which are read from it again"
    )
    parser.add_argument("--write", type=Path, help="table of what is counted")
    options = parser.parse_args()
    if options.keep:
        options.keep.mkdir(exist_ok=True, parents=True)
    warnings.simplefilter("ignore")
    rows = []
    for path in options.files:
        print(path.name, file=sys.stderr, flush=True)
        rows += records(path.name, results_of(path, options.keep))
    table = table_of(pd.DataFrame(rows))
    print(table.to_string(index=False))
    for seal, total in table.query("map == 'all'").groupby("seal"):
        shares = [total[f"right of {truth}"].item() / total[f"against {truth}"].item() for truth in OTHERS]
        print(f"{seal}: right of the whole {shares[0]:.3f}, of other quarters {shares[1]:.3f}")
    if options.write:
        table.to_csv(options.write, index=False)


if __name__ == "__main__":
    main()
