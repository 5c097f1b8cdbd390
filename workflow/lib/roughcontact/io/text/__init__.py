"""Numeric text files: metadata of the header, table of numbers, and points on a grid."""
