"""The page `roughcontact app`: five steps in a real browser, who is refused, keys alone, narrow screens."""

import asyncio
import contextlib
import html
import html.parser
import http.client
import http.server
import json
import os
import re
import resource
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import tomllib
import urllib.parse
from functools import partial
from pathlib import Path

import numpy as np
import psutil
import pytest
import uvicorn
import xarray as xr
import yaml
from browser import CHROMIUM, Browser
from packaging.requirements import Requirement
from starlette.responses import PlainTextResponse

from data_samples.make_samples import matrix_bytes, profile_bytes, sdf_bytes, x3p_bytes
from roughcontact import SettingsError, self_affine_surface
from roughcontact.arguments.rectangles import parse_rectangles
from roughcontact.arguments.settings.fields import field_at, is_list, section_model
from roughcontact.arguments.settings.models import Body, Settings
from roughcontact.arguments.settings.plausible import setting_base, value_at
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.units import printed
from roughcontact.interface.app import commands, measurements, server, study
from roughcontact.interface.app.measurements import save_upload
from roughcontact.interface.app.page import Page
from roughcontact.interface.app.study import CONFIG, JOBS, names_of
from roughcontact.interface.command_line.saving import EXPORTS
from roughcontact.io import inspection, registry
from roughcontact.io.guards import sha256
from roughcontact.report.summary import Summary, write_summary
from roughcontact.results.storage import write_dataset
from roughcontact.study.table.columns import column_choices, column_meaning
from roughcontact.study.table.read import read_surfaces
from roughcontact.study.table.text import read_table

in_browser = [pytest.mark.browser, pytest.mark.skipif(CHROMIUM is None, reason="no Chromium installed")]
SUMMARY = {key: [] if key in ("reasons", "doubts", "loads") else "use" for key in Summary.__annotations__}
ROOT = Path(__file__).parents[2]
ROUGHNESS = {"hurst": 0.8, "shortest": 8e-6, "longest": 32e-6, "rms_gradient": 0.1}
PROGRAM = [sys.executable, "-m", "roughcontact.interface"]


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    """One browser for all tests."""
    with Browser(tmp_path_factory.mktemp("profile")) as browser:
        yield browser


@pytest.fixture
def browser(chromium):
    """The browser with one page, a new one."""
    chromium.start_again()
    return chromium


@contextlib.contextmanager
def served(folder, *, program=PROGRAM, options=("--no-browser",), ended_by=signal.SIGINT, **started):
    """The address of the page of a folder, served by the program; `started` is for its process."""
    command = [*map(str, program), "app", str(folder), *options]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes, **started) as process:
        try:
            line = process.stdout.readline()
            assert "http://" in line, process.stderr.read()
            yield re.search(r"http://\S+", line)[0]
        finally:
            process.send_signal(ended_by)
            _, output = process.communicate(timeout=60)
    assert "Traceback" not in output, output
    assert process.returncode == 128 + ended_by


def opened(address):
    """A function that sends changes and a button of the page, as its script does: status, and the answer."""
    assert get(address)[0] == 200
    return lambda form, action="": get(address, method="POST", form=form | {"page.do": action})


def maps(folder, size=64):
    """Write maps in three formats: X3P, SDF, and an array of NumPy, which states neither pitch nor unit."""
    folder.mkdir(parents=True, exist_ok=True)
    heights_x3p, heights_sdf, three = (
        self_affine_surface((size, size), 1e-6, **ROUGHNESS, seed=seed).values for seed in (1, 2, 3)
    )
    (folder / "one.x3p").write_bytes(x3p_bytes(heights_x3p, 1e-6))
    (folder / "two.sdf").write_bytes(sdf_bytes(heights_sdf, 1e-6))
    np.save(folder / "three.npy", three * 1e6)
    return [folder / name for name in ("one.x3p", "two.sdf", "three.npy")]


def fill(browser, name, text):
    """Write a text into the field of a setting, as typing does."""
    browser.evaluate(
        f"{{ const field = document.getElementById({json.dumps(name)}) "
        f"?? document.getElementById({json.dumps(f'{name}.0')}); "
        "for (let part = field; part = part.parentElement?.closest('details');) part.open = true; "
        f"field.value = {json.dumps(text)}; field.dispatchEvent(new Event('input', {{bubbles: true}})); }}"
    )


def fill_cell(browser, number, column, text):
    """Write a text into a cell of a row, as typing does."""
    browser.evaluate(
        f"{{ const cell = document.getElementById('rows.{number}.{column}'); "
        f"cell.value = {json.dumps(text)}; cell.dispatchEvent(new Event('input', {{bubbles: true}})); }}"
    )


def click(browser, selector):
    browser.evaluate(f"document.querySelector({json.dumps(selector)}).click()")


def show(browser, address):
    """Open the page and wait until its first answer is there."""
    browser.open(address)
    browser.wait("document.querySelector('#preview')")


def ask(browser, job):
    """Choose a question and wait for its fields."""
    click(browser, f"[name='page.job'][value={job}]")
    browser.wait(f"document.querySelector('#fields h2').textContent === '3 {JOBS[job]['question']}'")


def picture(browser, name, selector="html"):
    """Keep a picture where the variable ROUGHCONTACT_PICTURES names a folder: those of the page on it."""
    if folder := os.environ.get("ROUGHCONTACT_PICTURES"):
        from PIL import Image

        path = Path(folder, f"{name}.png")
        browser.picture(path, selector=selector)
        with Image.open(path) as drawn:
            drawn.quantize(64).save(path, optimize=True)


def rows_read(browser, count):
    """Wait until so many files are in the table, and read."""
    browser.wait(f"document.querySelectorAll('.row').length === {count}")
    browser.wait("!document.querySelector('#rows').textContent.includes('is read ...')")
    browser.wait("document.body.ariaBusy === 'false'")


def drag(browser, *corners):
    """Drag over the map, from and to shares of its sides (x from the left, y from the top)."""
    browser.evaluate("document.querySelector('#map').scrollIntoView({block: 'center'})")
    frame = browser.evaluate(
        "(b => [b.x, b.y, b.width, b.height])(document.querySelector('#map').getBoundingClientRect())"
    )
    points = [(frame[0] + x * frame[2], frame[1] + y * frame[3]) for x, y in corners]
    for kind, (x, y) in zip(
        ("mousePressed", "mouseMoved", "mouseReleased"), (*points, points[1]), strict=True
    ):
        press = {"button": "left", "buttons": 1, "clickCount": 1}
        browser.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, **press)


def saved(browser):
    """Wait until all that was typed is in the files."""
    browser.wait("document.body.ariaBusy === 'false' && !waiting && !Object.keys(changes).length")


STEPS_IN_VIEW = (
    "(bar => [Math.round(bar.top), bar.bottom > 30, document.documentElement.scrollWidth <= innerWidth])"
    "(document.querySelector('#steps').getBoundingClientRect())"
)


def report_open(browser):
    """Wait until the report is loaded."""
    browser.wait("location.pathname.endsWith('report.html') && document.readyState === 'complete'")


class TestFiveSteps:
    pytestmark = in_browser

    def test_from_an_empty_folder_to_a_report(self, tmp_path, browser):
        study = tmp_path / "my study"
        files = maps(tmp_path / "instrument", 128)
        with served(study) as address:
            browser.resize(1400)
            browser.open(address)
            # 1: a question; an empty page complains of nothing
            browser.wait("document.querySelector('#preview')")
            assert (
                browser.evaluate("[...document.querySelectorAll('.mistake')].map(e => e.innerText).join('')")
                == ""
            )
            assert not browser.evaluate("document.querySelector('#mistakes')")
            click(browser, "[name='page.job'][value=area]")
            browser.wait("document.querySelector('#mistakes')")
            assert "choose measured files" in browser.text("#mistakes")
            # 2: files, of which one does not say its unit
            browser.choose_files("#choose", *files)
            rows_read(browser, 3)
            assert browser.text("#added").startswith("3 added")
            assert sorted(path.name for path in (study / "measured").iterdir()) == sorted(
                p.name for p in files
            )
            lines = [browser.text(f".row:nth-child({number}) .line") for number in (1, 2, 3)]
            assert lines[0] == lines[1].replace("1.81", "1.88")
            assert lines[0].startswith("128 × 128 points, 128.0 µm × 128.0 µm, heights over ")
            assert " ".join(lines[2].split()).endswith("; give dx, dy, unit, height_unit")
            seen = "[...document.querySelectorAll('.row img')].filter(image => image.naturalWidth > 0).length"
            browser.wait(f"{seen} === 2")
            for column, text in (("dx", "1 um"), ("dy", "1 um"), ("unit", "um")):
                browser.wait(f"document.getElementById('rows.2.{column}')")
                fill_cell(browser, 2, column, text)
            browser.wait(f"{seen} === 3")
            # groups by selecting: what has just been added is ticked
            click(browser, ".row:nth-child(3) .pick")
            browser.evaluate("document.querySelector('#column').value = 'group'")
            browser.evaluate("document.querySelector('#cell').value = 'ground'")
            click(browser, "#selected button[value=set]")
            browser.wait("document.getElementById('rows.1.group')?.value === 'ground'")
            assert browser.evaluate("document.getElementById('rows.2.group')") is None
            picture(browser, "app-files", "#files")
            # 3: bodies and loads, a load in the wrong unit
            fill(browser, "contact.bodies.0.material", "steel")
            fill(browser, "contact.bodies.1.material", "PEEK")
            placeholder = "document.getElementById('contact.bodies.0.youngs_modulus').placeholder"
            browser.wait(f"{placeholder} === '207 GPa'")
            fill(browser, "contact.bodies.1.youngs_modulus", "4 GPa")
            fill(browser, "contact.mean_pressure", "5")
            mistake = "[data-of='contact.mean_pressure']"
            browser.wait(f'document.querySelector("{mistake}").textContent')
            message = browser.text(mistake)
            assert "5.00 Pa is next to no load" in message
            assert "did you mean 5.00 MPa" in message
            with pytest.raises(Exception, match="mistakes in") as refused:
                resolve({"contact": {"bodies": ["steel", "PEEK"], "mean_pressure": [5]}})
            assert message.splitlines()[0] in str(refused.value)
            assert browser.evaluate("document.querySelector('#start').ariaDisabled") == "true"
            assert message in browser.text("#mistakes")
            # who presses it all the same reads why it does nothing
            click(browser, "#start")
            browser.wait("document.querySelector('#problem').textContent.startsWith('nothing is started')")
            fill(browser, "contact.mean_pressure", "5 MPa")
            # a second load by the plus
            click(browser, "[data-field='contact.mean_pressure'] .more")
            browser.wait("document.activeElement.id === 'contact.mean_pressure.1'")
            browser.type("20 MPa")
            browser.wait("!document.querySelector('#start').ariaDisabled")
            saved(browser)
            picture(browser, "app-bodies", "#fields")
            # all of it is in the files
            preview = browser.text("#preview")
            written = (study / "config/config.yaml").read_text()
            table = (study / "config/surfaces.tsv").read_text()
            assert written in preview
            assert table in preview
            contact = yaml.safe_load(written)["contact"]
            assert contact["mean_pressure"] == ["5 MPa", "20 MPa"]
            with contextlib.chdir(study):
                rows = read_surfaces("config/surfaces.tsv")
            assert [row.group for row in rows.values()] == ["ground", "ground", ""]
            assert rows["three"].read_arguments == {"unit": "um", "dx": "1 um", "dy": "1 um"}
            # 4: a run, cancelled after its first map and resumed
            click(browser, "#start")
            browser.wait("/: done/.test(document.querySelector('#screen').textContent)", seconds=120)
            picture(browser, "app-run", "#run")
            click(browser, "#cancel")
            browser.wait("document.querySelector('#state').textContent.startsWith('cancelled')", seconds=120)
            assert not (study / "results/report.html").exists()
            names_done = re.findall(r"(one|two|three): done", browser.text("#screen"))
            finished = [study / f"results/{name}/statistics.nc" for name in names_done]
            times_before = [path.stat().st_mtime_ns for path in finished]
            # a result whose row is gone is not offered
            shutil.copytree(study / "results" / names_done[0], study / "results/gone")
            click(browser, "#start")
            browser.wait("document.querySelector('#state').textContent === 'done'", seconds=300)
            assert browser.text("#screen").count(": done") == 3 - len(names_done)
            assert [path.stat().st_mtime_ns for path in finished] == times_before
            # 5: the report takes the place of the page, under the bar of the steps; no frame, one bar scrolls
            browser.wait("document.querySelector('#show')")
            click(browser, "#show")
            report_open(browser)
            assert "3 results:" in browser.text("body")
            assert browser.text("#results").count("To halve the ± of the contact area") == 3
            for width in (400, 1200):
                browser.resize(width)
                browser.evaluate("document.documentElement.scrollTo(0, 5000)")
                assert browser.evaluate(STEPS_IN_VIEW) == [0, True, True], width
                assert browser.evaluate("document.querySelectorAll('iframe, frame, object').length") == 0
            browser.evaluate("document.documentElement.scrollTo(0, 0)")
            # what lies beside: what would halve the ±, and exports, which open in a tab of their own
            click(browser, "#steps summary")
            browser.wait("document.querySelector('#results').checkVisibility()")
            picture(browser, "app-look")
            assert browser.text("#results").count("To halve the ± of the contact area") == 3
            report_page = browser.session
            for form, (holds, _) in EXPORTS.items():
                assert holds in browser.text("#exports"), form
                links = f"document.querySelectorAll('#results a[href$=\"form={form}\"]')"
                assert browser.evaluate(f"{links}.length") == 3
            browser.follow("#results li:first-child a[href$='form=methods']")
            browser.wait("document.body.innerText.startsWith('roughcontact methods results/')")
            assert "contact area" in browser.text("body")
            browser.session = report_page
            click(browser, "#results li:nth-child(3) a[href$='form=.gsf']")
            in_time(lambda: list((study / "exports").glob("*.gsf")))
            browser.follow("#results li:first-child a[href$='form=compare']")
            browser.wait("document.querySelectorAll('li a').length === 2")  # not with itself
            click(browser, "li a")
            browser.wait("document.body.innerText.includes('numbers')")
            assert browser.text("body").startswith("roughcontact compare results/")
            browser.session = report_page
            # and back
            click(browser, "#steps a[href$='#look']")
            browser.wait("location.hash === '#look' && document.body.ariaBusy === 'false'")
            browser.wait("document.querySelector('#results').children.length === 3")
            assert browser.text("#results").count("To halve the ± of the contact area") == 3
            # results of other settings say so, until the settings are theirs again
            assert browser.text("#results").count("Of other settings") == 0
            fill(browser, "contact.mean_pressure", "6 MPa")
            browser.wait("document.querySelectorAll('#results .other').length === 3")
            fill(browser, "contact.mean_pressure", "5 MPa")
            browser.wait("document.querySelectorAll('#results .other').length === 0")
            assert browser.problems == []
        # a colleague repeats it without the page: nothing is left to do
        run = subprocess.run([*PROGRAM, "run"], cwd=study, capture_output=True, text=True, check=False)
        assert "Nothing to be done" in run.stdout + run.stderr


