"""Write what two other codes find on a small map: `make_other_codes_pressures.py PYTHON`.

PYTHON is one in which Tamaas and ContactMechanics are installed. The program that poses the problem to them
is that of the cross-check; it imports nothing of this package.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from roughcontact.surface.synthetic import self_affine_surface
from validation import outside

FILE = Path(__file__).with_name("other_codes_pressures.csv")
SHAPE, PITCHES = (40, 32), (1.0, 0.75)
LOADS = [0.02, 0.1, 0.4]  # mean pressure / E*
CODES = ["tamaas", "contactmechanics"]
HEAD = """\
Pressures / E* on a small map at mean pressures of 0.02, 0.1 and 0.4 E*, at every point, row by row.
{} by make_other_codes_pressures.py, from the heights of the first column alone.
The map: {} x {} points, pitches {} and {} (y, x), self-affine, random. Lengths have no unit.
height,{}"""


def solve(python, code, heights):
    """Return the pressures (load, y, x) that a code finds, and its name with its version."""
    lengths = np.array(PITCHES) * SHAPE
    with tempfile.TemporaryDirectory() as folder:
        problem, solution = Path(folder) / "problem.npz", Path(folder) / "solution.npz"
        np.savez(problem, heights=heights, lengths=lengths, loads=LOADS)
        subprocess.run([python, outside.__file__, code, problem, solution], check=True, env={})
        with np.load(solution) as archive:
            return np.abs(archive["pressures"]), f"{code} {archive['version']}"


def main(python):
    band = {"hurst": 0.8, "shortest": 6.0, "longest": 24.0}
    surface = self_affine_surface(SHAPE, PITCHES, **band, rms_gradient=1.0, seed=11)
    heights = np.round(surface.values, 6)
    pressures_by_code, names = zip(*(solve(python, code, heights) for code in CODES), strict=True)
    columns = [f"{code} at {load}" for code in CODES for load in LOADS]
    head = HEAD.format(" and ".join(names), *SHAPE, *PITCHES, ",".join(columns))
    rows = np.column_stack(
        [heights.ravel(), *(p.ravel() for pressures in pressures_by_code for p in pressures)]
    )
    np.savetxt(FILE, rows, fmt=["%.6f"] + ["%.10g"] * len(columns), delimiter=",", header=head)


if __name__ == "__main__":
    main(sys.argv[1])
