"""Figures and table of the error budget: the ± of each quantity by source."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.quantities import NO_UPPER_END, number, percent, prefix, quantity, with_interval
from roughcontact.report.charts import COLOURS, MARKERS, Axis, Chart
from roughcontact.report.units import unit_of

# names of the quantities on the page
_SHOWN = {
    "relative_contact_area": "contact area A/A₀",
    "mean_gap": "mean gap ū",
    "max_pressure": "largest pressure",
    "mean_contact_pressure": "pressure in contact",
}
_WORDS = {
    "solver": "solver",
    "discretisation": "grid",
    "window": "window",
    "processing": "processing",
    "instrument": "instrument",
    "material": "material",
    "unresolved": "unresolved waves",
    "combined": "all together",
}
_LEAST = 0.01  # percent; less is not drawn


def shown_budget(numbers: xr.Dataset) -> dict[str, Any] | None:
    """Return figures, table and notes of the error budget of a surface; None where it has none.

    `numbers` are the statistics of one surface with `{quantity}_uncertainty` (load, source). The result has
    `images`, for each quantity its name and its figure (a data URI), `header` and `rows` of the table, as
    text, and `notes` on how the parts were found and which are missing.

    Examples
    --------
    >>> import xarray as xr
    >>> shown_budget(xr.Dataset({"mean_gap": ("load", [1e-6])})) is None
    True
    """
    if "source" not in numbers.dims:
        return None
    area = numbers["relative_contact_area"]
    budget = numbers["relative_contact_area_uncertainty"]
    shown = [area, *(numbers[f"relative_contact_area_{end}"] for end in ("lower", "upper"))]
    in_use = [s for s in _WORDS if s in budget["source"].values[:-1]]  # the last one is combined
    present = [s for s in in_use if np.isfinite(budget.sel(source=s)).any()]
    rows = []
    for index in range(numbers.sizes["load"]):
        parts = {s: float(budget.sel(source=s)[index]) for s in present}
        rows.append(
            [
                unit_of(numbers, "Pa").text(float(numbers["mean_pressure"][index])),
                with_interval(*(100 * float(of[index]) for of in shown)),
                *(_part(100 * part, source) for source, part in parts.items()),
                _largest(parts),
            ]
        )
    words = (numbers.attrs.get(key) for key in ("window_flag", "window_reason", "processing_reason"))
    notes = [word for word in words if word]
    absent = [_WORDS[s] for s in _WORDS if s not in (*present, "combined")]
    if absent:
        notes.append(f"Not in the ±: {', '.join(absent)}.")
    notes += _notes_on_the_band(numbers)
    return {
        "images": [*_images(numbers, present), *_magnification(numbers)],
        "header": [
            "mean pressure p̄",
            "contact area A/A₀",
            *(_WORDS[s] for s in present),
            "largest part",
        ],
        "rows": rows,
        "notes": notes,
    }


def _part(half_width: float, source: str) -> str:
    """Return the contribution of a source; one that changes nothing is not written as ± 0."""
    if np.isnan(half_width):
        return "–"
    if half_width > 0:
        return f"± {number(half_width, digits=2)}"
    return "no pixel in doubt" if source == "solver" else "no difference"


def _largest(parts: Mapping[str, float]) -> str:
    """Return the name of the source with the largest contribution, a dash where all is exact."""
    known = {source: part for source, part in parts.items() if part > 0}
    return _WORDS[max(known, key=known.__getitem__)] if known else "–"


def _images(numbers: xr.Dataset, present: Sequence[str]) -> list[tuple[str, str]]:
    """Draw the relative half-widths (percent) of each source against the load; return (quantity, image).

    All sources together are a solid line upwards and a dashed one downwards.
    """
    load = numbers["mean_pressure"].values
    factor, unit = unit_of(numbers, "Pa")
    images = []
    for name, title in _SHOWN.items():
        value, budget = np.abs(numbers[name].values), numbers[f"{name}_uncertainty"]
        down, up = value - numbers[f"{name}_lower"].values, numbers[f"{name}_upper"].values - value
        parts = [budget.sel(source=source).values for source in present]
        shares = np.array([_in_percent(part, value) for part in (*parts, down, up)])
        highest = np.max(shares, initial=100.0, where=np.isfinite(shares))
        chart = Chart(
            Axis(f"mean pressure p̄ ({unit})", load.min() * factor / 1.5, load.max() * factor * 1.5, log=True),
            Axis("± in percent of the value", _LEAST, 2 * highest, log=True),
            title=title,
            size=(330.0, 290.0),
        )
        for place, (source, part) in enumerate(zip(present, parts, strict=True)):
            chart.marks(
                load * factor,
                _in_percent(part, value),
                colour=COLOURS[place],
                marker=MARKERS[place],
                joined=1.5,
                label=_WORDS[source],
            )
        for half, dash, words in ((up, "", f"{_WORDS['combined']}, up"), (down, "5 3", "down")):
            share = _in_percent(half, value)
            chart.line(load * factor, share, colour="#000000", width=2.2, dash=dash, label=words)
        images.append((title, chart.source("below", columns=2)))
    return images


def _notes_on_the_band(numbers: xr.Dataset) -> list[str]:
    """Return sentences on the waves that the numbers hold for, and on ends that are not known."""
    notes = []
    if "cutoff_wavelength" in numbers and numbers.sizes["cutoff"] > 1:
        shortest = float(numbers["cutoff_wavelength"][0])
        changes = []
        for name in ("relative_contact_area", "max_pressure"):
            fine, coarse = numbers[f"{name}_at_cutoff"].values.T[:2]
            changes.append(percent(float(np.abs(fine / coarse - 1).max())))
        notes.append(
            f"The numbers hold for waves longer than {quantity(shortest, 'm')} (two pixels). Of these the "
            f"shortest octave, below {quantity(2 * shortest, 'm')}, changed the contact area by up to "
            f"{changes[0]} and the largest pressure by up to {changes[1]}. Shorter waves, which this map "
            "does not show, may change them again: that is the source unresolved waves."
        )
    unknown = []
    for name, words in _SHOWN.items():
        upper = numbers[f"{name}_upper"].values
        if (np.isnan(upper) | (upper > (1 + NO_UPPER_END) * numbers[name].values)).any():
            unknown.append(words)
    if unknown:
        notes.append(
            f"“Or more”: the upper end is not known from this map ({', '.join(unknown)}). Either shorter "
            "waves, which carry the largest pressure, are not resolved, or too few independent parts fit "
            "into the map."
        )
    return notes


def _magnification(numbers: xr.Dataset) -> list[tuple[str, str]]:
    """Draw the contact area against the shortest wave that is kept, one line for a few of the loads."""
    if "cutoff_wavelength" not in numbers or numbers.sizes["cutoff"] < 2:
        return []
    wavelengths = numbers["cutoff_wavelength"].values
    area = numbers["relative_contact_area_at_cutoff"].values
    factor, unit = prefix(float(wavelengths[0]), "m")
    loads = np.unique(np.linspace(0, len(area) - 1, min(len(area), 4)).round().astype(int))
    shown = 100 * area[loads]
    chart = Chart(
        Axis(
            f"shortest wave kept ({unit})",
            wavelengths[0] * factor / 1.3,
            wavelengths[-1] * factor * 1.3,
            log=True,
        ),
        Axis("contact area A/A₀ (%)", 0.0, min(1.15 * float(np.nanmax(shown)), 105.0)),
        title="Contact area by the shortest wave",
        size=(330.0, 290.0),
    )
    for place, (load, values) in enumerate(zip(loads, shown, strict=True)):
        chart.marks(
            wavelengths * factor,
            values,
            colour=COLOURS[place],
            marker=MARKERS[place],
            joined=1.5,
            label=unit_of(numbers, "Pa").text(float(numbers["mean_pressure"][load])),
        )
    return [("contact area by the shortest wave", chart.source("below", columns=2))]


def _in_percent(half_width: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return half-widths in percent of the value, NaN where there is nothing to draw."""
    share = 100 * np.divide(half_width, value, out=np.full(value.shape, np.nan), where=value > 0)
    return np.where(share >= _LEAST, share, np.nan)
