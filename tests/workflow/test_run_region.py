"""A crop and a mask in the table of surfaces: a run gives what the heights cut by hand give."""

import numpy as np
import pytest
import xarray as xr
from small_project import ROOT, Project

import roughcontact as rc
from roughcontact.surface.synthetic import self_affine_surface

SETTINGS = {
    "surfaces": "surfaces.tsv",
    "contact": {"contact_modulus": "1e9", "relative_pressure": [0.1], "tolerance": "1e-5"},
    "uncertainty": {"sources": ["solver"]},
}
TABLE = (
    "surface\tpath\tunit\tdx\tdy\tcrop\tmask",
    "Prüfling-表\tmeasured/ground.npy\tum\t1\t1\t8 16 72 80 um\t20 20 26 28 um; 60 40 66 43 um",
)


def test_a_run_gives_what_the_heights_cut_by_hand_give(tmp_path):
    project = Project(tmp_path, ROOT)
    surface = self_affine_surface((96, 96), 1.0, hurst=0.8, shortest=6, longest=60, rms_gradient=0.1, seed=2)
    heights = surface.values.copy()
    heights[20:28, 20:26] += 20  # dust
    np.save(project.path("measured/ground.npy"), heights)
    project.write(SETTINGS, TABLE)
    run = project.succeed()
    assert "cropped to 64.0 µm × 64.0 µm of 96.0 µm × 96.0 µm (crop = 8 16 72 80 um)" in run.stderr
    by_hand = surface.values.copy()
    by_hand[20:28, 20:26] = by_hand[40:43, 60:66] = np.nan
    cut = rc.height_map(1e-6 * by_hand[16:80, 8:72], "1 um")
    options = {key: value for key, value in SETTINGS.items() if key != "surfaces"}
    expected = rc.evaluate(cut, **options)
    found = xr.load_dataset(project.path("results/Prüfling-表/statistics.nc"))
    for name in ("relative_contact_area", "mean_gap", "max_pressure", "rms_gradient"):
        assert found[name].values == pytest.approx(expected[name].values, rel=1e-6)
    # the name, of letters of any script, is that of its folder
    assert xr.load_dataset(project.path("results/statistics.nc"))["surface_name"].values == ["Prüfling-表"]
    page = project.path("results/report.html").read_text()
    assert "Prüfling-表" in page
    assert "2 rectangles masked" in page.replace("Rectangles", "rectangles")
    assert "ropped to 64.0 µm × 64.0 µm" in page
    assert "points not measured (pink)" in page
    # another rectangle makes the map again
    project.write(SETTINGS, (TABLE[0], TABLE[1].replace("72 80 um", "71 80 um")))
    assert project.jobs()["prepare"] == 1
