"""Closed forms of contact mechanics, to hold every numeric result against.

Conventions as everywhere: heights positive outwards, rigid rough surface on an elastic half-space of contact
modulus E*, pressure and mean pressure in Pa, lengths in m. Waves have amplitude D and wavelength λ; r is the
mean pressure over the pressure of full contact p*. A sphere has radius R and carries the force F on a contact
of radius a with the largest pressure p0; a square period has the side L, a body Poisson's ratio ν.

References
----------
- Dapp, W. B., Lücke, A., Persson, B. N. J., Müser, M. H. (2012), Phys. Rev. Lett. 108, 244301.
- Glasser, M. L., Zucker, I. J. (1980), Theoretical Chemistry 5, 67.
- Johnson, K. L. (1985), Contact Mechanics.
- Johnson, K. L., Greenwood, J. A., Higginson, J. G. (1985), Int. J. Mech. Sci. 27, 383.
- Nogi, T., Kato, T. (1997), J. Tribol. 119, 493.
- Patir, N., Cheng, H. S. (1978), ASME J. Lubr. Technol. 100, 12.
- Tripp, J. H. (1983), ASME J. Lubr. Technol. 105, 458.
- Westergaard, H. M. (1939), J. Appl. Mech. 6, A49.
"""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from roughcontact.contact.elasticity.closed_forms import hertz
from roughcontact.contact.elasticity.halfspace import LATTICE_CONSTANT
from roughcontact.kernels.fourier import halfplane_weights, wavenumbers

# --- Westergaard: h = D cos(2πx/λ) ------------------------------------------------------------------------


def westergaard_full_contact_pressure(amplitude: float, wavelength: float, contact_modulus: float) -> float:
    """Return the mean pressure that just closes the wave D cos(2πx/λ): p* = π E* D/λ.

    Westergaard (1939); Johnson (1985), section 13.2.

    Parameters
    ----------
    amplitude, wavelength : float, m
    contact_modulus : float, Pa

    Returns
    -------
    float, Pa

    Examples
    --------
    >>> print(f"{westergaard_full_contact_pressure(1e-6, 1e-4, 1e9):.4g} Pa")
    3.142e+07 Pa
    """
    return np.pi * contact_modulus * amplitude / wavelength


def westergaard_contact_share(load_ratio: npt.ArrayLike) -> np.ndarray:
    """Return the share of the wave in contact, (2/π) asin √r.

    Westergaard (1939); Johnson (1985), section 13.2.

    Parameters
    ----------
    load_ratio : float or array
        r = p̄/p*; from 1 on the share is 1.

    Returns
    -------
    float or array of the shape of `load_ratio`, 0 to 1

    Examples
    --------
    >>> print(np.round(westergaard_contact_share([0.0, 0.5, 1.0, 2.0]), 6))
    [0.  0.5 1.  1. ]
    """
    return 2 / np.pi * np.arcsin(np.sqrt(np.clip(load_ratio, 0, 1)))


def westergaard_pressure(
    x: npt.ArrayLike, wavelength: float, mean_pressure: float, load_ratio: float
) -> np.ndarray:
    """Return the pressure under the wave D cos(2πx/λ), crest at x = 0.

    p = (2p̄/r) cos ψ √(r - sin²ψ), ψ = πx/λ, where sin²ψ < r; from r = 1 on the wave is closed and
    p = p̄ + p* cos(2πx/λ). Westergaard (1939); Johnson (1985), section 13.2.

    Parameters
    ----------
    x : array, m
    wavelength : float, m
    mean_pressure : float, Pa
        p̄.
    load_ratio : float
        r = p̄/p*, greater than 0.

    Returns
    -------
    array of the shape of `x`, Pa

    Examples
    --------
    >>> print(np.round(westergaard_pressure([0.0, 0.25, 0.5], 1.0, 1.0, 1.0), 6))
    [2. 1. 0.]
    """
    phase = np.pi * np.asarray(x, float) / wavelength
    if load_ratio >= 1:
        return mean_pressure * (1 + np.cos(2 * phase) / load_ratio)
    inside = np.clip(load_ratio - np.sin(phase) ** 2, 0, None)
    return 2 * mean_pressure / load_ratio * np.abs(np.cos(phase)) * np.sqrt(inside)


def westergaard_gap(x: npt.ArrayLike, wavelength: float, amplitude: float, load_ratio: float) -> np.ndarray:
    """Return the gap over the wave D cos(2πx/λ), crest at x = 0.

    gap = 2D [s √(s² - r) - r ln((s + √(s² - r))/√r)], s = |sin(πx/λ)|, where s² > r, 0 elsewhere: the
    integral of the conjugate function of the stress function of Westergaard (1939) from the edge of the
    contact. Its mean is `westergaard_mean_gap`; at r = 0 it is D - h.

    Parameters
    ----------
    x : array, m
    wavelength, amplitude : float, m
    load_ratio : float
        r = p̄/p*.

    Returns
    -------
    array of the shape of `x`, m

    Examples
    --------
    >>> print(np.round(westergaard_gap([0.0, 0.25, 0.5], 1.0, 1.0, 0.0), 6))
    [0. 1. 2.]
    """
    s = np.abs(np.sin(np.pi * np.asarray(x, float) / wavelength))
    root = np.sqrt(np.clip(s**2 - load_ratio, 0, None))
    if load_ratio == 0:
        return 2 * amplitude * s**2
    outside = s**2 > load_ratio
    logarithm = np.log(np.where(outside, (s + root) / np.sqrt(load_ratio), 1.0))
    return 2 * amplitude * (s * root - load_ratio * logarithm)