# what does not follow from the models: two metals, and a force that a small map bears
EXAMPLES = {
    "contact.bodies.0.material": "copper",
    "contact.bodies.1.material": "steel",
    "contact.force": "1 mN",
    "form.radius": "1 mm",
}
# of each question, as the table of the main results names them
ANSWERS = {
    "seal": "leak",
    "resistance": "resistance",
    "heat": "temperature drop",
    "differ": "Differences",
    "ball": "contact radius",
    "friction": "friction",
    "profile": "contact area",
    "area": "largest pressure",
}


def example(name):
    """The first of the examples of a setting."""
    value = field_at(name.split(".")).examples[0]
    return str(value[0] if isinstance(value, list) else value)


class TestJobs:
    """Each question shows its fields with label, unit and sentence, which are those of the settings."""

    pytestmark = in_browser

    @pytest.fixture(scope="class")
    def browser(self, tmp_path_factory, chromium):
        folder = tmp_path_factory.mktemp("jobs")
        maps(folder / "study/measured", 16)
        (folder / "study/config").mkdir()
        (folder / "study/config/surfaces.tsv").write_text("surface\tpath\none\tmeasured/one.x3p\n")
        with served(folder / "study") as address:
            chromium.start_again()
            chromium.resize(1400)
            chromium.open(address)
            rows_read(chromium, 1)
            yield chromium
            assert chromium.problems == []

    @pytest.mark.parametrize("job", JOBS)
    def test_its_fields(self, browser, job):
        columns = JOBS[job].get("columns", [])
        ask(browser, job)
        shown = browser.evaluate(
            "[...document.querySelectorAll('#fields .field')].filter(field => field.checkVisibility())"
            ".map(field => field.dataset.field)"
        )
        assert shown == names_of(job)
        assert 4 <= len(shown) + len(columns) <= 8  # of which two are the bodies
        for name in names_of(job):
            field = field_at(name.split("."))
            part = f"document.querySelector(\"[data-field='{name}']\")"
            control = f"{part}.querySelector('input, select')"
            label, unit, sentence, key, described = browser.evaluate(
                f"[{control}.labels[0].innerText, {part}.querySelector('.unit').innerText, "
                f"{part}.querySelector('.meaning').innerText, {part}.querySelector('code').innerText, "
                f"document.getElementById({control}.getAttribute('aria-describedby')).innerText]"
            )
            *_, word = name.split(".")
            assert label.lower().endswith(word.replace("_", " "))
            assert len(label) > 3
            assert unit == (printed(setting_base(field)) if field else "")
            meaning = (
                field.description
                if field
                else Body.model_json_schema()["properties"]["material"]["description"]
            )
            # the unit of a bare number stands beside the field, once
            meaning = meaning.removesuffix(f"; a number alone is in {unit}")
            assert sentence == f"{' '.join(meaning.split())} {name}"
            assert len(meaning) > 5
            assert (key, described) == (name, sentence)
        for column in columns:
            control = f"document.getElementById('rows.0.{column}')"
            label, sentence = browser.evaluate(
                f"[{control}.labels[0].innerText, "
                f"document.getElementById({control}.getAttribute('aria-describedby')).innerText]"
            )
            assert label == column.replace("_", " ")
            assert sentence == f"{column}: {column_meaning(column)} {column}"
            assert len(column_meaning(column)) > 20
            options = browser.evaluate(f"[...{control}.options ?? []].map(option => option.value)")
            assert options == (["", *words] if (words := column_choices(column)) else [])
            assert browser.evaluate(f"{control}.getBoundingClientRect().height") > 25, column
        picture(browser, f"app-job-{job}")

    def test_more_has_every_setting_once(self, browser):
        ask(browser, "ball")
        browser.evaluate("document.querySelectorAll('details').forEach(part => { part.open = true; })")
        names = browser.evaluate(
            "[...document.querySelectorAll('[data-field]')].map(field => field.dataset.field)"
        )
        assert len(names) == len({*names})
        expected = {
            re.sub(r"\.layers\.0\..*", "", name) for name, _ in leaves(Settings, "") if ".layers." not in name
        }
        assert {name for name in names if not name.startswith("contact.bodies.1.")} - {
            "contact.bodies.0.material"
        } == expected - {"surfaces"}
        empty = "part => !part.querySelector('label')?.innerText || !part.querySelector('.meaning').innerText"
        assert browser.evaluate(f"[...document.querySelectorAll('[data-field]')].filter({empty}).length") == 0
        units = browser.evaluate(
            "Object.fromEntries([...document.querySelectorAll('[data-field]')].map(field => "
            "[field.dataset.field, field.querySelector('.unit').innerText]))"
        )
        for name, field in leaves(Settings, ""):
            if name in units:
                assert units[name] == printed(setting_base(field)), name
        # as people write it: no null, no unit that stands beside the field, ² and µ in others
        text = browser.evaluate(
            "[...document.querySelectorAll('#fields .meaning, #fields input')]"
            ".map(part => part.innerText + (part.placeholder ?? '') + '\\n').join('')"
        )
        words = r"\bnull\b|[mK]-\d|\b[mcµn]?m[23]\b|\bum\b|number alone|, (?:Pa|N|m|s)\b"
        assert re.findall(f".*(?:{words}).*", text) == []

    def test_mistakes_stand_beside_the_fields_of_the_question_and_lead_there(self, browser):
        ask(browser, "seal")
        assert browser.text("#mistakes").strip() == "name the materials of both bodies"
        texts = {"contact.bodies.0.material": "stel", "contact.bodies.1.material": "NBR", "level.order": "x"}
        for name, text in texts.items():
            fill(browser, name, text)
            saved(browser)
        browser.evaluate("document.querySelectorAll('details').forEach(part => { part.open = false; })")
        places = {"contact.bodies": "[data-field='contact.bodies.1.material'] + .mistake"}
        places |= {"level.order": "[data-field='level.order'] .mistake"}
        for wrong, place in (("stel", "contact.bodies"), ("", "level.order")):
            fill(browser, "contact.bodies.0.material", wrong or "steel")
            saved(browser)
            link = f"document.querySelector(\"#mistakes a[href='#of-{place}']\")"
            assert browser.evaluate(f"{link}.textContent") == browser.text(places[place])
            browser.evaluate(f"{link}.click()")  # opens what it lies in
            browser.wait(f'document.querySelector("{places[place]}").checkVisibility()')
        for name in texts:
            fill(browser, name, "")
        saved(browser)

    def test_a_comparison_asks_for_two_groups(self, browser):
        ask(browser, "differ")
        assert "tick the files of A, set group to A, then those of B" in browser.text("#run .doubt")
        ask(browser, "seal")
        assert not browser.evaluate("document.querySelector('#run .doubt')")

    def test_loads_of_another_question_are_set_aside_and_come_back(self, browser):
        ask(browser, "ball")
        fill(browser, "contact.force", "5 N")
        fill(browser, "form.radius", "5 mm")
        saved(browser)
        config = lambda: yaml.safe_load(browser.text("#preview pre"))  # noqa: E731
        assert config()["contact"] == {"boundary": "free", "force": ["5 N"]}
        ask(browser, "seal")
        assert "contact" not in (config() or {})
        fill(browser, "contact.mean_pressure", "2,5 MPa")
        browser.wait("document.querySelector(\"[data-of='contact.mean_pressure']\").textContent")
        assert "write a decimal point, not a comma" in browser.text("[data-of='contact.mean_pressure']")
        assert config()["contact"]["mean_pressure"] == ["2,5 MPa"]
        fill(browser, "contact.mean_pressure", "2.5 MPa")
        click(browser, "[name='page.job'][value=ball]")
        browser.wait("document.getElementById('contact.force.0')?.value === '5 N'")
        assert browser.evaluate("document.getElementById('form.radius.0').value") == "5 mm"
        assert config()["contact"] == {"boundary": "free", "force": ["5 N"]}


class TestJobsToTheirAnswers:
    """Each question on a page of its own, from an empty folder."""

    pytestmark = in_browser

    @pytest.mark.slow
    @pytest.mark.parametrize("job", JOBS)
    def test_from_an_empty_folder_to_its_answer(self, job, tmp_path, chromium):
        """In twelve clicks and fields at most, by files of three formats that say all of themselves."""
        shape = (1, 512) if job == "profile" else (64, 64)
        surfaces = [self_affine_surface((64, shape[1]), 1e-6, **ROUGHNESS, seed=seed) for seed in range(6)]
        heights = [surface.values[: shape[0]] for surface in surfaces]
        third = profile_bytes if job == "profile" else lambda values, pitch: matrix_bytes(values, [pitch] * 2)
        makers = (("x3p", x3p_bytes), ("sdf", sdf_bytes), ("csv" if job == "profile" else "txt", third))
        files = []
        for number, values in enumerate(heights if job == "differ" else heights[:3]):
            ending, content = makers[number % 3]
            files.append(tmp_path / f"map-{number}.{ending}")
            files[-1].write_bytes(content(values, 1e-6))
        steps = []

        def step(action, *arguments):
            steps.append(arguments)
            action(chromium, *arguments)
            saved(chromium)

        with served(tmp_path / "study") as address:
            chromium.start_again()
            show(chromium, address)
            step(click, f"[name='page.job'][value={job}]")
            # those that are new are ticked: what the question asks of each file is set for all of them
            groups = {"differ": {"A": files[:3], "B": files[3:]}, "profile": {"none": files}}
            for cell, chosen in groups.get(job, {"": files}).items():
                step(Browser.choose_files, "#choose", *chosen)
                if cell:
                    step(fill, "cell", cell)
                    step(click, "#selected [value=set]")
            rows_read(chromium, len(files))
            for name in names_of(job):
                step(fill, name, EXAMPLES.get(name) or example(name))
            step(click, "#start")
            chromium.wait("document.querySelector('#state').textContent === 'done'", seconds=300)
            chromium.wait("document.querySelector('#show')")
            steps.append("#show")
            click(chromium, "#show")
            report_open(chromium)
            report = " ".join(chromium.text("body").split())
            main_results = report.partition("How to read this page")[2][:4000]
            assert ANSWERS[job] in main_results, main_results
            assert len(steps) <= 12
            assert chromium.problems == []


