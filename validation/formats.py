"""Two measured faces in files of any two formats: a face fits on its imprint, and the contact is one."""

import tempfile
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import height_map
from roughcontact.contact.solve import solve_contact
from roughcontact.io.read import read_height_map
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.surface.faces.composite import composite
from roughcontact.surface.levelling.level import level
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import self_affine_surface
from roughcontact.surface.window.periodic_window import periodic_window
from validation.lines import Section

_SHAPE, _STEP = (48, 64), 1e-6  # points; m
_LOAD = 0.1  # p / (E* g)


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of faces of 48 x 64 points."""
    y, x = np.indices(_SHAPE) * _STEP
    rough = self_affine_surface(
        _SHAPE, _STEP, hurst=0.8, shortest=8e-6, longest=32e-6, rms_gradient=0.1, seed=1
    ).values
    lay = 5e-7 * np.cos(2 * np.pi * (3 * x / 64e-6 - 2 * y / 48e-6))  # oblique: a mirror image crosses it
    with tempfile.TemporaryDirectory() as folder:
        _imprints(section, rough + lay, Path(folder))
        _contacts(section, rough + lay, rough, Path(folder))


def _points(path: Path, heights: np.ndarray) -> None:
    """Write a list of points with their positions, y upwards."""
    y, x = np.indices(heights.shape) * _STEP
    rows = np.column_stack([x.ravel(), y.ravel(), heights.ravel()])
    np.savetxt(path, rows, fmt="%.15g", header="x (m) y (m) z (m)", comments="")


def _picture(path: Path, heights: np.ndarray) -> None:
    """Write a matrix as programs print it, the upper line first."""
    ny, nx = heights.shape
    header = f"# Width: {nx * _STEP} m\n# Height: {ny * _STEP} m\n# Value units: m"
    np.savetxt(path, heights[::-1], fmt="%.15g", header=header, comments="")


def _x3p(path: Path, heights: np.ndarray) -> None:
    """Write an X3P file, the lower line first."""
    import x3pio

    x3pio.write(path, heights, x_scale=_STEP, y_scale=_STEP)


_FORMATS = {"points": _points, "picture": _picture, "X3P": _x3p}


def _measured(heights: np.ndarray, kind: str, folder: Path) -> xr.DataArray:
    """Return heights (y upwards) after their way through a file."""
    path = folder / kind
    _FORMATS[kind](path, heights)
    return level(read_height_map(path), form="mean", outlier_threshold=None, line_alignment="none")


def _imprints(section: Section, heights: np.ndarray, folder: Path) -> None:
    """Add the lines of the sum of a face and its imprint, for each two formats."""
    for first, second in product(_FORMATS, repeat=2):
        face, imprint = _measured(heights, first, folder), _measured(-heights[:, ::-1], second, folder)
        rest = composite(face, imprint).std() / heights.std()
        section.compare("imprint", rest, 0.0, 1e-9, first=first, second=second)


def _contacts(section: Section, face: np.ndarray, other: np.ndarray, folder: Path) -> None:
    """Add the lines of the contact area of pairs in two formats beside that of the summed heights."""
    summed = height_map(face + other[:, ::-1], _STEP)
    load = _LOAD * rms_gradient(summed)

    def area(window: xr.DataArray) -> float:
        contact = solve_contact(window, contact_modulus=1.0, mean_pressure=load, tolerance=1e-10)
        return float(contact_statistics(contact)["relative_contact_area"][0])

    reference = area(summed)
    for first, second in (("points", "picture"), ("picture", "X3P"), ("X3P", "points")):
        pair = composite(_measured(face, first, folder), _measured(other, second, folder))
        section.compare(
            "pair", area(periodic_window(pair)), reference, 1e-6, load=_LOAD, first=first, second=second
        )