def westergaard_mean_gap(amplitude: float, load_ratio: npt.ArrayLike) -> np.ndarray:
    """Return the mean gap over the wave: ū = D (1 - r + r ln r).

    It follows from `westergaard_energy` by dU/dū = -p̄; Johnson (1985), section 13.2.

    Parameters
    ----------
    amplitude : float, m
    load_ratio : float or array
        r = p̄/p*; from 1 on the gap is 0.

    Returns
    -------
    float or array of the shape of `load_ratio`, m

    Examples
    --------
    >>> print(np.round(westergaard_mean_gap(1.0, [0.0, 0.1, 1.0]), 4))
    [1.     0.6697 0.    ]
    """
    r = np.clip(np.asarray(load_ratio, float), 0, 1)
    logarithm = np.log(np.where(r > 0, r, 1.0))
    return amplitude * (1 - r + r * logarithm)


def westergaard_stiffness(
    amplitude: float, wavelength: float, contact_modulus: float, load_ratio: float
) -> float:
    """Return the stiffness -dp̄/dū of the wave: p*/(D ln(1/r)), from `westergaard_mean_gap`.

    Parameters
    ----------
    amplitude, wavelength : float, m
    contact_modulus : float, Pa
    load_ratio : float
        r = p̄/p*, greater than 0.

    Returns
    -------
    float, Pa/m
        infinite from r = 1 on.

    Examples
    --------
    >>> print(round(westergaard_stiffness(1.0, np.pi, 1.0, np.exp(-2.0)), 6))
    0.5
    """
    full = westergaard_full_contact_pressure(amplitude, wavelength, contact_modulus)
    return full / (amplitude * -np.log(load_ratio)) if load_ratio < 1 else np.inf


def westergaard_under_hertz(load_ratio: float) -> tuple[float, float]:
    """Return means over Hertz's contact, each place of it the wave under the pressure there.

    The share 2s ds of the contact is under s times the largest pressure. With u = √r, asin averages to

        (4/(π r²)) [r²/2 asin u - 3/16 asin u + u √(1 - r) (3/16 + r/8)],

    and 1/ln(1/(rs)) to (2/r²) E₁(-2 ln r): `westergaard_contact_share`, `westergaard_stiffness`.

    Parameters
    ----------
    load_ratio : float
        r = p₀/p* of Hertz's largest pressure, between 0 and 1.

    Returns
    -------
    tuple of float
        share in contact, stiffness over p*/D.

    Examples
    --------
    >>> [round(value, 3) for value in westergaard_under_hertz(0.5)]
    [0.387, 0.949]
    """
    from scipy.special import exp1

    root = np.sqrt(load_ratio)
    inner = (load_ratio**2 / 2 - 3 / 16) * np.arcsin(root)
    inner += root * np.sqrt(1 - load_ratio) * (3 / 16 + load_ratio / 8)
    return float(4 / (np.pi * load_ratio**2) * inner), 2 / load_ratio**2 * float(
        exp1(-2 * np.log(load_ratio))
    )


def westergaard_energy(
    amplitude: float, wavelength: float, contact_modulus: float, load_ratio: float
) -> float:
    """Return the elastic energy per area, relative to uniform pressure: D p* r² (1/4 - ln(r)/2).

    That is ½ Σ_{q≠0} G |p̂|² of `westergaard_pressure`. From r = 1 on it stays at D p*/4, that of the
    flattened wave.

    Parameters
    ----------
    amplitude, wavelength : float, m
    contact_modulus : float, Pa
    load_ratio : float
        r = p̄/p*, greater than 0.

    Returns
    -------
    float, J/m²

    Examples
    --------
    >>> print(round(westergaard_energy(1.0, np.pi, 1.0, 1.0), 6))
    0.25
    """
    r = min(load_ratio, 1.0)
    full = westergaard_full_contact_pressure(amplitude, wavelength, contact_modulus)
    return amplitude * full * r**2 * (1 / 4 - np.log(r) / 2)


# --- Johnson, Greenwood and Higginson: h = D cos(2πx/λ) cos(2πy/λ) ------------------------------------------

# load ratio r: relative contact area, perimeter-corrected, at 512 x 512 points (an independent code, ± 2e-4)
JGH_CONTACT_SHARE = {0.05: 0.11294, 0.1: 0.19061, 0.3: 0.51418, 0.5: 0.70423, 0.9: 0.95063}
# load ratio r: (largest pressure / mean pressure, mean gap / D), same source, ± 1e-5 relative
JGH_PEAK_AND_GAP = {0.1: (8.83885, 0.38475), 0.5: (2.95866, 0.04508)}


