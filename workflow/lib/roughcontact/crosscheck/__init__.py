"""The same problem solved by another code, run as an outside program."""
