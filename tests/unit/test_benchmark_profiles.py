"""The calibration of surfaces behind profiles is that of its table of errors, and reaches what is said."""

import json

import pandas as pd
import profiles as benchmark
import pytest

from roughcontact.uncertainty.scales import AREA, GAP


@pytest.fixture(scope="module")
def errors():
    return pd.read_csv(benchmark.ERRORS)


@pytest.fixture(scope="module")
def reached(errors):
    return benchmark.report(errors)


def test_the_calibration_is_that_of_the_table(errors):
    content = json.loads(benchmark.CALIBRATION.read_text())
    assert content["profiles"] == benchmark.calibrated(errors)


def test_with_each_map_left_out_the_truth_is_in_nine_of_ten_intervals(reached):
    written = pd.read_csv(benchmark.ERRORS.with_name("reached.csv"), index_col=[0, 1, 2])
    assert written["coverage"].tolist() == reached["coverage"].tolist()
    for kind in ("made", "measured"):
        for number in (1, 5):
            for quantity in (AREA, GAP):
                assert reached.loc[(kind, number, quantity), "coverage"] >= 0.9


def test_the_interval_of_the_area_holds_for_surfaces_with_a_lay_as_well(errors, reached):
    for kind, maps in (("made lay", 12), ("measured lay", 10)):
        assert errors.loc[errors["kind"] == kind, "map"].nunique() == maps
        for number in (1, 5):
            assert reached.loc[(kind, number, AREA), "coverage"] >= 0.9
    assert reached.loc[("made lay", 5, AREA), 0.02] < 0.05


def test_a_wrong_spread_would_be_noticed(errors):
    table = benchmark.calibrated(errors)
    table[AREA]["quantile"] = [0.5 * wide for wide in table[AREA]["quantile"]]
    area = errors[(errors["quantity"] == AREA) & (errors["kind"] == "measured")]
    as_calibrated = benchmark.judged(area, benchmark.calibrated(errors))
    assert benchmark.judged(area, table)["inside"].mean() < as_calibrated["inside"].mean()


def test_the_contrast_of_ridges_brings_the_area_nearer(errors, reached):
    without_contrast = benchmark.report(errors.assign(contrast=0.0))
    for load in benchmark.LOADS:
        assert reached.loc[("measured", 5, AREA), load] < without_contrast.loc[("measured", 5, AREA), load]
    together = "all loads"
    for kind in ("made", "measured"):
        assert reached.loc[(kind, 5, GAP), together] < without_contrast.loc[(kind, 5, GAP), together]