def jgh_full_contact_pressure(amplitude: float, wavelength: float, contact_modulus: float) -> float:
    """Return the mean pressure that just closes D cos(2πx/λ) cos(2πy/λ): p* = √2 π E* D/λ.

    Johnson, Greenwood and Higginson (1985).

    Parameters
    ----------
    amplitude, wavelength : float, m
    contact_modulus : float, Pa

    Returns
    -------
    float, Pa

    Examples
    --------
    >>> print(round(jgh_full_contact_pressure(1.0, np.pi, 1.0), 6))
    1.414214
    """
    return np.sqrt(2) * np.pi * contact_modulus * amplitude / wavelength


def jgh_contact_share_low(load_ratio: npt.ArrayLike) -> np.ndarray:
    """Return the relative contact area for r → 0, π [3r/(8π)]^(2/3): two Hertz contacts per λ².

    Johnson, Greenwood and Higginson (1985), asymptote for small loads.

    Parameters
    ----------
    load_ratio : float or array
        r = p̄/p*.

    Returns
    -------
    float or array of the shape of `load_ratio`

    Examples
    --------
    >>> print(np.round(jgh_contact_share_low([0.001, 0.008]), 5))
    [0.00762 0.03046]
    """
    return np.pi * (3 * np.asarray(load_ratio, float) / (8 * np.pi)) ** (2 / 3)


def jgh_contact_share_high(load_ratio: npt.ArrayLike) -> np.ndarray:
    """Return the relative contact area for r → 1, 1 - (3/2π)(1 - r): pressurised penny-shaped gaps.

    Johnson, Greenwood and Higginson (1985), asymptote near full contact.

    Parameters
    ----------
    load_ratio : float or array
        r = p̄/p*.

    Returns
    -------
    float or array of the shape of `load_ratio`

    Examples
    --------
    >>> print(np.round(jgh_contact_share_high([0.9, 1.0]), 4))
    [0.9523 1.    ]
    """
    return 1 - 3 / (2 * np.pi) * (1 - np.asarray(load_ratio, float))


# --- Hertz -------------------------------------------------------------------------------------------------

# Sum of 1/n³ over the square lattice, 4 ζ(3/2) β(3/2): the curvature that the other contacts add
LATTICE_CUBES = 9.033621683100950
# Displacement at q = 0 of a point force in a square period, in L/E*: the mean of 1/q over the cell of q = 0
NOGI_KATO_CONSTANT = 4 * np.arcsinh(1.0) / np.pi


def hertz_displacement(
    distance: npt.ArrayLike, contact_radius: float, max_pressure: float, contact_modulus: float
) -> np.ndarray:
    """Return the displacement inside a Hertz contact, u = π p0 (2a² - r²)/(4 E* a), r <= a.

    Johnson (1985), eq. (3.41a). "A numerical approach to the contact of nominally flat surfaces" prints it as
    eq. (16) with 2 E* a in the denominator, twice too much: u(0) must be the approach a²/R.

    Parameters
    ----------
    distance : array, m
        r, distance from the middle of the contact.
    contact_radius : float, m
    max_pressure, contact_modulus : float, Pa

    Returns
    -------
    array of the shape of `distance`, m

    Examples
    --------
    >>> print(np.round(hertz_displacement([0.0, 1.0], 1.0, 2 / np.pi, 1.0), 6))
    [1.  0.5]
    """
    r, a = np.asarray(distance, float), contact_radius
    return np.pi * max_pressure * (2 * a**2 - r**2) / (4 * contact_modulus * a)


def hertz_spectrum(wavenumber: npt.ArrayLike, contact_radius: float, max_pressure: float) -> np.ndarray:
    """Return the Fourier transform of a Hertz pressure, ∫ p exp(-i q·x) dx dy.

    2π p0 a² [sin(qa) - qa cos(qa)]/(qa)³, the Hankel transform of order zero of p0 √(1 - r²/a²); the force
    (2/3)π a² p0 for q → 0.

    Parameters
    ----------
    wavenumber : array, rad/m
        |q|, greater than 0.
    contact_radius : float, m
    max_pressure : float, Pa

    Returns
    -------
    array of the shape of `wavenumber`, N

    Examples
    --------
    >>> print(round(hertz_spectrum(1e-3, 1.0, 1.0) / (2 / 3 * np.pi), 6))
    1.0
    """
    qa = np.asarray(wavenumber, float) * contact_radius
    return 2 * np.pi * max_pressure * contact_radius**2 * (np.sin(qa) - qa * np.cos(qa)) / qa**3


