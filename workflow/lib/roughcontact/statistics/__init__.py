"""Numbers of a solved contact, theories beside them, and checks with a verdict.

The verb is in `contact_statistics`.
"""
