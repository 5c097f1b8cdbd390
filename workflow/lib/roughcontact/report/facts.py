"""Facts of a surface in words, beside its checks, and the captions of its maps."""

import json
import re
import textwrap
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.io.metadata import labelled, stored_instrument
from roughcontact.levelling.record import removed_and_filled
from roughcontact.maps import side_lengths, spacing, within_edges
from roughcontact.profiles.surface import is_drawn, surfaces_behind
from roughcontact.quantities import counted_noun, number, percent, quantity
from roughcontact.report.tables import is_finite_body, material_name
from roughcontact.report.template import sentence
from roughcontact.report.units import unit_of
from roughcontact.roughness.profile_parameters import profile_parameters
from roughcontact.roughness.texture import LAY
from roughcontact.statistics.adhesion import adhesion_in_words
from roughcontact.statistics.friction import slip_in_words
from roughcontact.variables import values_at_load
from roughcontact.window.band import shortest_reliable_wave


def surface_facts(
    measured: xr.DataArray, levelled: xr.DataArray, window: xr.DataArray, numbers: xr.Dataset
) -> list[tuple[str, str]]:
    """Return the facts of a surface as (name, text), in the order of the page; unknown ones are left out."""
    pitch = " × ".join(dict.fromkeys(quantity(step, "m") for step in spacing(measured)[::-1]))
    instrument = labelled(stored_instrument(measured.attrs))
    instrument_text = ", ".join(f"{label} {text}" for label, text in instrument)
    source = [str(measured.attrs.get(key, "")) for key in ("source_file", "source_format")]
    resolution = float(numbers["points_per_shortest_wavelength"][0])
    length = unit_of(numbers, "m").text
    facts = [
        ("File", " · ".join(filter(None, source))),
        ("First row", sentence("first_row", measured.attrs)),
        ("Channel", str(measured.attrs.get("channel", ""))),
        ("Instrument", textwrap.shorten(instrument_text, 160, placeholder=" …")),
        ("Map", f"{_size(measured)} of {pitch}"),
        ("Missing points", percent(measured.attrs.get("missing_share", 0.0))),
        ("Counter-face", sentence("counter_face", levelled.attrs)),
        ("Removed form", _removed(levelled, numbers)),
        ("Scan lines", sentence("scan_lines", levelled.attrs, length)),
        ("Filters", sentence("filters", json.loads(levelled.attrs.get("filters_removed", "{}")), length)),
        ("Corrected for", str(window.attrs.get("corrected_for", ""))),
        *_parameters(levelled, length),
        ("Window", _size(window[within_edges(window)])),
        ("Periodisation", str(window.attrs.get("periodisation", "none"))),
        ("Sal, Str, lay", _texture(numbers)),
        ("rms height", length(float(numbers["rms_height"]))),
        ("rms gradient g", number(float(numbers["rms_gradient"]))),
        ("rms curvature", f"{number(float(numbers['rms_curvature']) * 1e-3)} mm⁻¹"),
        ("Nayak parameter", number(float(numbers["nayak_parameter"]))),
        ("Points per shortest wave", number(resolution, digits=2)),
        ("First yield below the surface", _first_yield(numbers)),
        ("Gap closes", _closing(numbers)),
        ("Adhesion", adhesion_in_words(numbers)),
        ("Stick and slip", slip_in_words(numbers)),
        ("Contact modulus E*", quantity(float(numbers["contact_modulus"]), "Pa")),
        ("Body of finite size", _finite_body(numbers)),
        ("Hardness", _of_softer_body(numbers, "hardness")),
        ("First yield at the surface, p̄", _of_softer_body(numbers, "first_yield_pressure")),
    ]
    return [(name, text) for name, text in facts if text]


def _finite_body(numbers: xr.Dataset) -> str:
    """Return the contact of a body of finite size under its largest force, and Hertz's of the smooth body."""
    if not is_finite_body(numbers):
        return ""
    load = int(numbers["force"].values.argmax())
    return sentence("finite_body", values_at_load(numbers, load), "bodies" in numbers.attrs)


def date_of(measured: xr.DataArray) -> str:
    """Return the date of a measurement, YYYY-MM-DD; nothing where its file states none of this form.

    Examples
    --------
    >>> date_of(xr.DataArray(0.0, attrs={"instrument": '{"acquisition_time": "2011-07-23T16:49:36"}'}))
    '2011-07-23'
    """
    date = stored_instrument(measured.attrs).get("acquisition_time", "")
    result = re.match(r"\d{4}-\d\d-\d\d", str(date))
    return result[0] if result else ""


def versions(numbers: xr.Dataset) -> str:
    """Return the versions that wrote the statistics of a surface, from their attribute `versions` (JSON).

    Examples
    --------
    >>> import xarray as xr
    >>> versions(xr.Dataset(attrs={"versions": '{"python": "3.11", "numpy": "2.1"}'}))
    'python 3.11, numpy 2.1'
    """
    return ", ".join(map(" ".join, json.loads(numbers.attrs.get("versions", "{}")).items()))