class TestMap:
    pytestmark = in_browser

    def show_only_map(self, browser, address):
        browser.resize(1400)
        show(browser, address)
        fill_path = "document.querySelector('#path')"
        browser.evaluate(f"{fill_path}.value = 'measured'; {fill_path}.form.querySelector('button').click()")
        rows_read(browser, 1)
        click(browser, ".thumbnail")
        browser.wait("document.querySelector('#map image')")

    def test_cursor_zoom_cut_crop_and_mask(self, tmp_path, browser):
        study = tmp_path / "study"
        (study / "measured").mkdir(parents=True)
        x = np.arange(200) * 1e-6
        ramp = np.broadcast_to(x * 0.1, (100, 200)).copy()  # 0 to 19.9 µm along x
        ramp[80:, :20] = np.nan  # the upper left corner
        (study / "measured/ramp.sdf").write_bytes(sdf_bytes(ramp, 1e-6))
        with served(study) as address:
            self.show_only_map(browser, address)
            # at once in view, however much is above it, and closed again
            browser.evaluate("document.styleSheets[0].insertRule('#columns { margin-bottom: 60rem; }')")
            for width in (400, 1400):
                browser.resize(width)
                browser.evaluate("document.querySelector('.thumbnail').scrollIntoView()")
                click(browser, ".thumbnail")
                saved(browser)
                top, height = browser.evaluate(
                    "[document.querySelector('#tools').getBoundingClientRect().top, innerHeight]"
                )
                assert 0 < top < height - 100, width
                assert browser.evaluate("document.activeElement.className") == "viewer"
            browser.evaluate("document.styleSheets[0].deleteRule(0)")
            click(browser, ".viewer h3 button")
            browser.wait("!document.querySelector('.viewer') && !document.querySelector('#map')")
            click(browser, ".thumbnail")
            browser.wait("document.querySelector('#map image')")
            size = browser.evaluate(
                "(async () => { const image = new Image(); "
                "image.src = document.querySelector('#map image').getAttribute('href'); "
                "await image.decode(); return [image.naturalWidth, image.naturalHeight]; })()"
            )
            assert size == [200, 100]

            def cursor(x, y, begin):
                drag(browser, (x, y), (x, y))
                browser.wait(f"document.querySelector('#cursor').textContent.startsWith('{begin}')")
                return browser.text("#cursor").replace("−", "-")

            low, high = (
                float(re.search(r": (-?[\d.]+) µm", cursor(*where))[1])
                for where in ((0.25, 0.75, "x 50"), (0.75, 0.75, "x 150"))
            )
            assert high - low == pytest.approx(10, rel=0.02)
            assert cursor(0.02, 0.05, "x 4").endswith("not measured")
            # a cut along x over half of the map: 10 µm of height
            click(browser, "[name=tool][value=line]")
            drag(browser, (0.25, 0.5), (0.75, 0.5))
            browser.wait("document.querySelector('#cursor').textContent.includes('along the line')")
            length, heights = re.fullmatch(
                r"([\d.]+) µm along the line, heights over ([\d.]+) µm", browser.text("#cursor")
            ).groups()
            assert (float(length), float(heights)) == pytest.approx((100, 10), rel=0.02)
            # a chart, with units
            chart = urllib.parse.unquote(browser.evaluate("document.querySelector('#cut').src"))
            assert re.search(">along the line \\(µm\\)<.*>height \\(µm\\)<", chart)
            assert browser.evaluate("document.querySelector('#cut').naturalWidth") > 300
            click(browser, "[name=tool][value=zoom]")
            drag(browser, (0.5, 0.5), (0.75, 0.75))
            box = "document.querySelector('#map').getAttribute('viewBox').split(' ')"
            browser.wait(f"{box}[2] < 52")
            assert [*map(float, browser.evaluate(box))] == pytest.approx([100, -50, 50, 25], abs=1)
            assert cursor(0.5, 0.5, "x 125").startswith("x 125 µm, y 37")
            browser.wait(f"{box}[2] > 199")  # a click shows all
            for tool, corners in (("crop", ((0.1, 0.2), (0.9, 1.0))), ("mask", ((0.4, 0.4), (0.5, 0.6)))):
                click(browser, f"[name=tool][value={tool}]")
                drag(browser, *corners)
                saved(browser)
            browser.wait("document.querySelector('#cursor').textContent.startsWith('x 100 µm')")  # and stays
            click(browser, "[name=tool][value=line]")
            drag(browser, (0.1, 0.5), (0.9, 0.7))
            browser.wait("document.querySelector('#cursor').textContent.includes('along the line')")
            # stays until the next one begins
            browser.send("Input.dispatchMouseEvent", type="mouseMoved", x=200, y=400)
            saved(browser)
            assert "along the line" in browser.text("#cursor")
            assert browser.evaluate("Boolean(document.querySelector('#outline[points]') && element('cut'))")
            picture(browser, "app-map", ".viewer")
            click(browser, "[name=tool][value=mask]")
            drag(browser, (0.6, 0.4), (0.7, 0.6))
            saved(browser)
            with contextlib.chdir(study):
                row = read_surfaces("config/surfaces.tsv")["ramp"].read_arguments
            crop, *_ = parse_rectangles("crop", row["crop"])
            assert crop == pytest.approx((20e-6, 0, 180e-6, 80e-6), abs=1e-6)
            masked = parse_rectangles("mask", row["mask"])
            assert masked[0] == pytest.approx((80e-6, 40e-6, 100e-6, 60e-6), abs=1e-6)
            assert masked[1] == pytest.approx((120e-6, 40e-6, 140e-6, 60e-6), abs=1e-6)
            # the columns have label and sentence, and what is typed there is drawn
            for column in ("crop", "mask"):
                field = f"document.getElementById('rows.0.{column}')"
                assert browser.evaluate(f"{field}.labels[0].innerText") == column
                sentence = browser.evaluate(
                    f"document.getElementById({field}.getAttribute('aria-describedby')).innerText"
                )
                assert sentence == f"{column}: {column_meaning(column)} {column}"
            fill_cell(browser, 0, "mask", "0 0 200 100 um")
            saved(browser)
            masked = "[...document.querySelector('rect.mask').attributes].map(part => part.value).join(' ')"
            browser.wait("document.querySelectorAll('rect.mask').length === 1")
            assert browser.evaluate(masked) == "mask 0.0 -100.0 200.0 100.0"

    def test_a_map_has_a_scale_of_its_colours_and_a_profile_is_a_line(self, tmp_path, browser):
        study, x = tmp_path / "study", np.arange(200) * 1e-6
        (study / "measured").mkdir(parents=True)
        ramp = np.broadcast_to(x * 0.1, (100, 200)).copy()
        ramp[80:, :20] = np.nan
        (study / "measured/ramp.sdf").write_bytes(sdf_bytes(ramp, 1e-6))
        (study / "measured/saw.csv").write_bytes(profile_bytes(x[None] % 50e-6, 1e-6))
        with served(study) as address:
            browser.resize(1400)
            show(browser, address)
            browser.choose_files("#choose", *(study / "measured").iterdir())
            rows_read(browser, 2)
            click(browser, "[aria-label='look at ramp']")
            browser.wait("document.querySelector('#scale')")
            # 0 µm to 19.9 µm, of the mean 10.13 µm
            scale = " ".join(browser.text("#scale").split())
            assert scale == "−10.1 µm 9.77 µm from the mean not measured"
            assert browser.evaluate("document.querySelectorAll('#scale rect').length") == 19
            click(browser, "[aria-label='look at saw']")
            browser.wait("document.querySelector('#profile')?.naturalWidth > 300")
            assert not browser.evaluate("document.querySelector('#scale') || document.querySelector('#map')")
            source = browser.evaluate("document.querySelector('#profile').getAttribute('src')")
            status, chart = get(address + source)
            assert (status, ">x (µm)<" in chart, ">height (µm)<" in chart) == (200, True, True)
            assert browser.problems == []

    def test_an_error_under_the_cursor_is_no_markup(self, tmp_path, browser):
        study, file = tmp_path / "study", Path("measured/<b>ramp<b>.sdf")
        (study / file).parent.mkdir(parents=True)
        (study / file).write_bytes(sdf_bytes(np.outer(np.ones(32), np.arange(32) * 1e-7), 1e-6))
        with served(study) as address:
            self.show_only_map(browser, address)
            (study / file).unlink()
            drag(browser, (0.5, 0.5), (0.5, 0.5))
            browser.wait(f"document.querySelector('#cursor').textContent.includes('{file}')")
            assert browser.evaluate("document.querySelector('#cursor b') === null")
            assert browser.problems == []


class TestStart:
    """The one command, the file to double-click, and what is said where packages are missing."""

    def test_a_double_click_opens_the_study(self, tmp_path):
        # a checkout of its own, in which all is installed
        checkout = tmp_path / "checkout"
        for name in ("bin", "checkout/.venv/bin"):
            (tmp_path / name).mkdir(parents=True)
        for name in ("pyproject.toml", "setup.py", "run.py", "app.command"):
            shutil.copy2(ROOT / name, checkout)
        (checkout / "workflow").symlink_to(ROOT / "workflow")
        (checkout / ".venv/bin/roughcontact").symlink_to(Path(sys.executable).with_name("roughcontact"))
        state = f"import runpy; print(runpy.run_path({str(checkout / 'run.py')!r})['state_of_sources']())"
        stamp = subprocess.run(
            [sys.executable, "-c", state], capture_output=True, text=True, check=True
        ).stdout
        (checkout / ".venv/installed.workflow").write_text(stamp.strip())
        (tmp_path / "bin/python3").symlink_to(sys.executable)
        environment = os.environ | {"PATH": f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}"}
        (tmp_path / "opened").write_text("")
        (tmp_path / "browser.py").write_text(
            f"import pathlib, sys; pathlib.Path({str(tmp_path / 'opened')!r}).write_text(sys.argv[1])"
        )
        environment["BROWSER"] = f"{sys.executable} {tmp_path / 'browser.py'} %s"
        # of its own group, as the window of a terminal is: Ctrl-C reaches all of it
        pipes = {"stdout": subprocess.PIPE, "text": True, "start_new_session": True}
        command = [checkout / "app.command", tmp_path / "study"]
        with subprocess.Popen(command, env=environment, cwd=tmp_path, **pipes) as process:
            try:
                address = re.search(r"http://\S+", process.stdout.readline())[0]
                assert get(address)[0] == 200
                file = in_time((tmp_path / "opened").read_text)
                assert file == (tmp_path / "study/.snakemake/page.html").as_uri()
            finally:
                os.killpg(process.pid, signal.SIGINT)
        assert process.returncode != 0
        assert working_in(tmp_path / "study") == []

    def test_the_file_for_windows_starts_the_same(self):
        lines = (ROOT / "app.bat").read_bytes().split(b"\r\n")
        assert b'py "%~dp0run.py" app "%folder%"' in lines
        assert not any(b"\n" in line for line in lines)

    def test_ctrl_c_amid_the_imports_ends_it(self, tmp_path):
        """Where an exception would be ignored, as while an object is thrown away."""
        (tmp_path / "sitecustomize.py").write_text(
            "import os, signal, sys\n"
            "class Thrown:\n"
            "    def __del__(self):\n"
            "        os.kill(os.getpid(), signal.SIGINT)\n"
            "class Finder:\n"
            "    def find_spec(self, name, *_):\n"
            "        if name == 'roughcontact.interface.app.server':\n"
            "            Thrown()\n"
            "sys.meta_path.insert(0, Finder())\n"
        )
        command = [*PROGRAM, "app", str(tmp_path / "study"), "--no-browser"]
        environment = os.environ | {"PYTHONPATH": str(tmp_path)}
        pipes = {"capture_output": True, "text": True, "timeout": 60}
        ended = subprocess.run(command, env=environment, check=False, **pipes)
        assert (ended.returncode, ended.stdout) == (130, "")
        assert ended.stderr == "roughcontact: interrupted\n"

    def test_packages_that_are_missing_are_named_as_pip_takes_them(self, tmp_path):
        (tmp_path / "sitecustomize.py").write_text(
            "import importlib.util as u; f = u.find_spec\n"
            "u.find_spec = lambda name, *a: None if name == 'starlette' else f(name, *a)\n"
        )
        command = [*PROGRAM, "app", str(tmp_path / "study")]
        environment = os.environ | {"PYTHONPATH": str(tmp_path)}
        ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert ended.returncode == 2
        assert ended.stderr.startswith("roughcontact: starlette is not installed: pip install ")
        words = shlex.split(ended.stderr.partition("pip install ")[2])
        extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
        assert {Requirement(word) for word in words} == {
            *map(Requirement, extras["workflow"] + extras["app"])
        }


