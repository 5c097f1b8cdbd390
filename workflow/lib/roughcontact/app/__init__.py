"""The page `roughcontact app`: makes a study folder, runs it and shows its report, on this computer alone.

`server` (requests, and who may make them) → `study` (settings and table as texts of a form, inspected files),
`run` (the command of the terminal); `fields` makes the form from the models of the settings. Rules, sentences
and defaults are those of `configuration`; what it does in the folder the commands do as well.
"""
