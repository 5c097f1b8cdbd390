"""The table of surfaces: what it says is read, what is wrong is listed at once."""

import inspect
import re

import pytest

from roughcontact import SettingsError, read_height_map
from roughcontact.arguments.settings.messages import NAME, name_mistake
from roughcontact.interface.command_line.project import surface_names, write_project
from roughcontact.io.request import FILE_OPTIONS, Request
from roughcontact.study.places import find_file
from roughcontact.study.table.columns import (
    BEFORE,
    COLUMNS,
    GROUP,
    INSTRUMENT,
    OVERVIEW,
    OVERVIEW_POSITION,
    PAIR,
    PAIR_FIRST_ROW,
    REGION,
    REPEAT,
    REQUIRED,
    SPECIMEN,
    TILES,
)
from roughcontact.study.table.pairs import placements
from roughcontact.study.table.read import measured, read_surfaces
from roughcontact.study.table.same_area import same_area_pairs
from roughcontact.study.table.text import table_text


@pytest.fixture
def table(tmp_path):
    """Return a function that writes a table and returns its path."""

    def write(*lines):
        path = tmp_path / "surfaces.tsv"
        path.write_text("\n".join(lines), encoding="utf-8")
        return path

    return write


def mistakes(path, **options):
    """Return the message that reading `path` provokes."""
    with pytest.raises(SettingsError) as caught:
        read_surfaces(path, **options)
    return str(caught.value)


def test_rows_comments_and_optional_columns(table, tmp_path):
    (tmp_path / "a.txt").touch()
    path = table(
        "# made by hand",
        "surface\tpath\tdx\tunit\tchannel",
        "ground-1\ta.txt\t1e-3\tmm\t",
        "#left-out\tb.txt",
        "",
        "turned\tmissing.x3p\t\t\tHeight",
    )
    surfaces = read_surfaces(path)
    assert list(surfaces) == ["ground-1", "turned"]
    assert surfaces["ground-1"].read_arguments == {"dx": 1e-3, "unit": "mm"}
    assert surfaces["ground-1"].path == tmp_path / "a.txt"
    assert surfaces["ground-1"].origin == f"{path}, line 3"
    assert surfaces["turned"].read_arguments == {"channel": "Height"}
    assert not surfaces["turned"].path.exists()


def test_a_row_with_a_counter_face_is_a_pair(table, tmp_path):
    (tmp_path / "b.txt").touch()
    path = table(
        "surface\tpath\tcounter_face\tunit", "one\ta.txt\t\tum", "seal\ta.txt\tb.txt\tmm", "z\tb.txt\t\t"
    )
    surfaces = read_surfaces(path)
    assert list(surfaces) == ["one", "seal", "z"]
    files = measured(surfaces)
    assert list(files) == ["one", "seal-face", "seal-counter-face", "z"]
    assert files["seal-counter-face"].path == tmp_path / "b.txt"
    assert files["seal-face"].read_arguments == files["seal-counter-face"].read_arguments == {"unit": "mm"}
    assert files["seal-face"].origin == f"{path}, line 3"
    placements_by_name = placements(surfaces, 2)
    assert list(placements_by_name) == ["seal-1", "seal-2"]
    assert (placements_by_name["seal-2"].pair, placements_by_name["seal-2"].number) == ("seal", 2)
    assert (placements_by_name["seal-2"].face, placements_by_name["seal-2"].counter_face) == (
        "seal-face",
        "seal-counter-face",
    )


@pytest.mark.parametrize(
    ("name", "clash"),
    [("seal-2", True), ("Seal-30", True), ("seal-face", True), ("seal-counter-face", True)]
    + [(name, False) for name in ("seal-0", "seal-03", "seal-3-b", "seals-3", "seal-b", "counter-face")],
)
def test_a_name_that_a_pair_needs(table, name, clash):
    path = table("surface\tpath\tcounter_face", "seal\ta\tb", f"{name}\tc")
    if not clash:
        assert len(placements(read_surfaces(path), 2)) == 2
        return
    with pytest.raises(SettingsError, match=f"line 3, surface = {name}: the pair seal "):
        read_surfaces(path)


