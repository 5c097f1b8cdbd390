"""Solve the surface of the contact-mechanics challenge without adhesion: area, gap, stiffness over the load.

    python benchmarks/challenge.py --points 2048 --write
    python benchmarks/challenge.py FILE

The problem is that of Müser and Dapp (2015), arXiv 1512.02403; its solutions are compared in Müser and others
(2017), Tribol. Lett. 65, 118: a square of 0.1 mm, Hurst exponent 0.8, roll-off at 20 µm, cut-off at 0.1 µm,
rms gradient 1, E* = 25 MPa. FILE is the published surface, heights in metres. Without it a realisation of the
spectrum is made: constant to the roll-off, a power law to the cut-off or two pixels, random phases.
"""

import argparse
import math
import resource
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.kernels.fourier import wavenumbers
from roughcontact.surface.roughness.parameters import rms_gradient

SIDE, ROLL_OFF, CUT_OFF = 1e-4, 2e-5, 1e-7  # m
HURST, GRADIENT, MODULUS = 0.8, 1.0, 25e6  # E* in Pa
LOADS = (5e-4, 2e-3, 0.01, 0.03, 0.08)  # mean pressure over E* and rms gradient: to some 15 % in contact
TOLERANCE = 1e-4
TABLE = Path(__file__).parent / "results/challenge/loads.csv"


def realisation(points, seed=0):
    """Return a map (m) with the spectrum of the challenge, and its rms gradient."""
    step = SIDE / points
    q = wavenumbers((points, points), (step, step))
    longest, shortest = 2 * math.pi / ROLL_OFF, 2 * math.pi / max(CUT_OFF, 2 * step)
    amplitude = np.where((q > 0) & (q <= shortest), np.maximum(q, longest) ** -(1 + HURST), 0.0)
    phases = np.angle(np.fft.rfft2(np.random.default_rng(seed).standard_normal((points, points))))
    height = rc.height_map(np.fft.irfft2(amplitude * np.exp(1j * phases), s=(points, points)), step, unit="m")
    return height.copy(data=height.values * (GRADIENT / rms_gradient(height)))


def solved(height):
    """Return a row for each load."""
    gradient, size, rows = rms_gradient(height), float(height.std()), []
    for load in LOADS:
        began = time.process_time()
        pressure = load * MODULUS * gradient
        arguments = {"contact_modulus": MODULUS, "mean_pressure": pressure, "tolerance": TOLERANCE}
        contact = rc.solve_contact(height, **arguments)
        took = time.process_time() - began
        numbers = rc.contact_statistics(contact).isel(load=0)
        rows.append(
            {
                "points per side": height.shape[0],
                "p over E* and gradient": load,
                "area (%)": 100 * float(numbers["relative_contact_area"]),
                "mean gap over rms height": float(numbers["mean_gap"]) / size,
                "stiffness (Pa/m)": float(numbers["contact_stiffness"]),
                "error bound": float(contact["error_bound"][0]),
                "CPU time of the solve (s)": took,
                "peak memory (MB)": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000,
            }
        )
        print(rows[-1], flush=True)
    return rows


def main(*, file, points, write):
    """Print the table of one surface, or write it."""
    height = rc.read_height_map(file) if file else realisation(points)
    table = pd.DataFrame(solved(height)).map(lambda value: f"{value:.4g}")
    if write:
        table.to_csv(TABLE, index=False)
    print(table.to_string(index=False))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", nargs="?", help="the published surface; else a realisation of its spectrum")
    parser.add_argument("--points", type=int, default=2048, help="per side, of a realisation")
    parser.add_argument("--write", action="store_true")
    main(**vars(parser.parse_args()))
