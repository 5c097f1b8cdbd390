"""The workflow from the command line: settings and table to begin with, and what a run is refused for."""

import os
import re
import shutil
import socket
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import snakemake.io
import yaml

from roughcontact import SettingsError, height_map, write_dataset
from roughcontact.arguments.settings.messages import name_mistake
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.interface.program import main
from roughcontact.study import records, running
from roughcontact.study.plan import Plan
from roughcontact.study.run_lock import run_lock
from roughcontact.study.study import read_study
from roughcontact.study.table.read import read_surfaces
from roughcontact.study.yaml_text import check_yaml

CHECKOUT = Path(__file__).parents[2]
BODIES = ("--body", "210GPa", "0.3", "--body", "4GPa", "0.4", "0.3GPa")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_init_writes_settings_and_a_table_that_can_be_run(folder, capsys):
    for name in ("Ground 1.txt", "ground-1.csv", "ß.x3p", "Ground-1.nc"):
        (folder / name).write_text("1 2")
    assert main(["init", "Ground 1.txt", "Ground-1.nc", "ß.x3p", *BODIES, "--mean-pressure", "2MPa"]) == 0
    assert "3 surfaces" in capsys.readouterr().out
    (settings,) = resolve(yaml.safe_load((folder / "config/config.yaml").read_text())).values()
    assert [body["youngs_modulus"] for body in settings["contact"]["bodies"]] == [210e9, 4e9]
    assert (settings["contact"]["hardness"], settings["contact"]["mean_pressure"]) == (0.3e9, [2e6])
    surfaces = read_surfaces(settings["surfaces"])
    assert {name: str(row.path) for name, row in surfaces.items()} == {
        "Ground-1": "Ground 1.txt",
        "Ground-1-2": "Ground-1.nc",
        "ß": "ß.x3p",
    }


def test_init_takes_forces_a_form_a_group_and_looks_into_the_files(folder, capsys):
    np.save(folder / "a.npy", np.random.default_rng(0).normal(size=(16, 16)))
    words = ["--force", "5", "10", "N", "--form-radius", "5", "mm", "--group", "balls", "--lay", "none"]
    assert main(["init", "a.npy", *BODIES, *words]) == 0
    assert "a.npy: a map of 16 x 16 points that does not say its size" in capsys.readouterr().out
    (settings,) = resolve(yaml.safe_load((folder / "config/config.yaml").read_text())).values()
    assert settings["contact"]["force"] == [5.0, 10.0]
    assert (settings["contact"]["boundary"], settings["form"]["radius"]) == ("free", [5e-3])
    table = (folder / "config/surfaces.tsv").read_text().splitlines()
    assert table[-2:] == ["surface\tpath\tgroup\tlay", "a\ta.npy\tballs\tnone"]


def test_init_takes_courses_and_the_other_maps_of_a_face(folder):
    """Lists are numbers with their units behind one another; the map before has a row of its own."""
    for name in ("new.npy", "worn.npy"):
        np.save(folder / name, np.ones((4, 4)))
    slid = ["--wear", "coefficient=1e-7 mm³/(N m)", "distance=0.1 m 1 m 10 m", "--sliding", "speed=1e-3 0.1"]
    rubber = ["--body", "relaxation=EPDM-70", "--body", "steel", "hardness=null", "yield_stress=null"]
    maps = ["worn.npy", "--before", "new.npy", "--overview", "new.npy"]
    assert main(["init", *maps, *rubber, "--mean-pressure", "2MPa", *slid]) == 0
    written = yaml.safe_load((folder / "config/config.yaml").read_text())
    assert written["contact"]["bodies"][0] == {"relaxation": "EPDM-70"}
    assert written["contact"]["bodies"][1]["hardness"] is None
    (settings,) = resolve(written).values()
    assert (settings["wear"]["distance"], settings["sliding"]["speed"]) == ([0.1, 1.0, 10.0], [1e-3, 0.1])
    table = (folder / "config/surfaces.tsv").read_text().splitlines()
    cells = ["surface\tpath\tbefore\toverview", "new\tnew.npy\t\tnew.npy", "worn\tworn.npy\tnew\tnew.npy"]
    assert table[-3:] == cells


