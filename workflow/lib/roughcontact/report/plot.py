"""Results drawn on axes of Matplotlib, with the colours, labels, units and error bars of the report.

Each function takes a dataset, draws on `ax` (new axes where none are given) and returns the axes:
``roughcontact.report.plot.area(roughcontact.evaluate(path, contact=...))``. `maps` takes the solution of
`solve_contact`, or contact.nc, all others the statistics of one surface, as `evaluate` returns them or
`read_statistics` reads them from statistics.nc. The functions of the report make what is drawn.
All raise a SettingsError for a dataset of something else, or of several surfaces.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_solution
from roughcontact.arguments.choices import check_choice
from roughcontact.arguments.quantities import percent
from roughcontact.arguments.si import as_si
from roughcontact.errors import SettingsError
from roughcontact.report import budget_plots, load_plots, map_plots
from roughcontact.report.charts import Axis, Chart, tick_text
from roughcontact.report.units import unit_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["area", "budget", "height", "magnification", "maps", "pressure"]

Quantity = Literal["relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure"]
Map = Literal["pressure", "gap", "height"]
_POINTS = 0.75  # of a typographer, in a pixel
_LEGEND = 0.6  # room for a long legend above the lines, over the height of these
_LEGEND_STYLE: Any = {"fontsize": "small", "framealpha": 0.75, "edgecolor": "none"}


def area(dataset: xr.Dataset, ax: "Axes | None" = None) -> "Axes":
    """Draw the contact area against the load, with its interval and the theories of half-spaces.

    Parameters
    ----------
    dataset : Dataset
        statistics of one surface, dims (load, ...).
    ax : Axes, optional
        to draw on.

    Returns
    -------
    Axes
        mean pressure in the unit of the report, share of the nominal area in percent, both logarithmic.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> statistics = rc.contact_statistics(
    ...     rc.solve_contact(rough_reference_surface(64), contact_modulus=1e9, mean_pressure=[1e7, 1e8])
    ... )
    >>> rc.plot.area(statistics).get_ylabel()
    'contact area (%)'
    """
    loads = _sorted_loads(dataset, "relative_contact_area")
    if not np.isfinite(loads["relative_pressure"]).all():
        raise SettingsError("the surface is flat: it touches as a whole at every load")
    return _drawn(load_plots.area_against_load(loads, None), ax)


def pressure(dataset: xr.Dataset, ax: "Axes | None" = None) -> "Axes":
    """Draw mean and largest pressure of the contact against the load, with intervals and the hardness.

    Parameters
    ----------
    dataset : Dataset
        statistics of one surface, dims (load, ...).
    ax : Axes, optional
        to draw on.

    Returns
    -------
    Axes
        pressures in the unit of the report, both logarithmic.

    Examples
    --------
    >>> import xarray as xr
    >>> names = ("mean_pressure", "mean_contact_pressure", "max_pressure")
    >>> numbers = xr.Dataset({name: ("load", [10.0**power, 2e6]) for power, name in enumerate(names)})
    >>> pressure(numbers).get_ylabel()
    'pressure in contact (MPa)'
    """
    loads = _sorted_loads(dataset, "max_pressure", "mean_contact_pressure")
    return _drawn(load_plots.pressure_against_load(loads), ax)


def __dir__() -> list[str]:
    return __all__  # what a notebook completes


@as_si
def height(height: xr.DataArray, ax: "Axes | None" = None) -> "Axes":
    """Draw a map of heights in a unit that suits it; a profile is drawn as a line.

    Parameters
    ----------
    height : DataArray
        dims (y, x), in metres or the `units` it states: a measured or levelled map, a window.
    ax : Axes, optional
        to draw on; the colour bar takes a part of it.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> rc.plot.height(rough_reference_surface(64)).get_xlabel()
    'x (mm)'
    """
    return _drawn(map_plots.height_map(height), ax)


def maps(
    dataset: xr.Dataset, ax: "Axes | None" = None, *, quantity: Map = "pressure", load: int = -1
) -> "Axes":
    """Draw the map of pressure or gap at one load, or that of the heights; a profile is drawn as a line.

    Parameters
    ----------
    dataset : Dataset
        the solution of a contact: that of `solve_contact`, or the file contact.nc.
    ax : Axes, optional
        to draw on; the colour bar takes a part of it.
    quantity : {"pressure", "gap", "height"}
    load : int
        index of the load; by default the last one. Of a dataset of a single load it says nothing.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> contact = rc.solve_contact(rough_reference_surface(64), contact_modulus=1e9, mean_pressure=1e7)
    >>> rc.plot.maps(contact, quantity="gap").get_title()
    '10.0 MPa: 5.74 % of the pixels touch'
    """
    check_choice("quantity", quantity, Map)
    check_solution(dataset, of_loads=False)
    chosen = dataset.isel(load=load) if "load" in dataset.dims else dataset
    height, pressures, gap = chosen["height"], chosen["pressure"].values, chosen["gap"].values
    of_pressure = unit_of(dataset, "Pa")
    if quantity == "height":
        return _drawn(map_plots.height_map(height), ax)
    if quantity == "pressure":
        chart = map_plots.pressure_map(height, pressures, unit=of_pressure)
    else:
        chart = map_plots.gap_map(height, gap, pressures)
    touching = percent(np.count_nonzero(pressures > 0) / pressures.size)
    chart.title = f"{of_pressure.text(float(chosen['mean_pressure']))}: {touching} of the pixels touch"
    return _drawn(chart, ax)


def magnification(
    dataset: xr.Dataset, ax: "Axes | None" = None, *, quantity: str = "relative_contact_area"
) -> "Axes":
    """Draw a result against the shortest wave that is kept, for up to four of the loads.

    Parameters
    ----------
    dataset : Dataset
        statistics of one surface, dims (load, cutoff, ...).
    ax : Axes, optional
        to draw on.
    quantity : str
        one of those with `{quantity}_at_cutoff`.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> numbers = xr.Dataset(
    ...     {"relative_contact_area_at_cutoff": (("load", "cutoff"), [[0.1, 0.2]])},
    ...     coords={"mean_pressure": ("load", [1e6]), "cutoff_wavelength": ("cutoff", [1e-6, 2e-6])},
    ... )
    >>> magnification(numbers).get_xlabel()
    'shortest wave kept (µm)'
    """
    chart = budget_plots.cutoff_chart(_sorted_loads(dataset, f"{quantity}_at_cutoff"), quantity)
    if chart is None:
        raise SettingsError(f"{quantity}_at_cutoff is not known at two wavelengths: there is nothing to draw")
    return _drawn(chart, ax)


def budget(
    dataset: xr.Dataset, ax: "Axes | None" = None, *, quantity: Quantity = "relative_contact_area"
) -> "Axes":
    """Draw the ± of a result by source, in percent of the value, against the load.

    Parameters
    ----------
    dataset : Dataset
        statistics of one surface with its error budget, dims (load, source, ...).
    ax : Axes, optional
        to draw on.
    quantity : {"relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure"}

    Returns
    -------
    Axes

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> statistics = rc.evaluate(
    ...     rough_reference_surface(64),
    ...     contact={"contact_modulus": "1 GPa", "relative_pressure": [0.05, 0.1]},
    ...     uncertainty={"sources": ["solver", "discretisation"]},
    ... )
    >>> rc.plot.budget(statistics).get_title()
    'contact area'
    """
    check_choice("quantity", quantity, Quantity)
    loads = _sorted_loads(dataset, "relative_contact_area_uncertainty", f"{quantity}_uncertainty")
    ax = _drawn(budget_plots.budget_against_load(loads, quantity), ax)
    low, high = ax.get_ylim()
    ax.set_ylim(low, high * (high / low) ** _LEGEND)
    ax.legend(loc="upper center", ncols=2, **_LEGEND_STYLE)
    return ax


def _sorted_loads(dataset: xr.Dataset, *names: str) -> xr.Dataset:
    """Return the loads of one surface in order, without padding, if the dataset has what is needed."""
    if missing := [name for name in ("mean_pressure", *names) if name not in dataset]:
        raise SettingsError(
            f"the dataset has no {missing[0]}: give the result of evaluate, or of read_statistics"
        )
    dims = dataset["mean_pressure"].dims
    if further := [str(dim) for dim in dims if dim != "load"]:
        raise SettingsError(f"the dataset has more than one {further[0]}: choose one, .sel({further[0]}=...)")
    if not dims:
        raise SettingsError("the dataset has a single load, no curve: choose loads by a list of pressures")
    result = dataset.isel(load=np.isfinite(dataset["mean_pressure"].values))
    if "cutoff_wavelength" in result:
        result = result.isel(cutoff=np.isfinite(result["cutoff_wavelength"].values))
    return result.isel(load=np.argsort(result["mean_pressure"].values, kind="stable"))


def _drawn(chart: Chart, ax: "Axes | None") -> "Axes":
    """Draw what a chart of the report shows."""
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots(layout="constrained")
    ax.set(xlabel=chart.x.label, ylabel=chart.y.label, title=chart.title)
    for ticks, axis, limits in ((ax.xaxis, chart.x, ax.get_xlim()), (ax.yaxis, chart.y, ax.get_ylim())):
        # of axes that show something already, the union
        extent = [axis.low, axis.high, *(limits if ax.has_data() else ())]
        scale, extremes = "log" if axis.log else "linear", (min(extent), max(extent))
        ax.set(**{f"{ticks.axis_name}scale": scale, f"{ticks.axis_name}lim": extremes})
        _write_ticks(ticks, axis)
    for kind, step in chart.steps:
        if kind in _METHODS:
            _METHODS[kind](ax, chart, **step)
    ax.set_axisbelow(True)
    ax.grid(**{"color": "#dddddd"} if chart.grid else {"visible": False})
    if ax.get_legend_handles_labels()[1]:
        ax.legend(**_LEGEND_STYLE)
    return ax


def _write_ticks(ticks: Any, axis: Axis) -> None:
    """Write the numbers of a logarithmic axis as the report does."""
    if axis.log:
        from matplotlib.ticker import LogLocator, NullFormatter

        ticks.set_major_locator(LogLocator(subs=(1, 2, 5) if axis.high < 1000 * axis.low else (1,)))
        ticks.set_major_formatter(lambda value, _: tick_text(value))
        ticks.set_minor_formatter(NullFormatter())


def _line(ax: "Axes", _: Chart, *, x: Any, y: Any, colour: str, label: str, **look: Any) -> None:
    """Draw a line."""
    width, dashes = look["width"], [float(length) for length in look["dash"].split()]
    style: Any = (0, tuple(length / width for length in dashes)) if dashes else "-"
    ax.plot(x, y, color=colour, linewidth=width * _POINTS, linestyle=style, label=label or None)


def _marks(ax: "Axes", _: Chart, *, x: Any, y: Any, colour: str, label: str, **look: Any) -> None:
    """Draw marks."""
    face = colour if look["filled"] else "none"
    ax.plot(x, y, look["marker"], color=colour, markerfacecolor=face, markersize=5, label=label or None)


def _bars(ax: "Axes", chart: Chart, *, x: Any, lower: Any, upper: Any, colour: str, **_rest: Any) -> None:
    """Draw error bars; one that leaves the axes ends beyond their edge, without an upper end by an arrow."""
    axis: Axis = chart.y
    edges = (axis.low / 2, axis.high * 2) if axis.log else (2 * axis.low, 2 * axis.high)
    open_ended = np.isnan(upper) & np.isfinite(lower)
    low, high = (np.clip(bound, *edges) for bound in (lower, np.where(open_ended, edges[1], upper)))
    sides = [high - low, np.zeros_like(high)]
    ax.errorbar(x, high, yerr=sides, fmt="none", ecolor=colour, elinewidth=1, capsize=2)
    if open_ended.any():  # at the upper edge, whatever the other axis shows
        style: Any = {"marker": "^", "markersize": 4, "linestyle": "", "color": colour, "clip_on": False}
        ax.plot(x[open_ended], np.ones(open_ended.sum()), transform=ax.get_xaxis_transform(), **style)


def _values(ax: "Axes", chart: Chart, *, values: Any, bar: Axis, colours: str, bad: str) -> None:
    """Draw a map with its colour bar."""
    import matplotlib

    extent = chart.x.low, chart.x.high, chart.y.low, chart.y.high
    colour_map = matplotlib.colormaps[colours].with_extremes(bad=bad)
    style: Any = {"vmin": bar.low, "vmax": bar.high, "interpolation": "nearest", "origin": "lower"}
    style |= {"aspect": "auto" if "not to scale" in chart.y.label else "equal"}
    image = ax.imshow(values, extent=extent, cmap=colour_map, **style)
    ax.figure.colorbar(image, ax=ax, label=bar.label)


_METHODS: dict[str, Callable[..., None]] = {"line": _line, "marks": _marks, "bars": _bars, "values": _values}