def periodic_hertz(force: float, radius: float, contact_modulus: float, period: float) -> dict[str, float]:
    """Return what `hertz` does, for a sphere that is repeated with a square period L.

    With x = a_H/L and s = 0.6391 x³, the mean displacement set to zero, and the energy that of the part
    of the displacement that is not uniform::

        a  = a_H (1 - s)          δ = a_H²/R (1 + 8s/5) - 3.900265 F/(π E* L)
        p0 = p0_H (1 + 2s)        U = (2/5) F a_H²/R (1 + 5s/2) - 3.900265 F²/(2π E* L)

    Around one contact the others act like F/(π E* L) (-3.900265 + 9.033622/4 (r² + 2a²/5)/L²): a shift, and
    a flatter sphere 1/R + 2c with c = 9.033622 F/(4π E* L³), hence 2cR = 3s. U is the integral of F dδ. First
    order in x³: the error is about x⁵. The lattice sums of the square lattice are Σ 1/n = -3.900265 (uniform
    background) and Σ 1/n³ = 9.033622 (Glasser and Zucker 1980); 2a²/5 is the second moment of the Hertz
    pressure.

    Parameters
    ----------
    force : float, N
    radius : float, m
    contact_modulus : float, Pa
    period : float, m

    Returns
    -------
    dict of float
        `contact_radius` (m), `max_pressure` (Pa), `approach` (m), `energy` (J), as of `hertz`.

    Examples
    --------
    >>> alone, repeated = hertz(1.0, 1.0, 1e3), periodic_hertz(1.0, 1.0, 1e3, 1.0)
    >>> f"{repeated['max_pressure'] / alone['max_pressure'] - 1:.2e}"
    '9.58e-04'
    """
    single = hertz(force, radius, contact_modulus)
    s = LATTICE_CUBES / (6 * np.pi) * 4 / 3 * (single["contact_radius"] / period) ** 3
    shift = LATTICE_CONSTANT * force / (contact_modulus * period)
    return {
        "contact_radius": single["contact_radius"] * (1 - s),
        "max_pressure": single["max_pressure"] * (1 + 2 * s),
        "approach": single["approach"] * (1 + 8 / 5 * s) - shift,
        "energy": single["energy"] * (1 + 5 / 2 * s) - force * shift / 2,
    }


def spot_array_stiffness(contact_radius: float, contact_modulus: float, period: float) -> float:
    """Return the stiffness -dp̄/dū of round contacts in a square period L, one each.

    A spot alone takes the force 2 E* a for each unit of approach. The others act as in `periodic_hertz`, both
    on a punch whose pressure has the second moment 2a²/3, so that with s = 0.6391 (a/L)³::

        1/K = L²/E* [(1 + 3s)/(2a) - 3.900265/(π L)]

    The lattice sums are those of Glasser and Zucker (1980); the next term is of the order (a/L)⁵.

    Parameters
    ----------
    contact_radius : float, m
    contact_modulus : float, Pa
    period : float, m

    Returns
    -------
    float, Pa/m

    Examples
    --------
    The neighbours at ten radii from one another stiffen the spots by a third:

    >>> print(round(spot_array_stiffness(0.1, 1.0, 1.0) / 0.2, 3))
    1.327
    """
    s = LATTICE_CUBES / (6 * np.pi) * 4 / 3 * (contact_radius / period) ** 3
    compliance = (1 + 3 * s) / (2 * contact_radius) - LATTICE_CONSTANT / period
    return contact_modulus / (period**2 * compliance)


# --- Unloading and slip -------------------------------------------------------------------------------------


def flattened_summit_approach(load: float, radius: float, hardness: float, contact_modulus: float) -> float:
    """Return the approach of a sphere that carries the hardness over its whole contact.

    The load F spreads over a circle of radius a = sqrt(F/(pi H)), whose edge the uniform pressure displaces
    by 4 H a/(pi E*) [1]_; there the gap is just closed, so that the approach is a^2/(2R) + 4 H a/(pi E*).

    Parameters
    ----------
    load : float, N
    radius : float, m
        of the sphere, as a paraboloid.
    hardness, contact_modulus : float, Pa

    Returns
    -------
    float
        in m.

    References
    ----------
    .. [1] Johnson (1985), Contact Mechanics, eq. (3.29a).

    Examples
    --------
    >>> print(f"{flattened_summit_approach(np.pi, 2.0, 1.0, 4 / np.pi):.4f}")
    1.2500
    """
    edge = float(np.sqrt(load / (np.pi * hardness)))
    return edge**2 / (2 * radius) + 4 * hardness * edge / (np.pi * contact_modulus)


def flattened_summit_radius(share: float) -> float:
    """Return the radius b of the contact of a summit that was pressed flat, over that at the largest load.

    At the largest load the pressure was the same everywhere. Flat punches of all radii up to b, superposed,
    carry the share s = (2/pi)(asin b - b sqrt(1 - b^2)) of it; what the approach has recovered is that of the
    punches left out, sqrt(1 - b^2) of 2 H a/E* [1]_.

    Parameters
    ----------
    share : float
        s, of the largest load, from 0 to 1.

    Returns
    -------
    float

    References
    ----------
    .. [1] Johnson (1985), Contact Mechanics, sections 3.4 and 6.4.

    Examples
    --------
    >>> print(f"{flattened_summit_radius(0.5):.4f}")
    0.9148
    """
    from scipy.optimize import brentq  # for these two functions

    def excess(b: float) -> float:
        return float(2 / np.pi * (np.arcsin(b) - b * np.sqrt(1 - b * b)) - share)

    return float(brentq(excess, 0.0, 1.0, xtol=1e-15))


