"""The contact solver: a rough surface pressed on a periodic elastic half-space by a mean pressure.

The verb is in `solve`.
"""
