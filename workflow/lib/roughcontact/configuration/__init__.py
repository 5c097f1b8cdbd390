"""Settings and the table of surfaces: what may stand there, and what is said where it does not fit.

`models` (the sections) → `fields` (what a setting is made of) → `messages` (what is said about a mistake) →
`resolve` (the settings of every case), `surfaces` (the table) → `study` (both); `generated` (default
configuration, schema); `stages` and `dependencies` say which settings and which source files a stage depends
on, `plan` which files each job of a run reads and writes, and what it needs.
"""
