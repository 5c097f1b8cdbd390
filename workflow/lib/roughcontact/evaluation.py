"""One call from a measured file to its numbers, with the settings of the configuration."""

import warnings
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.checking import check_labelled, check_lay, warn_of_map
from roughcontact.configuration.resolve import resolve
from roughcontact.errors import HeightMapWarning, SettingsError
from roughcontact.io.read import read_height_map
from roughcontact.pipeline import run_chain
from roughcontact.profiles.surface import stacked
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.si import labelled_in_si, listed
from roughcontact.variables import describe

_HEAVIEST = 2.0  # E* times the rms gradient: nearly closed
_LIGHTEST = 5e-4  # of the heaviest load: first contact
_BELOW_HARDNESS = 0.95
_ENDS = ("", "_lower", "_upper")


def evaluate(
    source: str | Path | xr.DataArray | Sequence[xr.DataArray],
    *,
    lay: str | None = None,
    along: xr.DataArray | Sequence[xr.DataArray] = (),
    level: Mapping[str, Any] | None = None,
    window: Mapping[str, Any] | None = None,
    contact: Mapping[str, Any] | None = None,
    statistics: Mapping[str, Any] | None = None,
    uncertainty: Mapping[str, Any] | None = None,
    instrument: Mapping[str, Any] | None = None,
    form: Mapping[str, Any] | None = None,
    threads: int = 1,
    **file: Any,
) -> xr.Dataset:
    """Read, level, window, solve and count one map, and return its statistics with their intervals.

    Parameters
    ----------
    source : str, Path or DataArray (y, x), m
        a measured file, or a height map as `read_height_map` or `height_map` returns it; or a list of
        profiles of one finish, which have one answer where it is isotropic or others are `along` its lay.
    lay : {"across", "none"}, optional
        of a profile: whether it was measured across a lay, and is solved as endless ridges, or the surface
        has none, and surfaces with its spectrum are solved (`surface_from_profiles`).
    along : DataArray or sequence of DataArray (1, x), m, optional
        with `lay` "across", profiles along the lay, of any pitch: a surface with both is solved.
    level, window, contact, statistics, uncertainty, instrument, form : mapping, optional
        sections of the configuration, with numbers possibly as text with a unit ("115 GPa"); missing keys
        have their defaults. `contact` states the elasticity, as `contact_modulus` or `bodies`.
    threads : int
        threads of the solver.
    **file
        what a file does not say, as for `read_height_map`: ``channel="Height"``, ``missing_value=-9999``.

    Returns
    -------
    Dataset
        dims (load, ...), the content of statistics.nc: `{quantity}` for each load, `{quantity}_uncertainty`
        (load, source), `{quantity}_lower` and `{quantity}_upper` (load), numbers of the map, SI units, and
        the flag `verdict` (load): 0 use, 1 review, 2 do not use. Its attributes hold settings, versions, for
        a file its checksum, and `reasons`, JSON: a list of ``{"check", "loads", "text"}``, the checks that
        did not pass, each with the indices of the loads concerned and a sentence.

    Raises
    ------
    SettingsError
        for settings that the configuration does not accept.
    InputFileError
        for a file that cannot be read.
    HeightMapError
        for a map that cannot be levelled, windowed or solved.
    ConvergenceError
        where a load misses the tolerance and `contact` says ``on_failure: raise``.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> found = evaluate(
    ...     rough_reference_surface(64),
    ...     contact={"contact_modulus": "1 GPa", "relative_pressure": 0.1},
    ...     uncertainty={"sources": ["solver"]},
    ... )
    >>> f"{found['relative_contact_area'].item():.2f}"
    '0.21'
    >>> bool(found["mean_gap_lower"] <= found["mean_gap"])
    True
    >>> int(found["verdict"].item()), found["verdict"].attrs["flag_meanings"]
    (2, 'use review do_not_use')
    """
    if lay is not None:
        check_lay(lay)
    if isinstance(source, Sequence) and not isinstance(source, str):
        source = stacked(source)
    elif not isinstance(source, str | PathLike):
        source = labelled_in_si(check_labelled(source))
    sections = {
        "level": level,
        "window": window,
        "contact": contact,
        "statistics": statistics,
        "uncertainty": uncertainty,
        "instrument": instrument,
        "form": form,
    }
    if file and isinstance(source, xr.DataArray):
        raise SettingsError(f"{', '.join(file)}: of a file, the source is a map; read it with them")
    stated = {section: listed(values) for section, values in sections.items() if values is not None}
    full = resolve(stated)[""]
    if full["contact"]["unload"] is not None:
        text = "contact.unload: is of a run; give the result of solve_contact to rc.unload, or leave it out"
        raise SettingsError(text, keys=["contact.unload"])
    height = source if isinstance(source, xr.DataArray) else read_height_map(source, **file)
    if lay is not None:
        height = height.assign_attrs(lay=lay)
    if len(along) and lay != "across":
        raise SettingsError(
            f"along: is of a surface with a lay, and lay = {lay!r}; state lay = 'across'", keys=["lay"]
        )
    height = stacked(height, along) if len(along) else height
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HeightMapWarning)  # of every solution; said once below
        result = run_chain(height, full, threads=threads)
    warn_of_map(result.window.shape, float(result.statistics["rms_gradient"]), stacklevel=3)
    return result.statistics


