"""The page for people: figures, facts, checks in words."""

ONE_PAGE = 12  # results that stand on one page; more have an index, and a page for each surface