def get(address, *, method="GET", body=None, form=None, **headers):
    """Return status and text of the answer to a request, with headers as they are given."""
    parts = urllib.parse.urlsplit(address)
    connection = http.client.HTTPConnection("127.0.0.1", parts.port, timeout=30)
    connection.putrequest(
        method, parts.path + (f"?{parts.query}" if parts.query else ""), skip_host="host" in headers
    )
    for name, value in headers.items():
        connection.putheader(name.replace("_", "-"), value)
    data = body or json.dumps(form or {}).encode()
    connection.putheader("Content-Length", str(len(data)))
    connection.endheaders(data)
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, text


class TestWhoIsRefused:
    @pytest.fixture(scope="class")
    def study(self, tmp_path_factory):
        """A folder, and the address of its page."""
        folder = tmp_path_factory.mktemp("refused") / "study"
        with served(folder) as address:
            yield folder, address

    def test_requests_without_token_of_other_hosts_or_origins(self, study):
        folder, address = study
        parts = urllib.parse.urlsplit(address)
        base, port = f"http://127.0.0.1:{parts.port}", parts.port
        wrong = f"{base}/{'x' * len(parts.path.strip('/'))}/"
        for address_without_token in (
            f"{base}/",
            wrong,
            f"{base}//",
            f"{base}/page/page.js",
            f"{base}/results/a",
        ):
            assert get(address_without_token) == (403, "refused")
        for headers in (
            {"host": f"evil.example:{port}"},  # a name that was made to point here
            {"host": "127.0.0.1"},
            {"Origin": "http://evil.example"},
            {"Origin": f"http://127.0.0.1:{port + 1}"},
            {"Origin": "null"},
            {"Sec_Fetch_Site": "cross-site"},
            {"Sec_Fetch_Site": "same-site"},
        ):
            for name, method in (("", "GET"), ("page/page.js", "GET"), ("", "POST")):
                assert get(address + name, method=method, **headers) == (403, "refused"), headers
        # the file that opens the page is of no site: it is followed to the page, and nowhere else
        followed = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"}
        for name, method in (("page/page.js", "GET"), ("drop", "POST"), ("map/a", "GET")):
            assert get(address + name, method=method, **followed) == (403, "refused")
        assert get(wrong, **followed) == (403, "refused")
        upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13"}
        status, _ = get(wrong, Sec_WebSocket_Key="dGhlIHNhbXBsZSBub25jZQ==", **upgrade)
        assert status == 403
        status, _ = get(address, Sec_WebSocket_Key="dGhlIHNhbXBsZSBub25jZQ==", **upgrade)
        assert status == 200  # no socket opens: the answer is that of a page
        assert not (folder / "measured").exists()

    def test_dropped_files_stay_in_their_folder_and_write_over_nothing(self, study):
        folder, address = study
        to = f"{address}drop?name="
        assert get(to + "../../one.txt", method="POST", body=b"1") == (200, "measured/one.txt")
        assert get(to + "C:\\maps\\two.txt", method="POST", body=b"2") == (200, "measured/two.txt")
        for file_name in ("..", ".", "/", "", "%00", "a%00.txt"):
            status, message = get(to + file_name, method="POST", body=b"3")
            assert (status, "names no file" in message) == (400, True)
        # a copy is known again, a namesake has a number
        assert get(to + "one.txt", method="POST", body=b"1") == (200, "measured/one.txt")
        assert get(to + "one.txt", method="POST", body=b"3") == (200, "measured/one-2.txt")
        assert get(to + "one.txt", method="POST", body=b"3") == (200, "measured/one-2.txt")
        names = ["one-2.txt", "one.txt", "two.txt"]
        assert sorted(path.name for path in (folder / "measured").iterdir()) == names
        assert (folder / "measured/one.txt").read_text() == "1"
        # maps are those of rows of the table
        for words in ("0", "0?line=1,2", "0?whole", "measured"):
            assert get(f"{address}map/{words}")[0] == 400
        assert get(f"{address}map/..%2f..%2fone.txt")[0] in (403, 404)
        # nor do the results lead out of their folder
        (folder / "results").mkdir()
        (folder / "results/a.txt").write_text("a result")
        assert get(f"{address}results/a.txt") == (200, "a result")
        for path in ("results/../measured/one.txt", "results/%2e%2e/measured/one.txt"):
            assert get(f"{address}{path}")[0] in (403, 404)

    def test_folders_and_ports_that_cannot_be_used(self, tmp_path):
        (tmp_path / "a file").write_text("")
        for words in (["a file"], ["study", "--port", "99999"]):
            command = [*PROGRAM, "app", *words, "--no-browser"]
            ended = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
            assert ended.returncode == 2
            assert ended.stderr.startswith(f"roughcontact: {words[0]}: its page cannot be served (")
            assert "and a free --port" in ended.stderr

    def test_a_second_program_on_the_same_folder(self, study):
        command = [*PROGRAM, "app", str(study[0]), "--no-browser"]
        second_run = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
        assert second_run.returncode == 2
        assert "its page is open already" in second_run.stderr


STUDY = {
    "contact.contact_modulus": "1 GPa",
    "contact.mean_pressure": "5 MPa",
    "rows.0.surface": "one",
    "rows.0.path": "measured/one.x3p",
}


def check(texts, rows, *, job=""):
    """What the files of a form hold when they are saved."""
    study.save(texts, rows, job=job, keep=False)
    return study.check()


def contents(home):
    """The files outside the study `home/study`, and its measured ones."""
    files = [path for path in home.rglob("*") if path.is_file() and not path.is_symlink()]
    files = [path for path in files if home / "study" not in path.parents or path.suffix in (".sdf", ".x3p")]
    return {path: path.read_bytes() for path in files}


class TestNothingOutsideTheStudy:
    @pytest.mark.cases
    def test_whatever_settings_and_links_of_others_say(
        self, location, target, refused, tmp_path, monkeypatch
    ):
        """All buttons that write or start a command; neither the home folder nor a measured file changes."""
        home, study = tmp_path / "home", tmp_path / "home/study"
        maps(study / "measured", 8)
        (home / "elsewhere/one").mkdir(parents=True)
        (home / ".bashrc").write_text("# mine")
        (study / "aside").symlink_to("../elsewhere")
        write_summary(
            SUMMARY, (home / "elsewhere" if location == "results" else study / "results") / "one/panel"
        )
        fields = dict(STUDY)
        if location == "surfaces":
            fields["surfaces"] = target.format(home=home)
        else:
            (study / location).parent.mkdir(parents=True, exist_ok=True)
            (study / location).symlink_to(target)
        contents_before = contents(home)
        monkeypatch.chdir(study)
        started = []
        process = subprocess.CompletedProcess([], 0, "", "")
        monkeypatch.setattr(commands, "Popen", lambda command, **_: started.append(command))
        monkeypatch.setattr(commands, "run", lambda command, **_: started.append(command) or process)
        monkeypatch.setattr(measurements, "inspect", lambda _: measurements.UNREAD)  # takes long
        monkeypatch.setattr(server.socket, "create_server", lambda _: Path("no socket").read_bytes())

        actions = {name: partial(Page().after, fields | {"page.do": name}) for name in ("write", "start")}
        actions["export"] = partial(commands.export, "one", ".csv", "one", plan=None)

        async def content():
            yield b"echo evil"

        actions["drop"] = lambda: asyncio.run(save_upload("new.txt", content()))
        actions["serve"] = partial(server.serve, study)
        for name, action in actions.items():
            ended_by = SettingsError if name in refused.split() else OSError if name == "serve" else None
            with pytest.raises(ended_by) if ended_by else contextlib.nullcontext():
                action()
        assert contents(home) == contents_before
        assert len(started) == 2 - ("start" in refused) - ("export" in refused)


def shapes():
    """Settings with values of every shape in the place of others: of each setting three shapes, in turn."""
    values = [3, True, None, "text", [3, [4]], [[4]], {"99": {"a": 1}}, {1: 2}, [{"0": "a"}], {"a": {"b": 1}}]
    bodies = [[body, "steel"] for body in (*values, *({"layers": value} for value in values))]
    yield from (
        {"contact": {"bodies": value}} for value in (*values, *bodies, [{"youngs_modulus": {"a": 1}}])
    )
    yield from ({"cases": {"a": value}} for value in values)
    names = [*Settings.model_fields, "rows", "page", 1, "a.b", ""]
    yield from ({name: values[(n + step) % 10]} for n, name in enumerate(names) for step in (0, 4, 6))
    for shift, (name, field) in enumerate(Settings.model_fields.items()):
        if section := section_model(field):
            yield {name: {key: values[(n + shift) % 10] for n, key in enumerate(section.model_fields)}}
    yield {"contact": [{"contact_modulus": "1 GPa"}]}
    yield {"contact": {"9" * 11: 1}}
    yield {"cases": {"1": {"contact": {"tolerance": "x"}}, "2": None}}
    yield {"surfaces": ["a.x3p", "b.x3p"]}
    yield {"surfaces": "/dev/zero"}


@pytest.fixture
def small_study(tmp_path, monkeypatch):
    """A working folder with three maps, of which no table says anything yet."""
    monkeypatch.chdir(tmp_path)
    maps(tmp_path / "measured", 8)
    (tmp_path / "config").mkdir()


