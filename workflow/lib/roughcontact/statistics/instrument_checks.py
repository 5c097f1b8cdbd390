"""Checks of what the instrument, its software or dust made of the surface, and of its units.

`height` and `window` are attributes of the map as measured (`instrument` is JSON) and of the periodic window;
how often the checks flag maps is in `benchmarks/results/instrument_checks.csv`.
"""

import re
from collections.abc import Iterator

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import spacing
from roughcontact.arguments.measurement import Instrument, json_attribute
from roughcontact.arguments.quantities import number, percent, quantity
from roughcontact.io.instrument_kinds import PROBE, UNKNOWN, Kind, of_name
from roughcontact.statistics.map_checks import Attributes
from roughcontact.statistics.outcome import Check, not_made, passed, review
from roughcontact.statistics.selected_loads import Statistics
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

_UNFILTERED = "export it unfiltered"
_RESOLVED = "state the lens (instrument.numerical_aperture, instrument.resolution)"
_SMOOTHED_MEANS = (
    "Contact areas are then too large, pressures and gaps too small, but not those of longer waves alone: "
    "of coarser pixels, or filtered (level.s_filter)"
)
_FEW_WAVES = "too few waves to judge the spectrum by."
_PERIODIC_MAP = "the map is periodic as it is, as made ones are."


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
    if window.get("periodisation") == "none":  # a synthetic map has no instrument
        return not_made(_PERIODIC_MAP)
    if "spectrum_exponent" not in window:
        return not_made(_FEW_WAVES)
    traces = [*_traces(window)]
    # what is stated already is no reason to ask again
    if open_traces := [(sentence, remedies) for sentence, remedies in traces if remedies]:
        remedies = ", or ".join(dict.fromkeys(remedy for _, of_trace in open_traces for remedy in of_trace))
        finding, *further = [f"{sentence}." for sentence, _ in open_traces]
        return review(
            finding,
            explanation=" ".join([*further, f"{_SMOOTHED_MEANS}."]),
            advice=f"{remedies[0].upper()}{remedies[1:]}.",
        )
    if traces:
        return passed(". ".join(sentence for sentence, _ in traces) + ".")
    return passed(f"The spectrum reaches down to the pixels: its steepest fall is {_exponent(window)}.")