def contact_table(
    window: xr.DataArray,
    *,
    contact_modulus: float | str | None = None,
    bodies: Sequence[str | Mapping[str, Any]] | None = None,
    loads: int = 16,
    threads: int = 1,
    **contact: Any,
) -> xr.Dataset:
    """Return the contact of a periodic map over its mean gap, for codes of lubrication and structures.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic, of `periodic_window`.
    contact_modulus : float or str, Pa, optional
        E*, or `bodies`.
    bodies : sequence of two, optional
        names of materials, or mappings as in the settings.
    loads : int
        from a contact of about a thousandth of the area to one that is nearly closed, or to 0.95 of the
        hardness, where `contact` states none.
    threads : int
        of the solver.
    **contact
        further settings of the section `contact`, such as `hardness`.

    Returns
    -------
    Dataset
        over `mean_gap` (m), falling: `mean_pressure` (Pa), `relative_contact_area`, `contact_stiffness` (Pa
        m-1), `conductance_per_conductivity` (m-1), `pressure_flow_factor_x`, `_y` and `shear_flow_factor_x`,
        `_y` [1]_ [2]_, with `{name}_lower` and `_upper`. Those of area and conductance are of the load of the
        row, those of the stiffness follow from the conductance, to which it is proportional [3]_. Pressure
        and flow factors are those of a gap: their ends enclose the values of all loads whose interval of the
        mean gap holds that of the row. NaN: no ±, as of the pressure above that of the heaviest load. With
        plates at the mean gap h the flow along x is -phi_p h^3/(12 eta) dp/dx + U/2 (h + sigma phi_s), U the
        speed of the rough face; sigma is the attribute `rms_height`.

    References
    ----------
    .. [1] Patir and Cheng (1978), ASME J. Lubr. Technol. 100, 12.
    .. [2] Patir and Cheng (1979), ASME J. Lubr. Technol. 101, 220.
    .. [3] Barber (2003), Proc. R. Soc. A 459, 53.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> table = contact_table(rough_reference_surface(64), contact_modulus="1 GPa", loads=4, tolerance=1e-3)
    >>> table["relative_contact_area"].values.round(2), table["pressure_flow_factor_x"].values.round(2)
    (array([0.  , 0.04, 0.3 , 1.  ]), array([0.84, 0.78, 0.14, 0.  ]))
    """
    if not isinstance(loads, int | np.integer) or loads < 1:
        raise SettingsError(f"loads = {loads!r}: give a whole number of rows, 1 or more", keys=["loads"])
    if contact.get("boundary") == "free":
        raise SettingsError(
            "boundary = 'free': a body of finite size has no mean gap; give a periodic map", keys=["boundary"]
        )
    window = labelled_in_si(check_labelled(window))
    contact |= {"contact_modulus": contact_modulus, "bodies": bodies}
    stated = {key: value for key, value in contact.items() if value is not None}
    if not stated.keys() & {"mean_pressure", "relative_pressure", "force"}:
        solver = resolve({"contact": stated})[""]["contact"]
        scale = solver["contact_modulus"] * rms_gradient(window)
        limit = _BELOW_HARDNESS * (solver["hardness"] or np.inf)
        heaviest = _HEAVIEST if _HEAVIEST * scale < limit else limit / scale
        stated["relative_pressure"] = (heaviest * np.geomspace(_LIGHTEST, 1, loads)).tolist()
    statistics = evaluate(
        window,
        level={"form": "none", "line_alignment": "none", "outlier_threshold": None},
        window={"method": "raw"},
        contact=stated,
        statistics={"flow": "always"},
        threads=threads,
    )
    return over_mean_gap(statistics)


