"""The place of a map in an overview: a coarser map of a larger field around it, of the same face.

The fine map, its pixels merged to those of the overview, is shifted, turned and stretched until it correlates
best. The form that levelling removes counts for nothing in a correlation, wherever the map is laid.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
import scipy
import xarray as xr

from roughcontact.arguments.maps import dimensions, height_map, merged, side_lengths, spacing
from roughcontact.arguments.positions import ELSEWHERE, parse_position
from roughcontact.arguments.quantities import number, percent, quantity
from roughcontact.errors import HeightMapError
from roughcontact.surface.levelling.forms import form_order
from roughcontact.surface.window.rectangle import largest_rectangle

MIN_CORRELATION = 0.8
# of the place, over the side of the fine map: the gap is off twice as much with a quarter
MAX_UNCERTAINTY = 0.1
MIN_FIELDS = 2.0  # sides of the overview over those of the fine map: four places at least
MIN_POINTS = 16  # of the overview along each side of the fine map
_PREFIX = "place_"  # of the attributes of a placed overview
_MAX_ANGLE = 3.0  # degree, within which parts lie on stages alike
_MAX_SCALING = 0.04  # of the lateral scales of two instruments
_SEARCHED_POINTS = 48  # along the shorter side of the fine map where all angles and scales are tried
_SEARCHED_SHIFT = 0.8  # pixels by which its edges move from one angle or scale to the next
_SHOWN_ANGLE, _SHOWN_STRETCH = 0.1, 0.005  # in words
_LEAST_SHIFT = 0.2  # pixels, the last step of the search
_ROUNDING = 1e-3  # pixels, by which the rounding of coordinates makes a side shorter
_CORRELATED_POINTS = 9  # neighbours in a residual, which are one independent point
_SIGNIFICANT = 4.0  # standard deviations by which another place is to fit worse


class Place(NamedTuple):
    """Where a map lies in its overview."""

    y: float  # m, middle of the map in the coordinates of the overview
    x: float
    rotation: float  # degree, of the map in the overview
    scale: float  # length in the overview over length in the map
    correlation: float
    uncertainty: float  # of the place, over the side of the map; the larger one of both axes

    def __str__(self) -> str:
        """Return the place in words."""
        return f"at ({quantity(self.x, 'm')}, {quantity(self.y, 'm')}), {self.fit_in_words()}"

    def fit_in_words(self, *, with_scale: bool = True) -> str:
        """Return how the map lies there: its turn, with or without its scale, and the correlation."""
        words, stretch = [], abs(self.scale - 1)
        # at the limit of the search the map may be turned or stretched by more
        turned, stretched = (
            " or more" if np.isclose(amount, limit) else ""
            for amount, limit in ((abs(self.rotation), _MAX_ANGLE), (stretch, _MAX_SCALING))
        )
        if abs(self.rotation) >= _SHOWN_ANGLE:
            words.append(f"turned by {number(self.rotation, decimals=1)}°{turned}")
        if with_scale and stretch >= _SHOWN_STRETCH:
            side = "longer" if self.scale > 1 else "shorter"
            words.append(f"{percent(stretch)}{stretched} {side} than it says")
        return ", ".join([*words, f"correlation {number(self.correlation, decimals=2)}"])


def middle_of(height: xr.DataArray) -> tuple[float, float]:
    """Return x and y (m) of the middle of a map in its own coordinates."""
    return float(height["x"].mean()), float(height["y"].mean())


def overview_with_place(
    levelled: xr.DataArray,
    overview: xr.DataArray,
    position: str = "",
    middle: tuple[float, float] | None = None,
) -> xr.DataArray:
    """Return the measured part of a levelled overview, with the place of a levelled map in its attributes.

    `position` is what the table states (`arguments.positions`), of the `middle` (`middle_of`) of the map
    before a part of it was taken; one of another position has no place. Places are from the lower left.
    """
    corner = {
        axis: overview[axis].copy(data=(np.arange(overview.sizes[axis]) + 0.5) * step)
        for axis, step in zip("yx", spacing(overview), strict=True)
    }
    fine, field = measured_rectangle(levelled), measured_rectangle(overview.assign_coords(corner))
    if position == ELSEWHERE:  # stated by the user: other places of the face are of use, too
        check_size(fine, field)
        return field
    near = parse_position(position)
    if near is not None:
        # what is looked for is less than the map where parts, or points at its border, are left out
        x, y = np.add(near, middle_of(fine)) - (middle or middle_of(levelled))
        near = float(x), float(y)
    place = place_of(fine, field, near=near)
    return field.assign_attrs({f"{_PREFIX}{key}": value for key, value in place._asdict().items()})


def joined_overviews(overviews: Sequence[xr.DataArray]) -> xr.Dataset:
    """Return overviews (y, x; m) of different fields and pixels as one dataset, the content of a file."""
    columns, coordinates = {}, {}
    for rank, overview in enumerate(overviews, start=1):
        # files hold overviews of different pixels: each has axes of its own
        axes = {axis: f"{axis}_{rank}" for axis in overview.dims}
        for axis, name in axes.items():
            words = f"{axis} of overview {rank}"
            coordinates[name] = name, overview[axis].values, {"units": "m", "long_name": words}
        attrs = {k: value for k, value in overview.attrs.items() if k.startswith((_PREFIX, "source_"))}
        attrs |= {"units": "m", "long_name": "surface height of a coarser map around the map"}
        columns[f"overview_{rank}"] = tuple(axes.values()), overview.values, attrs
    return xr.Dataset(columns, coordinates)


def separate_overviews(joined: xr.Dataset) -> list[xr.DataArray]:
    """Return the overviews that `joined_overviews` has put together."""
    return [
        joined[name].rename({f"y_{rank}": "y", f"x_{rank}": "x"}).rename("height")
        for rank, name in enumerate(joined.data_vars, start=1)
    ]


def recorded_place(overview: xr.DataArray) -> Place | None:
    """Return the place of the fine map in an overview of `overview_with_place`; None if it is elsewhere."""
    if f"{_PREFIX}correlation" not in overview.attrs:
        return None
    return Place(*(float(overview.attrs[f"{_PREFIX}{key}"]) for key in Place._fields))


def place_in_words(overview: xr.DataArray) -> str:
    """Return what an overview of `overview_with_place` shows, a sentence."""
    place = recorded_place(overview)
    return f"The map lies {place}." if place else "Another position of the face, without the map."


def frame_of_place(overview: xr.DataArray, fine: xr.DataArray) -> tuple[float, float, float, float] | None:
    """Return where a map lies in an overview: x and y of a corner from its first, and sides (m)."""
    if not (place := recorded_place(overview)):
        return None
    side_y, side_x = _sides(place, fine)
    dy, dx = spacing(overview)
    left_edge = place.x - float(overview["x"][0]) + dx / 2 - side_x / 2
    return left_edge, place.y - float(overview["y"][0]) + dy / 2 - side_y / 2, side_x, side_y


def _sides(place: Place, fine: xr.DataArray) -> tuple[float, float]:
    """Return the sides (y, x; m) of a map in the lengths of its overview, whose scale may differ."""
    length_y, length_x = side_lengths(fine)
    return length_y * place.scale, length_x * place.scale


def place_attributes(overviews: Sequence[xr.DataArray], levelled: xr.DataArray) -> dict[str, float]:
    """Return what results record of the place of a map in the first overview that shows it.

    Correlation, scale, and the corner of the map from that of the overview (m).
    """
    for place in filter(None, map(recorded_place, overviews)):
        side_y, side_x = _sides(place, measured_rectangle(levelled))
        # of the overview, of which the measured part may begin later
        offsets = {"offset_x": place.x - side_x / 2, "offset_y": place.y - side_y / 2}
        return {"correlation": place.correlation, "scale": place.scale, **offsets}
    return {}


def place_of(fine: xr.DataArray, overview: xr.DataArray, *, near: tuple[float, float] | None = None) -> Place:
    """Return where a levelled map lies in a levelled overview (y, x; m), by normalised cross-correlation.

    It is looked for everywhere, or within a tenth of its side from a stated place `near` (x, y; m).

    Raises
    ------
    HeightMapError
        for an overview that is too small or too coarse, or does not show the map at one place.

    References
    ----------
    J. P. Lewis (1995), Fast normalized cross-correlation, Vision Interface, 120.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> field = rough_reference_surface(192)
    >>> part, pixel = field[100:164, 20:84], spacing(field)[0]
    >>> place = place_of(part, field.coarsen(y=2, x=2).mean())
    >>> bool(abs(place.y - float(part.y.mean())) < 0.2 * pixel), round(place.correlation, 2)
    (True, 1.0)
    """
    check_size(fine, overview)
    # a stated place is searched within a margin
    place = best_place(fine, overview if near is None else _around(overview, fine, near))
    names = [str(height.attrs.get("source_file") or "a map") for height in (overview, fine)]
    way = (
        "measure both without moving the part, the map in the middle of the overview, or state "
        "overview_position: x and y, or elsewhere"
    )
    if place.correlation < MIN_CORRELATION:
        raise HeightMapError(
            f"overview: {names[0]} does not show the place of {names[1]}: it fits best {place}, and has to "
            f"have {MIN_CORRELATION}; {way}"
        )
    # a stated place is not doubted, however many others look like it
    if near is not None:
        return place._replace(uncertainty=min(place.uncertainty, MAX_UNCERTAINTY))
    if place.uncertainty > MAX_UNCERTAINTY:
        raise HeightMapError(
            f"overview: {names[1]} fits into {names[0]} at several places, {percent(place.uncertainty)} of "
            f"its side apart, as on grooves or a grating; {way}"
        )
    return place


def best_place(fine: xr.DataArray, overview: xr.DataArray) -> Place:
    """Return where a levelled map fits best within a levelled overview (y, x; m), however well that is."""
    order = form_order(fine)
    steps = np.array(spacing(overview))
    # angles and scales are tried on a coarse overview, and refined on the full one
    coarsening = max(1, int((side_lengths(fine) / steps).min() // _SEARCHED_POINTS))
    search = _Search(fine, merged(overview, coarsening), order)
    angle, scale = search.strides
    angles = np.arange(-(_MAX_ANGLE // angle), _MAX_ANGLE // angle + 1) * angle
    scales = np.arange(-(_MAX_SCALING // scale), _MAX_SCALING // scale + 1) * scale
    best = max(product(angles, 1 + scales), key=search.height)
    search = _Search(fine, overview, order) if coarsening > 1 else search
    step = 0.5 * np.array([angle, scale])
    # halved where no neighbour fits better
    while step[0] >= search.strides[0] * _LEAST_SHIFT / _SEARCHED_SHIFT:
        nearest = max([best, *_neighbours(best, step)], key=search.height)
        step = step / (2 if nearest == best else 1)
        best = nearest
    surface = search.correlations(best)
    shift, shares = _peak(surface, search.shape)
    origin = np.array([float(overview[axis][0]) for axis in "yx"])
    y, x = map(float, origin + steps * (shift + (np.array(search.shape) - 1) / 2))
    return Place(y, x, float(best[0]), float(best[1]), float(surface.max()), float(max(shares)))


def _around(overview: xr.DataArray, fine: xr.DataArray, near: tuple[float, float]) -> xr.DataArray:
    """Return the part of an overview in which a map may lie whose middle is stated (x, y; m)."""
    sides = np.array(side_lengths(fine))
    # the template is as small as the map may be
    part = part_around(overview, near[::-1], sides * (1 - _MAX_SCALING + 2 * MAX_UNCERTAINTY))
    for axis, middle, side, length in zip("yx", near[::-1], sides, side_lengths(part), strict=True):
        if length < side:
            name = overview.attrs.get("source_file") or "the overview"
            # the part would end before the map does
            raise HeightMapError(
                f"overview_position: with its middle at {axis} = {quantity(middle, 'm')} the map reaches "
                f"beyond {name}; state x and y from the lower left corner of the overview"
            )
    return part


def part_around(
    height: xr.DataArray, middle: Sequence[float] | np.ndarray, sides: Sequence[float] | np.ndarray
) -> xr.DataArray:
    """Return the points of a map (y, x; m) whose centres lie in a rectangle of these sides (y, x; m)."""
    return height.isel(
        {
            axis: np.flatnonzero(np.abs(height[axis].values - centre) <= side / 2)
            for axis, centre, side in zip("yx", middle, sides, strict=True)
        }
    )


def shown_by(fine: xr.DataArray, overview: xr.DataArray) -> xr.DataArray:
    """Return a levelled map (y, x; m) with the pixels of an overview, each the mean of its heights there.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> fine = rough_reference_surface(64)
    >>> bool(np.allclose(shown_by(fine, fine.coarsen(y=4, x=4).mean()), fine.coarsen(y=4, x=4).mean()))
    True
    """
    search = _Search(fine, overview, form_order(fine), largest=1.0)
    return height_map(search.template((0.0, 1.0)), spacing(overview)).assign_attrs(fine.attrs)


def measured_rectangle(levelled: xr.DataArray) -> xr.DataArray:
    """Return the largest rectangle of a map (y, x; m) without missing points."""
    good = ~np.isnan(levelled.values)
    y, x, ny, nx = largest_rectangle(good, np.arange(max(good.shape) + 1))
    return levelled.isel(y=slice(y, y + ny), x=slice(x, x + nx))


def check_size(fine: xr.DataArray, overview: xr.DataArray) -> None:
    """Refuse an overview that holds too few fields, or whose points are too few or not coarser."""
    names = " and ".join(str(height.attrs.get("source_file") or "a map") for height in (fine, overview))
    sides = np.array(side_lengths(fine))
    fields, points = side_lengths(overview) / sides, sides / spacing(overview)
    wrong = ""
    if min(dimensions(fine.shape), dimensions(overview.shape)) < 2:
        wrong = "a profile has no overview; give two maps"
    elif fields.min() < MIN_FIELDS:
        fields_text = " x ".join(number(n, digits=2) for n in fields)
        wrong = f"it is {fields_text} times as long (y, x) as the map; measure a field at least twice as long"
    elif (points > np.array(fine.shape) / 1.5).any():
        wrong = "its pixels are hardly larger than those of the map; give the larger field alone"
    elif points.min() < MIN_POINTS:
        wrong = (
            f"it has {points.min():.0f} points along a side of the map, and needs {MIN_POINTS}; measure it "
            "with a higher magnification"
        )
    if wrong:
        raise HeightMapError(f"overview: {names}: {wrong}, or leave overview empty")


def _neighbours(middle: tuple[float, float], step: np.ndarray) -> Iterator[tuple[float, float]]:
    """Yield the next angles and scales, up to the limits of the search."""
    limits = np.array([_MAX_ANGLE, _MAX_SCALING])
    for direction in np.array([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        angle, stretch = np.clip(np.array(middle) + direction * step - [0, 1], -limits, limits)
        yield float(angle), 1 + float(stretch)


class _Search:
    """Correlations of a fine map with an overview, whose transforms are kept.

    The template has one `shape` (ny, nx; points of the overview) at all angles and scales, that of the
    smallest: otherwise its middle would fall between the points at some of them, which would fit worse.
    """

    def __init__(
        self, fine: xr.DataArray, overview: xr.DataArray, order: int, *, largest: float = 1 - _MAX_SCALING
    ):
        self._steps, self._fine_steps = np.array(spacing(overview)), np.array(spacing(fine))
        widths = np.maximum(1, np.rint(self._steps / self._fine_steps)).astype(int)
        # as the overview averages over its pixels
        self._fine = scipy.ndimage.uniform_filter(fine.values, widths, mode="nearest")
        self._lag = 0.5 * (widths % 2 == 0)  # an even mean is of half a pixel before
        # without its mean the sums of squares keep their digits
        image = overview.values - overview.values.mean()
        self._size, self._points = image.shape, [scipy.fft.next_fast_len(n, real=True) for n in image.shape]
        self._image, self._squares = (scipy.fft.rfft2(field, self._points) for field in (image, image**2))
        self._heights: dict[tuple[float, float], float] = {}
        sides = np.array(side_lengths(fine)) * largest / self._steps
        self.shape = tuple(map(int, sides + _ROUNDING))
        half = max(self.shape) / 2
        self.strides = np.degrees(_SEARCHED_SHIFT / half), _SEARCHED_SHIFT / half  # of angle and scale
        self._norm, self._forms = self._norm_and_forms(order)

    def height(self, pose: tuple[float, float]) -> float:
        """Return the largest correlation at an angle (degree) and a scale."""
        if pose not in self._heights:
            self._heights[pose] = float(self.correlations(pose).max())
        return self._heights[pose]

    def correlations(self, pose: tuple[float, float]) -> np.ndarray:
        """Return the correlation at every shift for which the template lies within the overview."""
        template = self.template(pose)
        # each place is levelled as the map was: forms do not count as likeness
        template -= self._forms.T.reshape(*self.shape, -1) @ (self._forms @ template.ravel())
        template /= np.linalg.norm(template) or 1.0  # a flat map correlates with nothing
        return self._over_image(self._image, template) / self._norm

    def template(self, pose: tuple[float, float]) -> np.ndarray:
        """Return the fine map on points of the overview, turned and stretched about its middle."""
        angle, scale = np.radians(pose[0]), pose[1]
        y, x = (
            (np.arange(n) - (n - 1) / 2) * d / scale for n, d in zip(self.shape, self._steps, strict=True)
        )
        y, x = np.meshgrid(y, x, indexing="ij")
        turned = y * np.cos(angle) - x * np.sin(angle), x * np.cos(angle) + y * np.sin(angle)
        where = [
            (n - 1) / 2 + along / d + lag
            for along, n, d, lag in zip(turned, self._fine.shape, self._fine_steps, self._lag, strict=True)
        ]
        return scipy.ndimage.map_coordinates(self._fine, where, order=1, mode="nearest")

    def _norm_and_forms(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the norm of the overview less its form at every shift, and the forms (term, point)."""
        y, x = np.meshgrid(*(np.linspace(-1, 1, n) for n in self.shape), indexing="ij")
        powers = [(i, j) for i in range(order + 1) for j in range(order + 1 - i)]
        forms = np.linalg.qr(np.column_stack([(y**i * x**j).ravel() for i, j in powers]))[0].T
        squares = self._over_image(self._squares, np.ones(self.shape))
        tiny = 1e-9 * float(squares.max())  # a flat place correlates with nothing
        for form in forms:
            squares = squares - self._over_image(self._image, form.reshape(self.shape)) ** 2
        return np.sqrt(np.maximum(squares, tiny)), forms

    def _over_image(self, image: np.ndarray, template: np.ndarray) -> np.ndarray:
        """Return the sum of products of a template with the transformed image at every shift."""
        products = scipy.fft.irfft2(image * scipy.fft.rfft2(template, self._points).conj(), self._points)
        # only shifts at which the whole template lies within the overview
        ny, nx = (n - m + 1 for n, m in zip(self._size, template.shape, strict=True))
        return products[:ny, :nx]


