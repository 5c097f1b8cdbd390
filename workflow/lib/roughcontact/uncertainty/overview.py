"""A second, coarser map of the same face as a control variate: what other places of the surface would give.

The overview shows a field around the fine map. On the scale t of each quantity the mean over its places is

    t = t_fine(own place) + b (mean of t_coarse(places) - t_coarse(own place)),

where b is of the bank, and every place is a window of the size of the fine map (control variates: Nelson
1990, Operations Research 38, 974). Of gap and conductance the change of the other counts as well, and for
the gap that of the gradient. All are solved at the load p k, k being the gradient of the overview over that
of the fine map at its own place, so that both touch as much. Lens, noise and lateral scale of the overview
are the same at all places, and cancel. The whole overview in place of the mean is a joint as large as it.

An overview of another position of the face has no own place: that of another overview with its pixels stands
for it, or else the fine map with its pixels merged, whose lens is not that of the overview. Then lens and
noise do not cancel, and the arms are those of such overviews of the bank. Several overviews are averaged.

The error that is left goes with what coarser pixels change from place to place, which the overview shows
with its own pixels merged 2 x 2, with the scatter of the places, and with the change itself; less, with the
scatter of the gradient within the fine map. The arms are quantiles of the errors of a bank over this size
(`benchmarks/two_magnifications.py`). They count also where they are wider than those of the fine map alone,
which hold in 38 to 89 % of such places, these in 77 to 98 %. The largest pressure is a matter of single
points, of which an overview tells less than the map: it keeps its own.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import merged, side_lengths, spacing
from roughcontact.arguments.quantities import number as number_text
from roughcontact.surface.faces import placing
from roughcontact.surface.levelling.forms import form_order
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window.periodic_window import subwindow
from roughcontact.uncertainty import calibration
from roughcontact.uncertainty.calibration import ALONE, JOINT, MEASURANDS, Measurand
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.scales import AREA, CONDUCTANCE, CONSTRICTIONS, GAP, PEAK, to_scale
from roughcontact.uncertainty.subwindows import Scatter, Slices, relevelled, scatter_of_subwindows

GRADIENT = "rms_gradient"  # of places, on its logarithm
# whose changes tell of that of a quantity as well
COUNTERPARTS: dict[str, tuple[str, ...]] = {GAP: (CONDUCTANCE, GRADIENT), CONDUCTANCE: (GAP,)}
OTHER_PLACES: tuple[Measurand, ...] = ("surface", "next", JOINT)
# of their scatter, in the size
_SHARE_OF_PLACES: dict[str, float] = dict(zip(OTHER_PLACES, (0.3, 1.0, 0.3), strict=True))
MAX_PLACES = 5  # along each side: more tell little more, and cost
_SHARE_OF_CHANGE = 0.3  # in the size: what an overview moves a result by, it moves it too far or not enough
_POWER, _POWER_OF_GRADIENT = 0.8, 0.1  # in the size: of what an overview shows, and of the fine map's scatter
_LEAST_SIZE = 0.05  # of a logarithm
_SAME_PIXELS = 0.01  # relative difference
_OF_MAP = "Largest pressure, narrowest places, leak and the loads of targets are those of the map."


class Transfer(NamedTuple):
    """What an overview shows of one quantity, on its scale (load)."""

    surface: np.ndarray  # mean of its places less the own place
    joint: np.ndarray  # the whole overview less the own place
    octave: np.ndarray  # scatter between places of what pixels twice as large change
    places: np.ndarray  # scatter of the places


class View(NamedTuple):
    """What one overview shows of a map."""

    transfers: Mapping[str, Transfer]
    pixels: float  # over those of the map
    sees_map: bool  # whether the map is compared with its own place in it, or in another one of its pixels
    field: float  # area over that of the map

    def numbers(
        self, measurand: Measurand, name: str, area: np.ndarray, gradient: Any
    ) -> tuple[np.ndarray, ...]:
        """Return by how much a result differs elsewhere, with arms down and up (load), on its scale.

        `gradient` is that of the features of the map.
        """
        # a counterpart is not known of layered bodies, nor where the contact is full
        counterparts = (self.transfers.get(key) for key in COUNTERPARTS.get(name, ()))
        own_transfer, *counterpart_transfers = [self.transfers[name], *counterparts]
        kind = "joint" if measurand == JOINT else "surface"
        change = getattr(own_transfer, kind)
        further = (
            np.nan_to_num(getattr(other, kind)) if other else 0.0 * area for other in counterpart_transfers
        )
        shares, down, up = calibration.overview_arms(measurand, name, self.pixels, area, self.sees_map)
        centre = sum(share * moved for share, moved in zip(shares, (change, *further), strict=False))
        size = expected_size(measurand, change, own_transfer.octave, own_transfer.places, gradient)
        return np.asarray(centre), down * size, up * size


def expected_size(
    measurand: Measurand, change: np.ndarray, octave: np.ndarray, places: np.ndarray, gradient: Any
) -> np.ndarray:
    """Return the expected size of an error from the numbers of a `Transfer`, on the scale.

    `gradient` is ln of the scatter of the rms gradient that maps of the size of the fine one have
    (`subwindows`).
    """
    square = octave**2 + (_SHARE_OF_PLACES[measurand] * places) ** 2
    square += (_SHARE_OF_CHANGE * change) ** 2 + _LEAST_SIZE**2
    return square ** (_POWER / 2) * np.exp(_POWER_OF_GRADIENT * gradient)


def scatter_with_overviews(
    overviews: Sequence[xr.DataArray],
    result: Result,
    levelled: xr.DataArray,
    *,
    arguments: Mapping[str, Any],
    number: int,
) -> Scatter:
    """Return the scatter of the subwindows of a map, with what its overviews (y, x; m) show."""
    scatter = scatter_of_subwindows(result, levelled, arguments=arguments, number=number)
    if not scatter.features:
        return scatter
    fine, views = placing.measured_rectangle(levelled), []
    for overview in overviews:
        footprint, sees_map = own_place(fine, overview, overviews)
        transfers = transfers_of(result, form_order(fine), footprint, overview, arguments)
        pixels = math.sqrt(math.prod(spacing(overview)) / math.prod(spacing(fine)))
        views.append(View(transfers, pixels, sees_map, math.prod(field_ratios(fine, overview))))
    sentences = [*(_sentence(fine, overview) for overview in overviews), _OF_MAP]
    return with_views(scatter._replace(overview=" ".join(sentences)), result, views)


def _sentence(fine: xr.DataArray, overview: xr.DataArray) -> str:
    """Return what an overview is, a sentence of the report."""
    file, words = overview.attrs.get("source_file"), placing.place_in_words(overview)
    sides = " × ".join(number_text(side, digits=2) for side in reversed(field_ratios(fine, overview)))
    overview_in_words = f"An overview{f' ({file})' if file else ''} of {sides} fields"
    return f"{overview_in_words} shows other places; {words[0].lower()}{words[1:]}"


def own_place(
    fine: xr.DataArray, overview: xr.DataArray, overviews: Sequence[xr.DataArray]
) -> tuple[xr.DataArray, bool]:
    """Return the place of a map with the pixels of an overview, and whether one of the overviews shows it."""
    for field in (overview, *overviews):  # those with its pixels, as maps of one instrument have
        is_like_it = np.allclose(spacing(field), spacing(overview), rtol=_SAME_PIXELS)
        if is_like_it and (place := placing.recorded_place(field)):
            return field.isel(window_of_place(fine, field, place)), True
    return placing.shown_by(fine, overview), False


def field_ratios(fine: xr.DataArray, overview: xr.DataArray) -> tuple[float, float]:
    """Return the sides of an overview over those of its fine map (y, x)."""
    y, x = (np.array(overview.shape) * spacing(overview)) / (np.array(fine.shape) * spacing(fine))
    return float(y), float(x)


def window_of_place(fine: xr.DataArray, overview: xr.DataArray, place: placing.Place) -> Slices:
    """Return rows and columns of the place of a map in the overview around it."""
    window = {}
    for axis, n, step, side in zip("yx", overview.shape, spacing(overview), side_lengths(fine), strict=True):
        points = min(n, round(side * place.scale / step))
        middle = (getattr(place, axis) - float(overview[axis][0])) / step
        first = min(max(0, round(middle - (points - 1) / 2)), n - points)
        window[axis] = slice(first, first + points)
    return window


def windows_of_places(shape: tuple[int, ...], overview: xr.DataArray) -> list[Slices]:
    """Return rows and columns of the places of an overview, of as many points as that of the map has."""
    tiles = []
    for n, points in zip(overview.shape, shape, strict=True):
        starts = np.linspace(0, n - points, min(n // points, MAX_PLACES)).round().astype(int)
        tiles.append([slice(start, start + points) for start in starts.tolist()])
    return [{"y": y, "x": x} for y, x in product(*tiles)]


def transfers_of(
    result: Result, order: int, footprint: xr.DataArray, overview: xr.DataArray, arguments: Mapping[str, Any]
) -> dict[str, Transfer]:
    """Return what an overview shows of area, gap and conductance of a result, and of the gradient.

    `footprint` is the place of the map with the pixels of the overview, `order` that of the form to remove.
    `arguments` are those of `periodic_window` of the fine map, without a correction for its instrument.
    """
    options = {key: value for key, value in arguments.items() if key not in ("placement", "min_share")}
    options |= {"correct_for": None}
    places = [overview.isel(window) for window in windows_of_places(footprint.shape, overview)]
    pieces = [relevelled(piece, order) for piece in (footprint, *places, overview)]
    coarser = [merged(piece, 2) for piece in pieces[:-1]]
    own_window, *windows = (subwindow(piece, **options) for piece in pieces)
    coarser_own, *coarser_windows = (subwindow(piece, **options) for piece in coarser)
    at_places = _results(result, own_window, [own_window, *windows])
    octave = _results(result, coarser_own, coarser_windows)  # only its gradient counts, of its own place
    transfers = {}
    for name in at_places:
        of_map, elsewhere, joint = at_places[name][0], at_places[name][1:-1], at_places[name][-1]
        scatter = (np.std(results, axis=0, ddof=1) for results in (elsewhere - octave[name], elsewhere))
        transfers[name] = Transfer(elsewhere.mean(axis=0) - of_map, joint - of_map, *scatter)
    return transfers


def _results(result: Result, own_window: xr.DataArray, windows: list[xr.DataArray]) -> dict[str, np.ndarray]:
    """Return the results (window, load) on their scales at loads by the gradient of the own place.

    With them is the gradient of the windows.
    """
    ratio = rms_gradient(own_window) / rms_gradient(result.window)
    contact = {**result.contact, "mean_pressure": result.load * ratio}
    if contact.get("hardness"):
        contact["hardness"] *= ratio
    names = [name for name in result.values if name not in (*CONSTRICTIONS, PEAK)]
    scaled = Result(own_window, contact, {name: result.values[name] for name in names})
    members = scaled.members(windows).items()
    results = {name: np.ascontiguousarray(to_scale(name, values)) for name, values in members}
    return results | {GRADIENT: np.log([[rms_gradient(window)] * result.load.size for window in windows])}


def with_views(scatter: Scatter, result: Result, views: Sequence[View]) -> Scatter:
    """Return the scatter of a map with the shifts and the arms that its overviews give, if any tells one."""
    arms: dict[Measurand, dict[str, tuple[np.ndarray, np.ndarray]]] = {}
    shift: dict[str, np.ndarray] = {}
    joint, tells = {}, False
    area, gap = result.values[AREA], result.values[GAP] / float(result.window.std())
    largest = max(views, key=lambda view: (view.sees_map, view.field))
    names = [name for name in views[0].transfers if name in scatter.features]
    for name, key in product(names, (*MEASURANDS, ALONE, JOINT)):
        ends = np.array(calibration.arms(key, name, scatter.features[name], area, gap))
        centre = np.zeros(area.shape)
        if key in OTHER_PLACES:
            telling, gradient = [largest] if key == JOINT else views, scatter.features[name]["gradient"]
            numbers = [view.numbers(key, name, area, gradient) for view in telling]
            # NaN where all overviews, or the own place in them, are closed
            centre, *bounds = _combined(np.array(numbers))
            tells |= bool(np.isfinite(bounds).any())
            centre, ends = np.nan_to_num(centre), np.where(np.isnan(bounds), ends, bounds)
        # of the measurands the surface is the first
        joint[name] = centre - shift.setdefault(name, centre)
        arms.setdefault(key, {})[name] = ends[0] - joint[name], ends[1] + joint[name]
    return scatter._replace(arms=arms, shift=shift, joint=joint) if tells else scatter._replace(overview="")


def _combined(numbers: np.ndarray) -> np.ndarray:
    """Return the centre and arms (3, load) of several overviews (overview, 3, load); NaN where none tells.

    The narrower ones count more; as they have the map, and places, in common, their arms are averaged too.
    """
    tells = np.isfinite(numbers).all(axis=1, keepdims=True)
    weights = np.where(tells, numbers[:, 1:2] + numbers[:, 2:], np.inf) ** -2.0
    with np.errstate(invalid="ignore"):
        return (weights * np.where(tells, numbers, 0.0)).sum(axis=0) / weights.sum(axis=0)
