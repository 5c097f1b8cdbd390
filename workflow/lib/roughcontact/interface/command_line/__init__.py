"""The commands of the program `roughcontact`: inspect a file, solve one map, begin a study, export."""
