"""Uncertainty of the instrument: amplification, noise, lens or lateral resolution, tip.

The result is that of the map as measured; the interval reaches to where the truth may be.

* Amplification (calibration of the scales) follows from the solved curve (`scaling`).
* Noise adds to the gradient: g^2 = g_true^2 + g_noise^2, so that the area comes out too small and pressure
  and gap too large. The window is solved once more with the same noise added; the exponent d ln Q/d ln g that
  follows from it takes the result back from g to g_true (simulation and extrapolation, Cook and Stefanski
  1994). On 43 measured and made maps with noise of 1 to 10 % of Sq the truth lay at 1.2 times this shift in
  the median, at twice the shift in the outer tenth: half of the shift is added to it, and half is its
  uncertainty. Where no noise is stated and the spectrum is flat at its end, its floor may be noise, or waves
  that the pixels fold back: the shift by such noise is added as a bound.
* A lens, or a stated resolution, attenuates short waves. The window is solved once more with the transfer
  undone (`transfer.restored`).
* A tip rounds peaks. The window is solved once more as the eroded map (`transfer.eroded`), which undoes it
  where the tip touched.

The last three are one-sided: each shifts the end of the interval on its side (JCGM 100:2008, F.2.4.5).
"""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.errors import SettingsError
from roughcontact.maps import spacing
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.statistics.instrument_checks import suspected_noise
from roughcontact.uncertainty.answers import counter_of, quantities_in
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.scaling import AREA, PRESSURE, effort, half_widths, scaling_uncertainty
from roughcontact.uncertainty.transfer import eroded, restored, with_noise
from roughcontact.window.band import numerical_aperture

_TOLERANCE = 1e-3  # of the pressure
_NOISE_MARGIN = 1.0  # of the shift by noise: half of it is added, half is its uncertainty
_RESTORING_UNCERTAINTY = 0.25  # of the shift by a lens or a tip
_MOST_NOISE = 0.95  # of g^2; a map with more noise says nothing of its surface
_STATED = "instrument_"  # beginning of the attributes of a map that hold what the table says
_AMPLIFICATIONS = ("amplification_z", "amplification_xy")


def instrument_uncertainty(
    window: xr.DataArray,
    *,
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    instrument: Mapping[str, Any],
    s_filter: float | None = None,
) -> xr.Dataset:
    """Return the uncertainty of each result due to what is known of the instrument.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    contact : dict
        keyword arguments of `solve_contact`.
    solved : Dataset
        the result: `QUANTITIES` and answers along `load`.
    instrument : mapping
        what is stated of `noise` (m, rms), `resolution` (m), `numerical_aperture`, `wavelength` (m),
        `tip_radius` (m), `amplification_z`, `amplification_xy` (relative, expanded).
    s_filter : float, m, optional
        nesting index of the filter that the map has gone through.

    Returns
    -------
    Dataset
        along `load`, `{name}`, `{name}_down`, `{name}_up`: half-widths; `{name}_shift_down`,
        `{name}_shift_up`: one-sided shifts of the ends, infinite where noise hides the surface. NaN where
        nothing is stated and no noise suspected (`suspected_noise`).

    Raises
    ------
    SettingsError
        as of `check_instrument`.
    ConvergenceError
        as of `solve_contact`.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.uncertainty.headline import headline
    >>> window, problem = rough_reference_surface(64), {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> solved = solve_contact(window, **problem, reduce=headline)
    >>> found = instrument_uncertainty(
    ...     window, contact=problem, solved=solved, instrument={"noise": 0.03 * float(window.std())}
    ... )
    >>> found["relative_contact_area_shift_up"].item() > 0 == found["relative_contact_area_shift_down"].item()
    True
    """
    check_instrument(window, instrument)
    stated = {key: value for key, value in instrument.items() if key != "finer_spectrum" and value}
    scales = {key: stated[key] for key in _AMPLIFICATIONS if key in stated}
    parts = [scaling_uncertainty(solved, scales)] if scales else []
    if noise := stated.get("noise"):
        parts.append(_noise_shift(window, contact, solved, noise, s_filter))
    elif suspected := suspected_noise(window.attrs):
        parts.append(_noise_shift(window, contact, solved, suspected, None, margin=0.0))
    if stated.get("numerical_aperture") or stated.get("resolution"):
        changed = restored(window, stated, noise=noise or 0.0)
        parts.append(_shift_to(changed, contact, solved))
    if tip_radius := stated.get("tip_radius"):
        parts.append(_shift_to(eroded(window, tip_radius), contact, solved))
    return added_up(parts, quantities_in(solved), solved)


