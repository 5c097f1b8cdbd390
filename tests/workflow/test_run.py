"""What a run leaves, what a second run does, and what an edit runs again."""

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tomllib
from contextlib import contextmanager, suppress

import numpy as np
import psutil
import pytest
import xarray as xr
from small_project import QUICK, ROOT, SETTINGS, TABLE, Project, counted, project_with_maps

from roughcontact import evaluate, read_dataset, read_height_map, write_dataset
from roughcontact.arguments.settings.resolve import resolve

EPSILON = np.finfo(float).eps
EACH = ["height.nc", "levelled.nc", "window.nc", "contact.nc", "uncertainty.nc", "statistics.nc"]
EACH += ["panel.html", "panel.json"]
FILES = [
    "statistics.nc",
    "summary.csv",
    "uncertainty.csv",
    "report.html",
    *(f"{s}/{f}" for s in ("ground", "turned") for f in EACH),
]
DRAWN = {"panel": 2, "report": 1}
FROM_CONTACT = {"contact": 2, **DRAWN}
FROM_PREPARE = {"prepare": 2, **FROM_CONTACT}
OF_ONE = dict.fromkeys(FROM_PREPARE, 1)


def files_of(project):
    """Return the files below results, named from there."""
    root = project.path("results")
    return {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}


@contextmanager
def edited(path, old, new):
    """Replace a piece of a file and put it back at the end, with the time it had."""
    times, text = path.stat(), path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    yield
    path.write_text(text)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def test_a_run_leaves_every_file_and_no_other(finished):
    assert files_of(finished) == set(FILES)


def test_a_run_shows_how_far_it_has_come(finished):
    for line in ("[contact ground] load 1 of 2", "[contact turned] load 2 of 2", "8 of 8 steps (100%) done"):
        assert line in finished.first.stderr
    assert "load 2 of 2" in finished.path("logs/ground/contact.log").read_text()


def test_the_short_screen_has_a_line_for_each_surface(finished_quickly):
    output = finished_quickly.first.stderr.partition("2 results, 8 jobs\n")[2]
    lines = [
        r"(ground|turned): done \(1 of 2.*\)\. At .* MPa: contact area .*",
        r"(ground|turned): done \(2 of 2.*\)\. At .* MPa: contact area .*",
        r"At .* MPa.*: contact area from .* to .*\.",
        r"done in .*: results/report\.html",
    ]
    assert re.fullmatch("\n".join(lines), output.strip())


def test_the_numbers_are_those_of_evaluate(finished):
    (settings,) = resolve(SETTINGS).values()
    sections = {name: settings[name] for name in ("level", "window", "statistics", "uncertainty")}
    statistics = evaluate(
        read_height_map(finished.path("measured/turned.txt"), unit="um", dx=1.0, dy=1.0),
        contact=SETTINGS["contact"],
        **sections,
    )
    written = read_dataset(finished.path("results/turned/statistics.nc"))
    assert {*statistics.variables} == {*written.variables}
    for name in statistics.variables:
        if written[name].dtype.kind == "f":  # sums of the flow depend on where arrays lie in memory
            np.testing.assert_allclose(statistics[name], written[name], rtol=4 * EPSILON, err_msg=name)
        else:
            np.testing.assert_array_equal(statistics[name], written[name], err_msg=name)
    assert statistics.attrs["verdicts"] == written.attrs["verdicts"]
    assert statistics.attrs["reasons"] == written.attrs["reasons"]
    assert written["verdict"].attrs["flag_meanings"] == "use review do_not_use"


def test_every_file_carries_settings_versions_and_checksum(finished):
    for surface, name in (("ground", "ground.npy"), ("turned", "turned.txt")):
        checksum = hashlib.sha256(finished.path(f"measured/{name}").read_bytes()).hexdigest()
        for file in EACH[:-2]:  # netCDF
            attrs = read_dataset(finished.path(f"results/{surface}/{file}")).attrs
            assert attrs["source_sha256"] == checksum
            assert json.loads(attrs["settings"])["surface"]["name"] == surface
            assert {"roughcontact", "numpy"} <= set(json.loads(attrs["versions"]))
    attrs = read_dataset(finished.path("results/statistics.nc")).attrs
    assert json.loads(attrs["source_sha256"])["turned"] == checksum
    assert json.loads(attrs["settings"])["contact"]["contact_modulus"] == 1e9


