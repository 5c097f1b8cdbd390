"""Compile the kernels that most tests need, so that workers side by side do not compile each their own.

Numba keeps them beside the package: where they are kept already this takes seconds.
"""

import roughcontact as rc
from roughcontact.references.synthetic import self_affine_surface

BAND = {"hurst": 0.8, "shortest": 8.0, "longest": 32.0}


def main():
    height = self_affine_surface(
        (300, 300), 1.0, **BAND, rms_gradient=0.1, seed=1
    )  # large enough for threads
    problem = {"contact_modulus": 1.0, "mean_pressure": [0.01, 0.02], "tolerance": 1e-4}
    for threads in (1, 2):
        for precision in ("double", "single"):
            rc.contact_statistics(rc.solve_contact(height, **problem, threads=threads, precision=precision))


if __name__ == "__main__":
    main()