def test_the_working_directory_comes_before_the_folder_of_the_table(table, tmp_path, monkeypatch):
    work = tmp_path / "work"
    work.mkdir()
    (tmp_path / "a.txt").write_text("beside the table")
    path = table("surface\tpath", "a\ta.txt")
    monkeypatch.chdir(work)
    assert read_surfaces(path)["a"].path.read_text() == "beside the table"
    (work / "a.txt").write_text("here")
    assert read_surfaces(path)["a"].path.read_text() == "here"
    assert str(find_file("a.txt", [".", tmp_path])) == "a.txt"
    assert find_file(tmp_path / "a.txt", ["."]) == tmp_path / "a.txt"


def test_mark_at_the_start_and_line_ends_of_other_systems(tmp_path):
    path = tmp_path / "surfaces.tsv"
    path.write_bytes(b"\xef\xbb\xbfsurface\tpath\r\na\ta.txt\r\n")
    assert read_surfaces(path)["a"].path.name == "a.txt"


def test_all_mistakes_at_once(table):
    path = table(
        "surface\tpath\tdx\tdy",
        "a b\ta.txt\t1\t1",
        "c\t\t0,5\t-1",
        "d\td.txt\t1\t1\textra",
        "d\te.txt\tinf\t",
    )
    message = mistakes(path)
    for part in (
        "line 2, surface = 'a b'",
        "line 3, path = '': names no file; give that of surface c",
        "line 3, dx = '0,5': ",
        "line 3, dy = '-1'",
        "line 4: 5 cells, the header has 4",
        f"line 5, surface = d: occurs twice (also {path}, line 4); rename one",
        "line 5, dx = 'inf'",
    ):
        assert f"\n  {part}" in message
    assert message.split("\n")[0] == f"mistakes in the table of surfaces {path}:"
    assert len(message.split("\n")) == 8


@pytest.mark.cases
def test_tables_that_are_none(table, lines, message):
    assert message in mistakes(table(*lines))


def test_a_missing_table_is_named(tmp_path):
    assert "nowhere.tsv: no such file; correct `surfaces` in the settings" in mistakes(
        tmp_path / "nowhere.tsv"
    )


@pytest.mark.parametrize("verb", [read_height_map, Request])
def test_columns_and_options_are_the_arguments_of_reading(verb):
    arguments = [name for name in inspect.signature(verb).parameters if name not in ("path", "instrument")]
    of_the_study = {
        *REQUIRED,
        GROUP,
        SPECIMEN,
        TILES,
        PAIR,
        PAIR_FIRST_ROW,
        BEFORE,
        REPEAT,
        OVERVIEW,
        OVERVIEW_POSITION,
        OVERVIEW_POSITION,
        *REGION,
    }
    assert set(COLUMNS) - of_the_study - {*INSTRUMENT} == set(arguments)
    assert [name.replace("-", "_") for name in FILE_OPTIONS] == arguments


def test_each_file_of_a_pair_has_its_own_first_row(table):
    header = "surface\tpath\tunit\tfirst_row\tcounter_face\tcounter_face_first_row"
    files = measured(
        read_surfaces(table(header, "a\ta.npy\tum\ttop\tb.npy\t", "c\tc.npy\tum\t\td.npy\tbottom"))
    )
    assert [
        files[name].read_arguments for name in ("a-face", "a-counter-face", "c-face", "c-counter-face")
    ] == [
        {"unit": "um", "first_row": "top"},
        {"unit": "um"},
        {"unit": "um"},
        {"unit": "um", "first_row": "bottom"},
    ]


def test_a_row_that_ends_early_is_named(table):
    message = mistakes(table("path\tsurface", "a.txt"))
    assert message.split("\n")[1:] == [
        "  line 2, surface = '': a name has letters, digits and hyphens only (it becomes a folder)"
    ]


@pytest.mark.cases
def test_names_that_snakemake_cannot_take_are_named(table, name, message):
    text = mistakes(table("surface\tpath", f"{name}\ta.txt"))
    assert f"line 2, surface = '{name}': " in text
    assert message in text


def test_cells_are_stripped_and_empty_ones_beyond_the_header_are_none(table):
    surface = read_surfaces(table(" surface\tpath \tunit", " a \t a.txt\t \t\t"))["a"]
    assert (surface.name, surface.path.name, surface.read_arguments) == ("a", "a.txt", {})
    assert surface.files() == [surface]


