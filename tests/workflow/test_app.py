"""The page `roughcontact app`: five steps in a real browser, who is refused, keys alone, narrow screens."""

import contextlib
import html.parser
import http.client
import http.server
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import urllib.parse

import numpy as np
import pytest
import yaml
from browser import CHROMIUM, Browser
from starlette.datastructures import QueryParams

from data_samples.make_samples import sdf_bytes, x3p_bytes
from roughcontact.app.page import Page
from roughcontact.app.study import CONFIG, check
from roughcontact.configuration.resolve import resolve
from roughcontact.configuration.surfaces import read_surfaces
from roughcontact.references.synthetic import self_affine_surface

in_browser = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium installed"),
]
PROGRAM = [sys.executable, "-m", "roughcontact.command_line"]


@contextlib.contextmanager
def served(folder):
    """The address of the page of a folder, served by the program."""
    command = [*PROGRAM, "app", str(folder), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            line = process.stdout.readline()
            assert "http://" in line, process.stderr.read()
            yield re.search(r"http://\S+", line)[0]
        finally:
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=60)
    assert "Traceback" not in said, said
    assert process.returncode == 130


def maps(folder, size=64):
    """Write maps in three formats: X3P, SDF, and an array of NumPy, which states neither pitch nor unit."""
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {"hurst": 0.8, "shortest": 8e-6, "longest": 32e-6, "rms_gradient": 0.1}
    one, two, three = (
        self_affine_surface((size, size), 1e-6, **wanted, seed=seed).values for seed in (1, 2, 3)
    )
    (folder / "one.x3p").write_bytes(x3p_bytes(one, 1e-6))
    (folder / "two.sdf").write_bytes(sdf_bytes(two, 1e-6))
    np.save(folder / "three.npy", three * 1e6)
    return [folder / name for name in ("one.x3p", "two.sdf", "three.npy")]


def fill(browser, name, text):
    """Write a text into the field of a setting, as typing does."""
    found = f"document.getElementsByName({json.dumps(name)})[0]"
    browser.evaluate(
        f"{{ const field = {found}; field.closest('details').open = true; field.value = {json.dumps(text)}; "
        "field.dispatchEvent(new Event('input', {bubbles: true})); }"
    )


def fill_cell(browser, number, column, text):
    """Write a text into a cell of a row, as typing does."""
    browser.evaluate(
        f"{{ const cell = document.getElementById('rows.{number}.{column}'); "
        f"cell.value = {json.dumps(text)}; cell.dispatchEvent(new Event('input', {{bubbles: true}})); }}"
    )


def click(browser, selector):
    browser.evaluate(f"document.querySelector({json.dumps(selector)}).click()")


def picture(browser, name, selector="html"):
    """Keep a picture where the variable ROUGHCONTACT_PICTURES names a folder: those of the page on it."""
    if folder := os.environ.get("ROUGHCONTACT_PICTURES"):
        from pathlib import Path

        from PIL import Image

        path = Path(folder, f"{name}.png")
        browser.picture(path, selector=selector)
        with Image.open(path) as drawn:
            drawn.quantize(64).save(path, optimize=True)


