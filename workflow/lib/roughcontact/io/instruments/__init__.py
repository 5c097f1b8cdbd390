"""Instrument files that SurfaceTopography reads: the formats, and the fence around the library."""
