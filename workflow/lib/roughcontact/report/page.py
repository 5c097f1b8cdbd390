"""The page that people read: one part per surface, put together to one self-contained HTML file."""

import json
import re
import textwrap
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.errors import InputFileError
from roughcontact.io.metadata import labelled
from roughcontact.maps import spacing
from roughcontact.quantities import number, percent, plus_minus, prefix, quantity
from roughcontact.report import plots, texture_plots
from roughcontact.report.budget_plots import shown_budget
from roughcontact.results.storage import read_dataset, write_text
from roughcontact.statistics import checks
from roughcontact.variables import VARIABLES
from roughcontact.window.score import WEIGHTS

_NO_LAY = 0.5  # texture aspect ratio from which on a surface has no lay
_SHOWN_LOADS = 3  # loads whose maps are drawn: the lowest, the middle, the highest

# the numbers of a surface at the top of the page, as `_headline` gives them
_HEADINGS = ("rms height", "rms gradient g", "mean pressure p̄", "contact area A/A₀", "largest pressure")

# the parts of the score of a window, as `window_search.WEIGHTS` names them, and whether in percent
_SCORE_PARTS = (
    ("height_mismatch", "heights at the seams", False),
    ("slope_mismatch", "slopes at the seams", False),
    ("missing", "filled points", True),
    ("stationarity", "gradient among quarters", True),
    ("representativeness", "spectrum off the map's", True),
    ("size", "sampling error", True),
)

# the columns of the table of numbers: variable, short name, unit (a share is given in percent)
_COLUMNS = (
    ("mean_pressure", "mean pressure p̄", "Pa"),
    ("relative_pressure", "p̄/(E* g)", "1"),
    ("relative_contact_area", "contact area A/A₀", "%"),
    ("relative_contact_area_pixels", "pixels in contact", "%"),
    ("mean_contact_pressure", "pressure in contact", "Pa"),
    ("pressure_std", "its std", "Pa"),
    ("max_pressure", "largest pressure", "Pa"),
    ("mean_gap", "mean gap ū", "m"),
    ("contact_stiffness", "stiffness −dp̄/dū", "Pa m-1"),
    ("elastic_energy", "elastic energy", "J m-2"),
    ("contact_perimeter", "contact perimeter", "m"),
    ("contact_clusters", "contact patches", "1"),
    ("contact_on_filled_points", "on filled points", "%"),
    ("error_bound", "error bound", "1"),
)

# of these, those of the table of pairs
_OF_PAIRS = ("mean_pressure", "relative_contact_area", "mean_contact_pressure", "max_pressure", "mean_gap")


def write_panel(
    path,
    *,
    surface,
    case=None,
    height,
    levelled,
    window,
    contact,
    statistics,
    settings,
    crosscheck=None,
    counter_face=None,
) -> None:
    """Write one surface's part of the report, an HTML fragment with its images inside.

    Parameters
    ----------
    path : where to write
    surface, case : str
        Names; `case` is None in a run without cases.
    height, levelled, window, contact, statistics : paths
        The result files of the surface. Where `contact` keeps no maps of pressure and gap the part says so.
    settings : dict
        The settings of the run.
    crosscheck : path or None
        What another code found, where the run was cross-checked.
    counter_face : path or None
        The other measured file of a pair of faces.
    """
    measured, plane, solved = (_read_map(file) for file in (height, levelled, window))
    numbers = read_dataset(statistics)
    order = np.argsort(numbers["mean_pressure"].values, kind="stable")
    numbers = numbers.isel(load=order)
    shown = _shown_loads(numbers.sizes["load"])
    outcome = checks.surface_checks(
        numbers,
        height=plane.attrs if counter_face else measured.attrs,  # of both faces together
        levelled=plane.attrs,
        window=solved.attrs,
        points=solved.size,
    )
    name = surface if case is None else f"{surface} · {case}"
    identifier = surface if case is None else f"{case}--{surface}"
    verdict = checks.verdict(outcome)
    rough = float(numbers["rms_gradient"]) > 0
    html = template("panel.html").render(
        identifier=identifier,
        name=name,
        verdict=verdict,
        verdict_words=checks.VERDICTS[verdict],
        checks=outcome,
        facts=_facts(measured, plane, solved, numbers),
        maps=[
            *_measured_maps(measured, counter_face),
            (
                "Sum of both, levelled" if counter_face else "Levelled",
                plots.height_map(plane, rectangle=_frame(solved)),
                _levelled_caption(plane),
            ),
            ("Solved window", plots.height_map(solved), solved.attrs.get("window_reason", "")),
        ],
        scores=_scores(solved),
        profile=1 in solved.shape,
        fields=_field_maps(contact, solved, order[shown]),
        waves=_waves(solved, numbers) if rough else [],
        charts=_charts(numbers, solved, shown, rough=rough),
        budget=shown_budget(numbers),
        table=_table(numbers, checks.load_flags(numbers, solved.size)),
        crosscheck=_crosscheck(crosscheck, numbers, order) if crosscheck else None,
        summary=_embedded(
            {
                "identifier": identifier,
                "name": name,
                "verdict": verdict,
                "reasons": [_reason(check) for check in outcome if check.outcome != checks.PASSED],
            }
        ),
        settings=json.dumps(settings, indent=1, sort_keys=True),
        versions=_versions(numbers),
        source_sha256=measured.attrs.get("source_sha256", ""),
    )
    write_text(html, path)


