"""Groups of maps in a run: files, page, cases, and tables that cannot be right."""

import re

import numpy as np
import pytest
from small_project import SETTINGS, Project

from roughcontact import read_dataset, self_affine_surface

HEADER = "surface\tpath\tunit\tdx\tdy\tgroup\tpart"
GRADIENTS = {"fine": (0.08, 0.09, 0.085), "coarse": (0.15, 0.17, 0.16)}
ROWS = [
    f"{group}-{number}\tmeasured/{group}-{number}.npy\tum\t1\t1\t{group}s\t"
    for group, gradients in GRADIENTS.items()
    for number in range(len(gradients))
]
QUICK = SETTINGS | {
    "contact": {"contact_modulus": "1e9", "mean_pressure": ["5 MPa", "20 MPa"], "tolerance": "1e-5"},
    "uncertainty": {"sources": ["solver", "discretisation"]},
}

SEAL = "seal\tmeasured/fine-0.npy\tum\t1\t1\t\t\tmeasured/coarse-0.npy"


@pytest.fixture
def grouped(tmp_path, checkout):
    """A project with six small maps of two finishes."""
    project = Project(tmp_path / "project", checkout)
    for group, gradients in GRADIENTS.items():
        for number, gradient in enumerate(gradients):
            parameters = {"hurst": 0.8, "shortest": 8, "longest": 16, "rms_gradient": gradient}
            height = self_affine_surface((32, 32), 1.0, **parameters, seed=number)
            np.save(project.path(f"measured/{group}-{number}.npy"), height.values)
    project.write(QUICK, [HEADER, *ROWS])
    return project


@pytest.mark.slow
def test_groups_have_their_files_and_stand_first_on_the_page(grouped):
    grouped.succeed()
    rows = grouped.rows("groups.csv")
    assert [(row["group"], row["maps"]) for row in rows] == [
        (group, "3") for group in ("fines", "coarses") for _ in range(2)
    ]
    summary = grouped.rows("summary.csv")
    for row in rows:
        of_maps = [
            float(row_of_map["relative_contact_area"])
            for row_of_map in summary
            if row_of_map["surface"].startswith(row["group"][:-1])
            and row_of_map["mean_pressure_Pa"] == row["mean_pressure_Pa"]
        ]
        low, value, high = (
            float(row[f"relative_contact_area{suffix}"]) for suffix in ("_lower", "", "_upper")
        )
        assert low < min(of_maps) * 1.05
        assert min(of_maps) < value < max(of_maps)
        assert high > max(of_maps) * 0.95
        assert float(row["relative_contact_area_next_upper"]) > high
    joined = read_dataset(grouped.path("results/groups.nc"))
    assert joined["map_name"].sel(group="fines").values.tolist() == ["fine-0", "fine-1", "fine-2"]
    compared = grouped.rows("comparisons.csv")
    area = [row for row in compared if row["quantity"] == "relative_contact_area"]
    assert [(row["first"], row["second"], row["outcome"]) for row in area] == [
        ("fines", "coarses", "differ")
    ] * 2
    page = grouped.path("results/report.html").read_text()
    assert page.index('<section id="groups">') < page.index('<section id="glance">')
    (verdicts,) = re.findall(r"<b>fines</b>: 3 maps \((.*?)\)\.", page)
    assert sum(map(int, re.findall(r"\d", verdicts))) == 3
    assert "coarses against fines" in page
    assert page.index("fines, map by map") < page.index("coarses, map by map")  # as in the table
    # regrouping solves nothing again
    grouped.write(QUICK, [HEADER, *(row.replace("\tcoarses\t", "\tfines\t") for row in ROWS)])
    assert grouped.jobs() == {"report": 1}


@pytest.mark.slow
def test_maps_that_are_cut_are_groups_of_their_parts(grouped):
    for name, gradient in (("lapped", 0.08), ("milled", 0.16)):
        waves = {"hurst": 0.8, "shortest": 8, "longest": 16, "rms_gradient": gradient}
        np.save(grouped.path(f"measured/{name}.npy"), self_affine_surface((64, 64), 1.0, **waves, seed=1))
    rows = [f"{name}\tmeasured/{name}.npy\tum\t1\t1\t2x2" for name in ("lapped", "milled")]
    grouped.write(QUICK, ["surface\tpath\tunit\tdx\tdy\tparts", *rows])
    grouped.succeed()
    assert {(row["group"], row["maps"], row["parts"]) for row in grouped.rows("groups.csv")} == {
        ("lapped", "4", "4"),
        ("milled", "4", "4"),
    }
    part = read_dataset(grouped.path("results/lapped-2-1/height.nc"))["height"]
    full_map = np.load(grouped.path("measured/lapped.npy"))
    np.testing.assert_allclose(part.values, full_map[:32, 32:] * 1e-6, rtol=1e-6)
    area = [r for r in grouped.rows("comparisons.csv") if r["quantity"] == "relative_contact_area"]
    assert {row["outcome"] for row in area} == {"differ"}
    page = grouped.path("results/report.html").read_text()
    assert "Part 2 of 2 along x, 1 of 2 along y (upwards), of 64 x 64 points" in page
    logs = "".join(log.read_text() for log in grouped.path("logs").glob("lapped-2-1/*.log"))
    assert "note: part 2 of 2 along x" in logs  # what the table asks for is no warning
    assert "warning: part" not in logs
    # other parts are other maps
    grouped.write(QUICK, ["surface\tpath\tunit\tdx\tdy\tparts", rows[0].replace("2x2", "2x1"), rows[1]])
    assert grouped.jobs()["prepare"] == 2


