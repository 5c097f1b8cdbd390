"""The gap as a path for a fluid: whether it is open, how narrow it is, how much flows."""
