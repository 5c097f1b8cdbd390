"""The page `roughcontact app`: makes a study folder, runs it and shows its report, on this computer alone.

`server` (and who may ask it) answers changed fields and buttons with the `page` as it is after them, which a
script puts in the place of the former one, in every window. `study` is what the fields say, and its two
files; `jobs` are the questions and their fields, `measurements` the files of the rows and their maps,
`commands` those of the terminal. Words, defaults and rules of the fields are those of the settings.
"""
