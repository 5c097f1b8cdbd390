"""Files of `roughcontact solve FILE -o RESULT`: the numbers of `evaluate`, or the maps of the solver."""

import re
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import openpyxl
import pandas as pd
import pytest
import tifffile
import xarray as xr
from PIL import Image

import roughcontact as rc
from roughcontact.arguments.answers import AREA, TITLES
from roughcontact.arguments.quantities import percent
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.evaluation.pipeline import run_chain
from roughcontact.interface.program import main
from roughcontact.results.exchange import write_tiff, write_workbook

CONTACT = {"contact_modulus": 1e9, "mean_pressure": [2e7, 5e6]}
OPTIONS = ["--contact-modulus", "1e9", "--mean-pressure", "2e7", "5e6", "--uncertainty-sources", "solver"]
MAPS = ["height", *(f"{name}_{load}" for load in (1, 2) for name in ("pressure", "gap", "contact"))]


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """Return the path of a map that is not square in any way."""
    path = tmp_path_factory.mktemp("maps") / "small 1.nc"
    waves = {"hurst": 0.8, "shortest": 6e-6, "longest": 24e-6, "rms_height": 2e-7}
    rc.self_affine_surface((48, 64), (1.5e-6, 1e-6), **waves, seed=4).to_netcdf(path)
    return path


def saved(measured, folder, ending):
    """Return the file that the program has written, the only one of its folder."""
    path = folder / f"new/result{ending}"
    assert main(["solve", str(measured), *OPTIONS, "-o", str(path)]) == 0
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]
    return path


def test_numbers_are_those_of_evaluate(measured, tmp_path):
    statistics = rc.evaluate(measured, contact=CONTACT, uncertainty={"sources": ["solver"]})
    path = saved(measured, tmp_path, ".nc")
    assert rc.read_dataset(path).broadcast_equals(statistics)
    assert "roughcontact.read_statistics(path)" in statistics.attrs["comment"]
    chosen = rc.read_statistics(path).sel(mean_pressure=4e6, method="nearest")  # as it says
    assert chosen["mean_gap"].item() == statistics["mean_gap"][1].item()
    table = pd.read_csv(saved(measured, tmp_path / "csv", ".csv"))
    assert set(table["surface"]) == {"small-1"}
    for name in ("mean_pressure", "mean_gap_lower", "max_pressure"):
        unit = "m" if "gap" in name else "Pa"
        assert table[f"{name}_{unit}"].values == pytest.approx(statistics[name].values, rel=1e-9)


def test_the_page_stands_by_itself(measured, tmp_path):
    text = saved(measured, tmp_path, ".html").read_text(encoding="utf-8")
    statistics = rc.evaluate(measured, contact=CONTACT, uncertainty={"sources": []})
    assert percent(float(statistics["relative_contact_area_pixels"][0])).replace(" ", "") in re.sub(
        r"\s", "", text
    )
    assert "small-1" in text
    # no word of files that lie beside the page of a run
    assert not re.search(r'href="[^"#:]*\.(nc|csv)"', text)
    assert "beside this page" not in text


def test_the_figure_is_drawn(measured, tmp_path):
    with Image.open(saved(measured, tmp_path, ".png")) as picture:
        assert picture.size == (1512, 1224)
        assert len(np.unique(np.asarray(picture.convert("L")))) > 100


