"""Numbers per load of a contact solution: areas, clusters, pressures, gaps, energy, stiffness, and theory."""

import numpy as np
import xarray as xr

from roughcontact.contact.response import linear_response
from roughcontact.elasticity.energy import elastic_energy
from roughcontact.errors import SettingsError
from roughcontact.maps import spacing
from roughcontact.roughness.parameters import roughness_parameters, summit_statistics
from roughcontact.roughness.texture import texture_parameters
from roughcontact.statistics import theory
from roughcontact.statistics.contact_geometry import contact_perimeter, count_clusters, relative_contact_area

# what the solver says of each load, handed on unchanged
SOLVER_COLUMNS = (
    "approach",
    "iterations",
    "operator_applications",
    "error_bound",
    "rounding_floor",
    "yielded_area",
    "max_penetration",
    "load_error",
    "converged",
)

# of ISO 25178-2, as `parameters.height_parameters` returns them
HEIGHT_PARAMETERS = ("Sa", "Sq", "Ssk", "Sku", "Sp", "Sv", "Sz", "Sdq")

_PRESSURE_DECADES = (-3, 3)  # in units of E* g
_GAP_DECADES = (-4, 0)  # in units of the peak-to-valley height, which no gap exceeds


_DIMS = {"pressure_density": ("load", "pressure_bin"), "gap_density": ("load", "gap_bin")}


def contact_statistics(contact: xr.Dataset, *, pressure_bins: int = 20, gap_bins: int = 20) -> xr.Dataset:
    """Return the statistics of each load of a contact solution.

    Parameters
    ----------
    contact : Dataset
        As `solve_contact` returns it: `pressure` (load, y, x) Pa, `gap` (load, y, x) m, `height` (y, x) m
        with the optional coordinate `filled`, `contact_modulus` Pa, coordinate `mean_pressure` (load) Pa.
    pressure_bins, gap_bins : int
        Bins per factor of ten. Pressures: [0, 1e-3], then logarithmic to 1e3, in units of E* g. Gaps: [0,
        1e-4], then logarithmic to 1, in units of the peak-to-valley height. The bounds depend on the
        surface and on E* alone, never on the loads; a value above the last bound is counted in the last
        bin, so nothing is lost.

    Returns
    -------
    Dataset, dims (load, pressure_bin, gap_bin), SI units; `roughcontact.variables` explains each name

    Raises
    ------
    SettingsError
        where a number of bins is no whole number of at least 1.
    """
    for name, bins in (("pressure_bins", pressure_bins), ("gap_bins", gap_bins)):
        if int(bins) != bins or bins < 1:
            raise SettingsError(
                f"{name} = {bins!r} is no number of bins per factor of ten; give 1, 2, 3, ..."
            )
    height, modulus = contact["height"], float(contact["contact_modulus"])
    steps = spacing(height)
    mean_pressure = np.asarray(contact["mean_pressure"].values, float)
    surface = surface_statistics(height)
    gradient = float(surface["rms_gradient"])
    # a flat map has neither gradient nor heights to set the scale of the bins
    edges = {
        "pressure": (modulus * gradient or modulus) * _logarithmic_edges(_PRESSURE_DECADES, pressure_bins),
        "gap": (float(np.ptp(height.values)) or steps[1]) * _logarithmic_edges(_GAP_DECADES, gap_bins),
    }
    filled = height["filled"].values != 0 if "filled" in height.coords else None
    rows = [
        _one_load(
            contact["pressure"].values[index],
            contact["gap"].values[index],
            steps,
            contact_modulus=modulus,
            filled=filled,
            edges=edges,
        )
        for index in range(contact.sizes["load"])
    ]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    columns |= {name: contact[name].values for name in SOLVER_COLUMNS if name in contact}
    columns |= theory_columns(mean_pressure, height, contact_modulus=modulus, rms_gradient=gradient)
    # a number of the map, listed with each load like everything that says how far to trust it
    columns["points_per_shortest_wavelength"] = np.full(
        mean_pressure.shape, surface.pop("points_per_shortest_wavelength")
    )
    columns = {name: (_DIMS.get(name, ("load",)), values) for name, values in columns.items()}
    coordinates = {"mean_pressure": ("load", mean_pressure)}
    for name, bounds in edges.items():
        coordinates[f"{name}_bin"] = (
            f"{name}_bin",
            (bounds[1:] + bounds[:-1]) / 2,
            {"bounds": f"{name}_bin_bounds"},
        )
        coordinates[f"{name}_bin_bounds"] = (
            (f"{name}_bin", "bounds"),
            np.column_stack([bounds[:-1], bounds[1:]]),
        )
    return xr.Dataset(
        columns | surface | {"contact_modulus": modulus}, coords=coordinates, attrs=contact.attrs
    )