class TestFilesOfOthers:
    """Whatever the files of the study hold, each answer is a page or a sentence."""

    pytestmark = pytest.mark.usefixtures("small_study")

    @pytest.mark.parametrize("part", range(4))
    def test_settings_of_any_shape(self, part, tmp_path):
        for config in [*shapes()][part::4]:
            (tmp_path / "config/config.yaml").write_text(yaml.safe_dump(config))
            page = Page()
            page_text = page.since()
            # what names a table elsewhere is not saved, but looked at
            answer = page.after({} if config.get("surfaces") == "/dev/zero" else form_fields(page_text))
            assert "please report" not in page_text + answer, config
            lines_shown = [
                line.strip() for line in html.unescape(page_text + answer).replace(">", ">\n").splitlines()
            ]
            ((name, value),) = config.items()
            if name == "surfaces" and not isinstance(value, list | dict):
                continue  # of the form, whose texts are names
            name = str(name).partition(".")[0]
            with pytest.raises(SettingsError) as of_run:
                resolve(config)
            if any(line.strip().startswith(name) for line in str(of_run.value).splitlines()):
                assert any(re.match(rf"{re.escape(name)}\b.*[:=]", line) for line in lines_shown), config

    @pytest.mark.parametrize("header", ["surface\tpath\ta.b", "surface\tpath\tpath", "surface\tpath\t0\t"])
    def test_tables_of_any_header(self, header, tmp_path):
        (tmp_path / "config/surfaces.tsv").write_text(f"{header}\none\tone.x3p\tx\n")
        page = Page()
        page_text = page.since()
        answer = page_text + page.after(form_fields(page_text))
        assert re.search("unknown, valid are|occurs twice", answer)

    def test_a_file_is_opened_once(self, monkeypatch):
        paths, recognised = [], registry.recognised
        monkeypatch.setattr(registry, "recognised", lambda path: paths.append(path) or recognised(path))
        assert measurements.inspect({"path": "measured/one.x3p"})["picture"].startswith("data:image/png;")
        assert len(paths) == 1

    def test_readers_and_figures_that_raise_anything(self, monkeypatch):
        for module, name in ((registry, "recognised"), (inspection, "convert"), (measurements, "coloured")):
            for error in (IndexError("list index out of range"), RecursionError(), MemoryError(), OSError()):

                def fail(*_, error=error, **__):
                    raise error

                with monkeypatch.context() as patched:
                    patched.setattr(module, name, fail)
                    for path in ("measured/one.x3p", "measured/two.sdf"):
                        text = " ".join(measurements.inspect({"path": path})["line"].split())
                        assert re.search(rf"{path}\b.*(cannot be read|needs more memory)", text), (
                            name,
                            error,
                        )

    def test_summaries_of_any_content(self, tmp_path):
        path = tmp_path / "results/one/panel.json"
        write_summary(SUMMARY, path)
        assert "<b>one</b>: " in Page().after({})
        for content in ("", "[" * 10**5, json.dumps(SUMMARY | {"verdict": []}), '{"verdict": 1}', "null"):
            path.write_text(content)
            page = Page()
            for answer in (page.since(), page.after({})):  # all else works
                assert "results/one/panel.json: no summary of a panel; delete " in answer
                assert "4 Run" in answer

    def test_what_never_ends_is_not_read(self, tmp_path):
        for name in ("pipe", "zeros", "sparse", "numbers"):
            (tmp_path / "results" / name).mkdir(parents=True)
        os.mkfifo(tmp_path / "results/pipe/panel.json")
        (tmp_path / "results/zeros/panel.json").symlink_to("/dev/zero")
        with (tmp_path / "results/sparse/panel.json").open("wb") as file:
            file.truncate(2**36)
        write_summary(SUMMARY, tmp_path / "results/numbers/panel.json")
        os.mkfifo(tmp_path / "results/numbers/statistics.nc")
        answer = Page().after({})
        for name in ("pipe", "zeros", "sparse"):
            assert f"results/{name}/panel.json: no summary of a panel" in answer
        assert "Of other settings or another measured file" in answer

    def test_a_folder_of_results_is_one_word_of_a_command(self, tmp_path, monkeypatch):
        name, sent = "x -o y/z", []
        write_summary(SUMMARY, tmp_path / "results" / name / "panel.json")
        process = subprocess.CompletedProcess([], 0, "", "")
        monkeypatch.setattr(commands, "run", lambda command, **_: sent.append(command) or process)
        for form in commands.EXPORTS:
            commands.export(name, form, name, plan=None)
            assert len(sent[-1]) == len([*commands._PROGRAM, *commands.EXPORTS[form][1].split()])

    def test_results_of_another_measured_file_or_other_settings(self, tmp_path):
        page, note = Page(), "Of other settings or another measured file: run again."
        study = STUDY | dict.fromkeys(("rows.0.crop", "wear.coefficient", "wear.distance"), "")
        page.after(study)
        settings = json.dumps(page.checked["plan"].settings("statistics", "one"), sort_keys=True)
        measured = tmp_path / "measured/one.x3p"
        origin = {"settings": settings, "source_sha256": sha256(measured)}
        write_dataset(xr.Dataset(attrs=origin), tmp_path / "results/one/statistics.nc")
        write_summary(SUMMARY, tmp_path / "results/one/panel.json")
        (tmp_path / "results/report.html").write_text("<html><head></head><body>old</body></html>")
        assert note not in page.after(study)
        further = {"rows.1.surface": "two", "rows.1.path": "measured/two.sdf"}
        assert "Without a result: two</p>" in page.after(study | further)
        page.after({"rows.0.ticked": "", "rows.1.ticked": "on", "page.do": "remove"})
        assert "Without a result" not in page.after({})
        assert "run again" not in page.with_bar(Path("results/report.html"), "/")
        assert note in page.after(study | {"contact.mean_pressure": "6 MPa"})
        assert note in page.after(study | {"rows.0.crop": "0 0 4 4 um"})
        worn = study | {"wear.coefficient": "1e-7 mm³/(N m)", "wear.distance": "1 m"}
        assert note in page.after(worn)
        origin["settings"] = json.dumps(page.checked["plan"].settings("worn", "one"), sort_keys=True)
        write_dataset(xr.Dataset(attrs=origin), tmp_path / "results/one/worn.nc")
        write_summary(SUMMARY, tmp_path / "results/one/panel.json")  # after what it is made of
        assert note not in page.after(worn)
        assert note in page.after(worn | {"wear.distance": "2 m"})
        assert note in page.after(study)  # its answer is of wear
        (tmp_path / "results/one/worn.nc").unlink()
        write_summary(SUMMARY, tmp_path / "results/one/panel.json")
        assert note not in page.after(study)
        measured.write_bytes(x3p_bytes(np.zeros((8, 8)), 1e-6))
        assert note in page.after(study)
        # on the page of the report as well, before it
        bar, _, _ = page.with_bar(Path("results/report.html"), "/").partition("old")
        assert "1 of other settings or another measured file: run again" in bar

    def test_an_unforeseen_error_is_a_sentence_of_the_page(self, tmp_path):
        with served(tmp_path / "study") as address:
            press = opened(address)
            for action, form in (("set", {}), ("add", {}), ("", {"rows.x.path": ""})):
                status, answer = press(form, action)
                assert (status, "unexpected, please report it)" in answer) == (400, True)


class TestReportsOfOthers:
    pytestmark = in_browser

    def test_a_report_of_others_learns_no_token(self, tmp_path, browser):
        """Neither its scripts, nor its style, nor a link that it leaves open before the bar."""
        (tmp_path / "results").mkdir()
        with socket.create_server(("127.0.0.1", 0)) as listener, served(tmp_path) as address:
            listener.settimeout(2)
            elsewhere = f"http://127.0.0.1:{listener.getsockname()[1]}/"
            for begin in ("<html><head></head><body>", f"<a href='{elsewhere}?<body>' id='open'>"):
                (tmp_path / "results/report.html").write_text(
                    f"{begin}<style>a[href^='/'] {{ background: url({elsewhere}) }}</style><script>"
                    f"new Image().src = fetch('{elsewhere}?' + location.href), location = '{elsewhere}' + "
                    "location.pathname</script>"
                )
                browser.open(f"{address}results/report.html")
                browser.wait("document.querySelector('#steps a')")
                link = browser.evaluate("document.querySelector('#open')?.href ?? ''")
                assert urllib.parse.urlsplit(address).path not in urllib.parse.unquote(link)
                with pytest.raises(TimeoutError):
                    listener.accept()


def in_time(condition, seconds=60):
    """Return the first value that is true of a function, asked every tenth of a second."""
    deadline = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < deadline
        time.sleep(0.1)
    return value


class TestOtherUsers:
    """Who works on the same computer, or ends the page there."""

    def test_the_token_is_on_no_command_line(self, tmp_path):
        (tmp_path / "browser.py").write_text(
            "import json, pathlib, sys, urllib.parse, urllib.request\n"
            "path = pathlib.Path(urllib.request.url2pathname(urllib.parse.urlsplit(sys.argv[1]).path))\n"
            "kept = [sys.argv, oct(path.stat().st_mode), path.read_text()]\n"
            f"pathlib.Path({str(tmp_path / 'kept')!r}).write_text(json.dumps(kept))\n"
        )
        (tmp_path / "study/.snakemake").mkdir(parents=True)
        (tmp_path / "study/.snakemake/page.html").symlink_to(tmp_path / "of-somebody")
        environment = os.environ | {"BROWSER": f"{sys.executable} {tmp_path / 'browser.py'} %s"}
        with served(tmp_path / "study", options=(), env=environment) as address:
            token = urllib.parse.urlsplit(address).path.strip("/")
            record = in_time(lambda: (tmp_path / "kept").exists() and (tmp_path / "kept").read_text())
            words, mode, content = json.loads(record)
            assert token not in " ".join(words)
            assert mode == "0o100600"
            assert f'content="0; url={address}"' in content
            assert get(address)[0] == 200  # it has started, and is not interrupted while it does
        assert not list((tmp_path / "study/.snakemake").glob("page.html"))
        assert not (tmp_path / "of-somebody").exists()

    def test_connections_that_never_ask_keep_nobody_out(self, tmp_path):
        def few_files():
            resource.setrlimit(resource.RLIMIT_NOFILE, (200, 200))

        with (
            served(tmp_path / "study", preexec_fn=few_files) as address,
            contextlib.ExitStack() as connections,
        ):
            parts = urllib.parse.urlsplit(address)
            for number in range(300):
                silent = socket.create_connection(("127.0.0.1", parts.port), timeout=30)
                connections.enter_context(silent)
                with contextlib.suppress(OSError):  # it has been closed
                    silent.sendall((b"", b"GET", b"GET / HTTP/1.1\r\nHost: a\r\n")[number % 3])
            press = opened(address)
            assert press({})[0] == 200
            # the body of a whole request is waited for, however many others come
            slow = connections.enter_context(socket.create_connection(("127.0.0.1", parts.port), timeout=30))
            head = f"POST {parts.path}drop?name=a.txt HTTP/1.1\r\nContent-Length: 70\r\n"
            slow.sendall(f"{head}Host: 127.0.0.1:{parts.port}\r\n\r\n".encode())
            for _ in range(70):
                connections.enter_context(socket.create_connection(("127.0.0.1", parts.port), timeout=30))
                slow.sendall(b"1")
            assert slow.recv(12) == b"HTTP/1.1 200"
            assert (tmp_path / "study/measured/a.txt").read_text() == "1" * 70
            assert get(address)[0] == 200

    def test_a_request_is_read_before_room_is_made_for_those_after_it(self):
        """However many connections are accepted in the same rounds of the loop: its head is there already."""

        async def answer():
            listener = socket.create_server(("127.0.0.1", 0))
            address = listener.getsockname()
            options = {"http": server.Connection, "ws": "none", "log_config": None, "backlog": 30}
            served = uvicorn.Server(uvicorn.Config(PlainTextResponse("yes"), lifespan="off", **options))
            serving = asyncio.create_task(served.serve(sockets=[listener]))
            while not served.started:
                await asyncio.sleep(0.01)
            listener.listen(128)
            with contextlib.ExitStack() as connections:

                def connect():
                    return connections.enter_context(socket.create_connection(address, timeout=30))

                for _ in range(60):
                    connect()
                await asyncio.sleep(0.2)
                assert len(served.server_state.connections) == 40
                asking = connect()
                asking.sendall(b"GET / HTTP/1.1\r\nHost: a\r\n\r\n")
                for _ in range(100):
                    connect()
                await asyncio.sleep(0.5)
                served.should_exit = served.force_exit = True
                await serving
                return asking.recv(12)

        assert asyncio.run(answer()) == b"HTTP/1.1 200"

    def test_a_page_that_is_terminated_ends_its_run(self, tmp_path):
        maps(tmp_path / "study/measured")
        with served(tmp_path / "study", ended_by=signal.SIGTERM) as address:
            assert opened(address)(STUDY, "start")[0] == 200
            in_time(lambda: len(working_in(tmp_path / "study")) > 2)  # the page, the run, Snakemake
        assert working_in(tmp_path / "study") == []


def working_in(folder):
    """The processes that work in a folder."""
    working = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            working += [process.pid] * (process.cwd() == str(folder))
    return working


