"""Checks of what the instrument, its software or dust made of the surface, and of its units.

`height` and `window` are attributes of the map as measured (`instrument` is JSON) and of the periodic window;
how often the checks flag maps is in `benchmarks/results/instrument_checks.csv`.
"""

import re
from collections.abc import Iterator
from itertools import chain

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import spacing
from roughcontact.arguments.measurement import Instrument, json_attribute
from roughcontact.arguments.quantities import number, percent
from roughcontact.io.instrument_kinds import PROBE, UNKNOWN, Kind, of_name
from roughcontact.statistics.map_checks import Attributes
from roughcontact.statistics.outcome import REVIEW, Check, judge
from roughcontact.statistics.selected_loads import Statistics, largest_of_loads
from roughcontact.surface.levelling.record import s_index
from roughcontact.surface.roughness.traces import MAX_GRADIENT
from roughcontact.surface.window.band import is_limited_by_grid, shortest_reliable_wave

# Self-affine surfaces fall with an exponent of -2 to -4, those with a bounded curvature with -6; measured
# maps that no filter touched reach -5.7. Filters, lenses and interpolation reach -8 to -20.
SPECTRUM_ENDS = MAX_GRADIENT
# Change of the exponent from the last octave but one to the last one. Measured maps reach -0.9; a lens that
# makes areas 25 to 50 % too large, with no end before the pixel, gives -0.9 to -2.
BENT = -1.0
# Powers of two by which peaks are blunter than valleys. Measured maps mostly stay below 0.2, some of probe
# microscopes reach 0.5, worn surfaces with deep scratches 0.3; a tip that changes the area by more than 5 %
# mostly gives 0.8 to 3.
ROUNDED = 0.6
# Repeated heights over those of quantised ones: 0.7 to 1.35 in measured maps, above 2 after a median filter.
REPEATED = 1.45
# Largest pressure over the mean in contact. At small loads the share exp(-pi x^2/4) of the points in contact
# bears more than x times the mean (Persson 2001): five times, one of 3e8.
PEAK_OVER_MEAN = 5.0
CHANCE = 0.01  # that the highest summit stands so far above the next one, as of Grubbs's test in ISO 5725-2
# exponent above which the Hurst exponent would be negative: noise, or shorter waves folded back by sampling
WHITE = -2.0
# beyond both a noise that was not stated counts as the largest part of the gradient
NEARLY_WHITE, MOST_OF_THE_GRADIENT = -1.5, 0.5
NOISE_SHARE = 0.2  # share of the mean square gradient that makes areas 11 % too small
# Quantisation step over rms height. Above the first it is in the instrument's uncertainty, which holds up to
# the second (`benchmarks/measurement.py`); areas are 1 % too small at 0.03, 7 % at 0.1, a quarter at 0.4.
COARSE_STEP, TOO_COARSE_STEP = 0.02, 0.4
# Noise between neighbouring pixels below which nothing measures: averaging interferometers reach 0.05 nm,
# the quietest probe microscopes 5 pm
QUIETEST, QUIETEST_PROBE = 5e-11, 5e-12
_PROBE_PIXEL = 1e-7  # a smaller pixel is that of a probe microscope, whatever the file says
_CAMERA = (1e-6, 6e-5)  # pitch of camera pixels, binned ones included

_OR = ", or "  # between remedies


def shortest_measured_wave(window: xr.DataArray) -> float:
    """Return the shortest wave (m) of a window: of pixels, band or S-filter, or where its spectrum ends."""
    ends = window.attrs.get("spectrum_exponent", 0.0) < SPECTRUM_ENDS
    spectrum_end = window.attrs["spectrum_end"] if ends else 0.0
    return max(2 * max(spacing(window)), shortest_reliable_wave(window), s_index(window.attrs), spectrum_end)


def smoothed(window: Attributes) -> Check:
    """Check that the map was measured down to its pixels, or that what smoothed it is stated or removed.

    A spectrum that ends before the pixel (lens, filter, interpolation) or bends down in its last octave
    (lens), blunt peaks (stylus) and repeated heights (median filter) show that it was not.
    """
    # a synthetic map has no instrument
    is_periodic, has_spectrum = window.get("periodisation") == "none", "spectrum_exponent" in window
    traces = [] if is_periodic or not has_spectrum else [*_traces(window)]
    # what is stated already is no reason to ask again
    open_traces = [trace for trace in traces if trace.outcome == REVIEW]
    remedies = chain.from_iterable(trace.advice.split(_OR) for trace in open_traces)
    advice = _OR.join(dict.fromkeys(remedies))
    findings = [f"{trace.finding}." for trace in open_traces or traces]
    return judge(
        "Smoothed",
        {"periodic": is_periodic, "few waves": not has_spectrum, "traces": open_traces, "stated": traces},
        findings=" ".join(findings),
        first=findings[0] if findings else "",
        further="".join(f"{finding} " for finding in findings[1:]),
        advice=f"{advice[:1].upper()}{advice[1:]}.",
        exponent=window.get("spectrum_exponent"),
    )


