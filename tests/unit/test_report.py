"""The report: its checks in words, its numbers, and the page in a real browser."""

import base64
import functools
import html
import http.server
import io
import json
import re
import shutil
import subprocess
import threading
import zlib
from collections import Counter
from contextlib import suppress
from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine
from PIL import Image

import roughcontact
from roughcontact.arguments.maps import height_map
from roughcontact.arguments.quantities import number, percent, with_interval
from roughcontact.contact.loads import plan_loads
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import InputFileError
from roughcontact.evaluation.evaluate import evaluate
from roughcontact.report import map_plots
from roughcontact.report.budget_plots import present_sources, shown_budget
from roughcontact.report.differences import case_rows
from roughcontact.report.gather import write_results
from roughcontact.report.glance import shown_loads
from roughcontact.report.page import _series, write_report
from roughcontact.report.panel import write_panel
from roughcontact.report.summary import read_summary, write_summary
from roughcontact.report.template import template
from roughcontact.results.collect import collect_statistics, result_entry, summary_table
from roughcontact.results.storage import provenance, read_dataset, table_text, write_dataset
from roughcontact.statistics import checks, map_checks
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.statistics.outcome import (
    FAILED,
    NOT_MADE,
    NOTE,
    PASSED,
    REVIEW,
    VERDICTS,
    worst_result,
)
from roughcontact.surface.levelling.level import level
from roughcontact.surface.window.periodic_window import periodic_window

STAGES = ("height", "levelled", "window", "contact", "statistics")
SETTINGS = {"contact": {"contact_modulus": 2e9}, "note": "<b>&"}
INSTRUMENT = json.dumps(
    {"kind": "optical profiler", "acquisition_time": "2011-07-23", "numerical_aperture": 0.4}
)
SURFACES = ("holes", "profile", "flat", "sparse")
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chrome")


def run_surface(folder, name, height, *, case=None, loads=None, keep_fields=True):
    """Take one map through all stages and draw its panel; return its entry."""
    folder = folder / (case or "all") / name
    solved = {"height": height, "levelled": level(height)}
    solved["window"] = periodic_window(solved["levelled"])
    loads = loads or plan_loads(solved["window"], contact_modulus=2e9, relative_pressure=[0.05, 0.01, 0.5])
    contact = solve_contact(solved["window"], contact_modulus=2e9, mean_pressure=loads)
    solved["statistics"] = contact_statistics(contact)
    stored_contact = contact if keep_fields else contact.drop_dims(["y", "x"])
    solved["contact"] = stored_contact
    for stage, result in solved.items():
        data = result.rename("height").to_dataset() if stage in STAGES[:3] else result
        write_dataset(
            data.assign_attrs(provenance(SETTINGS, source_sha256="ab" * 32)), folder / f"{stage}.nc"
        )
    files = {stage: folder / f"{stage}.nc" for stage in STAGES}
    panel = folder / "panel.html"
    write_panel(panel, surface=name, case=case, settings=SETTINGS, **files)
    return {"surface": name, "case": case, "statistics": files["statistics"]}


def assemble(folder, runs, title="Trial", **options):
    """Collect the statistics and write the page; return its path."""
    statistics = collect_statistics(runs)
    table = table_text(summary_table(statistics))
    write_dataset(statistics, folder / "statistics.nc")
    (folder / "summary.csv").write_text(table, encoding="utf-8")
    page = folder / "report.html"
    write_report(
        page,
        finished=runs,
        statistics=statistics,
        summary=table,
        title=title,
        **{"settings": SETTINGS} | options,
    )
    return page


