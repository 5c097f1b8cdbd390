"""Write the default configuration and its schema: `python -m roughcontact.arguments.settings FOLDER`."""

import sys
from pathlib import Path

from roughcontact.arguments.settings.generated import write_generated

write_generated(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
