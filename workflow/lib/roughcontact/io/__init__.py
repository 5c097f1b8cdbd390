"""Reading: one measured file in, one labelled height map in SI units out.

The verbs are in `read` and `inspection`. A file passes through `registry` (which reader knows it), a module
of `readers` (its channels, in its own units), `conversion` (one channel, in metres) and `plausibility`.
"""
