"""The benchmark of speed: its surfaces, its search for tolerances, its counts and its tables."""

import json

import cases
import certificate
import numpy as np
import pytest
import race
import speed
import speed_tables

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.kernels import fft
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.roughness.spectrum import isotropic_spectrum
from roughcontact.surface.synthetic import self_affine_surface


def test_a_made_surface_is_what_the_page_says():
    heights = cases.surface(64, seed=1)
    assert rms_gradient(height_map(heights, 1 / 64)) == pytest.approx(1, rel=1e-12)
    power = np.abs(np.fft.fft2(heights)) ** 2
    k = np.hypot(*np.meshgrid(np.fft.fftfreq(64, 1 / 64), np.fft.fftfreq(64, 1 / 64)))
    inside = (k >= 4) & (k <= 8)
    assert power[~inside].max() < 1e-20 * power.max()
    slope = np.polyfit(np.log(k[inside]), np.log(power[inside]), 1)[0]
    assert slope == pytest.approx(-2 * (1 + 0.8), rel=1e-9)


def test_an_enlarged_map_has_the_spectrum_of_the_window():
    window = self_affine_surface((90, 96), 2e-6, hurst=0.7, shortest=1.6e-5, longest=6e-5, rms_height=1e-7)
    large = cases.enlarged(window, 384)
    assert spacing(large) == pytest.approx((2e-6, 2e-6))
    assert float(large.std()) == pytest.approx(1e-7, rel=0.1)
    q, power = isotropic_spectrum(large)
    known_q, power_known = isotropic_spectrum(window)
    inside = (known_q > 2 * np.pi / 5e-5) & (known_q < 2 * np.pi / 2e-5)
    assert np.interp(known_q[inside], q, power) == pytest.approx(power_known[inside], rel=0.5)


def test_hard_maps_are_what_they_are_called():
    maps = cases.hard_surfaces()
    assert maps["2 × 500 points"].shape == (2, 500)
    assert spacing(maps["256 × 256 pixels of 1 : 100"]) == pytest.approx((100.0, 1.0))
    bowed = maps["180 × 720 points, a bow of 99 % of the variance"].values
    bow = np.fft.rfft(bowed.mean(axis=0))[1]
    assert 2 * (np.abs(bow) / 720) ** 2 / bowed.var() == pytest.approx(0.99, abs=2e-3)
    assert set(np.unique(maps["256 × 256 points, two heights"])) == {0.0, 1.0}
    walk = maps["profile of 100 000 points, random walk"].values[0]
    assert np.abs(np.diff(walk)).max() < 1.1
    assert abs(walk[0] - walk[-1]) < 1.1
    assert all(np.isfinite(hard_map).all() for hard_map in maps.values())


def test_maps_that_cannot_be_solved_are_left_out(tmp_path):
    (tmp_path / "notes.txt").write_text("nothing of interest\n")
    (tmp_path / "tiny.txt").write_text("# unit: um\n" + "1 2 3\n2 3 1\n3 1 2\n")
    rough = self_affine_surface((80, 100), 1e-6, hurst=0.8, shortest=8e-6, longest=4e-5, rms_height=1e-7)
    text = "# Width: 100 µm\n# Height: 80 µm\n# Value units: m\n"
    np.savetxt(tmp_path / "rough.txt", rough.values, header=text, comments="")
    np.savetxt(tmp_path / "bare.txt", rough.values * 1e6)  # the work does not depend on the scale
    cases_by_name = {name: (window, square) for name, window, square in cases.measured_maps([tmp_path])}
    assert set(cases_by_name) == {"rough.txt", "bare.txt"}
    window, square = cases_by_name["rough.txt"]
    assert window.shape != square.shape
    assert square.shape[0] == square.shape[1]