def check_instrument(window: xr.DataArray, instrument: Mapping[str, Any]) -> None:
    """Refuse statements about an instrument that cannot be true of a map.

    Parameters
    ----------
    window : DataArray (y, x), m
    instrument : mapping
        as of `instrument_uncertainty`.

    Raises
    ------
    SettingsError
        for negative values, a tip larger than the map, a resolution finer than two pixels, noise above the
        rms height of the map.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> check_instrument(rough_reference_surface(64), {"tip_radius": 0.1})
    """
    length = max(n * step for n, step in zip(window.shape, spacing(window), strict=True) if n > 1)
    pixel = max(step for n, step in zip(window.shape, spacing(window), strict=True) if n > 1)
    rms_height = float(window.std())
    for key, value in instrument.items():
        if key != "finer_spectrum" and value is not None and not value >= 0:
            raise SettingsError(f"instrument.{key} = {value:g}: give a number of 0 or more")
    for key, refused, reason in (
        ("tip_radius", lambda v: v > length, f"larger than the map ({length:.3g} m)"),
        ("resolution", lambda v: 0 < v < 2 * pixel, f"finer than two pixels of the map ({2 * pixel:.3g} m)"),
        ("noise", lambda v: v > rms_height, f"larger than the rms height of the map ({rms_height:.3g} m)"),
    ):
        value = instrument.get(key)
        if value is not None and refused(value):
            raise SettingsError(
                f"instrument.{key} = {value:g} m: {reason}; give it in m or with its unit (2 um)",
                keys=[f"instrument.{key}"],
            )


def added_up(parts: list[xr.Dataset], names: tuple[str, ...], solved: xr.Dataset) -> xr.Dataset:
    """Return the sum of uncertainties: half-widths in quadrature, shifts as the product of their factors.

    Parameters
    ----------
    parts : list of Dataset
        along `load`: `{name}_down`, `{name}_up`, `{name}_shift_down`, `{name}_shift_up`, each where it is
        known.
    names : tuple of str
        the quantities.
    solved : Dataset
        the result.

    Returns
    -------
    Dataset
        all four for every name, and `{name}`, the larger side; NaN without parts.

    Examples
    --------
    >>> import xarray as xr
    >>> result = xr.Dataset({"mean_gap": ("load", [2.0])})
    >>> parts = [xr.Dataset({"mean_gap_shift_up": ("load", [1.0])})] * 2
    >>> added_up(parts, ("mean_gap",), result)["mean_gap_shift_up"].item()
    2.5
    """
    found: dict[str, tuple[str, np.ndarray]] = {}
    for name in names:
        value = solved[name].values
        sides = []
        for side, sign in (("down", -1.0), ("up", 1.0)):
            widths = [part[f"{name}_{side}"].values for part in parts if f"{name}_{side}" in part]
            width = np.sqrt(
                sum((np.nan_to_num(w, posinf=np.inf) ** 2 for w in widths), np.zeros(value.shape))
            )
            shift = np.zeros(value.shape)
            for part in parts:
                if f"{name}_shift_{side}" in part:
                    own = np.nan_to_num(part[f"{name}_shift_{side}"].values, posinf=np.inf)
                    relative = np.divide(shift, value, out=np.zeros_like(value), where=value > 0)
                    shift = shift + own * np.maximum(1 + sign * relative, 0.0)
            if not parts:
                width = np.full(value.shape, np.nan)
            found |= {f"{name}_{side}": ("load", width), f"{name}_shift_{side}": ("load", shift)}
            sides.append(width + shift)
        found[name] = ("load", np.maximum(*sides))
    return xr.Dataset(found)


def one_sided(solved: xr.Dataset, changes: Mapping[str, np.ndarray], uncertainty: float) -> xr.Dataset:
    """Return shifts of the ends of an interval towards results that may be the true ones.

    Parameters
    ----------
    solved : Dataset
        the result.
    changes : mapping
        quantity -> change (load) of ln Q, of the area of ln erfinv(A), from the result to the possible truth;
        infinite where that is not known. The pressure in contact follows from the area.
    uncertainty : float
        of a change, relative: it is extended by this share, and its share on the other side is not taken off.

    Returns
    -------
    Dataset
        `{name}_shift_down`, `{name}_shift_up` and `{name}`, the larger one, along `load`, in the unit of the
        quantity.

    Examples
    --------
    >>> import numpy as np, xarray as xr
    >>> solved = xr.Dataset({"mean_gap": ("load", [2.0]), "mean_pressure": ("load", [1.0])})
    >>> found = one_sided(solved, {"mean_gap": np.log([1.5])}, 0.0)
    >>> round(found["mean_gap_shift_up"].item(), 12), found["mean_gap_shift_down"].item()
    (1.0, 0.0)
    """
    extended = {
        name: (1 + uncertainty) * np.nan_to_num(c, nan=0.0, posinf=np.inf, neginf=-np.inf)
        for name, c in changes.items()
    }
    sides = {name: (np.maximum(-c, 0.0), np.maximum(c, 0.0)) for name, c in extended.items()}
    return half_widths(solved, sides, ending="_shift")


