"""The contact solver: a rough surface pressed on a periodic elastic half-space by a mean pressure.

`solve` poses a `problem` (checks, dimensionless form) and solves it in a `sweep` over the loads.
Each starts from coarser grids (`nested_iteration`) and is solved by the `iteration` on one `grid`. Its
preconditioner is based on the `interpolation` between the active set and the whole grid, by a hierarchy of
grids (`coarsening`). A `line_search` ensures that every step lowers the energy; `conjugate_gradients` and
`projected_gradient` are the fallbacks of the iteration; the `certificate` bounds the error. `response` is the
stiffness of a contact set, `loads` the load plan. `free_boundary` solves bodies of finite size.
"""