def cattaneo_stick_radius(share: float) -> float:
    """Return the radius of the stick zone of a sphere over that of the contact, (1 - Q/(mu P))^(1/3).

    Parameters
    ----------
    share : float
        Q/(mu P), from 0 to 1.

    Returns
    -------
    float

    Examples
    --------
    >>> round(cattaneo_stick_radius(0.875), 12)  # the last bit of a cube root differs between processors
    0.5
    """
    return float(np.cbrt(1 - share))


def mindlin_deresiewicz_energy(
    share: float, full_slip: float, radius: float, *, shear_modulus: float, poissons_ratio: float
) -> float:
    """Return the energy that a sphere on its like loses in a cycle between Q and -Q, of either sign.

    Parameters
    ----------
    share : float
        Q/(mu P), from 0 to 1.
    full_slip : float, N
        mu P.
    radius : float, m
        of the contact.
    shear_modulus : float, Pa
    poissons_ratio : float
        of both bodies.

    Returns
    -------
    float, J

    References
    ----------
    .. [1] Mindlin and Deresiewicz (1953), J. Appl. Mech. 20, 327; Johnson (1985), eq. (7.57).

    Examples
    --------
    >>> print(f"{mindlin_deresiewicz_energy(1.0, 1.0, 1.0, shear_modulus=1.0, poissons_ratio=0.0):.3f}")
    0.600
    """
    shape = 1 - (1 - share) ** (5 / 3) - 5 * share / 6 * (1 + (1 - share) ** (2 / 3))
    return float(1.8 * full_slip**2 / radius * (2 - poissons_ratio) / shear_modulus * shape)


# --- Stresses below the surface -----------------------------------------------------------------------------


def film_strips_conductance(share: float, thickness: float) -> float:
    """Return the conductance of strips on a film between perfect conductors, times its thickness over k.

    Strips cover a share s of each period. Without the resistance t/k of the film under uniform flux, that of
    the constriction is (t/k)(1/A - 1), A = s + (4 ln 2/π) t: the film conducts as below an endless strip, and
    each edge as (2 ln 2/π) t more of it, by the conformal map of a strip of which one face is insulated on
    one side.

    Parameters
    ----------
    share : float
        s; covered and bare parts are at least twice as wide as the film is thick.
    thickness : float
        t, of the film, over the period.

    Returns
    -------
    float

    Examples
    --------
    >>> print(f"{film_strips_conductance(0.5, 0.02):.4f}")
    1.0732
    """
    return 1 / (1 / (share + 4 * np.log(2) / np.pi * thickness) - 1)


def wave_von_mises(depth: npt.ArrayLike, poissons_ratio: float) -> np.ndarray:
    """Return the largest stress of von Mises below a pressure wave of amplitude 1 without a mean.

    Below p cos(qx) the principal stresses in the plane of the wave are (-cos(qx) ± qz) e^(-qz), and the one
    across it -2ν cos(qx) e^(-qz) (plane strain). Largest below the crests: e^(-qz) √((1 - 2ν)² + 3 (qz)²);
    Johnson (1985), section 13.2.

    Parameters
    ----------
    depth : array
        qz.
    poissons_ratio : float

    Returns
    -------
    array, of the shape of `depth`
        over the amplitude of the pressure.

    Examples
    --------
    >>> print(f"{wave_von_mises(1.0, 0.5):.4f}")  # √3/e
    0.6372
    """
    z = np.asarray(depth, float)
    return np.exp(-z) * np.sqrt((1 - 2 * poissons_ratio) ** 2 + 3 * z**2)


def wave_tresca(depth: npt.ArrayLike, poissons_ratio: float) -> np.ndarray:
    """Return the largest stress of Tresca below a pressure wave of amplitude 1 without a mean.

    Of the principal stresses that `wave_von_mises` names, two differ by 2 qz e^(-qz) at every place along the
    wave, and one of them from the third by (1 - 2ν + qz) e^(-qz) below crests and troughs;
    Johnson (1985), section 13.2.

    Parameters
    ----------
    depth : array
        qz.
    poissons_ratio : float

    Returns
    -------
    array, of the shape of `depth`
        largest difference of principal stresses, over the amplitude of the pressure.

    Examples
    --------
    >>> print(f"{wave_tresca(1.0, 0.5):.4f}")  # 2/e
    0.7358
    """
    z = np.asarray(depth, float)
    return np.exp(-z) * np.maximum(2 * z, 1 - 2 * poissons_ratio + z)


def wave_volume_above(limit: float) -> float:
    """Return the volume below a pressure wave in which the stress of von Mises exceeds a limit, for ν = 1/2.

    The stress (Johnson 1985, section 13.2) is then √3 qz e^(-qz) along all of the wave, and above the limit k
    between the depths where qz = -W(-k/√3) on the two branches of Lambert's function.

    Parameters
    ----------
    limit : float
        k, over the amplitude of the pressure; more than 0.

    Returns
    -------
    float
        volume by area times q; 0 from √3/e on, the largest stress there is.

    Examples
    --------
    >>> print(f"{wave_volume_above(0.5):.4f} {wave_volume_above(0.7):.4f}")
    1.4115 0.0000
    """
    from scipy.special import lambertw  # for this one function

    reached = -limit / np.sqrt(3)
    if reached <= -np.exp(-1):
        return 0.0
    return float((lambertw(reached, 0) - lambertw(reached, -1)).real)


