"""Another code for tests of the cross-check: projected gradients, nothing of ours.

Called as the Python of such a code is: PROGRAM CODE PROBLEM SOLUTION, of which it ignores the program.
"""

import sys

import numpy as np


def on_the_simplex(p, total):
    """Return the nearest pressures that are not negative and sum to `total`."""
    falling = np.sort(p)[::-1]
    excess = (np.cumsum(falling) - total) / np.arange(1, p.size + 1)
    return np.maximum(p - excess[falling > excess][-1], 0)


def softer(x, nu):
    """Return by how much a layer on a rigid base, x = |q| t, gives way less than a half-space."""
    k, decay = 3 - 4 * nu, np.exp(-2 * x)
    above = k * (1 - decay**2) - 4 * x * decay
    return above / (k * (1 + decay**2) + 2 * decay * (2 * x**2 + 5 - 12 * nu + 8 * nu**2))


def solve(heights, pitches, load, thickness=None, nu=0.0, steps=4000):
    """Return the pressures, E* = 1."""
    qy = 2 * np.pi * np.fft.fftfreq(heights.shape[0], pitches[0])[:, None]
    qx = 2 * np.pi * np.fft.fftfreq(heights.shape[1], pitches[1])[None, :]
    q = np.hypot(qy, qx)
    q[0, 0] = q.max()
    stiffness = q / 2 if thickness is None else q / 2 / softer(q * thickness, nu)
    stiffness[0, 0] = np.inf
    p = np.full(heights.shape, load)
    for _ in range(steps):
        gradient = np.fft.ifft2(np.fft.fft2(p) / stiffness).real - heights
        p = on_the_simplex((p - stiffness.min() * gradient).ravel(), load * p.size).reshape(p.shape)
    return p


if __name__ == "__main__":
    _, code, problem, solution = sys.argv[1:]
    given = np.load(problem)
    pitches = given["lengths"] / given["heights"].shape
    layer = [given[name] for name in ("thickness", "poissons_ratio") if name in given]
    pressures = np.array([solve(given["heights"], pitches, load, *layer) for load in given["loads"]])
    np.savez(solution, pressures=pressures, version=f"{code} 1.0")