def test_maps_are_those_of_the_solver(measured, tmp_path):
    window = rc.periodic_window(rc.level(rc.read_height_map(measured)))
    solved = rc.solve_contact(window, **CONTACT)
    expected_maps = [solved["height"].values]
    expected_maps += [solved[name].values[load] for load in (0, 1) for name in ("pressure", "gap", "contact")]
    size = tuple(reversed(window.shape))

    head, _, data = saved(measured, tmp_path, ".vti").read_bytes().partition(b"\n_")
    tree = ElementTree.fromstring(head + b"</AppendedData></VTKFile>")
    image = tree.find("ImageData")
    assert image.get("WholeExtent") == f"0 {size[0] - 1} 0 {size[1] - 1} 0 0"
    assert [float(step) for step in image.get("Spacing").split()] == pytest.approx([1e-6, 1.5e-6, 1e-6])
    assert [float(load) for load in image.find("FieldData/DataArray").text.split()] == [2e7, 5e6]
    arrays = image.findall("Piece/PointData/DataArray")
    assert [array.get("Name") for array in arrays] == MAPS
    for array, values in zip(arrays, expected_maps, strict=True):
        start = int(array.get("offset"))
        (room,) = np.frombuffer(data, "<u8", 1, start)
        assert room == 8 * values.size
        assert (np.frombuffer(data, "<f8", values.size, start + 8).reshape(values.shape) == values).all()

    with tifffile.TiffFile(saved(measured, tmp_path / "tiff", ".tiff")) as file:
        for page, name, values in zip(file.pages, MAPS, expected_maps, strict=True):
            assert page.description.startswith(name.partition("_")[0])
            assert (page.asarray()[::-1] == values.astype(np.float32)).all()
            assert page.resolutionunit == 3  # by centimetre
            assert np.array(page.resolution) == pytest.approx([1e4, 1e4 / 1.5], rel=1e-6)
        assert "at a mean pressure of 5e+06 Pa" in file.pages[4].description


def test_the_first_sheet_of_the_workbook_has_the_answers_for_people(measured, tmp_path):
    statistics = rc.read_statistics(saved(measured, tmp_path / "nc", ".nc"))
    sheets = pd.read_excel(saved(measured, tmp_path, ".xlsx"), sheet_name=None)
    assert next(iter(sheets)) == "answers"
    answers = sheets["answers"]
    areas = answers[answers["answer"] == TITLES[AREA]]
    order = statistics["mean_pressure"].argsort().values
    value, upper = (100 * statistics[f"{AREA}{end}"].values[order] for end in ("", "_upper"))
    assert areas["value"].astype(float).to_numpy() == pytest.approx(value)
    assert set(areas["unit"]) == {"%"}
    assert areas["+"].to_numpy() == pytest.approx(upper - value)
    assert "seals?" in set(answers["answer"])


def test_the_workbook_has_the_columns_of_the_summary_and_the_settings(measured, tmp_path):
    sheets = pd.read_excel(saved(measured, tmp_path, ".xlsx"), sheet_name=None)
    assert list(sheets) == ["answers", "summary", "uncertainty", "settings"]
    summary = pd.read_csv(saved(measured, tmp_path / "csv", ".csv"))
    pd.testing.assert_frame_equal(sheets["summary"], summary, check_dtype=False, rtol=1e-9)
    assert {"solver", "combined"} == set(sheets["uncertainty"]["source"])
    settings = sheets["settings"].set_index("setting")["value"]
    assert settings["level.form"] == "plane"
    assert float(settings["contact.contact_modulus"]) == 1e9


def test_the_simple_field_is_the_pressure_at_the_largest_load(measured, tmp_path):
    content = saved(measured, tmp_path, ".gsf").read_bytes()
    head = content[: content.index(b"\0")].decode()
    fields = dict(line.split(" = ") for line in head.splitlines()[1:])
    assert head.startswith("Gwyddion Simple Field 1.0\n")
    assert (fields["ZUnits"], fields["XYUnits"], fields["Title"]) == ("Pa", "m", "pressure")
    window = rc.periodic_window(rc.level(rc.read_height_map(measured)))
    pressure = rc.solve_contact(window, **CONTACT)["pressure"].values[0]
    assert (int(fields["YRes"]), int(fields["XRes"])) == pressure.shape
    assert float(fields["YReal"]) == pytest.approx(1.5e-6 * len(pressure))
    start = len(head) + 4 - len(head) % 4  # zeros up to a multiple of four
    picture = np.frombuffer(content, "<f4", offset=start).reshape(pressure.shape)
    assert (picture[::-1] == pressure.astype(np.float32)).all()  # the upper row comes first