def test_two_groups_are_written_by_one_command(folder, capsys):
    for name in ("a1.npy", "a2.npy", "b1.npy", "b2.npy", "c.npy"):
        np.save(folder / name, np.random.default_rng(0).normal(size=(16, 16)))
    groups = ["--group", "A", "a1.npy", "a2.npy", "--group", "B", "b1.npy", "b2.npy", "--parts", "2x2"]
    assert main(["init", "c.npy", *groups, *BODIES, "--mean-pressure", "2MPa"]) == 0
    assert "5 surfaces" in capsys.readouterr().out
    head, *rows = (
        line.split("\t") for line in (folder / "config/surfaces.tsv").read_text().splitlines()[-6:]
    )
    assert head == ["surface", "path", "group", "parts"]
    assert {name: group for name, _, group, _ in rows} == {
        "c": "",
        "a1": "A",
        "a2": "A",
        "b1": "B",
        "b2": "B",
    }
    assert {parts for *_, parts in rows} == {"2x2"}


def test_a_file_is_in_one_group_alone(folder, capsys):
    np.save(folder / "a.npy", np.ones((4, 4)))
    assert main(["init", "--group", "A", "a.npy", "--group", "B", "a.npy", *BODIES]) == 2
    assert "--group B: a.npy is in A already" in capsys.readouterr().err


def test_what_is_given_again_adds_to_what_was_given(folder):
    """Each of several loads, and each key of a seal, may have an option of its own, as each body has."""
    np.save("a.npy", np.ones((4, 4)))
    loads = ("--mean-pressure", "1MPa", "--mean-pressure", "2MPa", "--allowed-pressure", "0.2GPa", "--unload")
    seal = [
        part
        for text in ("viscosity=1 mPa s", "pressure_difference=5bar", "width=3mm")
        for part in ("--seal", text)
    ]
    assert main(["init", "a.npy", *BODIES, *loads, *seal]) == 0
    (settings,) = resolve(yaml.safe_load(Path("config/config.yaml").read_text(encoding="utf-8"))).values()
    assert settings["contact"]["mean_pressure"] == [1e6, 2e6]
    assert settings["statistics"]["seal"]["pressure_difference"] == 5e5
    assert settings["statistics"]["allowed_pressure"] == 2e8
    assert settings["contact"]["unload"] is not None


def test_a_file_after_a_single_value_is_a_file(folder):
    np.save("a.npy", np.ones((4, 4)))
    assert main(["init", *BODIES, "--force", "20N", "--area", "3cm2", "a.npy"]) == 0
    (settings,) = resolve(yaml.safe_load(Path("config/config.yaml").read_text(encoding="utf-8"))).values()
    assert (settings["contact"]["force"], settings["contact"]["area"]) == ([20.0], 3e-4)
    assert Path("config/surfaces.tsv").read_text().splitlines()[-1] == "a\ta.npy"


def test_init_takes_resistivity_layers_and_a_film(folder):
    (folder / "pad.npy").write_text("1 2")
    joint = ("gas_conductivity=0.026", "temperature_jump=0.37um", "film_thickness=5nm", "film_conductivity=2")
    gold = "layer=2um,79GPa,0.42,electrical_resistivity=2.2e-8,thermal_conductivity=318"
    pad = ("--body", "copper", gold, "name=pad: gold, hard", "electrical_resistivity=1.7e-8")
    ball = ("--body", "gold", "thermal_conductivity=310")
    assert main(["init", "pad.npy", *pad, *ball, "--joint", *joint]) == 0
    (settings,) = resolve(yaml.safe_load((folder / "config/config.yaml").read_text())).values()
    body_a, body_b = settings["contact"]["bodies"]
    assert (body_a["name"], body_a["youngs_modulus"]) == ("pad: gold, hard", 115e9)
    assert (body_a["electrical_resistivity"], body_b["thermal_conductivity"]) == (1.7e-8, 310.0)
    (layer,) = body_a["layers"]
    assert (layer["youngs_modulus"], layer["electrical_resistivity"]) == (79e9, 2.2e-8)
    assert settings["statistics"]["joint"]["film_thickness"] == 5e-9


@pytest.mark.cases
def test_init_refuses_properties_that_are_unclear(folder, capsys, options, message):
    assert main(["init", "--body", "gold", *options]) == 2
    assert message in capsys.readouterr().err
    assert not (folder / "config").exists()


