"""The target `cost`: run time against error of the maps of a run, and nothing else of it."""

import pandas as pd
import pytest
from small_project import SETTINGS, TABLE


@pytest.mark.slow
def test_the_target_measures_the_windows(project):
    project.write(SETTINGS, TABLE[:2])
    run = project.run("cost")
    assert run.returncode == 0, run.stderr
    table = pd.read_csv(project.path("results/ground/cost.csv"))
    assert sorted(set(table["points_x"])) == [32, 64, 128]
    assert table["mean_pressure"].nunique() == len(SETTINGS["contact"]["relative_pressure"])
    html = project.path("results/cost.html").read_text()
    assert "solve at 1" in html or "solve at 6" in html
    assert html.count("<img ") == 3
    assert not project.path("results/report.html").exists()
    assert project.jobs("cost") == {}
