"""The page with run time and error of each grid and tolerance, surface by surface."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from roughcontact.cost.advice import WORDS, advice, choices, in_words
from roughcontact.quantities import number, percent
from roughcontact.report.charts import COLOURS, MARKERS
from roughcontact.report.figures import as_svg, new_figure
from roughcontact.report.template import template
from roughcontact.results.storage import write_text

_MIN_DRAWN = 1e-8  # of an error, on a logarithmic axis
_TEMPLATES = Path(__file__).with_name("templates")


def write_page(path: str | Path, tables: Mapping[str, pd.DataFrame]) -> None:
    """Write the page, one self-contained HTML file.

    `tables` has the results of `measure.run_time_against_error` by the name of the surface (and case).
    """
    surfaces = [
        {
            "name": name,
            "loads": table["mean_pressure"].nunique(),
            "advice": advice(table),
            "charts": [(words, chart(table, quantity)) for quantity, words in WORDS.items()],
            "rows": [
                [in_words(row), f"{number(row['seconds'], digits=2)} s"]
                + [percent(row[f"{quantity}_error"]) for quantity in WORDS]
                for _, row in choices(table).iterrows()
            ],
        }
        for name, table in tables.items()
    ]
    html = template("cost.html", folder=_TEMPLATES).render(
        surfaces=surfaces, header=["choice", "time of all loads", *WORDS.values()]
    )
    write_text(html, path)


def chart(table: pd.DataFrame, quantity: str) -> str:
    """Return a chart of the time of all loads against the error: a line per grid, a mark per tolerance.

    The quantity is a key of `WORDS`, the chart a data URI.
    """
    from matplotlib.ticker import LogLocator, NullFormatter

    options = choices(table)
    with new_figure(4.3, 3.8) as figure:
        axes = figure.add_subplot()
        grids = options.groupby(["points_x", "points_y"], sort=True)
        for index, (_, rows) in enumerate(grids):
            sides = rows[["points_x", "points_y"]].iloc[0]
            axes.plot(
                100 * np.maximum(rows[f"{quantity}_error"], _MIN_DRAWN),
                rows["seconds"],
                marker=MARKERS[index % len(MARKERS)],
                markersize=5,
                linewidth=0.8,
                color=COLOURS[index % len(COLOURS)],
                label=" × ".join(str(side) for side in sides if side > 1),
            )
        axes.set(xscale="log", yscale="log")
        for axis in (axes.xaxis, axes.yaxis):
            low, high = axis.get_data_interval()
            axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 100 * low else (1,)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
        axes.invert_xaxis()
        axes.set_xlabel(f"error of the {WORDS[quantity]} (%)")
        axes.set_ylabel("time of all loads (s)")
        figure.legend(loc="outside lower center", ncols=3)
        return as_svg(figure)
