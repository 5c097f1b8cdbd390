"""What each constant of the ± changes: half-widths of maps with the constant at another value.

    python benchmarks/constants.py --write

Maps are the samples and synthetic surfaces, with a stated noise, lens and uncertain scales, solved at three
loads. The table has the median change of the width of the interval of all maps and loads.
"""

import argparse
import importlib
import sys
import warnings
from itertools import product
from pathlib import Path

import numpy as np
import pages
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.contact.loads import plan_loads
from roughcontact.surface.synthetic import self_affine_surface
from roughcontact.uncertainty import ensemble
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.scales import AREA, CONDUCTANCE, GAP, PEAK

SIDE = 128  # points
QUANTITIES = {AREA: "area", GAP: "gap", PEAK: "peak", CONDUCTANCE: "conductance"}
# module, constant -> another value, and where else the name is bound
CONSTANTS = {
    ("ensemble", "TOLERANCE"): 3e-3,
    ("discretisation", "_REFINED_POINTS"): 64**2,
    ("discretisation", "_NOISE_PER_SWITCH"): 1.0,
    ("subwindows", "_MIN_POINTS_PER_SIDE"): 24,
    ("subwindows", "_CUTS"): (2, 3),
    ("subwindows", "_MIN_SCATTER"): 0.04,
    ("ensemble", "MARGIN"): 0.5,
    ("instrument", "_NOISE_MARGIN"): 0.0,
    ("instrument", "_MOST_NOISE"): 0.5,
    ("instrument", "_CORRECTION_UNCERTAINTY"): 1.0,
    ("unresolved", "_POINTS_PER_WAVE"): 4,
    ("unresolved", "_MIN_WAVES_PER_SIDE"): 16,
    ("unresolved", "_MAX_OCTAVES"): 1,
    ("solver", "_POINT_ERROR"): 6.0,
    ("scales", "SMALLEST"): 1e-4,
}
BOUND_IN = {
    "TOLERANCE": ("rejected",),
    "MARGIN": ("instrument", "unresolved"),
}


def maps() -> list:
    """Return middles of the sample maps, and synthetic surfaces."""
    folder = Path(__file__).parents[1] / "data_samples"
    samples = [rc.read_height_map(folder / name) for name in ("sandblasted.x3p", "ground.txt")]
    starts = [[(n - SIDE) // 2 for n in height.shape] for height in samples]
    cut = [h[y : y + SIDE, x : x + SIDE] for h, (y, x) in zip(samples, starts, strict=True)]
    waves = {"longest": 48e-6, "shortest": 3e-6, "rms_gradient": 0.2}
    return cut + [
        self_affine_surface((SIDE + 32,) * 2, 1e-6, hurst=hurst, seed=seed, **waves)[:SIDE, :SIDE]
        for hurst, seed in product((0.5, 0.8), (1,))
    ]


def widths(heights: list, *, correct: bool) -> pd.DataFrame:
    """Return ln of upper over lower end of the intervals, rows of maps and loads."""
    rows = []
    for height in heights:
        levelled = rc.level(height)
        instrument = {"noise": 0.01 * float(levelled.std()), "resolution": 6e-6, "amplification_z": 0.01}
        window_arguments = {"correct_for": instrument} if correct else {}
        window = rc.periodic_window(levelled, **window_arguments)
        loads = plan_loads(window, contact_modulus=1e9, relative_pressure=[0.02, 0.1, 0.4])
        contact = {"contact_modulus": 1e9, "mean_pressure": [float(load) for load in loads]}
        settings = {"window": window_arguments, "contact": contact, "instrument": instrument}
        budget = rc.error_budget(levelled, window, settings)
        for name, short in QUANTITIES.items():
            bounds = [budget[f"{name}_{side}"].values for side in ("lower", "upper")]
            rows += [{"quantity": short, "width": width} for width in bounds[1] - bounds[0]]
    return pd.DataFrame(rows)


def main() -> None:
    """Print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--write", action="store_true", help="write table and page")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    heights, rows = maps(), []
    plain = {correct: widths(heights, correct=correct) for correct in (False, True)}
    for (module, name), value in CONSTANTS.items():
        bound = [
            importlib.import_module(f"roughcontact.uncertainty.{m}")
            for m in (module, *BOUND_IN.get(name, ()))
        ]
        original, correct = getattr(bound[0], name), name == "_CORRECTION_UNCERTAINTY"
        for owner in bound:
            setattr(owner, name, value)
        solve_member.__kwdefaults__["tolerance"] = ensemble.TOLERANCE
        changed = widths(heights, correct=correct)
        for owner in bound:
            setattr(owner, name, original)
        change = 100 * (changed["width"] / plain[correct]["width"] - 1)
        row = {
            "constant": f"`{module}.{name.strip('_')}`",
            "value": f"{original:g}" if np.isscalar(original) else str(original),
        }
        row["tried"] = f"{value:g}" if np.isscalar(value) else str(value)
        for quantity, of_quantity in change.groupby(plain[correct]["quantity"], sort=False):
            row[f"{quantity} (%)"] = f"{of_quantity.median():+.1f}".replace("-", "−")
        rows.append(row)
        print(row, flush=True)
    if arguments.write:
        pages.publish("bank", {"constants": pd.DataFrame(rows)})


if __name__ == "__main__":
    main()
