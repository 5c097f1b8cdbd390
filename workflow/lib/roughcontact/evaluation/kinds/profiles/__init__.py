"""Profiles: one across a lay, solved as endless ridges, or those of a surface behind them."""