def westergaard_von_mises(depth: npt.ArrayLike, load_ratio: float, poissons_ratio: float) -> np.ndarray:
    """Return the stress of von Mises below the crest of Westergaard's ridges, pressed on by a part of p*.

    His pressure continues into the body as the harmonic P = 2 p* cosh t (√(r + sinh²t) - sinh t) below the
    crest, t = πz/λ, r = p̄/p*, which goes over into p̄. The normal stresses are -P + zP' across the surface,
    p̄ - P - zP' along x and 2ν (p̄ - P) along the crest, less ν/(1 - ν) p̄ for the last two. The pressure is
    that of Westergaard (1939), the stresses are those below each of its waves, Johnson (1985), section 13.2.

    Parameters
    ----------
    depth : array
        z/λ.
    load_ratio : float, 0 to 1
        r.
    poissons_ratio : float

    Returns
    -------
    array, of the shape of `depth`
        over p*, the pressure of complete contact.

    Examples
    --------
    Of light loads, Johnson's cylinder: 0.56 of the largest pressure 2 p* √r, at 0.70 of half the width a,
    with r = (πa/λ)²

    >>> import numpy as np
    >>> z = np.linspace(0.5, 1, 501)
    >>> stress = westergaard_von_mises(z * 1e-4 / np.pi, 1e-8, 0.3) / 2e-4
    >>> print(f"{stress.max():.3f} {z[stress.argmax()]:.2f}")
    0.558 0.70
    """
    t = np.pi * np.asarray(depth, float)
    root = np.sqrt(load_ratio + np.sinh(t) ** 2)
    # of √(r + sinh²t) - sinh t, without the difference
    beyond = 2 * load_ratio / (root + np.sinh(t))
    pressure = beyond * np.cosh(t)
    slope = t * beyond * (np.sinh(t) - np.cosh(t) ** 2 / root)  # z dP/dz
    lateral = poissons_ratio / (1 - poissons_ratio) * load_ratio
    across = slope - pressure
    along = load_ratio - pressure - slope - lateral
    crest = 2 * poissons_ratio * (load_ratio - pressure) - lateral
    squares = (across - along) ** 2 + (along - crest) ** 2 + (crest - across) ** 2
    return np.sqrt(squares / 2)


def hertz_von_mises(depth: npt.ArrayLike, poissons_ratio: float) -> np.ndarray:
    """Return the stress of von Mises on the axis of a Hertz contact, over its largest pressure.

    σz/p0 = -1/(1 + z²/a²), σr/p0 = -(1 + ν)(1 - (z/a) atan(a/z)) + 1/(2 (1 + z²/a²)), Johnson (1985),
    eq. (3.45); their difference is also the stress of Tresca. For ν = 0.3 it is largest at z = 0.48 a,
    0.62 p0.

    Parameters
    ----------
    depth : array
        z/a, positive.
    poissons_ratio : float

    Returns
    -------
    array, of the shape of `depth`

    Examples
    --------
    >>> print(f"{hertz_von_mises(0.48, 0.3):.3f}")
    0.620
    """
    z = np.asarray(depth, float)
    pressure = 1 / (1 + z**2)
    radial = -(1 + poissons_ratio) * (1 - z * np.arctan2(1, z)) + pressure / 2
    return np.abs(radial + pressure)


# --- Flow through a gap ------------------------------------------------------------------------------------


def channel_flow_factors(depth: float) -> tuple[float, float]:
    """Return the flow factors of channels of one wave, g = ū (1 + ε cos qx), along and across them.

    Along them flows <g³>/ū³ = 1 + 3ε²/2 of what flows between plates at the mean gap, across them
    1/(ū³ <g⁻³>) = (1 - ε²)^(5/2)/(1 + ε²/2); Patir and Cheng (1978), ridges along and across.

    Parameters
    ----------
    depth : float
        ε, less than 1.

    Returns
    -------
    along, across : float

    Examples
    --------
    >>> [round(factor, 4) for factor in channel_flow_factors(0.5)]
    [1.375, 0.433]
    """
    return 1 + 1.5 * depth**2, (1 - depth**2) ** 2.5 / (1 + 0.5 * depth**2)


def driven_share(depth: float) -> float:
    """Return the share of the mean gap whose fluid moves with ridges g = 1 + depth cos x that slide across.

    1 - <g^-2>/<g^-3>, by Reynolds' equation in one dimension; along the ridges all fluid is shared alike.

    Examples
    --------
    >>> print(f"{driven_share(0.5):.4f}")
    0.3333
    """
    return 1 - (1 - depth**2) / (1 + depth**2 / 2)


