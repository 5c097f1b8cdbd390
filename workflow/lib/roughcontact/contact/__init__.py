"""The contact solver: a rough surface pressed on a periodic elastic half-space by a mean pressure.

Rooms: `problem` (checks and dimensionless form), `levels` (nested grids), `active_set` (the iteration on one
grid), `projected` (the safe step it falls back on), `certificate` (the error bound), `response` (linear
response of a contact set), `loads` (load plans), `solve` (the public verb).
"""

from roughcontact.contact.loads import plan_loads
from roughcontact.contact.response import linear_response
from roughcontact.contact.solve import solve_contact

__all__ = ["linear_response", "plan_loads", "solve_contact"]
