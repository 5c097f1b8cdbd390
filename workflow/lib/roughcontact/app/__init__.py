"""The page `roughcontact app`: makes a study folder, runs it and shows its report, on this computer alone.

`server` (`access`: who may ask) answers each button with the `page` as it is after it, which a script puts in
the place of the former one. `study` is what the form says, and its two files; `measurements` are the files of
its rows, `commands` those of the terminal. Rules, sentences and defaults are those of `configuration`.
"""
