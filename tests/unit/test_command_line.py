"""The program: what it prints is what the verbs return, and bad input ends in one sentence."""

import argparse
import json
import os
import pty
import re
import shlex
import subprocess
import sys
import threading
import tomllib
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from known_surfaces import self_affine
from shared_data import DATA

import roughcontact as rc
from roughcontact import inspect_file, self_affine_surface, with_interval
from roughcontact.arguments.choices import UncertaintySource
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.quantities import quantity
from roughcontact.arguments.settings.models import Contact, Level, Uncertainty, Window
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.interface.command_line.describe import labelled_line
from roughcontact.interface.command_line.options import add_settings, chosen_settings, message_with_options
from roughcontact.interface.program import main

ROOT = Path(__file__).parents[2]
SAMPLES = ROOT / "data_samples"
GROUND = str(SAMPLES / "ground.txt")
PERIODIC = str(SAMPLES / "periodic.nc")
NO_BUDGET = ["--uncertainty-sources"]  # none of them: the ± takes most of the time of a run


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """Return the path of a map that is solved in no time."""
    path = tmp_path_factory.mktemp("maps") / "small.nc"
    height = self_affine((48, 64), 1e-6, (6e-6, 24e-6), rms_height=2e-7, seed=4)
    height.to_netcdf(path)
    return str(path)


def said(capsys, *arguments):
    """Return exit code, standard output and standard error of a run."""
    try:
        code = main(list(arguments))
    except SystemExit as error:  # by argparse
        code = error.code
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.parametrize(
    ("words", "loads"), [(["1MPa"], [1e6]), (["1MPa", "2e6"], [1e6, 2e6]), (["null"], None)]
)
def test_a_list_of_settings_is_an_option_with_several_values(words, loads):
    parser = argparse.ArgumentParser()
    add_settings(parser)
    options = parser.parse_args(["--body", "steel", "--body", "steel", "--mean-pressure", *words])
    assert chosen_settings(options)["contact"]["mean_pressure"] == loads


def test_what_solve_does_not_do_is_no_option(capsys):
    code, _, error = said(capsys, "solve", PERIODIC, "--body", "steel", "--body", "steel", "--unload", "true")
    assert code == 2
    assert "--unload" in error


def test_inspect_says_in_words_what_is_in_a_file(capsys):
    code, out, err = said(capsys, "inspect", str(SAMPLES / "sandblasted.x3p"))
    assert (code, err) == (0, "")
    contents = inspect_file(SAMPLES / "sandblasted.x3p")
    for words in (
        "X3P (ISO 25178-72)",
        "'height', the only channel",
        "256 × 256 points (x, y)",
        "256.0 µm × 256.0 µm",
        "1.000 µm",
        f"{contents['map']['missing_points']} points",
        "rms height",
        "rms gradient",
        "at the bottom of the picture (by its format)",
    ):
        assert words in out


def test_inspect_for_machines_is_what_inspect_file_returns(capsys):
    code, out, _ = said(capsys, "inspect", "--json", GROUND, PERIODIC)
    assert code == 0
    assert json.loads(out) == [json.loads(json.dumps(inspect_file(path))) for path in (GROUND, PERIODIC)]


def test_inspect_goes_on_after_a_file_that_is_none(capsys, tmp_path):
    (tmp_path / "letter.txt").write_text("Dear Sir,")
    code, out, err = said(capsys, "inspect", str(tmp_path / "letter.txt"), GROUND)
    assert code == 2
    assert "text without a table of numbers" in err
    assert len(err.strip().split("\n")) == 1
    assert "text matrix" in out


