"""`python -m roughcontact.command_line`, where the program is not installed."""

import sys

from roughcontact.command_line.program import main

if __name__ == "__main__":
    sys.exit(main())
