"""The settings: their models, and the messages about mistakes in them.

`plausible` (numbers with their unit) → `models` (the sections) → `fields` → `messages` → `resolve` (the
settings of every case). `generated` writes the default configuration, `stages` says what a stage depends on.
"""
