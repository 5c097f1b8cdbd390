"""Readers of file formats: one per module, found by `roughcontact.io.registry`.

`READER` of a module defines how its format is recognised and read; nothing else names the module.
"""
