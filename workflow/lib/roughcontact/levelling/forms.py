"""The form that was removed from a map, drawn again from its record."""

import numpy as np
from numpy.polynomial import legendre

from roughcontact.levelling.curved import curved_form_from_record


def form_from_record(removed: dict, y, x) -> np.ndarray:
    """Return the form (ny, nx) in m that `fit_form` (or `fit_curved_form`) recorded, on the map's own
    coordinates in m."""
    if "height_middle" in removed:
        return curved_form_from_record(removed, y, x)
    value = {name: entry["value"] for name, entry in removed.items()}
    y, x = np.asarray(y, dtype=float), np.asarray(x, dtype=float)
    if "c_0_0" in value:
        terms = [tuple(map(int, name[2:].split("_"))) for name in value if name.startswith("c_")]
        coefficients = np.zeros([1 + max(t[k] for t in terms) for k in (1, 0)])
        for i, j in terms:
            coefficients[j, i] = value[f"c_{i}_{j}"]
        scaled = [(c - value[f"middle_{d}"]) / value[f"half_length_{d}"] for c, d in ((y, "y"), (x, "x"))]
        return legendre.leggrid2d(*scaled, coefficients)
    slope_y, slope_x = value.get("slope_y", 0.0), value.get("slope_x", 0.0)
    return (
        value.get("mean", 0.0)
        + slope_y * (y - (y[0] + y[-1]) / 2)[:, None]
        + slope_x * (x - (x[0] + x[-1]) / 2)[None, :]
    )