def patir_cheng_flow_factor(gap: float, gamma: float) -> float:
    """Return the pressure flow factor of Gaussian roughness at a gap over its rms height.

    gamma is the ratio of the correlation lengths along and across the flow: 1/9, 1 or 9. The fit of Patir
    and Cheng (1978), ASME J. Lubr. Technol. 100, 12, table 1, for gaps above 1 (0.5 for gamma 1 and 9).

    Examples
    --------
    >>> print(f"{patir_cheng_flow_factor(3.0, 1.0):.3f}")
    0.832
    """
    if gamma > 1:
        return 1 + 0.870 * gap**-1.5
    factor, rate = (0.90, 0.56) if gamma == 1 else (1.48, 0.42)
    return 1 - factor * float(np.exp(-rate * gap))


def isotropic_flow_factor(relative_roughness: float) -> float:
    """Return the flow factor of a gap whose roughness is low and has no direction: 1 - (3/2) (σ/ū)².

    Of any low roughness it is the mean of the factors along x and y. The next term is of third order; Tripp
    (1983).

    Parameters
    ----------
    relative_roughness : float
        σ/ū, rms height over mean gap.

    Returns
    -------
    float

    Examples
    --------
    >>> print(isotropic_flow_factor(0.1))
    0.985
    """
    return 1 - 1.5 * relative_roughness**2


def effective_medium_flow_factor(gap: np.ndarray) -> float:
    """Return the flow factor of Bruggeman's effective medium, which knows the heights of a gap alone.

    In two dimensions the medium s lets through what leaves Σ (g³ - s)/(g³ + s) = 0; it is closed from half
    contact on. Dapp, Lücke, Persson and Müser (2012).

    Parameters
    ----------
    gap : array (ny, nx)
        0 where the surfaces touch.

    Returns
    -------
    float

    Examples
    --------
    Two phases that conduct 4 and 1, half of each, conduct 2:

    >>> gap = np.cbrt([[1.0, 4.0], [4.0, 1.0]])
    >>> print(f"{effective_medium_flow_factor(gap) * gap.mean() ** 3:.6f}")
    2.000000
    """
    from scipy.optimize import brentq  # for this one function

    cubed = (np.asarray(gap, float) / np.mean(gap)) ** 3

    def excess(logarithm: float) -> float:
        medium = np.exp(logarithm)
        return float(((cubed - medium) / (cubed + medium)).sum())

    low, high = np.log(1e-12), np.log(cubed.max())
    return float(np.exp(brentq(excess, low, high))) if excess(low) > 0 else 0.0


# --- Full contact of any periodic map ----------------------------------------------------------------------


def full_contact_fluctuation(
    height: np.ndarray, spacing: Sequence[float], contact_modulus: float
) -> np.ndarray:
    """Return the pressure fluctuation that flattens a periodic map: p̂(q) = (E*|q|/2) ĥ(q), q ≠ 0.

    It is exact for the discrete problem; Johnson (1985), section 13.2, one wave at a time.

    Parameters
    ----------
    height : array (ny, nx), m
    spacing : (dy, dx), m
    contact_modulus : float, Pa

    Returns
    -------
    array (ny, nx), Pa
        zero mean; contact is full where the mean pressure is not below -min of it.

    Examples
    --------
    >>> wave = np.cos(2 * np.pi * np.arange(8) / 8)[None, :]
    >>> pressure = full_contact_fluctuation(wave, (1.0, 1.0), 1.0)
    >>> print(round(-pressure.min(), 6), round(westergaard_full_contact_pressure(1.0, 8.0, 1.0), 6))
    0.392699 0.392699
    """
    symbol = contact_modulus * wavenumbers(height.shape, spacing) / 2
    return np.fft.irfft2(symbol * np.fft.rfft2(height), s=height.shape)


def full_contact_energy(height: np.ndarray, spacing: Sequence[float], contact_modulus: float) -> float:
    """Return the elastic energy per area of the flattened map, (E*/4) Σ |q| |ĥ(q)|².

    Parameters
    ----------
    height : array (ny, nx), m
    spacing : (dy, dx), m
    contact_modulus : float, Pa

    Returns
    -------
    float, J/m²

    Examples
    --------
    >>> wave = np.cos(2 * np.pi * np.arange(8) / 8)[None, :]
    >>> energy = full_contact_energy(wave, (1.0, 1.0), 1.0)
    >>> print(round(energy, 6), round(westergaard_energy(1.0, 8.0, 1.0, 1.0), 6))
    0.098175 0.098175
    """
    spectrum = np.abs(np.fft.rfft2(height) / height.size) ** 2
    weighted = halfplane_weights(height.shape) * wavenumbers(height.shape, spacing) * spectrum
    return contact_modulus / 4 * weighted.sum()


