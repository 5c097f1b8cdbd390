"""The elastic energy along a step, which is quadratic, and the state where it is least."""

from dataclasses import dataclass, replace

import numpy as np

from roughcontact.contact.state import State, contact_mean


@dataclass(frozen=True)
class LineSearch:
    """The energy E(p) = <p, G p>/2 - <p, H> on the straight line s = p' - p between states of equal load.

    It changes by t <s, v> + t^2 <s, v' - v>/2, with the separations v = G p - H.
    """

    slope: float  # <s, v>, a mean over the grid
    slope_after: float  # <s, v'>

    @property
    def minimizer(self) -> float:
        """The share t of the line at which the energy is least; it may lie beyond the end."""
        curvature = self.slope_after - self.slope
        return -self.slope / curvature if curvature > 0 else np.inf  # a straight line falls without end

    @property
    def descends(self) -> bool:
        """Whether the energy at the end is below that at the start."""
        return self.slope + self.slope_after < 0


def minimize_between(origin: State, target: State, line: LineSearch, *, cap: float) -> State | None:
    """Return the state of least energy on the line; None where the energy rises from the start.

    Both states have the same load. Their fields are linear in the share, so that no application of the
    operator is needed.
    """
    if line.slope >= 0:
        return None
    share = line.minimizer
    pressure = origin.pressure + share * (target.pressure - origin.pressure)
    separation = origin.separation + share * (target.separation - origin.separation)
    # the square of the norm is a parabola along the line, whose curvature is that of the energy
    square = (1 - share) * origin.norm**2 + share * target.norm**2
    square -= share * (1 - share) * (line.slope_after - line.slope)
    return replace(
        target,
        pressure=pressure,
        separation=separation,
        offset=contact_mean(pressure, separation, cap=cap),
        norm=float(np.sqrt(max(square, 0))),
    )