def _traces(window: Attributes) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield what an instrument left in a map, and what the user can do; nothing where it is stated."""
    limit = _removed_below(window)
    if window["spectrum_exponent"] < SPECTRUM_ENDS:
        spectrum_end, pixel = window["spectrum_end"], window.get("pixel_pitch", 0.0)
        length = quantity(spectrum_end, "m", digits=2)
        pixels = f" ({number(spectrum_end / pixel, digits=2)} pixels)" if pixel else ""
        sentence = (
            f"No waves were measured below {length}{pixels}: the spectrum ends there, falling as "
            f"{_exponent(window)}. A lens, a filter of the instrument's software or interpolation does this; "
            "of surfaces only one without any shorter waves"
        )
        explanation = f"Waves below {length} are missing, as stated"
        yield (explanation, ()) if spectrum_end <= limit else (sentence, (_UNFILTERED, _RESOLVED))
    elif window.get("spectrum_bend", 0.0) < BENT:
        sentence = (
            "The shortest waves are too low: in its last octave the spectrum falls more steeply than in the "
            f"one before, its exponent by {number(-window['spectrum_bend'], digits=2)} or more. A lens that "
            "resolves little more than the pixels does this"
        )
        explanation = "The shortest waves are too low, as stated"
        yield (explanation, ()) if window["pixel_pitch"] <= limit else (sentence, (_RESOLVED,))
    if window["rounded_peaks"] > ROUNDED:
        radius = window["sharpest_peak_radius"]
        rounded_sentence = f"Peaks are rounded, to radii of {quantity(radius, 'm', digits=2)} and more"
        sentence = f"{rounded_sentence}, and valleys are sharp: the tip of a stylus or probe does this"
        # half the radius: its estimate from the sharpest peaks is coarse
        is_stated = (Instrument.read(window).tip_radius or 0.0) > radius / 2
        explanation = "Peaks are rounded, as the stated tip radius says"
        yield (explanation, ()) if is_stated else (sentence, ("state the tip (instrument.tip_radius)",))
    if window.get("repeated_heights", 0.0) > REPEATED:  # which no setting states
        filter_sentence = "a median filter does this, and leaves little of waves below about five pixels"
        yield f"Neighbouring points often have exactly the same height: {filter_sentence}", (_UNFILTERED,)


def _exponent(window: Attributes) -> str:
    """Return the steepest fall of the spectrum in words."""
    return f"q^{number(window['spectrum_exponent'], digits=2)}"


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
    if "summit_chance" not in window:
        return not_made("the map has no summit.")
    # at the load where it is largest: at low loads a summit is alone
    over_mean = float((statistics["max_pressure"] / statistics["mean_contact_pressure"]).max())
    times = f"{number(over_mean, digits=2)} times the mean in contact"
    if not (over_mean > PEAK_OVER_MEAN and window["summit_chance"] < CHANCE):
        return passed(f"The largest pressure is at most {times}, or not that of one summit alone.")
    ratio_to_next = window["summit_over_next"]
    higher = f"{number(ratio_to_next, digits=2)} times as high above its surroundings as any other"
    if np.isinf(ratio_to_next):
        higher = "and no other summit does"
    where = " and ".join(f"{axis} = {quantity(window[f'summit_{axis}'], 'm')}" for axis in ("x", "y"))
    return review(
        f"One summit stands out, {higher}, at {where}; the largest pressure is {times}.",
        explanation="Dust and burrs look like this; the largest pressure, and gaps at low loads, are theirs.",
        advice="Unless it belongs to the surface, clean and measure again, cut the map, or lower "
        "the threshold of outliers (level.outlier_threshold).",
    )


def noise(window: Attributes) -> Check:
    """Check that noise, `instrument_noise` (m) or a flat spectrum, makes up little of the gradient."""
    if "noise_floor" not in window:
        return not_made(_FEW_WAVES)
    floor, share, explanation = window["noise_floor"], float(window["noise_gradient_share"]), ""
    stated_noise = (Instrument.read(window).noise or 0.0) if floor > 0 else 0.0
    if stated_noise:
        # the gradient of white noise goes with its rms height
        share *= (stated_noise / floor) ** 2
        makes_up = f"The stated noise of {quantity(stated_noise, 'm')} makes up"
        advice = "Average several maps"
    elif _ends_flat(window):
        white = f"a white noise of {quantity(floor, 'm', digits=2)} (rms)"
        makes_up = f"The spectrum is flat at its end, as with {white}, which would make up"
        explanation = " It may be noise, or waves shorter than the pixel: one map cannot tell."
        advice = "Measure twice and state the noise (instrument.noise)"
    else:
        exponent = number(window["top_exponent"], digits=2)
        return passed(f"The spectrum falls down to the pixels, as q^{exponent}: no white noise shows.")
    # that of a floor can exceed the whole
    text = f"{makes_up} {percent(share) if share < 1 else 'all'} of the mean square gradient"
    if stated_noise and "corrected_for" in window:
        return passed(f"{text} as measured, for which the map is corrected.")
    if share <= NOISE_SHARE:
        return passed(f"{text}.")
    # the area goes as 1 / g
    small = f"by up to {percent(1 - np.sqrt(1 - share))}" if share < 1 else "by an unknown factor"
    effect = f"Areas would be too small {small}, and pressures too large.{explanation}"
    advice += ", or remove short waves (level.s_filter)."
    return review(f"{text}.", explanation=effect, advice=advice)


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
    if "quantisation_step" not in window:
        return not_made("the map was not levelled.")
    step = float(window["quantisation_step"])
    if not step:
        return passed("The heights are not rounded to steps.")
    text = f"The heights are multiples of {quantity(step, 'm', digits=2)}"
    rms_height = float(window["Sq"])
    text += f", {percent(step / rms_height)} of the rms height" if rms_height else ""
    if not coarse_step(window):
        return passed(f"{text}.")
    return review(
        f"{text}: steps between them add to the gradient, so that areas are too small, and pressures and "
        "gaps too large.",
        advice="Export the heights with more digits, or measure with a smaller range of heights.",
    )


def height_unit(height: Attributes, window: Attributes) -> Check:
    """Check that the heights are not smaller than what an instrument can tell from noise."""
    if window.get("periodisation") == "none":
        return not_made(_PERIODIC_MAP)
    if window.get("spectrum_exponent", -np.inf) < SPECTRUM_ENDS:
        return not_made("the noise of the instrument does not show in a map that is smooth at its pixels.")
    rough = float(window["pixel_roughness"])
    # a small pixel tells a probe microscope where the file says nothing
    probe = instrument_kind(height) is PROBE or window.get("pixel_pitch", 1.0) < _PROBE_PIXEL
    quietest, instruments = (QUIETEST_PROBE, "probe microscopes") if probe else (QUIETEST, "profilers")
    text = f"Neighbouring points differ as with a noise of {quantity(rough, 'm', digits=2)}"
    if not rough < quietest:
        return passed(f"{text}: an instrument can measure that.")
    return review(
        f"{text}, less than that of the quietest {instruments} ({quantity(quietest, 'm', digits=1)}).",
        advice="Check the unit of the heights: were µm read as nm?",
    )


def pixel_size(height: Attributes, window: Attributes) -> Check:
    """Check that the instrument which the file names can have pixels of this size."""
    instrument, pixel = instrument_kind(height), float(window.get("pixel_pitch", 0.0))
    if instrument is UNKNOWN or not pixel:
        return not_made("the file does not name the kind of its instrument.")
    subject, words = f"Pixels of {quantity(pixel, 'm', digits=2)} are", instrument.words
    low, high = instrument.step
    if not low <= pixel <= high:
        return review(
            f"{subject} not those of {words} ({quantity(low, 'm')} to {quantity(high, 'm')}).",
            advice="Check the lateral unit.",
        )
    if times := _magnification(height):
        # a pixel on the surface is one of the camera, over the magnification
        camera = pixel * times
        words += f" with a lens of {number(times, digits=2)}×"
        if not _CAMERA[0] <= camera <= _CAMERA[1]:
            on_camera = quantity(camera, "m", digits=2)
            return review(
                f"{subject} not those of {words}: they would be {on_camera} on its camera.",
                advice="Check the lateral unit, and whether the map was resampled.",
            )
    return passed(f"{subject} those of {words}.")


def instrument_kind(height: Attributes) -> Kind:
    """Return the kind of instrument that the file names."""
    return of_name(json_attribute(height, "instrument").get("kind"))


def _magnification(height: Attributes) -> float:
    """Return the magnification of the lens, 0 where the file does not say."""
    instrument = json_attribute(height, "instrument")
    # "50x" in the name of a lens, not the "x" of a word
    match = re.search(r"\b(\d+(?:\.\d+)?) ?[xX×](?!\w)", str(instrument.get("lens", "")))
    return float(instrument.get("magnification") or (match[1] if match else 0.0))
