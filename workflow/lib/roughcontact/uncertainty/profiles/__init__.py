"""The ± of the surface behind stylus profiles: the scatter of its members, and the contrast of its ridges."""
