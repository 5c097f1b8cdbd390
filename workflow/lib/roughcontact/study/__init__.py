"""A study: its folder, its two files, what Snakemake runs for it, and what is left of a run.

Holds all that knows the settings file, the table of surfaces and Snakemake. May import everything but
`interface`.
"""
