"""Run time against error, measured on a map itself, for every grid and tolerance.

Modules: `measure` (grids, times, errors), `advice` (the cheapest choice for a wanted error, in words),
`page`.
"""
