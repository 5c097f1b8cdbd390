"""Levelling: rejects outliers, aligns scan lines, removes form and waviness, fills missing points.

The public function is in `level`.
"""
