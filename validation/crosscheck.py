"""Solve the windows of a finished run by another code: `python3 run.py crosscheck results/ground --python P`.

The other code, Tamaas or ContactMechanics, runs as an outside program by the Python in which it is installed;
none of it is imported.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.arguments.choices import check_choice
from roughcontact.arguments.maps import spacing
from roughcontact.errors import HeightMapError, RoughContactError, SettingsError
from roughcontact.results.storage import read_dataset, write_table
from roughcontact.surface.roughness import parameters
from validation.closed_forms import gap_left_by
from validation.layered_sphere import rigid_base_factor

OutsideCode = Literal["tamaas", "contactmechanics"]
CODES: dict[OutsideCode, str] = {"tamaas": "Tamaas", "contactmechanics": "ContactMechanics"}
PROGRAM = Path(__file__).with_name("outside.py")
_RIGID = 1e9  # times as stiff as a layer: rigid beside it
_ROWS = 8  # number of equal rows that represent a profile: not every code solves a single row correctly


class CrossCheckError(RoughContactError, RuntimeError):
    """Another code that does not run or does not converge."""


def crosscheck(
    window: xr.DataArray, contact: xr.Dataset, statistics: xr.Dataset, *, code: OutsideCode, python: str
) -> xr.Dataset:
    """Solve the contact of a window by another code, and compare load by load.

    The mean gap follows from the pressure of the other code, u = G p.

    Parameters
    ----------
    window : DataArray (y, x), m
        the map that was solved.
    contact : Dataset
        as `solve_contact` returns it; without `pressure` the fields are not compared.
    statistics : Dataset
        as `contact_statistics` returns it.
    code : str
        ``tamaas`` or ``contactmechanics``.
    python : str
        path of the Python in which it is installed.

    Returns
    -------
    Dataset
        dim load: `other_contact_area_pixels`, `other_max_pressure` (Pa), `other_mean_gap` (m),
        `pressure_difference` and `contact_difference` (NaN without fields); attributes `code` and `version`.

    Raises
    ------
    CrossCheckError
        where the program does not run or does not converge, with its error message.
    HeightMapError
        for a flat map: there is nothing to compare.
    SettingsError
        for an unknown code, or without a Python to run it.
    """
    check_choice("code", code, OutsideCode)
    if not python:
        raise SettingsError(f"python = {python!r}: give the path of a Python that has {CODES[code]}")
    gradient = parameters.rms_gradient(window)
    if gradient == 0:
        raise HeightMapError("the window is flat: there is nothing to cross-check")
    loads, modulus = statistics["mean_pressure"].values, float(statistics["contact_modulus"])
    (dy, dx), unit = spacing(window), modulus * gradient
    # units in which all quantities are of order 1: some codes have absolute tolerances
    length = float(np.sqrt(np.prod([n * step for n, step in zip(window.shape, (dy, dx), strict=True)])))
    scaled = (window.values - window.values.mean()) / (gradient * length)
    pitches = (dy / length, dx / length)
    layer = _layer(statistics, code, length)
    solved, version = _solve_outside(scaled, pitches, loads / unit, layer, code=code, python=python)
    factor = partial(_factor, layer) if layer else None
    rows = []
    for index, other in enumerate(solved):
        gap = gap_left_by(other, scaled, pitches, 1.0, factor)
        row = {
            "other_contact_area_pixels": np.count_nonzero(other > 0) / other.size,
            "other_max_pressure": other.max() * unit,
            "other_mean_gap": gap[other <= 0].sum() / gap.size * gradient * length,
            "pressure_difference": np.nan,
            "contact_difference": np.nan,
        }
        if "pressure" in contact:
            own = contact["pressure"].values[index] / unit
            row["pressure_difference"] = np.sqrt(np.mean((other - own) ** 2) / np.mean(own**2))
            row["contact_difference"] = np.count_nonzero((other > 0) != (own > 0))
        rows.append(row)
    return xr.Dataset(
        {name: ("load", np.array([row[name] for row in rows], float)) for name in rows[0]},
        coords={"mean_pressure": ("load", loads)},
        attrs={"code": CODES[code], "version": version},
    )


def sheet_on_rigid_base(bodies: Sequence[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """Return the single layer of a contact of which all else is rigid; None where there is more to it.

    Examples
    --------
    >>> sheet = {"thickness": 1e-3, "youngs_modulus": 3e6, "poissons_ratio": 0.5}
    >>> rigid = {"youngs_modulus": 1e20, "poissons_ratio": 0.3}
    >>> sheet_on_rigid_base([{"base": "rigid", "layers": [sheet]}, rigid])["thickness"]
    0.001
    >>> sheet_on_rigid_base([rigid | {"layers": [sheet]}, rigid]) is None
    True
    """
    layered = [body for body in bodies if body.get("layers")]
    others = [body["youngs_modulus"] for body in bodies if not body.get("layers")]
    if len(layered) != 1 or layered[0].get("base") != "rigid" or len(layered[0]["layers"]) != 1:
        return None
    sheet: Mapping[str, Any] = layered[0]["layers"][0]
    return sheet if all(stiff >= _RIGID * sheet["youngs_modulus"] for stiff in others) else None


def _layer(statistics: xr.Dataset, code: OutsideCode, length: float) -> dict[str, float]:
    """Return thickness, over a length, and Poisson's ratio of the layer of a contact; none: half-spaces."""
    if "bodies" not in statistics.attrs:
        return {}
    sheet = sheet_on_rigid_base(json.loads(statistics.attrs["bodies"]))
    if sheet is None or code != "contactmechanics":
        raise SettingsError(
            f"code = {code!r}: of bodies with layers another code solves one layer on a rigid base, pressed "
            "by a rigid body (youngs_modulus 1e20), and that is contactmechanics"
        )
    return {"thickness": sheet["thickness"] / length, "poissons_ratio": sheet["poissons_ratio"]}