def _traces(window: Attributes) -> Iterator[Check]:
    """Yield what an instrument left in a map, and what the user can do; passed where it is stated."""
    limit, pixel = _removed_below(window), window.get("pixel_pitch", 0.0)
    exponent, bend = window["spectrum_exponent"], window.get("spectrum_bend", 0.0)
    if exponent < SPECTRUM_ENDS:
        length = window["spectrum_end"]
        pixels = f" ({number(length / pixel, digits=2)} pixels)" if pixel else ""
        cases = {"stated end": length <= limit, "end": True}
        yield judge("Smoothed", cases, length=length, pixels=pixels, exponent=exponent)
    elif bend < BENT:
        yield judge("Smoothed", {"stated bend": pixel <= limit, "bend": True}, bend=-bend)
    if window["rounded_peaks"] > ROUNDED:
        radius = window["sharpest_peak_radius"]
        # half the radius: its estimate from the sharpest peaks is coarse
        is_stated = (Instrument.read(window).tip_radius or 0.0) > radius / 2
        yield judge("Smoothed", {"stated tip": is_stated, "tip": True}, radius=radius)
    if window.get("repeated_heights", 0.0) > REPEATED:  # which no setting states
        yield judge("Smoothed", {"median filter": True})


def _removed_below(window: Attributes) -> float:
    """Return the wavelength below which the settings remove waves or say that none was measured."""
    instrument = Instrument.read(window)
    band = 0.0 if is_limited_by_grid(window) else float(window["band_shortest"])
    # a Gaussian filter passes half at its nesting index; the fall that is found lies below it
    limits = instrument.resolution or 0.0, instrument.lateral_period_limit or 0.0, band, s_index(window)
    # an end is found to half an octave
    return float(np.sqrt(2) * max(limits))


def isolated_peak(statistics: Statistics, window: Attributes) -> Check:
    """Check that no single summit stands far above all others and carries a pressure far above the mean."""
    chance, ratio_to_next = (window.get(f"summit_{name}", np.inf) for name in ("chance", "over_next"))
    # at the load where it is largest: at low loads a summit is alone
    peak, mean = (statistics[name].values for name in ("max_pressure", "mean_contact_pressure"))
    over_mean = largest_of_loads(peak / mean)
    cases = {
        "no summit": "summit_chance" not in window,
        "common": not (over_mean > PEAK_OVER_MEAN and chance < CHANCE),
        "only one": np.isinf(ratio_to_next),
    }
    place = {axis: window.get(f"summit_{axis}") for axis in "xy"}
    return judge("Isolated peak", cases, over_mean=over_mean, ratio_to_next=ratio_to_next, **place)


def noise(window: Attributes) -> Check:
    """Check that noise, `instrument_noise` (m) or a flat spectrum, makes up little of the gradient."""
    floor, share = (float(window.get(name, 0.0)) for name in ("noise_floor", "noise_gradient_share"))
    if stated_noise := (Instrument.read(window).noise or 0.0) if floor > 0 else 0.0:
        # the gradient of white noise goes with its rms height
        share *= (stated_noise / floor) ** 2
    cases = {
        "few waves": "noise_floor" not in window,
        "falls": not (stated_noise or _ends_flat(window)),
        "corrected": stated_noise and "corrected_for" in window,
        "small, stated": stated_noise and share <= NOISE_SHARE,
        "small": share <= NOISE_SHARE,
        "stated": stated_noise,
    }
    # the area goes as 1 / g; the gradient of a floor can exceed the whole
    small = f"by up to {percent(1 - np.sqrt(1 - share))}" if share < 1 else "by an unknown factor"
    facts = {"share": percent(share) if share < 1 else "all", "small": small, "noise": stated_noise}
    return judge("Noise", cases, **facts, floor=floor, exponent=window.get("top_exponent"))


def suspected_noise(window: Attributes) -> float:
    """Return the rms (m) of the white noise that the check "Noise" suspects, 0 where it suspects none."""
    # a flat end alone says nothing: it has to matter for the gradient
    is_suspect = _ends_flat(window) and window["noise_gradient_share"] > NOISE_SHARE
    return float(window["noise_floor"]) if is_suspect else 0.0


