"""Write the default configuration and its schema: `python -m roughcontact.configuration FOLDER`."""

import sys
from pathlib import Path

from roughcontact.configuration.generated import write_generated

write_generated(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
