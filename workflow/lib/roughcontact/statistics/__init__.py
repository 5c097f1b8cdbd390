"""Numbers of a solved contact, theories beside them, and checks that say what to trust.

The verb is in `contact_statistics`.
"""