@pytest.mark.parametrize("first_tolerance", [2.0**-4, 2.0**-20])
def test_the_loosest_tolerance_is_found_from_above_and_from_below(first_tolerance):
    tolerances = []

    def run(tolerance):
        tolerances.append(tolerance)
        return {"true_error": 0.01 * tolerance}

    assert race.loosest(run, first_tolerance) == {"tolerance": 2.0**-7, "true_error": 0.01 * 2.0**-7}
    assert len(tolerances) == len(set(tolerances))


def test_no_tolerance_is_found_where_none_does_and_a_code_that_fails_is_not_asked_for_more():
    assert race.loosest(lambda tolerance: {"true_error": 1.0}, 2.0**-10) == {}
    errors = iter([np.inf])
    assert race.loosest(lambda tolerance: {"true_error": next(errors)}, 2.0**-10) == {}


def test_long_solves_are_timed_less_often():
    assert race.most_repeats(20.0) == 1
    assert race.most_repeats(4.0) == 2
    assert race.most_repeats(0.1) > 1000


def test_the_coarsest_grid_of_aspher_is_its_grid_over_a_power_of_two():
    coarsest = [race.options_of("ASPHER", n)["coarsest"] for n in (256, 432, 270, 576, 2048)]
    assert coarsest == [32, 27, 135, 36, 32]
    assert race.options_of("Tamaas", 256) == {}


def test_every_transform_is_counted(monkeypatch):
    """The pairs of a solve are the transforms that were made, each by the points of its grid."""
    transform_sizes = []

    def counting(transform):
        def counted(self, *arguments, **options):
            transform_sizes.append(np.prod(self.shape))
            return transform(self, *arguments, **options)

        return counted

    kinds = [fft.Plan]
    for kind in kinds:
        kinds += kind.__subclasses__()
        for name in ("forward", "inverse"):
            if name in vars(kind):
                monkeypatch.setattr(kind, name, counting(vars(kind)[name]))
    window = self_affine_surface((60, 96), 1.0, hurst=0.8, shortest=4.0, longest=30.0, rms_gradient=1.0)
    for load in (0.003, 0.3, 10.0):
        transform_sizes.clear()
        contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=load)
        assert float(contact["operator_applications"][0]) == pytest.approx(
            0.5 * sum(transform_sizes) / window.size
        )


def kept_records():
    """Return results as the script keeps them, of few cases with numbers that are easily checked."""

    def case(group, name, size, threads, **seconds):
        codes = {code: {"seconds": time, "true_error": 1e-4} for code, time in seconds.items()}
        return {"group": group, "name": name, "size": size, "load": 0.03, "threads": threads, "codes": codes}

    def solves(ratio):
        of_bound = {
            "converged": True,
            "floor": 1e-13,
            "bound": 1.02e-5,
            "true_error": 1e-5,
            "reference_error": 1e-12,
        }
        of_bound |= {"ratio": 1.02, "resolved": True, "way": "default"}
        default = [
            of_bound | {"load": load, "tolerance": tolerance, "pairs": pairs * ratio}
            for load in cases.LOADS
            for tolerance, pairs in ((1e-4, 6.5), (1e-8, 11.0))
        ]
        missed = {"way": "single precision", "pairs": 99.0, "converged": False, "floor": 1e-3, "load": 1.0}
        reached = {"way": "single precision", "pairs": 9.0, "load": 0.3}
        return [*default, default[0] | missed, default[0] | reached]

    race = [
        case("made", "made 512 0", 512, 1, roughcontact=0.01, ASPHER=0.04, Tamaas=1.0),
        case("made", "made 512 1", 512, 1, roughcontact=0.01, ASPHER=0.09, Tamaas=4.0),
        case("measured", "a_map.sur", 432, 1, roughcontact=0.01, ASPHER=0.06),
        case("made", "made 512 0", 512, 2, roughcontact=0.005, ASPHER=0.04),
    ]
    maps = [
        {"name": name, "shape": [4, 5], "solves": solves(i + 1)}
        for i, name in enumerate(("a_map.sur", "b.sur"))
    ]
    records = {
        "race": race,
        "maps": maps,
        "made": [
            {"name": "128²", "solves": [{"tolerance": 1e-4, "pairs": 6.5}]},
            {"name": "256²", "solves": [{"tolerance": 1e-4, "pairs": 8.5}]},
        ],
        "hard": [{"name": "primes", "solves": solves(1.0)}],
        "dense": [{"name": "dense", "solves": solves(1.0)}],
        "growth": [
            {"kind": kind, "size": size, "load": load, "pairs": [size / 64, 11.0]}
            for kind in ("made", "measured")
            for size in (512, 1024)
            for load in (0.003, 0.03)
        ],
        "starts": [{"pip": 9.0, "first": 0.5}, {"imports": 0.3}],
        "pair": [{"points per side": 1024, "pair (ms)": 1.0, "pairs": 6.5, "solve / pair": 8.0}],
        "sweep": [{"points per side": 1024, "one call (ms)": 1234.5, "share of time (%)": 50.0}],
        "memory": [{"code": "roughcontact", "size": 512, "bytes_per_point": 44.2}],
    }
    about = {"machine": {"cores": 2}, "versions": {"roughcontact": {"roughcontact": "0.1.0"}}}
    return {part: dict(enumerate(case_records)) for part, case_records in records.items()} | {"about": about}


