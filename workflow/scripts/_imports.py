"""What the scripts import: the executor of local runs imports it once, and each job is a fork of it."""

import sys
from importlib import import_module
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "lib"))

MODULES = (
    "netCDF4",
    "roughcontact.evaluation.pipeline",
    "roughcontact.io.read",
    "roughcontact.report.gather",
    "roughcontact.report.panel",
    "scipy.fft",
    "scipy.ndimage",
)
for module in MODULES:
    import_module(module)
import_module("roughcontact.io.registry").readers()
import_module("roughcontact.report.template").read_all()
import_module("roughcontact.results.storage").provenance({})  # versions and commit, which all files name
