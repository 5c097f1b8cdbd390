"""A plain script around ContactMechanics: read a file, take off a plane, solve every load, print the areas.

    python plain_contactmechanics.py HEIGHTS.npy LOAD ...

Heights and steps between points are in the same unit; loads over E*. The tolerance is its own.
"""

import json
import sys

import numpy as np
from ContactMechanics import make_system
from SurfaceTopography import Topography

heights, loads = np.load(sys.argv[1]), [float(load) for load in sys.argv[2:]]
sides = tuple(float(points) for points in heights.shape)
topography = Topography(heights, sides, periodic=True).detrend("slope")
topography = Topography(np.asarray(topography.heights()), sides, periodic=True)
system = make_system(substrate="periodic", surface=topography, young=1.0)
areas = []
for load in loads:
    result = system.minimize_proxy(external_force=load * heights.size, maxiter=10_000)
    areas.append(float((np.asarray(result.jac) > 0).mean()))
print(json.dumps(areas))
