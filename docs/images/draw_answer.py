"""Draw answer.png of this folder: a measured map, its contact, and the answer with its interval.

    python docs/images/draw_answer.py results
    python docs/images/draw_answer.py results --check

The numbers are those of a run on the samples. The check fails where they are others than the picture's, by
the rule of `make_pictures.py`.
"""

import sys
from pathlib import Path

import numpy as np
import xarray as xr
from make_pictures import WORDS, difference
from matplotlib.colors import ListedColormap
from PIL import Image

from roughcontact.report.figures import new_figure
from roughcontact.report.units import Unit, interval_at, number_text

PICTURE = Path(__file__).with_name("answer.png")
SURFACE, PRESSURE = "turned", 10e6
APART, TOUCHES, GREY = "#e8eaed", "#c2410c", "#5f6368"
ANSWERS = (  # variable, its name in words, unit
    ("relative_contact_area", "true contact area", Unit(100, "%")),
    ("mean_contact_pressure", "pressure in contact", Unit(1e-6, "MPa")),
    ("mean_gap", "mean gap", Unit(1e6, "µm")),
)


def load_shown(results: xr.Dataset) -> int:
    """Return the index of the load that is shown."""
    return int(np.abs(results["mean_pressure"].values - PRESSURE).argmin())


def answers(statistics: xr.Dataset) -> list[tuple[str, str]]:
    """Return each answer and, in words, what it is and its interval, with the digits of the report."""
    rows, load = [], load_shown(statistics)
    for name, words, unit in ANSWERS:
        value = number_text(statistics, name, unit, load).split()[0]
        decimals = len(value.partition(".")[2])  # the ends have those of the value
        ends = (f"{unit.factor * end:.{decimals}f}" for end in interval_at(statistics, name, load)[1:])
        rows.append((f"{value} {unit.symbol}", f"{words}: {' to '.join(ends)} {unit.symbol}"))
    return rows


def words_of(rows: list[tuple[str, str]]) -> str:
    """Return the words of the picture."""
    return "; ".join(" ".join(row) for row in rows)


def draw(folder: Path) -> None:
    """Draw the picture from the folder of a surface."""
    statistics, contact = (xr.load_dataset(folder / f"{name}.nc") for name in ("statistics", "contact"))
    rows = answers(statistics)
    touches = contact["pressure"].isel(load=load_shown(contact)) > 0
    width, length = (1e6 * contact[axis].values.max() for axis in "xy")
    with new_figure(11.0, 3.5, layout=None) as figure:
        of_map = (0.05, "1   the measured map", contact["height"], "viridis", "y (µm)")
        title = f"2   where it touches at {PRESSURE / 1e6:.0f} MPa"
        of_contact = (0.365, title, touches, ListedColormap([APART, TOUCHES]), "")
        for left, title, values, colours, ylabel in (of_map, of_contact):
            axes = figure.add_axes((left, 0.12, 0.275, 0.76))
            axes.imshow(
                values, origin="lower", extent=(0, width, 0, length), cmap=colours, interpolation="nearest"
            )
            axes.set(xlabel="x (µm)", ylabel=ylabel)
            axes.set_title(title, loc="left", fontweight="bold", fontsize=12)
            axes.grid(visible=False)
        figure.text(0.70, 0.845, "3   the answer, with its interval", fontweight="bold", fontsize=12)
        for (value, words), top in zip(rows, (0.68, 0.43, 0.18), strict=True):
            figure.text(0.70, top, value, fontsize=24, fontweight="bold", color=TOUCHES)
            figure.text(0.70, top - 0.07, words, fontsize=11, color=GREY)
        figure.savefig(PICTURE, dpi=110, metadata={"Software": None, WORDS: words_of(rows)})


if __name__ == "__main__":
    RESULTS = Path(sys.argv[1]) / SURFACE
    if "--check" in sys.argv:
        words = words_of(answers(xr.load_dataset(RESULTS / "statistics.nc")))
        stale = difference(Image.open(PICTURE).text.get(WORDS, ""), words)
        sys.exit(f"{PICTURE} is of other results ({stale}): draw it again" if stale else 0)
    draw(RESULTS)