def test_further_folders_come_after_that_of_the_table(table, tmp_path, monkeypatch):
    names = ("first", "second", "third")
    for name in names:
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.txt").write_text(name)
    path = tmp_path / "second" / "surfaces.tsv"
    path.write_text("surface\tpath\tcounter_face\na\ta.txt\ta.txt")
    for name in names:
        row = read_surfaces(path, [tmp_path / "first", tmp_path / "third"])["a"]
        assert row.path.read_text() == row.files()[1].path.read_text() == name
        (tmp_path / name / "a.txt").unlink()
    row = read_surfaces(path, [tmp_path / "first", tmp_path / "third"])["a"]
    assert (str(row.path), str(row.files()[1].path)) == ("a.txt", "a.txt")


@pytest.mark.parametrize("number", ["0", "-0.0", "nan", "inf", "1 parsec", "-1 um", "0 um", "1,5 um", "true"])
def test_pitches_are_positive_numbers(table, number):
    message = mistakes(table("surface\tpath\tdx", f"a\ta.txt\t{number}"))
    assert f"line 2, dx = '{number}': " in message


def test_pitches_may_carry_their_unit(table):
    path = table("surface\tpath\tdx\tdy\tunit", "a\ta.txt\t1.5 um\t2\tmm", "b\tb.txt\t3\t0.5 µm\t")
    arguments_by_name = {name: surface.read_arguments for name, surface in read_surfaces(path).items()}
    assert arguments_by_name["a"] == {"unit": "mm", "dx": "1.5 um", "dy": 2.0}
    assert arguments_by_name["b"] == {"dx": 3.0, "dy": "0.5 µm"}


def test_names_that_are_one_folder_on_other_systems_are_named(table):
    path = table("surface\tpath", "Ab\ta.txt", "aB\tb.txt")
    message = f"line 3, surface = aB: occurs twice but for capitals, as Ab (also {path}, line 2); rename one"
    assert message in mistakes(path)


def test_a_table_that_is_no_text_is_named(tmp_path):
    path = tmp_path / "surfaces.tsv"
    for content, line in (
        (b"\xff\xfe\x00", 1),  # half a letter of UTF-16
        ("surface\tpath\na\ta.txt\nb\tmäß.txt\n".encode("cp1252"), 3),
    ):
        path.write_bytes(content)
        message = mistakes(path)
        assert message.startswith(f"table of surfaces {path}, line {line}: is no text in UTF-8 (")
        assert message.endswith("save it as UTF-8")
    path.unlink()
    path.mkdir()
    assert f"{path}: not readable (" in mistakes(path)
    assert "a\0b: not readable (" in mistakes("a\0b")


BLANKS = [
    "two  blanks.npy",
    " before.npy",
    "after.npy ",
    "a\u00a0b.npy",
    "\u00a0.npy",
    "a\u2028b.npy",
    "a\x0cb",
]
MARKS = ['"quoted"', '"', '""', 'a "b".npy', '"a" and "b"', "#a", "a, b.npy", "'a", "=1+1.npy", "$(id).npy"]


@pytest.mark.parametrize("name", [*BLANKS[:-1], *MARKS])
def test_names_of_files_and_channels_stay_as_they_are(name, tmp_path, monkeypatch):
    """The name with single blanks, with which a table once took another file, is there as well."""
    monkeypatch.chdir(tmp_path)
    for file_name in {name, " ".join(name.split()), name.strip('"')} - {""}:
        (tmp_path / file_name).write_text(file_name)
    for written, path in ((write_project([name])[1], name), (tmp_path / "t.tsv", f"./{name}")):
        row = {"surface": "a", "path": path, "channel": name, "counter_face": name, "unit": " um "}
        if written.name == "t.tsv":
            written.write_text(table_text([row]), encoding="utf-8")
        read = read_surfaces(written)
        (surface,) = read.values()
        assert surface.path.read_text() == name
        if written.name == "t.tsv":
            assert surface.files()[1].path.read_text() == name
            assert surface.read_arguments == {"channel": name, "unit": "um"}


