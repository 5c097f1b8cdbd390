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
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.roughness.parameters import rms_gradient
from roughcontact.statistics.instrument_checks import coarse_step, suspected_noise
from roughcontact.uncertainty.combination import Component, Components, component
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.loads import carried_to_all_loads, few_loads
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, PEAK, to_scale
from roughcontact.window.instrument import check_instrument
from roughcontact.window.transfer import restored, unrounded, with_noise

_TOLERANCE = 1e-3  # of the pressure
_LOADS = 6  # at which a changed window is solved
_NOISE_MARGIN = 1.0  # of the shift by noise: half of it is added, half is its uncertainty
# of what a correction changes, in the logarithm; of the single highest point noise hides more
_CORRECTION_UNCERTAINTY, _PEAK_UNCERTAINTY = 0.5, 1.0
_RESTORING_UNCERTAINTY = 0.25  # of the shift by a lens, a tip, or rounding
_MOST_NOISE = 0.95  # of g^2; a map with more noise says nothing of its surface

Values = Mapping[str, np.ndarray]  # quantity -> array (load)


def instrument_components(
    window: xr.DataArray,
    *,
    contact: Mapping[str, Any],
    values: Values,
    instrument: Mapping[str, Any],
    as_measured: xr.DataArray | None = None,
    true_shapes: Mapping[str, xr.DataArray],
) -> tuple[list[Components], dict[str, np.ndarray]]:
    """Return what is known of the instrument contributes to the interval of each result, on its scale.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    contact : dict
        keyword arguments of `solve_contact`.
    values : mapping
        quantity -> array (load), the result.
    instrument : mapping
        what is stated of `noise` (m, rms), `resolution` (m), `numerical_aperture`, `wavelength` (m),
        `tip_radius` (m).
    as_measured : DataArray (y, x), m, optional
        the window before it was corrected, if it was.
    true_shapes : mapping
        `undone` of the window.

    Returns
    -------
    components : list
        one for each cause; none where nothing is stated, no noise suspected (`suspected_noise`) and the
        heights have no `coarse_step`.
    as_measured : dict
        of a corrected map the results without the correction.

    Raises
    ------
    SettingsError
        as of `check_instrument`.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> window, problem = rough_reference_surface(64), {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> values = solve_member(window, problem, tolerance=1e-3, names=["relative_contact_area"])
    >>> noise = {"noise": 0.03 * float(window.std())}
    >>> (found,), _ = instrument_components(
    ...     window, contact=problem, values=values, instrument=noise, true_shapes={}
    ... )
    >>> area = found["relative_contact_area"]
    >>> area.shift_up.item() > 0 == area.shift_down.item()
    True
    """
    check_instrument(window if as_measured is None else as_measured, instrument)
    stated = {key: value for key, value in instrument.items() if key != "finer_spectrum" and value}
    found: list[Components] = []
    before: dict[str, np.ndarray] = {}
    if as_measured is not None:
        before = _solve_again(as_measured, contact, values)
        found.append(_of_correction(as_measured, contact, values, before, stated))
    elif noise := stated.get("noise"):
        found.append(_noise_shift(window, contact, values, noise))
    if not stated.get("noise") and (suspected := suspected_noise(window.attrs)):
        found.append(_noise_shift(window, contact, values, suspected, margin=0.0))
    for changed in true_shapes.values():
        changes = _log_change(values, _solve_again(changed, contact, values))
        found.append(one_sided(values, changes, _RESTORING_UNCERTAINTY))
    if step := coarse_step(window.attrs):
        found.append(_rounding_shift(window, contact, values, step))
    return found, before


def added_up(parts: Iterable[Components]) -> dict[str, Component]:
    """Return the sum of independent causes: half-widths in quadrature, shifts added, on the scale.

    Examples
    --------
    >>> one = {"mean_gap": component(np.array([3.0]), np.array([0.0]))}
    >>> other = {"mean_gap": component(np.array([4.0]), np.array([0.0]))}
    >>> added_up([one, other])["mean_gap"].down.item()
    5.0
    """
    found: dict[str, Component] = {}
    for part in parts:
        for name, own in part.items():
            total = found.get(name)
            if total is None:
                found[name] = own
                continue
            found[name] = Component(
                np.hypot(total.down, own.down),
                np.hypot(total.up, own.up),
                total.shift_down + own.shift_down,
                total.shift_up + own.shift_up,
            )
    return found


def one_sided(values: Values, changes: Values, uncertainty: float) -> dict[str, Component]:
    """Return shifts of the ends of an interval towards results that may be the true ones.

    Parameters
    ----------
    values : mapping
        quantity -> array (load), the result.
    changes : mapping
        quantity -> change (load) of ln Q, of the area of ln erfinv(A), from the result to the possible truth;
        infinite where that is not known.
    uncertainty : float
        of a change, relative: it is extended by this share, and its share on the other side is not taken off.

    Examples
    --------
    >>> gap = {"mean_gap": np.array([2.0])}
    >>> found = one_sided(gap, {"mean_gap": np.log([1.5])}, 0.0)["mean_gap"]
    >>> found.shift_up.round(3).item(), found.shift_down.item()
    (0.405, 0.0)
    """
    found = {}
    for name, change in changes.items():
        extended = (1 + uncertainty) * np.nan_to_num(change, nan=0.0, posinf=np.inf, neginf=-np.inf)
        moved = _from_logarithm(name, values[name], extended)
        nothing = np.zeros_like(moved)
        found[name] = Component(nothing, nothing, np.maximum(-moved, 0.0), np.maximum(moved, 0.0))
    return found


