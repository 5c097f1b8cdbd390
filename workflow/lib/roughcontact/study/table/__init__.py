"""The table of surfaces: its text, its columns, its rows, and what rows mean for one another."""