def rough(seed=1, shape=(60, 80), shortest=12e-6):
    return self_affine(shape, (2e-6, 1.5e-6), (shortest, 60e-6), rms_height=3e-7, seed=seed)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A report of four surfaces: rough with holes, a profile, a flat map, one without kept fields."""
    folder = tmp_path_factory.mktemp("report")
    holes = rough().copy(deep=True)
    holes.values[10:14, 20:30] = np.nan
    values = rough(seed=2, shape=(1, 256)).values
    profile = height_map(values, 1e-6)
    flat = height_map(np.full((12, 16), 3e-7), 1e-6)
    runs = [
        run_surface(folder, "holes", holes),
        run_surface(folder, "profile", profile),
        run_surface(folder, "flat", flat, loads=[1e6, 2e6]),
        run_surface(folder, "sparse", rough(3).assign_attrs(instrument=INSTRUMENT), keep_fields=False),
    ]
    return assemble(folder, runs, title="Four <surfaces>\u202egnp.")


# --- the page ----------------------------------------------------------------------------------------------


def test_page_is_self_contained_and_complete(page):
    text = page.read_text(encoding="utf-8")
    for surface in SURFACES:
        assert text.count(f'id="surface-{surface}"') == 1
        assert f'href="#surface-{surface}"' in text
    assert "<title>Four &lt;surfaces&gt;\\u202egnp.</title>" in text
    assert "\u202e" not in text
    assert '<p class="note">contact modulus E* = 2.00 GPa; loads planned for each map</p>' in text
    assert "&lt;b&gt;&amp;" in text
    sources = re.findall(r'(?:src|href)="([^"]*)"', text)
    links_beside = {source for source in sources if not source.startswith(("#", "data:"))}
    files = {f"all/{surface}/{stage}.nc" for surface in SURFACES for stage in STAGES}
    assert links_beside == {"summary.csv", "statistics.nc"} | files  # links, which load nothing
    assert all((page.parent / file).is_file() for file in files)
    for name in SURFACES:
        part = text.partition(f'id="surface-{name}"')[2].partition("</section>")[0]
        linked = dict(re.findall(r'([\w ]+) <a class="file" href="([^"]*)"', part))
        content_name = "solution without maps" if name == "sparse" else "pressure and gap"
        assert linked[f" {content_name}"] == f"all/{name}/contact.nc"
        assert set(linked.values()) == {f"all/{name}/{stage}.nc" for stage in STAGES}
    assert not re.search(r'src="(?!data:)', text)
    assert not re.search(r"(?i)url\(|@import|https?://", re.sub(r'"data:[^"]*"', "", text))
    assert len(set(re.findall(r'\bid="([^"]*)"', text))) == len(re.findall(r'\bid="([^"]*)"', text))
    anchors = {source[1:] for source in sources if source.startswith("#")}
    assert anchors <= set(re.findall(r'\bid="([^"]*)"', text))
    alternatives = re.findall(r'<img src="data:[^"]*" alt="([^"]*)"', text)
    assert len(alternatives) == text.count("<img ")
    charts = [words for words in alternatives if words.startswith("Contact")]
    assert charts
    assert all(re.search(r"\d|numbers are in the tables? (above|below)", words) for words in charts)
    assert text.count("kept no maps of pressure and gap") == 1


def test_surfaces_with_the_same_loads_are_compared_at_one_of_them(tmp_path):
    loads = [1e6, 3e6, 1e7, 3e7, 1e8, 3e8]
    runs = [
        run_surface(tmp_path, name, rough() * factor, loads=loads) for name, factor in (("a", 1), ("b", 8))
    ]
    shown = [read_summary(Path(entry["statistics"]).with_name("panel.html"))["loads"][-1] for entry in runs]
    assert shown == [5, 5]  # the heaviest, as that of the page
    stated = {"contact": {"contact_modulus": 2e9, "mean_pressure": loads}}
    page = assemble(tmp_path, runs, settings=stated).read_text(encoding="utf-8")
    a, b = (read_dataset(entry["statistics"])["relative_contact_area"].values[-1] for entry in runs)
    assert a > b
    words = f"contact area from {percent(b)} (b) to {percent(a)} (a)."
    assert f'class="answer">At {loads[-1] / 1e6:.0f} MPa: {words}' in page


@pytest.mark.parametrize("failures", [[], [{"surface": "bad", "case": None, "reason": "bad.txt: =empty"}]])
def test_the_table_inside_the_page_is_that_beside_it(page, tmp_path, failures):
    finished = [result_entry(name, page.parent / "all" / name / "statistics.nc") for name in SURFACES]
    settings = {"settings": SETTINGS, "settings_of_statistics": {}, "groups": {}}
    superseded = page.parent / "all" / SURFACES[0] / "residual.nc"
    superseded.touch()  # of a run with contact.unload
    write_results(tmp_path, finished=finished, title="", failures=failures, **settings)
    assert not superseded.exists()
    written = (tmp_path / "report.html").read_text("utf-8")
    link = re.search(r'href="data:text/csv;charset=utf-8;base64,([^"]*)"', written)[1]
    summary = (tmp_path / "summary.csv").read_text("utf-8")
    assert base64.b64decode(html.unescape(link)).decode() == summary
    assert ("=empty" in summary) == bool(failures)


def test_panels_are_small(page):
    for panel in page.parent.rglob("panel.html"):
        assert panel.stat().st_size < 1_500_000


def test_page_is_the_same_a_second_time(page):
    folder = page.parent / "all" / "holes"
    second_page = folder / "again.html"  # where the links to the files are the same
    files = {stage: folder / f"{stage}.nc" for stage in STAGES}
    write_panel(second_page, surface="holes", case=None, settings=SETTINGS, **files)
    assert second_page.read_bytes() == (folder / "panel.html").read_bytes()
    folders = [page.parent / "all" / name for name in SURFACES]
    finished = [result_entry(path.name, path / "statistics.nc") for path in folders]
    write_report(
        page.with_name("again.html"),
        finished=finished,
        statistics=read_dataset(page.parent / "statistics.nc"),
        summary=(page.parent / "summary.csv").read_text("utf-8"),
        title="Four <surfaces>\u202egnp.",
        settings=SETTINGS,
    )
    assert page.with_name("again.html").read_bytes() == page.read_bytes()
    assert not list(page.parent.glob(".*"))


def test_numbers_of_the_page_are_those_of_the_file(page):
    statistics = read_dataset(page.parent / "all" / "holes" / "statistics.nc").sortby("mean_pressure")
    text = (page.parent / "all" / "holes" / "panel.html").read_text(encoding="utf-8")
    table = text[text.index("<caption>Contact</caption>") :]
    body = table[table.index("<tbody>") : table.index("</tbody>")]
    rows = [re.findall(r"<t[dh][^>]*>([^<]*)</t[dh]>", row) for row in body.split("<tr")[1:]]
    assert len(rows) == 3
    for row, area, clusters in zip(
        rows, statistics["relative_contact_area"], statistics["contact_clusters"], strict=True
    ):
        assert row[2] == number(100 * float(area))
        assert row[4] == str(int(clusters))
    assert "remarks" in text
    headings = re.findall(r"<p><b>(.*?) of the pixels touch</b></p>", text)
    unit = 1e-6 * statistics["mean_pressure"].values, statistics["relative_contact_area_pixels"].values
    assert headings == [
        f"{number(float(load))} MPa: {percent(float(area))}" for load, area in zip(*unit, strict=True)
    ]


def test_rows_of_numbers_have_the_colour_of_the_verdict_on_their_load(page, tmp_path):
    files = {stage: page.parent / "all" / "holes" / f"{stage}.nc" for stage in STAGES}
    judged = read_dataset(files["statistics"]).load().sortby("mean_pressure")
    files["statistics"] = tmp_path / "statistics.nc"
    write_dataset(judged.assign(verdict=("load", [0, 2, 1])), files["statistics"])
    write_panel(tmp_path / "panel.html", surface="holes", case=None, settings=SETTINGS, **files)
    table = (tmp_path / "panel.html").read_text("utf-8").partition("<caption>Contact</caption>")[2]
    body = table.partition("<tbody>")[2].partition("</tbody>")[0]
    assert re.findall(r"<tr([^>]*)>", body) == ["", ' class="failed"', ' class="review"']


def test_the_overview_has_the_weightiest_reason_and_counts_the_others(page):
    text = html.unescape(page.read_text(encoding="utf-8"))
    verdicts = re.findall(r'<a href="#surface-\w+">\w+</a> <span class="badge \w+">([^<]*)<', text)
    assert len(verdicts) == len(SURFACES)
    counted = re.findall(r"(\d+) × ([^<]*)<", text.partition("<nav")[0])
    assert {word: int(count) for count, word in counted} == Counter(verdicts)
    for name in SURFACES:
        panel = page.parent / "all" / name / "panel.html"
        summary = read_summary(panel)
        reasons = summary["reasons"]
        assert len(summary["doubts"]) == len(reasons)
        row = re.search(rf'<a href="#surface-{name}">{name}</a> <span class="badge.*?</th>', text)[0]
        count_match = re.search(r">(\d+) more reasons?</a>", row)
        assert (int(count_match[1]) if count_match else 0) == max(len(reasons) - 1, 0)
        assert summary["main_reason"] in row if reasons else 'class="why"' not in row
        assert len(summary["main_reason"]) <= 180


def test_the_head_says_what_was_asked_when_it_was_measured_and_by_which_version(page):
    head = page.read_text(encoding="utf-8").partition("<nav")[0]
    assert "contact modulus E* = 2.00 GPa; loads planned for each map</p>" in head
    assert (
        f"Measured 2011-07-23 (1 of 4 maps state it); computed by roughcontact {roughcontact.__version__}"
        in head
    )


@pytest.mark.parametrize("reason", ["Units: did you mean 93 kPa?", "Form"])
def test_a_reason_ends_with_one_mark(page, tmp_path, reason):
    panel = tmp_path / "panel.html"
    panel.write_text("", encoding="utf-8")
    summary = read_summary(page.parent / "all" / "holes" / "panel.html")
    write_summary({**summary, "reasons": [reason], "main_reason": reason}, panel)
    written = tmp_path / "report.html"
    entry = result_entry("holes", shutil.copy(page.parent / "all" / "holes" / "statistics.nc", tmp_path))
    collected = collect_statistics([entry])
    write_report(written, finished=[entry], statistics=collected, summary="", title="", settings={})
    mark = "" if reason[-1] == "?" else "."
    assert f'<span class="why">{reason}{mark}</span>' in written.read_text(encoding="utf-8")


def test_metadata_of_the_instrument_stand_under_their_labels(page):
    panel = page.parent / "all" / "sparse" / "panel.html"
    metadata = "kind optical profiler, date 2011-07-23, numerical aperture 0.4"
    assert metadata in panel.read_text(encoding="utf-8")


def test_the_summary_of_a_panel_lies_beside_it(page, tmp_path):
    summary_written = {
        "identifier": "one",
        "name": "one</script><p class='summary'>& \"two\"",
        "surface": "one",
        "answer": "At 1.00 MPa: contact area 2.00 %.",
        "verdict": "review",
        "reasons": ["Form: <b> & ±"],
        "doubts": ["Form"],
        "main_reason": "Form: <b> & ±",
        "halve": "measure 3 more places of this size",
        "halved": "contact area",
        "places": "5 places of this size in all",
        "overview": "",
        "loads": [0, 2],
        "measured": "2011-07-23",
        "waves": "waves longer than 2 µm",
    }
    write_summary(summary_written, tmp_path / "panel.html")
    assert read_summary(tmp_path / "panel.html") == summary_written
    summary = json.loads((page.parent / "all" / "holes" / "panel.json").read_text(encoding="utf-8"))
    assert summary["identifier"] == "holes"
    assert "<script" not in (page.parent / "all" / "holes" / "panel.html").read_text(encoding="utf-8")


def test_cases_stand_side_by_side(many, tmp_path):
    text = assemble(tmp_path, many[::7]).read_text(encoding="utf-8")
    for case in ("soft", "hard"):
        assert f'id="surface-{case}--s-0"' in text
        assert f"s-0 · {case}" in text
    (nav,) = re.findall(r"<nav.*?</nav>", text, re.DOTALL)
    rows_shown = re.findall(
        r'class="case">(\w+):</span> <a href="#surface-\1--s-0">.*? stroke-dasharray="(.*?)"', nav
    )
    assert rows_shown == [("soft", ""), ("hard", "6 3")]


@pytest.mark.parametrize("summary_text", [None, "", "[]", '{"name": "one"}', "\xff"])
def test_a_panel_without_its_summary_is_refused(page, tmp_path, summary_text):
    wrong = tmp_path / "panel.html"
    wrong.write_text("<p>no panel</p>", encoding="utf-8")
    if summary_text is not None:
        wrong.with_suffix(".json").write_text(summary_text, encoding="latin-1")
    with pytest.raises(InputFileError, match=r"panel\.json: no summary .* run again"):
        write_report(
            tmp_path / "r.html",
            finished=[result_entry("holes", tmp_path / "statistics.nc")],
            statistics=read_dataset(page.parent / "statistics.nc"),
            summary="",
            title="x",
            settings={},
        )
    assert not (tmp_path / "r.html").exists()


# --- the checks --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def good():
    """Statistics of a surface that passes all checks, and the attributes of its maps."""
    surface = rough(shape=(96, 96))
    loads = plan_loads(surface, contact_modulus=2e9, relative_pressure=[0.05, 0.2])
    contact = solve_contact(surface, contact_modulus=2e9, mean_pressure=loads, hardness=1.5e9)
    statistics = contact_statistics(contact)
    statistics["points_per_shortest_wavelength"][:] = 8.5
    return statistics.assign_attrs(window_flag="")


def outcomes(statistics, *, height=(), levelled=(), window=(), points=96 * 96):
    """Return {check: outcome} and the verdict."""
    check_list = checks.surface_checks(
        statistics, height=dict(height), levelled=dict(levelled), window=dict(window), points=points
    )
    return {check.name: check for check in check_list}, worst_result(check_list)


def test_a_good_surface_passes_every_check(good):
    sharp = {"spectrum_exponent": -3.0, "rounded_peaks": 0.0, "pixel_roughness": 1e-9, "pixel_pitch": 1e-6}
    sharp |= {"top_exponent": -3.0, "noise_floor": 1e-9, "noise_gradient_share": 0.1}
    sharp |= {"summit_over_next": 1.1, "summit_chance": 0.5, "quantisation_step": 0.0}
    optical = {"instrument": '{"kind": "optical profiler"}'}
    checks_by_name, verdict = outcomes(good, height=optical, window=sharp | {"reliable_reason": "the lens"})
    assert {check.outcome for check in checks_by_name.values()} == {PASSED}
    checks_by_name, verdict = outcomes(good, window=sharp)  # of a file that does not say what measured it
    assert {name for name, check in checks_by_name.items() if check.outcome != PASSED} == {
        "Band",
        "Pixel size",
    }
    assert checks_by_name["Band"].outcome == NOT_MADE
    assert VERDICTS[verdict] == "use"


ADVICE = {
    *("Average", "Check", "Compare", "Export", "Measure", "Remove", "See", "State", "Treat", "Unless", "Use")
}


def test_each_check_can_ask_for_a_look(good):
    poor = good.copy(deep=True)
    poor["points_per_shortest_wavelength"][:] = 2.0
    poor["contact_on_filled_points"][:] = 0.05
    poor["relative_contact_area_pixels"][:] = [50 / 96**2, 1.0]
    poor["rms_gradient"] = 0.7
    poor["rejected_load_share"] = ("load", [0.11, 0.04])
    poor["mean_contact_pressure"] = poor["max_pressure"] / 20
    poor.attrs["window_flag"] = "A few places hold most of the heights. Measure more places."
    poor.attrs["window_advice"] = "Measure more places."
    checks_by_name, verdict = outcomes(
        poor,
        height={
            "missing_share": 0.1,
            "ingest_warnings": json.dumps(["The unit was guessed."]),
            "instrument": json.dumps({"kind": "optical profiler"}),
        },
        levelled={
            "filled_share": 0.08,
            "outliers_rejected": 138,
            "outlier_kinds": json.dumps({"spike": 138}),
            "row_jitter": 0.1,
            "row_jitter_evidence": "clear",
            "line_alignment": "jitter",
        },
        window={
            "periodisation": "mirror",
            "rms_gradient_before": 1.0,
            "rms_gradient_after": 0.85,
            "window_share": 0.3,
            "form_share": 0.9,
            "steepest_share": 0.7,
            "spectrum_exponent": -3.0,
            "rounded_peaks": 2.0,
            "sharpest_peak_radius": 5e-6,
            "top_exponent": 0.0,
            "noise_floor": 1e-9,
            "noise_gradient_share": 0.5,
            "quantisation_step": 1e-8,
            "Sq": 1e-7,
            "pixel_roughness": 1e-12,
            "pixel_pitch": 2e-3,
            "summit_over_next": 3.0,
            "summit_chance": 1e-4,
            "summit_x": 1e-5,
            "summit_y": 1e-5,
        },
    )
    looks = {name for name, check in checks_by_name.items() if check.outcome == REVIEW}
    notes = {"Steep places", "Missing points", "Outliers", "Resolution"}
    exceptions = {"Solver", "Load range", "Longest wave", "Band", "Plasticity", "Units"}
    assert looks == set(checks_by_name) - exceptions - notes
    assert {checks_by_name[name].outcome for name in notes} == {NOTE}
    for name in looks - {"Reading the file"}:  # the last sentence says what to do
        last = checks_by_name[name].sentence.rstrip(".").split(". ")[-1]
        assert last.split()[0] in ADVICE, last
    assert VERDICTS[verdict] == "review"
    assert "down to 50" in checks_by_name["Points in contact"].sentence
    assert "−15.0 %" in checks_by_name["Periodic window"].sentence
    assert "5.00 %" in checks_by_name["Missing points"].sentence
    assert (
        "by 10.0 % of the rms height (rms); they were aligned (jitter)"
        in checks_by_name["Scan lines"].sentence
    )
    assert "138 points rejected (138 in spikes)" in checks_by_name["Outliers"].sentence
    assert "11.0 % of the load at most would lie there" in checks_by_name["Outliers"].sentence
    assert "level.form" in checks_by_name["Form"].sentence
    assert "make up 70.0 % of the mean square gradient" in checks_by_name["Steep places"].sentence
    assert checks_by_name["Reading the file"].sentence == "The unit was guessed."
    assert checks_by_name["Sample"].sentence == "A few places hold most of the heights. Measure more places."


def test_a_single_rejected_point_is_spoken_of_in_the_singular():
    shares = xr.Dataset({"rejected_load_share": ("load", [0.11])})
    sentence = map_checks.outliers(shares, {"outliers_rejected": 1, "outlier_kinds": '{"spike": 1}'}).sentence
    assert sentence.startswith("1 point rejected (1 spike); if kept, 11.0 % of the load would lie there")
    assert "whether they are errors of the measurement. See where the outliers are" in sentence


def test_slopes_that_no_surface_has_are_not_to_be_trusted(good):
    good = good.copy(deep=True)
    good["rms_gradient"] = 20.0
    checks_by_name, verdict = outcomes(good)
    assert VERDICTS[verdict] == "do not use"
    assert "Check the units" in checks_by_name["Slopes"].sentence


def test_full_contact_is_a_note_where_there_is_nothing_else(good):
    """It is the surest seal, and puts nothing in doubt."""
    closed = good.copy(deep=True)
    closed["relative_contact_area_pixels"][1] = closed["relative_contact_area"][1] = 1.0
    assert outcomes(closed)[0]["Load range"].outcome == PASSED
    closed["relative_contact_area_pixels"][:] = 1.0
    assert outcomes(closed)[0]["Load range"].outcome == NOTE


def test_edges_that_do_not_fit_together_ask_for_a_look(good):
    window = {"periodisation": "mirror", "rms_gradient_before": 1.0, "rms_gradient_after": 1.02}
    for change, outcome in ((0.4, PASSED), (0.6, REVIEW)):
        checks_by_name, _ = outcomes(good, window=window | {"periodisation_relative_change": change})
        assert checks_by_name["Periodic window"].outcome == outcome
    assert "60.0 % of their rms and the rms gradient by 2.00 %" in checks_by_name["Periodic window"].sentence


def test_a_rough_map_with_wide_patches_passes_and_one_with_narrow_patches_does_not(good):
    rough_down_to_the_pixels = good.copy(deep=True)
    rough_down_to_the_pixels["points_per_shortest_wavelength"][:] = 2.0
    checks_by_name, _ = outcomes(rough_down_to_the_pixels)
    assert checks_by_name["Resolution"].outcome == PASSED
    assert "2.0 points" in checks_by_name["Resolution"].sentence
    narrow = good.copy(deep=True)
    narrow["relative_contact_area"][0] = narrow["relative_contact_area_pixels"][0] / 1.3
    checks_by_name, _ = outcomes(narrow)
    assert checks_by_name["Resolution"].outcome == NOTE
    assert "At 1 of 2 loads" in checks_by_name["Resolution"].sentence
    assert "up to 30.0 %" in checks_by_name["Resolution"].sentence
    assert checks.load_flags(narrow, 96 * 96) == [["coarse patches"], []]
    narrow["relative_contact_area"][0] = 0
    assert outcomes(narrow)[0]["Resolution"].outcome == NOTE


def test_rejected_outliers_are_no_missing_measurements(good):
    checks_by_name, _ = outcomes(good, levelled={"outliers_rejected": 7, "filled_share": 0.001})
    assert checks_by_name["Missing points"].sentence.startswith(
        "Every point was measured; 7 were rejected as outliers"
    )


def test_rejections_are_judged_by_the_load_they_would_carry(good):
    levelled = {"outliers_rejected": 7}
    for share, outcome in ((0.0, PASSED), (0.02, PASSED), (0.021, NOTE), (1.0, NOTE)):
        carried = good.assign(rejected_load_share=("load", [share, 0.0]))
        checks_by_name, _ = outcomes(carried, levelled=levelled)
        assert checks_by_name["Outliers"].outcome == outcome
        flags = ["rejected points carry load"] if outcome == NOTE else []
        assert checks.load_flags(carried, 96 * 96) == [flags, []]
    unknown = good.assign(rejected_load_share=("load", [np.nan, np.nan]))
    for statistics in (good, unknown):
        checks_by_name, _ = outcomes(statistics, levelled=levelled)
        assert checks_by_name["Outliers"].outcome == NOTE
        assert "not known" in checks_by_name["Outliers"].sentence


def test_advice_on_spikes_knows_the_threshold_that_was_applied(good):
    steep = {"steepest_share": 0.7}
    checks_by_name, _ = outcomes(good, window=steep | {"outlier_threshold": 6.0})
    assert (
        "Spikes beyond 6.0 standard deviations are removed already" in checks_by_name["Steep places"].sentence
    )
    for window in (steep, steep | {"outlier_threshold": 0.0}):
        assert "(level.outlier_threshold)" in outcomes(good, window=window)[0]["Steep places"].sentence


def test_pressures_beyond_any_hardness_are_remarked(good):
    hard = good.drop_vars("hardness")
    hard["max_pressure"][:] = 0.02 * hard["contact_modulus"]
    hard["mean_contact_pressure"][0] = 0.01 * hard["contact_modulus"]
    hard["mean_contact_pressure"][1] = 0.2 * hard["contact_modulus"]
    assert checks.load_flags(hard, 96 * 96) == [[], ["any material would yield"]]


def test_contact_on_filling_and_missed_tolerance_are_not_to_be_trusted(good):
    filled = good.copy(deep=True)
    filled["contact_on_filled_points"][:] = 0.2
    checks_by_name, verdict = outcomes(filled, height={"missing_share": 0.3}, levelled={"filled_share": 0.3})
    assert checks_by_name["Missing points"].outcome == FAILED
    assert VERDICTS[verdict] == "do not use"
    missed = good.copy(deep=True)
    missed["converged"][1] = 0
    missed["error_bound"][1] = 0.02
    checks_by_name, verdict = outcomes(missed)
    assert checks_by_name["Solver"].outcome == FAILED
    assert (
        "1 of 2 loads missed the tolerance of 1×10⁻⁴; the error bound reaches 0.020"
        in checks_by_name["Solver"].sentence
    )
    assert verdict == FAILED
    assert checks.load_flags(missed, 96 * 96) == [[], ["not converged"]]


# --- figures -----------------------------------------------------------------------------------------------


def picture_in(chart):
    """Return the picture in a figure of a map, (rows, columns, RGB)."""
    kind, _, svg = chart.source().partition(",")
    assert kind == "data:image/svg+xml"
    root = ElementTree.fromstring(unquote(svg))
    image = root.find(".//{http://www.w3.org/2000/svg}image")
    coded = image.get("href").removeprefix("data:image/png;base64,")
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(coded))).convert("RGB")).astype(float)


@pytest.mark.parametrize("shape", [(3, 1000), (700, 20), (301, 299), (2, 2)])
def test_maps_of_odd_shapes_are_drawn(shape):
    values = np.random.default_rng(0).standard_normal(shape) * 1e-6
    values[0, 0] = np.nan
    assert picture_in(map_plots.height_map(height_map(values, 1e-6))).shape[2] == 3


@pytest.mark.parametrize("first_row", ["top", "bottom"])  # of the file; the map is right-handed by then
def test_y_grows_upwards_in_pictures(first_row):
    height = height_map(np.linspace(0, 1e-6, 40)[:, None] + np.zeros((40, 40)), 1e-6)
    height.attrs["first_row"] = first_row
    column = picture_in(map_plots.height_map(height))[:, 25]  # purple is low, yellow is high
    assert column[:10, 0].mean() > column[-10:, 0].mean()


def test_a_fine_map_keeps_its_share_of_contact_when_it_is_drawn_smaller():
    pressure = (np.random.default_rng(0).random((1800, 1800)) < 0.3) * 1e9
    height = height_map(pressure * 1e-15, 1e-6)
    inside = picture_in(map_plots.gap_map(height, np.where(pressure > 0, 0, 1e-6), pressure))
    assert inside.shape == (900, 900, 3)
    open_gap = 255 * np.array(matplotlib.colormaps["cividis"](1.0)[:3])
    assert np.allclose(inside.mean(axis=(0, 1)), 0.3 * 255 + 0.7 * open_gap, atol=3)


# --- in a browser ------------------------------------------------------------------------------------------


def in_browser(test):
    """Return a test that is skipped where there is no browser."""
    absent = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium installed")
    return pytest.mark.browser(absent(test))


def script(name, **values):
    """Return a script of the folder `scripts`, with values in place of their names in capitals."""
    folder = Path(__file__).with_name("scripts")
    text = (folder / f"{name}.html").read_text(encoding="utf-8")
    values["UNTIL"] = (folder / "until.js").read_text(encoding="utf-8")
    for key, value in values.items():
        text = text.replace(key, str(value))
    return text


def chromium(folder, *arguments):
    """Run the browser without a screen; return the process."""
    options = ("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run")
    profile = f"--user-data-dir={folder / 'profile'}"
    command = [CHROMIUM, *options, profile, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=180, check=True)


def dumped(folder, address, *options, budget=20000):
    """Show a page for some milliseconds of the browser's clock; return the process, its page on `stdout`."""
    return chromium(folder, *options, f"--virtual-time-budget={budget}", "--dump-dom", address)