def write_report(path, *, panels, statistics, title, settings, pairs=None) -> None:
    """Write the one self-contained page of a run: verdicts, comparison, and the part of every surface.

    Parameters
    ----------
    path : where to write
    panels : list of paths
        What `write_panel` wrote, in the order they shall appear.
    statistics : path
        What `collect_statistics` put together.
    title : str
    settings : dict
        The settings of the run (of each case, where there are cases).
    pairs : path or None
        The table of pairs of faces (`collect.pairs_table`), where there are any.
    """
    parts = [Path(panel).read_text(encoding="utf-8") for panel in panels]
    summaries = [_summary(part, panel) for part, panel in zip(parts, panels, strict=True)]
    series = _series(read_dataset(statistics))
    rows = [summary | {"numbers": _headline(series[summary["name"]])} for summary in summaries]
    lines = [
        (name, data["relative_pressure"].values, data["relative_contact_area"].values)
        for name, data in series.items()
        if np.isfinite(data["relative_pressure"]).all()
    ]
    html = template("report.html").render(
        title=title,
        rows=rows,
        headings=_HEADINGS,
        words=checks.VERDICTS,
        counts={outcome: sum(row["verdict"] == outcome for row in rows) for outcome in checks.VERDICTS},
        comparison=plots.compare_areas(lines) if lines else None,
        parts=parts,
        pairs=_pairs(pairs) if pairs else None,
        settings=json.dumps(settings, indent=1, sort_keys=True),
        limits={
            "points": checks.CONTACT_POINTS,
            "overcount": f"{100 * checks.OVERCOUNT:g} %",
            "filled": [f"{100 * share:g} %" for share in checks.FILLED_IN_CONTACT],
            "gradient": f"{100 * checks.GRADIENT_CHANGE:g} %",
            "heights": f"{100 * checks.HEIGHT_CHANGE:g} %",
            "form": f"{100 * checks.FORM:g} %",
            "window": f"{100 * checks.WINDOW_SHARE:g} %",
            "lengths": checks.LENGTHS,
            "steep": number(checks.STEEP, digits=1),
            "places": f"{100 * checks.STEEP_PLACES:g} %",
            "too_steep": number(checks.TOO_STEEP, digits=1),
            "hardest": number(checks.HARDEST, digits=1),
        },
    )
    write_text(html, path)


def template(name: str, *, folder: Path | None = None):
    """Return one of the package's templates, with HTML escaped and no surprise where a name is missing.

    Those in `folder`, where one is given, come before those of the report.
    """
    import jinja2

    folders = [Path(__file__).with_name("templates")]
    loader = jinja2.FileSystemLoader(folders if folder is None else [folder, *folders])
    environment = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.get_template(name)


def _read_map(path) -> xr.DataArray:
    """Return the height map of a result file, attributes of the file included."""
    dataset = read_dataset(path)
    return dataset["height"].assign_attrs(dataset.attrs | dataset["height"].attrs)


def _lengths(height) -> tuple[float, float]:
    """Return (length y, length x) of a map in m."""
    return tuple(n * pitch for n, pitch in zip(height.shape, spacing(height), strict=True))


