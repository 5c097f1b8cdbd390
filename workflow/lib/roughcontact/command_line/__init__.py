"""The program `roughcontact`: inspect a file, solve one map without a workflow, run the workflow."""