def measured_caption(measured: xr.DataArray) -> str:
    """Return the caption of the measured map, with its number of missing points.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map
    >>> measured_caption(height_map(np.array([[0.0, np.nan], [0.0, 1e-6]]), 1e-6))
    '1 point not measured (pink).'
    """
    missing = measured.attrs.get("missing_points", 0)
    if not missing:
        return "Every point was measured."
    return f"{counted_noun(missing, 'point')} not measured{'' if _is_profile(measured) else ' (pink)'}."


def _is_profile(height: xr.DataArray) -> bool:
    """Return whether a map is a profile, or profiles of an isotropic surface in rows."""
    return 1 in height.shape or is_drawn(height)


def levelled_caption(levelled: xr.DataArray) -> str:
    """Return the caption of the levelled map: points filled in, outliers rejected.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map
    >>> levelled_caption(height_map(np.zeros((2, 2)), 1e-6).assign_attrs(outlier_kinds='{"scar": 3}'))
    '0 points filled in, 0 outliers rejected (3 in scars). The red frame is the solved window.'
    """
    frame = "" if _is_profile(levelled) else " The red frame is the solved window."
    return f"{removed_and_filled(levelled.attrs)}.{frame}"


def spectrum_caption(window: xr.DataArray, numbers: xr.Dataset) -> str:
    """Return the band of waves of a window that is solved, and the roughness of the removed waves.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map
    >>> band = {"band_shortest": 2e-6, "band_longest": 1e-4, "band_removed_rms_height": 0.0}
    >>> spectrum_caption(height_map(np.zeros((2, 2)), 1e-6).assign_attrs(band), xr.Dataset())
    'Mean over all directions. Waves from 2.00 µm to 100 µm are solved.'
    """
    shortest, longest = (quantity(window.attrs[f"band_{end}"], "m") for end in ("shortest", "longest"))
    band = f"Waves from {shortest} to {longest} are solved"
    if removed := window.attrs["band_removed_rms_height"]:
        gradient = number(window.attrs["band_removed_rms_gradient"])
        band += f"; removed: rms height {unit_of(numbers, 'm').text(removed)}, rms gradient {gradient}"
    return f"{band}." if 1 in window.shape else f"Mean over all directions. {band}."


def waves_in_words(window: xr.DataArray) -> str:
    """Return the waves for which the numbers of a window hold; nothing where its band is not known.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map
    >>> band = {"band_shortest": 2e-6, "reliable_wavelength": 3.3e-6}
    >>> waves_in_words(height_map(np.zeros((2, 2)), 1e-6).assign_attrs(band))
    'waves longer than 3.30 µm'
    """
    shortest = shortest_reliable_wave(window)
    text = f"waves longer than {quantity(shortest, 'm')}" if shortest else ""
    if is_drawn(window):
        text = ", ".join(filter(None, [surfaces_behind(window), text]))
    if corrected := window.attrs.get("corrected_for"):
        text = f"{text or 'the map'}, corrected for {corrected}"
    return text


def lay_caption(numbers: xr.Dataset) -> str:
    """Return the direction of the lay from `Str` and `Std` (degree; ISO 25178-2, 2021), if there is one.

    Examples
    --------
    >>> import xarray as xr
    >>> lay_caption(xr.Dataset({"Str": 0.1, "Std": 150.0}))
    'Strongest waves at 150° (Std), lay at 60°, from x towards y.'
    >>> lay_caption(xr.Dataset({"Str": 0.9, "Std": 150.0}))
    'No lay: much the same in all directions.'
    >>> lay_caption(xr.Dataset({"Str": float("nan"), "Std": 0.0}))
    'Strongest waves at 0° (Std). The window is too narrow to tell whether there is a lay.'
    """
    if np.isnan(numbers["Str"]):
        strongest = f"Strongest waves at {float(numbers['Std']):.0f}° (Std)"
        return f"{strongest}. The window is too narrow to tell whether there is a lay."
    if not _has_lay(numbers):
        return "No lay: much the same in all directions."
    return f"Strongest waves at {float(numbers['Std']):.0f}° (Std), lay at {_lay(numbers)}, from x towards y."


def autocorrelation_caption(numbers: xr.Dataset, *, profile: bool) -> str:
    """Return the length over which the autocorrelation falls, from `Sal` (m) and `Str`, if no `profile`.

    Examples
    --------
    >>> import xarray as xr
    >>> autocorrelation_caption(xr.Dataset({"Sal": 2e-5, "Str": 0.5}), profile=True)
    'Falls to 0.2 over 20.0 µm (Sal).'
    """
    length = f"Falls to 0.2 over {quantity(float(numbers['Sal']), 'm')} (Sal)"
    if not profile:
        length += f" in the direction of the fastest fall; Str = {number(float(numbers['Str']))}"
    return f"{length}."


