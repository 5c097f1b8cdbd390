"""The public function: from a map, a modulus and some loads to a labelled dataset."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments import choices
from roughcontact.arguments.bodies import check_bodies
from roughcontact.arguments.checking import check_positive, warn_of_map
from roughcontact.arguments.kinds import FINITE_BODY, PERIODIC_MAP, facts_of
from roughcontact.arguments.maps import dimensions
from roughcontact.arguments.materials import contact_modulus as modulus_of
from roughcontact.arguments.measurement import json_attributes
from roughcontact.arguments.si import as_si
from roughcontact.arguments.variables import describe
from roughcontact.contact.dataset import FieldsInUnits, fields_in_units, joined, load_result, unit_of_pressure
from roughcontact.contact.elasticity.halfspace import zero_frequency_compliance
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.media import elastic_medium
from roughcontact.contact.free_boundary import free_solutions
from roughcontact.contact.iteration import Solution
from roughcontact.contact.loads import check_loads
from roughcontact.contact.problem import Problem, copy_to_host, nondimensionalise, warn_of_seams
from roughcontact.contact.sweep import sweep
from roughcontact.errors import ConvergenceError, RoughContactError, SettingsError
from roughcontact.kernels.arrays import DOUBLE, SINGLE

# Loads in units of E* g: below, the rounding of the heights hides the contact, whose relative deformation is
# p/(E* g); above, the rounding of the load hides the waves of the pressure, which are as large as E* g.
MIN_LOAD, MAX_LOAD = 1e-10, 1e10
NEAR_HARDNESS = 1e-6  # relative distance from the hardness that a search in single precision resolves

# keyword arguments of `solve_contact` that a section of settings may hold
SOLVER_SETTINGS = ("tolerance", "hardness", "influence", "zero_frequency", "precision", "on_failure")


@as_si
def solve_contact(
    window: xr.DataArray,
    *,
    contact_modulus: float | str | None = None,
    mean_pressure: float | str | Sequence[float | str] | None = None,
    boundary: choices.Boundary = "periodic",
    force: float | str | Sequence[float | str] | None = None,
    bodies: Sequence[Mapping[str, Any]] | None = None,
    tolerance: float = 1e-4,
    hardness: float | None = None,
    influence: choices.Influence = "sampled",
    zero_frequency: choices.ZeroFrequency = "zero",
    precision: choices.Precision = "double",
    on_failure: choices.OnFailure = "raise",
    fields: bool = True,
    reduce: Callable[[xr.Dataset], xr.Dataset] | None = None,
    arrays: Callable[[np.ndarray], Any] | None = None,
    threads: int = 1,
    progress: Callable[[int, int, str], None] | None = None,
) -> xr.Dataset:
    """Solve the frictionless contact of a periodic rough map with an elastic half-space, load by load.

    Finds p >= 0 with gap = G p - h + approach >= 0, p gap = 0 and mean(p) = mean_pressure, where
    G(q) = 2/(E* |q|) [1]_ [2]_, or that of bodies with bonded layers (`contact.elasticity.layers`).

    Parameters
    ----------
    window : DataArray (y, x), m
        heights (without `units`: of any unit that the coordinates share), periodic, no NaN. A single row or
        column is a profile, solved in one dimension. Heights in an array of another library that follows the
        Python array API are solved by that library, on their device, as with `arrays`.
    contact_modulus : float or str, Pa
        E*, unless `bodies` are given; this and other numbers may be text with a unit, "115 GPa". Any unit of
        pressure that the loads share, where the map has no `units`.
    mean_pressure : float or sequence of float, Pa
        one load or several, in any order; the dimension `load` keeps the order. Not of a finite body.
    boundary : {"periodic", "free"}
        ``free``: the map is a body of finite size (a ball, a block) on the half-space, without neighbours
        [4]_; the approach is then absolute, and the `force` is given instead of the pressure.
    force : float or sequence of float, N
        one or several, for ``boundary="free"``; the coordinate `force` of the result.
    bodies : sequence of one or two mappings, optional
        instead of E*: `youngs_modulus` (Pa) and `poissons_ratio`, or `base` = "rigid", and `layers` from the
        surface inwards, each with `thickness` (m), `youngs_modulus`, `poissons_ratio`. E* is then that of the
        materials at the surfaces. A second body that is not given is rigid.
    tolerance : float
        largest `error_bound` accepted: relative error of the pressure in the norm of the elastic energy.
    hardness : float or None, Pa
        largest pressure that the softer body carries before it yields: 0 <= p <= hardness, perfectly plastic
        beyond [3]_. None: elastic whatever the pressure.
    influence : {"sampled", "elements"}
        ``sampled``: 2/|q| at the waves of the grid; ``elements``: pressures constant on every pixel
        (`roughcontact.contact.elasticity.influence`).
    zero_frequency : {"zero", "nogi-kato", "lattice"}
        rule for the mean displacement (q = 0) in the approach
        (`contact.elasticity.halfspace.zero_frequency_compliance`); ``zero`` leaves out that of elastic
        bases, never that of layers on a rigid base, which is known.
    precision : {"double", "single"}
        of the result; ``single`` for maps that fill the memory: `rounding_floor` is then the lowest bound
        that can be reached.
    on_failure : {"raise", "flag"}
        ``raise`` ConvergenceError for a load that misses the tolerance, or ``flag`` it (`converged` = 0).
    fields : bool
        keep `pressure`, `gap`, `contact` and `height` in the result.
    reduce : callable, optional
        called with the dataset of each load (fields included); its result replaces the fields, so that
        statistics need not keep them: ``reduce=contact_statistics``. Variables that
        `arguments.variables` does not have need the attributes `units` and `long_name`; without them they
        are refused after the first load.
    arrays : callable, optional
        brings an array of NumPy into another library and onto its device, where the solve then takes place:
        ``torch.asarray``. The result is NumPy's.
    threads : int
        threads of the solve; a forked process takes one.
    progress : callable, optional
        called as ``progress(done, total, text)`` after every load.

    Returns
    -------
    Dataset
        with dimension `load` and the variables of `roughcontact.arguments.variables`.

    Raises
    ------
    HeightMapError
        for a map with missing points, uneven spacing or a single pixel.
    SettingsError
        for a modulus, load, tolerance or rule that is invalid, in general or for this map, or below the
        rounding error; for a `reduce` that cannot be called.
    RoughContactError
        where `reduce` returns a variable without a description, or no Dataset.
    ConvergenceError
        where a load does not reach the tolerance and `on_failure` is ``raise``.

    Warns
    -----
    HeightMapWarning
        of a map of fewer than 16 points, steeper than any measured surface (rms gradient above 3), or not
        periodic: with a tilt, or a jump from its last line to its first.

    References
    ----------
    .. [1] Johnson (1985), Contact Mechanics, chapter 13.
    .. [2] Polonsky and Keer (1999), Wear 231, 206, for the discrete problem.
    .. [3] Almqvist, Sahlin, Larsson and Glavatskih (2007), Tribol. Int. 40, 574.
    .. [4] Vico, Greengard and Ferrando (2016), J. Comput. Phys. 323, 191, for the kernel that is cut off
       beyond the contact (`roughcontact.contact.elasticity.free_space`).

    Examples
    --------
    A wave of amplitude 1 um and wavelength 1 mm on a half-space of 1 GPa closes at pi E* D / lambda; at half
    of that load, half of it touches (Westergaard 1939):

    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 256), 1e-3 / 256, amplitude=1e-6, wavelength=1e-3)
    >>> contact = rc.solve_contact(wave, contact_modulus=1e9, mean_pressure=0.5 * np.pi * 1e6)
    >>> print(f"{contact.contact.mean().item():.2f}")
    0.50
    >>> bool(contact.error_bound <= 1e-4)
    True

    A ball of radius 10 mm under 1 N approaches by a^2/R, a^3 = 3 F R/(4 E*) (Hertz):

    >>> x = np.linspace(-1, 1, 128) * 0.3e-3
    >>> ball = rc.height_map(-(x[:, None] ** 2 + x**2) / 20e-3, x[1] - x[0])
    >>> contact = rc.solve_contact(ball, boundary="free", contact_modulus=1e9, force="1 N")
    >>> print(f"{-contact.approach.item() * 10e-3 / (0.75 * 10e-3 / 1e9) ** (2 / 3):.4f}")
    1.0000
    """
    material = elasticity(contact_modulus, bodies, influence, hardness)
    kind = facts_of({"boundary": boundary})
    given_loads = {"mean_pressure": mean_pressure, "force": force}
    unusual = {
        # the load of this kind is needed, others do not apply
        **{name: (load is None) == (name == kind.load) for name, load in given_loads.items()},
        "influence": influence != "sampled",
        "zero_frequency": zero_frequency != "zero",
        "precision": precision != "double",
        "arrays": arrays is not None,
    }
    kind.check_arguments([name for name in unusual if unusual[name]], material.medium.properties)
    load = given_loads[kind.load]
    loads = check_loads(kind.load, [] if load is None else load, unit=kind.load_unit)
    tolerance = check_positive("tolerance", tolerance, unit="relative terms")
    if not choices.MIN_TOLERANCE <= tolerance < 1:
        raise SettingsError(
            f"tolerance = {tolerance!r} must lie between {choices.MIN_TOLERANCE:g} and 1; 1e-4 serves most "
            "purposes"
        )
    if not threads >= 1:
        raise SettingsError(f"threads = {threads!r}: give a whole number of 1 or more")
    if reduce is not None and not callable(reduce):
        raise SettingsError(
            f"reduce = {reduce!r}: give a function of a Dataset, such as roughcontact.contact_statistics"
        )
    # rising, as the methods expect them; the result has the order of the argument
    order = np.argsort(loads, kind="stable")
    rising = [loads[index] for index in order]
    working = DOUBLE if precision == "double" else SINGLE
    problem = nondimensionalise(window, precision=working, arrays=arrays, threads=threads)
    window = copy_to_host(window)
    if window.dtype not in (np.float32, np.float64):  # differences of small integers would wrap around
        window = window.astype(float)
    method = METHODS[kind.name]
    method.check(problem, rising, material, window, zero_frequency)
    solutions = method.solutions(
        problem,
        rising,
        material,
        window=window,
        tolerance=tolerance,
        threads=threads,
        zero_frequency=zero_frequency,
        precision=working,
        give_up=on_failure == "raise",
    )
    rules = {"boundary": boundary, "zero_frequency": zero_frequency}
    attrs: dict[str, Any] = {"tolerance": tolerance, "influence": influence}
    attrs |= {name: value for name, value in rules.items() if name in kind.recorded}
    attrs |= json_attributes({"bodies": described} if (described := material.medium.as_settings()) else {})
    area = float(window.size * np.prod(problem.spacing))
    load_datasets: dict[int, xr.Dataset] = {}
    for number, (index, load) in enumerate(zip(order, rising, strict=True), start=1):
        # no other name refers to the fields of a load while the next one is solved
        load_dataset = load_result(
            *next(solutions),
            problem=problem,
            window=window,
            loads=kind.coordinates(load, area),
            elasticity=material,
            attrs=attrs,
        )
        load_in_words = kind.text_of_load(load)
        if on_failure == "raise" and not load_dataset["converged"].item():
            raise ConvergenceError(_missed(load_in_words, load_dataset, precision=precision))
        load_datasets[int(index)] = _kept(load_dataset, fields, reduce)
        del load_dataset
        if progress is not None:
            progress(number, len(loads), load_in_words)
    del solutions, problem  # and with them their workspace
    return describe(joined([load_datasets[index] for index in range(len(loads))]))


def elasticity(
    contact_modulus: float | str | None = None,
    bodies: Sequence[Mapping[str, Any]] | None = None,
    influence: choices.Influence = "sampled",
    hardness: float | None = None,
    **_: Any,
) -> Elasticity:
    """Return what four of the arguments of `solve_contact` say of the elasticity, in SI units."""
    limit = np.inf if hardness is None else check_positive("hardness", hardness, unit="Pa")
    if bodies is None:
        if contact_modulus is None:
            raise SettingsError("neither contact_modulus nor bodies given; give one of them")
        modulus = check_positive("contact_modulus", contact_modulus, unit="Pa")
        return Elasticity(modulus, influence, hardness=limit)  # E* alone stands for half-spaces
    pair = check_bodies(bodies)
    modulus = modulus_of(pair)
    if contact_modulus is not None:
        stated_modulus = check_positive("contact_modulus", contact_modulus, unit="Pa")
        if not math.isclose(stated_modulus, modulus, rel_tol=1e-6):  # as exactly as somebody would write it
            raise SettingsError(
                f"contact_modulus = {stated_modulus:g} Pa, but that of the bodies' surfaces is {modulus:g} "
                "Pa; give one of them",
                keys=["contact_modulus", "bodies"],
            )
    return Elasticity(modulus, influence, elastic_medium(pair), limit)


def periodic_solutions(
    problem: Problem,
    loads: Sequence[float],
    material: Elasticity,
    *,
    window: xr.DataArray | None = None,  # of which a periodic map needs the heights alone
    zero_frequency: choices.ZeroFrequency = "zero",
    threads: int,
    **options: Any,
) -> Iterator[tuple[FieldsInUnits, Any, float]]:
    """Yield fields, solution and approach (m) of each of the rising loads (Pa) of a periodic map."""
    # what the mean pressure displaces, which no operator includes (m/Pa): by the rule for the bases, and
    # layers
    compliance = zero_frequency_compliance(zero_frequency, lengths=problem.lengths_in_metres)
    compliance /= material.medium.base_modulus(material.modulus)
    compliance += material.medium.mean_compliance(elastic=zero_frequency != "zero")
    unit = unit_of_pressure(problem, material.modulus)
    scaled_pair, in_units_of_it = material.scaled(problem.unit_length, unit), [load / unit for load in loads]
    solutions = sweep(problem, in_units_of_it, scaled_pair, threads=threads, **options)

    def in_units(solution: Solution, load: float) -> tuple[FieldsInUnits, Solution, float]:
        """Return a load (Pa) as it is yielded."""
        approach = problem.reference - solution.state.offset * problem.scale - compliance * load
        fields = fields_in_units(solution, problem, material, threads=threads)
        return fields, solution, approach

    for load in loads:  # no name here keeps the maps of one while the next one is solved
        yield in_units(next(solutions), load)


def contact_from(
    height: xr.DataArray,
    material: Elasticity,
    start: np.ndarray | None,
    *,
    load: float,
    tolerance: float,
    zero_frequency: choices.ZeroFrequency = "zero",
    threads: int,
) -> xr.Dataset:
    """Return the contact of a periodic map at a load (Pa), from a similar pressure (ny, nx; Pa) to start."""
    problem = nondimensionalise(height, threads=threads)
    guess = None if start is None else start / unit_of_pressure(problem, material.modulus)
    options: dict[str, Any] = {"tolerance": tolerance, "zero_frequency": zero_frequency}
    solution = next(periodic_solutions(problem, [load], material, start=guess, threads=threads, **options))
    loads = {"mean_pressure": load}
    return load_result(
        *solution, problem=problem, window=height, loads=loads, elasticity=material, attrs=options
    )


def _check_periodic(
    problem: Problem,
    loads: Sequence[float],
    material: Elasticity,
    window: xr.DataArray,
    zero_frequency: choices.ZeroFrequency,
) -> None:
    """Raise SettingsError for a load (Pa), or a rule, that a periodic map does not allow; warn of seams."""
    cap = material.hardness
    if max(loads) >= cap:
        raise SettingsError(
            f"mean_pressure {max(loads):g} Pa is not below the hardness {cap:g} Pa: no contact carries it",
            keys=("mean_pressure",),
        )
    if max(loads) > cap * (1 - NEAR_HARDNESS):
        raise SettingsError(
            f"mean_pressure {max(loads):.12g} Pa is less than one part in a million below the hardness "
            f"{cap:.12g} Pa: all of the surface yields; lower the one or raise the other",
            keys=("mean_pressure",),
        )
    warn_of_map(problem.heights.shape, problem.gradient, stacklevel=5)
    if zero_frequency != "zero" and dimensions(problem.heights.shape) == 1:
        raise SettingsError(
            f"zero_frequency = {zero_frequency!r} is for maps: the mean displacement of an infinitely wide "
            "profile is infinite; use 'zero'",
            keys=["zero_frequency"],
        )
    unit = unit_of_pressure(problem, material.modulus)
    for load in (min(loads), max(loads)) if not problem.flat else ():
        if not MIN_LOAD <= load / unit <= MAX_LOAD:
            raise SettingsError(
                f"mean_pressure {load:g} Pa is {load / unit:.1g} of E* times the rms gradient of the map "
                f"({unit:.3g} Pa); rounding allows {MIN_LOAD:g} to {MAX_LOAD:g}: check the units of load, "
                "modulus and heights",
                keys=("mean_pressure",),
            )
    warn_of_seams(window, problem.gradient, stacklevel=5)


class Method(NamedTuple):
    """How the problems of a kind are solved, load by load; forces are checked each against its region."""

    solutions: Callable[..., Iterator[tuple[FieldsInUnits, Any, float]]]
    check: Callable[..., None] = lambda *_: None


METHODS: dict[str, Method] = {
    PERIODIC_MAP.name: Method(periodic_solutions, _check_periodic),
    FINITE_BODY.name: Method(free_solutions),
}


def _kept(
    load_dataset: xr.Dataset, fields: bool, reduce: Callable[[xr.Dataset], xr.Dataset] | None
) -> xr.Dataset:
    """Return what is kept of a load: all, or its numbers, with the dataset that `reduce` makes of it."""
    if reduce is None:
        return load_dataset if fields else load_dataset.drop_dims(["y", "x"])
    result_of_load = reduce(load_dataset)
    if not isinstance(result_of_load, xr.Dataset):
        raise RoughContactError(
            f"the function given as reduce returned {type(result_of_load).__name__}: let it return a Dataset"
        )
    numbers = load_dataset.drop_dims(["y", "x"]).merge(describe(result_of_load), compat="override")
    return numbers.assign_attrs(result_of_load.attrs | load_dataset.attrs)


def _missed(load: str, load_dataset: xr.Dataset, *, precision: choices.Precision) -> str:
    """Return the error message for a load that misses the tolerance."""
    precision_hint = ", take precision: double" if precision == "single" else ""
    remedies = f"raise the tolerance{precision_hint} or set on_failure: flag"
    tolerance, floor = load_dataset.attrs["tolerance"], load_dataset["rounding_floor"].item()
    if floor > tolerance:
        return (
            f"{load}: rounding in {precision} precision allows no error bound below {floor:.2g} here, the "
            f"tolerance is {tolerance:g}: {remedies}"
        )
    return (
        f"{load}: the error bound stopped at {load_dataset['error_bound'].item():.2g} after "
        f"{load_dataset['iterations'].item()} iterations, above the tolerance {tolerance:g}; rounding in "
        f"{precision} precision allows {floor:.1g} here: {remedies}"
    )
