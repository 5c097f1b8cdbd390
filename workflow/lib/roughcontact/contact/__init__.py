"""The contact solver: a rough surface pressed on a periodic elastic half-space by a mean pressure.

`solve` poses a `problem` and solves it in a `sweep` over the loads, each from coarser grids
(`nested_iteration`) by the `iteration` on one `grid`, with the `interpolation` on a hierarchy of grids
(`coarsening`), a `line_search`, and as fallbacks `conjugate_gradients` and `projected_gradient`; the
`certificate` bounds the error.
"""
