"""The public verb: a map, a modulus and some loads in, a labelled dataset out."""

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr

from roughcontact.checking import check_choice
from roughcontact.choices import SMALLEST_TOLERANCE, Influence, OnFailure, Precision, ZeroFrequency
from roughcontact.contact.loads import check_loads
from roughcontact.contact.problem import Problem, check_positive, on_host, pose
from roughcontact.contact.sweep import sweep
from roughcontact.elasticity.halfspace import zero_frequency_compliance
from roughcontact.errors import ConvergenceError, SettingsError
from roughcontact.kernels.arrays import DOUBLE, SINGLE, empty
from roughcontact.kernels.choose import kernels_for
from roughcontact.variables import describe

# keyword arguments of `solve_contact` that a section of settings may hold
SOLVER_SETTINGS = ("tolerance", "hardness", "influence", "zero_frequency", "precision", "on_failure")


def solve_contact(
    window: xr.DataArray,
    *,
    contact_modulus: float,
    mean_pressure: float | Sequence[float],
    tolerance: float = 1e-4,
    hardness: float | None = None,
    influence: Influence = "sampled",
    zero_frequency: ZeroFrequency = "zero",
    precision: Precision = "double",
    on_failure: OnFailure = "raise",
    fields: bool = True,
    reduce: Callable[[xr.Dataset], xr.Dataset] | None = None,
    threads: int = 1,
    progress: Callable[[int, int, str], None] | None = None,
) -> xr.Dataset:
    """Solve the frictionless contact of a periodic rough map with an elastic half-space, load by load.

    Finds p >= 0 with gap = G p - h + approach >= 0, p gap = 0 and mean(p) = mean_pressure, where
    G(q) = 2/(E* |q|) (Johnson 1985; Polonsky and Keer 1999 for the discrete problem).

    Parameters
    ----------
    window
        heights (y, x) in m (any unit of length that the coordinates share), periodic, no NaN. A single row or
        column is a profile, solved in one dimension. Heights in an array of CuPy, or of another library that
        keeps to the Python array API, are solved by that library, where they are; the result is NumPy's.
    contact_modulus
        E* in Pa (any unit of pressure that the loads share).
    mean_pressure
        one load or several, Pa, in any order; the dimension `load` keeps the order.
    tolerance
        largest `error_bound` accepted: relative error of the pressure in the norm of the elastic energy.
    hardness
        largest pressure, Pa, that the softer body carries before it yields: 0 <= p <= hardness, perfectly
        plastic beyond (Almqvist, Sahlin, Larsson and Glavatskih 2007, Tribol. Int. 40, 574). None: elastic
        whatever the pressure.
    influence
        ``sampled``: 2/|q| at the waves of the grid; ``elements``: pressures constant on every pixel
        (`roughcontact.elasticity.influence`).
    precision
        of the result: ``double``, or ``single`` for maps that fill the memory; `rounding_floor` then says
        what bound can be reached.
    zero_frequency
        what q = 0 adds to the approach: ``zero``, ``nogi-kato`` or ``lattice``
        (`roughcontact.elasticity.halfspace.zero_frequency_compliance`).
    on_failure
        ``raise`` ConvergenceError for a load that misses the tolerance, or ``flag`` it (`converged` = 0).
    fields
        keep `pressure`, `gap`, `contact` and `height` in the result.
    reduce
        called with the dataset of each load (fields included); what it returns replaces the fields, so that
        statistics need not keep them: ``reduce=contact_statistics``.
    threads
        threads of the solve; a forked process takes one.
    progress
        called as ``progress(done, total, text)`` after every load.

    Returns
    -------
    Dataset
        with dimension `load` and the variables of `roughcontact.variables`.

    Raises
    ------
    HeightMapError
        for a map with missing points, uneven spacing or a single pixel.
    SettingsError
        for a modulus, load, tolerance or rule that has no meaning.
    ConvergenceError
        where a load does not reach the tolerance and `on_failure` is ``raise``.
    """
    modulus = check_positive("contact_modulus", contact_modulus, unit="Pa")
    loads = check_loads("mean_pressure", mean_pressure, unit="Pa")
    if not SMALLEST_TOLERANCE <= tolerance < 1:
        raise SettingsError(
            f"tolerance = {tolerance!r} must lie between {SMALLEST_TOLERANCE:g} and 1; "
            "1e-4 serves most purposes"
        )
    check_choice("on_failure", on_failure, OnFailure)
    check_choice("influence", influence, Influence)
    check_choice("precision", precision, Precision)
    cap = np.inf if hardness is None else check_positive("hardness", hardness, unit="Pa")
    if max(loads) >= cap:
        raise SettingsError(
            f"mean_pressure {max(loads):g} Pa is not below the hardness {cap:g} Pa: no contact carries it",
            keys=("mean_pressure",),
        )
    working = DOUBLE if precision == "double" else SINGLE
    problem, window = pose(window, precision=working, threads=threads), on_host(window)
    lengths = tuple(length * problem.unit_length for length in problem.lengths)
    compliance = zero_frequency_compliance(zero_frequency, lengths=lengths) / modulus

    order = np.argsort(loads, kind="stable")
    unit = modulus * problem.gradient if not problem.flat else modulus
    solutions = sweep(
        problem,
        [loads[i] / unit for i in order],
        tolerance=tolerance,
        cap=cap / unit,
        influence=influence,
        precision=working,
        threads=threads,
    )
    pieces = [None] * len(loads)
    for done, (index, solution) in enumerate(zip(order, solutions, strict=True), start=1):
        load = loads[index]
        if solution.error_bound > tolerance and on_failure == "raise":
            raise ConvergenceError(
                f"mean pressure {load:g} Pa: the error bound stopped at {solution.error_bound:.2g} after "
                f"{solution.steps} iterations, above the tolerance {tolerance:g}; rounding in {precision} "
                f"precision allows {solution.floor:.1g} here: raise the tolerance or set on_failure: flag"
            )
        piece = _label(
            solution,
            problem,
            window,
            load=load,
            modulus=modulus,
            compliance=compliance,
            hardness=hardness,
            attrs={"tolerance": tolerance, "zero_frequency": zero_frequency, "influence": influence},
            threads=threads,
        )
        if reduce is not None:
            reduced = reduce(piece)
            piece = piece.drop_dims(["y", "x"]).merge(reduced, compat="override", combine_attrs="override")
        elif not fields:
            piece = piece.drop_dims(["y", "x"])
        pieces[index] = piece
        if progress is not None:
            progress(done, len(loads), f"mean pressure {load:.4g} Pa")
    del solutions  # and with them their workspace
    return describe(pieces[0] if len(pieces) == 1 else _joined(pieces))


