"""Contact of two measured faces: their composite height, and an ensemble of relative positions.

The public functions are in `composite` and `positions`.
"""