def test_inspect_tells_what_is_to_be_given_and_takes_it(capsys, tmp_path):
    np.save(tmp_path / "map.npy", np.random.default_rng(0).random((20, 30)))
    path = str(tmp_path / "map.npy")
    code, out, _ = said(capsys, "inspect", path)
    assert code == 0
    assert "to be given" in out
    assert "30 × 20 points" in out
    assert "unit not said" in out
    code, out, _ = said(
        capsys, "inspect", path, "--dx", "2", "--dy", "2", "--unit", "um", "--height-unit", "nm"
    )
    assert code == 0
    assert "60.00 µm × 40.00 µm" in out
    assert "to be given" not in out
    with_units = said(capsys, "inspect", path, "--dx", "2um", "--dy", "0.002 mm", "--height-unit", "nm")
    assert with_units == (0, out, "")
    mixed = said(
        capsys, "inspect", path, "--dx", "2", "--dy", "2000 nm", "--unit", "um", "--height-unit", "nm"
    )
    assert mixed == (0, out, "")
    # the unit of a step is not that of the heights
    assert "the unit of its heights" in said(capsys, "inspect", path, "--dx", "2um", "--dy", "2um")[1]
    _, out, err = said(capsys, "inspect", path, "--dx", "2", "--dy", "2um", "--height-unit", "nm")
    assert "dx = 2 is given without a unit" in out + err


def test_solve_says_what_a_contact_wider_than_its_map_is(capsys):
    form = ("--force", "5 N", "--form-radius", "50 mm", "--form-local-scale", "true")
    options = ("--body", "copper", "--body", "copper", *form, "--uncertainty-sources", "solver")
    code, out, err = said(capsys, "solve", PERIODIC, *options)
    assert code == 0, err
    line = " ".join(out[out.index("at 5.00 N") :].split())
    text = (
        r"at 5.00 N radius [\d.]+ µm, contact area .* µm², pressure in contact .*Pa, mean gap .*m, "
        r".*thermal resistance.* [mµ]?K/W, electrical resistance.*Ω"
    )
    assert re.match(text, line), line


def test_solve_gives_the_numbers_of_the_verbs(capsys):
    loads = ["2e4", "1e5"]
    options = ["--contact-modulus", "1e9", "--tolerance", "1e-5", "--level-form", "mean", *NO_BUDGET]
    code, out, err = said(capsys, "solve", PERIODIC, *options, "--mean-pressure", *loads, "--json")
    assert (code, err) == (0, "")
    result = json.loads(out)
    window = rc.periodic_window(rc.level(rc.read_height_map(PERIODIC), form="mean"))
    contact = rc.solve_contact(window, contact_modulus=1e9, mean_pressure=[2e4, 1e5], tolerance=1e-5)
    expected = rc.contact_statistics(contact)
    assert result["units"]["mean_gap"] == "m"
    assert result["settings"]["contact"]["tolerance"] == 1e-5
    for index, load in enumerate(result["loads"]):
        for name in ("relative_contact_area", "relative_contact_area_pixels", "max_pressure", "mean_gap"):
            assert load[name] == pytest.approx(float(expected[name][index]), rel=1e-6)
        assert 0 < load["error_bound"] <= 1e-5
        assert load["converged"] == 1
        assert isinstance(load["flags"], list)
        assert load["verdict"] in ("use", "review", "do not use")
        assert (load["verdict"] == "use") == (load["reasons"] == [])
    assert {check["outcome"] for check in result["checks"]} <= {"passed", "review", "failed", "not made"}
    assert result["verdict"] in ("use", "review", "do not use")


def test_solve_prints_a_table(capsys):
    bodies = ["--body", "2e9", "0", "--body", "2e9", "0"]
    code, out, err = said(capsys, "solve", PERIODIC, *bodies, *NO_BUDGET)
    assert (code, err) == (0, "")
    assert "Contact modulus E*  1.00 GPa" in out
    assert "answer            At " in out
    table = out.partition("\n\n")[2]
    rows = [line for line in table.split("\n") if "Pa" in line and line.count("%") == 1 and "µm" in line]
    assert len(rows) == 7  # the plan of loads, from 200 points in contact on
    for heading in ("mean pressure", "contact area", "mean gap", "pressure in contact"):
        assert heading in out
    for heading in ("seals?", "yields?", "largest pressure", "conductance"):  # nobody asked
        assert heading not in table.partition("verdict")[0]
    assert "verdict" in out


