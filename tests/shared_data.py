"""Where the folder of real instrument files lies, which is no part of the checkout.

The environment variable ROUGHCONTACT_SHARED_DATA names it; else it is `shared/data` beside the checkout.
Tests that need it carry the mark `shared_data` and are skipped where it is absent.
"""

import os
from pathlib import Path

VARIABLE = "ROUGHCONTACT_SHARED_DATA"
DATA = Path(os.environ.get(VARIABLE) or Path(__file__).parents[2] / "shared" / "data")
FOUND = (DATA / "CATALOG.tsv").is_file()