class TestPages:
    pytestmark = in_browser

    def test_the_file_that_opens_the_page_leads_to_it(self, tmp_path, monkeypatch, browser):
        with served(tmp_path / "study") as address:
            monkeypatch.chdir(tmp_path / "study")
            monkeypatch.setattr(server.webbrowser, "open", browser.open)
            server.open_in_browser(address)
            browser.wait(f"location.href === '{address}' && document.querySelector('#preview')")
            assert server._OPENING.stat().st_mode & 0o777 == 0o600  # the address holds the token
            assert browser.problems == []

    def test_a_page_says_that_the_program_has_ended(self, tmp_path, browser):
        with served(tmp_path / "study") as address:
            show(browser, address)
        browser.wait("document.querySelector('#problem').textContent.startsWith('No answer: start')")
        assert browser.problems == []

    def test_a_report_of_a_terminal_is_shown_and_the_page_is_loaded_again_by_going_back(
        self, tmp_path, browser
    ):
        with served(tmp_path / "study") as address:
            show(browser, address)
            assert not browser.evaluate("document.querySelector('#show')")
            (tmp_path / "study/results").mkdir(parents=True)  # by a run in a terminal
            (tmp_path / "study/results/report.html").write_text("<html><head></head><body>old</body></html>")
            browser.wait("document.querySelector('#show')")
            click(browser, "#show")
            report_open(browser)
            browser.evaluate("history.back()")
            browser.wait(f"location.href === '{address}' && document.body.ariaBusy === 'false'")
            ask(browser, "friction")
            assert browser.text("#problem") == ""

    def test_a_page_of_another_origin_gets_nothing(self, tmp_path, browser):
        """The page of another port of this computer, which even knows the token."""
        (tmp_path / "study/results").mkdir(parents=True)
        (tmp_path / "study/results/secret.json").write_text('{"secret": 1}')
        with served(tmp_path / "study") as address:
            show(browser, address)
            other_site = tmp_path / "other"
            other_site.mkdir()
            (other_site / "index.html").write_text("<title>other</title>")

            class Quiet(http.server.SimpleHTTPRequestHandler):
                def __init__(self, *arguments):
                    super().__init__(*arguments, directory=str(other_site))

                def log_message(self, *_):
                    pass

            with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Quiet) as server:
                threading.Thread(target=server.serve_forever, daemon=True).start()
                browser.new_page()
                browser.open(f"http://127.0.0.1:{server.server_port}/")
                for words in (
                    f'fetch("{address}results/secret.json")',
                    f'fetch("{address}", {{method: "POST", body: "{{}}"}})',
                    f'fetch("{address}")',
                ):
                    assert browser.evaluate(f"{words}.then(() => 'an answer', () => 'nothing')") == "nothing"
                loaded = (
                    f'new Promise(kept => {{ const s = document.createElement("script"); '
                    f's.src = "{address}page/page.js"; '
                    's.onload = () => kept("an answer"); s.onerror = () => kept("nothing"); '
                    "document.head.append(s); })"
                )
                assert browser.evaluate(loaded) == "nothing"
                socket = (
                    f'new Promise(kept => {{ const s = new WebSocket("{address.replace("http", "ws")}"); '
                    's.onopen = () => kept("an answer"); s.onerror = () => kept("nothing"); })'
                )
                assert browser.evaluate(socket) == "nothing"
                # no answer without credentials in the modes that hide it, either: nothing has been started
                browser.evaluate(
                    f'fetch("{address}drop?name=a.txt", {{method: "POST", mode: "no-cors"}}).catch(() => 0)'
                )
                server.shutdown()
            assert not (tmp_path / "study/measured").exists()

    def test_scripts_of_a_report_do_not_run(self, tmp_path, browser):
        """A report of somebody else's study, with scripts; its links lead to files all the same."""
        results = tmp_path / "study/results"
        results.mkdir(parents=True)
        (results / "report.html").write_text(
            "<title>theirs</title><body><a href='one.txt'>one</a><script>document.title = 'ran'</script>"
            "<img src='data:,' onerror=\"document.title = 'ran'\"></body>"
        )
        (results / "one.txt").write_text("the first")
        with served(tmp_path / "study") as address:
            browser.open(f"{address}results/report.html")
            browser.wait("document.querySelector('img').complete")
            assert browser.evaluate("document.title") == "theirs"
            browser.evaluate("document.querySelector('a[href=\"one.txt\"]').click()")
            browser.wait("document.body.textContent.includes('the first')")

    def test_what_is_typed_stays_when_mistakes_come_and_go(self, tmp_path, browser):
        with served(tmp_path / "study") as address:
            show(browser, address)
            fill(browser, "contact.bodies.0.material", "steel")
            mistake_script = "document.querySelector(\"[data-of='contact.bodies']\").textContent"
            browser.wait(f"{mistake_script}.includes('needs exactly two bodies')")
            field = "document.getElementById('contact.bodies.1.material')"
            browser.evaluate(f"{field}.focus()")
            for letter in "PEEK":
                browser.type(letter)
                browser.evaluate("new Promise(kept => setTimeout(kept, 250))")  # a check between
            browser.wait(f"!{mistake_script}")
            assert browser.evaluate(f"[{field}.value, document.activeElement === {field}]") == ["PEEK", True]

    def test_the_focus_stays_when_mistakes_come_and_go_before_it(self, tmp_path, browser):
        maps(tmp_path / "study/measured", 8)
        with served(tmp_path / "study") as address:
            show(browser, address)
            browser.evaluate("document.querySelector('#preview').open = true")
            fill(browser, "path", "measured")
            browser.evaluate("document.querySelector('#adding button').click()")
            rows_read(browser, 3)
            for number in (0, 1):
                fill(browser, f"contact.bodies.{number}.material", "steel")
            for place in ("#start", "#preview summary"):
                browser.evaluate(f"document.querySelector('{place}').focus()")
                for pressure in ("1 apple", ""):
                    fill(browser, "contact.mean_pressure", pressure)
                    saved(browser)
                    assert browser.evaluate("document.querySelector('#mistakes') !== null") == bool(pressure)
                    assert browser.evaluate(f"document.activeElement.matches('{place}')")
                    assert browser.evaluate("document.querySelector('#preview').open")

    def test_odd_names_of_files(self, tmp_path, browser):
        """Marks of HTML, of shells, of addresses and of directions are no more than letters of a name."""
        files = []
        for name in (
            "a 'quote\".npy",
            "<script>alert(1)<!--.npy",
            "Grüße.npy",
            "a\u202eypn.exe.npy",
            "משטח 3.npy",
            f"{'long-' * 49}.npy",
            "a&b=c#d%20?.npy",
            "-dash.npy",
        ):
            files.append(tmp_path / name)
            np.save(files[-1], np.zeros((8, 8)))
        study = tmp_path / "a 'study' <b>"
        with served(study) as address:
            browser.open(address)
            browser.choose_files("#choose", *files)
            rows_read(browser, 8)
            paths = browser.evaluate(
                "[...document.querySelectorAll('.row .path')].map(path => path.textContent)"
            )
            shown_paths = (f"measured/{path.name}".replace("\u202e", "\\u202e") for path in files)
            assert sorted(paths) == sorted(shown_paths)
            # they are shown in the order of their letters, what turns it as an escape
            fill(browser, "report.title", "a title \u202e<b>")
            saved(browser)
            shown = browser.evaluate("document.body.innerText + document.querySelector('#preview').innerText")
            assert "measured/a\\u202eypn.exe.npy" in shown
            assert "{title: a title \\u202e<b>}" in browser.text("#preview")
            assert "\u202e" not in shown
            assert browser.evaluate("document.getElementById('report.title').value") == "a title \u202e<b>"
            browser.resize(400)
            assert browser.evaluate("document.documentElement.scrollWidth") <= 400
            assert browser.evaluate("document.scripts.length") == 1
            assert browser.text("#problem") == ""
            assert browser.problems == []
        assert sorted(path.name for path in (study / "measured").iterdir()) == sorted(p.name for p in files)

    def test_keys_alone_and_narrow_screens(self, tmp_path, browser):
        """From a folder with maps to a run that may begin by keys and letters, 400 pixels wide."""
        study = tmp_path / "study"
        maps(study / "measured")
        with served(study) as address:
            browser.resize(400)
            show(browser, address)
            browser.tab_to("[name='page.job']")
            browser.press("Space")  # the first question: does it seal?
            browser.wait("document.querySelector('#fields h2').textContent === '3 Does it seal?'")
            browser.tab_to("#path")
            browser.type("measured")
            browser.press("Enter")
            rows_read(browser, 3)
            assert browser.text("#added").strip() == "3 added"
            assert (
                browser.text("#run .doubt") == "1 of 3 files cannot be read as they are: see what they need."
            )
            # what the array does not say has a field for each
            for column, text in (("dx", "1 um"), ("dy", "1 um"), ("height_unit", "um")):
                browser.tab_to(f".row [name$='.{column}']")
                browser.type(text)
            for name, text in (
                ("contact.bodies.0.material", "steel"),
                ("contact.bodies.1.material", "NBR"),
                ("contact.mean_pressure.0", "1 MPa"),
                ("statistics.seal.pressure_difference", "1 bar"),
                ("statistics.seal.viscosity", "1 mPa s"),
                ("statistics.seal.width", "2 mm"),
            ):
                browser.tab_to(f"[name='{name}']")
                browser.type(text)
            saved(browser)
            rows_read(browser, 3)
            browser.wait("!document.querySelector('#start').ariaDisabled")
            browser.tab_to("#start")
            # from the top of the page no more than forty stops, with three files
            browser.evaluate("document.activeElement.blur(); getSelection().collapse(document.body, 0)")
            browser.evaluate("document.querySelector('nav a').focus()")
            browser.tab_to("#start", most=39)
            # everything else is within reach, a layer of a body, too
            browser.tab_to("#more summary", most=400)
            browser.evaluate("document.querySelectorAll('details').forEach(part => { part.open = true; })")
            browser.tab_to("[data-list='contact.bodies.1.layers'] .more")
            browser.press("Enter")  # a layer, whose first field has the focus
            browser.wait("document.activeElement.name === 'contact.bodies.1.layers.0.material'")
            layer = {"thickness": "2 um", "youngs_modulus": "1 GPa", "poissons_ratio": "0.4"}
            for name, text in layer.items():
                browser.tab_to(f"[name='contact.bodies.1.layers.0.{name}']")
                browser.type(text)
            saved(browser)
            bodies = yaml.safe_load((study / "config/config.yaml").read_text())["contact"]["bodies"]
            assert bodies[1]["layers"] == [layer | {"poissons_ratio": 0.4}]
            unnamed = (
                "[...document.querySelectorAll('input, select, textarea, button')].filter(field => "
                "field.type !== 'hidden' && "
                "!(field.labels?.length || field.ariaLabel || field.textContent)).length"
            )
            assert browser.evaluate(unnamed) == 0
            click(browser, ".thumbnail")
            browser.wait("document.querySelector('#map')")
            assert browser.evaluate("document.documentElement.scrollWidth") <= 400
            picture(browser, "app-narrow")
            assert browser.problems == []


def reloaded_after_typing(browser, study, text, seconds):
    """Type a coefficient of friction, load the page again so long after, and find it."""
    fill(browser, "statistics.friction.coefficient", text)
    time.sleep(seconds)
    browser.evaluate("window.isOld = true")
    browser.send("Page.reload")
    browser.wait("!window.isOld && document.readyState === 'complete'")
    browser.wait(f"document.getElementById('statistics.friction.coefficient')?.value === '{text}'")
    config = yaml.safe_load((study / "config/config.yaml").read_text())
    assert config["statistics"]["friction"]["coefficient"] == float(text)