def test_init_makes_admitted_names_of_long_and_monotonous_ones(folder):
    files = [
        "g" * 100 + ".npy",
        "ground-" * 20 + ".npy",
        "long name " * 20 + "1.npy",
        "long name " * 20 + "2.npy",
    ]
    for name in files:
        (folder / name).write_text("1 2")
    assert main(["init", *files]) == 0
    surfaces = read_surfaces("config/surfaces.tsv")
    assert [str(row.path) for row in surfaces.values()] == files
    long = ("long-name-" * 6)[:56].strip("-")
    assert list(surfaces) == ["surface", ("ground-" * 20)[:56].strip("-"), long, f"{long}-2"]


@pytest.mark.parametrize("name", ["a" * 18, "g" * 63 + "h", "ab" * 18, "Ab-1" * 16, "0" * 18, "1-" * 9 + "1"])
def test_snakemake_takes_every_name_that_is_admitted(folder, name):
    """With the suffixes of a pair, and as the name of a case."""
    assert not name_mistake(name)
    detector = snakemake.io.PeriodicityDetector()
    suffixes = ("", "-1", "-11", "-111", "-face", "-counter-face")
    assert not any(detector.is_periodic(f"{name}{suffix}") for suffix in suffixes)


def test_names_of_64_letters_are_planned_by_snakemake(folder, capfd):
    np.save(folder / "a.npy", np.ones((4, 4)))
    (folder / "surfaces.tsv").write_text("surface\tpath\tdx\tdy\tunit\n" + "g" * 63 + "h\ta.npy\t1\t1\tum\n")
    case = "Ab-1" * 16
    (folder / "settings.yaml").write_text(
        f"surfaces: surfaces.tsv\ncontact: {{contact_modulus: 1e9}}\ncases: {{{case}: {{}}}}\n"
    )
    assert main(["run", "-n", "--configfile", "settings.yaml"]) == 0, capfd.readouterr().err


def test_what_the_command_line_states_is_laid_over_the_settings_of_the_folder(folder, capfd):
    np.save(folder / "a.npy", np.ones((4, 4)))
    table = "surface\tpath\tdx\tdy\tunit\n{}\ta.npy\t1\t1\tum\n"
    (folder / "config").mkdir()
    (folder / "config/config.yaml").write_text("surfaces: a.tsv\ncontact: {contact_modulus: 1e9}\n")
    for name in ("a", "b"):
        (folder / f"{name}.tsv").write_text(table.format(name))
    assert main(["run", "-n", "--config", "surfaces=b.tsv"]) == 0, capfd.readouterr().err
    assert "b: prepare, contact, draw" in capfd.readouterr().out


def test_init_writes_over_nothing(folder, capsys):
    (folder / "config").mkdir()
    (folder / "config/surfaces.tsv").write_text("mine")
    assert main(["init"]) == 2
    assert "config/surfaces.tsv already exists" in capsys.readouterr().err
    assert (folder / "config/surfaces.tsv").read_text() == "mine"
    assert not (folder / "config/config.yaml").exists()


def test_a_run_asks_for_materials_that_are_not_stated(folder, capfd):
    np.save(folder / "a.npy", np.ones((4, 4)))
    assert main(["init", "a.npy"]) == 0
    assert "under `contact`" in capfd.readouterr().out
    assert main(["run"]) != 0
    message = capfd.readouterr().err
    assert "mistakes in config/config.yaml:\n  contact: no elasticity given; " in message
    # what it says to write is accepted
    example = re.search(r"bodies: \[.*\]", message)[0]
    resolve(yaml.safe_load(f"contact: {{{example}}}"))
    assert not (folder / "results").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (BODIES[:3], "--body is given once; give it twice, one for each body"),
        (("--body", "210", "0.3", *BODIES[3:]), "--body[0].youngs_modulus = '210': "),
        (("--mean-pressure", "2MPa"), "contact: no elasticity given"),
    ],
)
def test_init_refuses_materials_that_a_run_would_refuse(folder, capsys, options, message):
    assert main(["init", *options]) == 2
    assert message in capsys.readouterr().err
    assert not (folder / "config").exists()


