"""The measured surface: levelling, window, roughness, two faces, stylus profiles, synthetic surfaces.

Holds what is done to heights before they are solved, and what describes them. May import `kernels`, `io` and
`arguments`.
"""