def test_several_files_are_solved_together(capsys, tmp_path):
    files = []
    for seed in (1, 2, 3):
        waves = {"hurst": 0.8, "shortest": 8e-6, "longest": 16e-6, "rms_gradient": 0.1 + 0.001 * seed}
        files.append(str(tmp_path / f"{seed}.npy"))
        np.save(files[-1], self_affine_surface((48, 48), 1e-6, **waves, seed=seed).values)
    options = ["--unit", "m", "--dx", "1e-6", "--dy", "1e-6", "--contact-modulus", "1GPa", *NO_BUDGET]
    code, out, err = said(capsys, "solve", *files, *options, "--mean-pressure", "5MPa", "--json")
    assert (code, err) == (0, "")
    result = json.loads(out)
    areas = [map_result["loads"][0]["relative_contact_area"] for map_result in result["maps"]]
    (load,) = result["group"]["loads"]
    assert load["relative_contact_area_lower"] < min(areas) < load["relative_contact_area"] < max(areas)
    assert load["relative_contact_area_next_upper"] > load["relative_contact_area_upper"]
    assert result["group"]["units"]["mean_gap_next_lower"] == "m"
    code, out, _ = said(capsys, "solve", *files, *options, "--mean-pressure", "5MPa")
    assert code == 0
    assert "3 maps together" in out
    assert "next map" in out
    code, out, _ = said(capsys, "solve", *files[:2], *options, "--mean-pressure", "5MPa")
    assert "range, from the lowest to the highest of the maps" in " ".join(out.split())
    assert "±" not in out
    # loads of their own leave each map its numbers
    code, out, _ = said(capsys, "solve", *files, *options, "--relative-pressure", "0.05")
    assert code == 0
    assert "no group          the group: no load in common" in out
    assert out.count("\n  contact area ") == 3


def test_a_long_label_stands_apart_from_its_text():
    assert labelled_line("serial number of scanner", "101-20-000") == "  serial number of scanner  101-20-000"
    assert labelled_line("format", "sdf") == "  format            sdf"


def test_numbers_may_carry_their_unit(capsys, small):
    bodies = ["--body", "210GPa", "0.3", "2 GPa", "--body", "4 kN/mm2", "0.4"]
    code, out, err = said(
        capsys, "solve", small, *bodies, *NO_BUDGET, "--mean-pressure", "1MPa", "5 bar", "--json"
    )
    assert (code, err) == (0, "")
    contact = json.loads(out)["settings"]["contact"]
    assert contact["contact_modulus"] == pytest.approx(1 / (0.91 / 2.1e11 + 0.84 / 4e9), rel=1e-12)
    assert contact["hardness"] == 2e9
    assert contact["mean_pressure"] == [1e6, 5e5]


def test_one_command_says_whether_a_seal_holds_and_writes_what_the_table_needs(capsys, small, tmp_path):
    words = ["--body", "NBR", "--body", "steel", "--mean-pressure", "0.5 MPa", "2 MPa", *NO_BUDGET]
    seal = ["viscosity=1 mPa s", "pressure_difference=0.1 MPa", "width=1 mm", "perimeter=0.1"]
    allowed = ["--seal", "allowed_leak=1 l/h", "--allowed-pressure", "1 GPa"]
    code, out, _ = said(capsys, "solve", small, *words, "--seal", *seal, *allowed)
    answer = " ".join(out.split())
    assert code == 0
    assert "Leak of at most 1000 ml/h: " in answer
    assert "Largest pressure of at most 1000 MPa: " in answer
    result = str(tmp_path / "result.nc")
    assert said(capsys, "solve", small, *words, "--flow", "always", "-o", result)[0] == 0
    assert "pressure_flow_factor_x" in said(capsys, "table", result)[1]


