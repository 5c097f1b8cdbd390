"""Stresses below the surface of a half-space, or of a body with layers, wave by wave."""

import math
from collections.abc import Callable

import numpy as np

from roughcontact.contact.elasticity.layers import Stack, stress_amplitudes
from roughcontact.contact.elasticity.point_force import TAPER, PointForce, half_space_amplitudes
from roughcontact.kernels.arrays import DOUBLE, empty
from roughcontact.kernels.fft import make_plan
from roughcontact.kernels.fourier import wavevectors


def subsurface_stress(
    pressure: np.ndarray,
    steps: tuple[float, float],
    *,
    poissons_ratio: float | None = None,
    body: Stack | None = None,
    images: bool = True,
) -> Callable[..., np.ndarray]:
    """Return the function depth (m) -> stresses (6, ny, nx; Pa) below a frictionless pressure (ny, nx; Pa).

    The order is xx, yy, zz, yz, xz, xy, tension is positive, z points into the body. Below a wave p exp(i q
    x), q > 0, (Johnson 1985, Contact Mechanics, section 13.2 and chapter 3; Tripp, Van Kuilenburg,
    Morales-Espejel and Lugt 2003, Tribol. Trans. 46, 376):

        across the surface    -p (1 + qz) e^(-qz)         shear with q    i p qz e^(-qz)
        along q               -p (1 - qz) e^(-qz)
        along the crests      -2ν p e^(-qz)

    The mean acts at every depth, with the lateral pressure ν/(1 - ν) of a constrained body. With layers the
    waves are those of `stress_amplitudes`; the function then takes the depth below the upper face of a
    material, and its index. Without periodic `images` the half-space has this load alone (`PointForce`).
    """
    size = pressure.shape
    inside = slice(size[0]), slice(size[1])
    if not images:
        from scipy.fft import next_fast_len  # imported late: periodic maps need nothing of scipy

        reach = float(np.hypot(*np.multiply(pressure.shape, steps)))  # the farthest two loaded points
        wide = [n + math.ceil(TAPER * reach / step) for n, step in zip(pressure.shape, steps, strict=True)]
        wide_pressure = np.zeros([next_fast_len(n, real=True) for n in wide])
        wide_pressure[inside] = pressure
        pressure = wide_pressure
    shape, mean = pressure.shape, float(pressure.mean()) if images else 0.0
    plan = make_plan(pressure, DOUBLE)
    # a copy: the plan overwrites its spectrum at the next transform
    spectrum = plan.forward(np.subtract(pressure, mean, dtype=float)).copy()
    qy, qx = wavevectors(shape, steps)
    q = np.hypot(qy, qx)
    # the shallowest depth that is resolved
    force = None if images else PointForce(q, reach, min(steps) / 32)
    along_y, along_x = (
        np.divide(wavevector, q, out=np.zeros_like(q), where=q > 0) for wavevector in (qy, qx)
    )
    along_y[0, 0] = along_x[0, 0] = np.sqrt(0.5)  # without a direction
    # a wave at the Nyquist limit has no sign, and no direction of its shear
    ny, nx = shape
    odd_y, odd_x = along_y.copy(), along_x.copy()
    if ny % 2 == 0:
        odd_y[ny // 2] = 0
    if nx % 2 == 0:
        odd_x[:, -1] = 0
    if body is None:
        assert poissons_ratio is not None
        ratios = [poissons_ratio]
    else:
        ratios = [body_material.poissons_ratio for body_material in body.materials]
        # any wave serves at q = 0, whose amplitude the spectrum has lost with the mean
        layer_stresses = stress_amplitudes(np.where(q > 0, q, q.flat[-1]), body)

    def stress_at(depth: float, material: int = 0) -> np.ndarray:
        """Return the stresses (6, ny, nx) at a depth."""
        ratio = ratios[material]
        if body is None:
            amplitudes = half_space_amplitudes(q * depth, ratio)
            if force is not None:
                amplitudes[:, force.long] = force.amplitudes(depth, ratio)
            normal, shear, with_q, crests = amplitudes
        else:
            normal, shear, with_q = layer_stresses(material, depth)
            crests = ratio * (normal + with_q)
        components = (
            lambda: along_x**2 * with_q + along_y**2 * crests,
            lambda: along_y**2 * with_q + along_x**2 * crests,
            lambda: normal,
            lambda: -1j * odd_y * shear,
            lambda: -1j * odd_x * shear,
            lambda: odd_x * odd_y * (with_q - crests),
        )
        lateral = ratio / (1 - ratio) * mean  # sides cannot give way under a pressure that is everywhere
        uniform = (-lateral, -lateral, -mean, 0, 0, 0)
        stress, field = empty(pressure, DOUBLE, (6, *size)), empty(pressure, DOUBLE)
        for index, component in enumerate(components):
            plan.inverse(component() * spectrum, field)
            np.add(field[inside], uniform[index], out=stress[index])
        return stress

    return stress_at


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Return the equivalent stress of von Mises of stresses (6, ...), xx, yy, zz, yz, xz, xy."""
    xx, yy, zz, yz, xz, xy = stress
    normal = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
    return np.sqrt(normal + 3 * (yz**2 + xz**2 + xy**2))


def tresca(stress: np.ndarray) -> np.ndarray:
    """Return the largest difference of principal stresses (Tresca) of stresses ordered as in `von_mises`."""
    xx, yy, zz, yz, xz, xy = stress
    tensor = np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), (0, 1), (-2, -1))
    principal = np.linalg.eigvalsh(tensor)
    return principal[..., 2] - principal[..., 0]
