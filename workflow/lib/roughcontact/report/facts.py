"""Facts of a surface in words, beside its checks, and the captions of its maps."""

import re
import textwrap
from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr

from roughcontact.arguments.choices import PERIODIC_BY
from roughcontact.arguments.maps import side_lengths, spacing
from roughcontact.arguments.measurement import Instrument, json_attribute
from roughcontact.arguments.profiles.lines import are_lines
from roughcontact.arguments.quantities import number, percent, quantity
from roughcontact.arguments.variables import values_at_load
from roughcontact.io.metadata import labelled
from roughcontact.io.sources import in_words
from roughcontact.report.tables import material_name
from roughcontact.report.template import sentence
from roughcontact.report.units import stated_loads, unit_of
from roughcontact.statistics.adhesion import adhesion_in_words
from roughcontact.statistics.contact_checks import may_yield
from roughcontact.statistics.kinds import facts_of_numbers, load_in_words
from roughcontact.surface.levelling.record import removed_and_filled
from roughcontact.surface.roughness.profile_parameters import profile_parameters
from roughcontact.surface.roughness.texture import LAY
from roughcontact.surface.window.band import shortest_reliable_wave

_NEGLIGIBLE = 1e-4  # of the rms height: less than an atom on most maps
# names of the parameters of profiles and maps without their first letter, by the way they are written
_PARAMETERS = (("a", "q", "z"), ("sk", "ku", "dq"), ("k", "pk", "vk"), ("sm",))


def surface_facts(
    measured_map: xr.DataArray, levelled_map: xr.DataArray, window: xr.DataArray, numbers: xr.Dataset
) -> dict[str, str]:
    """Return the facts of a surface by their names, in the order of the page; unknown ones are empty."""
    of_map, of_window = measured_map.attrs, window.attrs
    pitch = " × ".join(dict.fromkeys(quantity(step, "m") for step in spacing(measured_map)[::-1]))
    instrument = (f"{label} {text}" for label, text in labelled(json_attribute(of_map, "instrument")))
    sources, length = json_attribute(of_map, "ingest_sources"), unit_of(numbers, "m").text
    method = str(of_window.get("periodisation", "none"))
    return {
        "File": " · ".join(filter(None, (of_map.get(key, "") for key in ("source_file", "source_format")))),
        "First row": sentence("first_row", of_map),
        "Sources": in_words(sources),
        "Not used": textwrap.shorten("; ".join(sources.get("not used", [])), 240, placeholder=" …"),
        "Channel": str(of_map.get("channel", "")),
        "Instrument": textwrap.shorten(", ".join(instrument), 160, placeholder=" …"),
        "Assumed in the ±": sentence("assumed", Instrument.read(numbers.attrs).properties()),
        "Map": f"{_size(measured_map)} of {pitch}",
        "Missing points": percent(of_map.get("missing_share", 0.0)),
        "Counter-face": sentence("counter_face", levelled_map.attrs),
        "Removed form": _removed(levelled_map),
        "Scan lines": sentence("scan_lines", levelled_map.attrs, length),
        "Filters": sentence("filters", json_attribute(levelled_map.attrs, "filters_removed"), length),
        "Corrected for": str(of_window.get("corrected_for", "")),
        **_parameters(levelled_map, length),
        "Window": _size(window),
        "Made periodic by": PERIODIC_BY.get(method, ""),
        "Sal, Str, lay": sentence("texture", values_at_load(numbers, -1), LAY),
        "Points per shortest wave": number(float(numbers["points_per_shortest_wavelength"][0]), digits=2),
        **number_facts(numbers),
        "Body of finite size": size_of_contact(numbers, -1),
    }


def number_facts(numbers: xr.Dataset) -> dict[str, str]:
    """Return the facts that follow from the statistics of a surface, loads rising, as of `surface_facts`."""
    return {
        "rms height": unit_of(numbers, "m").text(float(numbers["rms_height"])),
        "rms gradient g": number(float(numbers["rms_gradient"])),
        "Contact modulus E*": quantity(float(numbers["contact_modulus"]), "Pa"),
        "Hardness": quantity(float(numbers["hardness"]), "Pa") if "hardness" in numbers else "",
        "First yield at the surface": _first_yield(numbers, "first_yield_pressure"),
        "First yield below the surface": _first_yield(numbers, "first_subsurface_yield_pressure"),
        "Gap closes": _closing(numbers),
        "Adhesion": adhesion_in_words(numbers),
        "Stick and slip": numbers.attrs.get("slip_approximation", ""),
        "Flash temperature": sentence("flashes", numbers.attrs, "max_flash_temperature" in numbers),
    }


def size_of_contact(numbers: xr.Dataset, load: int) -> str:
    """Return the contact of a body of finite size at a load (index), and Hertz's of the smooth body."""
    name = facts_of_numbers(numbers).sentence
    return sentence(name, values_at_load(numbers, load), "bodies" in numbers.attrs) if name else ""


def date_text(measured_map: xr.DataArray) -> str:
    """Return the date of a measurement, YYYY-MM-DD; nothing where its file states none of this form.

    Examples
    --------
    >>> date_text(xr.DataArray(0.0, attrs={"instrument": '{"acquisition_time": "2011-07-23T16:49:36"}'}))
    '2011-07-23'
    """
    date = json_attribute(measured_map.attrs, "instrument").get("acquisition_time", "")
    return "".join(re.findall(r"^\d{4}-\d\d-\d\d", str(date)))