def _peak(surface: np.ndarray, shape: Sequence[int]) -> tuple[list[float], list[float]]:
    """Return the shift (y, x; points) of the best fit, and how far places reach that fit no worse, by side.

    The residual 1 - r^2 of a place of n independent points scatters by the root of 4/n of itself.
    """
    best = np.unravel_index(int(surface.argmax()), surface.shape)
    residual, independent = 1 - surface**2, max(surface.size and np.prod(shape) / _CORRELATED_POINTS, 1.0)
    # the residual of other places is larger by chance alone, by this much
    limit = residual[best] * (1 + _SIGNIFICANT * 2 / np.sqrt(independent)) + 1e-6
    fitting = np.argwhere((residual <= limit) & (surface > 0))
    reach = np.abs(fitting - best).max(axis=0)
    shares = [max(0.5, float(points)) / n for points, n in zip(reach, shape, strict=True)]
    shift = []
    for axis, middle in enumerate(best):
        line = np.moveaxis(surface, axis, 0)[:, best[1 - axis]]
        before, top, behind = np.pad(line, 1, constant_values=np.nan)[middle : middle + 3]
        curvature = before - 2 * top + behind
        # a parabola through three points
        shift.append(float(middle + (0.5 * (before - behind) / curvature if curvature < 0 else 0.0)))
    return shift, shares
