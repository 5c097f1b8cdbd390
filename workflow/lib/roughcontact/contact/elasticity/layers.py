"""Elastic bodies with bonded layers: displacement u = S(q) p under a pressure wave p exp(i q x).

S follows from Navier's equations in plane strain (Johnson 1985, Contact Mechanics, chapter 13, for the
half-space), from the base outwards: C of u = C t, displacement and traction of a lower face, is passed on to
the upper one. Where |q| t is small, by the transfer matrix exp(-A |q| t), else by the reflection of the
decaying waves: neither loses digits for any thickness, stiffness and Poisson's ratio up to 1/2, as the closed
form of one layer does where it is thin. The tractions go inwards: those of the lower face are T times those
of the upper one. S p^2/2 is an energy, so that S > 0 for q > 0, which is all that
`roughcontact.contact.certificate` asks of it.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from roughcontact.arguments.stacks import layers_in, properties_of_bodies
from roughcontact.contact.elasticity.layers_under_force import FadedLayers, change_by_layers
from roughcontact.contact.elasticity.medium import Medium, wavenumbers
from roughcontact.kernels.arrays import Array, get_precision, like_array

_THIN = 1.0  # |q| t below which the transfer matrix is used; above, its error would grow as exp(2 |q| t)
_TERMS = 12  # of the series of (s cosh s - sinh s)/2, exact to rounding up to there
# Wavenumbers above which the factor is interpolated: a cubic spline of its logarithm over that of |q|, which
# is exact to 1e-12, takes a tenth of the time
_NODES = 8192


class Material(NamedTuple):
    """An elastic material: Young's modulus (Pa) and Poisson's ratio."""

    youngs_modulus: float
    poissons_ratio: float

    @property
    def shear_modulus(self) -> float:
        """E/(2 (1 + nu)), Pa."""
        return self.youngs_modulus / (2 * (1 + self.poissons_ratio))

    @property
    def plane_modulus(self) -> float:
        """E/(1 - nu^2), Pa."""
        return self.youngs_modulus / (1 - self.poissons_ratio**2)


class Layer(NamedTuple):
    """A bonded layer: its thickness (m) and material."""

    thickness: float
    material: Material


class Stack(NamedTuple):
    """A body: its layers from the surface inwards, and the material of its base, None for a rigid one."""

    layers: tuple[Layer, ...]
    base: Material | None

    @property
    def surface(self) -> Material:
        """The material at the surface."""
        return self.materials[0]

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials from the surface inwards, without a rigid base."""
        return *(layer.material for layer in self.layers), *([] if self.base is None else [self.base])

    def merged(self) -> "Stack":
        """Return the same body with neighbouring layers of one material as one, and none like its base."""
        layers = [
            Layer(sum(layer.thickness for layer in equal_layers), material)
            for material, equal_layers in groupby(self.layers, key=attrgetter("material"))
        ]
        if layers and layers[-1].material == self.base:  # a layer of the material of its base is part of it
            layers.pop()
        return Stack(tuple(layers), self.base)


