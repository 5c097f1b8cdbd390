"""Run time against error, measured on a map itself: what each grid and tolerance costs, and what it gives.

Rooms: `measure` (grids, times, errors), `advice` (the cheapest way to a wanted error, in words), `page`.
"""
