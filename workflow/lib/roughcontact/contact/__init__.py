"""The contact solver: a rough surface pressed on a periodic elastic half-space by a mean pressure.

Rooms: `problem` (checks and dimensionless form), `loads` (load plans), `sweep` (loads one after another, on
`levels` of nested grids), `iteration` (on one `grid`; `conjugate` and `projected` are what it falls back on),
`extension` (what makes the preconditioner good), `kernels` and `compiled` (passes over memory), `state`,
`certificate` (the error bound), `response` (linear response of a contact set), `solve` (the public verb).
"""

from roughcontact.contact.loads import plan_loads
from roughcontact.contact.response import linear_response
from roughcontact.contact.solve import SOLVER_SETTINGS, solve_contact

__all__ = ["SOLVER_SETTINGS", "linear_response", "plan_loads", "solve_contact"]