def measured_caption(measured_map: xr.DataArray) -> str:
    """Return the caption of the measured map, with its number of missing points.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> measured_caption(height_map(np.array([[0.0, np.nan], [0.0, 1e-6]]), 1e-6))
    '1 point not measured (pink).'
    """
    return sentence("measured", measured_map.attrs.get("missing_points", 0), are_lines(measured_map))


def levelled_caption(levelled_map: xr.DataArray) -> str:
    """Return the caption of the levelled map: points filled in, outliers rejected.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> levelled_caption(height_map(np.zeros((2, 2)), 1e-6).assign_attrs(outlier_kinds='{"scar": 3}'))
    '0 points filled in, 0 outliers rejected (3 in scars). The red frame is the solved window.'
    """
    return sentence("levelled", removed_and_filled(levelled_map.attrs), are_lines(levelled_map))


def spectrum_caption(window: xr.DataArray, numbers: xr.Dataset) -> str:
    """Return the band of waves of a window that is solved, and the roughness of the removed waves.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> band = {"band_shortest": 2e-6, "band_longest": 1e-4, "band_removed_rms_height": 0.0}
    >>> spectrum_caption(height_map(np.zeros((2, 2)), 1e-6).assign_attrs(band), xr.Dataset())
    'Mean over all directions. Waves from 2.00 µm to 100 µm are solved.'
    """
    return sentence("spectrum", window.attrs, are_lines(window), unit_of(numbers, "m").text)


def waves_in_words(window: xr.DataArray) -> str:
    """Return the waves for which the numbers of a window hold; nothing where its band is not known.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> band = {"band_shortest": 2e-6, "reliable_wavelength": 3.3e-6}
    >>> waves_in_words(height_map(np.zeros((2, 2)), 1e-6).assign_attrs(band))
    'wavelengths above 3.30 µm'
    """
    causes = window.attrs.get("corrected_for")
    return sentence("holds_for", window.attrs.get("ensemble", ""), shortest_reliable_wave(window), causes)


def _first_yield(numbers: xr.Dataset, name: str) -> str:
    """Return the load, by its variable, at which a body begins to yield, where it was computed."""
    if name not in numbers or (name == "first_yield_pressure" and not may_yield(numbers)):
        return ""
    load = float(numbers[name])
    kind, load_text = load_in_words(load, numbers)
    text = f"at {load_text} {kind}".removesuffix(" force") if kind else load_text
    if not kind or name == "first_yield_pressure" or "material_first_yield_pressure" not in numbers:
        return text
    index = int(np.nanargmin(numbers["material_first_yield_pressure"].values))
    nearest = int(np.argmin(np.abs(np.log(numbers["mean_pressure"].values / load))))
    depth = float(numbers["material_von_mises_depth"][nearest, index])
    face = np.flatnonzero(np.isclose(depth, [0.0, *numbers["interface_depth"].values], rtol=1e-9, atol=0))
    position = [f" at the {f'interface {i}' if i else 'surface'}" for i in face]
    return f"{text}, in {material_name(numbers, index)}{''.join(position)}"


def _closing(numbers: xr.Dataset) -> str:
    """Return between which loads the gap closes along each axis, nothing for a profile and for a flat map."""
    flat = not np.isfinite(numbers.get("Std", np.nan))
    if "gap_percolates_x" not in numbers or flat or not facts_of_numbers(numbers).has_flow:
        return ""
    open_loads = [int(np.cumprod(numbers[f"gap_percolates_{axis}"].values != 0).sum()) for axis in "xy"]
    return sentence("closes", stated_loads(numbers).texts, *open_loads)


def _size(height: xr.DataArray) -> str:
    """Return the size of a map, x first; of a profile, its length."""
    sides = [side for side in zip(height.shape, side_lengths(height), strict=True) if side[0] > 1]
    return sentence("size", sides[::-1])


def _removed(levelled_map: xr.DataArray) -> str:
    """Return the form that levelling removed."""
    removed, form = json_attribute(levelled_map.attrs, "form_removed"), levelled_map.attrs.get("form", "none")
    longest, negligible = max(side_lengths(levelled_map)), _NEGLIGIBLE * float(np.nanstd(levelled_map.values))
    return sentence("form_removed", form, removed, are_lines(levelled_map), longest, negligible)


def _parameters(levelled_map: xr.DataArray, length: Callable[[float], str]) -> dict[str, str]:
    """Return the height parameters of the levelled map, or of its profiles, of the measured points."""
    parameters = profile_parameters(levelled_map) if are_lines(levelled_map) else levelled_map.attrs
    letter, facts = min(parameters)[0] if are_lines(levelled_map) else "S", {}
    along: Callable[[float], str] = partial(quantity, unit="m")
    for row in _PARAMETERS if are_lines(levelled_map) else _PARAMETERS[:3]:
        show = along if row[0] == "sm" else number if row[0] == "sk" else length
        names = [letter + name for name in row if np.isfinite(parameters.get(letter + name, np.nan))]
        facts[", ".join(names)] = ", ".join(show(parameters[name]) for name in names)
    return facts