def _has_lay(numbers: xr.Dataset) -> bool:
    """Return whether a surface has a direction."""
    return float(numbers["Str"]) <= LAY


def _lay(numbers: xr.Dataset) -> str:
    """Return the direction of the lay, across that of the strongest waves."""
    return f"{(float(numbers['Std']) + 90) % 180:.0f}°"


def _of_softer_body(numbers: xr.Dataset, name: str) -> str:
    """Return a pressure of the softer body, nothing where no hardness is stated."""
    return unit_of(numbers, "Pa").text(float(numbers[name])) if name in numbers else ""


def _first_yield(numbers: xr.Dataset) -> str:
    """Return the load at which a body begins to yield below its surface, where it was computed."""
    name = "first_subsurface_yield_pressure"
    if name not in numbers:
        return ""
    load = float(numbers[name])
    if np.isnan(load):
        volumes = numbers["volume_above_yield"].values
        return f"{'below' if volumes[0] > 0 else 'above'} the loads solved"
    if is_finite_body(numbers):  # in proportion to the mean pressure over the map
        return f"at {quantity(load * float((numbers['force'] / numbers['mean_pressure'])[0]), 'N')}"
    text = f"at {unit_of(numbers, 'Pa').text(load)} mean pressure"
    if "material_first_yield_pressure" not in numbers:
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
    if "gap_percolates_x" not in numbers or is_finite_body(numbers) or flat:
        return ""
    loads = [unit_of(numbers, "Pa").text(float(load)) for load in numbers["mean_pressure"]]
    result = {}
    for axis in ("x", "y"):
        closed = np.flatnonzero(numbers[f"gap_percolates_{axis}"].values == 0)
        if not closed.size:
            result[axis] = f"not up to {loads[-1]}"
        elif closed[0] == 0:
            result[axis] = f"at {loads[0]} already"
        else:
            result[axis] = f"between {loads[closed[0] - 1]} and {loads[closed[0]]}"
    if result["x"] == result["y"]:
        return result["x"]
    return "; ".join(f"along {axis} {text}" for axis, text in result.items())


def _size(height: xr.DataArray) -> str:
    """Return the size of a map, x first; of a profile, its length."""
    sides = [(n, length) for n, length in zip(height.shape, side_lengths(height), strict=True) if n > 1][::-1]
    lengths = " × ".join(quantity(length, "m") for _, length in sides)
    points = " × ".join(str(n) for n, _ in sides)
    return f"{lengths}, {points} points"


def _removed(levelled: xr.DataArray, numbers: xr.Dataset) -> str:
    """Return the form that levelling removed."""
    removed = json.loads(levelled.attrs.get("form_removed", "{}"))
    components = [
        f"{name.replace('_', ' ')} {_removed_part(name, entry, levelled, numbers)}"
        for name, entry in removed.items()
        if name.startswith(("mean", "slope", "curvature", "radius", "axis"))  # the rest are coefficients
    ]
    return f"{levelled.attrs.get('form', 'none')}" + (f": {', '.join(components)}" if components else "")


def _removed_part(name: str, entry: Mapping[str, Any], levelled: xr.DataArray, numbers: xr.Dataset) -> str:
    """Return a mean, slope or curvature; 0 where it is negligible over the whole map."""
    if entry["units"] == "degree":
        return f"{entry['value']:.2f}°".replace("-", "−")
    power = {"m": 0, "1": 1, "m-1": 2}[entry["units"]]
    over_the_map = abs(entry["value"]) * max(side_lengths(levelled)) ** power
    empty = over_the_map < 1e-6 * float(np.nanstd(levelled.values))
    value = 0.0 if empty else entry["value"]
    if name.startswith("mean"):
        return unit_of(numbers, "m").text(value)
    return quantity(value, entry["units"].replace("m-1", "m⁻¹"))


def _parameters(levelled: xr.DataArray, length: Callable[[float], str]) -> list[tuple[str, str]]:
    """Return the height parameters of the levelled map, or of its profiles, of the measured points."""
    letter, parameters = "S", levelled.attrs
    rows: list[tuple[str, ...]] = [("a", "q", "z"), ("sk", "ku", "dq"), ("k", "pk", "vk")]
    if _is_profile(levelled):
        parameters = profile_parameters(levelled)
        letter = min(parameters)[0]
        rows.append(("sm",))
    facts = []
    for row in rows:
        show = number if row[0] == "sk" else length
        names = [letter + name for name in row if letter + name in parameters]
        facts.append((", ".join(names), ", ".join(show(parameters[name]) for name in names)))
    return facts


def _texture(numbers: xr.Dataset) -> str:
    """Return length and direction of the texture, nothing for a flat map."""
    if not np.isfinite(numbers["Sal"]):
        return ""
    length = quantity(float(numbers["Sal"]), "m")
    if not np.isfinite(numbers["Str"]):
        return length
    lay = _lay(numbers) if _has_lay(numbers) else "none"
    return f"{length}, {number(float(numbers['Str']))}, {lay}"