def test_the_tables_have_the_numbers_of_the_records():
    tables = speed_tables.tables(kept_records())
    lines_by_table = {name: frame.to_csv(index=False).splitlines() for name, frame in tables.items()}
    assert lines_by_table["race"][1:] == [
        "1,synthetic,2,512,0.03,10,60,2000,6.0,200.0",  # geometric means
        "1,a_map.sur,1,432,0.03,10,60,,6.0,",
        "2,synthetic,1,512,0.03,5,40,,8.0,",
    ]
    assert '1,ASPHER,all,3,6.0,4.0,"synthetic, 512², seed 0",0.03' in lines_by_table["ratios"]
    assert "1e-4,all,9.8,9.8,13.0,13.0" in lines_by_table["pairs"]
    assert "1e-8,0.3,16.5,16.5,20.9,22.0" in lines_by_table["pairs"]
    assert lines_by_table["hardest"][1] == "b.sur,4 × 5,0.003,13.0,22.0"
    assert lines_by_table["settings"][1:] == ["single precision,9.0,9.0,9.0,9.0,2,2"]
    assert lines_by_table["made"][1::2] == ["1e-4,128²,6.5,6.5,6.5,6.5", "1e-4,all,7.5,7.5,8.3,8.5"]
    assert lines_by_table["dense"][1] == "10,1.020,1.020,1.020,0"
    assert lines_by_table["bounds"][1] == "1e-4,8,1.020,1.020,1.020,0"
    assert lines_by_table["hard"][1] == "primes,6.5,11.0,1,0"
    assert lines_by_table["growth"][3] == "synthetic,0.03,1e-4,8.0,16.0,2.00"
    assert lines_by_table["growth"][6] == "measured,0.003,1e-8,11.0,11.0,"
    assert lines_by_table["starts"][1:] == ["pip,9000", "first,500", "imports,300"]
    assert lines_by_table["pair"][1] == "1024,1,6.5,8.0"
    assert lines_by_table["sweep"][1] == "1024,1230,50"
    assert lines_by_table["memory"][1] == "roughcontact,44"


def test_this_solver_alone_has_no_ratios():
    results = {"race": {"a": kept_records()["race"][2] | {"codes": {"roughcontact": {"seconds": 0.01}}}}}
    tables = speed_tables.tables(results)
    assert tables.keys() == {"race"}
    assert tables["race"].columns.tolist()[-1] == "roughcontact (ms)"


def test_a_bound_below_the_true_error_is_counted():
    results = kept_records()
    for part in ("hard", "dense"):
        results[part][0]["solves"][0]["true_error"] = 1.03e-5
        assert speed_tables.tables(results)[part]["bound below error"].tolist() == ["1"]


