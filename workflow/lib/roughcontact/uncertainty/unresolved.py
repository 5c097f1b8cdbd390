"""Uncertainty due to the waves that a map does not resolve: at most an octave beyond its shortest wave.

Most surfaces are rough below the pixel of their map. The rms gradient g(lambda) of the waves longer than
lambda grows octave by octave; let d1 and d2 be the growth of ln g over the last and the last but one resolved
octave. The next octave is expected to add

    d = 1.3 d1 min(max(d1/d2, 1), 2),

since pixels average over their own area and so hide a part of the last octave as well. On 27 measured maps
with their pixels merged 2 x 2, d was between 0.6 and 1.9 times the gradient that was lost, 0.95 in the
median. Each result may continue to change as it did over the last resolved octave, d/d1 times; the area by no
less than Persson's law says, erfinv(A) ~ 1/g. The shifts are one-sided and widen the interval; they correct
nothing. Two octaves cannot be extrapolated: errors then double.

Where an instrument resolves less than its pixels (a lens, a tip), the trend is taken over the octaves that it
does resolve, and continued to the pixels, at least one octave and at most two. Where it hides more than two,
nothing bounds the area below and the pressures above.

The spectrum of a finer map of the same finish replaces the trend. A profile shows one line in one direction:
what it adds is increased by the scatter between its parts, and where the shortest waves of the map differ in
strength from axis to axis, the trend counts if it is larger.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import scipy
import xarray as xr

from roughcontact.io.read import read_height_map
from roughcontact.levelling.level import level
from roughcontact.maps import spacing
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.uncertainty.answers import quantities_in
from roughcontact.uncertainty.instrument import one_sided
from roughcontact.uncertainty.scaling import AREA, PEAK, PRESSURE, effort
from roughcontact.window.transfer import reliability_length, shortest_transmitted, undone

_CHOSEN_BAND = 2.0  # shortest wave that is kept, over two pixels, from which on it defines the result
_MARGIN = 1.3  # on the growth of the gradient over the next octave
_LARGEST_ACCELERATION = 2.0  # of that growth, from octave to octave
_MAX_OCTAVES = 2.0
_CONVERGED = 0.1  # growth of ln g below which the largest pressure has an upper end
_FINER_UNCERTAINTY = 0.15  # of the growth that a finer spectrum shows
_SMALLEST_GROWTH = 1e-3  # of ln g in an octave, to divide by
_PARTS_OF_PROFILE = 8  # whose scatter tells how well a line stands for the surface
_ISOTROPIC = 0.2  # largest logarithm of the ratio of the axes' mean square slopes


class Growth(NamedTuple):
    """Growth of the gradient by the waves that are not resolved.

    Attributes
    ----------
    gradient : float
        expected growth of ln g.
    octaves : float
        over that of the last resolved octave.
    level : int
        entry of the magnification curve at which the last resolved octave ends.
    bounded : bool
        whether few enough octaves are hidden for the growth to be extrapolated.
    """

    gradient: float
    octaves: float
    level: int
    bounded: bool = True


def expected_growth(curve: xr.Dataset, *, resolved: float = 0.0, reference: float | None = None) -> Growth:
    """Return the expected growth of the rms gradient by the waves that a map does not resolve.

    Parameters
    ----------
    curve : Dataset
        from `magnification_curve`.
    resolved : float, m
        shortest wavelength that the instrument resolves, if that is longer than two pixels.
    reference : float, optional
        rms gradient that the growth is counted from; that of the map where it is not given.

    Returns
    -------
    Growth

    Examples
    --------
    >>> import numpy as np
    >>> gradients = {"gradient_at_cutoff": ("cutoff", np.exp([0.0, -0.1, -0.2]))}
    >>> curve = xr.Dataset(coords={"cutoff_wavelength": ("cutoff", [2.0, 4.0, 8.0]), **gradients})
    >>> f"{expected_growth(curve).gradient:.3f}"
    '0.130'
    """
    wavelengths, gradients = curve["cutoff_wavelength"].values, curve["gradient_at_cutoff"].values
    if len(wavelengths) < 2 or not gradients.min() > 0:
        return Growth(0.0, 0.0, 0)
    # an octave below the next entry: of the waves of the window those in the corners of the grid are shorter
    hidden = math.log2(max(2 * resolved / wavelengths[1], 1.0))
    level = min(math.ceil(hidden - 0.25), len(wavelengths) - 2)
    logarithms = np.log(gradients[level:])
    last = max(logarithms[0] - logarithms[1], _SMALLEST_GROWTH)
    before = max(logarithms[1] - logarithms[2], _SMALLEST_GROWTH) if len(logarithms) > 2 else last
    acceleration = float(np.clip(last / before, 1.0, _LARGEST_ACCELERATION))
    octaves = float(np.clip(hidden, 1.0, _MAX_OCTAVES)) * _MARGIN * acceleration
    start = math.log((reference or gradients[0]) / gradients[level])
    growth = max(last * octaves - max(start, 0.0), 0.0)
    return Growth(growth, octaves, level, bounded=hidden < _MAX_OCTAVES + 0.5)


def growth_by_finer_spectrum(window: xr.DataArray, finer: xr.DataArray) -> float:
    """Return the growth of ln g by the waves that a finer map or profile of the same finish shows.

    Slopes along the lines of both are compared: up to the wavenumber q0 those of the window count, beyond it
    those of the finer one. q0 is a quarter of the highest wavenumber of the window, where its pixels do not
    yet attenuate, or the fourth wave of the finer line if that is shorter.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    finer : DataArray (y, x), m
        a map or a profile (a single row or column), levelled; its lines are tapered by a Hann window.

    Returns
    -------
    float
        0 where the finer spectrum adds nothing; for a profile the upper limit (95 %), by the scatter between
        its parts.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.uncertainty.magnification import without_shortest_waves
    >>> finer = rough_reference_surface(128)
    >>> coarse = without_shortest_waves(finer, 1 / 16)
    >>> 0.0 < growth_by_finer_spectrum(coarse, finer) < 1.0
    True
    """
    own = _line_spectra(window, periodic=True)
    fine = _line_spectra(finer, periodic=False)
    limit = max([min(q[-1] for q, _ in own) / 4, *(4 * q[1] for q, _ in fine)])
    kept = sum(float(np.sum(c[q <= limit])) for q, c in own) / len(own)
    whole = sum(float(np.sum(c)) for _, c in own) / len(own)
    added = sum(float(np.sum(c[q > limit])) for q, c in fine) / len(fine)
    if not whole > 0:
        return 0.0
    if min(finer.shape) == 1:
        added *= 1 + _relative_scatter(finer, limit)
    return max(0.5 * math.log((kept + added) / whole), 0.0)


def _relative_scatter(profile: xr.DataArray, limit: float) -> float:
    """Return the relative expanded uncertainty of a profile's mean square slope of waves beyond `limit`."""
    step = max(spacing(profile))
    slopes = np.fft.rfft(np.diff(profile.values.ravel()) / step)
    slopes[2 * np.pi * np.fft.rfftfreq(profile.size - 1, step) <= limit] = 0
    square = np.fft.irfft(slopes, profile.size - 1) ** 2
    if square.size < 2 * _PARTS_OF_PROFILE or not square.any():
        return 1.0
    parts = [part.mean() for part in np.array_split(square, _PARTS_OF_PROFILE)]
    student = float(scipy.special.stdtrit(len(parts) - 1, 0.975))
    return student * float(np.std(parts, ddof=1) / np.mean(parts)) / math.sqrt(len(parts))


