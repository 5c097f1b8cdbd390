"""Passes over the points of a grid and Fourier transforms, for any array library; memory and threads."""
