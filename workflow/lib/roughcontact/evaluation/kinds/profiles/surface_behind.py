"""The surface behind profiles: an example of the surfaces with their spectrum is solved.

Its ± is the scatter of the results of such surfaces, drawn from pieces of the profiles, with standard
deviation s. Their mean is the result, that of area and gap corrected by a share of the contrast between the
profiles and theirs (`ridge_contrast`). The arms are q sqrt(s^2 + c^2), c the spread beyond s of the errors
e of profiles cut out of maps, and q the 95 % quantile of |e|/sqrt(s^2 + c^2) (split conformal prediction).
The numbers are written by `benchmarks/profiles.py`.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import height_map, spacing
from roughcontact.arguments.quantities import counted_noun
from roughcontact.evaluation.kinds.periodic_map import PeriodicMap, SolvedMap
from roughcontact.evaluation.kinds.profiles.ridge_contrast import ridge_contrast
from roughcontact.surface.preparation.profiles import ProfilesPreparation
from roughcontact.surface.profiles.finish import draw, fit_statistics
from roughcontact.surface.profiles.spectrum import ProfileFit
from roughcontact.surface.profiles.surface import fit_profiles
from roughcontact.surface.window.band import in_band
from roughcontact.uncertainty.calibration import MEASURANDS, entry, look_up, table
from roughcontact.uncertainty.discretisation import CORRECTED
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, to_scale
from roughcontact.uncertainty.subwindows import Scatter

_CALIBRATED = ("spread", "quantile", "share", "contrast")


class SurfaceBehindProfiles(ProfilesPreparation, PeriodicMap):
    """A periodic map drawn from the spectrum of profiles."""

    def scatter(self, solution: SolvedMap) -> Callable[..., Scatter]:
        """Return the scatter of the surfaces that the profiles leave open."""
        return partial(scatter_of_surfaces, solution.levelled)

    def measured_surface(self, solution: SolvedMap) -> xr.DataArray:
        """Return the window itself: the profiles are lines on such a surface."""
        return solution.window


def scatter_of_surfaces(
    profiles: xr.DataArray, result: Result, *_: xr.DataArray, arguments: Mapping[str, Any], number: int
) -> Scatter:
    """Return the scatter of the results of surfaces that profiles (number, x; m) leave open, about the mean.

    `arguments` are those of `periodic_window` that led to the window, `number` is that of the members.
    """
    values, fit = result.values, fit_profiles(profiles)
    draws = [surface.assign_attrs(profiles.attrs) for surface in member_surfaces(fit, result.window, number)]
    ensemble = result.members(in_band(surface, **arguments) for surface in draws)
    contrast = ridge_contrast(fit.pieces, draws, arguments)
    arms, shift = {}, {}
    for name, value in values.items():
        mean, deviation = moments(name, ensemble[name], value, values[GAP])
        calibration = table()["profiles"][entry(name)] | {"contrast": contrast[name]}
        spread, quantile, share, of_ridges = look_up(calibration, values[AREA], _CALIBRATED)
        mean, width = mean + share * of_ridges, quantile * np.hypot(deviation, spread)
        if name in CORRECTED:
            arms[name], shift[name] = (width, width), mean
        else:
            arms[name] = np.maximum(width - mean, 0.0), np.maximum(width + mean, 0.0)
    reason = (
        f"The ± is for surfaces with this spectrum: {number} surfaces that "
        f"{counted_noun(len(profiles), 'profile')} might have shown were drawn and solved. What spectrum, "
        "heights and slopes do not hold is corrected as far as the profiles show it, pressed as ridges; the "
        "rest is that of maps that were cut into profiles."
    )
    return Scatter(ensemble, arms=dict.fromkeys(MEASURANDS, arms), shift=shift, reason=reason)


def member_surfaces(fit: ProfileFit, window: xr.DataArray, number: int) -> Iterator[xr.DataArray]:
    """Yield so many surfaces of the size of a window that profiles leave open."""
    points, step = window.shape[1], spacing(window)[1]
    for index in range(number):
        rng = np.random.default_rng([index + 1, points])
        yield height_map(draw(fit_statistics(fit, rng), points, step / fit.pitch, rng), step, unit="m")


def moments(
    name: str, ensemble: np.ndarray, result: np.ndarray, gap: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and standard deviation of members (member, load) and result, less the result, on the scale.

    Narrowest places are counted in mean gaps.
    """
    unit = np.where(gap > 0, gap, 1.0) if name in CONSTRICTIONS else 1.0
    all_results = np.vstack([result[None], np.where(np.isnan(ensemble), result, ensemble)])
    on_scale = np.nan_to_num(to_scale(name, all_results) - to_scale(name, result), nan=0.0) / unit
    return on_scale.mean(axis=0), on_scale.std(axis=0, ddof=1)
