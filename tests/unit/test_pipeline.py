"""The chain as one function: settings as the configuration has them, numbers as the verbs give them."""

import json

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.evaluation import pipeline
from roughcontact.evaluation.kinds import kind_of
from roughcontact.surface.synthetic import westergaard_surface

NO_BUDGET = {"sources": []}


@pytest.fixture(scope="module")
def rough():
    """A map of an instrument: not periodic, with a tilt."""
    height = self_affine((48, 64), 1e-6, (6e-6, 24e-6), rms_height=2e-7, seed=4)
    return height.copy(data=(height + 0.01 * height["x"]).values)


def test_half_of_a_wave_touches_at_half_of_the_load_that_closes_it():
    """Westergaard (1939): it closes under π E* D/λ."""
    wave = westergaard_surface((1, 512), 1e-3 / 512, amplitude=1e-6, wavelength=1e-3)
    statistics = rc.evaluate(
        wave,
        level={"form": "none", "outlier_threshold": None},
        window={"method": "raw"},
        contact={"contact_modulus": "1 GPa", "mean_pressure": np.pi * 1e6 / 2},
        uncertainty=NO_BUDGET,
    )
    assert statistics["relative_contact_area"].item() == pytest.approx(0.5, abs=2 / 512)
    assert statistics["max_pressure"].item() == pytest.approx(np.sqrt(2) * np.pi * 1e6, rel=1e-3)


def test_the_numbers_are_those_of_the_verbs_one_by_one(rough):
    # loads not in the order of solving
    contact = {"contact_modulus": 1e9, "mean_pressure": [4e6, 1e6], "tolerance": 1e-4}
    result = rc.evaluate(rough, contact=contact, uncertainty={"sources": ["solver", "discretisation"]})
    levelled = rc.level(rough)
    window = rc.periodic_window(levelled)
    reference = rc.contact_statistics(rc.solve_contact(window, **contact))
    corrected = {str(name).removesuffix("_as_solved") for name in result if str(name).endswith("_as_solved")}
    assert corrected == {"relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure"}
    for name in reference.variables:
        values = result[f"{name}_as_solved" if name in corrected else name]
        if name != "max_pressure_over_modulus":
            np.testing.assert_array_equal(values, reference[name], err_msg=name)
    peak = result["max_pressure"] / result["contact_modulus"]
    np.testing.assert_array_equal(result["max_pressure_over_modulus"], peak)
    budget = rc.error_budget(
        levelled,
        window,
        {"level": {}, "window": {}, "contact": contact},
        sources=["solver", "discretisation"],
    )
    for name in (
        "mean_gap_lower",
        "mean_gap_upper",
        "relative_contact_area_uncertainty",
        "mean_gap_estimate",
    ):
        np.testing.assert_array_equal(result[name], budget[name], err_msg=name)
    assert (result["mean_gap_lower"] < result["mean_gap"]).all()
    words = [word for word, _ in json.loads(result.attrs["verdicts"])]
    meanings = result["verdict"].attrs["flag_meanings"].split()
    assert [meanings[code].replace("_", " ") for code in result["verdict"].values] == words
    listed = json.loads(result.attrs["reasons"])
    assert all(entry.keys() == {"check", "loads", "text"} for entry in listed)
    doubted = {load for entry in listed for load in entry["loads"]}
    answers = [name for name in result.data_vars if name.endswith("_verdict")]
    assert len(answers) == 7
    assert doubted == {load for load in (0, 1) if any(result[name].values[load] for name in answers)}
    verdicts = [
        result[f"{name}_verdict"].values for name in ("relative_contact_area", "mean_contact_pressure")
    ]
    np.testing.assert_array_equal(result["verdict"], np.maximum(*verdicts))


def test_a_file_and_its_map_give_the_same(tmp_path, rough):
    rough.to_netcdf(tmp_path / "map.nc")
    options = {"contact": {"contact_modulus": 1e9, "relative_pressure": 0.1}, "uncertainty": NO_BUDGET}
    file = rc.evaluate(tmp_path / "map.nc", **options)
    of_map = rc.evaluate(rc.read_height_map(tmp_path / "map.nc"), **options)
    assert file.identical(of_map)
    assert len(file.attrs["source_sha256"]) == 64
    assert json.loads(file.attrs["settings"])["contact"]["contact_modulus"] == 1e9


def test_fields_are_handed_on_and_not_kept(rough):
    (settings,) = resolve({"contact": {"contact_modulus": 1e9, "mean_pressure": [4e6, 1e6]}}).values()
    window = rc.periodic_window(rc.level(rough))
    solver = kind_of(window, settings).solver_arguments(window, settings)
    pieces: list[xr.Dataset] = []
    solution, *_ = pipeline.solve_and_evaluate(
        window, settings, solver, store=lambda piece: pieces.append(piece.copy(deep=True))
    )
    assert [float(piece["mean_pressure"][0]) for piece in pieces] == [1e6, 4e6]
    assert all(piece["pressure"].shape == (1, *window.shape) for piece in pieces)
    assert "pressure" not in solution
    assert solution["mean_pressure"].values.tolist() == [4e6, 1e6]


@pytest.mark.cases
def test_settings_are_refused_as_those_of_a_configuration(rough, sections, message):
    with pytest.raises(rc.SettingsError, match=message.replace("?", r"\?")):
        rc.evaluate(rough, **sections)


def test_keys_of_the_contact_are_given_flat_as_to_the_solver(rough):
    numbers = {"contact_modulus": "1 GPa", "relative_pressure": 0.1}
    section = rc.evaluate(rough, contact={**numbers, "tolerance": 1e-5}, uncertainty=NO_BUDGET)
    flat = rc.evaluate(rough, **numbers, contact={"tolerance": 1e-5}, uncertainty=NO_BUDGET)
    assert flat.identical(section)