class TestFiveSteps:
    pytestmark = in_browser

    def test_from_an_empty_folder_to_a_report(self, tmp_path):
        study = tmp_path / "a study"
        files = maps(tmp_path / "instrument", 128)
        with served(study) as address, Browser(tmp_path / "profile") as browser:
            browser.open(address)
            # 1: files, of which one does not say its unit
            browser.choose_files("#choose", *files)
            browser.wait("document.querySelectorAll('.row').length === 3")
            browser.wait("document.querySelectorAll('.row pre').length === 3")
            assert browser.text("#added").startswith("3 added")
            assert sorted(path.name for path in (study / "measured").iterdir()) == sorted(
                p.name for p in files
            )
            rows = [browser.text(f".row:nth-child({number}) pre") for number in (1, 2, 3)]
            assert "X3P" in rows[0]
            assert "SDF" in rows[1]
            assert "give dx, dy, unit in the table of surfaces" in " ".join(rows[2].split())
            seen = "[...document.querySelectorAll('.row img')].filter(image => image.naturalWidth > 0).length"
            browser.wait(f"{seen} === 2")
            for column, text in (("dx", "1 um"), ("dy", "1 um"), ("unit", "um")):
                fill_cell(browser, 2, column, text)
            browser.wait(f"{seen} === 3")
            assert "--dx '1 um'" in browser.text(".row:nth-child(3) .command")
            picture(browser, "app-files", "#files")
            # groups by selecting
            for number in (1, 2):
                click(browser, f".row:nth-child({number}) .pick")
            browser.evaluate("document.querySelector('#cell').value = 'ground'")
            click(browser, "#selected button[formaction=set]")
            browser.wait("document.getElementById('rows.1.group')?.value === 'ground'")
            assert browser.evaluate("document.getElementById('rows.2.group')") is None
            # 2: bodies and loads, a load in the wrong unit
            fill(browser, "contact.bodies.0.material", "steel")
            fill(browser, "contact.bodies.1.material", "PEEK")
            placeholder = "document.getElementsByName('contact.bodies.0.youngs_modulus')[0].placeholder"
            browser.wait(f"{placeholder} === '207 GPa'")
            fill(browser, "contact.bodies.1.youngs_modulus", "4 GPa")
            fill(browser, "contact.mean_pressure", "5, 20")
            mistake = "[data-of='contact.mean_pressure']"
            browser.wait(f'document.querySelector("{mistake}").textContent')
            said = browser.text(mistake)
            assert "5.00 Pa is next to no load" in said
            assert "did you mean 5.00 MPa" in said
            with pytest.raises(Exception, match="mistakes in") as refused:
                resolve({"contact": {"bodies": ["steel", "PEEK"], "mean_pressure": [5, 20]}})
            assert said.splitlines()[0] in str(refused.value)
            assert browser.evaluate("document.querySelector('#save').disabled")
            picture(browser, "app-bodies", "#section-contact")
            fill(browser, "contact.mean_pressure", "5 MPa, 20 MPa")
            browser.wait("!document.querySelector('#save').disabled")
            # 3: the files
            preview = browser.text("#preview")
            picture(browser, "app-write", "#write")
            click(browser, "#save")
            browser.wait("document.querySelector('#saved').textContent.includes('written')")
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
            done = re.findall(r"(one|two|three): done", browser.text("#screen"))
            finished = [study / f"results/{name}/statistics.nc" for name in done]
            before = [path.stat().st_mtime_ns for path in finished]
            # a result whose row is gone is not offered
            shutil.copytree(study / "results" / done[0], study / "results/gone")
            click(browser, "#start")
            browser.wait("document.querySelector('#state').textContent === 'done'", seconds=300)
            assert browser.text("#screen").count(": done") == 3 - len(done)
            assert [path.stat().st_mtime_ns for path in finished] == before
            # 5: report, comparison, export
            browser.wait("document.querySelector('#report')")
            assert (study / "results/report.html").is_file()
            browser.wait("document.querySelector('#results').children.length === 3")
            assert browser.text("#results").count("To halve the ± of the contact area: ") == 3
            assert "3 results:" in browser.text_of_frame()
            click(browser, "#compare")
            browser.wait("document.querySelector('#answer').textContent.includes('numbers')")
            assert browser.text("#command").startswith("roughcontact compare results/")
            for ending in (".vti", ".gsf", ".xlsx"):
                browser.evaluate("document.querySelector('#result').value = 'one'")
                browser.evaluate(f"document.querySelector('#form').value = '{ending}'")
                click(browser, "#export")
                command = f"roughcontact export results/one -o exports/one{ending}"
                browser.wait(f"document.querySelector('#command').textContent === '{command}'")
                browser.wait("document.querySelector('#problem').textContent === ''")
                assert (study / f"exports/one{ending}").is_file()
            picture(browser, "app-look", "#look")
            assert browser.problems == []
        # a colleague repeats it without the page: nothing is left to do
        run = subprocess.run([*PROGRAM, "run"], cwd=study, capture_output=True, text=True, check=False)
        assert "Nothing to be done" in run.stdout + run.stderr


def get(address, *, method="GET", body=None, form=None, **headers):
    """Return status and text of the answer to a request, with headers as they are given."""
    parts = urllib.parse.urlsplit(address)
    connection = http.client.HTTPConnection("127.0.0.1", parts.port, timeout=30)
    connection.putrequest(
        method, parts.path + (f"?{parts.query}" if parts.query else ""), skip_host="host" in headers
    )
    for name, value in headers.items():
        connection.putheader(name.replace("_", "-"), value)
    data = body or urllib.parse.urlencode(form or {}).encode()
    if form:
        connection.putheader("Content-Type", "application/x-www-form-urlencoded")
    connection.putheader("Content-Length", str(len(data)))
    connection.endheaders(data)
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, text


