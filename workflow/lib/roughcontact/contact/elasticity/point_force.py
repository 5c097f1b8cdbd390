"""Stresses below a point force, wave by wave, in a cell where no image of the force acts.

Up to the distance `reach` beside the force the stresses are those of the half-space (Boussinesq), beyond it
they fade to zero (`contact.elasticity.free_space` does so with displacements). Short waves keep the
amplitudes that they have without the fade, those of long waves are Hankel transforms by quadrature.
"""

import numpy as np

from roughcontact.contact.elasticity.fade import graded_panels, smooth_fade

TAPER = 1.25  # distance where the stresses vanish over the distance up to which they are exact
_LONG = 200.0  # |q| reach: shorter waves do not notice the fade, which is wider
_EVEN_PANELS = 20  # of the quadrature between 0 and the end


def half_space_amplitudes(x: np.ndarray, ratio: float) -> np.ndarray:
    """Return the stresses (normal, shear, along q, along crests) of a unit wave at q z (Johnson, 13.2)."""
    decay = np.exp(-x)
    normal, with_q = -(1 + x) * decay, (x - 1) * decay
    return np.array([normal, -x * decay, with_q, ratio * (normal + with_q)])


class PointForce:
    """The long waves of a cell, |q| in rad/m, and Bessel's functions of them at the nodes of a quadrature."""

    def __init__(self, q: np.ndarray, reach: float, finest: float):
        from scipy.special import jv  # imported late: stresses of periodic maps need nothing of it

        self.long, self.shallow = q * reach < _LONG, finest
        # equal wavenumbers share a quadrature
        self.q, self.index = np.unique(q[self.long], return_inverse=True)
        outer_radius = TAPER * reach
        self.r, weights = graded_panels(outer_radius, outer_radius / _EVEN_PANELS, finest / 4)
        weights *= smooth_fade(self.r / reach, TAPER)
        self.bessel = [jv(order, self.q[:, None] * self.r) * weights for order in range(3)]

    def amplitudes(self, depth: float, ratio: float) -> np.ndarray:
        """Return the `half_space_amplitudes` (4, long waves) of faded stresses (Johnson 1985, eq. 3.19)."""
        # nearer to the surface, what lies beyond the fade does not depend on the depth
        z, r = max(depth, self.shallow), self.r
        big = np.hypot(r, z)
        slope, ring = (1 - 2 * ratio) * z / big**3, 3 * z * r**2 / big**5
        normal = self.bessel[0] @ (-3 * z**3 * r / big**5)
        shear = self.bessel[1] @ (-3 * z**2 * r**2 / big**5)
        mean = self.bessel[0] @ (r * (slope - ring) / 2)
        difference = self.bessel[2] @ (r * (slope + ring - 2 * (1 - 2 * ratio) / (big * (big + z))) / 2)
        amplitudes = np.array([normal, shear, mean + difference, mean - difference])
        # between that depth and the surface the change is that of plain waves
        amplitudes += half_space_amplitudes(self.q * depth, ratio) - half_space_amplitudes(self.q * z, ratio)
        return amplitudes[:, self.index]