def test_the_table_of_surfaces_reaches_the_map(finished):
    ground = read_dataset(finished.path("results/ground/height.nc"))
    assert float(ground["y"][1] - ground["y"][0]) == pytest.approx(1e-6)
    assert float(ground["x"][1] - ground["x"][0]) == pytest.approx(2e-6)


def test_the_summary_has_a_row_for_each_surface_and_load(finished):
    rows = finished.rows("summary.csv")
    assert [(row["surface"], float(row["relative_pressure"])) for row in rows] == [
        (surface, pytest.approx(load)) for surface in ("ground", "turned") for load in (0.05, 0.2)
    ]
    for row in rows:
        assert 0 < float(row["relative_contact_area"]) < float(row["relative_contact_area_pixels"]) < 1
        assert float(row["error_bound"]) < 1e-6
    # E* = 1 GPa, no hardness: at p' = 0.2 and g = 0.1 metals would flow, and the table says so of every load
    assert {row["verdict"] for row in rows} <= {"use", "review", "do not use"}
    for row in rows:
        flows = float(row["mean_contact_pressure_Pa"]) > 1e7 or float(row["max_pressure_Pa"]) > 3e7
        assert ("Plasticity: At " in row["reasons"]) == flows
        assert (row["verdict"] == "use") == (row["reasons"] == "")
    assert "metals would flow" in rows[-1]["reasons"]


def test_a_second_run_does_nothing(finished):
    second_run = finished.run()
    assert second_run.returncode == 0
    assert "Nothing to be done" in second_run.stderr


def test_results_without_the_records_of_snakemake_are_made_again(finished, tmp_path, checkout):
    """Snakemake itself compares dates alone then, and lets results of other settings stay."""
    copy = Project(tmp_path / "copy", checkout)
    for name in ("measured", "results"):
        shutil.copytree(finished.path(name), copy.path(name), dirs_exist_ok=True)
    copy.write(SETTINGS | {"contact": SETTINGS["contact"] | {"contact_modulus": "2e9"}})
    run = copy.run("--dry-run")
    assert counted(run) == FROM_PREPARE
    assert "Without a record of Snakemake, made again: 'results/ground/height.nc', " in run.stderr
    assert copy.jobs() == FROM_PREPARE
    complete = shutil.copytree(finished.folder, tmp_path / "complete")
    assert Project(complete, checkout).jobs().keys() <= {"report"}  # whose panels are too large to compare
    # those of another folder, copied over results that Snakemake has records of
    statistics = complete / "results/ground/statistics.nc"
    write_dataset(read_dataset(statistics).assign_attrs(settings="{}"), statistics)
    run = Project(complete, checkout).run("--dry-run")
    assert counted(run) == {"contact": 1, "panel": 1, "report": 1}
    assert "Not left by the last run here, made again: 'results/ground/statistics.nc'\n" in run.stderr


def test_a_result_that_was_deleted_is_made_again(finished, tmp_path, checkout):
    """Although the report, which was made of it, is newer than all that remains."""
    folder = shutil.copytree(finished.folder, tmp_path / "copy")
    shutil.rmtree(folder / "results/ground")
    assert Project(folder, checkout).jobs() == OF_ONE


def test_a_run_that_ended_after_the_window_goes_on_whatever_the_dates(finished, tmp_path, checkout):
    folder = shutil.copytree(finished.folder, tmp_path / "copy")
    project, measured = Project(folder, checkout), folder / "measured/turned.txt"
    measured.write_text(measured.read_text().replace("-", "", 1))
    project.succeed("results/turned/window.nc")
    for name in ("contact.nc", "uncertainty.nc", "statistics.nc", "panel.html", "panel.json"):
        os.utime(folder / "results/turned" / name)
    assert project.jobs() == {"contact": 1, "panel": 1, "report": 1}