def test_solve_says_how_far_the_numbers_may_be_off(capsys, small):
    options = ["solve", small, "--contact-modulus", "1e9", "--relative-pressure", "0.05", "--threads", "1"]
    code, out, _ = said(capsys, *options, "--json")
    assert code == 0
    result = json.loads(out)
    verbs = result["settings"]
    levelled = rc.level(rc.read_height_map(small), **verbs["level"])
    window = rc.periodic_window(levelled, **verbs["window"])
    load = result["loads"][0]
    contact = {"contact_modulus": 1e9, "mean_pressure": [load["mean_pressure"]], "tolerance": 1e-4}
    budget = rc.error_budget(levelled, window, verbs | {"contact": contact})
    for name in ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure"):
        of_load = load[f"{name}_uncertainty"]
        assert list(of_load) == [*get_args(UncertaintySource), "combined"]
        for source, half_width in of_load.items():
            expected = budget[f"{name}_uncertainty"].sel(source=source)[0]
            assert (half_width is None) == np.isnan(expected)
            assert half_width is None or half_width == pytest.approx(float(expected), rel=1e-6)
        for side in ("lower", "upper"):
            expected = float(budget[f"{name}_{side}"][0])
            value = load[f"{name}_{side}"]
            assert value is None if np.isnan(expected) else value == pytest.approx(expected, rel=1e-6)
            assert result["units"][f"{name}_{side}"] == result["units"][name]
    area, *bounds = (100 * load[f"relative_contact_area{side}"] for side in ("", "_lower", "_upper"))
    _, out, _ = said(capsys, *options)
    text, _, interval = with_interval(area, *bounds).partition(" ")
    assert f" {text} %" in out
    assert f" {interval} " in out
    # as on the page, not the shortest diagonal wave of the grid
    assert f"  wavelengths       above {quantity(2 * spacing(window)[0], 'm')}" in out
    _, out, _ = said(capsys, *options, "--uncertainty-sources")  # none of them
    assert "±" not in out
    code, _, err = said(capsys, *options, "--uncertainty-sources", "luck")
    assert code == 2
    assert "--uncertainty-sources" in err


def test_an_empty_list_may_be_written_as_in_a_configuration():
    parser = argparse.ArgumentParser()
    add_settings(parser)
    for words in (["--uncertainty-sources"], ["--uncertainty-sources", "[]"]):
        settings = chosen_settings(parser.parse_args(["--contact-modulus", "1e9", *words]))
        assert settings["uncertainty"]["sources"] == []


def test_a_profile_is_solved(capsys):
    path = str(SAMPLES / "stylus-profile.csv")
    code, out, _ = said(capsys, "solve", path, "--contact-modulus", "1e11", "--relative-pressure", "0.1")
    assert code == 0
    assert "profile of" in out


@pytest.mark.cases
def test_bad_input_ends_with_code_2_and_one_sentence(capsys, line, words):
    line = line.replace("{E}", "solve {P} --contact-modulus 1e9")
    code, out, err = said(capsys, *(word.format(P=PERIODIC, G=GROUND) for word in shlex.split(line)))
    assert (code, out) == (2, "")
    assert words in err
    assert len(err.strip().split("\n")) == 1
    assert err.startswith("roughcontact")


def test_a_load_that_misses_the_tolerance_ends_with_code_1(capsys, monkeypatch):
    def missed(*_, **__):
        raise rc.ConvergenceError("mean pressure 1e5 Pa: the error bound stopped at 2e-4")

    monkeypatch.setattr("roughcontact.evaluation.pipeline.solve_contact", missed)
    code, out, err = said(capsys, "solve", PERIODIC, "--contact-modulus", "1e9", "--mean-pressure", "1e5")
    assert (code, out) == (1, "")
    assert err == "roughcontact: mean pressure 1e5 Pa: the error bound stopped at 2e-4\n"


def test_files_after_a_body_are_not_its_properties(capsys, tmp_path):
    path = tmp_path / "map.npy"
    path.touch()
    code, _, err = said(capsys, "init", "--body", "steel", "--body", "PEEK", str(path))
    assert (code, err) == (2, f"roughcontact: --body PEEK {path}: {path} is a file; files go before --body\n")


def test_every_setting_of_the_stages_is_an_option(capsys):
    assert said(capsys, "solve", "--help")[0] == 0
    main_help = said(capsys, "solve", "--help")[1]
    sections = {"": Contact, "level-": Level, "window-": Window, "uncertainty-": Uncertainty}
    for prefix, model in sections.items():
        for key in set(model.model_fields) - {"bodies", "keep_fields", "unload"}:
            assert f"--{prefix}{key.replace('_', '-')}" in main_help


def test_messages_speak_of_options():
    with pytest.raises(rc.SettingsError) as caught:
        resolve({"contact": {"contact_modulus": 0}, "level": {"fill": "x"}, "window": {"width": 2}})
    sentence = message_with_options(caught.value)
    assert "\n" not in sentence
    for option in ("--contact-modulus = 0", "--level-fill = 'x'", "--window-width = 2"):
        assert option in sentence


