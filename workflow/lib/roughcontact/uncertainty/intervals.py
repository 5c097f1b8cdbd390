"""The intervals of a quantity: of the surface, the next map, longer and shorter waves, and this map."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import get_args

import numpy as np

from roughcontact.choices import HeadlineMeasurand, UncertaintySource
from roughcontact.uncertainty import calibration
from roughcontact.uncertainty.combination import (
    SIGNS,
    Component,
    Components,
    Ends,
    added_up,
    columns_of_components,
    ends_of,
    half_widths,
    limited,
    monotonic,
)
from roughcontact.uncertainty.discretisation import CORRECTED
from roughcontact.uncertainty.ensemble import Values
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, PEAK, PRESSURE, from_scale
from roughcontact.uncertainty.subwindows import Scatter


@dataclass(frozen=True)
class Intervals:
    """The intervals of all measurands, from what the sources contribute.

    Attributes
    ----------
    components : mapping
        source -> components of each quantity.
    scatter : Scatter or None
        of the subwindows; None where the source `window` is left out.
    octave : mapping
        quantity -> shift (load) by waves one octave shorter, and the component about it.
    open_ended : mapping
        narrowest place -> whether grooves lead out of the map (load).
    load : array, Pa
    extent : float
        length of the longer surface over that of the map.
    hardness : float or None, Pa
    measurand : str
        that of the ends `_lower` and `_upper`, and of the half-widths.
    """

    components: Mapping[UncertaintySource, Components]
    scatter: Scatter | None
    octave: Mapping[str, tuple[np.ndarray, Component]]
    open_ended: Values
    load: np.ndarray
    extent: float
    hardness: float | None
    measurand: HeadlineMeasurand = "surface"

    def columns(self, name: str, as_solved: Values, middle: Values) -> dict[str, tuple]:
        """Return the ends of all intervals of a quantity, and what they are made of.

        `as_solved` are the results, `middle` the corrected ones on their scales.
        """
        value = self._value(name, middle, as_solved)
        if name in (AREA, PRESSURE):  # full contact, up to the rounding of its scale
            value = np.where(as_solved[AREA] >= 1, as_solved[name], value)
        sources = self._sources(name, middle[AREA])
        windows: dict[str, Component] = {}
        if self.scatter is not None:
            windows = {m: self._window(m, name, middle, as_solved) for m in get_args(calibration.Measurand)}
        headline = [windows[self.measurand]] if windows else []
        ends = {"": self._ends(name, middle, value, [*sources.values(), *headline])}
        for measurand in ("next", "longer", "map"):
            window = [windows[measurand]] if windows else []
            ends[f"{measurand}_"] = self._ends(name, middle, value, [*sources.values(), *window])
        ends["octave_"] = ends[""]  # where the band is chosen
        if (key := AREA if name == PRESSURE else name) in self.octave:
            shorter = {q: middle[q] + shift for q, (shift, _) in self.octave.items()}
            octave_component = self._converted(name, shorter[AREA], self.octave[key][1])
            moved = self._value(name, shorter, as_solved)
            ends["octave_"] = self._ends(
                name, shorter, moved, [*sources.values(), *headline, octave_component]
            )
        columns: dict[str, tuple] = {
            f"{name}_{key}{end}": ("load", numbers)
            for key, pair in ends.items()
            for end, numbers in zip(("lower", "upper"), pair, strict=True)
        }
        if name in (*CORRECTED, PRESSURE):
            columns[f"{name}_as_solved"] = ("load", as_solved[name])
        if headline:
            sources["window"] = headline[0]
        return columns | columns_of_components(name, value, sources, ends[""])

    def _centre(self, name: str, middle: Values) -> np.ndarray:
        """Return a result on its scale; the pressure in contact is the load over the area."""
        if name != PRESSURE:
            return middle[name]
        return np.log(self.load) - np.log(from_scale(AREA, middle[AREA]))

    def _value(self, name: str, middle: Values, as_solved: Values) -> np.ndarray:
        """Return a corrected result in its unit; as solved in full contact, which has no gap on its scale."""
        centre = self._centre(name, middle)
        value = np.where(np.isnan(centre), as_solved[name], from_scale(name, centre))
        return (
            value if self.hardness is None or name not in (PRESSURE, PEAK) else np.fmin(value, self.hardness)
        )

    def _sources(self, name: str, area: np.ndarray) -> dict[UncertaintySource, Component]:
        """Return the components of a quantity; of the pressure those of the area, but for stated inputs."""
        sources = {}
        for source, components in self.components.items():
            if name in components:
                sources[source] = components[name]
            elif name == PRESSURE and AREA in components:
                sources[source] = self._converted(name, area, components[AREA])
        return sources

    def _window(
        self, measurand: calibration.Measurand, name: str, middle: Values, as_solved: Values
    ) -> Component:
        """Return the component by which the truth of a measurand may differ from this map."""
        assert self.scatter is not None
        # without parts of a map nothing bounds what other places would give
        if not self.scatter.features and not self.scatter.arms:
            width = np.full(self.load.shape, 0.0 if measurand == "map" else np.inf)
            return half_widths(width, width)
        key, area = AREA if name == PRESSURE else name, from_scale(AREA, middle[AREA])
        if self.scatter.arms:  # of surfaces behind profiles, whatever their size
            below, above = self.scatter.arms[key]
        else:
            features = self.scatter.features[key]
            below, above = calibration.arms(measurand, key, features, area, extent=self.extent)
        if name in CONSTRICTIONS:  # counted in mean gaps
            below, above = below * as_solved[GAP], above * as_solved[GAP]
        if name in self.open_ended and measurand != "map":
            above = np.where(self.open_ended[name], np.inf, above)
        return self._converted(name, middle[AREA], half_widths(below, above))

    def _converted(self, name: str, area: np.ndarray, component: Component) -> Component:
        """Return a component of the area as one of ln(pressure in contact); those of others as they are."""
        if name != PRESSURE:
            return component
        with np.errstate(divide="ignore"):
            ratio = from_scale(AREA, area) / from_scale(AREA, area + SIGNS * component)
        return (-SIGNS * np.log(ratio))[[1, 0, 3, 2]]

    def _ends(self, name: str, middle: Values, value: np.ndarray, components: Iterable[Component]) -> Ends:
        """Return both ends of an interval, in the unit of the quantity; NaN without any source."""
        components = list(components)
        if not components:
            return (np.full(value.shape, np.nan),) * 2
        ends = ends_of(name, self._centre(name, middle), added_up(components))
        if name == GAP and self.scatter is not None:  # in full contact: that of the most open subwindow
            with np.errstate(all="ignore"):
                widest = np.fmax.reduce(self.scatter.members[GAP], axis=0, initial=0.0)
            ends = np.where(value > 0, ends[0], 0.0), np.where(value > 0, ends[1], widest)
        ends = monotonic(name, ends, self.load)
        return limited(name, ends, value=value, load=self.load, hardness=self.hardness)