class TestWhoIsRefused:
    def test_requests_without_token_of_other_hosts_or_origins(self, tmp_path):
        with served(tmp_path / "study") as address:
            parts = urllib.parse.urlsplit(address)
            base, port = f"http://127.0.0.1:{parts.port}", parts.port
            wrong = f"{base}/{'x' * len(parts.path.strip('/'))}/"
            for without in (f"{base}/", wrong, f"{base}//", f"{base}/page/page.js", f"{base}/results/a"):
                assert get(without) == (403, "refused")
            for headers in (
                {"host": f"evil.example:{port}"},  # a name that was made to point here
                {"host": "127.0.0.1"},
                {"Origin": "http://evil.example"},
                {"Origin": f"http://127.0.0.1:{port + 1}"},
                {"Origin": "null"},
                {"Sec_Fetch_Site": "cross-site"},
                {"Sec_Fetch_Site": "same-site"},
                {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"},
            ):
                for name, method in (("", "GET"), ("page/page.js", "GET"), ("start?page=", "POST")):
                    assert get(address + name, method=method, **headers) == (403, "refused"), headers
            upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13"}
            status, _ = get(wrong, Sec_WebSocket_Key="dGhlIHNhbXBsZSBub25jZQ==", **upgrade)
            assert status == 403
            status, page = get(address, Sec_WebSocket_Key="dGhlIHNhbXBsZSBub25jZQ==", **upgrade)
            assert status == 200  # no socket opens: the answer is that of a page
            # a page with another name, or with none, does nothing
            name = re.search(r'data-page="(\w+)"', page)[1]
            for other in ("", "0" * 16):
                status, said = get(f"{address}state?page={other}", method="POST")
                assert (status, "another page" in said) == (400, True)
                assert get(f"{address}drop?page={other}&name=a.txt", method="POST", body=b"1")[0] == 400
            assert get(f"{address}state?page={name}", method="POST")[0] == 200
            assert not (tmp_path / "study/measured").exists()

    def test_dropped_files_stay_in_their_folder_and_write_over_nothing(self, tmp_path):
        study = tmp_path / "study"
        with served(study) as address:
            name = re.search(r'data-page="(\w+)"', get(address)[1])[1]

            to = f"{address}drop?page={name}&name="
            assert get(to + "../../one.txt", method="POST", body=b"1") == (200, "measured/one.txt")
            assert get(to + "C:\\maps\\two.txt", method="POST", body=b"2") == (200, "measured/two.txt")
            for taken in ("one.txt", "..", ".", "/", ""):
                status, said = get(to + taken, method="POST", body=b"3")
                assert (status, "is there already" in said) == (400, True)
            assert sorted(path.name for path in tmp_path.rglob("*.txt")) == ["one.txt", "two.txt"]
            assert (study / "measured/one.txt").read_text() == "1"
            # nor do the results lead out of their folder
            (study / "results").mkdir()
            (study / "results/a.txt").write_text("a result")
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

    def test_a_second_program_on_the_same_folder(self, tmp_path):
        with served(tmp_path / "study"):
            command = [*PROGRAM, "app", str(tmp_path / "study"), "--no-browser"]
            second = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
        assert second.returncode == 2
        assert "its page is open already" in second.stderr
        with served(tmp_path / "study") as address:  # the first has ended
            assert get(address)[0] == 200


class TestPages:
    pytestmark = in_browser

    def test_a_second_page_waits_until_the_first_is_closed(self, tmp_path):
        with served(tmp_path / "study") as address, Browser(tmp_path / "profile") as browser:
            browser.open(address)
            browser.wait("document.querySelector('#preview pre')")
            first = browser.new_page()
            browser.open(address)
            assert "is open in another page" in browser.text("body")
            assert get(address)[0] == 409
            second, browser.session = browser.session, first
            browser.send("Page.close")
            browser.session = second
            browser.wait("document.querySelector('#preview pre')", seconds=30)

    def test_a_page_of_another_origin_gets_nothing(self, tmp_path):
        """The page of another port of this computer, which even knows the token."""
        (tmp_path / "study/results").mkdir(parents=True)
        (tmp_path / "study/results/secret.json").write_text('{"secret": 1}')
        with served(tmp_path / "study") as address, Browser(tmp_path / "profile") as browser:
            browser.open(address)
            browser.wait("document.querySelector('#preview pre')")
            name = browser.evaluate("document.body.dataset.page")
            other = tmp_path / "other"
            other.mkdir()
            (other / "index.html").write_text("<title>other</title>")

            class Quiet(http.server.SimpleHTTPRequestHandler):
                def __init__(self, *arguments):
                    super().__init__(*arguments, directory=str(other))

                def log_message(self, *_):
                    pass

            with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Quiet) as server:
                threading.Thread(target=server.serve_forever, daemon=True).start()
                browser.new_page()
                browser.open(f"http://127.0.0.1:{server.server_port}/")
                for words in (
                    f'fetch("{address}results/secret.json")',
                    f'fetch("{address}state?page={name}", {{method: "POST", body: ""}})',
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
                    f'fetch("{address}start?page={name}", {{method: "POST", mode: "no-cors"}}).catch(() => 0)'
                )
                server.shutdown()
            assert not (tmp_path / "study/logs").exists()

    def test_scripts_of_a_report_reach_nothing(self, tmp_path):
        """A report of somebody else's study, with a script of theirs."""
        results = tmp_path / "study/results"
        results.mkdir(parents=True)
        (results / "report.html").write_text(
            "<body><a href='one.txt'>one</a><script>const say = text => { document.title += text };"
            "try { say(parent.document.title) } catch { say('no parent,') }"
            "fetch('../state?page=', {method: 'POST', body: '{}'})"
            ".then(() => say('an answer'), () => say('no answer'))"
            "</script></body>"
        )
        (results / "one.txt").write_text("the first")
        with served(tmp_path / "study") as address, Browser(tmp_path / "profile") as browser:
            browser.open(f"{address}results/report.html")
            browser.wait("document.title.includes('answer')")
            assert browser.evaluate("document.title").endswith("no answer")
            browser.evaluate("document.querySelector('a').click()")  # its links lead to files
            browser.wait("document.body.textContent.includes('the first')")

    def test_what_is_typed_stays_when_mistakes_come_and_go(self, tmp_path):
        with served(tmp_path / "study") as address, Browser(tmp_path / "profile") as browser:
            browser.open(address)
            browser.wait("document.querySelector('#preview pre')")
            fill(browser, "contact.bodies.0.material", "steel")
            wanted = "document.querySelector(\"[data-of='contact.bodies']\").textContent"
            browser.wait(f"{wanted}.includes('needs exactly two bodies')")
            field = "document.getElementById('contact.bodies.1.material')"
            browser.evaluate(f"{field}.focus()")
            for letter in "PEEK":
                browser.type(letter)
                browser.evaluate("new Promise(kept => setTimeout(kept, 250))")  # a check between
            browser.wait(f"!{wanted}")
            assert browser.evaluate(f"[{field}.value, document.activeElement === {field}]") == ["PEEK", True]

    def test_odd_names_of_files(self, tmp_path):
        """Marks of HTML, of shells and of addresses are no more than letters of a name."""
        files = []
        for name in (
            "a 'quote\".npy",
            "<script>alert(1)<!--.npy",
            "Grüße.npy",
            "a&b=c#d%20?.npy",
            "-dash.npy",
        ):
            files.append(tmp_path / name)
            np.save(files[-1], np.zeros((8, 8)))
        study = tmp_path / "a 'study' <b>"
        with served(study) as address, Browser(tmp_path / "profile") as browser:
            browser.open(address)
            browser.choose_files("#choose", *files)
            browser.wait("document.querySelectorAll('.row pre').length === 5")
            paths = browser.evaluate(
                "[...document.querySelectorAll('[name$=path]')].map(field => field.value)"
            )
            assert sorted(filter(None, paths)) == sorted(f"measured/{path.name}" for path in files)
            assert browser.evaluate("document.scripts.length") == 1
            assert browser.text("#problem") == ""
            assert browser.problems == []
        assert sorted(path.name for path in (study / "measured").iterdir()) == sorted(p.name for p in files)

    def test_keys_alone_and_narrow_screens(self, tmp_path):
        """From a folder with maps to the written study by Tab, Enter, Space and letters, 400 pixels wide."""
        study = tmp_path / "study"
        maps(study / "measured")
        with served(study) as address, Browser(tmp_path / "profile", width=400) as browser:
            browser.resize(400)
            browser.open(address)
            browser.wait("document.querySelector('#preview pre')")
            browser.tab_to("#path")
            browser.type("measured")
            browser.press("Enter")
            browser.wait("document.querySelectorAll('.row').length === 3")
            browser.wait("document.querySelectorAll('.row pre').length === 3")
            assert browser.text("#added") == "3 added; left out, as no measurements: none"
            # what the array does not say has a field for each
            for column, text in (("unit", "um"), ("dx", "1 um"), ("dy", "1 um")):
                browser.tab_to(f".row [name$='.{column}']")
                browser.type(text)
            for name, text in (("0.material", "steel"), ("1.material", "PEEK")):
                browser.tab_to(f"[name='contact.bodies.{name}']")
                browser.type(text)
            browser.tab_to("[data-list='contact.bodies.1.layers'] .more")
            browser.press("Enter")  # a layer, whose first field has the focus
            browser.wait("document.activeElement.name === 'contact.bodies.1.layers.0.material'")
            for name, text in (
                ("thickness", "2 um"),
                ("youngs_modulus", "1 GPa"),
                ("poissons_ratio", "0.4"),
                ("thermal_conductivity", "0.3"),
            ):
                browser.tab_to(f"[name='contact.bodies.1.layers.0.{name}']")
                browser.type(text)
            browser.tab_to("[name='contact.mean_pressure']")
            browser.type("1 MPa")
            browser.wait("!document.querySelector('#save').disabled")
            browser.tab_to("#save")
            browser.press("Enter")
            browser.wait("document.querySelector('#saved').textContent.includes('written')")
            bodies = yaml.safe_load((study / "config/config.yaml").read_text())["contact"]["bodies"]
            assert bodies[0] == {"material": "steel"}
            assert bodies[1]["layers"] == [
                {"thickness": "2 um", "youngs_modulus": "1 GPa", "poissons_ratio": 0.4}
                | {"thermal_conductivity": 0.3}
            ]
            for selector in ("#start", ".pick", "#remove", "summary"):
                browser.tab_to(selector)
            unnamed = (
                "[...document.querySelectorAll('input, select, textarea, button')].filter(field => "
                "field.type !== 'hidden' && "
                "!(field.labels?.length || field.ariaLabel || field.textContent)).length"
            )
            assert browser.evaluate(unnamed) == 0
            browser.evaluate("document.querySelectorAll('details').forEach(part => { part.open = true; })")
            assert browser.evaluate("document.documentElement.scrollWidth") <= 400
            picture(browser, "app-narrow")
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


