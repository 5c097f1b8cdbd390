"""Reconstruction of the form that levelling removed, from its record."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr

from roughcontact.arguments.measurement import json_attribute
from roughcontact.surface.levelling.curved import curved_form_from_record
from roughcontact.surface.levelling.polynomial import polynomial_from_record


def form_from_record(record: Mapping[str, Mapping], y: npt.ArrayLike, x: npt.ArrayLike) -> np.ndarray:
    """Return the form (ny, nx; m) that `form_removed` of a levelled map describes, at y and x (m)."""
    # only the records of spheres and cylinders contain the height in the middle
    draw = curved_form_from_record if "height_middle" in record else polynomial_from_record
    return draw(record, y, x)


def form_order(levelled_map: xr.DataArray) -> int:
    """Return the polynomial order that levels a subwindow as the whole map was levelled."""
    form = levelled_map.attrs.get("form", "plane")
    if form == "polynomial":
        # coefficients are named c_i_j; the record of a plane has slopes instead
        terms = (name.split("_") for name in json_attribute(levelled_map.attrs, "form_removed"))
        return max((int(term[1]) + int(term[2]) for term in terms if term[0] == "c"), default=1)
    return {"none": 0, "mean": 0, "plane": 1}.get(form, 2)