def test_init_takes_all_files_of_a_folder(folder, capsys):
    (folder / "measured").mkdir()
    for name in ("two.txt", "one.txt", ".hidden", "README.md", "values.json"):
        (folder / "measured" / name).write_text("1 2")
    (folder / "measured/CATALOG.tsv").write_text("file\tnx\none.txt\t2\n")
    (folder / "measured/three.txt").write_text("nan 2\n1 No Data\n")  # a point is missing in each row
    assert main(["init", "measured"]) == 0
    output = capsys.readouterr().out
    assert "3 surfaces" in output
    file_names = (f"measured{os.sep}{name}" for name in ("CATALOG.tsv", "README.md", "values.json"))
    assert f"left out, as no measurements: {', '.join(file_names)}" in output
    rows = (folder / "config/surfaces.tsv").read_text().splitlines()[-3:]
    assert rows == [f"{name}\tmeasured{os.sep}{name}.txt" for name in ("one", "three", "two")]


def test_init_names_a_file_that_is_not_there(folder, capsys):
    assert main(["init", "nowhere.x3p"]) == 2
    assert "nowhere.x3p: no such file" in capsys.readouterr().err
    assert not (folder / "config").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--configfile", "nowhere.yaml"], "--configfile nowhere.yaml: no such file"),
        ([], "(no config/config.yaml): `roughcontact init FILE ...` begins one"),
    ],
)
def test_a_run_that_cannot_begin_is_refused_in_a_sentence(monkeypatch, tmp_path, capsys, arguments, message):
    monkeypatch.setattr(running, "workflow_file", lambda: tmp_path / "package/workflow/Snakefile")
    assert main(["run", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.glob(".snakemake"))


def test_a_run_holds_its_file_and_so_does_what_it_starts(folder):
    """The lock is gone when both are, however they end; a run that comes to its end leaves no name."""
    running = folder / ".snakemake/running"
    with run_lock(folder) as lock:
        assert running.read_text() == f"{lock.name}\n"
        assert not lock.killed
        started = subprocess.Popen(
            [sys.executable, "-c", "input()"], stdin=subprocess.PIPE, pass_fds=lock.files
        )
        lock.ended = False  # as if Snakemake was killed
    at_work = rf"a run is at work there \(process {os.getpid()} on {socket.gethostname()}\): wait for its end"
    for unlocks in (False, True):
        with pytest.raises(SettingsError, match=at_work), run_lock(folder, unlocks=unlocks):
            pass
    started.communicate()
    with run_lock(folder) as lock:
        assert lock.killed
    assert running.read_text() == ""
    with run_lock(folder) as lock:
        assert not lock.killed


def test_a_killed_run_is_known_on_a_computer_whose_name_has_an_umlaut(folder, monkeypatch):
    monkeypatch.setattr(socket, "gethostname", lambda: "b\u00fcro")
    with run_lock(folder) as lock:
        lock.ended = False
    with run_lock(folder) as lock:
        assert lock.killed


def test_a_signal_is_heard_while_the_scheduler_holds_its_lock():
    """As it does while it looks after a job that has ended: the lock of Snakemake is not for two."""
    code = """
import os, signal
scheduler = object.__new__(JobScheduler)
scheduler._lock, scheduler._open_jobs = threading.Lock(), threading.Semaphore(0)
signal.signal(signal.SIGTERM, scheduler.exit_gracefully)
with scheduler._lock:
    os.kill(os.getpid(), signal.SIGTERM)
assert scheduler._open_jobs.acquire(timeout=30)
print(scheduler._user_kill)
"""
    command = [sys.executable, "-c", running._SNAKEMAKE.replace("\nmain()\n", code)]
    assert subprocess.check_output(command, text=True, timeout=60) == "graceful\n"


def test_a_run_on_another_computer_is_named_until_the_user_says_that_it_is_gone(folder):
    (folder / ".snakemake").mkdir(parents=True)
    (folder / ".snakemake/running").write_text("node-7 4711-1700000000\n")
    with (
        pytest.raises(SettingsError, match=r"on the computer node-7 \(process 4711\).*--unlock"),
        run_lock(folder),
    ):
        pass
    assert (folder / ".snakemake/running").read_text() == "node-7 4711-1700000000\n"
    with run_lock(folder, unlocks=True) as lock:
        assert lock.name
        assert not lock.killed


@pytest.mark.parametrize("option", ["-n", "-np", "--dry-run", "--summary", "--list-rules", "--dag=mermaid"])
def test_what_only_shows_something_is_not_held(option):
    assert running._DRY.fullmatch(option)


@pytest.mark.parametrize("option", ["-k", "-p", "--nolock", "--unlock", "-j4", "-sn", "--report-after-run"])
def test_what_runs_or_unlocks_is_held(option):
    assert not running._DRY.fullmatch(option)


def test_a_dry_run_holds_nothing(folder):
    np.save(folder / "a.npy", np.ones((4, 4)))
    assert main(["init", "a.npy", *BODIES]) == 0
    with run_lock(folder):
        assert main(["run", "-n", "--quiet"]) == 0
        assert main(["run", "--unlock"]) == 2


def test_options_of_a_run_go_to_snakemake(folder, capfd):
    (folder / "a.txt").write_text("1 2\n3 4\n")
    assert main(["init", "a.txt", *BODIES]) == 0
    assert main(["run", "-n", "--quiet", "all"]) == 0
    assert main(["run", "--no-such-option"]) != 0
    assert "--no-such-option" in capfd.readouterr().err
    assert not (folder / "results").exists()


def test_a_run_says_what_an_earlier_table_left(folder, capfd):
    (folder / "ground.txt").write_text("1 2\n3 4\n")
    assert main(["init", "ground.txt", *BODIES]) == 0
    for earlier in ("seat", "ground", "soft/seat"):
        (folder / "results" / earlier).mkdir(parents=True)
        (folder / "results" / earlier / "panel.html").touch()
    assert main(["run", "-n"]) == 0
    output = capfd.readouterr().out
    assert "Not in the table: results/seat, results/soft/seat. They stay" in output  # ground is


def test_results_of_another_folder_are_known_by_what_the_last_run_has_left(folder):
    np.save(folder / "a.npy", np.ones((4, 4)))
    assert main(["init", "a.npy", *BODIES]) == 0
    config = yaml.safe_load((folder / "config/config.yaml").read_text())
    plan = Plan(*read_study(config, ["."], measured_in=["."]))
    result = folder / "results/a/statistics.nc"
    write_dataset(height_map(np.eye(16), 1e-6), result)
    (folder / ".snakemake").mkdir()
    records.note_results(plan)
    assert records.replaced_files() == []
    shutil.copytree(folder, folder.with_name("moved"))
    write_dataset(height_map(np.ones((16, 16)), 1e-6), result)
    assert records.replaced_files() == ["results/a/statistics.nc"]
    for unknown in ("{", "{}"):  # as an interrupted run leaves it
        records.LAST_RESULTS.write_text(unknown)
        assert records.replaced_files() == []
    os.chdir(folder.with_name("moved"))
    assert records.replaced_files() == []


def test_a_dry_run_has_a_line_for_each_surface_or_lists_the_jobs_with_their_files(folder, capfd):
    np.save(folder / "a.npy", np.ones((4, 4)))
    assert main(["init", "a.npy", *BODIES]) == 0
    capfd.readouterr()
    assert main(["run", "-n"]) == 0
    lines = "".join(capfd.readouterr()).splitlines()
    assert lines == ["1 result, 5 jobs", "a: prepare, contact, draw", "This is a plan: nothing was done."]
    assert main(["run", "-n", "-p"]) == 0
    listed = "".join(capfd.readouterr())
    jobs = re.findall(r"^rule (\w+):\n    input: (.*)\n    output: (.*)$", listed, re.MULTILINE)
    files = {rule: (inputs.split(", "), outputs.split(", ")) for rule, inputs, outputs in jobs}
    prepared = [f"results/a/{name}.nc" for name in ("height", "levelled", "window")]
    assert files["prepare"] == (["a.npy"], prepared)
    assert files["contact"][0] == prepared
    assert "results/report.html" in files["report"][1]
    assert main(["run", "-n", "--quiet", "rules"]) == 0
    assert "rule prepare" not in "".join(capfd.readouterr())
    left = [path.name for path in (folder / ".snakemake").rglob("*") if path.is_file()]
    assert set(left) <= {"latest.pkl"}, "Snakemake's own"


@pytest.mark.cases
def test_a_configuration_that_cannot_be_read_is_named(folder, capsys, content, message):
    (folder / "settings.yaml").write_bytes(content)
    assert main(["run", "--configfile", "settings.yaml"]) == 2
    assert message in capsys.readouterr().err


def bomb(levels, times, line):
    """Return a text of a few lines that stands for `times` to the power of `levels` values."""
    lines = ["contact: {mean_pressure: 1}", f"x0: &x0 {line.replace('ALIASES', '1')}"]
    for level in range(1, levels + 1):
        aliases = ", ".join([f"*x{level - 1}"] * times)
        lines.append(f"x{level}: &x{level} {line.replace('ALIASES', aliases)}")
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (bomb(30, 3, "[ALIASES]"), ["more than 100000 values", "*name"]),
        ("contact:\n  bodies: &b [1, [*b]]\n", ["more than 100000 values", "*name"]),
        ("contact: &c\n  level: {again: *c}\n", ["more than 100000 values"]),
        ("contact:\n  mean_pressure: " + "9" * 5000, ["line 2: 99999999999999999999 is no valid int"]),
        ("contact:\n  mean_pressure: [1, 0x" + "9" * 5000 + "]", ["line 2: 0x", "is no valid int", "limit"]),
        (
            "a: 1\nb:\n  - !!python/object/apply:os.system [touch here]\n",
            ["line 3: is not valid YAML", "python/object/apply:os.system"],
        ),
        ("a: 1\nb: !!python/name:os.system\n", ["line 2: is not valid YAML", "python/name:os.system"]),
        ("a: 1\nb: 2011-13-45\n", ["line 2: 2011-13-45 is no valid timestamp", "put it in quotes"]),
        ("a: 1\nb: !!bool perhaps\n", ["line 2: perhaps is no valid bool"]),
        ("a: 1\n? [b]\n: 2\n", ["line 2: is not valid YAML"]),
        (
            "contact:\n  mean_pressure: 0100000\n",
            ["line 2: YAML reads 0100000 to the base of 8", "32768", "without leading zeros"],
        ),
        ("contact: {mean_pressure: [1, -010]}\n", ["YAML reads -010 ", "-8"]),
        ("cases:\n  0100: {}\n", ["line 2: YAML reads 0100 ", "64", "put it in quotes"]),
        ("level:\n  order: 1:30\n", ["line 2: YAML reads 1:30 to the base of 60", "90", "in quotes"]),
    ],
)
def test_a_configuration_that_grows_or_hides_a_value_is_refused_at_once(folder, capsys, content, message):
    (folder / "settings.yaml").write_text(content)
    start = time.process_time()
    tracemalloc.start()
    try:
        assert main(["run", "--configfile", "settings.yaml"]) == 2
        assert tracemalloc.get_traced_memory()[1] < 50e6
    finally:
        tracemalloc.stop()
    assert time.process_time() - start < 1 + 3  # tracing makes it slower
    text = capsys.readouterr().err
    assert "settings.yaml" in text
    for words in message:
        assert words in text
    assert len(text.splitlines()) == 1
    assert len(text) < 400
    assert not (folder / ".snakemake").exists()


