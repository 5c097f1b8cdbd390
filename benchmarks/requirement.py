"""Coverage of the largest Sq that meets a requirement: parts of surfaces against the whole of each.

    python benchmarks/requirement.py            # made surfaces, printed; some five CPU minutes
    python benchmarks/requirement.py --surfaces 2
    python benchmarks/requirement.py --surfaces 0 --write TABLE.csv FILE...   # measured maps
    python benchmarks/requirement.py --loads 9    # of a part, close enough for its load curve to answer

A part, a ninth of its surface, asks for 1.5 times the gap, two thirds of the area, 1.5 times the thermal
resistance of the whole. Its interval is to hold the largest Sq of the whole in 92 to 98 % of all cases, both
over the Sq of their own map: that of a part lacks the waves that are longer than the part.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc

BODIES = [{"youngs_modulus": "2 GPa", "poissons_ratio": 0.4, "thermal_conductivity": 0.25}] * 2
PITCH, PART, ACROSS = 1e-6, 72, 3  # m; points of a side; parts along a side
CLOSE = 1.35  # ratio of two loads between which the answer is read from the curve
ASKED = {  # requirement: its number, and what is asked for over that of the whole
    "gap": ("mean_gap", 1.5),
    "contact_area": ("relative_contact_area", 2 / 3),
    "thermal_resistance": ("thermal_resistance", 1.5),
}


def whole_surface(seed):
    """Return a periodic surface of random roughness, nine times as large as a part."""
    rng = np.random.default_rng(seed)
    waves = {"hurst": rng.uniform(0.5, 0.9), "shortest": 4e-6, "longest": rng.uniform(12e-6, 30e-6)}
    points = ACROSS * PART
    return rc.self_affine_surface((points, points), PITCH, rms_gradient=0.1, seed=seed, **waves)


def evaluated(height, asked=None, **load):
    """Return the statistics of a map under a load, of what is asked for."""
    return rc.evaluate(height, bodies=BODIES, statistics={"requirement": asked}, **load)


def records(surface, load, *, name, loads=1, **whole):
    """Yield for each part of a surface and each requirement its largest Sq with both ends, and the truth."""
    whole |= {"uncertainty": {"sources": ["discretisation"]}}  # which corrects, as in the parts
    once = evaluated(surface, relative_pressure=[load], **whole)
    pressure = once["mean_pressure"].values.tolist()
    asked = {key: share * float(once[number][0]) for key, (number, share) in ASKED.items()}
    true = evaluated(surface, asked, mean_pressure=pressure, **whole)
    size = [points // ACROSS for points in surface.shape]
    for place in range(ACROSS**2):
        row, column = (index * points for index, points in zip(divmod(place, ACROSS), size, strict=True))
        cut = surface.isel(y=slice(row, row + size[0]), x=slice(column, column + size[1]))
        around = CLOSE ** (np.arange(loads) - loads // 2)
        part = evaluated(cut, asked, mean_pressure=(around * pressure).tolist()).isel(load=[loads // 2])
        for key in ASKED:
            largest, *ends = (
                float(numbers[f"{key}_largest_Sq{end}"][0] / numbers["Sq"])
                for numbers, end in ((true, ""), (part, "_lower"), (part, "_upper"))
            )
            yield {"surface": name, "part": place, "requirement": key, "true": largest} | dict(
                zip(("lower", "upper"), ends, strict=True)
            )


def all_records(surfaces, files, loads):
    """Yield the records of made surfaces and of measured maps, each at a load of its own."""
    for seed in range(surfaces):
        load = float(10 ** np.random.default_rng(seed).uniform(-1.7, -0.5))
        yield from records(whole_surface(seed), load, name=seed, loads=loads, window={"method": "raw"})
    for index, file in enumerate(files):
        load = float(10 ** np.random.default_rng(index).uniform(-1.7, -0.5))
        yield from records(rc.read_height_map(file), load, name=file.stem, loads=loads)


def main():
    """Measure and print the coverage of each requirement."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--surfaces", type=int, default=8)
    parser.add_argument("--loads", type=int, default=1, help="of each part")
    parser.add_argument("--write", type=Path, help="table of all cases")
    parser.add_argument("files", nargs="*", type=Path, help="measured maps")
    options = parser.parse_args()
    table = pd.DataFrame(all_records(options.surfaces, options.files, options.loads))
    # an end that is not known does not bound
    table["held"] = ~(table["true"] < table["lower"]) & ~(table["true"] > table["upper"])
    table["factor"] = np.sqrt(table["upper"] / table["lower"])
    by_name = table.groupby("requirement")
    print(by_name.agg(parts=("held", "size"), held=("held", "mean"), median_factor=("factor", "median")))
    print(f"all: {table['held'].mean():.3f} of {len(table)}")
    if options.write:
        table.to_csv(options.write, index=False, float_format="%.4g")


if __name__ == "__main__":
    main()
