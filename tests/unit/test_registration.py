"""Maps of one place before and after wear, cropped to what both show, against shifts that are known."""

import numpy as np
import pytest

from roughcontact import HeightMapError, height_map, level, periodic_window, self_affine_surface
from roughcontact.arguments.measurement import json_attribute
from roughcontact.surface.faces.registration import common_part

PITCH = 1e-6
SIDE = 128  # points


def field(seed):
    """Return a rough field that is larger than the maps."""
    waves = {"hurst": 0.8, "shortest": 4 * PITCH, "longest": 64 * PITCH, "rms_height": 3e-7}
    return self_affine_surface((256, 256), PITCH, **waves, seed=seed)


def measured(height, y=0, x=0):
    """Return a map from a corner of a field on, with coordinates and noise of its own."""
    noise = np.random.default_rng(y + x).normal(0, 3e-9, (SIDE, SIDE))
    return height_map(height.values[y : y + SIDE, x : x + SIDE] + noise, PITCH)


@pytest.mark.parametrize("seed", range(4))
def test_maps_of_a_worn_place_show_the_same_points(seed):
    new = field(seed)
    worn, again = (new.clip(max=float(new.quantile(share))) for share in (0.8, 0.6))
    maps = {"new": measured(new), "worn": measured(worn, 9, 5), "again": measured(again, 7, 8)}
    earlier = {"worn": "new", "again": "worn"}
    parts = {name: common_part(maps, earlier, name) for name in maps}
    expected = new.values[9:SIDE, 8:SIDE]
    heights = {"new": new, "worn": worn, "again": again}
    for name, part in parts.items():
        assert part.shape == pytest.approx(expected.shape, abs=2)
        ny, nx = part.shape
        true = heights[name].values[9 : 9 + ny, 8 : 8 + nx]
        assert np.std(part.values[4:-4, 4:-4] - true[4:-4, 4:-4]) < 0.15 * np.std(true), name  # one point off
    assert len({part.shape for part in parts.values()}) == 1
    found, cropped = json_attribute(parts["worn"].attrs, "ingest_facts")
    assert found.startswith("the place of new, shifted by (")
    assert cropped.startswith("cropped to ")


def test_another_place_is_refused():
    maps = {"new": measured(field(5)), "worn": measured(field(5), 110, 110)}
    for name, height in maps.items():
        height.attrs["source_file"] = f"{name}.x3p"
    with pytest.raises(HeightMapError) as caught:
        common_part(maps, {"worn": "new"}, "new")
    text = str(caught.value)
    assert text.startswith("before: worn.x3p does not show the place of new.x3p: its middle fits ")
    assert text.endswith(
        "; measure the same place, shifted by less than a quarter of the map, or leave before empty"
    )


def test_grooves_are_taken_as_they_lie():
    x = np.arange(2 * SIDE) * PITCH
    grooves = height_map(np.tile(1e-6 * np.sin(2 * np.pi * x / (16 * PITCH)), (2 * SIDE, 1)), PITCH)
    maps = {"new": measured(grooves), "worn": measured(grooves.clip(max=0.5e-6), 0, 1)}
    (ny, nx) = common_part(maps, {"worn": "new"}, "new").shape
    assert (nx, ny) == (SIDE - 1, pytest.approx(SIDE, abs=8))


def test_profiles_stand_for_their_surface_and_not_for_a_place():
    maps = {"new": measured(field(1))[:1], "worn": measured(field(2))[:1]}
    assert common_part(maps, {"worn": "new"}, "worn") is maps["worn"]


def test_what_one_map_of_a_place_lacks_is_missing_in_all():
    new, y, x = field(2), 9, 5
    maps = {"new": measured(new), "worn": measured(new.clip(max=float(new.quantile(0.8))), y, x)}
    maps["new"][20:24, 60:70] = np.nan
    maps["worn"][:, :25] = np.nan  # an edge that is masked
    windows = {}
    for name in maps:
        part = common_part(maps, {"worn": "new"}, name)
        assert part.attrs["missing_points"] == int(part.isnull().sum())
        windows[name] = periodic_window(level(part))
    assert windows["new"].shape == windows["worn"].shape
    for axis, shift in {"y": y, "x": x}.items():
        apart = float(windows["new"][axis][0] - windows["worn"][axis][0]) / PITCH
        assert apart == pytest.approx(shift, abs=0.01)
    parts = [common_part(maps, {"worn": "new"}, name).isnull().values for name in maps]
    assert (parts[0] == parts[1]).all()
    found, _ = json_attribute(common_part(maps, {"worn": "new"}, "new").attrs, "ingest_facts")
    assert found.endswith("points that another map of the place lacks: counted as not measured")
