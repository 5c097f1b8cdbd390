"""Levelling: outliers out, scan lines aligned, form and waviness off, missing points filled in.

The verb is in `level`.
"""
