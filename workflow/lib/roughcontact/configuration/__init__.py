"""Settings and the table of surfaces: what may stand there, and what is said where it does not fit."""