def log_change(solved: xr.Dataset, other: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return ln Q of other results less that of the result, of the area ln erfinv(A).

    Parameters
    ----------
    solved : Dataset
        the result along `load`.
    other : mapping
        quantity -> array (load).

    Returns
    -------
    dict
        quantity -> array (load), without the pressure in contact; 0 where the result vanishes.

    Examples
    --------
    >>> import numpy as np, xarray as xr
    >>> solved = xr.Dataset({"mean_gap": ("load", [2.0])})
    >>> log_change(solved, {"mean_gap": np.array([2.0])})
    {'mean_gap': array([0.])}
    """
    changes = {}
    for name, values in other.items():
        if name == PRESSURE or name not in solved:
            continue
        pair = [effort(v) if name == AREA else v for v in (solved[name].values, values)]
        usable = (np.nan_to_num(pair[0]) > 0) & np.isfinite(pair[1])
        own, new = (np.where(usable, v, 1.0) for v in pair)
        with np.errstate(divide="ignore"):
            changes[name] = np.log(new) - np.log(own)
    return changes


def _solve_again(
    window: xr.DataArray, contact: Mapping[str, Any], solved: xr.Dataset
) -> dict[str, np.ndarray]:
    """Return the results of a changed window."""
    return solve_member(window, contact, tolerance=_TOLERANCE, count=counter_of(solved)).values


def _shift_to(changed: xr.DataArray, contact: Mapping[str, Any], solved: xr.Dataset) -> xr.Dataset:
    """Return the one-sided uncertainty towards the results of a corrected window."""
    changes = log_change(solved, _solve_again(changed, contact, solved))
    return one_sided(solved, changes, _RESTORING_UNCERTAINTY)


def _noise_shift(
    window: xr.DataArray,
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    noise: float,
    s_filter: float | None,
    *,
    margin: float = _NOISE_MARGIN,
) -> xr.Dataset:
    """Return the one-sided uncertainty towards the results without noise."""
    noisy, of_noise = with_noise(window, noise, s_filter=s_filter)
    measured, more = rms_gradient(window), rms_gradient(noisy)
    share = min((of_noise / measured) ** 2, 1.0) if measured else 1.0
    changes = log_change(solved, _solve_again(noisy, contact, solved))
    if share >= _MOST_NOISE:
        back = math.inf
    else:  # ln(g/g_true) over ln(g with more noise/g)
        back = -0.5 * math.log1p(-share) / max(math.log(more / measured), 1e-12)
    with np.errstate(invalid="ignore"):
        without = {name: np.where(change == 0, 0.0, -change * back) for name, change in changes.items()}
    return one_sided(solved, without, margin)


def stated_instrument(levelled: xr.DataArray, settings: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return what is known of the instrument: from the settings, the table of surfaces, the file.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        whose attributes `instrument_{name}` hold what the table says of this map, and whose attribute
        `instrument` (JSON) what the file says; of the latter the numerical aperture counts, that of a comment
        (`NA: 0.60`) too.
    settings : mapping or None
        section `instrument`, over which the table prevails; the file comes last.

    Returns
    -------
    dict
        the keys of the section that are known.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64).assign_attrs(instrument_noise=1e-9)
    >>> stated_instrument(height, {"noise": 2e-9, "tip_radius": None})
    {'noise': 1e-09}
    """
    known = dict(settings or {})
    of_file = numerical_aperture(json.loads(levelled.attrs.get("instrument", "{}") or "{}"))
    optics = ("numerical_aperture", "resolution", "tip_radius")
    known |= {
        str(key).removeprefix(_STATED): value
        for key, value in levelled.attrs.items()
        if str(key).startswith(_STATED)
    }
    if of_file and not any(known.get(key) for key in optics):
        known["numerical_aperture"] = of_file
    return {key: value for key, value in known.items() if value is not None}