class TestNothingLost:
    pytestmark = in_browser

    def test_reload_undo_and_another_page(self, tmp_path, browser):
        study = tmp_path / "study"
        maps(study / "measured", 16)
        with served(study) as address:
            show(browser, address)
            assert not (study / "config").exists()
            click(browser, "[name='page.job'][value=friction]")
            browser.choose_files("#choose", *(study / "measured").iterdir())
            rows_read(browser, 3)  # copies of files that are there are known again
            assert browser.evaluate("document.querySelector('#choose').files.length") == 0  # and chosen again
            assert len([*(study / "measured").iterdir()]) == 3
            saved(browser)
            reloaded_after_typing(browser, study, "0.3", 0.0)
            rows_read(browser, 3)
            # those that are ticked, at first the new ones, are so still
            assert browser.evaluate("document.querySelectorAll('.pick:checked').length") == 3
            for number in (1, 3):
                click(browser, f".row:nth-child({number}) .pick")
            click(browser, "#remove")
            rows_read(browser, 2)
            assert len((study / "config/surfaces.tsv").read_text().splitlines()) == 4
            click(browser, "#undo")
            rows_read(browser, 3)
            assert "1 back" in browser.text("#added")
            assert len((study / "config/surfaces.tsv").read_text().splitlines()) == 5
            # another window shows the same study, what is typed in either appears in both
            first_page = browser.new_page()
            browser.open(address)
            browser.wait("document.querySelectorAll('.row').length === 3")
            coefficient = "document.getElementById('statistics.friction.coefficient').value"
            browser.wait(f"{coefficient} === '0.3'")
            fill(browser, "statistics.friction.coefficient", "0.9")
            second_page, browser.session = browser.session, first_page
            browser.wait(f"{coefficient} === '0.9'")
            fill(browser, "statistics.friction.coefficient", "0.4")
            browser.session = second_page
            browser.wait(f"{coefficient} === '0.4'")
            assert "coefficient: 0.4" in (study / "config/config.yaml").read_text()
            assert browser.problems == []

    @pytest.mark.slow
    def test_twenty_reloads(self, tmp_path, browser):
        """At random moments after a letter was typed: before it is sent, while it is written, and later."""
        generator = np.random.default_rng(7)
        with served(tmp_path / "study") as address:
            show(browser, address)
            click(browser, "[name='page.job'][value=friction]")
            saved(browser)
            for number in range(20):
                reloaded_after_typing(
                    browser, tmp_path / "study", f"{0.1 + number / 100:.2f}", generator.uniform(0.0, 0.5)
                )
            assert (
                browser.evaluate("document.querySelector('[name=\"page.job\"]:checked').value") == "friction"
            )
            assert browser.text("#problem") == ""
            assert browser.problems == []

    @pytest.mark.slow
    def test_twenty_kills(self, tmp_path):
        """Whatever was answered for before the program is killed is in the files; no file is half written."""
        study = tmp_path / "study"
        maps(study / "measured", 8)
        generator = np.random.default_rng(7)
        row = {"rows.0.surface": "Prüfling-表", "rows.0.path": "measured/one.x3p", "page.job": "seal"}
        for kill in range(20):
            command = [*PROGRAM, "app", str(study), "--no-browser"]
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
                address = re.search(r"http://\S+", process.stdout.readline())[0]
                press = opened(address)
                start = time.monotonic()
                assert press(row | {"contact.mean_pressure.0": f"{kill}000 kPa"})[0] == 200
                answered = kill * 1000
                threading.Timer(generator.uniform(0.0, 2 * (time.monotonic() - start)), process.kill).start()
                with contextlib.suppress(OSError, http.client.HTTPException):
                    while press(row | {"contact.mean_pressure.0": f"{answered + 1} kPa"})[0] == 200:
                        answered += 1
            written = yaml.safe_load((study / "config/config.yaml").read_text())["contact"]["mean_pressure"]
            assert written in ([f"{answered} kPa"], [f"{answered + 1} kPa"])  # of which the answer was lost
            with contextlib.chdir(study):
                assert [*read_surfaces("config/surfaces.tsv")] == ["Prüfling-表"]
            assert "; asked: seal\n" in (study / "config/config.yaml").read_text()