@dataclass(frozen=True)
class LayeredPair(Medium):
    """The bodies of a contact, of which one at least has layers."""

    bodies: tuple[Stack, ...]
    properties: ClassVar[tuple[str, ...]] = ("layers",)

    @property
    def departures(self) -> tuple[Medium, ...]:
        """The pair."""
        return (self,)

    @property
    def largest_factor(self) -> float:
        """The largest `factor`, at least 1."""
        # from waves far longer than the layers to far shorter ones: beyond them the factor has its limits
        return max(1.0, float(self.factor(np.geomspace(1e-3 / self.thickest, 1e2 / self.thinnest, 64)).max()))

    @property
    def modulus(self) -> float:
        """E* of the materials at the two surfaces, Pa: that of the contact for the shortest waves."""
        return 1 / sum(1 / body.surface.plane_modulus for body in self.bodies)

    def base_modulus(self, modulus: float) -> float:
        """Return E* of the elastic bases (Pa), infinite where all are rigid."""
        soft = sum(1 / body.base.plane_modulus for body in self.bodies if body.base is not None)
        return 1 / soft if soft else np.inf

    @property
    def thinnest(self) -> float:
        """The thickness of the thinnest layer."""
        return min(layer.thickness for body in self.bodies for layer in body.layers)

    @property
    def thickest(self) -> float:
        """The thickness of the layers of the body that has most of them."""
        return max(sum(layer.thickness for layer in body.layers) for body in self.bodies)

    def mean_compliance(self, *, elastic: bool) -> float:
        """Return what the layers add, those on elastic bases only where `elastic`, m/Pa."""
        # t/(lambda + 2 mu) of a layer on a rigid base, whose sides cannot give way; on an elastic base the
        # limit of S(q) - 2/(E2* q) for q to 0
        return sum(_compression(body) for body in self.bodies if elastic or body.base is None)

    def as_settings(self) -> list[dict[str, Any]]:
        """Return the bodies as the settings describe them; `layered_pair` reads them."""
        settings = []
        for body in self.bodies:
            layers = [{"thickness": thickness} | material._asdict() for thickness, material in body.layers]
            base = {"base": "rigid"} if body.base is None else body.base._asdict()
            settings.append(base | {"layers": layers})
        return settings

    def scaled(self, unit: float) -> "LayeredPair":
        """Return the pair with its thicknesses in a `unit` of length."""
        layers = [
            tuple(Layer(thickness / unit, material) for thickness, material in body.layers)
            for body in self.bodies
        ]
        return type(self)(tuple(map(Stack, layers, [body.base for body in self.bodies])))

    def factor(self, q: np.ndarray) -> np.ndarray:
        """Return E* |q| S(|q|)/2 of both bodies together, by which they differ from half-spaces.

        It tends to 1 for short waves. `q` > 0 is in the inverse unit of the thicknesses.
        """
        q = np.asarray(q, float)
        if q.size <= 2 * _NODES:
            total = np.zeros_like(q)
            for body in self.bodies:
                factor = self._of_body(q, body) if body.layers else 1.0
                total += self.modulus / body.surface.plane_modulus * factor
            return total
        nodes, at_waves = _nodes_over(q)
        factor = at_waves(np.log(self.factor(nodes)))
        return np.exp(factor, out=factor)

    def weigh(self, symbol: Array, qy: np.ndarray, qx: np.ndarray) -> None:
        """Multiply the symbol of half-spaces (qy.size, qx.size) by the `factor` of its waves, in place."""
        factor = self.factor(wavenumbers(qy, qx))
        symbol *= like_array(factor.astype(get_precision(symbol)), symbol)

    def change_of_point_force(self, distance: np.ndarray) -> np.ndarray:
        """Return what layers add to E* times the displacement by a unit force, 1/(pi r), at distances."""
        return change_by_layers(self, distance)

    def free_response(self, reach: float) -> FadedLayers:
        """Return the response of the layers, faded smoothly beyond `reach`."""
        return FadedLayers(self, reach)

    @staticmethod
    def _of_body(q: np.ndarray, body: Stack) -> np.ndarray:
        return compliance_factor(q, body)


class ConductingPair(LayeredPair):
    """The bodies of a contact as conductors, each material of conductivity k with the modulus 2 k and nu = 0.

    A wave of flux j warms a half-space by j/(k |q|), as a pressure displaces it by 2/(E* |q|).
    """

    @staticmethod
    def _of_body(q: np.ndarray, body: Stack) -> np.ndarray:
        assert body.base is not None
        ratio = np.full(q.shape, 2 / body.base.plane_modulus)
        # Laplace's equation: q times temperature over flux, Z at the lower face, is (Z + tanh(q t)/k)/(1 + k
        # Z tanh(q t)) at the upper
        for thickness, material in reversed(body.layers):
            resistivity, rise = 2 / material.plane_modulus, np.tanh(q * thickness)
            ratio = (ratio + resistivity * rise) / (1 + ratio * rise / resistivity)
        return ratio * body.surface.plane_modulus / 2


def conducting_pair(bodies: Iterable[Mapping[str, Any]], name: str) -> ConductingPair | None:
    """Return the bodies as conductors, None unless the property is known of every material.

    It is `thermal_conductivity` (W m-1 K-1) or `electrical_resistivity` (Ohm m).
    """
    stacks = []
    for body in bodies:
        layers: Sequence[Mapping[str, Any]] = layers_in(body)
        # the base is the body itself
        conductivities: list[Any] = [layer.get(name) for layer in (*layers, body)]
        if None in conductivities:
            return None
        power = -1 if name == "electrical_resistivity" else 1
        *above, base = (Material(2 * float(value) ** power, 0.0) for value in conductivities)
        thicknesses = (float(layer["thickness"]) for layer in layers)
        stacks.append(Stack(tuple(map(Layer, thicknesses, above)), base))
    return ConductingPair(tuple(stacks))


def layered_pair(bodies: Sequence[Mapping[str, Any]]) -> LayeredPair | None:
    """Return bodies of the settings (Pa, m) as a pair, None where none has a layer unlike its base."""
    stacks = tuple(body_stack(body).merged() for body in bodies) if properties_of_bodies(bodies) else ()
    return LayeredPair(stacks) if any(stack.layers for stack in stacks) else None


