"""The intervals of a quantity: of the surface, the next map, longer and shorter waves, and this map."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import get_args

import numpy as np

from roughcontact.choices import HeadlineMeasurand, UncertaintySource
from roughcontact.uncertainty import calibration
from roughcontact.uncertainty.combination import (
    SOURCES,
    Component,
    Components,
    columns_of_components,
    component,
    ends_of,
    limited,
    monotonic,
)
from roughcontact.uncertainty.discretisation import CORRECTED
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, PEAK, PRESSURE, from_scale
from roughcontact.uncertainty.subwindows import Scatter

Arms = tuple[np.ndarray, np.ndarray]  # below and above the result (load), on the scale
Octave = Mapping[str, tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Intervals:
    """The intervals of all measurands, from what the sources contribute.

    Attributes
    ----------
    found : mapping
        source -> components of each quantity.
    scatter : Scatter or None
        of the subwindows; None where the source `window` is left out.
    octave : mapping
        quantity -> shift, and half-widths below and above it, by waves one octave shorter.
    open_ended : mapping
        narrowest place -> whether grooves lead out of the map (load).
    load : array, Pa
    extent : float
        length of the longer surface over that of the map.
    hardness : float or None, Pa
    measurand : str
        that of the ends `_lower` and `_upper`, and of the half-widths.
    """

    found: Mapping[UncertaintySource, Components]
    scatter: Scatter | None
    octave: Octave
    open_ended: Mapping[str, np.ndarray]
    load: np.ndarray
    extent: float
    hardness: float | None
    measurand: HeadlineMeasurand = "surface"

    def columns(
        self, name: str, as_solved: Mapping[str, np.ndarray], middle: Mapping[str, np.ndarray]
    ) -> dict[str, tuple]:
        """Return the ends of all intervals of a quantity, and what they are made of."""
        area = from_scale(AREA, middle[AREA])
        if name == PRESSURE:  # the load over the area
            centre, own = np.log(self.load) - np.log(area), self._of_pressure(middle[AREA])
        else:
            centre, own = middle[name], {s: parts[name] for s, parts in self.found.items() if name in parts}
        value = np.where(np.isnan(centre), as_solved[name], from_scale(name, centre))
        if name in (AREA, PRESSURE):  # full contact, up to the rounding of its scale
            value = np.where(as_solved[AREA] >= 1, as_solved[name], value)
        if self.hardness is not None and name in (PRESSURE, PEAK):
            value = np.fmin(value, self.hardness)
        arms = {
            m: self._arms(m, name, area, as_solved[GAP], middle[AREA])
            for m in get_args(calibration.Measurand)
        }
        everything = [*own.values()]
        ends = {
            "": self._ends(name, centre, value, everything, arms[self.measurand]),
            "next_": self._ends(name, centre, value, everything, arms["next"]),
            "longer_": self._ends(name, centre, value, everything, arms["longer"]),
            "map_": self._ends(name, centre, value, everything, arms["map"]),
            "octave_": self._octave(name, centre, value, everything, arms[self.measurand], middle[AREA]),
        }
        columns: dict[str, tuple] = {}
        for key, pair in ends.items():
            for end, numbers in zip(("lower", "upper"), pair, strict=True):
                columns[f"{name}_{key}{end}"] = ("load", numbers)
        if (headline := arms[self.measurand]) is not None:
            own["window"] = component(*(np.maximum(side, 0.0) for side in headline))
        shown: dict[UncertaintySource, Components] = {s: {name: own[s]} for s in SOURCES if s in own}
        columns |= columns_of_components(name, value, shown, ends[""])
        if name in (*CORRECTED, PRESSURE):
            columns[f"{name}_as_solved"] = ("load", as_solved[name])
        return columns

    def _arms(
        self,
        measurand: calibration.Measurand,
        name: str,
        area: np.ndarray,
        gap: np.ndarray,
        middle_of_area: np.ndarray,
    ) -> Arms | None:
        """Return how far the truth of a measurand may lie below and above a result, on its scale."""
        if self.scatter is None:
            return None
        if not self.scatter.features:  # without parts of a map nothing bounds what other places would give
            return (np.full(area.shape, np.inf if measurand != "map" else 0.0),) * 2
        source = AREA if name == PRESSURE else name
        features = self.scatter.features[source]
        if measurand == "longer":
            down, up = calibration.arms_of_longer(source, features, area, self.extent)
        else:
            down, up = calibration.arms(measurand, source, features, area)
        if name in CONSTRICTIONS:  # counted in mean gaps
            down, up = down * gap, up * gap
        if name == PRESSURE:
            return _of_area_in_pressure(middle_of_area, down, up)
        if name in self.open_ended and measurand != "map":
            up = np.where(self.open_ended[name], np.inf, up)
        return down, up

    def _of_pressure(self, middle_of_area: np.ndarray) -> dict[UncertaintySource, Component]:
        """Return the components of the pressure in contact: of the area, but for stated inputs."""
        own: dict[UncertaintySource, Component] = {}
        for source, parts in self.found.items():
            if PRESSURE in parts and source != "solver":
                own[source] = parts[PRESSURE]
            elif AREA in parts:
                area = parts[AREA]
                below, above = _of_area_in_pressure(middle_of_area, area.down, area.up)
                shifts = _of_area_in_pressure(middle_of_area, area.shift_down, area.shift_up)
                own[source] = Component(below, above, *shifts)
        return own

    def _ends(
        self, name: str, centre: np.ndarray, value: np.ndarray, parts: list[Component], arms: Arms | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return both ends of an interval, in the unit of the quantity; NaN without any source."""
        if not parts and arms is None:
            return (np.full(value.shape, np.nan),) * 2
        ends = ends_of(name, centre, parts, arms)
        if name == GAP and self.scatter is not None:  # in full contact: that of the most open subwindow
            with np.errstate(all="ignore"):
                widest = np.fmax.reduce(self.scatter.members[GAP], axis=0, initial=0.0)
            ends = np.where(value > 0, ends[0], 0.0), np.where(value > 0, ends[1], widest)
        ends = monotonic(name, ends, self.load)
        return limited(name, ends, value=value, load=self.load, hardness=self.hardness)

    def _octave(
        self,
        name: str,
        centre: np.ndarray,
        value: np.ndarray,
        parts: list[Component],
        arms: Arms | None,
        middle_of_area: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return both ends with waves one octave shorter; those of the surface where the band is chosen."""
        source = AREA if name == PRESSURE else name
        if source not in self.octave:
            return self._ends(name, centre, value, parts, arms)
        shift, below, above = self.octave[source]
        if name == PRESSURE:
            moved, _ = _of_area_in_pressure(middle_of_area, 0 * shift, shift)
            below, above = _of_area_in_pressure(middle_of_area + shift, below, above)
            shift = -moved
        moved_value = np.where(np.isnan(centre), value, from_scale(name, centre + shift))  # full contact
        if self.hardness is not None and name in (PRESSURE, PEAK):
            moved_value = np.fmin(moved_value, self.hardness)
        return self._ends(name, centre + shift, moved_value, [*parts, component(below, above)], arms)


def _of_area_in_pressure(middle: np.ndarray, down: np.ndarray, up: np.ndarray) -> Arms:
    """Return arms of ln(pressure in contact) below and above, from those of the area on its scale."""
    area = from_scale(AREA, middle)
    with np.errstate(divide="ignore"):
        below = np.log(from_scale(AREA, middle + up) / area)
        above = np.log(area / from_scale(AREA, middle - down))
    return below, above
