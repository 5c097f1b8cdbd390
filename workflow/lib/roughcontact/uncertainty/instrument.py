"""Uncertainty of the instrument: noise, lens or lateral resolution, tip, rounding (amplification: `inputs`).

* Noise adds to the gradient: g^2 = g_true^2 + g_noise^2. The window is solved plus and minus such noise,
  filtered as the map was; the exponent d ln Q/d ln g leads back to g_true (simulation and extrapolation, Cook
  and Stefanski 1994). On 43 maps with noise of 1 to 10 % of Sq the truth lay at 1.2 times this shift in the
  median, at twice in the outer tenth: it is doubled. A spectrum that is flat at its end may be noise, or
  folded waves: the shift is added as a bound. What stated noise does by chance is told by four draws of it.
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

from roughcontact.arguments.choices import UncertaintySource
from roughcontact.statistics.instrument_checks import coarse_step, suspected_noise
from roughcontact.surface.window.instrument import check_instrument
from roughcontact.surface.window.transfer import add_noise, restored, share_of_noise, unrounded
from roughcontact.uncertainty.combination import Components, one_sided, symmetric
from roughcontact.uncertainty.ensemble import MARGIN, Result, Values
from roughcontact.uncertainty.random_effects import width_of_next
from roughcontact.uncertainty.scales import AREA, PEAK, PRESSURE

_NOISE_MARGIN = 1.0  # of the shift by noise
_DRAWS = 4  # of noise, whose scatter is what noise does by chance
_MIN_NOISE, _MAX_NOISE = 1e-9, 0.95  # of g^2; a map with more noise says nothing of its surface
_CORRECTION_UNCERTAINTY = 0.5  # of what a correction changes; of the single highest point all of it


def add_correction_source(
    sources: Sequence[UncertaintySource], window: xr.DataArray
) -> list[UncertaintySource]:
    """Return the sources of the ±, if any; that of a correction of the window counts, asked for or not."""
    includes_correction = sources and "corrected_for" in window.attrs and "instrument" not in sources
    return [*sources, "instrument"] if includes_correction else list(sources)


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
    as_measured_values: dict[str, np.ndarray] = {}
    if as_measured is not None:
        as_measured_values = result.again(as_measured)
        causes.append(_correction_component(result, as_measured, as_measured_values, instrument))
        as_measured_values[PRESSURE] = result.load / as_measured_values[AREA]
    elif noise:
        causes.append(_noise_shift(result, noise, margin=_NOISE_MARGIN))
    if noise:
        causes.append(_chance_of_noise(result, noise))
    elif noise_estimate := suspected_noise(window.attrs):
        causes.append(_noise_shift(result, noise_estimate, margin=0.0))
    shifts = [result.changes(result.again(shape)) for shape in true_shapes.values()]
    if step := coarse_step(window.attrs):
        changes = result.changes(result.again(unrounded(window, step)))
        # the highest point stays a kink of the smoothest map: its pressure falls at least as the gradient
        changes[PEAK] = np.minimum(changes[PEAK], -changes[AREA])
        shifts.append(changes)
    causes += [{name: one_sided((1 + MARGIN) * change) for name, change in shift.items()} for shift in shifts]
    return causes, as_measured_values


def _correction_component(
    result: Result, as_measured: xr.DataArray, as_measured_values: Values, instrument: Mapping[str, Any]
) -> Components:
    """Return the two-sided uncertainty of a correction, from the results before it."""
    noise = instrument.get("noise") or 0.0
    causes = [result.changes(as_measured_values)]
    # both may cancel: a further solution without the noise alone tells them apart
    if noise and (instrument.get("numerical_aperture") or instrument.get("resolution")):
        without_noise = restored(as_measured, {}, noise=noise, equalise=True)
        by_lens = result.changes(result.again(without_noise))
        causes = [{name: change - by_lens[name] for name, change in causes[0].items()}, by_lens]
    hidden = share_of_noise(as_measured, noise) >= _MAX_NOISE
    components = {}
    for name in result.values:
        share = _CORRECTION_UNCERTAINTY * (2 if name == PEAK else 1)
        changes = np.stack([cause[name] for cause in causes])
        changes = np.where(np.isneginf(changes), -1.0, changes)  # a gap that closes: as much as its height
        width = share * np.sqrt(np.sum(changes**2, axis=0))
        components[name] = symmetric(np.full_like(width, np.inf) if hidden else width)
    return components


def _noise_shift(result: Result, noise: float, *, margin: float) -> Components:
    """Return the one-sided uncertainty towards the results without noise (m, rms), extended by a margin."""
    share, exponent_back = max(share_of_noise(result.window, noise), _MIN_NOISE), math.inf
    if share < _MAX_NOISE:  # ln(g/g_true) over ln(g with more noise/g), both as expected
        exponent_back = -math.log1p(-share) / math.log1p(share)
    # waves of the map and of one draw may be in phase, which is most of the change by little noise: with the
    # opposite draw that cancels
    draws = [result.changes(result.again(add_noise(result.window, sign * noise))) for sign in (1, -1)]
    changes = {name: np.mean([draw[name] for draw in draws], axis=0) for name in result.values}
    factor = -(1 + margin) * exponent_back
    with np.errstate(invalid="ignore"):
        shifts = {name: np.where(change == 0, 0.0, factor * change) for name, change in changes.items()}
    return {name: one_sided(shift) for name, shift in shifts.items()}


def _chance_of_noise(result: Result, noise: float) -> Components:
    """Return what the noise (m, rms) of the map may do by chance: by Student's t, of other draws of it."""
    noisy = [add_noise(result.window, noise, seed=seed) for seed in range(1, _DRAWS + 1)]
    draws = [result.changes(result.again(window)) for window in noisy]
    return {name: symmetric(width_of_next(np.array([d[name] for d in draws]))) for name in result.values}