def test_only_the_settings_that_are_wrong_become_options():
    with pytest.raises(rc.SettingsError) as caught:
        resolve({"contact": {"contact_modulus": 1e9, "influence": "x"}})
    sentence = message_with_options(caught.value)
    assert sentence.startswith("--influence = 'x'")
    assert "elastic influence function" in sentence


def run(*command):
    """Run a command of this Python in a process of its own."""
    environment = os.environ | {"PYTHONPATH": str(ROOT / "workflow/lib")}
    return subprocess.run(
        [sys.executable, *command], env=environment, capture_output=True, text=True, check=False
    )


def test_a_mark_that_turns_the_direction_of_a_name_is_shown_as_an_escape(tmp_path):
    path = tmp_path / "a\u202ecod.txt"
    path.write_text("Width: 4 um\nHeight: 2 um\nValue units: nm\n1 2 3 4\n5 6 7 8\n")
    for command in (["inspect", path], ["inspect", path, "--json"], ["inspect", f"{path}\u2067"]):
        process = run("-m", "roughcontact.interface", *command)
        assert "a\\u202ecod.txt" in process.stdout + process.stderr
        assert not {*"\u202e\u2067"} & {*process.stdout, *process.stderr}


def test_no_bar_where_nobody_looks(small):
    options = ["--contact-modulus", "1e9", "--mean-pressure", "1e5", *NO_BUDGET]
    process = run("-m", "roughcontact.interface", "solve", small, *options)
    assert process.returncode == 0
    assert "mean pressure" in process.stdout
    assert process.stderr == ""


def test_an_interruption_while_modules_are_imported_is_one_line():
    """The installed program and `python -m` are the same module, which imports all others itself."""
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["scripts"]
    assert scripts == {"roughcontact": "roughcontact.interface.__main__:main"}
    interrupted = """
import runpy, sys

class Interruption:
    def find_spec(self, name, *_):
        if name == "roughcontact.interface.program":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interruption())
runpy.run_module("roughcontact.interface", run_name="__main__")
"""
    process = run("-c", interrupted)
    assert (process.returncode, process.stdout) == (130, "")
    assert process.stderr == "roughcontact: interrupted\n"


@pytest.mark.parametrize(
    "samples", [["ground.txt", "sandblasted.x3p", "stylus-profile.csv"], ["periodic.nc"]]
)
def test_inspect_waits_for_nothing_that_it_does_not_need(samples):
    """What takes long to import is left to `solve` and to the report; xarray opens netCDF files by SciPy."""
    program = "import sys; from roughcontact.interface.program import main; main(sys.argv[1:]); "
    process = run(
        "-c",
        f"{program} print(*sys.modules, sep='\\n')",
        "inspect",
        *(str(SAMPLES / name) for name in samples),
    )
    assert process.returncode == 0, process.stderr
    loaded = set(process.stdout.split("\n"))
    assert "roughcontact.io.inspection" in loaded
    slow = {"matplotlib", "SurfaceTopography", "pydantic", "rich", "jinja2", "PIL"}
    slow |= set() if "periodic.nc" in samples else {"scipy"}
    assert loaded & slow == set()


@pytest.mark.parametrize(("loads", "bar"), [(["0.05", "0.2"], "2 of 2 loads"), (["0.05"], "1 of 1 loads")])
def test_a_bar_on_a_terminal(capsys, monkeypatch, small, loads, bar):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    master, slave = pty.openpty()
    pieces = []

    def read():
        """Empty the terminal while the program writes, which would else wait for a reader."""
        try:
            while piece := os.read(master, 4096):
                pieces.append(piece)
        except OSError:  # the other end was closed
            pass

    reader = threading.Thread(target=read)
    reader.start()
    with os.fdopen(slave, "w", encoding="utf-8") as terminal, monkeypatch.context() as patch:
        patch.setattr(sys, "stderr", terminal)
        options = ["--contact-modulus", "1e9", *NO_BUDGET, "--relative-pressure", *loads]
        code, out, _ = said(capsys, "solve", small, *options)
    reader.join()
    os.close(master)
    on_terminal = b"".join(pieces).decode()
    assert code == 0
    assert bar in on_terminal
    assert "⠋" in on_terminal  # turns
    assert "mean pressure" in out
    assert "loads" not in out  # the numbers are not mixed with the bar


