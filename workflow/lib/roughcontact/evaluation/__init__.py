"""From a file to its numbers with their ±: the chain of one result.

Holds the `kinds` of problem, the `pipeline` of one result and `evaluate`, which goes all the way. May import
every room below `report`; no report, no study, no program.
"""
