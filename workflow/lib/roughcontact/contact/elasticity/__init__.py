"""The elastic half-space: its operators on a periodic grid, and their symbols."""
