"""Worker for this project: everything goes through the public verb `solve_contact`, labels included."""

import os
import sys
from importlib.metadata import distributions
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import worker

import roughcontact as rc
from roughcontact.arguments.maps import height_map

THREADS = int(os.environ["OMP_NUM_THREADS"])


def solve(window, load, tolerance, *, fields=True, precision="double"):
    """Return the pressure of the last load (None without fields) and what gives the numbers of all loads."""
    contact = rc.solve_contact(
        window,
        contact_modulus=1.0,
        mean_pressure=load,
        tolerance=tolerance,
        threads=THREADS,
        fields=fields,
        precision=precision,
        on_failure="flag",
    )
    return contact["pressure"].values[-1] if fields else None, lambda: details(contact)


def details(contact) -> dict:
    """Return the numbers of a solution, all loads taken together."""
    numbers = {
        "operator_applications": float(contact["operator_applications"].sum()),
        "error_bound": float(contact["error_bound"].max()),
        "converged": bool(contact["converged"].all()),
    }
    if "contact" in contact:
        numbers["contact_share"] = float(contact["contact"][-1].mean())
    return numbers


def versions() -> dict:
    """Return the versions of the package and of the libraries that compute for it."""
    used = ("numpy", "scipy", "ducc0")
    installed = {distribution.metadata["Name"]: distribution.version for distribution in distributions()}
    return {"roughcontact": rc.__version__} | {name: installed[name] for name in used if name in installed}


if __name__ == "__main__":
    worker.serve(lambda heights: height_map(heights, 1 / heights.shape[1]), solve, versions())
