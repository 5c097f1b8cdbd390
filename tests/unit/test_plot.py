"""Figures on axes of Matplotlib: the numbers of the report, read back from what is drawn."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine
from test_load_plots import AREAS, LOADS, numbers

import roughcontact as rc
from roughcontact import SettingsError, height_map
from roughcontact.surface.synthetic import rough_reference_surface


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def line(ax, label):
    (match,) = [candidate for candidate in ax.get_lines() if candidate.get_label() == label]
    return match


def bars(ax):
    """Return the ends of the error bars."""
    (drawn,) = [c for c in ax.containers if isinstance(c, matplotlib.container.ErrorbarContainer)]
    return np.array([segment[:, 1] for segment in drawn.lines[2][0].get_segments()]).T


def test_the_area_has_the_values_and_bars_of_the_report():
    _, axes = plt.subplots()
    ax = rc.plot.area(numbers(), ax=axes)
    assert ax is axes
    assert line(ax, "solved, corrected").get_xydata() == pytest.approx(np.c_[LOADS / 1e6, 100 * AREAS])
    assert bars(ax) == pytest.approx(100 * np.array([0.9 * AREAS, 1.2 * AREAS]))
    assert (ax.get_xlabel(), ax.get_xscale(), ax.get_yscale()) == ("mean pressure (MPa)", "log", "log")


def test_pressures_end_at_the_hardness_and_loads_are_in_order():
    shuffled = numbers(hardness=1e9).isel(load=[2, 0, 1])
    ax = rc.plot.pressure(shuffled)
    assert line(ax, "largest").get_xydata() == pytest.approx(np.c_[LOADS / 1e6, [800, 900, 1000]])
    segments = [segment for artist in ax.containers for segment in artist.lines[2][0].get_segments()]
    # what is the hardness has no bar, it is taken as exact
    assert max(segment[1, 1] for segment in segments if len(segment)) == pytest.approx(1000)


def test_no_line_of_the_budget_lies_under_the_legend():
    surface = rough_reference_surface(64)
    contact = {"contact_modulus": 1e9, "relative_pressure": [0.02, 0.1, 0.5]}
    ax = rc.plot.budget(rc.evaluate(surface, contact=contact, uncertainty={"windows": 4}))
    ax.figure.canvas.draw()
    legend = ax.get_legend().get_window_extent()
    for curve in ax.get_lines():
        drawn = ax.transData.transform(curve.get_xydata())
        assert not any(legend.contains(*point) for point in drawn[np.isfinite(drawn).all(axis=1)])


def test_an_end_that_is_not_known_reaches_the_edge():
    open_end = numbers()
    open_end["relative_contact_area_upper"][2] = np.inf
    open_end["relative_contact_area_lower"][0] = 0.0
    low, high = bars(rc.plot.area(open_end))
    ax = plt.gca()
    assert low[0] < ax.get_ylim()[0] < low[1]
    assert high[1] < ax.get_ylim()[1] < high[2] < np.inf
    open_end["relative_contact_area_upper"][2] = np.nan  # nothing bounds it: an arrow
    ax = rc.plot.area(open_end)
    assert bars(ax)[1][2] > ax.get_ylim()[1]
    (arrow,) = [
        curve
        for curve in ax.get_lines()
        if curve.get_marker() == "^" and curve.get_transform() != ax.transData
    ]
    assert arrow.get_xydata() == pytest.approx(np.array([[LOADS[2] / 1e6, 1.0]]))


def test_maps_lie_upright_with_the_limits_of_the_report():
    pressure, gap = np.zeros((1, 4, 5)), np.full((1, 4, 5), 1e-6)
    pressure[0, 3, 1], gap[0, 3, 1] = 2e6, 0  # at the top
    contact = xr.Dataset(
        {"pressure": (("load", "y", "x"), pressure), "gap": (("load", "y", "x"), gap)},
        coords={"mean_pressure": ("load", [1e5])},
    ).assign(height=height_map(np.eye(4, 5) * 1e-6, 1e-6), contact_modulus=1e9)
    ax = rc.plot.maps(contact)
    (image,) = ax.images
    assert image.origin == "lower"
    assert image.get_extent() == pytest.approx([0, 5, 0, 4])
    assert (image.get_array().compressed() == [2.0]).all()
    assert (~np.ma.getmaskarray(image.get_array())).nonzero() == ([3], [1])
    assert image.get_clim() == (0, 2)
    assert ax.get_title() == "0.100 MPa: 5.00 % of the pixels touch"
    gaps = rc.plot.maps(contact.isel(load=0), quantity="gap").images[0].get_array()
    assert gaps.count() == 19
    row = contact.isel(y=[3])
    assert rc.plot.maps(row).get_lines()[0].get_ydata() == pytest.approx([0, 2, 0, 0, 0])


def test_budget_and_magnification_have_a_line_for_each():
    sources = ["solver", "window", "combined"]
    parts = AREAS[:, None] * [0.001, 0.1, 0.15]
    statistics = numbers(relative_contact_area_uncertainty=(("load", "source"), parts)).assign_coords(
        source=sources
    )
    assert line(rc.plot.budget(statistics), "window").get_ydata() == pytest.approx([10, 10, 10])
    cutoffs = {"cutoff_wavelength": ("cutoff", [1e-6, 2e-6, np.nan])}  # padded, as one of several surfaces is
    statistics = statistics.assign(
        relative_contact_area_at_cutoff=(("load", "cutoff"), AREAS[:, None] * [1, 2, np.nan])
    )
    ax = rc.plot.magnification(statistics.assign_coords(cutoffs))
    assert line(ax, "5.00 MPa").get_ydata() == pytest.approx([2, 4])


@pytest.mark.parametrize(
    ("draw", "wrong", "message"),
    [
        (rc.plot.area, xr.Dataset(), "has no mean_pressure: give the result of evaluate"),
        (rc.plot.area, numbers().expand_dims("surface"), r"more than one surface: choose one, .sel\(surface"),
        (rc.plot.area, numbers().isel(load=0), "a single load, no curve"),
        (rc.plot.area, numbers() * np.nan, "flat"),
        (rc.plot.maps, numbers(), "has no height: give the solution"),
        (rc.plot.budget, numbers(), "has no relative_contact_area_uncertainty"),
        (rc.plot.magnification, numbers(), "has no relative_contact_area_at_cutoff"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_a_sentence(draw, wrong, message):
    wrong = wrong.assign(mean_pressure=("load", LOADS)) if "flat" in message else wrong
    with pytest.raises(SettingsError, match=message):
        draw(wrong)


def test_heights_are_drawn_in_a_unit_that_suits_them():
    height = self_affine((16, 32), 1e-6, (4e-6, 16e-6), rms_gradient=0.1, seed=1)
    micrometres = (height * 1e6).assign_attrs(units="um").assign_coords(height.coords)
    axes = [rc.plot.height(drawn) for drawn in (height, micrometres)]
    assert [ax.get_xlim() for ax in axes] == [pytest.approx((0, 32))] * 2
    images = [ax.images[0].get_array() for ax in axes]
    np.testing.assert_allclose(images[1], images[0])
    scale = np.ptp(images[0]) / np.ptp(height.values)
    assert scale == pytest.approx(
        {"nm": 1e9, "µm": 1e6}[axes[0].images[0].colorbar.ax.get_ylabel().split("(")[1][:2]]
    )


def test_a_notebook_completes_the_functions_alone():
    assert dir(rc.plot) == sorted(rc.plot.__all__)