def _from_logarithm(name: str, value: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Return a change of a logarithm on the scale of a quantity: narrowest places have none."""
    if name not in CONSTRICTIONS:
        return change
    with np.errstate(over="ignore", invalid="ignore"):
        return np.where(value > 0, value * np.expm1(change), 0.0)


def _log_change(values: Values, other: Values) -> dict[str, np.ndarray]:
    """Return ln Q of other results less that of the result, of the area ln erfinv(A); 0 where it vanishes."""
    changes = {}
    for name, result in values.items():
        own, new = (
            to_scale(name, v) if name not in CONSTRICTIONS else _logarithm(v) for v in (result, other[name])
        )
        usable = np.isfinite(own) & (np.isfinite(new) | (other[name] == 0))
        changes[name] = np.where(
            usable, np.where(np.isnan(new), -np.inf, new) - np.where(usable, own, 0.0), 0.0
        )
    return changes


def _logarithm(values: np.ndarray) -> np.ndarray:
    """Return the logarithm of positive values, NaN for others."""
    return np.log(np.where(values > 0, values, np.nan))


def _solve_again(window: xr.DataArray, contact: Mapping[str, Any], values: Values) -> dict[str, np.ndarray]:
    """Return the results of a changed window at all loads."""
    load = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    solved = few_loads(load, _LOADS)
    member = solve_member(window, contact, tolerance=_TOLERANCE, names=list(values), loads=solved)
    return {name: carried_to_all_loads(name, member[name], solved, load, values[name]) for name in values}


def _rounding_shift(
    window: xr.DataArray, contact: Mapping[str, Any], values: Values, step: float
) -> dict[str, Component]:
    """Return the one-sided uncertainty towards the results without rounding to a `step` (m).

    The highest point stays a kink of the smoothest map; its pressure falls at least as the gradient does.
    """
    changes = _log_change(values, _solve_again(unrounded(window, step), contact, values))
    changes[PEAK] = np.minimum(changes[PEAK], -changes[AREA])
    return one_sided(values, changes, _RESTORING_UNCERTAINTY)


def _of_correction(
    as_measured: xr.DataArray,
    contact: Mapping[str, Any],
    values: Values,
    before: Values,
    stated: Mapping[str, Any],
) -> dict[str, Component]:
    """Return the two-sided uncertainty of a correction, from the results before it.

    Noise and transfer may cancel: where both are known, what each changes is told apart by a further solution
    of the window without the noise alone.
    """
    noise = stated.get("noise") or 0.0
    steps = [_finite_change(values, before)]
    if noise and (stated.get("numerical_aperture") or stated.get("resolution")):
        without_noise = _solve_again(restored(as_measured, {}, noise=noise, equalise=True), contact, values)
        of_lens = _finite_change(values, without_noise)
        steps = [{name: change - of_lens[name] for name, change in steps[0].items()}, of_lens]
    _, of_noise = with_noise(as_measured, noise)
    hidden = _share_of_noise(of_noise, rms_gradient(as_measured)) >= _MOST_NOISE
    found = {}
    for name in steps[0]:
        share = _PEAK_UNCERTAINTY if name == PEAK else _CORRECTION_UNCERTAINTY
        width = share * np.sqrt(sum(step[name] ** 2 for step in steps))
        width = np.full_like(width, np.inf) if hidden else width
        found[name] = component(
            np.abs(_from_logarithm(name, values[name], -width)), _from_logarithm(name, values[name], width)
        )
    return found


def _finite_change(values: Values, other: Values) -> dict[str, np.ndarray]:
    """Return `_log_change`; a place that is closed in the other result differs by as much as its height."""
    changes = _log_change(values, other)
    return {name: np.where(np.isneginf(change), -1.0, change) for name, change in changes.items()}


def _share_of_noise(of_noise: float, measured: float) -> float:
    """Return the share of noise in the mean square gradient, from the rms gradients of noise and map."""
    return min((of_noise / measured) ** 2, 1.0) if measured else 1.0


def _noise_shift(
    window: xr.DataArray,
    contact: Mapping[str, Any],
    values: Values,
    noise: float,
    *,
    margin: float = _NOISE_MARGIN,
) -> dict[str, Component]:
    """Return the one-sided uncertainty towards the results without noise."""
    noisy, of_noise = with_noise(window, noise)
    measured, more = rms_gradient(window), rms_gradient(noisy)
    share = _share_of_noise(of_noise, measured)
    changes = _log_change(values, _solve_again(noisy, contact, values))
    if share >= _MOST_NOISE:
        back = math.inf
    else:  # ln(g/g_true) over ln(g with more noise/g)
        back = -0.5 * math.log1p(-share) / max(math.log(more / measured), 1e-12)
    with np.errstate(invalid="ignore"):
        without = {name: np.where(change == 0, 0.0, -change * back) for name, change in changes.items()}
    return one_sided(values, without, margin)