def _is_isotropic(window: xr.DataArray) -> bool:
    """Return whether the slopes of the shortest waves, of two octaves, are as large along both axes."""
    own = [float(np.sum(c[q > q[-1] / 4])) for q, c in _line_spectra(window, periodic=True)]
    return min(own) > 0 and math.log(max(own) / min(own)) <= _ISOTROPIC


def unresolved_uncertainty(
    curve: xr.Dataset, solved: xr.Dataset, growth: Growth, *, known: bool = False
) -> xr.Dataset:
    """Return one-sided uncertainties due to waves that are not resolved.

    Parameters
    ----------
    curve : Dataset
        from `magnification_curve`.
    solved : Dataset
        the result: quantities along `load`.
    growth : Growth
        from `expected_growth`, or with the gradient from `growth_by_finer_spectrum`.
    known : bool
        whether the growth was measured on a finer spectrum.

    Returns
    -------
    Dataset
        along `load` as of `one_sided`. Unless the growth is known, the largest pressure has no upper end
        (infinite) where the gradient has not converged, and the area no lower one where the growth is not
        bounded.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.uncertainty.headline import QUANTITIES
    >>> solved = xr.Dataset({name: ("load", [0.1]) for name in (*QUANTITIES, "mean_pressure")})
    >>> levels = {f"{name}_at_cutoff": (("load", "cutoff"), [[0.1, 0.12]]) for name in QUANTITIES}
    >>> found = unresolved_uncertainty(xr.Dataset(levels), solved, Growth(0.5, 1.3, 0))
    >>> found["max_pressure_shift_up"].item(), found["relative_contact_area_shift_down"].item() > 0.03
    (inf, True)
    """
    changes = {}
    for variable in curve.data_vars:
        name = str(variable).removesuffix("_at_cutoff")
        if name == PRESSURE or name not in solved:
            continue
        levels = curve[variable].values
        if levels.shape[1] < 2:
            changes[name] = np.zeros(levels.shape[0])
            continue
        fine, coarse = (
            np.nan_to_num(effort(v) if name == AREA else v)
            for v in levels[:, growth.level : growth.level + 2].T
        )
        usable = (fine > 0) & (coarse > 0)
        change = np.log(np.where(usable, fine, 1.0)) - np.log(np.where(usable, coarse, 1.0))
        changes[name] = growth.octaves * change
        if name == AREA:
            changes[name] = np.minimum(changes[name], -growth.gradient)
            if not growth.bounded and not known:
                changes[name] = np.full_like(change, -np.inf)
        elif name == PEAK:
            changes[name] = np.maximum(changes[name], growth.gradient)
            if (growth.gradient > _CONVERGED or not growth.bounded) and not known:
                changes[name] = np.full_like(change, np.inf)
    return one_sided(solved, changes, _FINER_UNCERTAINTY if known else 0.0)


