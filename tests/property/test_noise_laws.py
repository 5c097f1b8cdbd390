"""What noise adds to the ±: as much as filter and band leave of it, against the same maps without noise."""

from functools import cache

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.statistics import instrument_checks as checks
from roughcontact.surface.levelling.filters import gaussian_mean_surface
from roughcontact.surface.levelling.repeats import noise_of_repeats
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import self_affine_surface
from roughcontact.surface.window.band import limit_band
from roughcontact.surface.window.instrument import check_instrument
from roughcontact.surface.window.transfer import add_noise, noise_that_remains

S_FILTER, BAND = {"level": {"s_filter": 8e-6}}, {"window": {"shortest_wavelength": 9e-6}}
FILTERS = {"neither": {}, "s_filter": S_FILTER, "band": BAND, "both": S_FILTER | BAND}
NOISE = 9e-9  # 3 % of the rms height
KINDS = ("stated", "repeats", "corrected", "pair", "profile")
NAMES = ("relative_contact_area", "mean_gap", "mean_contact_pressure", "max_pressure")
MAPS = range(3)


def noisy(height: xr.DataArray, noise: float, *seed: int) -> xr.DataArray:
    return height.copy(data=height.values + np.random.default_rng(seed).normal(0, noise, height.shape))


def true_map(kind: str, seed: int) -> xr.DataArray:
    shape = (1, 512) if kind == "profile" else (72, 72)
    waves = {"hurst": 0.8, "shortest": 3e-6, "longest": 40e-6, "rms_height": 3e-7}
    # with hardly any noise it is no more periodic than when it is measured
    return noisy(self_affine_surface(shape, 1e-6, **waves, seed=seed), 1e-3 * NOISE, 0, seed)


@cache
def found(kind: str, filtered: str, seed: int) -> tuple[xr.Dataset, xr.Dataset]:
    """Return the statistics of a map without noise, and of the same one measured with noise."""
    true, settings, instrument = true_map(kind, seed), FILTERS[filtered], {"noise": NOISE}
    measured = noisy(true, NOISE, 1, seed)
    if kind == "repeats":
        instrument = {"noise": noise_of_repeats(measured, noisy(true, NOISE, 2, seed))[0]}
    if kind == "corrected":
        instrument["correct"] = True
    if kind == "pair":  # levelled before they are laid on one another
        level = settings.get("level", {})
        flat = noisy(height_map(np.zeros(true.shape), 1e-6), NOISE, 3, seed)
        true, measured = (
            rc.composite(rc.level(face, **level), rc.level(counter_face, **level))
            for face, counter_face in ((true, 1e-3 * flat), (measured, flat))
        )
        settings = {"window": settings.get("window", {})}
    common = {
        "contact": {"contact_modulus": 1e9, "mean_pressure": [2e6, 1e7]},
        "statistics": {"flow": "never"},
    }
    common |= {"lay": "across"} if kind == "profile" else {}
    bare = rc.evaluate(true, **common, **settings, uncertainty={"sources": []})
    return bare, rc.evaluate(
        measured, **common, **settings, uncertainty={"sources": ["instrument"]}, instrument=instrument
    )


def ends(statistics: xr.Dataset, name: str) -> tuple[np.ndarray, np.ndarray]:
    lower, upper = (statistics[f"{name}_{side}"].values for side in ("lower", "upper"))
    return lower, np.nan_to_num(upper, nan=np.inf)


@pytest.mark.parametrize("kind", KINDS)
def test_intervals_hold_the_map_without_noise_and_are_no_wider_than_noise_makes_them(kind):
    inside = []
    for filtered in FILTERS:
        errors, widths = [], []
        for true, measured in (found(kind, filtered, seed) for seed in MAPS):
            for name in NAMES:
                lower, upper = ends(measured, name)
                value = (true["mean_pressure"] / true[NAMES[0]] if name == NAMES[2] else true[name]).values
                inside += [*(lower <= value * (1 + 1e-3)) & (value <= upper * (1 + 1e-3))]
                errors += [*np.log(value / measured[name].values)]
                widths += [*np.log(upper / lower)]
        assert np.max(widths) < 60 * np.std(errors), filtered
        assert np.median(widths) < 12 * np.std(errors), filtered
    assert np.mean(inside) >= 0.9


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("filtered", [name for name in FILTERS if name != "neither"])
def test_a_filter_widens_no_interval_by_more_than_it_changes(kind, filtered):
    for seed in MAPS:
        (_, neither), (_, with_filter) = (found(kind, name, seed) for name in ("neither", filtered))
        for name in NAMES:
            wide, narrow = (
                np.log(upper / lower) for lower, upper in (ends(neither, name), ends(with_filter, name))
            )
            change = np.abs(np.log(with_filter[name] / neither[name]).values)
            assert (narrow <= wide + change).all(), (name, seed)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("filtered", FILTERS)
