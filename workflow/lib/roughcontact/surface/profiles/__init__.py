"""The surface behind stylus profiles: its spectrum and heights, surfaces with both, and their scatter."""
