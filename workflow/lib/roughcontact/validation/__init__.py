"""Validation: what the program computes, held line by line against what is known from elsewhere.

Every line states what was compared, the reference, our value, their deviation, its tolerance, and where
formula, source and test are. Rooms: `lines` (a line, a part, what holds), one module for each part (`paper`,
`waves`, `hertz`, `full_contact`, `convergence`, `rough`, `consistency`), `parts` (their names and the public
verb), `drawing` (figures), `page` (the page for people).
"""