def with_uncertainty(statistics: xr.Dataset, budget: xr.Dataset) -> xr.Dataset:
    """Return the statistics with the error budget beside them, `{quantity}_uncertainty` (load, source).

    Parameters
    ----------
    statistics : Dataset
        from `contact_statistics`.
    budget : Dataset
        from `error_budget`, for the same loads; it may be empty. Its attributes `window_flag` and
        `window_reason`, ... go along.

    Raises
    ------
    SettingsError
        where the two are for different loads.
    """
    if not np.array_equal(statistics["mean_pressure"].values, budget["mean_pressure"].values):
        raise SettingsError("the error budget is for other loads than the statistics; compute both again")
    found = [name for name in budget.data_vars if name.endswith("_uncertainty")]
    words = {
        key: budget.attrs[key]
        for key in ("window_reason", "window_flag", "processing_reason")
        if key in budget.attrs
    }
    return statistics.merge(budget[found], compat="override", join="override").assign_attrs(words)


def surface_statistics(height: xr.DataArray) -> dict:
    """Return roughness (spectral), texture, size and position of the solved window, and the height parameters
    that levelling left in its attributes; a dict of floats in SI units (`Std`: degree)."""
    (ny, nx), (dy, dx) = height.shape, spacing(height)
    # the middle of the range first: then a constant map is exactly zero, and flat, whatever its offset
    middle = (float(height.min()) + float(height.max())) / 2
    parameters = {name: float(height.attrs[name]) for name in HEIGHT_PARAMETERS if name in height.attrs}
    parameters |= roughness_parameters(height - middle) | texture_parameters(height)
    return parameters | {
        "window_length_x": nx * dx,
        "window_length_y": ny * dy,
        "window_offset_x": float(height.attrs.get("window_offset_x", 0.0)),
        "window_offset_y": float(height.attrs.get("window_offset_y", 0.0)),
    }


def theory_columns(mean_pressure, height, *, contact_modulus, rms_gradient) -> dict:
    """Return the load p' = p̄/(E* g) and the contact area of each theory at it, a dict of arrays (load).

    NaN where a theory says nothing: those of asperities on a single row or column, which has ridges and no
    summits, and where they exceed full contact. A flat map has infinite p'.
    """
    if rms_gradient > 0:
        relative = mean_pressure / (contact_modulus * rms_gradient)
    else:
        relative = np.full(mean_pressure.shape, np.inf)
    low_load = theory.bush_gibson_thomas_area(relative)
    summits = summit_statistics(height)
    return {
        "relative_pressure": relative,
        "area_persson": theory.persson_area(relative),
        "area_xu": theory.xu_area(relative),
        "area_bush_gibson_thomas": np.full(relative.shape, np.nan) if 1 in height.shape else low_load,
        "area_greenwood_williamson": theory.greenwood_williamson_area(
            mean_pressure, summits, contact_modulus=contact_modulus
        ),
    }


def _one_load(pressure, gap, steps, *, contact_modulus, filled, edges) -> dict:
    """Return all numbers of one load; `pressure` (ny, nx) Pa, `gap` (ny, nx) m, `filled` (ny, nx) or None."""
    touching = pressure > 0
    points = int(np.count_nonzero(touching))
    carried = pressure[touching]
    compliance = linear_response(touching, steps, contact_modulus)
    return {
        "relative_contact_area": relative_contact_area(touching),
        "relative_contact_area_pixels": points / touching.size,
        "contact_perimeter": contact_perimeter(touching, steps),
        "contact_clusters": count_clusters(touching),
        "contact_on_filled_points": 0.0 if filled is None else np.count_nonzero(touching & filled) / points,
        "mean_contact_pressure": carried.mean(),
        "max_pressure": carried.max(),
        "pressure_std": carried.std(),
        # the solver keeps the mean of the gap over the contact at zero: what is left there is rounding
        "mean_gap": gap[~touching].sum() / gap.size,
        "contact_stiffness": 1 / compliance if compliance > 0 else np.inf,
        "elastic_energy": elastic_energy(pressure, steps, contact_modulus=contact_modulus),
        "pressure_density": _density(carried, edges["pressure"]),
        "gap_density": _density(gap[~touching], edges["gap"]),
    }


def _logarithmic_edges(decades: tuple[int, int], per_decade: int) -> np.ndarray:
    """Return 0 and then `per_decade` bounds per factor of ten."""
    low, high = decades
    return np.concatenate([[0.0], 10.0 ** np.linspace(low, high, (high - low) * int(per_decade) + 1)])


def _density(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the probability density of `values` in the bins; NaN where there are no values."""
    if values.size == 0:
        return np.full(edges.size - 1, np.nan)
    # values above the last bound fall in the last bin, roundings below zero in the first
    bins = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
    return np.bincount(bins, minlength=edges.size - 1) / (values.size * np.diff(edges))
