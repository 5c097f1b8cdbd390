"""Areas of the contact patches."""

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad
from scipy.special import ellipe

import roughcontact as rc
from roughcontact.arguments.variables import describe
from roughcontact.results.collect import collect_statistics, summary_table
from roughcontact.results.storage import write_dataset
from roughcontact.statistics.sealing.connectivity import connected_regions, region_sizes
from roughcontact.surface.roughness.heights import height_parameters
from roughcontact.surface.synthetic import rough_reference_surface, westergaard_surface
from validation import closed_forms
from validation.surfaces import product_wave_surface


@pytest.mark.parametrize("seed", range(5))
def test_sizes_are_those_of_the_labelled_regions(seed):
    inside = np.random.default_rng(seed).random((23, 31)) < 0.5
    region, _ = connected_regions(inside)
    assert sorted(region_sizes(inside)) == sorted(np.bincount(region.ravel())[1:])
    assert region_sizes(inside).sum() == inside.sum()
    assert region_sizes(~inside | inside).tolist() == [inside.size]
    assert region_sizes(inside & ~inside).size == 0


@pytest.fixture(scope="module")
def statistics():
    contact = rc.solve_contact(
        rough_reference_surface(64), contact_modulus=1.0, mean_pressure=[0.02, 0.1, 5.0]
    )
    return contact, describe(rc.contact_statistics(contact, flow="never"))


def test_patches_of_a_solved_contact(statistics):
    contact, stats = statistics
    pixel = 1 / 64**2
    for load in range(3):
        sizes = region_sizes(contact["pressure"].values[load] > 0)
        assert stats["contact_clusters"][load] == sizes.size
        assert stats["largest_patch_area"][load] == pytest.approx(sizes.max() * pixel)
    width = stats["patch_bin_bounds"].diff("bounds").isel(bounds=0)
    np.testing.assert_allclose((stats["patch_area_density"] * width).sum("patch_bin"), 1, rtol=1e-12)
    # full contact is one patch
    assert stats["largest_patch_area"][2] == pytest.approx(1)
    assert stats["largest_patch_area"].attrs["units"] == "m2"
    centres, means = (
        stats["patch_bin_centre"],
        (stats["patch_area_density"] * width * stats["patch_bin_centre"]).sum("patch_bin"),
    )
    expected = stats["relative_contact_area_pixels"] / stats["contact_clusters"]
    assert (abs(means / expected - 1)[:2] < 0.3).all()  # centres of bins stand for what is in them
    assert (np.diff(centres) > 0).all()


@pytest.mark.parametrize("ratio", [0.1, 0.6])
def test_ridges_touch_in_one_patch_each(ratio):
    ridges = westergaard_surface((1, 768), 1 / 256, amplitude=0.01, wavelength=1.0)
    load = ratio * closed_forms.westergaard_full_contact_pressure(0.01, 1.0, 1.0)
    contact = rc.solve_contact(ridges, contact_modulus=1.0, mean_pressure=[load], tolerance=1e-8)
    sizes = region_sizes(contact["pressure"].values[0] > 0)
    assert sizes.size == 3
    np.testing.assert_allclose(sizes / 256, closed_forms.westergaard_contact_share(ratio), atol=2 / 256)


def test_the_product_wave_touches_in_two_equal_patches():
    wave = product_wave_surface((128, 128), 1 / 128, amplitude=0.01, wavelength=1.0)
    load = 0.1 * closed_forms.jgh_full_contact_pressure(0.01, 1.0, 1.0)
    contact = rc.solve_contact(wave, contact_modulus=1.0, mean_pressure=[load])
    sizes = region_sizes(contact["pressure"].values[0] > 0)
    assert sizes.size == 2
    np.testing.assert_allclose(sizes / 128**2, closed_forms.JGH_CONTACT_SHARE[0.1] / 2, rtol=0.04)


def test_developed_area_of_a_wave():
    """The closed form of its length by quadrature, and what the parameter makes of fine steps."""
    square = (2 * np.pi * 0.1) ** 2
    reference = 2 / np.pi * np.sqrt(1 + square) * ellipe(square / (1 + square)) - 1
    length, _ = quad(lambda x: np.sqrt(1 + square * np.sin(2 * np.pi * x) ** 2), 0, 1)
    assert reference == pytest.approx(length - 1, rel=1e-10)
    wave = westergaard_surface((3, 4097), 1 / 4096, amplitude=0.1, wavelength=1.0)
    assert height_parameters(wave)["Sdr"] == pytest.approx(reference, rel=1e-6)


def test_they_reach_the_table_of_all_surfaces(statistics, tmp_path):
    write_dataset(statistics[1], tmp_path / "statistics.nc")
    collected = collect_statistics([{"surface": "a", "case": None, "statistics": tmp_path / "statistics.nc"}])
    assert isinstance(collected, xr.Dataset)
    table = summary_table(collected)
    assert "largest_patch_area_m2" in table
    assert "patch_area_density_per_m2" not in table
    assert len(table) == 3
