"""Surfaces drawn from profiles, as maps with what the profiles tell, and of what they warn."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_labelled, check_positive
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.arguments.measurement import json_attributes
from roughcontact.arguments.profiles.lays import BOTH, ISOTROPIC, MAX_POINTS, check_lay, lay_facts
from roughcontact.arguments.profiles.lines import check_lines, have_lines
from roughcontact.arguments.quantities import number, percent, quantity
from roughcontact.arguments.si import as_si, labelled_in_si
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.kernels.fourier import sums_of_products
from roughcontact.surface.levelling.forms import form_order
from roughcontact.surface.levelling.level import level
from roughcontact.surface.profiles.finish import Finish, correlation_length, draw, fit_statistics
from roughcontact.surface.profiles.spectrum import ProfileFit
from roughcontact.surface.window.sides import friendly_sides

Profiles = xr.DataArray | Sequence[xr.DataArray]
_LAY_BY_DIRECTIONS = {1: ISOTROPIC, 2: BOTH}
_MAX_PIECE_POINTS = 8192  # points of a profile: longer ones are cut
_MIN_POINTS = 64
_LENGTHS = 10  # correlation lengths of a profile, below which its long waves are unknown
# standard deviations of ln mean square slope, by chance, between profiles of one finish
_UNLIKE_DEVIATIONS = 3.0
_STRETCHED = 2.0  # ratio of the stretches by slopes and by correlation lengths, up to which it is one
_STEP_SHARE = 0.2  # of the mean square slope in a single step between neighbours
_LONG_SHARE = 0.2  # of the mean square height in waves that are longer than the surface


@as_si
def surface_from_profiles(
    profiles: Sequence[xr.DataArray],
    *,
    along: Sequence[xr.DataArray] = (),
    lay: str = ISOTROPIC,
    points: int | None = None,
    spacing: float | str | None = None,
    seed: int = 0,
) -> xr.DataArray:
    """Draw a surface that has the spectrum, the heights and the slopes of profiles of it.

    The surface is isotropic, periodic and as random as its `seed`. Its spectrum is fitted to the mean
    periodogram of the profiles by non-negative least squares; what levelling has removed from each line is
    put back. Heights have the distribution of the profiles, the highest summits, which no profile meets, by
    linear extrapolation over the normal score, and slopes that of the profiles at the same height; amplitudes
    and ranks are imposed in turns [1]_. With profiles of a second direction, `along` a lay, waves along y are
    longer by the ratio of the rms slopes of both.

    Parameters
    ----------
    profiles : sequence of DataArray (1, x), m
        one or more of one finish, of equal pitch, as `level` returns them; of a profile with missing points
        the longest stretch between them. A straight line is removed from each.
    along : sequence of DataArray (1, x), m, optional
        one or more at right angles to the others, of any pitch.
    lay : {"none"}
        isotropic, but for `along`. Across a lay profiles are solved as they are.
    points : int, optional
        per side; as many as the profiles have by default, but no more than 512.
    spacing : float or str, optional, m
        pitch of the surface; that of the profiles by default.
    seed : int
        of `numpy.random.default_rng`.

    Returns
    -------
    DataArray (y, x), m
        with the attributes of the first profile, `lay`, `profiles` (their number), `correlation_length` (m),
        `stretch`, `profile_warnings` (JSON, sentences), and `profile_spectra` (JSON): at each `wavenumber`
        (rad/m) the mean periodogram of the `profiles` and that of their `fit` (m3).

    Raises
    ------
    HeightMapError
        for no profiles, maps, profiles of unlike pitch, of fewer than 64 points, or flat ones.
    SettingsError
        for another lay, or a size or pitch that is not positive.

    References
    ----------
    .. [1] Schreiber and Schmitz (1996), Improved surrogate data for nonlinearity tests, Phys. Rev. Lett. 77,
       635.

    Examples
    --------
    >>> import roughcontact as rc
    >>> made = rc.self_affine_surface((256, 256), 1e-6, hurst=0.8, shortest=8e-6, longest=5e-5, rms_height=1)
    >>> surface = rc.surface_from_profiles([made[[row]] for row in (10, 90, 170)], seed=1)
    >>> surface.shape, f"{float(surface.std()):.1g} m"
    ((256, 256), '1 m')
    """
    check_lay(lay)
    if not lay_facts({"lay": lay}).has_surface_behind:
        raise SettingsError("lay = 'across': such profiles are ridges, and are solved as they are (evaluate)")
    stack = stacked(profiles, along)
    fit = fit_profiles(stack)
    pitch = fit.pitch
    ratio = 1.0 if spacing is None else check_positive("spacing", spacing, unit="m") / pitch
    side = int(friendly_sides(min(fit.pieces.shape[1], MAX_POINTS))[-1]) if points is None else points
    for key, value, minimum in (("points", side, 2), ("seed", seed, 0)):
        if value < minimum:
            raise SettingsError(f"{key} = {value!r}: give a whole number of {minimum} or more", keys=[key])
    finish = fit_statistics(fit)
    heights = draw(finish, side, ratio, np.random.default_rng(seed))
    spectra = {  # the last two measured values are mean squares
        "wavenumber": 2 * np.pi * fit.band / pitch,
        "profiles": fit.measured[:-2] * pitch,
        "fit": finish.spectrum.fitted[:-2] * pitch,
    }
    return height_map(heights, pitch * ratio, unit="m").assign_attrs(
        stack.attrs,
        lay=_LAY_BY_DIRECTIONS[len(fit.directions)],
        profiles=len(stack),
        correlation_length=correlation_length(fit.pieces) * pitch,
        stretch=finish.stretch,
        **json_attributes({"profile_warnings": [*_warnings(fit, finish, side * ratio)]}),
        **json_attributes({"profile_spectra": spectra}),
        missing_points=0,
        missing_share=0.0,
    )


def stacked(profiles: Profiles, along: Profiles = ()) -> xr.DataArray:
    """Return profiles, or arrays of these, as the rows of one array (number, x; m), NaN beyond their ends.

    The last rows are any `along` a lay, of a pitch of their own.
    """
    across, along_rows = _rows(profiles), _rows(along) if len(along) else []
    rows = [*across, *along_rows]
    if len(rows) == 1:
        return rows[0]
    values = np.full((len(rows), max(row.size for row in rows)), np.nan)
    for index, row in enumerate(rows):
        values[index, : row.size] = row.values
    missing = sum(int(np.isnan(row).sum()) for row in rows)
    stack = height_map(values, spacing(rows[0])[1], unit="m").assign_attrs(
        rows[0].attrs, profiles=len(rows), missing_points=missing, missing_share=missing / values.size
    )
    if along_rows:
        pitch_along = spacing(along_rows[0])[1]
        stack.attrs |= {"lay": BOTH, "profiles_along": len(along_rows), "pitch_along": pitch_along}
    return stack


def _rows(profiles: Profiles) -> list[xr.DataArray]:
    """Return profiles, or arrays of these, one by one (1, x; m)."""
    profile_list = [profiles] if isinstance(profiles, xr.DataArray) else profiles
    arrays = [labelled_in_si(check_labelled(profile)) for profile in profile_list]
    if not arrays or not all(map(have_lines, arrays)):
        shapes = ", ".join(f"{array.shape[1]} x {array.shape[0]}" for array in arrays) or "no"
        raise HeightMapError(f"profiles: have {shapes} points; give one-row maps, one or more")
    arrays = [array if array.shape[1] > 1 else array.rename(x="y", y="x").T for array in arrays]
    pitches = [spacing(array)[1] for array in arrays]
    if max(pitches) > 1.01 * min(pitches):
        lengths = ", ".join(quantity(pitch, "m") for pitch in pitches)
        raise HeightMapError(f"profiles: have pitches of {lengths}; give profiles of one pitch")
    return [array[[row]] for array in arrays for row in range(len(array))]


def split_by_direction(stack: xr.DataArray) -> tuple[list[xr.DataArray], list[xr.DataArray]]:
    """Return the profiles (1, x; m) of a stack, and those of them that are along a lay."""
    rows, pitch = _rows(stack), spacing(stack)[1]
    number_across = len(rows) - stack.attrs.get("profiles_along", 0)
    stretch = stack.attrs.get("pitch_along", pitch) / pitch
    return rows[:number_across], [row.assign_coords(x=row["x"] * stretch) for row in rows[number_across:]]


def fit_profiles(stack: xr.DataArray) -> ProfileFit:
    """Return the fit to the pieces of levelled profiles (number, x; m), in each direction."""
    directions = [profile_pieces(rows) for rows in split_by_direction(stack) if rows]
    return ProfileFit(directions, max(1, form_order(stack)))


def with_lay(height: xr.DataArray, lay: str | None, along: Profiles) -> xr.DataArray:
    """Return a map (y, x; m) with the stated lay of its profiles, and others `along` it as its last rows."""
    if lay is not None:
        check_lay(lay)
        height = height.assign_attrs(lay=lay)
    if isinstance(along, str) or not isinstance(along, Sequence | xr.DataArray):
        text = f"along is of type {type(along).__name__}: give a profile along the lay, or a list of them"
        raise SettingsError(text, keys=["along"])
    if len(along) and not lay_facts({"lay": lay}).takes_profiles_along:
        raise SettingsError(
            f"along: is of a surface with a lay, and lay = {lay!r}; state lay = 'across'", keys=["lay"]
        )
    return stacked(height, along) if len(along) else height


def levelled_profiles(height: xr.DataArray, options: Mapping[str, Any]) -> xr.DataArray:
    """Return profiles (number, x; m) with a surface behind them, each levelled by itself."""
    if "stretch" in height.attrs:
        raise HeightMapError(
            "this surface was drawn from profiles: evaluate these with lay = none, for their ±, or solve it "
            "by solve_contact"
        )
    check_lines(height)
    directions = split_by_direction(stacked(height))
    return stacked(*([level(_trim_missing(row), **options) for row in rows] for rows in directions))


def profile_pieces(profiles: Sequence[xr.DataArray]) -> tuple[np.ndarray, float]:
    """Return profiles as pieces of equal length (number, points; m), without a line, and their pitch (m)."""
    rows = [_longest_run(row.values[0]) for row in profiles]
    points = min([_MAX_PIECE_POINTS, *(row.size for row in rows)])
    name = profiles[0].attrs.get("source_file") or "profiles"
    if points < _MIN_POINTS:
        raise HeightMapError(
            f"{name}: {points} points in one stretch are too few for a spectrum; give profiles of "
            f"{_MIN_POINTS} points or more, or state lay = across"
        )
    segments = np.concatenate([row[: row.size // points * points].reshape(-1, points) for row in rows])
    line = np.linalg.qr(np.polynomial.legendre.legvander(np.linspace(-1, 1, points), 1))[0]
    largest = np.abs(segments).max()
    segments = segments - (segments @ line) @ line.T
    if not np.diff(segments).std() > 1e-12 * largest:
        raise HeightMapError(f"{name}: is flat; a flat profile has no spectrum")
    return segments, spacing(profiles[0])[1]


def _trim_missing(profile: xr.DataArray) -> xr.DataArray:
    """Return a profile (1, x) from its first measured point to its last."""
    indices = np.flatnonzero(np.isfinite(profile[0]))
    return profile[:, indices[0] : indices[-1] + 1] if indices.size else profile


def _longest_run(row: np.ndarray) -> np.ndarray:
    """Return the longest stretch of a profile between missing points."""
    stretches = np.ma.clump_unmasked(np.ma.masked_invalid(row))
    return row[max(stretches, key=lambda stretch: stretch.stop - stretch.start, default=slice(0))]


def _warnings(fit: ProfileFit, finish: Finish, side: float) -> Iterator[str]:
    """Yield sentences on profiles that do not tell enough of a surface of `side` times their pitch."""
    (segments, pitch), (along, pitch_along) = fit.directions[0], fit.directions[-1]
    length, stretch = correlation_length(segments), finish.stretch
    longer = correlation_length(along) / length * (pitch_along / pitch)
    if not 1 / _STRETCHED < longer / stretch < _STRETCHED:
        yield (
            f"By the slopes of the profiles along, waves are {number(stretch)} times as long as across, by "
            f"the correlation lengths {number(longer)} times: the spectrum is not a stretched one, and the "
            "areas may be wrong by a third. Measure an areal map."
        )
    steps = np.diff(segments) ** 2
    lengths = segments.shape[1] / length
    if lengths < _LENGTHS:
        yield (
            f"The profiles are {number(lengths)} correlation lengths ({quantity(length * pitch, 'm')}) long, "
            f"fewer than {_LENGTHS}: the long waves, and with them the gap, are hardly known. Measure "
            "longer profiles."
        )
    spread = np.ptp(np.log(steps.mean(axis=1)))
    chance = np.sqrt(2 * _bandwidth(steps) / steps.shape[1])
    if len(segments) > 1 and spread > _UNLIKE_DEVIATIONS * np.sqrt(2) * chance:
        yield (
            f"The mean square slopes of the profiles differ by a factor of {number(np.exp(spread))}, more "
            "than those of an isotropic surface do: they may be of two directions, across and along a lay. "
            "State lay = across for those across it, and give the others as profiles along it."
        )
    share = steps.max() / steps.sum()
    if share > _STEP_SHARE:
        yield (
            f"A single step between neighbours has {percent(share)} of the mean square slope: a trace that "
            "was put together, or a spike. Cut the profile there."
        )
    spectrum, side = finish.spectrum, side / stretch
    f = np.geomspace(spectrum.frequency[0], spectrum.frequency[-1], 500)
    powers = spectrum.at(f) * f**2  # for each step of ln f
    is_resolved = f > 1 / segments.shape[1]
    missing = powers[is_resolved & (f < 1 / side)].sum() / powers[is_resolved].sum()
    if missing > _LONG_SHARE:
        yield (
            f"Waves longer than the surface that was solved, {quantity(side * pitch, 'm')}, have "
            f"{percent(missing)} of the mean square height: the gap is that of waves up to this length. "
            "Remove longer ones (level.l_filter)."
        )


def _bandwidth(steps: np.ndarray) -> float:
    """Return the variance of the mean square slopes (pieces, points) over that of independent normal ones."""
    correlation = sums_of_products(steps / steps.mean(axis=1, keepdims=True) - 1) / steps.shape[1]
    positive = np.argmax(correlation <= 0) or correlation.size
    return float(correlation[:positive].sum() - correlation[0] / 2)