class TestManyFiles:
    pytestmark = in_browser

    def test_two_hundred_files(self, tmp_path, browser):
        study = tmp_path / "study"
        (study / "measured").mkdir(parents=True)
        for number in range(200):
            heights = self_affine_surface((32, 32), 1e-6, **ROUGHNESS, seed=number // 2).values
            (study / f"measured/m{number:03}.sdf").write_bytes(sdf_bytes(heights, 1e-6))
        with served(study) as address:
            browser.resize(1400)
            show(browser, address)
            browser.evaluate("document.querySelector('#path').value = 'measured'")
            browser.evaluate(
                "window.seen = []; new MutationObserver(() => seen.push(element('added').textContent))"
                ".observe(document.body, {subtree: true, childList: true, characterData: true})"
            )
            start = time.monotonic()
            browser.evaluate("document.querySelector('#adding button').click()")
            browser.wait("document.querySelectorAll('.row img').length > 0")
            assert time.monotonic() - start < 20
            browser.wait("seen.some(text => /; \\d+ of 200 files are read/.test(text))")
            # while they are read the page answers
            start = time.monotonic()
            fill(browser, "report.title", "two hundred")
            browser.wait("document.querySelector('#preview pre').textContent.includes('two hundred')")
            assert time.monotonic() - start < 10
            browser.wait("document.querySelectorAll('.row img').length === 200", seconds=200)
            assert browser.text(".row:nth-child(2) .line").endswith("; the same file as m000")
            assert browser.evaluate("document.querySelector('#files').getBoundingClientRect().height") < 2000
            picture(browser, "app-many", "#files")
            assert browser.problems == []


class Fields(html.parser.HTMLParser):
    """The fields of a page with their texts, as a browser sends them."""

    def __init__(self):
        super().__init__()
        self.texts, self.name, self.area = {}, None, None

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        if tag in ("input", "select", "textarea") and "name" in attrs and attrs.get("type") != "checkbox":
            self.name = attrs["name"]
            self.texts[self.name] = attrs.get("value", "")
            self.area = tag
        if tag == "option" and self.area == "select":
            self.chosen = "selected" in attrs

    def handle_data(self, data):
        if self.area == "textarea":
            self.texts[self.name] += data.removeprefix("\n")
        elif self.area == "select" and getattr(self, "chosen", False):
            self.texts[self.name], self.chosen = data, False

    def handle_endtag(self, tag):
        if tag == self.area:
            self.area = None


def form_fields(page):
    fields = Fields()
    fields.feed(page)
    return fields.texts


def leaves(section, prefix):
    """The names of all settings that are no groups, of lists in the first entry, and their fields."""
    for name, field in section.model_fields.items():
        if below := section_model(field):
            yield from leaves(below, f"{prefix}{name}." + ("0." if is_list(field.annotation) else ""))
        else:
            yield prefix + name, field


class TestForm:
    """The form and the files stand for one another."""

    pytestmark = pytest.mark.usefixtures("small_study")

    @pytest.mark.parametrize(
        "config",
        [
            {
                "contact": {
                    "bodies": ["steel", {"material": "PEEK", "hardness": "0.3 GPa"}],
                    "force": ["50 N", 80.25],
                    "area": 1.23456789e-4,
                }
            },
            {
                "level": {"outlier_threshold": None, "order": 3, "robust": True},
                "contact": {
                    "contact_modulus": "1 GPa",
                    "relative_pressure": [0.01, 0.2],
                    "target_area": [0.1],
                },
                "uncertainty": {"sources": []},
                "report": {"title": "2024, a title: with marks"},
                "cases": {"soft": {"contact": {"contact_modulus": "1 MPa"}}},
            },
            {
                "contact": {
                    "bodies": [
                        {
                            "base": "rigid",
                            "layers": [
                                {"thickness": "2 um", "youngs_modulus": "1 GPa", "poissons_ratio": 0.2},
                                {"thickness": 1e-6, "youngs_modulus": 2e9, "poissons_ratio": 0.3},
                            ],
                        },
                        {"youngs_modulus": 1e9, "poissons_ratio": 0.5},
                    ]
                }
            },
        ],
    )
    def test_settings_survive_the_form(self, config, tmp_path):
        (tmp_path / "config/config.yaml").write_text(yaml.safe_dump(config))
        (tmp_path / "config/surfaces.tsv").write_text("surface\tpath\none\tmeasured/one.x3p\n")
        page = Page()
        sent = page.after(form_fields(page.since()))
        assert "saved in config/config.yaml and config/surfaces.tsv" in sent
        written = (tmp_path / "config/config.yaml").read_text()
        assert resolve(yaml.safe_load(written)) == resolve(config)
        page.after(form_fields(page.since()))
        assert (tmp_path / "config/config.yaml").read_text() == written

    @pytest.mark.parametrize("job", JOBS)
    def test_every_question_can_be_asked_of_metals_by_the_examples_of_its_fields(self, job):
        texts = {"contact.bodies.0.material": "copper", "contact.bodies.1.material": "steel"} | JOBS[job].get(
            "made", {}
        )
        for name in names_of(job)[2:]:
            texts[name] = example(name)
        columns = {
            name: text
            for name, text in (("group", "a"), ("lay", "none"))
            if name in JOBS[job].get("columns", [])
        }
        rows = [
            {"surface": "one", "path": "measured/one.x3p"},
            {"surface": "two", "path": "measured/two.sdf"},
        ]
        checked = check(texts, [row | columns for row in rows], job=job)
        assert checked["mistakes"] == {}
        assert list(checked["plan"].results) == ["one", "two"]

    def test_the_unit_of_the_heights_is_offered_where_it_is_in_doubt(self, tmp_path):
        text = "# Value units: m\n# Width: 12 µm\n# Height: 8 µm\n1 1.5 3\n-2 -3 -6\n"
        (tmp_path / "measured/own.txt").write_text(text)
        inspection = measurements.inspect({"path": "measured/own.txt"})
        assert "check the height unit" in " ".join(inspection["warnings"])
        assert inspection["columns"] == ["height_unit"]
        assert measurements.inspect({"path": "measured/one.x3p"})["columns"] == []

    def test_no_part_of_a_profile_is_cropped_or_masked(self, tmp_path):
        """Where the table would refuse it."""
        (tmp_path / "measured/line.csv").write_bytes(profile_bytes(np.arange(64.0)[None] * 1e-8, 1e-6))
        page = Page()
        for path, tools in (("one.x3p", 4), ("line.csv", 0)):
            page.after({"rows.0.surface": "one", "rows.0.path": f"measured/{path}", "page.look": "0"})
            page.reader.pool.submit(int).result()
            answer = page.html()
            assert answer.count('name="tool"') == tools
            assert ("rows.0.crop" in form_fields(answer)) == bool(tools)

    @pytest.mark.parametrize(("held", "first"), [({"ny": 8}, "default: Topography"), (None, "")])
    def test_the_channel_that_is_read_is_named(self, held, first, tmp_path, monkeypatch):
        (tmp_path / "config/surfaces.tsv").write_text("surface\tpath\none\tone.nid\n")
        channels = [{"name": name, "is_height": True} for name in ("Topography forward", "Topography")]
        inspection = measurements.UNREAD | {"key": "a", "channel": "Topography", "channels": channels}
        inspection |= {"map": held}  # where one has to be named, none is read
        monkeypatch.setattr(measurements, "inspect", lambda _: inspection)
        page = Page()
        page.since()
        page.reader.pool.shutdown()
        options = re.findall("<option[^>]*>([^<]*)", page.html().partition("rows.0.channel")[2])
        assert options[:3] == [first, "Topography forward", "Topography"]

    def test_a_study_of_unreadable_files_alone_is_not_run(self):
        page, reason = Page(), "1 of 1 files cannot be read as they are"
        page.after(STUDY | {"rows.0.path": "measured/three.npy"})
        page.reader.inspected(page.rows)
        page.reader.pool.submit(int).result()  # all before it are read
        assert f'{reason}: <a href="#row-0">' in page.html()
        assert re.search('id="start"[^>]* aria-disabled=true', page.html())
        with pytest.raises(SettingsError, match="nothing is started"):
            page.after({"page.do": "start"})
        assert page.run.process is None
        # what it needs makes it readable
        page.after({"rows.0.dx": "1 um", "rows.0.dy": "1 um", "rows.0.unit": "um"})
        page.reader.pool.submit(int).result()
        assert reason not in page.html()
        assert not re.search('id="start"[^>]* aria-disabled', page.html())

    def test_a_further_field_is_asked_for_by_its_name(self):
        page, further = Page(), "contact.mean_pressure.1"
        assert further not in form_fields(page.since())
        assert further in form_fields(page.after({further: ""}))

    @pytest.mark.parametrize("bodies", ["[steel, PEEK]", "[{material: steel}, {layers: [steel, PEEK]}]"])
    def test_a_word_for_a_body_and_a_number_for_a_list_are_changed_by_their_fields(self, bodies, tmp_path):
        config = tmp_path / "config/config.yaml"
        config.write_text(f"contact: {{bodies: {bodies}, mean_pressure: 5 MPa}}\n")
        page = Page()
        fields = {"contact.bodies.0.material": "copper", "contact.mean_pressure.0": "6 MPa"}
        fields |= {"contact.bodies.1.hardness": "1 GPa"}
        assert set(fields) - {"contact.bodies.1.hardness"} <= form_fields(page.since()).keys()
        page.after(fields)
        contact = yaml.safe_load(config.read_text())["contact"]
        assert contact["mean_pressure"] == ["6 MPa"]
        assert contact["bodies"][0] == {"material": "copper"}
        second = {"layers": [{"material": name} for name in ("steel", "PEEK")]}
        second = second if "layers" in bodies else {"material": "PEEK"}
        assert contact["bodies"][1] == second | {"hardness": "1 GPa"}

    @pytest.mark.parametrize("values", ["{bodies: steel}", "{bodies: [], mean_pressure: []}", "3"])
    def test_a_field_takes_the_place_of_a_value_where_a_group_belongs(self, values, tmp_path):
        config = tmp_path / "config/config.yaml"
        config.write_text(f"contact: {values}\n")
        page = Page()
        page.since()
        bodies = {f"contact.bodies.{index}.material": "steel" for index in (0, 1)}
        page.after(bodies | {"contact.mean_pressure.0": "6 MPa"})
        expected = {"bodies": [{"material": "steel"}] * 2, "mean_pressure": ["6 MPa"]}
        assert yaml.safe_load(config.read_text())["contact"] == expected

    def test_a_load_that_comes_with_another_question_is_set_aside(self, tmp_path):
        page, pressure = Page(), "contact.mean_pressure.0"
        page.after({"page.job": "seal", pressure: "2 MPa"})
        page.after({pressure: "2.5 MPa", "page.job": "ball"})
        page.after({"contact.force.0": "5 N"})
        contact = yaml.safe_load((tmp_path / "config/config.yaml").read_text())["contact"]
        assert contact == {"boundary": "free", "force": ["5 N"]}
        page.after({"page.job": "seal"})
        contact = yaml.safe_load((tmp_path / "config/config.yaml").read_text())["contact"]
        assert contact == {"mean_pressure": ["2.5 MPa"]}

    def test_what_others_change_meanwhile_is_kept(self, tmp_path):
        """While the page is open both files are edited in a terminal: one field of the page changes there."""
        config, table = tmp_path / "config/config.yaml", tmp_path / "config/surfaces.tsv"
        page = Page()
        page.since()
        page.after(STUDY | {"rows.1.surface": "two", "rows.1.path": "measured/two.sdf"})
        page.after({"page.do": "all"})
        news = page.news()
        edited = (
            config.read_text().replace("mean_pressure", "unload: [1 MPa]\n  mean_pressure")
            + "report: {title: five}\n"
        )
        config.write_text(edited)
        # a row before, and one of which the name is another
        header, one, two = table.read_text().splitlines()[1:]
        new, other = "new\tmeasured/three.npy\t", two.replace("two", "second", 1)
        table.write_text("\n".join([header + "\tdx", new + "3 um", one, other, ""]))
        # the page shows it by itself
        answer = page.since(news)
        assert "config/config.yaml and config/surfaces.tsv: changed outside this page" in answer
        assert form_fields(answer)["rows.0.dx"] == "3 um"
        assert [bool(row.get(study.TICKED)) for row in page.rows] == [False, True, False]
        table.write_text(table.read_text().replace("3 um", "4 um"))
        config.write_text(edited.replace("five", "seven"))
        answer = page.after({"contact.mean_pressure.0": "6 MPa"})
        assert "config/config.yaml and config/surfaces.tsv: changed outside this page" in answer
        written = yaml.safe_load(config.read_text())
        assert (written["report"]["title"], written["contact"]["unload"]) == ("seven", ["1 MPa"])
        assert written["contact"]["mean_pressure"] == ["6 MPa"]
        assert "changed outside" not in page.after({"rows.0.dy": "5 um"})
        # rows have their numbers by the table that the page has shown
        new, *later = (row for row in table.read_text().splitlines()[2:])
        table.write_text("\n".join([*table.read_text().splitlines()[:2], *later, ""]))
        answer = page.after({"rows.0.dx": "9 um", "rows.1.dx": "2 um"})
        assert "dx is not set: its row is in the table no more" in answer
        rows = read_table(table)[1]
        assert [cells[0] for _, cells in rows] == ["one", "second"]
        assert ["2 um" in cells for _, cells in rows] == [True, False]
        # what cannot be read is kept as a file of its own, also where it was seen before
        config.write_text(config.read_text() + "contact: {")
        assert "is not valid YAML" in page.since("")
        assert "is not valid YAML" in page.after({"page.look": "0"})
        answer = page.after({"contact.mean_pressure.0": "7 MPa"})
        assert "is not valid YAML" not in answer
        assert "what was there is kept as config/config.yaml.before-page" in answer
        assert yaml.safe_load(config.read_text())["report"]["title"] == "seven"

    def test_the_cells_of_a_file_stay_while_it_is_read_again(self):
        page = Page()
        page.after(STUDY | {"rows.0.path": "measured/three.npy"})
        page.reader.pool.submit(int).result()
        assert 'name="rows.0.unit"' in page.html()
        reading = threading.Event()
        page.reader.pool.submit(reading.wait)
        answer = page.after({"rows.0.dx": "1 um"})
        reading.set()
        assert "is read ..." in answer
        assert 'name="rows.0.unit"' in answer

    def test_a_page_looks_up_each_file_once(self, monkeypatch):
        page, looked_up = Page(), []
        page.after(STUDY | {"rows.1.surface": "two", "rows.1.path": "measured/two.sdf"})
        page.reader.pool.submit(int).result()
        find_file = measurements.find_file
        monkeypatch.setattr(
            measurements, "find_file", lambda path, *rest: looked_up.append(path) or find_file(path, *rest)
        )
        page.html()
        assert looked_up == ["measured/one.x3p", "measured/two.sdf"]

    def test_columns_are_explained_by_columns_not_by_options(self, tmp_path):
        (tmp_path / "config/surfaces.tsv").write_text("surface\tpath\none\tmeasured/one.x3p\n")
        page = Page().since()
        assert "unit of dx and dy, and of the heights without height_unit: m" in page
        assert "--height-unit" not in page

    def test_a_file_of_the_page_that_cannot_be_read_is_kept(self, tmp_path):
        page = Page()
        page.since()
        page.after(STUDY)
        damaged = (tmp_path / "config/config.yaml").read_text() + "statistics: {"
        (tmp_path / "config/config.yaml").write_text(damaged)
        page = Page()
        assert "config/config.yaml" in page.since()
        answer = page.after(STUDY)
        assert "what was there is kept as config/config.yaml.before-page" in answer
        assert (tmp_path / "config/config.yaml.before-page").read_text() == damaged
        # nor does what is kept next take its place
        (tmp_path / "config/config.yaml").write_text("# by Ann\n")
        answer = page.after({"contact.mean_pressure": "6 MPa"})
        assert "kept as config/config.yaml.before-page2" in answer
        assert (tmp_path / "config/config.yaml.before-page").read_text() == damaged
        assert (tmp_path / "config/config.yaml.before-page2").read_text() == "# by Ann\n"

    def test_what_is_typed_into_a_list(self):
        bodies = {f"contact.bodies.{index}.material": "steel" for index in (0, 1)}
        for text, unload in (
            ("true", []),
            ("1 MPa", [1e6]),
            ("1 MPa, 2e6", [1e6, 2e6]),
            ("1 MPa,2 MPa", [1e6, 2e6]),
            ("[1 MPa , 2.5e6,]", [1e6, 2.5e6]),
            ("1e6 ,2e6", [1e6, 2e6]),
        ):
            files = check(bodies | {"contact.unload": text}, [])["files"]
            config = yaml.safe_load(files[CONFIG])
            assert resolve(config)[""]["contact"]["unload"] == unload

    @pytest.mark.parametrize("text", ["2,5", "-0,5", "1,5e-6", "[2,5]", "2,5 {}", "2,5, 3,5"])
    def test_a_decimal_comma_is_never_two_values(self, text):
        """In every field: a number with a comma is refused in words, or is a text or no choice."""
        texts = ("cases", "surfaces")
        all_fields = {name: field for name, field in leaves(Settings, "") if name not in texts}
        form = {name: text.format(setting_base(field)) for name, field in all_fields.items()}
        form["contact.bodies.1.material"] = "steel"
        checked = check(form, [])
        # a hardness of the contact takes the place of those of the bodies
        of_bodies = check({name: form[name] for name in form if "contact.hardness" not in name}, [])
        config = yaml.safe_load(checked["files"][CONFIG])
        numbers = 0
        for name, field in all_fields.items():
            value = value_at(config, name)
            assert all("," in str(entry) for entry in (value if isinstance(value, list) else [value])), name
            if setting_base(field) or "float" in str(field.annotation):
                numbers += 1
                mistakes = " ".join((of_bodies["mistakes"] | checked["mistakes"]).get(name, []))
                # one number is no modulus by the time
                refusal = "a group" if "creep" in name else "write a decimal point, not a comma|has no unit"
                assert re.search(refusal, mistakes), (name, mistakes)
        assert numbers > 60

    @pytest.mark.parametrize(
        "column", ["dx", "dy", "noise", "tip_radius", "amplification_z", "missing_value"]
    )
    def test_nor_in_the_table(self, column):
        row = {"surface": "one", "path": "measured/one.x3p", column: "2,5"}
        mistakes = check({}, [row])["mistakes"]
        assert re.search("decimal point|give numbers", " ".join(mistakes[f"rows.0.{column}"]))
        row[column] = "2,5 um"
        assert f"rows.0.{column}" in check({}, [row])["mistakes"]

    def test_numbers_that_yaml_reads_otherwise_are_refused(self):
        for text, words in (
            ("010", "to the base of 8"),
            ("1:30", "to the base of 60"),
            ("[5", "5"),
            ("a: b", "a: b"),
        ):
            mistakes = check({"contact.hardness": text, "contact.contact_modulus": "1 GPa"}, [])["mistakes"]
            assert words in str(mistakes)
        mistakes = check({"cases": "soft: {", "contact.contact_modulus": "1 GPa"}, [])["mistakes"]
        assert "must be" in mistakes["cases"][0]
        mistakes = check({"contact": "5", "contact.force": "1 N"}, [])["mistakes"]
        assert "must be a group of settings" in mistakes["contact"][0]

    def test_notes_of_others_are_kept_and_unknown_keys_shown(self, tmp_path):
        study = tmp_path / "study"
        (study / "config").mkdir(parents=True)
        maps(study / "measured")
        note = "# measured by Ann\ncontact: {contact_modulus: 1 GPa, bodys: [steel]}\n"
        (study / "config/config.yaml").write_text(note)
        (study / "config/surfaces.tsv").write_text("# by Ann\nsurface\tpath\none\tmeasured/one.x3p\n")
        with served(study) as address:
            assert 'name="contact.bodys"' in get(address)[1]
            fields = {"rows.0.surface": "one", "rows.0.path": "measured/one.x3p"}
            fields["contact.contact_modulus"] = "2 GPa"

            ask = opened(address)
            assert "did you mean bodies?" in ask({})[1]
            assert (study / "config/config.yaml").read_text() == note  # who only looks writes nothing
            answer = ask(fields)[1]
            assert "what was there is kept as config/config.yaml.before-page" in answer
            assert "what was there is kept as config/surfaces.tsv.before-page" in answer
            assert (study / "config/config.yaml.before-page").read_text() == note
            assert "what was there is kept" not in ask({"contact.force": "1 N"})[1]  # by the page itself
            # what is wrong is saved as well, but not run
            assert "nothing is started: correct first" in ask({"contact.bodys": "steel"}, "start")[1]
            assert "bodys: steel" in (study / "config/config.yaml").read_text()
            fields["rows.0.path"] = "measured/gone.x3p"
            assert "no such file; correct the path" in ask(fields)[1]
