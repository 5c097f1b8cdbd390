"""One call from a measured file to its numbers, with the settings of the configuration."""

import warnings
from collections.abc import Mapping, Sequence
from inspect import signature
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ENDS
from roughcontact.arguments.checking import check_labelled, warn_of_map, warn_of_unit
from roughcontact.arguments.kinds import facts_of
from roughcontact.arguments.settings.fields import fields_at
from roughcontact.arguments.settings.messages import nearest
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.si import labelled_in_si, listed
from roughcontact.arguments.variables import describe, has_number
from roughcontact.contact.problem import warn_of_seams
from roughcontact.errors import HeightMapWarning, SettingsError
from roughcontact.evaluation.creep import moduli_after
from roughcontact.evaluation.pipeline import Progress, run_chain, silent, with_positions
from roughcontact.io.read import read_height_map
from roughcontact.surface.profiles.surface import stacked, with_lay
from roughcontact.surface.roughness.parameters import rms_gradient

_HEAVIEST = 2.0  # E* times the rms gradient: nearly closed
_LIGHTEST = 5e-4  # of the heaviest load: first contact
_BELOW_HARDNESS = 0.95


def evaluate(
    source: str | Path | xr.DataArray | Sequence[xr.DataArray],
    *,
    lay: str | None = None,
    along: xr.DataArray | Sequence[xr.DataArray] = (),
    overview: str | Path | xr.DataArray | Sequence[str | Path | xr.DataArray] | None = None,
    overview_position: str = "",
    level: Mapping[str, Any] | None = None,
    window: Mapping[str, Any] | None = None,
    contact: Mapping[str, Any] | None = None,
    statistics: Mapping[str, Any] | None = None,
    uncertainty: Mapping[str, Any] | None = None,
    instrument: Mapping[str, Any] | None = None,
    form: Mapping[str, Any] | None = None,
    threads: int = 1,
    progress: Progress = silent,
    **options: Any,
) -> xr.Dataset:
    """Read, level, window and solve one map, and return its statistics with their intervals.

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
    overview : str, Path or DataArray (y, x), m, or a sequence of them, optional
        a coarser map of a larger field of the same face, around the map: the results are then those of the
        surface over this field, and `{quantity}_joint` is that of a joint as large as it.
    overview_position : str, optional
        x and y of the middle of the map in the overview ("300 250 um"), where it cannot be found, or
        "elsewhere": the overview is of another position of the face, and the ± larger. Of several overviews
        one for each, between semicolons.
    level, window, contact, statistics, uncertainty, instrument, form : mapping, optional
        sections of the configuration, with numbers possibly as text with a unit ("115 GPa"); missing keys
        have their defaults. `contact` states the elasticity, as `contact_modulus` or `bodies`.
    threads : int
        threads of the solver.
    progress : callable, optional
        called with the loads that are done, their number (None before it is known) and what is going on.
    **options
        keys of the section `contact`, without it: ``contact_modulus="1 GPa"``; and what a file does not say,
        as for `read_height_map`: ``channel="Height"``, ``missing_value=-9999``.

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
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> result = evaluate(
    ...     rough_reference_surface(64),
    ...     contact_modulus="1 GPa",
    ...     relative_pressure=0.1,
    ...     uncertainty={"sources": ["solver"]},
    ... )
    >>> f"{result['relative_contact_area'].item():.2f}"
    '0.21'
    >>> bool(result["mean_gap_lower"] <= result["mean_gap"])
    True
    >>> int(result["verdict"].item()), result["verdict"].attrs["flag_meanings"]
    (2, 'use review do_not_use')
    """
    contact, file = _sort_options(contact, options)
    if isinstance(source, Sequence) and not isinstance(source, str):
        source = stacked(source)  # profiles of one surface
    elif not isinstance(source, str | PathLike):
        warn_of_unit(check_labelled(source), stacklevel=3)
        source = labelled_in_si(source)
    sections = {"level": level, "window": window, "contact": contact, "statistics": statistics}
    sections |= {"uncertainty": uncertainty, "instrument": instrument, "form": form}
    if file and isinstance(source, xr.DataArray):
        raise SettingsError(f"{', '.join(file)}: of a file, the source is a map; read it with them")
    # arrays and units are settled before the settings are checked
    given_sections = {section: listed(values) for section, values in sections.items() if values is not None}
    full = resolve(given_sections)[""]
    if full["contact"]["unload"] is not None:
        text = "contact.unload: is of a run; give the result of solve_contact to rc.unload, or leave it out"
        raise SettingsError(text, keys=["contact.unload"])
    height = source if isinstance(source, xr.DataArray) else read_height_map(source, **file)
    height = with_lay(height, lay, along)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HeightMapWarning)  # of every solution; said once below
        if isinstance(overview, Sequence) and not isinstance(overview, str):
            fields = [*overview]
        else:
            fields = [] if overview is None else [overview]
        overviews = with_positions(fields, overview_position)
        result = run_chain(height, full, threads=threads, progress=progress, overviews=overviews)
    warn_of_map(result.window.shape, float(result.statistics["rms_gradient"]), stacklevel=3)
    return result.statistics