def over_mean_gap(statistics: xr.Dataset) -> xr.Dataset:
    """Return the statistics of one surface, with their flow factors, as `contact_table` does."""
    if "flow_factor_xx" not in statistics or "surface" in statistics.dims:
        raise SettingsError(
            "the statistics are to be of one surface with flow factors (statistics.flow: always)"
        )
    statistics = statistics.sortby("mean_gap", ascending=False)
    gap, sigma = statistics["mean_gap"].values, float(statistics["rms_height"])
    columns = {"mean_pressure": _at_stated_gaps(statistics, "mean_pressure", closed=np.nan, far=0.0)}
    for name in ("relative_contact_area", "contact_stiffness", "conductance_per_conductivity"):
        columns[name] = _with_ends(statistics, name)
    conductance, *conductance_ends = columns["conductance_per_conductivity"]
    with np.errstate(invalid="ignore"):  # both are infinite in full contact
        columns["contact_stiffness"][1:] = columns["contact_stiffness"][0] * (conductance_ends / conductance)
    for axis in "xy":
        pressure_flow = _at_stated_gaps(statistics, f"flow_factor_{axis}{axis}", closed=0.0, far=1.0)
        shear_flow = _at_stated_gaps(statistics, f"shear_flow_{axis}", closed=1.0, far=0.0)
        columns[f"pressure_flow_factor_{axis}"] = pressure_flow
        columns[f"shear_flow_factor_{axis}"] = shear_flow * gap / sigma
    rows = {f"{name}{end}": row for name in columns for end, row in zip(_ENDS, columns[name], strict=True)}
    table = xr.Dataset({name: ("mean_gap", row) for name, row in rows.items()}, {"mean_gap": gap})
    return describe(table.assign_attrs(rms_height=sigma))


def _with_ends(statistics: xr.Dataset, name: str) -> np.ndarray:
    """Return a quantity and both ends of its interval (3, load), NaN where they are not known."""
    unknown = np.full(statistics["load"].size, np.nan)
    return np.array([statistics.get(f"{name}{end}", unknown) for end in _ENDS])


@np.errstate(divide="ignore")  # where the gap is closed
def _at_stated_gaps(statistics: xr.Dataset, name: str, *, closed: float, far: float) -> np.ndarray:
    """Return a quantity and its ends (3, load) at the gaps of the loads, which fall.

    A stated gap may be that of any load whose interval of the gap holds it; beyond the loads that were
    solved the quantity is that of a closed gap, or of faces far apart.
    """
    values, (gap, lower, upper) = statistics[name].values, _with_ends(statistics, "mean_gap")
    if not (lower > 0).any():
        return np.array([values, *np.full((2, gap.size), np.nan)])
    lower, upper = np.nan_to_num(lower, nan=0.0), np.nan_to_num(upper, nan=np.inf)
    possible = np.where((lower <= gap[:, None]) & (gap[:, None] <= upper), values, values[:, None])
    heavier, lighter = (
        np.interp(np.log(gap), np.log(end[end > 0])[::-1], values[end > 0][::-1], closed, far)
        for end in (upper, lower)
    )
    smallest = np.fmin(possible.min(axis=1), heavier)
    largest = np.fmax(possible.max(axis=1), lighter)
    return np.array([values, np.minimum(smallest, lighter), np.maximum(largest, heavier)])
