"""The page for people: figures, facts, checks in words."""
