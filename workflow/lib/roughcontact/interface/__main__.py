"""`python -m roughcontact.interface`, where the program is not installed."""

import sys

from roughcontact.interface.program import main

if __name__ == "__main__":
    sys.exit(main())
