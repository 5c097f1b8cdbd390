"""The contact solver: a rough surface pressed on a periodic elastic half-space by a mean pressure.

The verb is in `solve`: it takes a `problem` (checks, dimensionless form) through a `sweep` over the loads.
Each starts from coarser grids (`nested_iteration`) and is solved by the `iteration` on one `grid`. Its
preconditioner rests on the `interpolation` between the active set and the whole grid, by a hierarchy of grids
(`coarsening`). A `line_search` keeps every step downhill; `conjugate_gradients` and `projected_gradient` are
what the iteration falls back on; the `certificate` bounds the error. `response` is the stiffness of a contact
set, `loads` the load plan.
"""