@in_browser
@pytest.mark.parametrize("width", [480, 1200])
def test_page_in_a_browser(page, tmp_path, width):
    """The page, served with a probe in its head, must load nothing, break nothing and fit the window."""
    text = page.read_text(encoding="utf-8")
    (tmp_path / "page.html").write_text(text.replace("<head>", "<head>" + script("probe")), encoding="utf-8")
    requests = []

    class Handler(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            requests.append(self.path)

    handler = functools.partial(Handler, directory=str(tmp_path))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    quiet = ("--disable-sync", "--disable-background-networking", "--disable-component-update")
    address = f"http://127.0.0.1:{server.server_port}/page.html"
    try:
        browser = dumped(
            tmp_path, address, *quiet, "--enable-logging=stderr", f"--window-size={width},1000", budget=10000
        )
    finally:
        server.shutdown()
        server.server_close()
    probe = re.search(r'data-probe="([^"]*)"', browser.stdout)
    assert probe, browser.stderr[-2000:]
    result = json.loads(probe[1].replace("&quot;", '"'))
    assert result["problems"] == []
    assert result["requests"] == []
    assert requests == ["/page.html"]
    assert "CONSOLE" not in browser.stderr
    assert result["empty"] == 0
    assert result["images"] == text.count("<img ")
    assert result["sections"] == [f"surface-{name}" for name in SURFACES]
    assert result["wide"] <= 0
    assert not Path(tmp_path / "page_files").exists()


def without_policy(text):
    """Return a page whose styles a test may change."""
    changed = re.sub(r'<meta http-equiv="Content-Security-Policy" [^>]*>', "", text)
    assert changed != text
    return changed


def test_every_page_has_the_policy_before_anything_that_it_admits():
    pages = [
        text
        for folder in (Path(roughcontact.__file__).parent, Path(__file__).parents[2] / "validation")
        for path in folder.rglob("templates/*.html")
        if "<head>" in (text := path.read_text(encoding="utf-8"))
    ]
    assert len(pages) == 3  # of the run, of a surface, of the validation
    for text in pages:
        head, include, _ = text.partition('{% include "style.html" %}')
        assert include
        assert not re.search("<(script|style|link|img|body)", head)


@in_browser
def test_the_policy_of_the_page_admits_nothing_but_the_page(page, tmp_path):
    text = page.read_text(encoding="utf-8").replace("</main>", script("intruder") + "</main>")
    report_of_page = said_by(text.replace("<head>", "<head>" + script("intruded")), tmp_path)
    assert not report_of_page["ran"]
    assert report_of_page["colour"] != "rgb(1, 2, 3)"
    assert report_of_page["buttons"] > 3  # the script of the page has run
    blocked_kinds = {"script-src-elem", "script-src-attr", "img-src", "frame-src", "style-src-elem"}
    assert blocked_kinds <= set(report_of_page["blocked"])


def said_in_a_frame(text, folder, *, width, rows, columns):
    """Show a page in a frame so many pixels wide; return what a script finds in it."""
    probe = script("frame", ROWS=rows, COLUMNS=columns)
    frame = f'<iframe style="width:{width}px;height:900px;border:0" srcdoc="{html.escape(text)}"></iframe>'
    return said_by(f"<!DOCTYPE html><body>{frame}{probe}</body>", folder)


def said_by(text, folder):
    """Return what the script of a page leaves in `data-said`."""
    (folder / "frame.html").write_text(text, encoding="utf-8")
    browser = dumped(folder, (folder / "frame.html").as_uri(), "--window-size=1500,1000")
    return json.loads(unquote(re.search(r'data-said="([^"]*)"', browser.stdout)[1]))


@in_browser
@pytest.mark.parametrize("medium", [400, 1400, "print"])
def test_nothing_is_cut_off_and_maps_can_be_read(page, tmp_path, medium):
    """At both widths, and with the rules of the printed page on A4 between its margins; all sections open."""
    text = page.read_text(encoding="utf-8").replace('<details class="folded"', '<details class="folded" open')
    if medium == "print":
        text = without_policy(text).replace("@media screen", "@media not all")
        text = text.replace("@media print", "@media all")
    window = xr.open_dataset(page.parent / "all" / "holes" / "contact.nc")
    pressures = window["pressure"].sortby("mean_pressure").values
    rows, columns = pressures.shape[1:]
    report_of_page = said_in_a_frame(
        text, tmp_path, width=700 if medium == "print" else medium, rows=rows, columns=columns
    )
    assert report_of_page["page"] <= 0
    assert report_of_page["tables"] <= 0
    assert report_of_page["broken"] == report_of_page["blocked"] == []
    assert report_of_page["heads"] == report_of_page["captions"] == 0
    assert all(report_of_page["doubts"])
    assert report_of_page["passed"]
    assert not any(report_of_page["passed"])
    words = [text for _, text, _ in report_of_page["slid"]]
    assert len(set(words)) == 3
    for (seen, chosen, shown_pair), load in zip(report_of_page["slid"], (2, 1, 0), strict=True):
        assert seen == [True] * 3 if medium == "print" else [index == load for index in range(3)]
        assert chosen == f"{shown_pair.partition(':')[0]} ({load + 1} of 3)"
    assert report_of_page["here"] == ["sparse"]
    numbers = read_dataset(page.parent / "all" / "holes" / "statistics.nc").sortby("mean_pressure")
    match = re.fullmatch(
        r"largest: mean pressure ≈ (\S+) MPa, pressure in contact ≈ (\S+) MPa", report_of_page["read"]
    )
    pressure_limits = [1e-6 * float(numbers[name][0]) for name in ("mean_pressure", "max_pressure")]
    assert [float(text) for text in match.groups()] == pytest.approx(pressure_limits, rel=0.01)
    assert report_of_page["opened"]
    assert report_of_page["closed"]
    table = base64.b64decode(report_of_page["table"].partition(",")[2]).decode()
    summary_frame = summary_table(read_dataset(page.parent / "statistics.nc"))
    assert table == table_text(summary_frame)
    if medium == "print":
        return
    assert report_of_page["larger"] > 1.4
    lowest, highest = pressures[0], max(np.percentile(p[p > 0], 99.5) for p in pressures)
    read = 0
    for row, column, words in report_of_page["values"]:
        value = lowest[rows - 1 - row, column]
        if value == 0:
            assert words.endswith(": no contact")
            continue
        match, unit = re.search(r"pressure ≈ ([\d.e+-]+) (\w+)$", words).groups()
        match = float(match) * {"kPa": 1e3, "MPa": 1e6, "GPa": 1e9}[unit]
        assert abs(match - min(value, highest)) < 0.015 * highest
        read += 1
    assert read > 2


@in_browser
def test_every_point_of_a_large_map_can_be_seen_and_read(tmp_path):
    pressure = np.random.default_rng(4).uniform(0.1e6, 1e6, (700, 900))
    chart = map_plots.pressure_map(height_map(np.zeros((700, 900)), 1e-6), pressure, highest=1e6)
    points = [[row, column] for row in range(0, 700, 77) for column in range(0, 900, 91)]
    text = (
        f'<!DOCTYPE html><meta charset="utf-8"><style>{template("report.css").render()}</style>'
        '<figure style="width:300px">'
        f'<img src="{chart.source()}" alt="Pressure."></figure>{template("figures.html").render()}'
    )
    probe = script("enlarged", POINTS=json.dumps(points))
    report_of_page = said_by(text + probe, tmp_path)
    assert (
        report_of_page["words"]
        == "Pressure. 900 × 700: every point is drawn. Point at the map to read values."
    )
    assert report_of_page["zoom"]
    overview, every_point, third_state = report_of_page["states"]
    assert 300 < overview[0] < 900
    assert overview[1:] == ["auto", "Every point"]
    assert every_point == [pytest.approx(900, abs=0.5), "pixelated", "Whole map"]
    assert third_state == overview
    for (row, column), words in zip(points, report_of_page["values"], strict=True):
        pressure_read = float(re.search(r"pressure ≈ ([\d.e+-]+) MPa$", words)[1]) * 1e6
        assert abs(pressure_read - pressure[699 - row, column]) < 0.01e6


def printed(text, folder):
    """Return a page as it is printed, a PDF."""
    page, result = folder / "printed.html", folder / "printed.pdf"
    page.write_text(text, encoding="utf-8")
    chromium(folder, "--no-pdf-header-footer", f"--print-to-pdf={result}", page.as_uri())
    return result.read_bytes()


def number_of_pages(pdf):
    return max(int(count) for count in re.findall(rb"/Count (\d+)", pdf))


def pages_printed(text, folder):
    """Return the number of pages that a page is printed on, A4."""
    return number_of_pages(printed(text, folder))


@pytest.mark.slow
@in_browser
def test_a_surface_is_printed_on_two_pages_and_what_is_unfolded_on_more(page, tmp_path):
    text = without_policy(page.read_text(encoding="utf-8")).replace("@page {", "@page { size: A4;")
    head, *parts = re.split(r'(?=<section class="surface")', text.partition('<section id="legend">')[0])
    start = head.partition("<main>")[0] + "<main>"
    for part in parts:
        assert pages_printed(start + part, tmp_path) <= 1 + 2, part[:60]  # that of the title
    opened = start + parts[0].replace('<details class="part">', '<details class="part" open>')
    assert pages_printed(opened, tmp_path) > 3
    assert pages_printed(text, tmp_path) <= 2 + 2 * len(parts) + 2  # at a glance, how to read


def test_labels_of_charts_have_six_points_in_print(page):
    """On A4 within margins of 10 mm three stand side by side, those of several surfaces two."""
    head, *surfaces = page.read_text(encoding="utf-8").split('<section class="surface"')
    for text, width in ((head, 94.0), *((surface, 62.0) for surface in surfaces)):  # mm
        charts = [unquote(uri) for uri in re.findall(r'<figure><img src="data:image/svg\+xml,([^"]*)"', text)]
        assert charts
        for chart in charts:
            units = float(re.search(r'viewBox="0 0 ([\d.]+) ', chart)[1])
            assert 72 / 25.4 * width / units * float(re.search(r'font-size="([\d.]+)"', chart)[1]) >= 6.0


def test_exponents_are_raised_in_escaped_texts():
    raised = template("report.css").environment.filters["raised"]
    assert raised("\u202e") == "\\u202e"
    assert raised("<b> q^−16. As q^−5.3: x") == "&lt;b&gt; q<sup>−16</sup>. As q<sup>−5.3</sup>: x"


# --- units -------------------------------------------------------------------------------------------------


def test_a_quantity_has_one_unit_in_the_part_of_a_surface_and_in_the_table_of_all(tmp_path):
    """A polished surface is in nm, rough ones are in µm, and the table of all three is in µm."""
    maps = {"ground": rough(1), "lapped": rough(2), "polished": rough(3) * 5e-2}
    page = assemble(tmp_path, [run_surface(tmp_path, name, height) for name, height in maps.items()])
    text = unquote(page.read_text(encoding="utf-8"))
    heights = r"(?:mean gap|gap u|gap|height|narrowest place along [xy])"
    assert set(re.findall(r"[\d.]\s([nµ]m)\b", text.partition('id="surface-')[0])) == {"µm"}
    of_pressures = re.sub(r"(modulus of|modulus E\*</dt><dd>|modulus E\* =) ?[\d.]+ GPa", "", text)
    assert set(re.findall(r"[\d.] ([kMG]?Pa)\b", of_pressures)) == {"MPa"}
    for name, unit, factor in (("ground", "µm", 1e6), ("lapped", "µm", 1e6), ("polished", "nm", 1e9)):
        numbers = read_dataset(tmp_path / "all" / name / "statistics.nc").sortby("mean_pressure")
        part = text.partition(f'id="surface-{name}"')[2].partition("</section>")[0]
        assert set(re.findall(rf"{heights} \((\w+)\)", part)) == {unit}
        assert set(re.findall(r"(?:The mean gap is|rms height</dt><dd>) ?[^ ]+ (\w+)", part)) == {unit}
        for label, values in (
            ("mean pressure (MPa)", numbers["mean_pressure"] * 1e-6),
            (f"mean gap ({unit})", numbers["mean_gap"] * factor),
            ("largest pressure (MPa)", numbers["max_pressure"] * 1e-6),
        ):
            cells = re.findall(rf'data-label="{re.escape(label)}">([^<]*)<', part)
            assert cells[: values.size] == [number(float(value)) for value in values]


@pytest.mark.parametrize(("step", "unit"), [(2e-4, "mm"), (1e-4, "µm"), (1e-9, "nm")])
def test_lengths_along_a_surface_have_one_unit_on_its_page(tmp_path, step, unit):
    """Maps of 16 mm, of 8 mm with waves and texture far below a millimetre, and of 80 nm."""
    height = height_map(rough(1).values * step / 1.5e-6, step)
    text = assemble(tmp_path, [run_surface(tmp_path, "one", height)]).read_text(encoding="utf-8")
    pictures = " ".join(unquote(picture) for picture in re.findall(r'src="(data:image/svg[^"]*)"', text))
    names = "x|y|wavelength|wavenumber q"
    labels = set(re.findall(rf">((?:{names}) \([^<]*\))<", pictures))
    assert labels == {
        *(f"{axis} ({unit})" for axis in ("x", "y", "wavelength")),
        f"wavenumber q (rad/{unit})",
    }
    heads = re.findall(r'(contact perimeter|its depth)<br><span class="unit">([^<]*)<', text)
    assert {unit_shown for _, unit_shown in heads} == {unit}


def test_a_page_of_polished_surfaces_is_in_nanometres(tmp_path):
    page = assemble(tmp_path, [run_surface(tmp_path, "polished", rough(3) * 1e-2)])
    text = unquote(page.read_text(encoding="utf-8"))
    assert set(re.findall(r"(?:mean gap|gap|height) \((\w+)\)", text)) == {"nm"}
    solved = read_dataset(tmp_path / "all/polished/window.nc")["height"].values
    reading = r'"height \(nm\)", ([^,]*), ([^\]]*)\]'
    height_range = [float(limit) for limit in re.findall(reading, html.unescape(html.unescape(text)))[-1]]
    assert height_range == pytest.approx(1e9 * np.percentile(solved - solved.mean(), [0.1, 99.9]), rel=1e-6)


def test_parts_of_an_interval_that_are_larger_than_the_value_are_drawn():
    value = np.array([1e-9, 2e-9])
    sources = ["solver", "discretisation", "window", "instrument", "combined"]
    numbers = xr.Dataset({"mean_pressure": ("load", [1e6, 2e6])}, coords={"source": sources})
    for name in ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure"):
        numbers[name] = ("load", value)
        numbers[f"{name}_uncertainty"] = (("load", "source"), np.outer(value, [0.0, 0.0, 30.0, 30.0, 30.0]))
        numbers[f"{name}_lower"], numbers[f"{name}_upper"] = ("load", 0.1 * value), ("load", 31 * value)
    for _, image in shown_budget(numbers)["images"]:
        axes = ElementTree.fromstring(unquote(image.partition(",")[2])).find("{*}svg")
        lines = [path.get("d") for path in axes if path.get("fill") == "none"]
        heights = [float(y) for line in lines for _, y in re.findall(r"(-?[\d.]+) (-?[\d.]+)", line)]
        assert heights
        assert 0 < min(heights) < max(heights) < float(axes.get("height"))
    # an interval that was not found at all leaves its axes, and no marks
    budget_columns = [f"mean_gap_{column}" for column in ("uncertainty", "lower", "upper")]
    unknown = numbers.assign({column: numbers[column] * np.nan for column in budget_columns})
    image = dict(shown_budget(unknown)["images"])["mean gap"]
    axes = ElementTree.fromstring(unquote(image.partition(",")[2])).find("{*}svg")
    assert not [path for path in axes if path.get("fill") != "none"]


def test_the_sources_of_the_interval():
    to_the_pixels = rough(3, shortest=4e-6)
    numbers = evaluate(to_the_pixels, contact={"contact_modulus": 2e9, "relative_pressure": [0.05, 0.3]})
    assert present_sources(numbers) == ["solver", "discretisation", "window"]


# --- many surfaces -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """The entries of seven surfaces under two cases."""
    folder = tmp_path_factory.mktemp("many")
    return [
        run_surface(folder, f"s-{seed}", rough(seed, shape=(24, 24)), case=case)
        for case in ("soft", "hard")
        for seed in range(7)
    ]


@pytest.fixture(scope="module")
def study(many):
    """An index of these and one failure, and their pages."""
    failures = [{"surface": "bad", "case": "soft", "reason": "bad.txt: <empty>"}]
    return assemble(many[0]["statistics"].parents[2], many, failures=failures)


def test_the_page_of_a_surface_names_the_cases_that_failed(many, tmp_path):
    failures = [{"surface": "s-3", "case": "third", "reason": "no <b> hardness"}]
    index = assemble(tmp_path, many, failures=failures)
    # also where no surface has results under it
    assert "<option>hard</option><option>third</option>" in index.read_text(encoding="utf-8")
    pages = index.parent / "pages"
    for seed in range(7):
        text = (pages / f"s-{seed}.html").read_text(encoding="utf-8")
        assert ("s-3 · third" in text) == ("no &lt;b&gt; hardness" in text) == (seed == 3)


def test_a_profile_has_no_answer_on_sealing_anywhere(page):
    text = page.read_text(encoding="utf-8")
    part = text.partition('id="surface-profile"')[2].partition("</section>")[0]
    assert "a profile does not tell" in text
    assert "narrowest place" not in part
    assert "flow factor" not in part
    of_map = text.partition('id="surface-holes"')[2].partition("</section>")[0]
    assert "narrowest place along x" in of_map
    # nor colours, which only maps have
    assert ("The colours of each map" in part, "The colours of each map" in of_map) == (False, True)


def test_the_page_says_what_its_plus_minus_is(page):
    """Two halves that differ by up to a tenth are one ±, the larger one, as the page says."""
    rule = "the larger half where the two differ by up to a tenth of it"
    text = page.read_text(encoding="utf-8")
    assert text.partition("How to read this page")[2].count(rule) == 1
    assert "the larger half where the two differ by up to a tenth;" in text
    assert with_interval(10.0, 9.09, 11.0) == "10.0 ± 1.0"
    assert with_interval(10.0, 9.0, 10.91) == "10.0 ± 1.0"
    assert with_interval(10.0, 9.11, 11.0) == "10.00 −0.89 +1.0"


def test_what_takes_a_width_has_no_number_for_a_profile(page):
    """A dash in the table, no figure, an empty cell in the summary."""
    text = page.read_text(encoding="utf-8")
    entries = [
        {"surface": name, "case": None, "statistics": page.parent / "all" / name / "statistics.nc"}
        for name in SURFACES[:2]
    ]
    written = table_text(summary_table(collect_statistics(entries))).splitlines()
    rows = [dict(zip(written[0].split(","), line.split(","), strict=False)) for line in written[1:]]
    for name, empty in (("holes", False), ("profile", True)):
        part = text.partition(f'id="surface-{name}"')[2].partition("</section>")[0]
        for name_of_column in ("largest patch (µm²)", "contact perimeter (µm)"):
            cells = re.findall(rf'<td data-label="{re.escape(name_of_column)}">(.*?)</td>', part)
            assert [cell == "–" for cell in cells] == [empty] * 3
        assert not re.search(r">[^<]*\bnan\b", part)
        for row in (row for row in rows if row["surface"] == name):
            columns = ["largest_patch_area_m2", "contact_perimeter_m", "window_length_y_m"]
            assert [row[column] == "" for column in columns] == [empty] * 3
            assert "" not in (row["contact_clusters"], row["window_length_x_m"])


def test_of_many_surfaces_there_is_an_index_and_a_page_each(study):
    text = study.read_text(encoding="utf-8")
    pages = study.parent / "pages"
    assert sorted(page.name for page in pages.iterdir()) == [f"s-{seed}.html" for seed in range(7)]
    links = re.findall(r'href="(pages/[^"]*)"', text)
    assert len(links) == 14
    for link in links:
        name, _, anchor = link.partition("#")
        page = (study.parent / name).read_text(encoding="utf-8")
        assert page.count(f'id="{anchor}"') == 1
        assert '<a href="../report.html">' in page
        assert "contact modulus E* = 2.00 GPa" in page.partition("<nav")[0]
        seed = int(re.search(r"s-(\d)\.html", link)[1])
        neighbours = re.findall(r'<a href="s-(\d)\.html">(‹|s-\d ›)', page)
        assert neighbours == [
            *[(str(seed - 1), "‹")] * (seed > 0),
            *[(str(seed + 1), f"s-{seed + 1} ›")] * (seed < 6),
        ]
        files = re.findall(r'<a class="file" href="([^"]*)"', page)
        stem = name.removesuffix(".html").removeprefix("pages/")
        expected_links = {f"../{case}/{stem}/{stage}.nc" for case in ("soft", "hard") for stage in STAGES}
        assert set(files) == expected_links
        assert all((pages / file).is_file() for file in files)
    assert "bad.txt: &lt;empty&gt;" in text
    assert "<img" not in text  # lines of so many surfaces over one another would tell nothing
    for page in (text, *(path.read_text(encoding="utf-8") for path in pages.iterdir())):
        assert not re.search(r"(?i)url\(|@import|https?://", re.sub(r'"data:[^"]*"', "", page))
    assert len(text) < 200_000


def test_the_index_answers_for_all_surfaces_at_one_load(study):
    text = study.read_text(encoding="utf-8")
    rows = re.findall(r'<tr data-verdict="[^n]\w*">(.*?)</tr>', text)
    collected = read_dataset(study.parent / "statistics.nc")
    assert len(rows) == 14
    for row in rows:
        surface, case = re.search(r'html#[^>]*>([^<]*)</a></td><td class="text">([^<]*)<', row).groups()
        indices = (
            list(collected["surface_name"].values).index(surface),
            list(collected["case_name"].values).index(case),
        )
        numbers = collected.isel(surface=indices[0], case=indices[1]).sortby("mean_pressure").isel(load=-1)
        cells = dict(re.findall(r'data-label="([^"]*)"[^>]*>([^<]*)<', row))
        assert cells["mean pressure"] == f"{number(float(numbers['mean_pressure']) * 1e-6)} MPa"
        assert cells["contact area"] == percent(float(numbers["relative_contact_area"]))
        assert not {"largest pressure", "seals?", "yields?"} & cells.keys()  # nobody has asked for them
        # by what a click on a heading sorts
        keys = dict(re.findall(r'data-label="([^"]*)" data-key="([^"]*)"', row))
        assert [float(key) for key in keys.values()] == [
            pytest.approx(float(numbers[name]), rel=1e-12)
            for name in ("mean_pressure", "relative_contact_area", "mean_contact_pressure", "mean_gap")
        ]


def numbers_at(*loads, **columns):
    """Return statistics at some mean pressures (Pa): 1 where nothing else is stated."""
    names = ("relative_contact_area", "mean_contact_pressure", "max_pressure", "mean_gap")
    columns = dict.fromkeys(names, 1.0) | columns | {"mean_pressure": loads}
    return xr.Dataset(
        {name: ("load", np.array(np.broadcast_to(column, len(loads)))) for name, column in columns.items()}
    )


def area_between(area, down, up, load=1e6):
    """Return statistics at a load (Pa) with an area and how far its interval goes."""
    ends = {"relative_contact_area_lower": area - down, "relative_contact_area_upper": area + up}
    return numbers_at(load, relative_contact_area=area, **ends)


def shown_case_rows(cases, **options):
    """Return {second against first: {quantity: [ratio and its interval at each load]}}, loads under "at"."""
    found = {}
    for row in case_rows(cases, **options):
        cells = {part["quantity"]: part["cells"] for part in row["rows"]}
        texts = {name: [f"{cell.text} {cell.details}".rstrip() for cell in cells[name]] for name in cells}
        found[f"{row['second']} against {row['first']}"] = texts | {"at": row["loads"]}
    return found


def test_cases_are_compared_by_their_ratio_without_what_both_share():
    case_a = numbers_at(
        *(1e6, 2e6),
        relative_contact_area=[0.1, 0.2],
        mean_contact_pressure=1e7,
        max_pressure=[3e7, 4e7],
        mean_gap=[2e-6, 0.0],
        mean_gap_lower=[2e-6 / np.exp(0.03), np.nan],
        mean_gap_upper=[2e-6 * np.exp(0.03), np.nan],
    )
    case_b = case_a * 2
    bounds = {"lower": 4e-6 / np.exp(0.04), "upper": 4e-6 * np.exp(0.04)}
    case_b = case_b.assign(
        {f"mean_gap_{bound}": ("load", [value, np.nan]) for bound, value in bounds.items()}
    )
    found = shown_case_rows({"one": case_a, "two": case_b}, equal_loads=True)
    row = found["two against one"]
    assert (row["at"], row["contact area"]) == (["1.00 MPa / 2.00 MPa", "2.00 MPa / 4.00 MPa"], ["2.00"] * 2)
    # independent where nothing is known of what both share: 2 e^(± hypot(0.03, 0.04)) = 1.902 to 2.103
    assert row["mean gap"] == [
        "2.00 1.90 to 2.10",
        "– closed (< 1 nm)",
    ]  # a closed gap is no multiple of another
    assert case_rows({"one": case_a}) == []
    # on bodies of finite size the force is what both share
    radius = ("load", [1e-5, 2e-5])
    bodies = {
        name: data.assign(force=("load", [1.0, 2.0]), contact_radius=radius)
        for name, data in (("a", case_a), ("b", case_b))
    }
    found = shown_case_rows(bodies, equal_loads=True)
    assert found["b against a"]["at"] == ["1.00 N", "2.00 N"]


def test_differences_of_cases_reach_as_far_as_the_ends_of_both_intervals():
    def case(gap, down, up):
        ends = {"mean_gap_lower": gap * np.exp(-down), "mean_gap_upper": gap * np.exp(up)}
        return numbers_at(1e6, mean_gap=gap, **ends)

    found = shown_case_rows({"one": case(1e-6, 0.3, 0.01), "two": case(2e-6, 0.01, 0.4)})
    # up: 2 e^hypot(0.4, 0.3) = 3.297, down: 2 e^-hypot(0.01, 0.01) = 1.972
    assert found["two against one"]["mean gap"] == ["2.00 1.97 to 3.30"]


def test_stated_loads_of_cases_are_compared_with_one_another_and_those_of_a_target():
    names = ("mean_contact_pressure", "max_pressure", "mean_gap", "relative_contact_area")

    def surface(*pressures):
        """Two loads that are stated, and that of a target."""
        numbers = {name: ("load", np.array([0.3, 0.4, 0.1])) for name in names}
        return xr.Dataset(numbers | {"surface_name": "a"}, {"mean_pressure": ("load", [*pressures])})

    def on_the_page(data):
        (series,) = _series(data.expand_dims("surface")).values()
        return series

    soft, stiff = (on_the_page(surface(5e7, 2e8, target)) for target in (1e8, 4e8))
    found = shown_case_rows({"one": soft, "two": stiff}, equal_loads=True)
    assert found["two against one"]["at"] == ["50.0 MPa", "100 MPa / 400 MPa", "200 MPa"]
    assert found["two against one"]["contact area"] == ["1.00"] * 3


def test_cases_are_compared_at_the_loads_that_they_share_and_at_no_others():
    def case(*loads, modulus=1e9):
        areas, relative = np.array(loads) * 1e-8, np.array(loads) / modulus
        return numbers_at(*loads, relative_contact_area=areas, relative_pressure=relative)

    case_a = case(1e6, 2e6, 5e6)
    found = shown_case_rows({"one": case_a, "two": case(2e6, 3e6, 5e6)})
    assert found["two against one"]["at"] == ["2.00 MPa", "5.00 MPa"]
    assert found["two against one"]["contact area"] == ["1.00"] * 2
    # 5 MPa is a load of both, but all three are the same ones relative to E* g
    stiffer = shown_case_rows({"one": case_a, "two": case(5e6, 1e7, 2.5e7, modulus=5e9)})
    assert len(stiffer["two against one"]["at"]) == 3
    (none,) = case_rows({"one": case_a, "two": case(4.95e3, 9.9e3, 2e4)})
    assert (none["first"], none["second"], none["loads"]) == ("one", "two", [])


def load_case(*loads, gap=1e-6):
    """Return statistics of a case at some mean pressures (MPa): its area grows with them."""
    pressures = np.array(loads) * 1e6
    return numbers_at(*pressures, relative_contact_area=np.array(loads) / 100, mean_gap=gap)


def test_each_two_of_three_cases_are_compared_at_the_loads_that_these_two_share():
    cases = {"one": load_case(1.0, 2.0), "two": load_case(2.0, 5.0, gap=2e-6), "three": load_case(1.0, 5.0)}
    found = shown_case_rows(cases)
    assert {pair: (row["at"], row["mean gap"]) for pair, row in found.items()} == {
        "two against one": (["2.00 MPa"], ["2.00"]),
        "three against one": (["1.00 MPa"], ["1.00"]),
        "three against two": (["5.00 MPa"], ["0.500"]),
    }
    # a pair without a load in common has none, the others are compared
    cases = {"one": load_case(1.0, 2.0), "two": load_case(2.0, 5.0), "three": load_case(5.0, 9.0)}
    found = shown_case_rows(cases)
    assert {pair: len(row["at"]) for pair, row in found.items()} == {
        "two against one": 1,
        "three against one": 0,
        "three against two": 1,
    }
    four = shown_case_rows(cases | {"four": load_case(1.0, 2.0, 5.0)})
    assert [*four] == ["two against one", "three against one", "four against one"]


def test_a_ratio_that_is_nearly_certain_has_no_more_digits_than_a_thousandth():
    # of independent errors: 1.11 hypot(0.111 %, 0.1 %) = 0.166 %
    for half, text in ((1e-9, "1.1111"), (1e-4, "1.1111 1.1095 to 1.1128"), (0.01, "1.11 0.957 to 1.29")):
        both = {name: area_between(area, half, half) for name, area in (("one", 0.09), ("two", 0.1))}
        assert shown_case_rows(both)["two against one"]["contact area"] == [text]


def test_the_page_says_that_cases_share_no_load(tmp_path):
    cases = {"soft": [1e6, 2e6], "hard": [4e6, 5e6]}
    runs = [
        run_surface(tmp_path, "one", rough(shape=(24, 24)), case=case, loads=loads)
        for case, loads in cases.items()
    ]
    contact = {"contact_modulus": 2e9}
    settings = {case: {"contact": contact | {"mean_pressure": loads}} for case, loads in cases.items()}
    text = assemble(tmp_path, runs, settings=settings).read_text(encoding="utf-8")
    part = text.partition('<section id="cases">')[2].partition("</section>")[0]
    assert "one: soft and hard have no load in common" in part
    assert "<table" not in part
    # a target may take other loads
    target = {name: {"contact": contact | {"target_area": [0.1, 0.2]}} for name in settings}
    same = assemble(tmp_path, runs, settings=target).read_text(encoding="utf-8")
    assert "1.00 MPa / 4.00 MPa" in same.partition('<section id="cases">')[2]


@in_browser
def test_loads_have_a_row_of_their_own_on_a_phone(many, tmp_path):
    text = assemble(tmp_path, many[::7]).read_text(encoding="utf-8")
    probe = """<script>addEventListener("load", () => {
      const inside = document.querySelector("iframe").contentDocument;
      const width = part => inside.querySelector(part).getBoundingClientRect().width;
      const ends = part => inside.querySelector(part).getBoundingClientRect().right;
      const said = [width(".cases td") / width(".cases tbody tr"), width(".loads input") / width(".loads")];
      said.push(ends(".loads input") / ends(".loads"));
      said.push(width(".cases td:last-child") / width(".cases tbody tr"));
      document.body.setAttribute("data-said", encodeURIComponent(JSON.stringify(said)));
    });</script>"""
    frame = f'<iframe style="width:400px;height:900px;border:0" srcdoc="{html.escape(text)}"></iframe>'
    assert said_by(f"<!DOCTYPE html><body>{frame}{probe}</body>", tmp_path) == pytest.approx(
        [1] * 4, abs=0.001
    )


@in_browser
def test_a_number_and_its_interval_stand_apart_on_a_phone(study, page, tmp_path):
    cell_with_interval = (
        '<span class="more">± 1</span><span class="mark">review</span></td>'  # without a ± there
    )
    index = study.read_text(encoding="utf-8").replace("</td>", cell_with_interval)
    styles = [
        said_by(
            "<!DOCTYPE html><body>"
            f'<iframe style="width:400px;height:900px;border:0" srcdoc="{html.escape(text)}"></iframe>'
            """<script>addEventListener("load", () => {
              const inside = document.querySelector("iframe").contentDocument;
              const styles = [...inside.querySelectorAll("td .more, td .mark")].map(part => {
                const before = getComputedStyle(part, "::before").content;
                return [getComputedStyle(part).display, before.slice(0, 3)];
              });
              document.body.setAttribute("data-said", encodeURIComponent(JSON.stringify(styles)));
            });</script></body>""",
            tmp_path,
        )
        for text in (index, page.read_text(encoding="utf-8"))
    ]
    assert all(styles)
    # by a space that does not break, so that no line begins with the dot
    assert {tuple(style) for styles in styles for style in styles} == {("inline", '"\N{NO-BREAK SPACE}·')}


@in_browser
@pytest.mark.parametrize("keep_fields", [True, False])
def test_the_slider_goes_through_all_loads_that_were_solved(tmp_path, keep_fields):
    loads = [1e5, 2e5, 1e6, 4e6, 1e7, 5e7]
    runs = [run_surface(tmp_path, "one", rough(), loads=loads, keep_fields=keep_fields)]
    text = assemble(tmp_path, runs).read_text(encoding="utf-8")
    report_of_page = said_by(text.replace("<head>", "<head>" + script("slider")), tmp_path)
    numbers = read_dataset(runs[0]["statistics"])
    drawn = shown_loads(numbers["relative_contact_area"].values) if keep_fields else []
    assert 1 < len(drawn) < len(loads) or not keep_fields
    assert report_of_page["last"] == len(loads) - 1
    assert report_of_page["start"] in drawn or not keep_fields
    assert report_of_page["large"] == ([drawn[-1], len(loads) - 1] if keep_fields else None)
    for index, (label, captions, lines) in enumerate(report_of_page["loads"]):
        load = numbers.isel(load=index)
        words = label.replace("\N{NO-BREAK SPACE}", " ")
        assert f"{number(loads[index] / 1e6)} MPa ({index + 1} of 6)" in words
        assert f"contact area {percent(float(load['relative_contact_area']))}" in words
        assert f"pressure in contact {number(float(load['mean_contact_pressure']) / 1e6)} MPa" in words
        assert "largest pressure" not in words  # nobody has asked for it
        assert ("not drawn" in words) == (index not in drawn)
        if keep_fields:
            nearest = min(drawn, key=lambda index_drawn: abs(np.log(loads[index_drawn] / loads[index])))
            assert [caption.partition(":")[0] for caption in captions] == [
                f"{number(loads[nearest] / 1e6)} MPa"
            ]
        # the line is where the chart has this load: its axis ends at 1.5 times the highest
        share = np.log(1.5 * loads[index] / loads[0]) / np.log(2.25 * loads[-1] / loads[0])
        for (at, top, height), (left_edge, above, width, tall, full_height) in zip(
            lines, axes_of_charts(text), strict=True
        ):
            assert at == pytest.approx((left_edge + share * width) / 430, abs=0.005)
            assert (top, height) == pytest.approx((above / full_height, tall / full_height), abs=0.01)


def axes_of_charts(text):
    """Return (left, top, width, height) of the axes of the charts against load, and the whole height."""
    part = text.partition("against-load")[2]
    axes = []
    for source in re.findall(r'<img src="data:image/svg\+xml,([^"]*)"', part)[:3]:
        svg = unquote(html.unescape(source))
        axes.append(
            (
                *json.loads(re.search(r'"area": (\[[^]]*\])', svg)[1]),
                float(re.search(r'viewBox="0 0 430 ([\d.]+)"', svg)[1]),
            )
        )
    return axes


@pytest.mark.parametrize("results", [1, 14])
def test_a_file_that_fails_under_several_cases_is_listed_once(many, tmp_path, results):
    failures = [{"surface": "bad", "case": case, "reason": "bad.txt: empty"} for case in ("soft", "hard")]
    failures.append({"surface": "bad", "case": "rough", "reason": "another"})
    text = assemble(tmp_path, many[:results], failures=failures).read_text(encoding="utf-8")
    assert "3 without results" in text
    assert text.count("bad.txt: empty") == text.count("soft, hard<") == 1
    assert text.count('<tr class="failure"') == 2


@in_browser
def test_a_printed_index_has_its_heads_on_every_page(study, tmp_path):
    text = study.read_text(encoding="utf-8")
    head, rows, _ = re.split(r"<tbody>|</tbody>", text, maxsplit=2)
    # heads in a colour by which they are known; what follows the table is left out
    marked = without_policy(head).replace("</style>", ".many thead th { color: #010203 }</style>")
    file = printed(f"{marked}<tbody>{10 * rows}</tbody></table></div></section></main>", tmp_path)
    drawn = []
    for stream in re.finditer(rb"stream\r?\n", file):
        with suppress(zlib.error):
            drawn.append(zlib.decompressobj().decompress(file[stream.end() :]))
    # 1, 2 and 3 of 255
    with_heads = sum(bool(re.search(rb"0?\.0039\d* 0?\.0078\d* 0?\.011[78]\d* rg", page)) for page in drawn)
    assert with_heads == number_of_pages(file)
    assert with_heads > 3


@in_browser
def test_the_index_is_sorted_and_filtered(study, tmp_path):
    page = tmp_path / "index.html"
    page.write_text(
        study.read_text(encoding="utf-8").replace("<head>", "<head>" + script("sort")), encoding="utf-8"
    )
    browser = dumped(tmp_path, page.as_uri(), "--window-size=500,900", budget=5000)
    state, unsorted, back = json.loads(html.unescape(re.search(r'data-said="([^"]*)"', browser.stdout)[1]))
    assert state["all"] == 15
    assert not state["clear"]
    for title, up, keys, down, downwards in state["columns"]:
        assert sorted(up) == sorted(down)
        assert len(up) == 15
        if title not in ("surface", "case", "verdict", "reasons"):
            assert up[-1] == down[-1] == "bad · soft"  # without numbers
        if title.endswith("?") or title in ("surface", "case", "reasons"):
            continue
        for sort_keys, sign in ((keys, 1), (downwards, -1)):
            numbers = [sign * float(key) for key in sort_keys if key is not None]
            assert len(numbers) == (15 if title == "verdict" else 14)
            assert numbers == sorted(numbers)
    assert state["columns"][0][1][0] == "bad · soft"
    assert {name.partition(" · ")[2] for name in state["columns"][1][1][:7]} == {"hard"}
    assert sorted(state["found"]) == ["s-3 · hard", "s-3 · soft"]
    assert state["both"] == ["s-3 · hard"]
    assert state["cleared"] == 15
    assert state["failed"] == ["bad · soft"]
    for words, count in state["reasons"]:
        assert words.endswith(f" ({count})")
    assert state["reasons"]
    assert state["wide"] <= 0
    assert len(back[0]) == 7
    assert back == unsorted