def test_planning_a_run_imports_nothing_that_computes():
    """So that a run with nothing to do ends at once: what it imports is all that makes it wait."""
    rules = "\n".join(path.read_text() for path in (ROOT / "workflow/rules").glob("*.smk"))
    imports = re.findall(r"^from roughcontact\S* import (?:\([^)]*\)|.+)$", rules, re.MULTILINE)
    assert len(imports) > 3
    program = "\n".join([*imports, "import sys", "print(*sys.modules)"])
    environment = os.environ | {"PYTHONPATH": str(ROOT / "workflow/lib")}
    run = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
    )
    assert not {"scipy", "xarray", "pandas", "matplotlib"} & set(run.stdout.split())


EVALUATE = """import roughcontact
waves = {"hurst": 0.8, "rms_gradient": 0.1, "longest": 16e-6, "shortest": 4e-6}
window = roughcontact.self_affine_surface((32, 32), 1e-6, **waves)
roughcontact.evaluate(window, contact_modulus=1e9, mean_pressure=1e6)
"""
IMPORTED = {"numpy", "pandas", "scipy", "xarray"}  # pandas is xarray's own


@pytest.mark.parametrize(
    ("statements", "packages"),
    [
        ("import roughcontact.evaluation", set()),
        ("import roughcontact.evaluation.pipeline", IMPORTED),
        (EVALUATE, IMPORTED | {"pydantic", "scipy.fft", "scipy.ndimage", "scipy.special", "scipy.linalg"}),
    ],
)
def test_what_takes_long_to_import_is_imported_where_it_is_used(statements, packages):
    """Each of these, and each part of SciPy, takes a tenth of a second and more of every process."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    names = {re.match(r"[\w-]+", line)[0].replace("-", "_") for line in project["dependencies"]} | {"PIL"}
    loaded, parts = modules_after(statements)
    # an older SciPy imports more of its parts in others
    brought, _ = modules_after(f"import {', '.join(packages | {'numpy', 'scipy'})}")
    assert loaded & (names | {f"scipy.{part}" for part in parts}) <= brought


def modules_after(statements):
    """Return the modules that a process has after some statements, and the parts that SciPy has."""
    code = f"{statements}\nimport sys, scipy; print(*sys.modules); print(*scipy.__all__)"
    environment = os.environ | {"PYTHONPATH": str(ROOT / "workflow/lib")}
    run = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    return [set(line.split()) for line in run.stdout.splitlines()]


@pytest.mark.slow
def test_an_equal_run_elsewhere_leaves_equal_bytes(finished, tmp_path, checkout):
    project = Project(tmp_path / "second", checkout)
    for name in ("measured", "settings.yaml", "surfaces.tsv"):
        source, target = finished.path(name), project.path(name)
        shutil.copytree(source, target, dirs_exist_ok=True) if source.is_dir() else shutil.copy(
            source, target
        )
    project.succeed()
    for name in FILES:
        assert (
            project.path(f"results/{name}").read_bytes() == finished.path(f"results/{name}").read_bytes()
        ), name


@pytest.mark.parametrize(
    ("section", "change", "expected"),
    [
        ("level", {"form": "mean"}, FROM_PREPARE),
        ("contact", {"tolerance": 1e-5}, FROM_CONTACT),
        ("statistics", {"gap_bins": 7}, FROM_CONTACT),
        ("uncertainty", {"sources": ["solver"]}, FROM_CONTACT),
        ("report", {"title": "Another title"}, {"report": 1}),
    ],
)
def test_an_edited_setting_reruns_what_depends_on_it(finished, section, change, expected):
    finished.write(SETTINGS | {section: SETTINGS.get(section, {}) | change})
    jobs = finished.jobs()
    finished.write()
    assert jobs == expected


def test_what_means_the_same_reruns_nothing(finished, checkout):
    """Values written in another way, a row that moved, a file that was touched, modules that no job imports.

    Of files below a megabyte Snakemake compares the contents.
    """
    contact = {"relative_pressure": ["5e-2", 0.2], "contact_modulus": 1000000000, "tolerance": 1e-6}
    settings = SETTINGS | {"contact": contact, "level": {"form": "plane"}}
    finished.write(settings, ["# measured in May", *TABLE])
    os.utime(finished.path("measured/ground.npy"))
    package = checkout / "workflow/lib/roughcontact"
    with (
        edited(package / "io/readers/sdf.py", "\n", "\n\n"),
        edited(package / "arguments/settings/models.py", "\n", "\n\n"),
    ):
        jobs = finished.jobs()
    finished.write()
    assert jobs == {}


def test_pitches_that_changed_places_rerun_that_surface(finished):
    finished.write(table=[TABLE[0], TABLE[1].replace("2\t1", "1\t2"), TABLE[2]])
    jobs = finished.jobs()
    finished.write()
    assert jobs == OF_ONE


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        ("surface/levelling/level.py", FROM_PREPARE),
        ("contact/solve.py", FROM_CONTACT),
        ("report/page.py", {"report": 1}),
        ("report/templates/panel.html", DRAWN),
        ("io/readers/npy.py", OF_ONE),
    ],
)
def test_an_edited_file_of_the_package_reruns_what_depends_on_it(finished, checkout, file, expected):
    """Which files a script depends on is in tests/unit/test_dependencies.py."""
    path = checkout / "workflow/lib/roughcontact" / file
    with edited(path, "\n", "\n\n"):
        assert finished.jobs() == expected


def test_an_edited_measurement_reruns_that_surface(finished):
    with edited(finished.path("measured/turned.txt"), "\n", "\n "):
        jobs = finished.jobs()
    assert jobs == OF_ONE


@contextmanager
def replaced(path, *, seconds):
    """Put another map of the same size and that date in the place of one, and put it back at the end."""
    aside, replacement = path.with_name("aside.npy"), path.with_name("another.npy")
    np.save(replacement, 5 * np.load(path))
    os.utime(replacement, (seconds, seconds))
    path.replace(aside)
    replacement.replace(path)
    yield
    aside.replace(path)


@pytest.mark.parametrize("date", ["older", "the same"])
def test_a_measurement_that_was_replaced_reruns_whatever_the_date_of_the_other(finished, date):
    path = finished.path("measured/ground.npy")
    size, seconds = path.stat().st_size, 1e9 if date == "older" else path.stat().st_mtime
    with replaced(path, seconds=seconds):
        assert path.stat().st_size == size
        assert finished.jobs() == OF_ONE


def test_a_measurement_that_is_replaced_at_work_leaves_no_result(project):
    path = project.path("measured/turned.txt")
    target = "results/turned/levelled.nc"
    run = project.start(target)
    jobs = project.wait_for(run, lambda: [job for job in family(run) if ".prepare.py" in " ".join(job)])
    os.kill(int(jobs[0][0]), signal.SIGSTOP)
    path.write_text(path.read_text().replace("-", "", 1))
    os.utime(path, (1e9, 1e9))
    os.kill(int(jobs[0][0]), signal.SIGCONT)
    assert run.wait()
    output = project.path("said").read_text()
    assert "[prepare turned] ERROR: measured/turned.txt: changed while " in output
    assert not list(project.path("results").rglob("*.nc"))
    project.succeed(target)
    checksum = hashlib.sha256(path.read_bytes()).hexdigest()
    assert read_dataset(project.path(target)).attrs["source_sha256"] == checksum


def family(run):
    """Return number and command line of all processes that a run has started."""
    processes = []
    for process in run.children(recursive=True):
        with suppress(psutil.Error):
            processes.append([str(process.pid), *process.cmdline()])
    return processes


CASES = {
    "base": {},
    "binned": {"statistics": {"gap_bins": 5}},
    "no-maps": {"contact": {"keep_fields": False}},
}


@pytest.fixture(scope="module")
def study(tmp_path_factory, checkout):
    """A project with cases in which the workflow has run once, on one surface."""
    settings = SETTINGS | {"cases": CASES}
    project = project_with_maps(tmp_path_factory.mktemp("study") / "project", checkout, settings, TABLE[:2])
    project.first = project.succeed()
    return project


def test_a_case_computes_only_what_it_changes(study):
    assert counted(study.first) == {"prepare": 1, "contact": 2, "statistics": 1, "panel": 3, "report": 1}
    assert "Nothing to be done" in study.run().stderr


def test_a_case_has_the_files_that_differ_from_those_of_earlier_cases_and_names_the_others(study):
    missing = {
        "base": set(),
        "binned": {"height", "levelled", "window", "contact"},
        "no-maps": {"height", "levelled", "window", "uncertainty"},
    }
    assert files_of(study) == {"statistics.nc", "summary.csv", "uncertainty.csv", "report.html"} | {
        f"{case}/ground/{name}"
        for case, names in missing.items()
        for name in EACH
        if name.removesuffix(".nc") not in names - {"uncertainty"}
    }
    for case, names in missing.items():
        attrs = read_dataset(study.path(f"results/{case}/ground/statistics.nc")).attrs
        used = json.loads(attrs.get("files_of_cases", "{}"))
        assert set(used.values()) == ({"base"} if names else set())
        assert set(used) == names | ({"uncertainty"} if names else set())
    page = study.path("results/report.html").read_text(encoding="utf-8")
    files = re.findall(r'<a class="file" href="([^"]*)"', page)
    assert {f"{case}/ground/statistics.nc" for case in CASES} <= set(files)
    assert {"base/ground/contact.nc", "no-maps/ground/contact.nc", "base/ground/window.nc"} <= set(files)
    assert all(study.path(f"results/{file}").is_file() for file in files)


def test_without_fields_the_numbers_are_the_same(study):
    full, lean = (
        read_dataset(study.path(f"results/{case}/ground/statistics.nc")) for case in ("base", "no-maps")
    )
    xr.testing.assert_equal(full, lean)
    contact = read_dataset(study.path("results/no-maps/ground/contact.nc"))
    assert not {"pressure", "gap", "contact"} & set(contact.variables)
    assert contact["error_bound"].equals(
        read_dataset(study.path("results/base/ground/contact.nc"))["error_bound"]
    )


def test_the_summary_compares_the_cases(study):
    rows = study.rows("summary.csv")
    assert [row["case"] for row in rows] == [case for case in CASES for _ in range(2)]
    areas = [row["relative_contact_area"] for row in rows]
    assert areas[:2] == areas[2:4] == areas[4:]


def test_a_change_of_one_case_reruns_that_case(study):
    changed = CASES | {"binned": {"statistics": {"gap_bins": 6}}}
    study.write(SETTINGS | {"cases": changed}, TABLE[:2])
    jobs = study.jobs()
    study.write(SETTINGS | {"cases": CASES}, TABLE[:2])
    assert jobs == {"statistics": 1, "panel": 1, "report": 1}


def test_a_case_that_shares_again_has_no_file_of_its_own_of_before(study, tmp_path, checkout):
    """`export` would draw its maps."""
    project = Project(shutil.copytree(study.folder, tmp_path / "copy"), checkout)
    own_contact, shared = (project.path(f"results/{case}/ground/contact.nc") for case in ("binned", "base"))
    shutil.copy(shared, own_contact)
    project.write(SETTINGS | {"cases": CASES | {"binned": {"statistics": {"gap_bins": 7}}}}, TABLE[:2])
    project.succeed()
    assert shared.exists()
    assert not own_contact.exists()


def test_braces_in_names_of_files_and_in_the_title_stay(project):
    """Snakemake would take them for wildcards: `{surface}.npy` is neither a mistake nor ground.npy."""
    rows = [
        TABLE[0],
        TABLE[1].replace("ground.npy", "{surface}.npy"),
        TABLE[2].replace("turned.txt", "t{a,}.txt"),
    ]
    project.path("measured/turned.txt").rename(project.path("measured/t{a,}.txt"))
    heights = np.load(project.path("measured/ground.npy"))
    np.save(project.path("measured/{surface}.npy"), 2 * heights)
    project.write(QUICK | {"report": {"title": "Ra {um} of {surface}"}}, rows)
    project.succeed()
    assert "Ra {um} of {surface}" in project.path("results/report.html").read_text()
    height = read_dataset(project.path("results/ground/height.nc"))["height"].values
    assert np.ptp(height) == pytest.approx(2e-6 * np.ptp(heights))
    assert project.jobs() == {}
    np.save(project.path("measured/{surface}.npy"), heights)
    assert project.jobs() == {"prepare": 1, "contact": 1, "panel": 1, "report": 1}
