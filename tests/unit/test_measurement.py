"""The record of a measurement: attributes in memory, and the few that a file has."""

import numpy as np
import pytest
import xarray as xr

from roughcontact.arguments import measurement
from roughcontact.arguments.maps import height_map
from roughcontact.io.read import read_height_map
from roughcontact.results.storage import read_dataset, write_dataset
from roughcontact.surface.levelling.level import level
from roughcontact.surface.synthetic import self_affine_surface
from roughcontact.surface.window.periodic_window import periodic_window

MAX_ATTRIBUTES = 22  # of the map; those of its file are eight more


@pytest.fixture(scope="module")
def window(tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "map.npy"
    band = {"hurst": 0.8, "shortest": 8e-6, "longest": 32e-6, "rms_gradient": 0.1}
    np.save(path, self_affine_surface((48, 48), 1e-6, **band, seed=1).values)
    instrument = {"noise": 1e-9, "numerical_aperture": 0.4}
    height = read_height_map(path, dx=1e-6, dy=1e-6, unit="m", height_unit="m", instrument=instrument)
    return periodic_window(level(height))


def test_a_file_has_few_attributes_and_gives_all_of_them_back(window, tmp_path):
    write_dataset(window.to_dataset(), tmp_path / "window.nc")
    with xr.open_dataset(tmp_path / "window.nc") as file:
        assert len(window.attrs) > 60
        assert len(file["height"].attrs) <= MAX_ATTRIBUTES
        assert file["height"].attrs["source_sha256"] == window.attrs["source_sha256"]
        assert '"noise"' not in file["height"].attrs
    restored = read_dataset(tmp_path / "window.nc")["height"].attrs
    assert {key: restored[key] for key in window.attrs} == window.attrs
    assert {key: type(restored[key]) for key in window.attrs} == {
        key: type(value.item() if isinstance(value, np.generic) else value)
        for key, value in window.attrs.items()
    }
    again = read_height_map(tmp_path / "window.nc")
    assert measurement.json_attribute(again.attrs, "instrument") == measurement.json_attribute(
        window.attrs, "instrument"
    )


def test_attributes_of_earlier_files_and_of_other_programs_stay():
    attrs = {"levelling": "by hand", "band": 3, "traces": "[1]", "reading": "{", "Sq": 1e-7}
    assert measurement.map_attributes(attrs) == attrs


@pytest.mark.parametrize(
    "value", [0.1, np.float64(1 / 3), np.int64(3), "ß", True, [1e-6, 3e-6], np.array([1.0])]
)
def test_every_kind_of_value_is_restored(value):
    (text,) = measurement.file_attributes({"summit_x": value}).values()
    assert isinstance(text, str)
    assert measurement.map_attributes({"summit": text}) == {
        "summit_x": value.tolist() if hasattr(value, "tolist") else value
    }


def test_a_map_that_was_read_records_more_than_one_of_an_array(window):
    attrs, array = window.attrs, height_map([[0.0, 1e-9]], 1e-6).attrs
    assert (attrs["source_file"], attrs["missing_points"], attrs["first_row"]) == ("map.npy", 0, "bottom")
    assert array.keys() < attrs.keys() - {"first_row"}
    assert measurement.json_attribute({"instrument": "[3]"}, "instrument") == {}  # of another program


def test_what_is_stated_of_an_instrument_is_one_record(window):
    assert measurement.Instrument.read(window.attrs) == measurement.Instrument(
        noise=1e-9, numerical_aperture=0.4
    )
    assert measurement.Instrument.read({}).attributes() == {}


@pytest.mark.parametrize("fact", [True, False])
def test_a_remark_is_added_to_the_warnings_and_a_fact_to_both(fact):
    attrs = measurement.add_remark({"ingest_warnings": '["a"]', "ingest_facts": '["b"]'}, "c", fact=fact)
    assert measurement.json_attribute(attrs, "ingest_warnings") == ["a", "c"]
    assert attrs.get("ingest_facts") == ('["b", "c"]' if fact else None)
