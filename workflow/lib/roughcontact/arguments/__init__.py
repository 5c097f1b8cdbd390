"""What functions are given: maps, numbers with units, bodies, choices, materials, and the `settings`.

Holds their types, checks and conversions. May import nothing of the package but `errors`.
"""
