"""Maps of one place, before and after something was done to it: the part that all of them show.

The middle of the later map is looked for in the earlier one, as a map is in its overview. Both are cropped to
what they share; neither is interpolated, which would smooth its shortest waves, so that a turn stays.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions, side_lengths, spacing
from roughcontact.arguments.measurement import add_remark
from roughcontact.arguments.quantities import counted_noun, quantity
from roughcontact.errors import HeightMapError
from roughcontact.surface.faces import placing
from roughcontact.surface.levelling.level import level

_MIN_CORRELATION = 0.5  # of the middle with the earlier map; wear takes from it, another place gives less
_TEMPLATE = 0.5  # side of what is looked for, over that of the smaller map


def registered(later: xr.DataArray, earlier: xr.DataArray) -> tuple[np.ndarray, placing.Place]:
    """Return the shift of a measured map to its place in an earlier one (y, x; m), and that of its middle.

    The shift is the position in the earlier map less that in the map itself. Where the middle fits at several
    places, as on grooves, the one next to its own position is meant.

    Raises
    ------
    HeightMapError
        for maps that do not show the same place.
    """
    fields = [placing.measured_rectangle(level(height)) for height in (earlier, later)]
    # the middle of the later map, which a shift up to a quarter keeps within the earlier one
    sides = _TEMPLATE * np.min([side_lengths(field) for field in fields], axis=0)
    template = placing.part_around(fields[1], placing.middle_of(fields[1])[::-1], sides)
    middle = np.array(placing.middle_of(template)[::-1])
    place, threshold = placing.best_place(template, fields[0]), _MIN_CORRELATION
    if place.uncertainty > placing.MAX_UNCERTAINTY:
        # grooves fit at several places: then the nearest one counts, if it fits well
        reach = np.array(side_lengths(template)) * (1 + 2 * placing.MAX_UNCERTAINTY)
        nearby = placing.part_around(fields[0], middle, reach)
        place, threshold = placing.best_place(template, nearby), placing.MIN_CORRELATION
    if place.correlation < threshold:
        names = [str(height.attrs.get("source_file") or "a map") for height in (later, earlier)]
        where = "at no place alone" if threshold > _MIN_CORRELATION else "nowhere"
        raise HeightMapError(
            f"before: {names[0]} does not show the place of {names[1]}: its middle fits {where}, best "
            f"{place}, and has to have {threshold}; measure the same place, shifted by less than a quarter "
            "of the map, or leave before empty"
        )
    return np.array([place.y, place.x]) - middle, place


def common_part(maps: Mapping[str, xr.DataArray], earlier: Mapping[str, str], name: str) -> xr.DataArray:
    """Return what of a map (y, x; m) all maps of its place show, with where it was found in its attributes.

    `maps` are in the order of time, each by its name; `earlier` has that of the map before each but the
    first. Profiles, which stand for their surface and not for a place, are left as they are.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> field = rough_reference_surface(128)
    >>> maps = {"new": field[:120, :120], "worn": field[4:124, 2:122].assign_coords(field[:120, :120].coords)}
    >>> [common_part(maps, {"worn": "new"}, name).shape for name in maps]
    [(116, 118), (116, 118)]
    """
    height = maps[name]
    if min(dimensions(field.shape) for field in maps.values()) < 2:
        return height
    registrations = {
        member: registered(maps[member], maps[reference]) for member, reference in earlier.items()
    }
    shifts: dict[str, np.ndarray] = {}
    for member in maps:
        # positions in the map that came first, step by step along the order of time
        reference = earlier.get(member)
        shifts[member] = shifts[reference] + registrations[member][0] if reference else np.zeros(2)
    cuts = {}
    for row, axis in enumerate("yx"):
        starts, stops = (
            [float(field[axis][edge]) + shifts[key][row] for key, field in maps.items()] for edge in (0, -1)
        )
        step = spacing(height)[row]
        points = min(height.sizes[axis], round((min(stops) - max(starts)) / step) + 1)
        start = round((max(starts) - shifts[name][row] - float(height[axis][0])) / step)
        # rounding may be off by a pixel at either end
        start = min(max(start, 0), height.sizes[axis] - points)
        cuts[axis] = slice(start, start + points)
    part = height.isel(cuts)
    measured = part.notnull()
    for each, other in maps.items():  # with the same points missing all have the same window
        positions = {axis: part[axis].values + shifts[name][row] for row, axis in enumerate("yx")}
        there = {axis: values - shifts[each][row] for row, (axis, values) in enumerate(positions.items())}
        measured &= other.notnull().sel(there, method="nearest").values
    part, sentences = measured_in_all(part, measured), []
    if name in registrations:
        (y, x), place = registrations[name]
        moved = f"shifted by ({quantity(x, 'm')}, {quantity(y, 'm')})"
        sentences.append(f"the place of {earlier[name]}, {moved}, {place.fit_in_words(with_scale=False)}")
    if part.shape != height.shape:
        sizes = (" × ".join(map(str, cut.shape[::-1])) for cut in (part, height))
        sentences.append("cropped to {} of {} points, which all maps of the place show".format(*sizes))
    for text in sentences:
        part = part.assign_attrs(add_remark(part.attrs, text, fact=True))
    return part


def measured_in_all(height: xr.DataArray, measured: xr.DataArray) -> xr.DataArray:
    """Return a map (y, x; m) without the points that are not `measured` (y, x) in all maps of its place."""
    lacking, missing = int((height.notnull() & ~measured).sum()), int((~measured).sum())
    part = height.where(measured).assign_attrs(missing_points=missing, missing_share=missing / height.size)
    if not lacking:
        return part
    text = f"{counted_noun(lacking, 'point')} that another map of the place lacks: counted as not measured"
    return part.assign_attrs(add_remark(part.attrs, text, fact=True))
