"""Maps that the table cuts into parts: names, groups, heights, and what cannot be cut."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.study.table.read import read_surfaces
from roughcontact.study.tiles import Tile, cut, parse_tiles


@pytest.fixture
def read(tmp_path):
    """Return a function that reads a table of surfaces of some rows."""

    def of_rows(*rows, header="surface\tpath\tparts\tgroup\tpart"):
        table = tmp_path / "surfaces.tsv"
        table.write_text("\n".join([header, *rows]) + "\n")
        return read_surfaces(table)

    return of_rows


def test_parts_are_surfaces_of_a_group_with_the_name_of_the_map(read):
    surfaces = read("a\ta.txt\t2 x 2\t\t", "b\tb.txt\t\t\t", "c\tc.txt\t3×1\t\t")
    assert list(surfaces) == ["a-1-1", "a-2-1", "a-1-2", "a-2-2", "b", "c-1-1", "c-2-1", "c-3-1"]
    assert {row.group for name, row in surfaces.items() if name.startswith("a")} == {"a"}
    assert {row.specimen for row in surfaces.values()} == {""}  # each its own
    assert surfaces["a-1-2"].read_arguments == {"parts": [1, 2, 2, 2]}
    assert surfaces["b"].read_arguments == {}
    assert surfaces["b"].group == ""


def test_parts_of_one_map_are_of_one_workpiece_among_other_maps_of_the_group(read):
    rows = read("a\ta.txt\t2x1\thoned\t", "b\tb.txt\t2x1\thoned\tcylinder", "c\tc.txt\t2x1\tlapped\t")
    assert [(row.group, row.specimen) for row in rows.values()] == [
        *[("honed", "a")] * 2,
        *[("honed", "cylinder")] * 2,
        *[("lapped", "")] * 2,
    ]


@pytest.mark.cases
def test_rows_that_cannot_be_cut(read, rows, words):
    with pytest.raises(rc.SettingsError) as caught:
        read(*rows)
    assert words in str(caught.value)


@pytest.mark.cases
def test_what_is_solved_together_with_something_is_not_cut(read, column, cell, words):
    with pytest.raises(rc.SettingsError, match="line 2, parts = 2x2: ") as caught:
        read(f"a\ta.txt\t2x2\t{cell}", "b\tb.txt\t\t", header=f"surface\tpath\tparts\t{column}")
    assert words in str(caught.value)


def test_parts_cover_every_point_once_at_its_place(tmp_path):
    heights = np.arange(35.0).reshape(5, 7)
    heights[0, 0] = np.nan
    path = tmp_path / "map.npy"
    np.save(path, heights)
    height = rc.read_height_map(path, dx=1, dy=1, unit="um")
    pieces = [cut(height, part) for part in parse_tiles("3x2")]
    assert sorted(v for piece in pieces for v in piece.values.ravel() if v == v) == sorted(
        v for v in height.values.ravel() if v == v
    )
    assert pieces[1].x.values.tolist() == height.x.values[2:4].tolist()  # the second along x
    assert (pieces[1].y.values == height.y.values[:2]).all()  # of the lower row
    assert [piece.attrs["missing_points"] for piece in pieces] == [1, 0, 0, 0, 0, 0]
    assert "part 2 of 3 along x, 1 of 2 along y (upwards), of 7 x 5 points" in pieces[1].attrs["ingest_facts"]
    with pytest.raises(rc.HeightMapError, match=r"map.npy: has 5 points along y, too few for parts = 1x6"):
        cut(height, Tile(1, 1, 1, 6))
    with pytest.raises(rc.HeightMapError, match=r"part 1-1 of 7x5 has no measured point"):
        cut(height, Tile(1, 1, 7, 5))
