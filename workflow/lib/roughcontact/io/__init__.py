"""Reading: one measured file in, one labelled height map in SI units out.

A file passes through `registry` (choice of the reader), a module of `readers` (channels in the file's units),
`conversion` (one channel, in metres) and `plausibility`.
"""
