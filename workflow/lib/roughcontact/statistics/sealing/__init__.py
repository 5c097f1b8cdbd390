"""Sealing: percolation of the gap, its narrowest place, and the flow of a fluid through it."""