@pytest.mark.shared_data
def test_real_files_are_inspected_or_refused_in_one_sentence(capsys):
    paths = sorted(path for path in DATA.iterdir() if path.suffix not in (".md", ".tsv", ".json"))
    for path in paths:
        code, out, err = said(capsys, "inspect", str(path))
        assert (code == 0) == (path.name in out), path.name
        assert err.count("\n") == (code == 2), path.name


@pytest.mark.shared_data
def test_lens_date_and_serial_are_printed(capsys):
    _, out, _ = said(capsys, "inspect", str(DATA / "metropro-1.dat"))
    for words in (
        "optical profiler",
        "Zygo",
        "59407",
        "20X Mirau",
        "2011-07-23T16:49:36",
        "suspicion         ",
    ):
        assert words in out
    _, out, _ = said(capsys, "inspect", str(DATA / "mi-1.mi"))
    assert "'Topography', the first height channel of 4" in out
    assert "values in V, no length" in out


@pytest.mark.parametrize("words", [["inspect"], ["init"], ["run", "--configfile"], ["run", "-d"], ["crate"]])
def test_a_path_too_long_for_any_file_is_one_sentence(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*words, "a" * 5000]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"roughcontact: {'a' * 60}...: ")
    assert len(line) < 300


def test_a_folder_has_a_line_for_each_file(capsys, tmp_path):
    np.save(tmp_path / "bare.npy", np.zeros((3, 4)))
    (tmp_path / "map.txt").write_text("Width: 4 um\nHeight: 2 um\nValue units: nm\n1 2 3 4\n5 6 8 7\n")
    (tmp_path / "cut.x3p").write_bytes(b"PK\x03\x04 and no more")
    (tmp_path / "README.md").write_text("1 2 3\n")
    code, out, _ = said(capsys, "inspect", str(tmp_path))
    lines = {line.split()[0]: line for line in out.splitlines()[2:]}
    assert code == 0
    assert list(lines) == ["bare.npy", "cut.x3p", "map.txt"]
    assert "NumPy array  4 × 3" in lines["bare.npy"]
    assert "give dx, dy, unit" in lines["bare.npy"]
    assert "a ZIP archive (X3P, PLUX, ...) without its end" in lines["cut.x3p"]
    assert str(tmp_path) not in lines["cut.x3p"]
    assert "text matrix  4 × 2   4.000 µm × 2.000 µm  487 pm  nothing" in lines["map.txt"]
    entries = json.loads(said(capsys, "inspect", "--json", str(tmp_path))[1])
    assert [entry["file"] for entry in entries] == list(lines)


def test_warnings_of_a_solution_are_sentences_without_a_place_in_the_source(capsys, tmp_path):
    (tmp_path / "map.txt").write_text(
        "Width: 4 um\nHeight: 3 um\nValue units: nm\n1 9 3 4\n5 6 8 7\n5 3 4 9\n"
    )
    options = ("--contact-modulus", "1e9", "--mean-pressure", "1e6", *NO_BUDGET)
    _, _, err = said(capsys, "solve", str(tmp_path / "map.txt"), *options)
    assert "roughcontact: warning: the map has 3 x 4 points: that is no rough surface" in err
    assert "HeightMapWarning" not in err
    assert ".py" not in err


@pytest.mark.parametrize("verb", ["inspect", "solve", "init", "run", "app", "methods", "table", "compare"])
def test_every_help_ends_with_an_example(verb, capsys):
    with pytest.raises(SystemExit):
        main([verb, "--help"])
    assert f"Example: roughcontact {verb}" in capsys.readouterr().out


def test_the_help_of_init_names_the_keys_of_a_seal_and_a_joint(capsys):
    with pytest.raises(SystemExit):
        main(["init", "--help"])
    out = capsys.readouterr().out
    assert all(f"{key}=" in out for key in ("viscosity", "pressure_difference", "width", "[gas_conductivity"))