@pytest.mark.parametrize("name", ["a\tb", "a\nb", "a\rb", BLANKS[-1], "\x1b[31m", "a\0", "a\x85", "\udcff"])
def test_names_that_no_table_can_hold_are_refused(name):
    for column in ("path", "counter_face", "channel"):
        with pytest.raises(SettingsError, match="a cell is text without tabs or control marks; rename it"):
            table_text([{"surface": "a", "path": "a.npy", column: name}])


def test_a_table_as_excel_saves_text_with_tabs_is_read(table):
    plain = "surface\tpath\tunit", "a\ta, b.txt\tum", 'c\tan "inch".txt\t'
    excel = (
        '"# one row, and a file"\t\t',
        "surface\tpath\tunit\t\t",
        'a\t"a, b.txt"\tum\t',
        'c\t"an ""inch"".txt"\t\t\t',
        "\t\t\t",
    )
    quoted = ["\t".join('"' + cell.replace('"', '""') + '"' for cell in line.split("\t")) for line in plain]
    expected = [(row.name, row.path, row.read_arguments) for row in read_surfaces(table(*plain)).values()]
    for lines in (excel, quoted):
        read = read_surfaces(table(*lines)).values()
        assert [(row.name, row.path, row.read_arguments) for row in read] == expected


def test_no_control_character_of_a_table_reaches_the_terminal(table):
    cells = "\x1b[31mred", "\x1b]0;title\x07", "\x9b31m"
    path = table("surface\tpath\tgroup\tpart", *(f"{cell}\t{cell}\t{cell}\t{cell}" for cell in cells))
    message = mistakes(path, files_exist=True)
    assert "no such file" in message
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]", message)


@pytest.mark.parametrize("path", [".", "./", ".."])
@pytest.mark.parametrize("column", ["path", "counter_face"])
def test_a_folder_is_no_file(table, column, path):
    cells = {"path": "test_surfaces.py", column: path}
    message = mistakes(table("surface\tpath\tcounter_face", f"a\t{cells['path']}\t{path}"), files_exist=True)
    assert re.search(rf"line 2, {column} = '(\.|\./|\.\.)': (no such file|names no file)", message)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_a_table_is_read_in_the_encoding_that_it_marks(tmp_path, encoding):
    mark = "\ufeff" if encoding.endswith("e") else ""
    (tmp_path / "t.tsv").write_bytes((mark + "surface\tpath\r\na\tmäß-µ.txt\r\n").encode(encoding))
    assert str(read_surfaces(tmp_path / "t.tsv")["a"].path) == "mäß-µ.txt"


def test_a_path_too_long_for_any_file_is_no_such_file(table):
    path = table("surface\tpath", f"a\t{'a' * 5000}.txt")
    message = mistakes(path, files_exist=True)
    assert f"line 2, path = '{'a' * 5000}.txt': no such file" in message


@pytest.mark.parametrize("name", ["seal-counter-face", "seal-face", "seal-1"])
def test_the_pair_that_needs_a_name_is_named(table, name):
    path = table("surface\tpath\tcounter_face\tdx", "seal\ta\tb\t-1", f"{name}\tc\t1")
    with pytest.raises(SettingsError) as caught:
        read_surfaces(path)
    assert str(caught.value).splitlines()[1:] == [
        (
            "  line 2, dx = '-1': must be a number greater than 0 (decimal point), in `unit` or with its own "
            "unit behind it (1.5 um)"
        ),
        f"  line 3, surface = {name}: the pair seal needs this name for one of its parts; rename one",
    ]


def test_an_unknown_column_hides_no_mistake_in_the_rows(table):
    message = mistakes(table("surface\tpath\tdx\tcolour", "a\ta.txt\t-1\tred", "a\ta.txt\t1\tred"))
    assert "column 'colour': unknown, valid are surface" in message
    assert "line 2, dx = '-1': must be a number" in message
    assert "line 3, surface = a: occurs twice" in message


def test_repeats_know_each_other(table):
    surfaces = read_surfaces(table("surface\tpath\trepeat_of\tnoise", "a\ta.npy\tb\t", "b\tb.npy\t\t2 nm"))
    of_b = {"name": "b", "path": "b.npy", "instrument": {"noise": pytest.approx(2e-9)}}
    assert surfaces["a"].read_arguments["repeats"] == [of_b]
    assert surfaces["b"].read_arguments["repeats"] == [{"name": "a", "path": "a.npy"}]