def gap_left_by(
    pressure: np.ndarray,
    height: np.ndarray,
    spacing: Sequence[float],
    contact_modulus: float,
    factor: Callable[[np.ndarray], np.ndarray] | None = None,
) -> np.ndarray:
    """Return u - h less its mean over the contact, by NumPy's transforms alone: apart from the solver.

    û = 2 p̂/(E*|q|), q ≠ 0; Johnson (1985), section 13.2, one wave at a time.

    Parameters
    ----------
    pressure : array (ny, nx), Pa
    height : array (ny, nx), m
    spacing : (dy, dx), m
    contact_modulus : float, Pa
    factor : callable, optional
        |q| -> E* |q| S/2 of a body with layers, for finite wavenumbers.

    Returns
    -------
    array (ny, nx), m

    Examples
    --------
    >>> wave = np.cos(2 * np.pi * np.arange(8) / 8)[None, :]
    >>> pressure = 10 + full_contact_fluctuation(wave, (1.0, 1.0), 1.0)
    >>> bool(np.allclose(gap_left_by(pressure, wave, (1.0, 1.0), 1.0), 0))
    True
    """
    q = wavenumbers(height.shape, spacing)
    softer: np.ndarray | float = 1.0
    if factor is not None:
        q[0, 0] = q.max()
        softer = factor(q)
    q[0, 0] = np.inf
    displaced = np.fft.irfft2(2 * softer / (contact_modulus * q) * np.fft.rfft2(pressure), s=height.shape)
    gap = displaced - height
    return gap - gap[pressure > 0].mean()


# --- Rough maps that other codes have solved ---------------------------------------------------------------

# `synthetic.rough_reference_surface` at 1024 x 1024 points, by an independent code. Load p̄/(E* g): (relative
# contact area, perimeter-corrected; mean gap over the rms height), to five decimals
ROUGH_AREA_AND_GAP = {0.05: (0.11614, 0.99125), 0.2: (0.36845, 0.32548), 1.0: (0.96078, 0.00458)}
# `validation.rough.ensemble_map(256, seed=0)`, by Tamaas 2.9.0. Load p̄/E*: (points in contact; largest
# pressure over E*; mean gap over the length of the side)
OUTSIDE_CODES = {
    0.01: (1598, 1.38192689113, 0.0292639610734),
    0.1: (14708, 1.79459795770, 0.0107318478434),
    0.5: (49218, 2.34777477247, 0.00120520856749),
}

# --- Zero frequency ----------------------------------------------------------------------------------------


def nogi_kato_zero_frequency(length_y: float, length_x: float, contact_modulus: float) -> float:
    """Return the mean of 2/(E*|q|) over the cell of the zero frequency.

    G00 = (Lx Ly/4π²)(2/E*) 4 [a asinh(b/a) + b asinh(a/b)], a = π/Lx, b = π/Ly, their average in closed form;
    a square: 1.12220 L/E*. Nogi and Kato (1997).

    Parameters
    ----------
    length_y, length_x : float, m
        sides of the window.
    contact_modulus : float, Pa

    Returns
    -------
    float, m/Pa

    Examples
    --------
    >>> print(round(nogi_kato_zero_frequency(2.0, 2.0, 1.0), 4))
    2.2444
    """
    a, b = np.pi / length_x, np.pi / length_y
    integral = 4 * (a * np.arcsinh(b / a) + b * np.arcsinh(a / b))
    return length_x * length_y / (4 * np.pi**2) * 2 / contact_modulus * integral


# --- heights ----------------------------------------------------------------------------------------------


def gaussian_bearing(rms_height: float) -> dict[str, float]:
    """Return the parameters of the material ratio curve of heights that are normally distributed.

    The curve is z(m) = σ Φ⁻¹(1 − m). The line of its flattest 40 %, which are those in the middle, has by
    least squares the slope −σ [erf(t)/(2√π) − 0.4 φ(t)] 12/0.4³, t = Φ⁻¹(0.7); its ends are Sk apart. Peaks
    and dales beyond them have the areas σ [φ(c) − c (1 − Φ(c))], c = Sk/(2σ), and are drawn as triangles. The
    material down to the ratio m is σ [φ(c) − c m], c = Φ⁻¹(1 − m), and the voids alike. ISO 13565-2:1996; ISO
    25178-2:2021, annex B.

    Parameters
    ----------
    rms_height : float, m

    Returns
    -------
    dict of float
        `Sk`, `Spk`, `Svk`, `Vmc`, `Vvv` (m), `Smr1`, `Smr2` (1).

    Examples
    --------
    >>> found = gaussian_bearing(1.0)
    >>> print(" ".join(f"{name} {value:.3f}" for name, value in found.items()))
    Sk 2.574 Spk 0.945 Svk 0.945 Vmc 0.906 Vvv 0.112 Smr1 0.099 Smr2 0.901
    """
    from scipy.special import erf, ndtr, ndtri

    def height_density(t: float) -> float:
        return float(np.exp(-(t**2) / 2) / np.sqrt(2 * np.pi))

    def material(ratio: float) -> float:
        above = float(ndtri(1 - ratio))
        return height_density(above) - above * ratio

    end = float(ndtri(0.7))
    core = float(erf(end) / (2 * np.sqrt(np.pi)) - 0.4 * height_density(end)) * 12 / 0.4**3
    peaks = float(ndtr(-core / 2))
    triangle = 2 * material(peaks) / peaks * rms_height
    return {
        "Sk": core * rms_height,
        "Spk": triangle,
        "Svk": triangle,
        "Vmc": (material(0.8) - material(0.1)) * rms_height,
        "Vvv": material(0.2) * rms_height,
        "Smr1": peaks,
        "Smr2": 1 - peaks,
    }
