"""Every exit of a run has the same numbers of a result, and says them in the same words.

Screen, app, page, both tables, workbook, methods and groups are compared with the file of statistics, of a
periodic map, a coated one, a pair, a profile, a body of finite size, and a larger one.
"""

import html
import json
import math
import re
from itertools import product

import numpy as np
import pandas as pd
import pytest
from small_project import project_with_maps

from roughcontact import read_dataset, with_interval
from roughcontact.interface.program import main

# heading on the sheets and words on the screen; what changes a number into each unit
QUANTITIES = {
    "relative_contact_area": "contact area",
    "mean_contact_pressure": "pressure in contact",
    "mean_gap": "mean gap",
    "contact_radius": "contact radius",
    "mutual_approach": "approach",
    "max_pressure": "largest pressure",
}
MAIN = [*QUANTITIES][:3]
FACTORS = {"%": 1e2, "MPa": 1e-6, "kPa": 1e-3, "µm": 1e6, "nm": 1e9}
SOFT = {"youngs_modulus": "2 GPa", "poissons_ratio": 0.3}
STUDIES = {
    "maps": {
        "contact": {"bodies": [SOFT, SOFT], "mean_pressure": ["5 MPa", "20 MPa"], "hardness": "0.4 GPa"},
        "cases": {
            "plain": {},
            "coated": {"contact": {"bodies": [SOFT | {"layers": [SOFT | {"thickness": "4 um"}]}, SOFT]}},
        },
    },
    "bodies": {
        "contact": {"contact_modulus": "1 GPa", "boundary": "free", "force": ["1 mN", "2 mN"]},
        "cases": {
            "ball": {"form": {"radius": "1 mm"}},
            "local": {"contact": {"boundary": "periodic"}, "form": {"radius": "1 mm", "local_scale": True}},
        },
    },
}
TABLE = ("surface\tpath\tcounter_face\tunit\tdx\tdy\tlay", "ground\tmeasured/ground.npy\t\tum\t1\t1\t")
FURTHER = {
    "maps": (
        "pair\tmeasured/ground.npy\tmeasured/turned.txt\tum\t1\t1\t",
        "trace\tmeasured/trace.txt\t\tum\t1\t\tnone",
    ),
    "bodies": (),
}


def known(value, lower, upper):
    """How well a number is known, in words: never better than it is."""
    half_width = max(value - lower, upper - value) / value
    factor = max(upper / value, value / max(lower, 1e-99))
    if half_width <= 0.3:
        return f"to ± {max(10, 5 * math.ceil(20 * half_width - 1e-9))} %"
    if factor <= 3:
        return f"to a factor {math.ceil(10 * factor - 1e-9) / 10:.1f}"
    return "order of magnitude" if factor <= 10 else "worse than a factor of 10"


def cells(ends, unit):
    """What exits show of a number: its digits with the interval, it, the interval, how well it is known."""
    ends = [*ends]
    digits = with_interval(*(FACTORS[unit] * end for end in ends))
    number, _, interval = digits.partition(" ")
    return digits, f"{number} {unit}", interval.strip("()"), known(*ends)


def plain(text):
    """A text of any exit, with plain spaces and without marks."""
    return " ".join(html.unescape(re.sub("<[^>]+>", " ", text)).split())


@pytest.mark.slow
@pytest.mark.parametrize("study", STUDIES)
def test_every_exit_has_the_numbers_of_the_file_in_the_same_words(study, tmp_path, checkout, capsys):
    project = project_with_maps(tmp_path / study, checkout)
    trace = np.load(project.path("measured/ground.npy"))[3]
    np.savetxt(project.path("measured/trace.txt"), np.c_[:64, trace])
    settings = {"surfaces": "surfaces.tsv", "composite": {"shifts": 3, "rotations": [0]}}
    project.write(settings | STUDIES[study], [*TABLE, *FURTHER[study]])
    screen = plain(project.succeed("--logger", "roughcontact").stderr)
    page, compared = plain(project.path("results/report.html").read_text()), 0
    summary = pd.read_csv(project.path("results/summary.csv"))
    results = [path.parent for path in project.path("results").glob("*/*/statistics.nc")]
    for folder in results:
        data, book = read_dataset(folder / "statistics.nc").load(), folder / "book.xlsx"
        assert main(["export", str(folder), "-o", str(book)]) == main(["methods", str(folder)]) == 0
        methods = plain(capsys.readouterr().out)
        answer = plain(json.loads((folder / "panel.json").read_text())["answer"])  # which the app shows
        assert answer in screen
        assert answer in page
        sheets = pd.read_excel(book, sheet_name=None)
        rows = summary[(summary["case"] == folder.parts[-2]) & (summary["surface"] == folder.name)]
        for (name, words), load in product(QUANTITIES.items(), range(2)):
            if f"{name}_lower" not in data:
                continue
            ends = {f"{name}{end}": float(data[f"{name}{end}"][load]) for end in ("", "_lower", "_upper")}
            value, lower, upper = ends.values()
            for table, key in product((rows, sheets["summary"]), ends):
                (column,) = table.filter(regex=f"^{key}(_Pa|_m)?$")
                assert table[column].iloc[load] == pytest.approx(ends[key], rel=1e-9)
            row = sheets["answers"][sheets["answers"]["answer"] == words].iloc[load]
            factor = FACTORS[row["unit"]]
            numbers = [factor * number for number in (value, value - lower, upper - value)]
            assert list(row[["value", "-", "+"]]) == pytest.approx(numbers, rel=1e-9, nan_ok=True)
            digits, *shown = cells(ends.values(), row["unit"])
            assert list(row[["details", "known"]]) == shown[1:]
            assert " ".join(shown) in page
            if load == 1 and words in answer:
                assert f"{words} {shown[0]} ({', '.join(shown[1:])}" in answer
            if name in MAIN:
                assert f"{digits} {row['unit']}" in methods
            compared += 1
    assert compared >= 4 * 2 * len(results) > 0
    if study == "maps":  # all placements of the pair
        for _, row in pd.read_csv(project.path("results/groups.csv")).iterrows():
            for name, unit in zip(MAIN, ("%", "MPa", "µm"), strict=True):
                _, *shown = cells((row[f"{name}{end}"] for end in ("", "_lower", "_upper")), unit)
                assert " ".join(shown) in page