def test_what_allows_a_file_to_be_read_holds_for_its_overview(table):
    """Or its refusal asks for a cell that is there."""
    header = "surface\tpath\toverview\tresample\tchecksum"
    surfaces = read_surfaces(table(header, "a\ta.xyz\tfield.xyz\tlinear\tignore"))
    expected = {"path": "field.xyz", "resample": "linear", "checksum": "ignore"}
    assert surfaces["a"].read_arguments["overview"] == [expected]


def test_a_repeat_is_read_without_what_lies_around_it(table):
    rows = "a\ta.npy\t\tfield.npy", "b\tb.npy\ta\t"
    surfaces = read_surfaces(table("surface\tpath\trepeat_of\toverview", *rows))
    assert surfaces["b"].read_arguments["repeats"] == [{"name": "a", "path": "a.npy"}]
    assert surfaces["a"].read_arguments["overview"] == [{"path": "field.npy"}]


def test_repeats_in_a_group_are_of_one_part(table):
    rows = ["a\ta.npy\tb\tground\t", "b\tb.npy\t\tground\t", "c\tc.npy\t\tground\t"]
    surfaces = read_surfaces(table("surface\tpath\trepeat_of\tgroup\tpart", *rows))
    assert [surface.specimen for surface in surfaces.values()] == ["b", "b", ""]
    rows[0] += "left"  # what is stated stays
    surfaces = read_surfaces(table("surface\tpath\trepeat_of\tgroup\tpart", *rows))
    assert [surface.specimen for surface in surfaces.values()] == ["left", "", ""]


def test_profiles_across_a_lay_are_solved_with_those_along_it(table):
    rows = ["x\tx.csv\tz1; z2\tturned\tacross", "y\ty.csv\t\tturned\talong", "z\tx.csv\tz3\tturned\talong"]
    path = table("surface\tpath\tchannel\tgroup\tlay", *rows)
    (single,) = read_surfaces(path).values()
    along = [{"path": "y.csv", "lay": "across"}, {"path": "x.csv", "channel": "z3", "lay": "across"}]
    assert single.read_arguments == {"channel": "z1; z2", "lay": "across", "along": along}
    assert single.group == ""
    more_surfaces = read_surfaces(
        table("surface\tpath\tchannel\tgroup\tlay", *rows, "w\tw.csv\t\tturned\tacross")
    )
    assert [(name, row.group) for name, row in more_surfaces.items()] == [("x", "turned"), ("w", "turned")]
    assert more_surfaces["w"].read_arguments["along"] == along


@pytest.mark.cases
def test_profiles_along_a_lay_are_no_surfaces(table, row, message):
    table_message = mistakes(table("surface\tpath\tgroup\tlay\trepeat_of", "x\tx.csv\tturned\tacross\t", row))
    assert message in table_message


def test_every_repeat_of_a_place_is_of_one_part(table):
    rows = ["a\ta.npy\t\tground", "b\tb.npy\ta\tground", "c\tc.npy\tb\tground", "d\td.npy\t\tground"]
    surfaces = read_surfaces(table("surface\tpath\trepeat_of\tgroup", *rows))
    assert [row.specimen for row in surfaces.values()] == ["a", "a", "a", ""]


@pytest.mark.parametrize("column", ["repeat_of", "before"])
@pytest.mark.parametrize("surface_named", ["a", "nobody", "pair"])
def test_a_place_that_is_no_other_surface_is_refused(table, column, surface_named):
    rows = f"a\ta.npy\t{surface_named}\t", "b\tb.npy\t\t", "pair\tp.npy\t\tq.npy"
    reasons = {"a": "is the name of this row", "pair": r"pair is a pair \(counter_face\)"}
    reason = reasons.get(surface_named, "is no other surface of the table; valid are b")
    with pytest.raises(SettingsError, match=f"line 2, {column} = '{surface_named}': {reason}"):
        read_surfaces(table(f"surface\tpath\t{column}\tcounter_face", *rows))


def test_a_place_before_pairs_surfaces_and_gives_no_noise(table):
    rows = "new\ta.npy\t\t", "worn\tb.npy\tnew\t", "again\tc.npy\t\tworn"
    surfaces = read_surfaces(table("surface\tpath\tbefore\trepeat_of", *rows))
    assert same_area_pairs(surfaces) == [("new", "worn"), ("worn", "again")]
    assert "repeats" not in surfaces["new"].read_arguments
    assert surfaces["worn"].read_arguments["repeats"][0]["name"] == "again"