@pytest.mark.cases
def test_other_keywords_are_answered_by_the_section_they_belong_to(rough, keywords, message):
    with pytest.raises(rc.SettingsError, match=message):
        rc.evaluate(rough, **keywords)


def test_unloading_is_of_a_run(rough):
    contact = {"contact_modulus": 1e9, "mean_pressure": 1e5, "hardness": 1e8, "unload": True}
    with pytest.raises(rc.SettingsError, match=r"contact.unload: .* rc.unload, or leave it out"):
        rc.evaluate(rough, contact=contact)


def test_a_flat_map_under_a_relative_load_names_its_file():
    (settings,) = resolve({"contact": {"contact_modulus": 1e9, "relative_pressure": 0.1}}).values()
    flat = xr.DataArray(
        np.ones((8, 8)), dims=("y", "x"), coords={"y": np.arange(8) * 1e-6, "x": np.arange(8) * 1e-6}
    ).assign_attrs(source_file="flat.npy")
    with pytest.raises(rc.HeightMapError, match=r"^flat.npy: .*\(section contact\)"):
        kind_of(flat, settings).solver_arguments(flat, settings)


@pytest.mark.parametrize(
    ("verb", "words"),
    [
        (lambda heights: rc.evaluate(heights, contact={"contact_modulus": 1e9}), "roughcontact.height_map"),
        (rc.level, "roughcontact.height_map"),
        (rc.periodic_window, "roughcontact.height_map"),
        (lambda heights: rc.error_budget(heights, heights, {"contact": {}}), "roughcontact.height_map"),
        (rc.profile_parameters, "roughcontact.height_map"),
        (rc.contact_statistics, "give the solution of solve_contact"),
    ],
)
def test_an_array_without_labels_is_answered_with_the_way_out(verb, words):
    with pytest.raises(rc.RoughContactError, match="of type ndarray") as caught:
        verb(np.zeros((8, 8)))
    assert words in str(caught.value)


@pytest.mark.parametrize("verb", [rc.level, rc.periodic_window, rc.profile_parameters])
def test_positions_in_any_other_order_than_upwards_and_even_are_refused(rough, verb):
    shuffled = rough.isel(y=np.random.default_rng(0).permutation(rough.sizes["y"]))
    for bad, words in (
        (shuffled, r"'y'.*not increase.*sortby"),
        (rough[:, ::-1], "'x'.*not increase"),
        (rough.assign_coords(x=rough["x"] ** 1.2), "'x'.*not evenly spaced"),
    ):
        with pytest.raises(rc.HeightMapError, match=words):
            verb(bad)
    assert verb(shuffled.sortby("y")) is not None


def test_a_shuffled_map_is_no_map_of_evaluate(rough):
    contact = {"contact_modulus": 1e9, "mean_pressure": 1e6}
    shuffled = rough.isel(y=np.random.default_rng(0).permutation(rough.sizes["y"]))
    with pytest.raises(rc.HeightMapError, match="does not increase"):
        rc.evaluate(shuffled, contact=contact, uncertainty=NO_BUDGET)


def test_loads_and_moduli_may_be_arrays_with_or_without_a_unit(rough):
    def areas(**contact):
        return rc.evaluate(rough, contact=contact, uncertainty=NO_BUDGET)["relative_contact_area"].values

    expected = areas(contact_modulus=1e9, mean_pressure=[1e6, 5e6])
    labelled = xr.DataArray([1.0, 5.0], dims="load", attrs={"units": "MPa"})
    modulus = xr.DataArray(1.0, attrs={"units": "GPa"})
    for loads in (np.array([1e6, 5e6]), np.array([1_000_000, 5_000_000]), labelled):
        np.testing.assert_array_equal(areas(contact_modulus=modulus, mean_pressure=loads), expected)
    window = rc.periodic_window(rc.level(rough))
    contact = rc.solve_contact(window, contact_modulus=modulus, mean_pressure=labelled)
    np.testing.assert_array_equal(contact["mean_pressure"], [1e6, 5e6])
    with pytest.raises(rc.SettingsError, match="unknown pressure unit 'mm'"):
        rc.solve_contact(window, contact_modulus=modulus, mean_pressure=labelled.assign_attrs(units="mm"))


def test_a_list_of_numbers_is_no_list_of_profiles():
    with pytest.raises(rc.HeightMapError, match=r"of type list.*roughcontact.height_map"):
        rc.evaluate([[0.0, 1e-7], [2e-7, 0.0]], contact={"contact_modulus": 1e9})


def test_tables_and_comparisons_are_of_their_own_kind_of_dataset(rough):
    window = rc.periodic_window(rc.level(rough))
    contact = rc.solve_contact(window, contact_modulus=1e9, mean_pressure=[1e6, 5e6])
    statistics = rc.contact_statistics(contact)
    assert len(rc.table(statistics)) == 2
    for dataset in (contact, statistics.isel(load=0)):
        with pytest.raises(rc.SettingsError, match="give statistics with the dimension load"):
            rc.table(dataset)
    with pytest.raises(rc.SettingsError, match="two results of group_statistics"):
        rc.compare_groups(statistics, statistics)


def test_a_flat_map_has_a_budget_without_a_warning(recwarn):
    flat = rc.height_map(np.full((20, 30), 5e-6), 1e-6, unit="m")
    result = rc.evaluate(flat, contact_modulus=1e9, mean_pressure=[1e6])
    assert result["relative_contact_area"].item() == 1
    assert not [warning for warning in recwarn if issubclass(warning.category, RuntimeWarning)]
