"""Draw groups.svg of this folder again, from the report of the first example of docs/how-to/groups.md.

python docs/images/draw_groups.py finishes/results/report.html
"""

import html
import re
import sys
from pathlib import Path
from urllib.parse import unquote

PICTURE = Path(__file__).with_name("groups.svg")


def drawn(report: str) -> str:
    """Return the picture of the groups on a page."""
    source = re.search(r'src="data:image/svg[^,]*,([^"]*)" alt="Groups of maps', report)[1]
    return unquote(html.unescape(source))


if __name__ == "__main__":
    PICTURE.write_text(drawn(Path(sys.argv[1]).read_text(encoding="utf-8")) + "\n", encoding="utf-8")
