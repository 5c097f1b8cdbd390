"""The error bound held against true errors, on random maps and on small ones that a dense solver solves too.

Each function yields names of jobs and what to call for their records, which `speed.py` keeps. The true error
is that of `counts.compare`, by a solution to 1e-12 or by that of a quadratic program (non-negative least
squares of SciPy), which knows nothing of this solver.
"""

from collections.abc import Callable
from functools import partial

import counts
import numpy as np
import xarray as xr
from scipy.optimize import nnls

from roughcontact.arguments.maps import height_map, spacing
from roughcontact.contact.loads import plan_loads
from roughcontact.surface.synthetic import self_affine_surface

JOBS = 10  # each keeps its records, so that a long measurement can be stopped
RANDOM, DENSE = 100, 24  # solves of each job: 1 000 and 240
DENSE_ERROR = 1e-10  # of the least squares, relative
HURST = (0.2, 1.0)


def random(study):
    """Yield the jobs of random maps, loads, tolerances and hardness, against solutions to 1e-12."""
    for job in range(JOBS):
        yield str(job), partial(of_job, "random", random_solve, RANDOM, seed=[1, job])


def dense(study):
    """Yield the jobs of small maps that a dense solver solves too."""
    for job in range(JOBS):
        yield str(job), partial(of_job, "dense", dense_solve, DENSE, seed=[2, job])


def of_job(name: str, solve: Callable, number: int, *, seed: list[int]) -> dict:
    """Return the solves of a job."""
    generator = np.random.default_rng(seed)
    return {"name": name, "solves": [solve(generator) for _ in range(number)]}


def random_solve(generator: np.random.Generator) -> dict:
    """Return bound and true error of one solve, all drawn at random."""
    shape = tuple(int(n) for n in generator.integers(2, 150, 2))
    pitch = tuple(10.0 ** generator.uniform(-0.7, 0.7, 2))
    if generator.random() < 0.1:
        shape, pitch = (1, 20 * shape[1]), (1.0, 1.0)
    longest = max(n * step for n, step in zip(shape, pitch, strict=True))
    band = {"shortest": min(pitch) * 10.0 ** generator.uniform(0.3, 1), "longest": longest}
    options = {"hurst": generator.uniform(*HURST), "seed": int(generator.integers(2**31))}
    window = self_affine_surface(shape, pitch, rms_gradient=1.0, **band, **options)
    (load,) = plan_loads(window, contact_modulus=1.0, relative_pressure=[10.0 ** generator.uniform(-3, 0.5)])
    hardness = load * 10.0 ** generator.uniform(0.05, 1.5) if generator.random() < 0.25 else None
    solution, exact = (
        counts.solved(window, load, tolerance=tolerance, hardness=hardness)
        for tolerance in (10.0 ** generator.uniform(-8, -1), counts.TRUTH)
    )
    return counts.pairs(solution) | counts.compare(solution, exact, spacing(window))


def dense_solve(generator: np.random.Generator) -> dict:
    """Return bound and true error of one solve, at the load of a dense solution of some indentation."""
    shape = tuple(int(n) for n in generator.integers(2, 15, 2))
    heights = generator.standard_normal(shape)
    if generator.random() < 0.5:
        heights = heights.cumsum(0).cumsum(1)
    window = height_map(heights / 100, tuple(10.0 ** generator.uniform(-1, 1, 2)))
    pressure = dense_pressure(window, generator.uniform(0.05, 2) * np.ptp(window.values))
    solution = counts.solved(window, pressure.mean(), tolerance=10.0 ** generator.uniform(-7, -1))
    exact = xr.Dataset({"pressure": (("y", "x"), pressure), "error_bound": DENSE_ERROR})
    return counts.pairs(solution) | counts.compare(solution, exact, spacing(window))


def dense_pressure(window, indentation: float) -> np.ndarray:
    """Return the pressure (ny, nx) at an indentation of the highest point: min |R p - R^-1 (h + d)|, p >= 0.

    With G = R R this is the quadratic program of the contact, whose load is the mean of its solution.
    """
    root, inverse = dense_root(window.shape, spacing(window))
    target = inverse @ (window.values - window.values.max() + indentation).ravel()
    return nnls(root, target, maxiter=100 * window.size)[0].reshape(window.shape)


def dense_root(shape: tuple[int, int], steps: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the symmetric root of the matrix of G(q) = 2/|q|, with 1 for the mean, and its inverse."""
    qy, qx = (2 * np.pi * np.fft.fftfreq(n, step) for n, step in zip(shape, steps, strict=True))
    q = np.hypot(qy[:, None], qx)
    root = np.sqrt(np.divide(2, q, out=np.ones_like(q), where=q > 0))
    waves = np.fft.fft2(np.eye(q.size).reshape(-1, *shape))
    return tuple(np.fft.ifft2(waves * factor).real.reshape(q.size, -1) for factor in (root, 1 / root))