def fields_of(page):
    fields = Fields()
    fields.feed(page)
    return fields.texts


class TestForm:
    """The form and the files stand for one another."""

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
    def test_settings_survive_the_form(self, config, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        maps(tmp_path / "measured")
        (tmp_path / "config").mkdir()
        (tmp_path / "config/config.yaml").write_text(yaml.safe_dump(config))
        (tmp_path / "config/surfaces.tsv").write_text("surface\tpath\none\tmeasured/one.x3p\n")
        sent = Page().after("write", QueryParams(urllib.parse.urlencode(fields_of(Page().first("a page")))))
        assert "written: config/config.yaml, config/surfaces.tsv" in sent
        written = (tmp_path / "config/config.yaml").read_text()
        assert resolve(yaml.safe_load(written)) == resolve(config)
        Page().after("write", QueryParams(urllib.parse.urlencode(fields_of(Page().first("a page")))))
        assert (tmp_path / "config/config.yaml").read_text() == written

    def test_columns_are_explained_by_columns_not_by_options(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        maps(tmp_path / "measured")
        (tmp_path / "config").mkdir()
        (tmp_path / "config/surfaces.tsv").write_text("surface\tpath\none\tmeasured/one.x3p\n")
        page = Page().first("a page")
        assert "unit of dx and dy, and of the heights without height_unit: m" in page
        assert "--height-unit" not in page

    def test_what_is_typed_into_a_list(self):
        bodies = {f"contact.bodies.{index}.material": "steel" for index in (0, 1)}
        for text, unload in (("true", []), ("1 MPa", [1e6]), ("1 MPa, 2e6", [1e6, 2e6])):
            files = check(bodies | {"contact.unload": text}, [])["files"]
            config = yaml.safe_load(files[CONFIG])
            assert resolve(config)[""]["contact"]["unload"] == unload

    def test_numbers_that_yaml_reads_otherwise_are_refused(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        for text, words in (
            ("010", "as octal"),
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
            page = get(address)[1]
            name = re.search(r'data-page="(\w+)"', page)[1]
            assert 'name="contact.bodys"' in page
            fields = {"rows.0.surface": "one", "rows.0.path": "measured/one.x3p"}
            fields["contact.contact_modulus"] = "1 GPa"

            def ask(action, **further):
                return get(f"{address}{action}?page={name}", method="POST", form=fields | further)[1]

            said = ask("write", **{"contact.bodys": "steel"})
            assert "nothing is written: correct first" in said
            assert "did you mean bodies?" in ask("check", **{"contact.bodys": "steel"})
            assert (study / "config/config.yaml").read_text() == note
            said = ask("write")
            assert "what was there is kept as config/config.yaml.before-page" in said
            assert "what was there is kept as config/surfaces.tsv.before-page" in said
            assert (study / "config/config.yaml.before-page").read_text() == note
            assert "what was there is kept" not in ask("write")  # by the page itself
            fields["rows.0.path"] = "measured/gone.x3p"
            assert "no such file; correct the path" in ask("check")