@pytest.mark.cases
def test_places_that_contradict_one_another_are_refused_with_their_names(table, rows, message):
    table_message = mistakes(table("surface\tpath\trepeat_of\tbefore\tgroup\tcrop", *rows))
    assert re.search(message if "->" in message else re.escape(message), table_message)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (("a\ta\t\t\t", "b\ta\t\t2x2\t"), "a and b-1-1 are the same file, a; leave one out"),
        (("a\ta\tz1; z2\t\t", "b\ta\tz2;z3\t\t"), "a and b are the same file, a z2; leave one out"),
        (("a\ta\t\t\t0 0 4 4 um", "b\ta\t\t\t3 0 6 4 um"), "a and b are the same file, a; leave one out"),
        (("a\ta\t\t\t0 0 4 4 um", "b\ta\t\t\t"), "leave one out, or crop them apart"),
    ],
)
def test_what_maps_of_a_group_have_in_common_is_measured_once(table, rows, message):
    header = "surface\tpath\tchannel\tparts\tcrop\tgroup"
    assert message in mistakes(table(header, *(f"{row}\tg" for row in rows)))
    apart = "c\tc\t\t\t0 0 4 4 um\tg", "d\tc\t\t\t4 0 8 4 um\tg"
    surfaces = read_surfaces(table(header, "a\ta\tz1; z2\t\t\tg", "b\ta\tz3\t2x2\t\tg", *apart))
    # places of one map are of one workpiece, as its parts are
    assert [row.specimen for row in surfaces.values()] == ["", *["b"] * 4, *["c"] * 2]


@pytest.mark.cases
def test_a_noise_that_is_no_length_is_refused(table, cell, rule):
    with pytest.raises(SettingsError, match=rf"line 2, noise = '{cell}': {rule}.*\(measurement noise"):
        read_surfaces(table("surface\tpath\tnoise", f"a\ta.npy\t{cell}"))


def test_names_keep_the_letters_of_any_script(table):
    files = [f"m/{name}.x3p" for name in ("Dichtung Prüfling Nr. 3", "é_1", "表", "u\u0308", "ü", "___", "Ü")]
    names = surface_names(files)
    assert names == ["Dichtung-Prüfling-Nr-3", "é-1", "表", "ü", "ü-2", "surface", "Ü-3"]
    lines = [f"{name}\t{number}.x3p" for number, name in enumerate(names)]
    assert [*read_surfaces(table("surface\tpath", *lines))] == names
    assert all(name_mistake(name) for name in ("a_b", "a b", "u\u0308", "a/b", "ü.", "", "表\n"))
    assert re.fullmatch(NAME, "a" * 64)


def test_positions_of_overviews_are_one_for_each_file(table):
    path = table(
        "surface\tpath\toverview\toverview_position",
        "a\ta.txt\tb.txt; c.txt\t300 250 um; elsewhere",
        "d\td.txt\tb.txt\t",
    )
    surfaces = read_surfaces(path)
    assert surfaces["a"].read_arguments["overview"] == [
        {"path": "b.txt", "position": "300 250 um"},
        {"path": "c.txt", "position": "elsewhere"},
    ]
    assert surfaces["d"].read_arguments["overview"] == [{"path": "b.txt"}]


@pytest.mark.cases
def test_a_wrong_position_of_an_overview_is_a_mistake_of_the_table(table, overview, position, mistake):
    path = table("surface\tpath\toverview\toverview_position\tunit", f"a\ta.txt\t{overview}\t{position}\tum")
    with pytest.raises(SettingsError, match=f"line 2, overview_position = .*{mistake}"):
        read_surfaces(path)


def test_each_of_three_repeats_knows_both_others(table):
    rows = "a\ta.npy\t", "b\tb.npy\ta", "c\tc.npy\tb"
    surfaces = read_surfaces(table("surface\tpath\trepeat_of", *rows))
    others = {
        name: [entry["name"] for entry in row.read_arguments["repeats"]] for name, row in surfaces.items()
    }
    assert others == {"a": ["b", "c"], "b": ["a", "c"], "c": ["b", "a"]}