def is_mostly_noise(window: Attributes) -> bool:
    """Return whether a noise that nobody has stated is likely to make up most of the mean square gradient.

    Examples
    --------
    >>> white = {"top_exponent": -0.2, "noise_floor": 2e-9, "noise_gradient_share": 0.6}
    >>> is_mostly_noise(white), is_mostly_noise(white | {"instrument_noise": 2e-9})
    (True, False)
    """
    if Instrument.read(window).noise or window.get("top_exponent", -np.inf) <= NEARLY_WHITE:
        return False
    # the interval rests on a guess: of maps with noise of 10 % of Sq it missed one area in four
    return float(window.get("noise_gradient_share", 0.0)) > MOST_OF_THE_GRADIENT


def _ends_flat(window: Attributes) -> bool:
    """Return whether the spectrum is as flat at its end as that of white noise."""
    return window.get("top_exponent", -np.inf) > WHITE


def coarse_step(window: Attributes) -> float:
    """Return the step (m) to which the heights were rounded if it is above 2 % of the rms height, else 0.

    Examples
    --------
    >>> [coarse_step({"quantisation_step": step, "Sq": 1e-7}) for step in (0.0, 1e-9, 1e-8)]
    [0.0, 0.0, 1e-08]
    """
    step = float(window.get("quantisation_step", 0.0))
    return step if step > COARSE_STEP * float(window.get("Sq", np.inf)) else 0.0


def is_too_coarse(window: Attributes) -> bool:
    """Return whether the heights have steps beyond those for which the interval is known to hold.

    Examples
    --------
    >>> [is_too_coarse({"quantisation_step": step, "Sq": 1e-7}) for step in (2e-8, 5e-8)]
    [False, True]
    """
    # of a flat map no step is too coarse
    return coarse_step(window) > TOO_COARSE_STEP * float(window.get("Sq", np.inf))


def quantisation(window: Attributes) -> Check:
    """Check that the digitisation step (ISO 25178-600) of the heights does not make up the roughness.

    Examples
    --------
    >>> quantisation({"quantisation_step": 1e-9, "Sq": 1e-7}).sentence
    'The heights are multiples of 1.0 nm, 1.00 % of the rms height.'
    >>> quantisation({"quantisation_step": 2e-8, "Sq": 1e-7}).outcome
    'review'
    """
    step, rms_height = (float(window.get(name, 0.0)) for name in ("quantisation_step", "Sq"))
    cases = {"unknown": "quantisation_step" not in window, "none": not step, "fine": not coarse_step(window)}
    of_height = f", {percent(step / rms_height)} of the rms height" if rms_height else ""
    return judge("Quantisation", cases, step=step, of_height=of_height)


def height_unit(height: Attributes, window: Attributes) -> Check:
    """Check that the heights are not smaller than what an instrument can tell from noise."""
    rough = float(window.get("pixel_roughness", np.nan))
    # a small pixel tells a probe microscope where the file says nothing
    probe = instrument_kind(height) is PROBE or window.get("pixel_pitch", 1.0) < _PROBE_PIXEL
    quietest, instruments = (QUIETEST_PROBE, "probe microscopes") if probe else (QUIETEST, "profilers")
    cases = {
        "periodic": window.get("periodisation") == "none",
        "smooth": window.get("spectrum_exponent", -np.inf) < SPECTRUM_ENDS,
        "quiet": rough < quietest,
    }
    return judge("Height unit", cases, rough=rough, instruments=instruments, quietest=quietest)


def pixel_size(height: Attributes, window: Attributes) -> Check:
    """Check that the instrument which the file names can have pixels of this size."""
    instrument, pixel, times = instrument_kind(height), window.get("pixel_pitch", 0.0), _magnification(height)
    low, high = instrument.step
    camera = pixel * times  # a pixel on the surface is one of the camera, over the magnification
    cases = {
        "unknown": instrument is UNKNOWN or not pixel,
        "unusual": not low <= pixel <= high,
        "camera": times and not _CAMERA[0] <= camera <= _CAMERA[1],
        "lens": times,
    }
    facts = {"kind": instrument.words, "low": low, "high": high, "times": times, "camera": camera}
    return judge("Pixel size", cases, pixel=pixel, **facts)


def instrument_kind(height: Attributes) -> Kind:
    """Return the kind of instrument that the file names."""
    return of_name(json_attribute(height, "instrument").get("kind"))


def _magnification(height: Attributes) -> float:
    """Return the magnification of the lens, 0 where the file does not say."""
    instrument = json_attribute(height, "instrument")
    # "50x" in the name of a lens, not the "x" of a word
    match = re.search(r"\b(\d+(?:\.\d+)?) ?[xX×](?!\w)", str(instrument.get("lens", "")))
    return float(instrument.get("magnification") or (match[1] if match else 0.0))
