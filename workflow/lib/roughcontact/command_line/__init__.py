"""The program `roughcontact`: what is in a file, and the contact of one map without any workflow."""
