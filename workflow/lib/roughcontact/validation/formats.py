"""Two measured faces in files of any two formats: a face fits on its imprint, and the contact is one."""

import tempfile
from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.faces.composite import composite
from roughcontact.io.read import read_height_map
from roughcontact.levelling.level import level
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.validation.lines import Evidence, Line, Part, compare
from roughcontact.window.periodic_window import periodic_window

TITLE = "Faces in files of different formats"
_SHAPE, _STEP = (48, 64), 1e-6  # points; m
_LOAD = 0.1  # p / (E* g)

IMPRINT = Evidence(
    "h₁(x, y) + h₂(−x, y) = 0 for a face h₁ on its imprint h₂(x, y) = −h₁(−x, y)",
    "Johnson (1985), Contact Mechanics, section 13.4; a mirror image fits on nothing else",
    "faces.composite.composite",
    "tests/unit/test_faces.py::test_a_face_fits_on_its_imprint_whatever_their_formats",
)
PAIR = Evidence(
    "the contact of two faces is that of h₁(x, y) + h₂(−x, y) on a flat",
    "Greenwood and Tripp (1970), Proc. Inst. Mech. Eng. 185, 625",
    "faces.composite.composite",
    "tests/unit/test_faces.py::test_the_contact_of_a_pair_depends_neither_on_formats_nor_on_the_order",
)


def part(*, finest_grid: int) -> Part:
    """Return the lines of this part.

    Parameters
    ----------
    finest_grid : int
        points along the finest grid.
        Maps of 48 x 64 points serve whatever it is.

    Returns
    -------
    Part
    """
    y, x = np.indices(_SHAPE) * _STEP
    rough = self_affine_surface(
        _SHAPE, _STEP, hurst=0.8, shortest=8e-6, longest=32e-6, rms_gradient=0.1, seed=1
    ).values
    lay = 5e-7 * np.cos(2 * np.pi * (3 * x / 64e-6 - 2 * y / 48e-6))  # oblique: a mirror image crosses it
    heights = rough + lay
    with tempfile.TemporaryDirectory() as folder:
        lines = [*_imprints(heights, Path(folder)), *_contacts(heights, rough, Path(folder))]
    text = (
        "A face with an oblique lay is written as list of points, as picture in text and as X3P. Whatever "
        "the two formats of a pair, a face must fit on its imprint, and the contact of two faces must be "
        "that of the sum of their heights."
    )
    return Part("formats", TITLE, text, lines)


def _points(path: Path, heights: np.ndarray) -> None:
    """Write a list of points with their positions, y upwards."""
    y, x = np.indices(heights.shape) * _STEP
    np.savetxt(
        path,
        np.column_stack([x.ravel(), y.ravel(), heights.ravel()]),
        fmt="%.15g",
        header="x (m) y (m) z (m)",
        comments="",
    )


def _picture(path: Path, heights: np.ndarray) -> None:
    """Write a matrix as programs print it, the upper line first."""
    ny, nx = heights.shape
    header = f"# Width: {nx * _STEP} m\n# Height: {ny * _STEP} m\n# Value units: m"
    np.savetxt(path, heights[::-1], fmt="%.15g", header=header, comments="")


def _x3p(path: Path, heights: np.ndarray) -> None:
    """Write an X3P file, the lower line first."""
    import x3pio

    x3pio.write(path, heights, x_scale=_STEP, y_scale=_STEP)


_FORMATS: dict[str, Callable[[Path, np.ndarray], None]] = {
    "points": _points,
    "picture": _picture,
    "X3P": _x3p,
}


def _measured(heights: np.ndarray, kind: str, folder: Path) -> xr.DataArray:
    """Return heights (y upwards) after their way through a file."""
    path = folder / kind
    _FORMATS[kind](path, heights)
    return level(read_height_map(path), form="mean", outlier_threshold=None, line_alignment="none")


def _imprints(heights: np.ndarray, folder: Path) -> list[Line]:
    """Return what is left of a face on its imprint, for each two formats."""
    return [
        compare(
            f"Face ({first}) on its imprint ({second}): rms of the sum / rms of the face",
            composite(_measured(heights, first, folder), _measured(-heights[:, ::-1], second, folder)).std()
            / heights.std(),
            0.0,
            measure="absolute",
            tolerance=1e-9,
            reason="digits of the files",
            evidence=IMPRINT,
        )
        for first, second in product(_FORMATS, repeat=2)
    ]


def _contacts(face: np.ndarray, other: np.ndarray, folder: Path) -> list[Line]:
    """Return contact areas of pairs in two formats beside that of the summed heights."""
    summed = height_map(face + other[:, ::-1], _STEP)
    load = _LOAD * rms_gradient(summed)

    def area(window: xr.DataArray) -> float:
        contact = solve_contact(window, contact_modulus=1.0, mean_pressure=load, tolerance=1e-10)
        return float(contact_statistics(contact)["relative_contact_area"][0])

    reference = area(summed)
    return [
        compare(
            f"Pair ({first} and {second}), p′ = {_LOAD:g}: contact area",
            area(
                periodic_window(composite(_measured(face, first, folder), _measured(other, second, folder)))
            ),
            reference,
            tolerance=1e-6,
            reason="digits of the files",
            evidence=PAIR,
        )
        for first, second in (("points", "picture"), ("picture", "X3P"), ("X3P", "points"))
    ]