def test_the_dense_solution_is_that_of_a_wave():
    """Westergaard (1939): full contact from p̄ = π E* h/λ on, the pressure follows the wave."""
    wave = height_map(0.01 * np.cos(2 * np.pi * np.arange(32) / 32)[None], 1 / 32)
    pressure = certificate.dense_pressure(wave, 1.0)
    assert pressure.mean() > np.pi * 0.01
    assert pressure - pressure.mean() == pytest.approx(np.pi * wave.values, abs=1e-10)


@pytest.mark.parametrize("solve", [certificate.random_solve, certificate.dense_solve])
def test_a_random_solve_is_held_against_its_reference(solve):
    record = solve(np.random.default_rng(3))
    assert record["converged"]
    assert 0 < record["true_error"] <= record["bound"] + record["reference_error"]


def test_a_busy_machine_is_told():
    results = kept_records()
    description = speed_tables.about(results)
    assert (
        description["points"],
        description["one load (ms)"],
        description["maps"],
        description["busy"],
    ) == (512, "10", 2, False)
    results["about"]["load"] = {"pair": 0.1, "race": 11.6}
    assert speed_tables.about(results)["busy"]


def test_a_stopped_measurement_goes_on(tmp_path):
    def study():
        options = speed.parse(["--work", str(tmp_path), "--rivals", str(tmp_path / "none")])
        return speed.Study(options)

    runs = []

    def part(stop):
        def jobs(_):
            for name in "abc":
                yield name, lambda name=name: runs.append(name) or stop(name)

        return jobs

    def interrupted(name):
        if name == "b":
            raise KeyboardInterrupt
        return {"of": name}

    speed.PARTS["trial"] = part(interrupted)
    with pytest.raises(KeyboardInterrupt):
        study().measure("trial", again=False)
    speed.PARTS["trial"] = part(lambda name: {"of": name})
    study().measure("trial", again=False)
    assert runs == ["a", "b", "b", "c"]
    study().measure("trial", again=True)
    assert runs[4:] == ["a", "b", "c"]
    stored = json.loads((tmp_path / "speed.json").read_text())
    assert stored["trial"] == {name: {"of": name} for name in "abc"}
    del speed.PARTS["trial"]


def test_a_window_that_has_changed_drops_what_is_known_of_it(tmp_path):
    study = speed.Study(speed.parse(["--work", str(tmp_path), "--rivals", str(tmp_path / "none")]))
    path = study.measured("a.sur", np.zeros((4, 4)))
    truth = study.surfaces / f"truth 0.03 {path.name}"
    other_truth = study.surfaces / "truth 0.03 measured b.sur.npy"
    for file in (truth, other_truth):
        file.touch()
    study.results["rungs"] = {"a.sur 0.03 ASPHER": {}, "b.sur 0.03 ASPHER": {}}
    study.measured("a.sur", np.zeros((4, 4)))
    assert truth.exists()
    assert len(study.results["rungs"]) == 2
    study.measured("a.sur", np.ones((4, 4)))
    assert not truth.exists()
    assert other_truth.exists()
    assert list(study.results["rungs"]) == ["b.sur 0.03 ASPHER"]


def test_a_case_of_the_race_from_end_to_end(tmp_path):
    """This solver alone, on one small map: the worker solves it to the true error that is asked for."""
    words = ["--work", str(tmp_path), "--rivals", str(tmp_path / "none"), "--sizes", "64", "--seeds", "0"]
    study = speed.Study(speed.parse([*words, "--threads", "1", "--repeats", "1"]))
    study.results["about"] = {}
    with study.workers:
        name, job = next(race.race(study))
        result = job()
    assert name == "made 64 0 0.003 threads 1"
    of_code = result["codes"]["roughcontact"]
    assert 0 < of_code["true_error"] <= 1e-4
    assert 0 < of_code["seconds"] < 5