def _joined(pieces) -> xr.Dataset:
    """Return the datasets of the loads as one."""
    return xr.concat(
        pieces,
        dim="load",
        data_vars="minimal",
        coords="minimal",
        compat="override",
        join="override",
        combine_attrs="override",
    )


def _label(
    solution, problem: Problem, window, *, load, modulus, compliance, hardness, attrs, threads
) -> xr.Dataset:
    """Return one dimensionless solution as a dataset in SI units, with a dimension `load` of size 1.

    Points at the hardness have yielded until the gap was closed: it is zero there.
    """
    state = solution.state
    height_unit = problem.scale if not problem.flat else 1.0
    pressure_unit = modulus * problem.gradient if not problem.flat else modulus
    # in place: nobody needs the dimensionless fields any more
    pressure, gap = (
        on_host(xr.Variable(("y", "x"), field)).values for field in (state.pressure, state.separation)
    )
    contact = empty(pressure, "int8")
    least_gap, total = kernels_for(pressure, threads=threads).restore_units(
        pressure, gap, state.offset, pressure_unit, height_unit, contact
    )
    yielded = 0.0
    if hardness is not None:
        kind = pressure.dtype.type
        at_hardness = pressure >= kind(hardness * (1 - 8 * float(np.finfo(kind).eps)))
        pressure[at_hardness], gap[at_hardness] = hardness, 0.0
        yielded, least_gap = float(at_hardness.mean()), float(gap.min())
    per_load = {
        "relative_pressure": load / pressure_unit if not problem.flat else np.inf,
        "approach": problem.reference - state.offset * height_unit - compliance * load,
        "iterations": solution.steps,
        "operator_applications": solution.applications,
        "error_bound": solution.error_bound,
        "rounding_floor": solution.floor,
        "yielded_area": yielded,
        "max_penetration": max(0.0, -least_gap),
        "converged": np.int8(solution.error_bound <= attrs["tolerance"]),
        "load_error": abs(total / pressure.size / load - 1),
    }
    maps = {
        "pressure": pressure,
        "gap": gap,
        "contact": contact,
    }
    return xr.Dataset(
        {name: (("load", "y", "x"), field[None]) for name, field in maps.items()}
        | {name: ("load", [value]) for name, value in per_load.items()}
        | {"height": window.variable, "contact_modulus": modulus},
        coords={"mean_pressure": ("load", [load]), **window.coords},
        attrs=attrs,
    )