def _line_spectra(height: xr.DataArray, *, periodic: bool) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return for each axis with lines the wavenumbers and their contributions to the mean square slope."""
    found = []
    for axis, step in enumerate(spacing(height)):
        points = height.shape[axis]
        if points < 8:
            continue
        lines = np.moveaxis(height.values, axis, -1).reshape(-1, points)
        lines = lines - lines.mean(axis=1, keepdims=True)
        if not periodic:
            taper = np.hanning(points)
            lines = lines * taper / math.sqrt(np.mean(taper**2))
        power = np.mean(np.abs(np.fft.rfft(lines, axis=1)) ** 2, axis=0) / points**2
        power[1 : (points + 1) // 2] *= 2
        q = 2 * np.pi * np.fft.rfftfreq(points, step)
        found.append((q, power * q**2))
    return found


def waves_not_resolved(
    window: xr.DataArray,
    curve: xr.Dataset,
    solved: xr.Dataset,
    settings: Mapping[str, Mapping[str, Any]],
    instrument: Mapping[str, Any],
    true_shapes: Mapping[str, xr.DataArray] | None = None,
) -> xr.Dataset:
    """Return the uncertainty due to waves that a map does not resolve, by its trend or a finer spectrum.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    curve : Dataset
        from `magnification_curve`.
    solved : Dataset
        the result: quantities along `load`.
    settings : mapping
        sections `level` and `window`. Where they leave out the waves below four pixels (S-filter, band),
        these define what is measured, and nothing is added for shorter ones.
    instrument : mapping
        what is known of it; `finer_spectrum` is a path or a map (y, x; m).
    true_shapes : mapping, optional
        `undone` of the window, if that is known.

    Returns
    -------
    Dataset
        as of `unresolved_uncertainty`.
    """
    shortest = 2 * max(spacing(window))
    band = [settings.get("level", {}).get("s_filter"), settings.get("window", {}).get("shortest_wavelength")]
    if max(each or 0.0 for each in band) >= _CHOSEN_BAND * shortest:
        return xr.Dataset(dict.fromkeys(quantities_in(solved), ("load", np.zeros(solved.sizes["load"]))))
    true_shapes = undone(window, instrument) if true_shapes is None else true_shapes
    resolved = shortest_transmitted(instrument)
    reference = true_shapes.get("lens") if resolved > shortest else None
    if tip_radius := instrument.get("tip_radius"):
        resolved = max(resolved, reliability_length(window, tip_radius))
        reference = true_shapes["tip"]
    growth = expected_growth(
        curve, resolved=resolved, reference=None if reference is None else rms_gradient(reference)
    )
    finer = instrument.get("finer_spectrum")
    if finer is None:
        return unresolved_uncertainty(curve, solved, growth)
    if not isinstance(finer, xr.DataArray):
        finer = read_height_map(finer)
    known = growth_by_finer_spectrum(window, level(finer, form="plane"))
    if min(finer.shape) == 1 and not _is_isotropic(window):
        known = max(known, growth.gradient)
    last = growth.gradient / growth.octaves if growth.octaves else 0.0
    octaves = min(known / last, 4.0) if last > 0 else 0.0
    return unresolved_uncertainty(curve, solved, Growth(known, octaves, growth.level), known=True)