def body_stack(body: Mapping[str, Any]) -> Stack:
    """Return one body of the settings as a `Stack`."""
    layers = tuple(Layer(float(layer["thickness"]), _material(layer)) for layer in layers_in(body))
    return Stack(layers, None if body.get("base") == "rigid" else _material(body))


def compliance_factor(q: np.ndarray, body: Stack) -> np.ndarray:
    """Return S(q) E1* q/2 of one body, E1* = E/(1 - nu^2) of its surface, for q > 0 in rad/length.

    Examples
    --------
    An incompressible layer on a rigid base, pressed by a wave that is long against it, is as stiff as its
    flow along the base makes it, S = q^2 t^3/(3 G):

    >>> rubber = Stack((Layer(1.0, Material(3.0, 0.5)),), None)
    >>> print(f"{compliance_factor(np.array([1e-3]), rubber)[0] / (1e-9 * 4 / 6):.4f}")
    1.0000
    """
    compliance = _base_matrix(body.base, np.shape(q))
    for thickness, material in reversed(body.layers):
        compliance, _ = _through(compliance, np.asarray(q, float) * thickness, material)
    return -compliance[1, 1] * body.surface.plane_modulus / 2


def stress_amplitudes(q: np.ndarray, body: Stack) -> Callable[[int, float], np.ndarray]:
    """Return the function (material index, depth below its face) -> stresses (3, ...) below waves cos(q x).

    They are the normal stress across the surface over cos(q x), the shear over sin(q x) and the normal stress
    along q over cos(q x), of unit pressure; tension is positive, q > 0 in rad per unit of the thicknesses.
    """
    q = np.asarray(q, float)
    if q.size > 2 * _NODES:
        # splines over few wavenumbers, as for the factor
        nodes, at_waves = _nodes_over(q)
        exact = stress_amplitudes(nodes, body)
        return lambda number, depth: at_waves(exact(number, depth))
    steps = [(_base_matrix(body.base, q.shape), np.empty(0))]  # of each material: C of its upper face, and T
    for thickness, material in reversed(body.layers):
        # from the base upwards: each layer stands on what is below
        steps.insert(0, _through(steps[0][0], q * thickness, material))
    above = np.zeros((2, 1, *q.shape))
    above[1] = -1  # a unit pressure, no shear
    tractions = [above]
    for _, transfer in steps[:-1]:
        tractions.append(_times(transfer, tractions[-1]))

    def stress_at(number: int, depth: float) -> np.ndarray:
        compliance, material = steps[-1][0], body.base
        if number < len(body.layers):
            thickness, material = body.layers[number]
            # the rest of the layer below the depth takes the place of its base
            compliance, _ = _through(steps[number + 1][0], q * (thickness - depth), material)
        assert material is not None  # in a rigid base there are no stresses to be known
        _, to_depth = _through(compliance, q * depth, material)
        traction = _times(to_depth, tractions[number])
        stretch = _times(compliance, traction)[0, 0]
        (shear,), (normal,) = traction
        nu, mu = material.poissons_ratio, material.shear_modulus
        return np.stack([normal, shear, (2 * mu * stretch + nu * normal) / (1 - nu)])

    return stress_at


def _nodes_over(q: np.ndarray) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Return fewer wavenumbers, and the function from values there to values at all, by splines over ln q."""
    from scipy.interpolate import CubicSpline  # the import takes half a second

    logarithm = np.log(q)
    nodes = np.linspace(logarithm.min(), logarithm.max(), _NODES)
    return np.exp(nodes), lambda values: CubicSpline(nodes, values, axis=-1)(logarithm)


def _material(values: Mapping[str, Any]) -> Material:
    return Material(float(values["youngs_modulus"]), float(values["poissons_ratio"]))


def _base_matrix(base: Material | None, shape: tuple[int, ...]) -> np.ndarray:
    """Return C (2, 2, ...) of a base: displacement along q and inwards, per traction over q."""
    if base is None:
        return np.zeros((2, 2, *shape))
    nu, mu = base.poissons_ratio, base.shear_modulus
    half_space = np.array([[nu - 1, 0.5 - nu], [0.5 - nu, nu - 1]]) / mu
    return np.broadcast_to(half_space.reshape(2, 2, *(1 for _ in shape)), (2, 2, *shape))


def _through(compliance: np.ndarray, x: np.ndarray, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Return C of the upper face of a layer, x = |q| t, of that of its lower face, and T through it."""
    thin, (upper, transfer) = x < _THIN, np.empty((2, *compliance.shape))
    for chosen, propagate in ((thin, _via_transfer), (~thin, _via_reflection)):
        if chosen.any():
            through = propagate(compliance[..., chosen], x[chosen], material)
            upper[..., chosen], transfer[..., chosen] = through
    return upper, transfer