def _sort_options(
    contact: Mapping[str, Any] | None, options: Mapping[str, Any]
) -> tuple[Mapping[str, Any] | None, dict[str, Any]]:
    """Return the section `contact` with the keys that are given beside it, and what a file does not say."""
    contact_keys = {key: value for key, value in options.items() if key in fields_at(["contact"])}
    file = {key: value for key, value in options.items() if key not in contact_keys}
    for key in file.keys() - signature(read_height_map).parameters.keys():
        sections = [section for section in Settings.model_fields if key in fields_at([section])]
        way = (
            f"give it as {sections[0]}={{{key!r}: ...}}" if sections else nearest(key, fields_at(["contact"]))
        )
        raise SettingsError(f"{key}: is no key of the section contact, {way}", keys=[key])
    # one key at two places would hide which of them counts
    if twice := [key for key in contact_keys if key in (contact or {})]:
        raise SettingsError(f"{twice[0]}: is given twice, also in contact={{...}}; leave one out", keys=twice)
    return {**(contact or {}), **contact_keys} if contact_keys else contact, file


def contact_table(
    window: xr.DataArray,
    *,
    contact_modulus: float | str | None = None,
    bodies: Sequence[str | Mapping[str, Any]] | None = None,
    loads: int = 16,
    threads: int = 1,
    progress: Progress = silent,
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
    progress : callable, optional
        as of `evaluate`: of large maps the flow through the gap takes most of the time.
    **contact
        further settings of the section `contact`, such as `hardness`.

    Returns
    -------
    Dataset
        over `mean_gap` (m), falling: `mean_pressure` (Pa), `relative_contact_area`, `contact_stiffness` (Pa
        m-1), `conductance_per_conductivity` (m-1), `thermal_conductance` (W m-2 K-1) where the bodies state
        their conductivity, `pressure_flow_factor_x`, `_y` and `shear_flow_factor_x`, `_y` [1]_ [2]_, with
        `{name}_lower` and `_upper`. Those of area and conductance are of the load of the
        row, those of the stiffness follow from the conductance, to which it is proportional [3]_. Pressure
        and flow factors are those of a gap: their ends enclose the values of all loads whose interval of the
        mean gap holds that of the row. NaN: no ±, as of the pressure above that of the heaviest load.
        `approach` (m): place of the bodies, by whose fall they come closer; where points flow it falls more
        than the gap, by the mean depth of the flow (with `zero_frequency: zero`, the default). With
        plates at the mean gap h the flow along x is -phi_p h^3/(12 eta) dp/dx + U/2 (h + sigma phi_s), U the
        speed of the rough face; sigma is the attribute `rms_height`.

    References
    ----------
    .. [1] Patir and Cheng (1978), ASME J. Lubr. Technol. 100, 12.
    .. [2] Patir and Cheng (1979), ASME J. Lubr. Technol. 101, 220.
    .. [3] Barber (2003), Proc. R. Soc. A 459, 53.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> table = contact_table(rough_reference_surface(64), contact_modulus="1 GPa", loads=4, tolerance=1e-3)
    >>> table["relative_contact_area"].values.round(2), table["pressure_flow_factor_x"].values.round(2)
    (array([0.  , 0.04, 0.3 , 1.  ]), array([0.84, 0.78, 0.14, 0.  ]))
    """
    if not isinstance(loads, int | np.integer) or loads < 1:
        raise SettingsError(f"loads = {loads!r}: give a whole number of rows, 1 or more", keys=["loads"])
    facts_of(contact).check_arguments(["contact_table"])
    window = labelled_in_si(check_labelled(window))
    warn_of_seams(window, rms_gradient(window), stacklevel=3)
    contact |= {"contact_modulus": contact_modulus, "bodies": bodies}
    given_settings = {key: value for key, value in contact.items() if value is not None}
    solver = resolve({"contact": given_settings})[""]["contact"]
    if moduli_after(solver):
        text = "each time has a table of its own; give the modulus after one as youngs_modulus"
        raise SettingsError(f"contact_table: the bodies creep, and {text}", keys=["contact.time"])
    if not given_settings.keys() & {"mean_pressure", "relative_pressure", "force"}:
        # planned for the map: from the first touch to nearly closed, or to the hardness
        scale = solver["contact_modulus"] * rms_gradient(window)
        limit = _BELOW_HARDNESS * (solver["hardness"] or np.inf)
        heaviest = _HEAVIEST if _HEAVIEST * scale < limit else limit / scale
        given_settings["relative_pressure"] = (heaviest * np.geomspace(_LIGHTEST, 1, loads)).tolist()
    statistics = evaluate(
        window,
        # the window is solved as it is given
        level={"form": "none", "line_alignment": "none", "outlier_threshold": None},
        window={"method": "raw"},
        contact=given_settings,
        statistics={"flow": "always"},
        threads=threads,
        progress=progress,
    )
    return tabulate_by_gap(statistics)


def tabulate_by_gap(statistics: xr.Dataset) -> xr.Dataset:
    """Return the statistics of one surface, with their flow factors, as `contact_table` does."""
    if "flow_factor_xx" not in statistics or "surface" in statistics.dims:
        raise SettingsError(
            "the statistics are to be of one surface with flow factors: solve it with --flow always, or with "
            "flow: always in the section statistics"
        )
    if has_number(statistics, "mean_gap_alone"):
        raise SettingsError(
            "the mean gap is that of the surface over an overview, the flow factors are of the map: solve it "
            "without the overview"
        )
    # from the first touch to the closed gap, as codes of lubrication read it
    statistics = statistics.sortby("mean_gap", ascending=False)
    gap, sigma = statistics["mean_gap"].values, float(statistics["rms_height"])
    columns = {"mean_pressure": _interpolate_to_gaps(statistics, "mean_pressure", at_contact=np.nan, far=0.0)}
    of_load = ["relative_contact_area", "contact_stiffness", "conductance_per_conductivity"]
    of_load += [name for name in ("thermal_conductance", "joint_conductance") if name in statistics]
    for name in of_load:
        columns[name] = _value_and_bounds(statistics, name)
    conductance, *conductance_ends = columns["conductance_per_conductivity"]
    with np.errstate(invalid="ignore"):  # both are infinite in full contact
        columns["contact_stiffness"][1:] = columns["contact_stiffness"][0] * (conductance_ends / conductance)
    for axis in "xy":
        pressure_flow = _interpolate_to_gaps(statistics, f"flow_factor_{axis}{axis}", at_contact=0.0, far=1.0)
        shear_flow = _interpolate_to_gaps(statistics, f"shear_flow_{axis}", at_contact=1.0, far=0.0)
        columns[f"pressure_flow_factor_{axis}"] = pressure_flow
        columns[f"shear_flow_factor_{axis}"] = shear_flow * gap / sigma
    rows = {f"{name}{key}": row for name in columns for key, row in zip(ENDS, columns[name], strict=True)}
    # of the finer pixels that the gap is of; where points flow it falls more than the gap, by their depth
    shift = gap - statistics.get("mean_gap_as_solved", statistics["mean_gap"]).values
    rows["approach"] = statistics["approach"].values + shift
    table = xr.Dataset({name: ("mean_gap", row) for name, row in rows.items()}, {"mean_gap": gap})
    return describe(table.assign_attrs(rms_height=sigma))


def _value_and_bounds(statistics: xr.Dataset, name: str) -> np.ndarray:
    """Return a quantity and both ends of its interval (3, load), NaN where they are not known."""
    nan_values = np.full(statistics["load"].size, np.nan)
    return np.array([statistics.get(f"{name}{key}", nan_values) for key in ENDS])


@np.errstate(divide="ignore")  # where the gap is closed
def _interpolate_to_gaps(statistics: xr.Dataset, name: str, *, at_contact: float, far: float) -> np.ndarray:
    """Return a quantity and its ends (3, load) at the gaps of the loads, which fall.

    A stated gap may be that of any load whose interval of the gap holds it; beyond the loads that were
    solved the quantity is that of a closed gap, or of faces far apart.
    """
    values, (gap, lower, upper) = statistics[name].values, _value_and_bounds(statistics, "mean_gap")
    # without an interval of the gap nothing is interpolated
    if not (lower > 0).any():
        return np.array([values, *np.full((2, gap.size), np.nan)])
    lower, upper = np.nan_to_num(lower, nan=0.0), np.nan_to_num(upper, nan=np.inf)
    possible = np.where((lower <= gap[:, None]) & (gap[:, None] <= upper), values, values[:, None])
    # in logarithms, in which quantities of a contact are nearly straight over the gap
    heavier, lighter = (
        np.interp(np.log(gap), np.log(bound[bound > 0])[::-1], values[bound > 0][::-1], at_contact, far)
        for bound in (upper, lower)
    )
    smallest = np.fmin(possible.min(axis=1), heavier)
    largest = np.fmax(possible.max(axis=1), lighter)
    ends = np.minimum(smallest, lighter), np.maximum(largest, heavier)
    # from the closed gap to faces far apart: nothing is known
    highest = np.inf if np.isnan(at_contact) else max(at_contact, far)
    is_known = (ends[0] > np.fmin(at_contact, far)) | (ends[1] < highest)
    return np.array([values, *np.where(is_known, ends, np.nan)])