@pytest.mark.slow
def test_a_group_of_different_pixels_is_named_and_the_rest_goes_on(grouped):
    rows = [row.replace("\t1\t1\t", "\t2\t2\t") if row.startswith("fine-0") else row for row in ROWS[:3]]
    cases = {"cases": {"soft": {}, "stiff": {"contact": {"contact_modulus": "2e9"}}}}
    grouped.write(QUICK | cases, [HEADER, *rows])
    run = grouped.succeed()
    message = "its maps hold different waves, the shortest of fine-1 is 2.00 µm, that of fine-0 4.00 µm"
    assert message in run.stderr
    assert message in grouped.path("results/report.html").read_text()
    assert grouped.rows("groups.csv") == grouped.rows("comparisons.csv") == []


@pytest.mark.slow
def test_repeats_and_placements_are_compared_and_folded_below_their_pair(grouped):
    rows = [f"{row}\t\t{repeat_of}" for row, repeat_of in zip(ROWS[:2], ("", "fine-0"), strict=True)]
    rows = [row.replace("\tfines\t", "\t\t") for row in rows]
    np.save(grouped.path("measured/fine-1.npy"), 1.001 * np.load(grouped.path("measured/fine-0.npy")))
    grouped.write(
        QUICK | {"composite": {"shifts": 2}}, [f"{HEADER}\tcounter_face\trepeat_of", *rows, f"{SEAL}\t"]
    )
    grouped.succeed()
    compared = [row for row in grouped.rows("comparisons.csv") if row["quantity"] == "mean_gap"]
    assert [(row["first"], row["second"]) for row in compared] == [("fine-0", "fine-1")] * 2 + [
        ("seal-1", "seal-2")
    ] * 2
    # heights 1.001 times as large have a gap that is larger by about as much
    ratios = [float(compared[0][f"ratio{suffix}"]) for suffix in ("_lower", "", "_upper")]
    assert ratios == sorted(ratios)
    assert 1.0005 < ratios[1] < 1.002
    assert ratios[2] - ratios[0] < 0.01
    page = grouped.path("results/report.html").read_text()
    folded = '<details class="group"><summary>seal, map by map: seal-1, seal-2</summary>'
    match = re.search(r"<b>seal</b>: 2 placements of two faces \((use|review) 2\)\.", page)
    assert match.start() < page.index('<section id="glance">')
    assert page.index('<a href="#surface-fine-0">', page.index('<section id="glance">')) < page.index(folded)
    assert page.index('<details class="group"><summary>seal-1, of seal: ') < page.index('id="surface-seal-1"')


@pytest.mark.slow
def test_cases_of_a_group_are_compared_map_by_map(grouped):
    cases = {
        "soft": {},
        "stiff": {"contact": {"contact_modulus": "2e9", "mean_pressure": ["10 MPa", "40 MPa"]}},
    }
    grouped.write(QUICK | {"cases": cases}, [HEADER, *ROWS[:3]])
    grouped.succeed()
    assert {row["case"] for row in grouped.rows("groups.csv")} == {"soft", "stiff"}


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([ROWS[0], ROWS[3], ROWS[4]], "line 2, group = fines: has fine-0 alone; name further maps"),
        (
            [row.replace("fines", "coarse-0") for row in ROWS],
            "line 2, group = coarse-0: a surface has this name",
        ),
        ([row.replace("fines", "a b") for row in ROWS], "line 2, group = a b: a name has letters, digits"),
        ([row.replace("fines", "soft") for row in ROWS], "line 2, group = soft: a case of the settings has"),
        (
            [f"{HEADER}\tcounter_face", *(f"{row.replace('fines', 'seal-1')}\t" for row in ROWS), SEAL],
            "line 2, group = seal-1: the pair seal needs this name for one of its parts",
        ),
        ([*ROWS[3:], "one\tmeasured/fine-0.npy\tum\t1\t1\t\tp1"], "line 5, part = p1: is in no group"),
    ],
)
def test_tables_that_cannot_be_right(grouped, rows, message):
    rows = rows if rows[0].startswith(HEADER) else [HEADER, *rows]
    grouped.write(QUICK | {"cases": {"soft": {}, "stiff": {"contact": {"tolerance": 1e-3}}}}, rows)
    run = grouped.run("--dry-run")
    assert run.returncode != 0
    assert message in run.stderr