def test_maps_of_a_kept_file_are_written_too(tmp_path, monkeypatch):
    """A library call; what no TIFF holds is refused before anything is written."""
    solved = rc.solve_contact(
        rc.self_affine_surface((8, 8), 1.0, hurst=0.5, shortest=4, longest=8, rms_height=1.0, seed=1),
        contact_modulus=1.0,
        mean_pressure=1.0,
    )
    monkeypatch.setattr("roughcontact.results.exchange._MAX_TIFF_BYTES", 1000)
    with pytest.raises(rc.SettingsError, match=r"1.02e-06 GB, a TIFF holds 4 GB: choose .vti"):
        write_tiff(solved, tmp_path / "maps.tiff")
    assert not list(tmp_path.iterdir())


def test_nothing_is_printed_where_maps_are_written_as_tiff(tmp_path):
    """In development mode, since Python 3.13 always, an error while a stream is deleted is printed."""
    lines = (
        "import roughcontact as rc",
        "from roughcontact.results.exchange import write_tiff",
        "surface = rc.self_affine_surface((16, 16), 1.0, hurst=0.5, shortest=4, longest=8, rms_height=1.0)",
        "write_tiff(rc.solve_contact(surface, contact_modulus=1.0, mean_pressure=0.1), 'maps.tiff')",
    )
    command = [sys.executable, "-X", "dev", "-W", "ignore", "-c", "\n".join(lines)]
    process = subprocess.run(command, check=False, cwd=tmp_path, capture_output=True, text=True)
    assert (process.returncode, process.stderr) == (0, "")
    assert tifffile.TiffFile(tmp_path / "maps.tiff").pages[3].shape == (16, 16)


@pytest.mark.cases
def test_what_cannot_be_written_is_refused_before_anything_is_solved(
    measured, capsys, monkeypatch, files, output, message
):
    monkeypatch.chdir(measured.parent)
    (measured.parent / "folder.nc").mkdir(exist_ok=True)
    content_before = measured.read_bytes()
    assert main(["solve", *[str(measured)] * files, *OPTIONS, "-o", output]) == 2
    assert capsys.readouterr() == ("", f"roughcontact: -o {output}: {message}\n") or message.endswith(".nc")
    assert measured.read_bytes() == content_before


def test_a_load_that_misses_the_tolerance_writes_nothing(measured, tmp_path, capsys):
    tight = ["--tolerance", "1e-15"]
    assert main(["solve", str(measured), *OPTIONS, *tight, "-o", str(tmp_path / "result.nc")]) == 1
    assert "tolerance" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("ending", [".csv", ".xlsx", ".png", ".vti", ".tiff", ".gsf"])
def test_a_finished_run_is_exported_as_solve_writes_it(measured, tmp_path, ending):
    settings = resolve({"contact": CONTACT, "uncertainty": {"sources": ["solver"]}})[""]
    run = tmp_path / "results/small-1"
    run.mkdir(parents=True)
    chain = run_chain(rc.read_height_map(measured), settings, fields=run / "contact.nc")
    rc.write_dataset(chain.statistics, run / "statistics.nc")
    path = tmp_path / f"exported/small{ending}"
    assert main(["export", str(run), "-o", str(path)]) == 0
    of_solve = saved(measured, tmp_path, ending)
    if ending == ".xlsx":
        for name, sheet in pd.read_excel(of_solve, sheet_name=None).items():
            pd.testing.assert_frame_equal(pd.read_excel(path, sheet_name=name), sheet)
    elif ending == ".png":  # its title is the name of the file there, of the surface here
        with Image.open(path) as picture, Image.open(of_solve) as picture_of_solve:
            assert picture.size == picture_of_solve.size
            assert np.mean(np.asarray(picture) != np.asarray(picture_of_solve)) < 0.01
    else:
        assert path.read_bytes() == of_solve.read_bytes()