@pytest.mark.parametrize(
    "text", ["'0100000'", "100000", "1e5", "0", "007", "0.5", "00.5", "0x10", "2011-07-23", "08"]
)
def test_decimal_numbers_and_quoted_text_are_admitted_and_octal_ones_are_not(folder, text):
    settings = folder / "settings.yaml"
    content = f"contact: &c {{mean_pressure: {text}}}\ncases: {{a: {{<<: *c}}}}\n"
    settings.write_text(content)
    check_yaml(settings)
    assert settings.read_text() == content  # looked at, and left as it is
    settings.write_text(content.replace(text, "0100000"))
    with pytest.raises(SettingsError, match="line 1: YAML reads 0100000 to the base of 8, here as 32768"):
        check_yaml(settings)


def test_a_configuration_of_aliases_is_looked_at_once(folder, capsys):
    # 2**60 values: what is looked for stands in the first line, and is come to last
    lines = ["contact: {mean_pressure: 1, mean_pressure: 2}", "a0: &a0 [1, 1]"]
    lines += [f"a{n}: &a{n} [*a{n - 1}, *a{n - 1}]" for n in range(1, 60)]
    (folder / "settings.yaml").write_text("\n".join(lines))
    assert main(["run", "--configfile", "settings.yaml"]) == 2
    assert "settings.yaml, line 1: mean_pressure occurs twice in the same group" in capsys.readouterr().err
