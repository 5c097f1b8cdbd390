"""Running-in: how sliding wears a rough face against a smooth one, with a bound of the heights in time.

Archard's law, dh/ds = -k p over the sliding distance s, is the gradient flow of the convex function Phi(h) =
max of <p, h> - <p, G p>/2 over the pressures of the prescribed mean, whose gradient is the contact pressure:
means over the map, u = G p. An implicit step h' = h - k Δs p(h') is the contact of h on a Winkler foundation
of compliance k Δs in series with the half-space, so that solver and certificate stay as they are, any step is
stable, and two faces never grow more unlike: an error of the measurement does not grow.

The bound in time: with U = h' + t (h - h') on the way of a step and u the exact face, the mean square of
u - U grows, by k Δs, by at most 2 (B(U) - ||p(U) - p(h')||^2/4), B(U) = Phi(U) - Phi(h') - <p(h'), U - h'>,
because Phi(g) lies above its tangent at h by ||p(g) - p(h)||^2/2 or more, in the norm of G. By the same B(U)
is at most t B(h) - ((1 - t) ||p(U) - p(h')||^2 + t ||p(h) - p(U)||^2)/2. The triangle inequality and the mean
over t leave B(h) - 5/18 ||p(h) - p(h')||^2; Nochetto, Savaré and Verdi (2000) have B(h).
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_applies, check_positive
from roughcontact.arguments.choices import Influence, ZeroFrequency
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import number, quantity
from roughcontact.arguments.si import as_si
from roughcontact.arguments.stacks import top_material
from roughcontact.arguments.variables import describe
from roughcontact.contact.elasticity.energy import elastic_energy
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.solve import contact_from, elasticity, solve_contact
from roughcontact.errors import ConvergenceError, SettingsError
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.surface.roughness.heights import own_parameters

FIRST_SHARE = 0.1  # of the squared tolerance, for the first step
SHORTEST = 1e-6  # of the first step: a solver that leaves too much open makes it shorter and shorter
CONVEXITY = 5 / 18  # share of ||p(h) - p(h')||^2 that the convexity of Phi takes off the bound of a step
SAFETY, MAX_GROWTH = 0.8, 4.0  # of the next step: below its predicted length, and over the last one
_ROUNDING = 4 * np.finfo(float).eps
SETTLED = 1.1  # ratio of the contact areas after and before a doubling of the distance


class Archard(NamedTuple):
    """The law by which a face is worn, and how its contacts are solved."""

    coefficient: float  # 1/Pa
    material: Elasticity
    solve: Callable[..., xr.Dataset]  # `contact_from` at the load


class _Worn(NamedTuple):
    """The face after a distance (m), in its contact."""

    distance: float
    contact: xr.Dataset  # at one load
    energy: float  # upper bound of Phi, Pa m
    missing: float  # bound of the error of the pressure, in the norm of G
    squared_error: float = 0.0  # bound of the mean square of the error of the heights, m2


@as_si
def run_in(
    window: xr.DataArray,
    *,
    wear_coefficient: float | str,
    sliding_distance: float | str | Sequence[float | str],
    mean_pressure: float | str,
    contact_modulus: float | str | None = None,
    bodies: Sequence[Mapping[str, Any]] | None = None,
    hardness: float | None = None,
    influence: Influence = "sampled",
    zero_frequency: ZeroFrequency = "zero",
    tolerance: float = 0.02,
    solver_tolerance: float = 1e-4,
    statistics: Mapping[str, Any] | None = None,
    threads: int = 1,
) -> xr.Dataset:
    """Return the face that sliding against a smooth counterface leaves, and its contact, over the distance.

    Each point loses height as Archard [1]_ says, k times its pressure times the distance. The steps are
    implicit, and so long that the bound of Nochetto, Savaré and Verdi [2]_, with what the solver leaves open,
    keeps to the tolerance. k is constant, debris leaves and nothing is transferred, nothing is heated, the
    direction of sliding makes no difference, and the mean pressure is constant.

    Parameters
    ----------
    window : DataArray (y, x), m
        as for `solve_contact`: a single rough face.
    wear_coefficient : float or str, 1/Pa
        k, worn volume over load and distance: "1e-7 mm3/(N m)".
    sliding_distance : float or sequence of float, m
        rising distances whose faces are returned; 0 is the face as it is.
    mean_pressure : float, Pa
        nominal pressure.
    contact_modulus : float, Pa
        E*, unless `bodies` are given as for `solve_contact`.
    bodies : sequence of mappings, optional
        instead of E*, the face that wears first; properties such as conductivities are for the statistics.
    hardness : float, Pa, optional
        largest pressure, as for `solve_contact`; flow itself leaves no trace in the heights.
    influence : {"sampled", "elements"}
    zero_frequency : {"zero", "nogi-kato", "lattice"}
        as for `solve_contact`.
    tolerance : float
        largest `time_error_bound` over the rms height of the window; infinite: one step to each distance.
    solver_tolerance : float
        of each contact; what it leaves open is part of that bound.
    statistics : mapping, optional
        further arguments of `contact_statistics`, as `seal`.
    threads : int
        of the solver.

    Returns
    -------
    Dataset
        along `sliding_distance`: `height` (y, x; m), which can be measured and solved again, the numbers of
        `contact_statistics`, `worn_volume` (m, by nominal area: the mean worn depth), `max_worn_depth` (m),
        `time_error_bound` (m: of the root mean square over the map of the error of the heights that steps and
        solver make), `wear_steps` up to there, and `running_in_distance` (m), from which on the contact area
        grows by less than 10 % while the distance doubles; NaN where the last doubling still exceeds that.

    Raises
    ------
    SettingsError
        for a wear coefficient or distances that do not serve, a map of two rough faces, an outermost layer
        of a body, either of which may have the face, that is worn through, and as `solve_contact`.
    HeightMapError, ConvergenceError
        as `solve_contact`.

    References
    ----------
    .. [1] J. F. Archard (1953), Contact and rubbing of flat surfaces, J. Appl. Phys. 24, 981.
    .. [2] R. H. Nochetto, G. Savaré, C. Verdi (2000), A posteriori error estimates for variable time-step
       discretizations of nonlinear evolution equations, Comm. Pure Appl. Math. 53, 525.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> face = rough_reference_surface(64)
    >>> worn = run_in(face, contact_modulus=1.0, mean_pressure=0.1, wear_coefficient=0.1,
    ...               sliding_distance=[0.0, 2.0], tolerance=0.1)
    >>> worn["worn_volume"].values.round(6), worn["relative_contact_area"].values.round(2)
    (array([0.  , 0.02]), array([0.34, 0.86]))
    """
    check_applies("run_in", window.attrs)
    if np.ndim(wear_coefficient) > 0:
        raise SettingsError(
            f"wear_coefficient = {wear_coefficient!r}: give one, of the rough face; the smooth counterface "
            "is worn evenly by all of the face that slides over it, and stays smooth",
            keys=["wear_coefficient"],
        )
    wear = check_positive("wear_coefficient", wear_coefficient, unit="1/Pa")
    numbers = np.ravel(np.asarray(sliding_distance, dtype=object)).tolist()
    distances = [0.0 if d == 0 else check_positive("sliding_distance", d, unit="m") for d in numbers]
    if not distances or distances != sorted({*distances}):
        raise SettingsError(
            f"sliding_distance = {numbers}: give one or more, each once, in rising order, from 0 on",
            keys=["sliding_distance"],
        )
    if not tolerance > 0:
        raise SettingsError(f"tolerance = {tolerance:g}: give a number above 0, of the rms height")
    load = check_positive("mean_pressure", mean_pressure, unit="Pa")
    options: dict[str, Any] = {"contact_modulus": contact_modulus, "bodies": bodies, "hardness": hardness}
    solver: dict[str, Any] = {"tolerance": solver_tolerance, "zero_frequency": zero_frequency}
    options, solver = options | {"influence": influence}, solver | {"threads": threads}
    # the parameters of worn faces are of the window, not of the levelled map
    first = solve_contact(own_parameters(window), **options, mean_pressure=load, **solver)
    law = Archard(wear, elasticity(**options), partial(contact_from, load=load, **solver))
    checked_bodies = json_attribute(first.attrs, "bodies")
    rows, areas = [], []
    for steps, worn in enumerate(worn_faces(first, law, distances, tolerance=tolerance)):
        lost = float((first["height"] - worn.contact["height"]).max())
        for which, body in zip(("first", "second"), checked_bodies, strict=False):  # either may have the face
            if lost >= (thickness := top_material(body).get("thickness", math.inf)):
                raise SettingsError(
                    f"sliding_distance: after {number(worn.distance)} m the face has lost "
                    f"{quantity(lost, 'm')}, and the outermost layer of the {which} body is "
                    f"{quantity(thickness, 'm')} thick; give shorter distances",
                    keys=["sliding_distance"],
                )
        areas.append((worn.distance, relative_contact_area(worn.contact["pressure"].values[0] > 0)))
        if worn.distance in distances:
            contact = worn.contact.assign_attrs(first.attrs)
            counted = contact_statistics(contact, **{"bodies": bodies, **(statistics or {})}).isel(load=0)
            further = {"height": contact["height"].drop_attrs(), "max_worn_depth": lost, "wear_steps": steps}
            further |= {"time_error_bound": math.sqrt(worn.squared_error)}
            rows.append(counted.drop_dims([*counted.dims]).reset_coords(drop=True).assign(further))
    along = xr.concat(rows, xr.Variable("sliding_distance", distances))
    along["worn_volume"] = (first["height"] - along["height"]).mean(("y", "x")).drop_attrs()
    return describe(along.assign(running_in_distance=running_in_distance(*np.transpose(areas))))


def worn_faces(
    contact: xr.Dataset, law: Archard, distances: Sequence[float], *, tolerance: float
) -> Iterator[_Worn]:
    """Yield the face as it is, and after each step, some of which end at the rising `distances` (m).

    `contact` is that of the face at one load; `tolerance` is relative to the rms height. The squared bound
    grows by D = k Δs (Phi(h) - Phi(h')) - mean (h' - h)^2 in each step, by at most k^2 Δs^2 times a quarter
    of the variance of the pressure before it: the first step is as long as that allows. Of what remains of
    the squared tolerance each has its part of the logarithm of the distance that remains, so that some is
    left to the end; D of short steps grows as their cube, which predicts the next.

    Yields
    ------
    _Worn
        whose distances rise from 0.
    """
    yield (worn := _Worn(0.0, contact, *_energy(contact, contact["pressure"].values[0], law.material)))
    height, spread = contact["height"], float(contact["pressure"].values.std())
    rms_height = float(height.std())
    is_flat = rms_height <= _ROUNDING * float(abs(height).max())  # and is worn evenly by any step
    allowed = math.inf if is_flat else (tolerance * rms_height) ** 2
    first_step = 2 * math.sqrt(FIRST_SHARE * allowed) / (law.coefficient * spread) if spread > 0 else math.inf
    length = first_step = min(first_step, distances[-1])
    for end in distances:
        while (start := worn.distance) < end:
            step = min(length, end - start)
            worn_after = _step(worn, law, step)
            part = math.log1p(step / start) / math.log(distances[-1] / start) if start else FIRST_SHARE
            share = part * (allowed - worn.squared_error)
            growth = worn_after.squared_error - worn.squared_error
            factor = min(SAFETY * math.sqrt(share / growth), MAX_GROWTH) if growth > 0 else MAX_GROWTH
            # a step that was cut short to end at a distance says nothing against a longer one
            was_cut = step < length and growth <= share
            length = max(length, factor * step) if was_cut else factor * step
            if length < SHORTEST * first_step:
                raise ConvergenceError(
                    f"after {start:g} m the solver leaves more open than the tolerance allows; "
                    f"give a smaller solver_tolerance, or a larger tolerance than {tolerance:g}"
                )
            if growth <= share:
                worn = worn_after._replace(distance=end) if step == end - start else worn_after
                yield worn


def _step(worn: _Worn, law: Archard, step: float) -> _Worn:
    """Return the face after an implicit step (m) of Archard's law."""
    material, depth = law.material, law.coefficient * step  # by pressure, m/Pa
    height, last_pressure = worn.contact["height"], worn.contact["pressure"].values[0]
    series = replace(material, foundation=depth * material.modulus)
    pressure = law.solve(height, series, last_pressure)["pressure"].values[0]
    lost = depth * pressure
    contact = law.solve(height - lost, material, pressure)
    # whatever the solver left open, the pressure of the step is a subgradient of Phi at h' up to the
    # difference of Phi and its own energy, and that counts twice: as an error of the step, and in D
    energy, missing = _energy(contact, contact["pressure"].values[0], material)
    own_energy, _ = _energy(contact.assign(error_bound=0.0), pressure, material)
    change = math.sqrt(2 * elastic_energy(last_pressure - pressure, spacing(height), material)) - worn.missing
    change -= math.sqrt(2 * max(energy - own_energy, 0.0))
    growth = depth * (worn.energy + energy - 2 * own_energy - CONVEXITY * max(change, 0.0) ** 2)
    squared_error = worn.squared_error + max(growth - float(np.var(lost)), 0.0)
    return _Worn(worn.distance + step, contact, energy, missing, squared_error)


def _energy(contact: xr.Dataset, pressure: np.ndarray, material: Elasticity) -> tuple[float, float]:
    """Return an upper bound of Phi (Pa m) by a pressure with the error of a contact, that in the norm of G.

    Of a pressure without an error the bound is its own energy.
    """
    height = contact["height"].values
    # both about their means: what all points lose alike is no error of a step
    work = np.mean((pressure - pressure.mean()) * (height - height.mean()))
    size = math.sqrt(2 * elastic_energy(pressure, spacing(contact["height"]), material))
    missing = contact["error_bound"].item() * size
    return float(work) - (size**2 - missing**2) / 2, missing


def running_in_distance(distances: np.ndarray, areas: np.ndarray) -> float:
    """Return the distance (m) from which on the contact area grows by less than 10 % with each doubling.

    Between the steps the area is linear in the logarithm of the distance. 0 where it never grows by more, NaN
    where it does so up to the last doubling, or where the steps include none.

    Examples
    --------
    >>> import numpy as np
    >>> areas = np.array([0.1, 0.1, 0.2, 0.3, 0.315, 0.32])
    >>> print(f"{running_in_distance(np.array([0, 1, 2, 4, 8, 16]), areas):.2f}")
    3.59
    """
    logarithm, area, doubling = np.log(distances[distances > 0]), areas[distances > 0], math.log(2)
    # linear between the ends of steps, and half of those
    starts = np.union1d(logarithm, logarithm - doubling)
    starts = starts[(starts >= logarithm[:1]) & (starts <= logarithm[-1:] - doubling)]
    if not starts.size:
        return math.nan
    excess = np.interp(starts + doubling, logarithm, area) - SETTLED * np.interp(starts, logarithm, area)
    growing = np.flatnonzero(excess >= 0)
    if not growing.size:
        return 0.0
    last = slice(growing[-1], growing[-1] + 2)
    return float(np.exp(np.interp(0.0, -excess[last], starts[last]))) if excess[-1] < 0 else math.nan