def test_no_end_lies_outside_what_is_possible(kind, filtered):
    for seed in MAPS:
        _, measured = found(kind, filtered, seed)
        area, gap, pressure, peak = (ends(measured, name) for name in NAMES)
        assert (area[0] >= 0).all()
        assert (area[1] <= 1).all()
        assert (gap[0] >= 0).all()
        assert (gap[1] <= np.ptp(true_map(kind, seed).values)).all()
        assert (pressure[0] >= measured["mean_pressure"]).all()
        assert (peak[0] >= pressure[0]).all()
        assert (peak[1] >= pressure[1]).all()
        assert (peak[1] < 1e10).all()


@pytest.mark.parametrize(
    ("shape", "pitch"), [((96, 96), (1e-6, 1e-6)), ((75, 128), (2e-6, 1e-6)), ((1, 2048), (1e-6, 1e-6))]
)
@pytest.mark.parametrize(("s_filter", "shortest"), [(0, 0), (5e-6, 0), (0, 6e-6), (5e-6, 8e-6)])
def test_the_noise_that_remains_is_that_of_many_draws(shape, pitch, s_filter, shortest):
    """White noise goes through the filter and the band themselves."""
    window, squares = height_map(np.zeros(shape), pitch), []
    if s_filter:
        window = rc.level(window, form="none", s_filter=s_filter)
    if shortest:
        window = limit_band(window, shortest_wavelength=shortest)
    for seed in range(24):
        white = noisy(height_map(np.zeros(shape), pitch), 1e-9, 4, seed)
        if s_filter:  # as of a periodic map
            tiled = np.tile(white.values, (1 if shape[0] == 1 else 3, 3))
            middle = tuple(slice(0, 1) if n == 1 else slice(n, 2 * n) for n in shape)
            white = white.copy(data=gaussian_mean_surface(tiled, spacing(white), s_filter)[middle])
        if shortest:
            white = limit_band(white, shortest_wavelength=shortest)
        squares.append((float(white.std()) ** 2, rms_gradient(white) ** 2))
    rms_height, gradient = noise_that_remains(window, 1e-9)
    assert (rms_height, gradient) == pytest.approx(tuple(np.sqrt(np.mean(squares, axis=0))), rel=0.03)
    assert float((add_noise(window, 1e-9) + add_noise(window, -1e-9)).std()) == 0


def test_a_map_that_is_levelled_again_keeps_the_record_of_its_filter():
    once = rc.level(true_map("stated", 0), s_filter=8e-6)
    twice = rc.level(once, form="none")
    assert noise_that_remains(twice, 1e-9) == noise_that_remains(once, 1e-9)
    # mean square gradient of white noise, in pixels: 2 π²/3, behind weights exp(-a q²/2) 1/(4 π a²)
    a = np.log(2) * 8**2 / (2 * np.pi**2)
    share = noise_that_remains(once, 1e-9)[1] / noise_that_remains(once.drop_attrs(), 1e-9)[1]
    assert share == pytest.approx(np.sqrt(3 / (8 * np.pi**3)) / a, rel=0.02)


def test_noise_above_the_roughness_that_a_filter_leaves_is_possible():
    smooth = height_map(1e-8 * np.sin(2 * np.pi * np.arange(64) / 64) * np.ones((64, 1)), 1e-6)
    measured = rc.level(noisy(smooth, 2e-8, 0), form="none", s_filter=16e-6)
    assert float(measured.std()) < 2e-8
    check_instrument(measured, {"noise": 2e-8})
    with pytest.raises(rc.SettingsError, match="larger than the rms height"):
        check_instrument(measured, {"noise": 2e-6})


@pytest.mark.parametrize("filtered", FILTERS)
def test_the_share_of_noise_is_that_in_the_map_that_is_solved(filtered):
    settings = FILTERS[filtered]
    measured, noise = (
        rc.periodic_window(rc.level(height, **settings.get("level", {})), **settings.get("window", {}))
        for height in (noisy(true_map("stated", 0), 3e-8, 5), noisy(0 * true_map("stated", 0), 3e-8, 5))
    )
    attrs = measured.attrs | {"instrument_noise": 3e-8}
    share = (rms_gradient(noise) / rms_gradient(measured)) ** 2
    actual = attrs["noise_gradient_share"] * (3e-8 / attrs["noise_floor"]) ** 2
    assert actual == pytest.approx(share, rel=0.35)
    checked = checks.noise(attrs)
    assert checked.outcome == ("review" if filtered == "neither" else "passed")
