"""JPK's fast scans in HDF5, written here by the rules of the format, and a real one beside another reader."""

import json

import numpy as np
import pytest
from measured_files import jpk, refuses, saved, steps
from shared_data import DATA

from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map

COUNTS = np.random.default_rng(4).integers(-(2**30), 2**30, (12, 2), dtype=np.int32)


def scan(path, points=12, unit="m", **grid):
    grid = {"ilength": 4, "jlength": 3, "ulength": 8e-7, "vlength": 9e-7} | grid
    channels = (
        ("phase", "Lock-In Phase", 1e-7, 0.0, "deg"),
        ("amplitude", "Lock-In Amplitude", 1e-17, 0.0, "m"),
        ("height", "Height", -3e-16, 4e-7, unit),
        ("measuredHeight", "Height (measured)", 2e-15, 1e-7, unit),
    )
    return saved(path.parent, jpk(COUNTS[:points], channels, **grid), path.name)


def test_frames_and_quantities_are_channels(tmp_path):
    path = scan(tmp_path / "map.h5-jpk")
    height = read_height_map(path)
    np.testing.assert_allclose(height.values, 2e-15 * COUNTS[:, 0].reshape(3, 4) + 1e-7, rtol=1e-15)
    assert steps(height) == pytest.approx([2e-7, 3e-7])
    assert height.attrs["channel"] == "Height (measured) (retrace, frame 1)"
    assert height.attrs["first_row"] == "bottom"
    assert json.loads(height.attrs["instrument"])["probe"] == "USC"
    other = read_height_map(path, channel="Height (trace, frame 2)")
    np.testing.assert_allclose(other.values, -3e-16 * COUNTS[:, 1].reshape(3, 4) + 4e-7, rtol=1e-15)
    found = inspect_file(path)
    reasons = {each["name"]: each["reason"] for each in found["channels"]}
    assert reasons["Lock-In Phase (trace, frame 1)"] == "values in deg, no length"
    assert reasons["Lock-In Amplitude (retrace, frame 1)"] == "by its name no topography"


def test_what_is_wrong_in_a_scan_is_named(tmp_path):
    refuses("no 3 x 4 points of each frame", scan(tmp_path / "short.h5-jpk", points=11))
    refuses("no channel of this file holds heights", scan(tmp_path / "volts.h5-jpk", unit="V"))
    refuses("are impossible; give dx, dy and unit", scan(tmp_path / "flat.h5-jpk", ulength=0.0))
    turned = read_height_map(scan(tmp_path / "turned.h5-jpk", theta=0.5))
    assert "the scan is turned" in turned.attrs["ingest_warnings"]
    data = (tmp_path / "turned.h5-jpk").read_bytes()
    (tmp_path / "cut.h5-jpk").write_bytes(data[: int(0.6 * len(data))])
    refuses("damaged or cut off HDF5 file", tmp_path / "cut.h5-jpk")


@pytest.mark.shared_data
@pytest.mark.parametrize(
    ("channel", "rms"),
    [
        ("Height (trace, frame 1)", 3.153759787322164e-9),
        ("Height (trace, frame 4)", 2.385664846424173e-9),
        ("Height (retrace, frame 2)", 2.527799639881413e-9),
    ],
)
def test_a_real_scan_as_afmreader_reads_it(channel, rms):
    height = read_height_map(DATA.parent / "more_data" / "sample_0.h5-jpk", channel=channel)
    assert height.shape == (128, 128)
    assert float(height.std()) == pytest.approx(rms, rel=1e-9)
    assert float(height.x[1] - height.x[0]) == pytest.approx(1.171875e-9, rel=1e-12)
