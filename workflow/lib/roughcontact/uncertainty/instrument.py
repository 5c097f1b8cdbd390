"""Uncertainty of the instrument: noise, lens or lateral resolution, tip, rounding (amplification: `inputs`).

* Noise adds to the gradient: g^2 = g_true^2 + g_noise^2. The window is solved with the same noise added; the
  exponent d ln Q/d ln g leads back to g_true (simulation and extrapolation, Cook and Stefanski 1994). On 43
  maps with noise of 1 to 10 % of Sq the truth lay at 1.2 times this shift in the median, at twice in the
  outer tenth: it is doubled. A spectrum that is flat at its end may be noise, or folded waves: the shift is
  added as a bound. What stated noise does by chance, to both sides, is told by four draws of it.
* A lens, a tip and rounding to a `coarse_step` are undone (`window.transfer`: `restored`, `eroded`,
  `unrounded`), and the window is solved once more.

Each shifts one end of the interval (JCGM 100:2008, F.2.4.5). A map corrected for noise and lens has a
two-sided component, a share of the change by the correction (3.2.4).
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.choices import UncertaintySource
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.statistics.instrument_checks import coarse_step, suspected_noise
from roughcontact.uncertainty.combination import Components, one_sided, symmetric
from roughcontact.uncertainty.ensemble import MARGIN, Result, Values
from roughcontact.uncertainty.random_effects import width_of_next
from roughcontact.uncertainty.scales import AREA, PEAK, PRESSURE
from roughcontact.window.instrument import check_instrument
from roughcontact.window.transfer import restored, unrounded, with_noise

_NOISE_MARGIN = 1.0  # of the shift by noise
_DRAWS = 4  # of noise, whose scatter is what noise does by chance
_MOST_NOISE = 0.95  # of g^2; a map with more noise says nothing of its surface
_CORRECTION_UNCERTAINTY = 0.5  # of what a correction changes; of the single highest point all of it


def with_source_of_correction(
    sources: Sequence[UncertaintySource], window: xr.DataArray
) -> list[UncertaintySource]:
    """Return the sources of the ±, if any; that of a correction of the window counts, asked for or not."""
    added = sources and "corrected_for" in window.attrs and "instrument" not in sources
    return [*sources, "instrument"] if added else list(sources)


def instrument_components(
    result: Result,
    instrument: Mapping[str, Any],
    as_measured: xr.DataArray | None,
    true_shapes: Mapping[str, xr.DataArray],
) -> tuple[list[Components], dict[str, np.ndarray]]:
    """Return the components of each cause, on the scales, and of a corrected map the results without it.

    `as_measured` is the window before a correction, `true_shapes` its `undone`. None is there where nothing
    is stated, no noise suspected (`suspected_noise`) and no `coarse_step`.
    """
    window, noise = result.window, instrument.get("noise") or 0.0
    check_instrument(window if as_measured is None else as_measured, instrument)
    causes: list[Components] = []
    uncorrected: dict[str, np.ndarray] = {}
    if as_measured is not None:
        uncorrected = result.again(as_measured)
        causes.append(_of_correction(result, as_measured, uncorrected, instrument))
        uncorrected[PRESSURE] = result.load / uncorrected[AREA]
    elif noise:
        causes.append(_noise_shift(result, noise, margin=_NOISE_MARGIN))
    if noise:
        causes.append(_chance_of_noise(result, noise))
    elif suspected := suspected_noise(window.attrs):
        causes.append(_noise_shift(result, suspected, margin=0.0))
    shifts = [result.changes(result.again(shape)) for shape in true_shapes.values()]
    if step := coarse_step(window.attrs):
        changes = result.changes(result.again(unrounded(window, step)))
        # the highest point stays a kink of the smoothest map: its pressure falls at least as the gradient
        changes[PEAK] = np.minimum(changes[PEAK], -changes[AREA])
        shifts.append(changes)
    causes += [{name: one_sided((1 + MARGIN) * change) for name, change in shift.items()} for shift in shifts]
    return causes, uncorrected


def _of_correction(
    result: Result, as_measured: xr.DataArray, uncorrected: Values, instrument: Mapping[str, Any]
) -> Components:
    """Return the two-sided uncertainty of a correction, from the results before it."""
    noise = instrument.get("noise") or 0.0
    causes = [result.changes(uncorrected)]
    # both may cancel: a further solution without the noise alone tells them apart
    if noise and (instrument.get("numerical_aperture") or instrument.get("resolution")):
        without_noise = restored(as_measured, {}, noise=noise, equalise=True)
        by_lens = result.changes(result.again(without_noise))
        causes = [{name: change - by_lens[name] for name, change in causes[0].items()}, by_lens]
    hidden = _share_of_noise(as_measured, with_noise(as_measured, noise)[1]) >= _MOST_NOISE
    components = {}
    for name in result.values:
        share = _CORRECTION_UNCERTAINTY * (2 if name == PEAK else 1)
        changes = np.stack([cause[name] for cause in causes])
        changes = np.where(np.isneginf(changes), -1.0, changes)  # a gap that closes: as much as its height
        width = share * np.sqrt(np.sum(changes**2, axis=0))
        components[name] = symmetric(np.full_like(width, np.inf) if hidden else width)
    return components


def _share_of_noise(window: xr.DataArray, noise_gradient: float) -> float:
    """Return the share of noise in the mean square gradient of a map."""
    gradient = rms_gradient(window)
    return min((noise_gradient / gradient) ** 2, 1.0) if gradient else 1.0


def _noise_shift(result: Result, noise: float, *, margin: float) -> Components:
    """Return the one-sided uncertainty towards the results without noise (m, rms), extended by a margin."""
    noisy, noise_gradient = with_noise(result.window, noise)
    share, exponent_back = _share_of_noise(result.window, noise_gradient), math.inf
    if share < _MOST_NOISE:  # ln(g/g_true) over ln(g with more noise/g)
        growth = math.log(rms_gradient(noisy) / rms_gradient(result.window))
        exponent_back = -0.5 * math.log1p(-share) / max(growth, 1e-12)
    components = {}
    for name, change in result.changes(result.again(noisy)).items():
        with np.errstate(invalid="ignore"):
            shift = np.where(change == 0, 0.0, -(1 + margin) * exponent_back * change)
        components[name] = one_sided(shift)
    return components


def _chance_of_noise(result: Result, noise: float) -> Components:
    """Return what the noise (m, rms) of the map may do by chance: by Student's t, of other draws of it."""
    noisy = [with_noise(result.window, noise, seed=seed)[0] for seed in range(1, _DRAWS + 1)]
    draws = [result.changes(result.again(window)) for window in noisy]
    widths = {name: width_of_next(np.stack([draw[name] for draw in draws])) for name in result.values}
    return {name: symmetric(width) for name, width in widths.items()}
