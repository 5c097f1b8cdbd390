"""Instrument files that SurfaceTopography reads: the formats, and safe calls of the library."""
