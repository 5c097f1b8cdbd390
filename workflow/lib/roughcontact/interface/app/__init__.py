"""The page `roughcontact app`: makes a study folder, runs it and shows its report, on this computer alone.

`server` (`access`: who may ask) answers each change and button with the `page` as it is after it, which a
script puts in the place of the former one. `study` is what the form says, and its two files; `jobs` are the
questions and their fields, `measurements` the files of the rows and their maps, `commands` those of the
terminal. Words, defaults and rules of the fields are those of the settings.
"""