def _via_transfer(compliance: np.ndarray, x: np.ndarray, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Return C of the upper face of a layer, and T, by its transfer matrix exp(-A x).

    With y = (u, w, shear, normal traction) in units of the shear modulus, y' = A y and A^4 - 2 A^2 + 1 = 0:
    the exponential consists of the four functions below.
    """
    nu, mu = material.poissons_ratio, material.shear_modulus
    sh, ch, even, odd = np.sinh(x), np.cosh(x), x * np.sinh(x) / 2, _half_difference(x)
    h, n, m, k = 0.5 / (1 - nu), nu / (1 - nu), 2 / (1 - nu), (0.5 - nu) / (1 - nu)
    stretch, shrink = ch + 2 * h * even, ch - 2 * h * even
    turn, lift = sh + 2 * h * odd, n * sh + 2 * h * odd
    upper = np.array([[stretch, -turn], [lift, shrink]])
    flexibility = np.array([[-sh - h * odd, h * even], [-h * even, h * odd - k * sh]]) / mu
    stiffness = np.array([[-m * (sh + odd), m * even], [-m * even, m * odd]]) * mu
    lower = np.array([[stretch, -lift], [turn, shrink]])
    transfer = _inverse(_times(stiffness, compliance) + lower)
    return _times(_times(upper, compliance) + flexibility, transfer), transfer


def _via_reflection(
    compliance: np.ndarray, x: np.ndarray, material: Material
) -> tuple[np.ndarray, np.ndarray]:
    """Return C of the upper face of a layer, and T, by the waves that decay from its faces and reflect."""
    nu, mu = material.poissons_ratio, material.shear_modulus

    def waves(s: np.ndarray, sign: float) -> tuple[np.ndarray, np.ndarray]:
        """Return displacements and tractions (2, 2, ...) of two waves at the depth s, less exp(-sign s)."""
        ones, k = np.ones_like(s), 3 - 4 * nu
        displacements = np.array([[ones, s], [sign * ones, sign * s + k]])
        shear = [-2 * sign * ones, -2 * sign * s - 2 * (1 - 2 * nu)]
        normal = [-2 * ones, -2 * s - 4 * sign * (1 - nu)]
        return displacements, mu * np.array([shear, normal])

    (decaying, decaying_traction), (growing, growing_traction) = waves(x, 1.0), waves(x, -1.0)
    # the growing wave is what the lower face reflects of the decaying one
    reflection = -_times(
        _inverse(growing - _times(compliance, growing_traction)),
        decaying - _times(compliance, decaying_traction),
    )
    transfer = np.exp(-x) * (decaying_traction + _times(growing_traction, reflection))
    # both ways through the layer: never larger than 1, unlike exp(+x)
    reflection *= np.exp(-2 * x)
    (decaying, decaying_traction), (growing, growing_traction) = waves(0 * x, 1.0), waves(0 * x, -1.0)
    incident = _inverse(decaying_traction + _times(growing_traction, reflection))
    return _times(decaying + _times(growing, reflection), incident), _times(transfer, incident)


def _compression(body: Stack) -> float:
    """Return the displacement per mean pressure of the layers of a body beside that of its base, m/Pa."""
    cross = 0.0 if body.base is None else (0.5 - body.base.poissons_ratio) / body.base.shear_modulus
    total = 0.0
    for thickness, material in body.layers:
        nu, mu = material.poissons_ratio, material.shear_modulus
        # the layer follows the lateral strain of its base, the square of which it takes up as a membrane
        total += thickness * ((0.5 - nu) / mu - 2 * nu * cross - 2 * mu * cross**2) / (1 - nu)
    return total


def _half_difference(s: np.ndarray) -> np.ndarray:
    """Return (s cosh s - sinh s)/2 for s up to `_THIN` by its series, sum of j s^(2j+1)/(2j+1)!."""
    total, term = np.zeros_like(s), s.copy()
    for j in range(1, _TERMS):  # the leading terms of both parts cancel: the series has none of the rounding
        term = term * s * s / (2 * j * (2 * j + 1))
        total += j * term
    return total


def _times(a: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the products of matrices (2, 2, ...)."""
    return np.einsum("ij...,jk...->ik...", a, right)


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Return the inverses of matrices (2, 2, ...)."""
    (a, b), (c, d) = matrix
    return np.array([[d, -b], [-c, a]]) / (a * d - b * c)
