"""Draw overview.svg of this folder again: the overview of the samples, with the map where it was found.

python docs/images/draw_overview.py
"""

from pathlib import Path
from urllib.parse import unquote

import roughcontact as rc
from roughcontact.report.map_plots import height_map
from roughcontact.surface.faces.placing import frame_of_place, placed

ROOT = Path(__file__).parents[2]
PICTURE = Path(__file__).with_name("overview.svg")


def drawn() -> str:
    """Return the picture."""
    fine, overview = (
        rc.level(rc.read_height_map(ROOT / "data_samples" / f"lapped-{name}.txt")) for name in ("50x", "10x")
    )
    shown = placed(fine, overview)
    source = height_map(shown, rectangle=frame_of_place(shown, fine)).source()
    return unquote(source.partition(",")[2])


if __name__ == "__main__":
    PICTURE.write_text(drawn() + "\n", encoding="utf-8")
