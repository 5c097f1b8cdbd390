"""Uncertainty of the instrument: amplification, noise, lens or lateral resolution, tip.

The result is that of the map as measured; the interval reaches to where the truth may be.

* Amplification (calibration of the scales) is propagated with load and modulus (`inputs`).
* Noise adds to the gradient: g^2 = g_true^2 + g_noise^2, so that the area comes out too small and pressure
  and gap too large. The window is solved once more with the same noise added; the exponent d ln Q/d ln g that
  follows from it takes the result back from g to g_true (simulation and extrapolation, Cook and Stefanski
  1994). On 43 measured and made maps with noise of 1 to 10 % of Sq the truth lay at 1.2 times this shift in
  the median, at twice the shift in the outer tenth: half of the shift is added to it, and half is its
  uncertainty. Where no noise is stated and the spectrum is flat at its end, its floor may be noise, or waves
  that the pixels fold back: the shift by such noise is added as a bound.
* A lens, or a stated resolution, attenuates short waves. The window is solved once more with the transfer
  undone (`window.transfer.restored`).
* A tip rounds peaks. The window is solved once more as the eroded map (`window.transfer.eroded`), which
  undoes it where the tip touched.
* Heights that were rounded to a `coarse_step` lie within half of it of the true ones. The window is
  solved once more as the smoothest such map (`window.transfer.unrounded`).

The last four are one-sided: each shifts the end of the interval on its side (JCGM 100:2008, F.2.4.5). A map
that was corrected for noise and lens (`window.transfer.corrected`) has a two-sided part instead: the window
as measured is solved once more, and a share of the change is the uncertainty of the correction.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.roughness.parameters import rms_gradient
from roughcontact.statistics.instrument_checks import coarse_step, suspected_noise
from roughcontact.uncertainty.answers import counter_of, quantities_in
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.scaling import AREA, PEAK, PRESSURE, effort, half_widths
from roughcontact.window.instrument import check_instrument
from roughcontact.window.transfer import restored, undone, unrounded, with_noise

_TOLERANCE = 1e-3  # of the pressure
_NOISE_MARGIN = 1.0  # of the shift by noise: half of it is added, half is its uncertainty
# of what a correction changes, in the logarithm; of the single highest point noise hides more
_CORRECTION_UNCERTAINTY, _PEAK_UNCERTAINTY = 0.5, 1.0
_RESTORING_UNCERTAINTY = 0.25  # of the shift by a lens, a tip, or rounding
_MOST_NOISE = 0.95  # of g^2; a map with more noise says nothing of its surface


def instrument_uncertainty(
    window: xr.DataArray,
    *,
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    instrument: Mapping[str, Any],
    scales: Sequence[xr.Dataset] = (),
    as_measured: xr.DataArray | None = None,
    true_shapes: Mapping[str, xr.DataArray] | None = None,
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
        `tip_radius` (m).
    scales : sequence of Dataset
        half-widths due to each amplification, as of `added_up`.
    as_measured : DataArray (y, x), m, optional
        the window before it was corrected, if it was.
    true_shapes : mapping, optional
        `undone` of the window, if that is known.

    Returns
    -------
    Dataset
        along `load`, `{name}`, `{name}_down`, `{name}_up`: half-widths; `{name}_shift_down`,
        `{name}_shift_up`: one-sided shifts of the ends, infinite where noise hides the surface. NaN where
        nothing is stated, no noise suspected (`suspected_noise`) and the heights have no `coarse_step`. Of a
        corrected map also `{name}_as_measured`, the result without the correction.

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
    check_instrument(window if as_measured is None else as_measured, instrument)
    stated = {key: value for key, value in instrument.items() if key != "finer_spectrum" and value}
    parts = list(scales)
    before: dict[str, np.ndarray] = {}
    if as_measured is not None:
        before = _solve_again(as_measured, contact, solved)
        parts.append(_of_correction(as_measured, contact, solved, before, stated))
    elif noise := stated.get("noise"):
        parts.append(_noise_shift(window, contact, solved, noise))
    if not stated.get("noise") and (suspected := suspected_noise(window.attrs)):
        parts.append(_noise_shift(window, contact, solved, suspected, margin=0.0))
    changed = undone(window, stated) if true_shapes is None else true_shapes
    parts += [_shift_to(each, contact, solved) for each in changed.values()]
    if step := coarse_step(window.attrs):
        parts.append(_rounding_shift(window, contact, solved, step))
    return added_up(parts, quantities_in(solved), solved).assign(
        {f"{name}_as_measured": ("load", values) for name, values in before.items()}
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
    count = counter_of(solved)
    return solve_member(window, contact, tolerance=_TOLERANCE, count=count, result=solved).values


def _shift_to(changed: xr.DataArray, contact: Mapping[str, Any], solved: xr.Dataset) -> xr.Dataset:
    """Return the one-sided uncertainty towards the results of a corrected window."""
    changes = log_change(solved, _solve_again(changed, contact, solved))
    return one_sided(solved, changes, _RESTORING_UNCERTAINTY)


def _rounding_shift(
    window: xr.DataArray, contact: Mapping[str, Any], solved: xr.Dataset, step: float
) -> xr.Dataset:
    """Return the one-sided uncertainty towards the results without rounding to a `step` (m).

    The highest point stays a kink of the smoothest map; its pressure falls at least as the gradient does.
    """
    changes = log_change(solved, _solve_again(unrounded(window, step), contact, solved))
    changes[PEAK] = np.minimum(changes[PEAK], -changes[AREA])
    return one_sided(solved, changes, _RESTORING_UNCERTAINTY)


def _of_correction(
    as_measured: xr.DataArray,
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    before: Mapping[str, np.ndarray],
    stated: Mapping[str, Any],
) -> xr.Dataset:
    """Return the two-sided uncertainty of a correction, from the results before it.

    Noise and transfer may cancel: where both are known, what each changes is told apart by a further solution
    of the window without the noise alone.
    """
    noise = stated.get("noise") or 0.0
    steps = [_finite_change(solved, before)]
    if noise and (stated.get("numerical_aperture") or stated.get("resolution")):
        without_noise = _solve_again(restored(as_measured, {}, noise=noise, equalise=True), contact, solved)
        rest = _finite_change(solved, without_noise)
        steps = [{name: change - rest[name] for name, change in steps[0].items()}, rest]
    _, of_noise = with_noise(as_measured, noise)
    hidden = _share_of_noise(of_noise, rms_gradient(as_measured)) >= _MOST_NOISE
    widths = {}
    for name in steps[0]:
        share = _PEAK_UNCERTAINTY if name == PEAK else _CORRECTION_UNCERTAINTY
        width = share * np.sqrt(sum(step[name] ** 2 for step in steps))
        widths[name] = (np.full_like(width, np.inf) if hidden else width,) * 2
    return half_widths(solved, widths)


def _finite_change(solved: xr.Dataset, other: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return `log_change`; a place that is closed in the other result differs by as much as its height."""
    changes = log_change(solved, other)
    return {name: np.where(np.isneginf(change), -1.0, change) for name, change in changes.items()}


def _share_of_noise(of_noise: float, measured: float) -> float:
    """Return the share of noise in the mean square gradient, from the rms gradients of noise and map."""
    return min((of_noise / measured) ** 2, 1.0) if measured else 1.0


def _noise_shift(
    window: xr.DataArray,
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    noise: float,
    *,
    margin: float = _NOISE_MARGIN,
) -> xr.Dataset:
    """Return the one-sided uncertainty towards the results without noise."""
    noisy, of_noise = with_noise(window, noise)
    measured, more = rms_gradient(window), rms_gradient(noisy)
    share = _share_of_noise(of_noise, measured)
    changes = log_change(solved, _solve_again(noisy, contact, solved))
    if share >= _MOST_NOISE:
        back = math.inf
    else:  # ln(g/g_true) over ln(g with more noise/g)
        back = -0.5 * math.log1p(-share) / max(math.log(more / measured), 1e-12)
    with np.errstate(invalid="ignore"):
        without = {name: np.where(change == 0, 0.0, -change * back) for name, change in changes.items()}
    return one_sided(solved, without, margin)