def _frame(window):
    """Return (x, y, length x, length y) of the part of the map that the window shows, m."""
    offset = (window.attrs.get(f"window_offset_{axis}", 0.0) for axis in ("x", "y"))
    images = 2 if window.attrs.get("periodisation") == "mirror" else 1  # the part and its mirror image
    return (*offset, *(length / images for length in _lengths(window)[::-1]))


def _shown_loads(loads: int) -> list[int]:
    """Return the places of the lowest, the middle and the highest of so many loads."""
    return sorted({0, loads // 2, loads - 1})[:_SHOWN_LOADS]


def _scores(window) -> dict | None:
    """Return header and rows of the table of scores, None where the window was not searched for."""
    if "window_scores" not in window.attrs:
        return None
    candidates = json.loads(window.attrs["window_scores"])
    header = ["window, points", "corner, x and y", "score"] + [
        f"{title} (weight {WEIGHTS[name]:g})" for name, title, _ in _SCORE_PARTS
    ]
    rows = []
    for index, candidate in enumerate(candidates):
        corner = ", ".join(quantity(value, "m") for value in candidate["offset"][::-1])
        parts = [
            percent(candidate[name]) if in_percent else f"{candidate[name]:.2f}"
            for name, _, in_percent in _SCORE_PARTS
        ]
        size = " × ".join(str(points) for points in candidate["points"][::-1])
        words = ["solved"] * (index == 0) + ["largest rectangle"] * candidate["largest_rectangle"]
        rows.append({"cells": [size, corner, f"{candidate['score']:.3f}", *parts], "words": ", ".join(words)})
    return {"header": header, "rows": rows}


def _field_maps(path, window, loads):
    """Return (caption, pressure map, gap map) of a few loads, an empty list where no maps were kept."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as contact:
            if "pressure" not in contact or "gap" not in contact:
                return []
            chosen = contact[["pressure", "gap", "mean_pressure"]].isel(load=loads).load()
    except OSError as error:
        raise InputFileError(f"{path}: not readable as netCDF ({error}); delete it and run again") from error
    fields = []
    for index in range(chosen.sizes["load"]):
        pressure, gap = (chosen[name].values[index] for name in ("pressure", "gap"))
        caption = f"p̄ = {quantity(float(chosen['mean_pressure'][index]), 'Pa')}"
        area = percent(np.count_nonzero(pressure > 0) / pressure.size)
        pictures = (plots.pressure_map(window, pressure), plots.gap_map(window, gap, pressure))
        fields.append((f"{caption}: {area} of the pixels touch", *pictures))
    return fields


def _waves(window, numbers) -> list[tuple[str, str, str]]:
    """Return (title, image, caption) of the pictures of the waves of a window that is not flat."""
    removed = window.attrs["band_removed_rms_height"]
    band = (
        f"Waves from {quantity(window.attrs['band_shortest'], 'm')} to "
        f"{quantity(window.attrs['band_longest'], 'm')} are solved"
    )
    if removed:
        gradient = number(window.attrs["band_removed_rms_gradient"])
        band += f"; taken out: rms height {quantity(removed, 'm')}, rms gradient {gradient}"
    length = f"Falls to 0.2 over {quantity(float(numbers['Sal']), 'm')} (Sal)"
    pictures = [
        ("Power spectrum", texture_plots.spectrum(window), f"Mean over all directions. {band}."),
    ]
    if 1 not in window.shape:
        pictures.append(
            ("Waves by direction", texture_plots.directional_spectrum(window), f"{_lay(numbers)}.")
        )
        length += f" in the direction of the fastest fall; Str = {number(float(numbers['Str']))}"
    pictures.append(("Autocorrelation", texture_plots.autocorrelation_map(window), f"{length}."))
    return pictures


def _lay(numbers) -> str:
    """Return the direction of the lay in words; a surface that is the same in all directions has none."""
    if float(numbers["Str"]) > _NO_LAY:
        return "No lay: much the same in all directions"
    waves = float(numbers["Std"])
    return f"Strongest waves at {waves:.0f}° (Std), lay at {(waves + 90) % 180:.0f}°, from x towards y"


def _charts(numbers, window, shown, *, rough) -> list[tuple[str, str]]:
    """Return (title, image) of the charts; a flat map has nothing to draw."""
    if not rough:
        return []
    return [
        ("Contact area against load", plots.area_against_load(numbers, window)),
        ("Mean gap against load", plots.gap_against_load(numbers)),
        ("Distribution of the contact pressure", plots.pressure_distribution(numbers, shown)),
    ]


def _table(numbers, flags) -> dict:
    """Return header and rows of the table of numbers, each column in one unit that suits all its values."""
    header, columns = [], []
    for name, title, unit in _COLUMNS:
        values = numbers[name].values.astype(float)
        finite = np.abs(values[np.isfinite(values) & (values != 0)])
        middle = float(np.exp(np.log(finite).mean())) if finite.size else 0.0
        if unit == "%":
            factor, shown = 100.0, "%"
        elif unit == "Pa m-1":
            # a stiffness reads best as pressure per micrometre
            factor, shown = prefix(middle * 1e-6, "Pa")
            factor, shown = factor * 1e-6, f"{shown}/µm"
        elif unit == "J m-2":
            factor, shown = prefix(middle, "J")
            shown = f"{shown}/m²"
        else:
            factor, shown = prefix(middle, unit)
        header.append((title, "" if shown == "1" else shown, VARIABLES[name][1]))
        whole = name == "contact_clusters"
        half_widths = _half_widths(numbers, name)
        if half_widths is not None:
            pairs = zip(values * factor, half_widths * factor, strict=True)
            columns.append([plus_minus(*pair) for pair in pairs])
        else:
            columns.append([f"{value:.0f}" if whole else number(value * factor) for value in values])
    rows = [
        {"cells": cells, "flags": ", ".join(words)} for *cells, words in zip(*columns, flags, strict=True)
    ]
    return {"header": header, "rows": rows}


def _half_widths(numbers, name):
    """Return the combined uncertainty of a quantity (load), None where there is no budget for it."""
    if f"{name}_uncertainty" not in numbers:
        return None
    return numbers[f"{name}_uncertainty"].sel(source="combined").values


def _crosscheck(path, numbers, order) -> dict:
    """Return who cross-checked, and a row of differences for each load."""
    other = read_dataset(path).isel(load=order)
    header = (
        "mean pressure p̄",
        "pixels in contact",
        "by the other code",
        "points that differ",
        "pressure, rms difference",
        "largest pressure, difference",
        "mean gap, difference",
    )
    rows = []
    for own, theirs in ((numbers.isel(load=i), other.isel(load=i)) for i in range(order.size)):
        relative = [
            float(theirs[f"other_{name}"]) / float(own[name]) - 1 if own[name] > 0 else 0.0
            for name in ("max_pressure", "mean_gap")
        ]
        points = float(theirs["contact_difference"])
        rows.append(
            [
                quantity(float(own["mean_pressure"]), "Pa"),
                f"{100 * float(own['relative_contact_area_pixels']):.4f} %",
                f"{100 * float(theirs['other_contact_area_pixels']):.4f} %",
                "–" if np.isnan(points) else f"{points:.0f}",
                number(float(theirs["pressure_difference"]), digits=2),
                *(number(value, digits=2) for value in relative),
            ]
        )
    return {"code": f"{other.attrs['code']} {other.attrs['version']}", "header": header, "rows": rows}


def _facts(measured, levelled, window, numbers) -> list[tuple[str, str]]:
    """Return what is known of the surface, as (name, text)."""
    pitch = " × ".join(dict.fromkeys(quantity(step, "m") for step in spacing(measured)[::-1]))
    instrument = labelled(json.loads(measured.attrs.get("instrument", "{}")))
    instrument = ", ".join(f"{label} {text}" for label, text in instrument)
    source = [str(measured.attrs.get(key, "")) for key in ("source_file", "source_format")]
    resolution = float(numbers["points_per_shortest_wavelength"][0])
    facts = [
        ("File", " · ".join(filter(None, source))),
        ("Channel", str(measured.attrs.get("channel", ""))),
        ("Instrument", textwrap.shorten(instrument, 160, placeholder=" …")),
        ("Map", f"{_size(measured)} of {pitch}"),
        ("Missing points", percent(measured.attrs.get("missing_share", 0.0))),
        ("Counter-face", _counter_face(levelled)),
        ("Removed form", _removed(levelled)),
        ("Scan lines", _lines(levelled)),
        ("Filters", _filters(levelled)),
        ("Sa, Sq, Sz", _parameters(levelled, ("Sa", "Sq", "Sz"), "m")),
        ("Ssk, Sku, Sdq", _parameters(levelled, ("Ssk", "Sku", "Sdq"), "1")),
        ("Window", _size(window)),
        ("Periodisation", str(window.attrs.get("periodisation", "none"))),
        ("Sal, Str, lay", _texture(numbers)),
        ("rms height", quantity(float(numbers["rms_height"]), "m")),
        ("rms gradient g", number(float(numbers["rms_gradient"]))),
        ("rms curvature", f"{number(float(numbers['rms_curvature']) * 1e-3)} mm⁻¹"),
        ("Nayak parameter", number(float(numbers["nayak_parameter"]))),
        ("Points per shortest wave", number(resolution, digits=2)),
        ("Contact modulus E*", quantity(float(numbers["contact_modulus"]), "Pa")),
    ]
    return [(name, text) for name, text in facts if text]


def _counter_face(levelled) -> str:
    """Return how the other face of a pair lies on this one, nothing where there is a single face."""
    attrs = levelled.attrs
    if "counter_face" not in attrs:
        return ""
    shift = ", ".join(quantity(attrs[f"shift_{axis}"], "m") for axis in ("x", "y"))
    return (
        f"{attrs['counter_face']}, its middle at {shift} (x, y) from that of the face, turned by "
        f"{attrs['rotation']:g}°, on {percent(attrs['covered_share'])} of the face"
    )


def _parameters(levelled, names, unit) -> str:
    """Return some height parameters of the levelled map in words; they are those of the measured points."""
    return ", ".join(quantity(levelled.attrs[name], unit) for name in names if name in levelled.attrs)


def _texture(numbers) -> str:
    """Return length and direction of the texture in words, nothing for a flat map."""
    if not np.isfinite(numbers["Sal"]):
        return ""
    length = quantity(float(numbers["Sal"]), "m")
    if not np.isfinite(numbers["Str"]):
        return length
    return f"{length}, {number(float(numbers['Str']))}, " + (
        "none" if float(numbers["Str"]) > _NO_LAY else f"{(float(numbers['Std']) + 90) % 180:.0f}°"
    )


def _lines(levelled) -> str:
    """Return how the scan lines were aligned, nothing where they were not."""
    method = levelled.attrs.get("line_alignment", "none")
    if method == "none":
        return ""
    return f"aligned ({method}), shifts of {quantity(levelled.attrs['line_shift_rms'], 'm')} rms"


def _filters(levelled) -> str:
    """Return which waves levelling took off, nothing where it took none."""
    names = {"s_filter": "S-filter", "l_filter": "L-filter"}
    return "; ".join(
        f"{names[name]} {quantity(entry['nesting_index']['value'], 'm')}, "
        f"{quantity(entry['rms_removed']['value'], 'm')} rms taken off"
        for name, entry in json.loads(levelled.attrs.get("filters_removed", "{}")).items()
    )


def _size(height) -> str:
    """Return the size of a map in words, x first; of a profile, its length."""
    sides = [(n, length) for n, length in zip(height.shape, _lengths(height), strict=True) if n > 1][::-1]
    lengths = " × ".join(quantity(length, "m") for _, length in sides)
    points = " × ".join(str(n) for n, _ in sides)
    return f"{lengths}, {points} points"


def _removed(levelled) -> str:
    """Return what levelling removed, in words."""
    removed = json.loads(levelled.attrs.get("form_removed", "{}"))
    parts = [
        f"{name.replace('_', ' ')} {_removed_part(entry, levelled)}"
        for name, entry in removed.items()
        if name.startswith(("mean", "slope", "curvature", "radius", "axis"))  # the rest are coefficients
    ]
    return f"{levelled.attrs.get('form', 'none')}" + (f": {', '.join(parts)}" if parts else "")


def _removed_part(entry, levelled) -> str:
    """Return a mean, slope or curvature in words: 0 where over the whole map it makes no difference."""
    if entry["units"] == "degree":
        return f"{entry['value']:.2f}°".replace("-", "−")
    power = {"m": 0, "1": 1, "m-1": 2}[entry["units"]]
    over_the_map = abs(entry["value"]) * max(_lengths(levelled)) ** power
    nothing = over_the_map < 1e-6 * float(np.nanstd(levelled.values))
    return quantity(0.0 if nothing else entry["value"], entry["units"].replace("m-1", "m⁻¹"))


def _measured_caption(measured) -> str:
    missing = measured.attrs.get("missing_points", 0)
    return f"{missing} points not measured (pink)." if missing else "Every point was measured."


def _measured_maps(measured, counter_face) -> list[tuple[str, str, str]]:
    """Return (title, image, caption) of what was measured: one map, or those of a pair of faces."""
    if not counter_face:
        return [("As measured", plots.height_map(measured), _measured_caption(measured))]
    maps = [("Face, as measured", measured), ("Counter-face, as measured", _read_map(counter_face))]
    return [(title, plots.height_map(each), _measured_caption(each)) for title, each in maps]


def _levelled_caption(levelled) -> str:
    filled, rejected = levelled.attrs.get("filled_points", 0), levelled.attrs.get("outliers_rejected", 0)
    frame = "" if 1 in levelled.shape else " The red frame is the solved window."
    kinds = json.loads(levelled.attrs.get("outlier_kinds", "{}"))
    named = ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in kinds.items())
    hole = f" (largest hole {levelled.attrs['largest_hole']})" if filled else ""
    return (
        f"{filled} points filled in{hole}, {rejected} outliers rejected"
        + (f" ({named})" if named else "")
        + f".{frame}"
    )


def _versions(numbers) -> str:
    """Return the versions that wrote the statistics, in words."""
    versions = json.loads(numbers.attrs.get("versions", "{}"))
    return ", ".join(f"{name} {version}" for name, version in versions.items())


def _reason(check) -> str:
    """Return the name of a check and its first sentence, for the top of the page."""
    first = check.sentence.split(". ")[0].rstrip(".")
    return f"{check.name}: {textwrap.shorten(first, 200, placeholder=' …')}"


def _pairs(path) -> dict:
    """Return header and rows of the table of pairs: mean and spread over the ways to lay the faces on."""
    table = pd.read_csv(path)
    columns = [
        (name, title, unit, f"{name}_{unit}" if unit in ("m", "Pa") else name)
        for name, title, unit in _COLUMNS
        if name in _OF_PAIRS
    ]
    rows = []
    for _, row in table.iterrows():
        name = " · ".join(str(row[key]) for key in ("surface", "case") if key in table)
        cells = [name, str(row["members"])]
        for _, _, unit, column in columns:
            show = percent if unit == "%" else partial(quantity, unit=unit)
            mean, spread = float(row[column]), float(row[f"spread_{column}"])
            cells.append(show(mean) if np.isnan(spread) else f"{show(mean)} ± {show(spread)}")
        rows.append(cells)
    return {"header": ["pair", "members", *(title for _, title, _, _ in columns)], "rows": rows}


def _embedded(data: dict) -> str:
    """Return `data` as JSON that can stand inside a script element."""
    return json.dumps(data, sort_keys=True).replace("<", "\\u003c")


def _summary(part: str, path) -> dict:
    """Return what a part says of itself."""
    found = re.search(r'<script type="application/json" class="summary">(.*?)</script>', part, re.DOTALL)
    if found is None:
        raise InputFileError(f"{path}: is no part of a report; delete it and run again")
    return json.loads(found[1])


def _series(statistics) -> dict:
    """Return {name: statistics of its loads} of every surface (and case), loads rising, padding left out."""
    series = {}
    cases = statistics["case_name"].values if "case" in statistics.dims else [None]
    for place, case in enumerate(cases):
        of_case = statistics if case is None else statistics.isel(case=place)
        for index, surface in enumerate(statistics["surface_name"].values):
            one = of_case.isel(surface=index)
            one = one.isel(load=np.isfinite(one["mean_pressure"].values))
            name = str(surface) if case is None else f"{surface} · {case}"
            series[name] = one.isel(load=np.argsort(one["mean_pressure"].values))
    return series


def _headline(data) -> list[str]:
    """Return the few numbers of a surface that stand at the top of the page."""
    return [
        quantity(float(data["rms_height"]), "m"),
        number(float(data["rms_gradient"])),
        _span(data["mean_pressure"].values, lambda value: quantity(value, "Pa")),
        _span(data["relative_contact_area"].values, percent),
        quantity(float(data["max_pressure"].max()), "Pa"),
    ]


def _span(values, show) -> str:
    """Return the least and the largest of some values in words."""
    low, high = (show(float(f(values))) for f in (np.min, np.max))
    return low if low == high else f"{low} to {high}"
