"""Settings and the table of surfaces: their models, and the messages about mistakes in them.

`models` (the sections) → `fields` (properties of a setting) → `messages` (error messages) → `resolve` (the
settings of every case), `surfaces` (the table) → `study` (both); `yaml_text` (the file, before Snakemake
reads it); `generated` (default configuration, schema); `stages` and `dependencies` define the settings and
source files on which a stage depends, `plan` the files that each job of a run reads and writes, and its
resources.
"""
