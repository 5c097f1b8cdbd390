"""Settings and the table of surfaces: their models, and the messages about mistakes in them.

`models` (the sections) → `fields` → `messages` → `resolve` (the settings of every case), `surfaces` (the
table) → `study` (both). `stages` and `dependencies` say what a stage depends on, `plan` what each job reads,
writes and needs.
"""