@pytest.mark.parametrize(
    ("word", "cell"),
    [
        ('=HYPERLINK("http://evil","c")', '\'=HYPERLINK("http://evil","c")'),
        ("+1", "'+1"),
        ("@SUM(1)", "'@SUM(1)"),
        ("a\x1b[31mb\x00", "a\ufffd[31mb\ufffd"),
        ("\x1b=1", "\ufffd=1"),
        ("not UTF-8 \udcff, \uffff", "not UTF-8 \ufffd, \ufffd"),
        ("two\nlines", "two\nlines"),
    ],
)
def test_a_word_of_a_file_is_no_formula_and_no_control_character_in_a_workbook(tmp_path, word, cell):
    write_workbook({"settings": pd.DataFrame({"setting": ["channel"], "value": [word]})}, tmp_path / "a.xlsx")
    (_, (_, written)) = openpyxl.load_workbook(tmp_path / "a.xlsx")["settings"].iter_rows()
    assert (written.data_type, written.value) == ("s", cell)


def test_the_workbook_has_the_instrument_of_the_table(measured, tmp_path):
    """Columns of the table of surfaces prevail over the settings, and are no part of them."""
    settings = resolve({"contact": CONTACT, "instrument": {"noise": 2e-9}})[""]
    chain = run_chain(rc.read_height_map(measured, instrument={"noise": 5e-9}), settings)
    rc.write_dataset(chain.statistics, tmp_path / "small-1/statistics.nc")
    assert main(["export", str(tmp_path / "small-1"), "-o", str(tmp_path / "small.xlsx")]) == 0
    setting_values = pd.read_excel(tmp_path / "small.xlsx", sheet_name="settings").set_index("setting")[
        "value"
    ]
    assert float(setting_values["instrument.noise"]) == 2e-9
    assert float(setting_values["instrument.noise of this map"]) == 5e-9


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("one.html", "-o one.html: end it with one of .csv, .xlsx, .png, .vti, .tiff, .gsf"),
        (
            "one.csv",
            "nowhere/statistics.nc: no such file; name the statistics.nc in the folder of one surface",
        ),
    ],
)
def test_what_cannot_be_exported(tmp_path, capsys, monkeypatch, output, message):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "nowhere", "-o", output]) == 2
    assert capsys.readouterr().err == f"roughcontact: {message}\n"


def test_the_folder_of_a_whole_run_is_no_single_result(tmp_path, capsys):
    whole = xr.Dataset(coords={"surface": ["a", "b"], "mean_pressure": ("load", [1e6])})
    rc.write_dataset(whole, tmp_path / "statistics.nc")
    assert main(["export", str(tmp_path), "-o", str(tmp_path / "all.csv")]) == 2
    assert "is of all surfaces; name the statistics.nc in the folder of one" in capsys.readouterr().err
    assert not (tmp_path / "all.csv").exists()
    rc.write_dataset(xr.Dataset(coords={"mean_pressure": ("load", [1e6])}), tmp_path / "statistics.nc")
    assert main(["export", str(tmp_path), "-o", str(tmp_path / "maps.vti")]) == 2
    assert (
        "has no contact.nc; name the folder of the first case with the same contact"
        in capsys.readouterr().err
    )


def test_maps_that_a_run_has_not_kept(measured, tmp_path, capsys):
    contact = rc.solve_contact(rc.periodic_window(rc.level(rc.read_height_map(measured))), **CONTACT)
    rc.write_dataset(contact[["mean_pressure"]], tmp_path / "contact.nc")
    rc.write_dataset(rc.evaluate(measured, contact=CONTACT), tmp_path / "statistics.nc")
    assert main(["export", str(tmp_path), "-o", str(tmp_path / "maps.vti")]) == 2
    assert "has no maps; set contact.keep_fields to true and run again" in capsys.readouterr().err
    assert not (tmp_path / "maps.vti").exists()
