"""The formats: each module of this folder is one reader, and `roughcontact.io.registry` finds it here.

A module says in `READER` how its format is recognised and how it is read; nothing else names it.
"""