def _factor(layer: Mapping[str, float], q: np.ndarray) -> np.ndarray:
    return rigid_base_factor(q * layer["thickness"], layer["poissons_ratio"])


def _solve_outside(
    heights: np.ndarray,
    pitches: tuple[float, float],
    loads: np.ndarray,
    layer: Mapping[str, float],
    *,
    code: OutsideCode,
    python: str,
) -> tuple[np.ndarray, str]:
    """Return (pressures (load, ny, nx), version) of another code; dimensionless, E* = 1."""
    shape = heights.shape
    rows, columns = (_ROWS if n == 1 else n for n in shape)
    heights = np.ascontiguousarray(np.broadcast_to(heights, (rows, columns)))
    lengths = (rows * pitches[0], columns * pitches[1])
    # the other process has paths of its own
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    with tempfile.TemporaryDirectory() as folder:
        problem, solution = Path(folder) / "problem.npz", Path(folder) / "solution.npz"
        fields: dict[str, Any] = {"heights": heights, "lengths": lengths, "loads": loads, **layer}
        np.savez(problem, **fields)
        command = [python, str(PROGRAM), code, str(problem), str(solution)]
        try:
            run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        except OSError as error:
            raise CrossCheckError(f"python = {python!r} does not start ({error})") from error
        if run.returncode:
            said = run.stderr.strip().splitlines() or [f"exit status {run.returncode}"]
            raise CrossCheckError(
                f"{CODES[code]} did not solve the problem: {said[-1]}. Is it installed where {python} looks?"
            )
        with np.load(solution) as computed:
            return computed["pressures"][:, : shape[0], : shape[1]], str(computed["version"])


def table(statistics: xr.Dataset, other: xr.Dataset) -> pd.DataFrame:
    """Return the shares of the pixels in contact and the relative differences, a row for each load."""

    def relative(name: str) -> np.ndarray:
        own = statistics[name].values
        difference = other[f"other_{name}"].values - own
        return np.divide(difference, own, out=np.zeros_like(own), where=own > 0)  # no gap in full contact

    return pd.DataFrame(
        {
            "mean_pressure_Pa": other["mean_pressure"].values,
            "pixels_in_contact": statistics["relative_contact_area_pixels"].values,
            "pixels_by_the_other_code": other["other_contact_area_pixels"].values,
            "points_that_differ": other["contact_difference"].values,
            "pressure_rms_difference": other["pressure_difference"].values,
            "max_pressure_difference": relative("max_pressure"),
            "mean_gap_difference": relative("mean_gap"),
        }
    )


def main(arguments: Sequence[str]) -> int:
    """Cross-check each folder of results, print the tables, and return 1 where another code failed."""
    parser = argparse.ArgumentParser(prog="run.py crosscheck", description=__doc__.splitlines()[0])
    parser.add_argument("results", nargs="+", type=Path, help="folder of a surface: results/ground")
    parser.add_argument("--python", required=True, help="path of the Python that has the other code")
    parser.add_argument("--code", choices=list(CODES), default="tamaas", help="the other code (%(default)s)")
    options = parser.parse_args(arguments)
    try:
        for folder in options.results:
            window, contact, statistics = (
                read_dataset(folder / f"{name}.nc") for name in ("window", "contact", "statistics")
            )
            other = crosscheck(
                window["height"], contact, statistics, code=options.code, python=options.python
            )
            differences = table(statistics, other)
            write_table(differences, folder / "crosscheck.csv")
            print(f"{folder}, solved by {other.attrs['code']} {other.attrs['version']}:")
            print(differences.to_string(index=False, float_format="{:.4g}".format))
    except RoughContactError as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
