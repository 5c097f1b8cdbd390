"""A plain script around Tamaas: read a file, take off a plane, solve every load, print the contact areas.

    python plain_tamaas.py HEIGHTS.npy LOAD ...

Heights and steps between points are in the same unit; loads over E*. The tolerance is that of its examples.
"""

import json
import sys

import numpy as np
import tamaas as tm

tm.set_log_level(tm.LogLevel.error)
heights, loads = np.load(sys.argv[1]), [float(load) for load in sys.argv[2:]]
y, x = np.indices(heights.shape).reshape(2, -1)
plane = np.column_stack([x, y, np.ones(x.size)])
fit = np.linalg.lstsq(plane, heights.ravel(), rcond=None)[0]
heights = (heights - (plane @ fit).reshape(heights.shape)) / heights.shape[0]
model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
model.E, model.nu = 1.0, 0.0
areas = []
for load in loads:
    solver = tm.PolonskyKeerRey(model, heights, 1e-6)
    solver.max_iter = 100_000
    solver.solve(load)
    areas.append(float((model.traction > 0).mean()))
print(json.dumps(areas))
