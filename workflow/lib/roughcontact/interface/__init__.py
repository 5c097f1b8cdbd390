"""What a person starts: the `program`, its commands (`command_line`) and the page of the `app`.

Holds the programs, and no rule, sentence or number of its own. May import everything.
"""

import os

# The solver has threads of its own; those of linear algebra spin for small matrices, at twice the time.
# Before all else: NumPy reads this when it is imported.
os.environ.setdefault("OMP_NUM_THREADS", "1")
