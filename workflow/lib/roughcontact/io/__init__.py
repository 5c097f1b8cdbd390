"""Reading: one measured file in, one labelled height map in SI units out.

The verb is in `read`; `readers` has one module for each family of formats.
"""
