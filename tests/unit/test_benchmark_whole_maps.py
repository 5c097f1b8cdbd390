"""The benchmark of whole maps counts verdicts and widths, and leaves out what is no map."""

import json

import numpy as np
import whole_maps
import xarray as xr


def statistics(area, upper, verdict):
    """Return statistics of a map whose lower ends are 80 % of the results."""
    area = np.array(area)
    suffixes = {"": area, "_lower": 0.8 * area, "_upper": np.array(upper)}
    columns = {
        name + suffix: ("load", values)
        for name in whole_maps.WIDTHS.values()
        for suffix, values in suffixes.items()
    }
    return xr.Dataset(
        columns | {"max_pressure_upper": ("load", np.array(upper)), "verdict": ("load", verdict)},
        attrs={"reasons": json.dumps([{"check": "Noise"}])},
    )


def test_verdicts_and_widths_are_counted():
    results = {
        # half-widths of 10, 20 and 40 %; the first load has less than 2 % in contact
        "one.sur": statistics([0.01, 0.1, 0.2, 0.4], [1.0, 0.1, 0.24, 0.64], [0, 0, 1, 1]),
        "two.x3p": statistics([0.1], [np.nan], [0]),  # open above
    }
    rows = whole_maps.tables(results)["maps"].set_index("map")
    assert rows.loc["one.sur"].tolist() == ["4", "2", "20", "20", "20", "100", "Noise"]
    assert rows.loc["two.x3p", ["use", "area ± (%)"]].tolist() == ["1", "inf"]
    assert rows.loc["all 2"].tolist() == [
        "5",
        "3",
        "30",
        "30",
        "30",
        "75",
        "area ± 30 % for 50 %; pressure ± 30 % for 50 %; gap ± 30 % for 50 %",
    ]


def test_files_that_are_no_maps_are_left_out(tmp_path):
    words = tmp_path / "notes.txt"
    words.write_text("no numbers here")
    assert whole_maps.evaluated(words) is None
