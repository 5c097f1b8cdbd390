"""Two measured faces that touch: their sum, and an ensemble of ways to lay them on one another.

The verbs are in `composite` and `positions`.
"""
