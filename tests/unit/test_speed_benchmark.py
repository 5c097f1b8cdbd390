"""The benchmark of speed: its surfaces, its search for tolerances, its counts, its page and its sentence."""

import importlib
import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.kernels import fft
from roughcontact.maps import height_map, spacing
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.roughness.spectrum import isotropic_spectrum

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def script():
    """The modules of `benchmarks/speed.py`, by name."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    names = ("cases", "counts", "race", "speed", "speed_page")
    yield SimpleNamespace(**{name: importlib.import_module(name) for name in names})
    sys.path.remove(str(ROOT / "benchmarks"))


def test_a_made_surface_is_what_the_page_says(script):
    heights = script.cases.surface(64, seed=1)
    assert rms_gradient(height_map(heights, 1 / 64)) == pytest.approx(1, rel=1e-12)
    power = np.abs(np.fft.fft2(heights)) ** 2
    k = np.hypot(*np.meshgrid(np.fft.fftfreq(64, 1 / 64), np.fft.fftfreq(64, 1 / 64)))
    inside = (k >= 4) & (k <= 8)
    assert power[~inside].max() < 1e-20 * power.max()
    slope = np.polyfit(np.log(k[inside]), np.log(power[inside]), 1)[0]
    assert slope == pytest.approx(-2 * (1 + 0.8), rel=1e-9)


def test_an_enlarged_map_has_the_spectrum_of_the_window(script):
    window = self_affine_surface((90, 96), 2e-6, hurst=0.7, shortest=1.6e-5, longest=6e-5, rms_height=1e-7)
    large = script.cases.enlarged(window, 384)
    assert spacing(large) == pytest.approx((2e-6, 2e-6))
    assert float(large.std()) == pytest.approx(1e-7, rel=0.1)
    q, power = isotropic_spectrum(large)
    known_q, known = isotropic_spectrum(window)
    inside = (known_q > 2 * np.pi / 5e-5) & (known_q < 2 * np.pi / 2e-5)
    assert np.interp(known_q[inside], q, power) == pytest.approx(known[inside], rel=0.5)


def test_hard_maps_are_what_they_are_called(script):
    maps = script.cases.hard_surfaces()
    assert maps["2 × 500 points"].shape == (2, 500)
    assert spacing(maps["256 × 256 pixels of 1 : 100"]) == pytest.approx((100.0, 1.0))
    bowed = maps["180 × 720 points, a bow of 99 % of the variance"].values
    bow = np.fft.rfft(bowed.mean(axis=0))[1]
    assert 2 * (np.abs(bow) / 720) ** 2 / bowed.var() == pytest.approx(0.99, abs=2e-3)
    assert set(np.unique(maps["256 × 256 points, two heights"])) == {0.0, 1.0}
    walk = maps["profile of 100 000 points, random walk"].values[0]
    assert np.abs(np.diff(walk)).max() < 1.1
    assert abs(walk[0] - walk[-1]) < 1.1
    assert all(np.isfinite(one).all() for one in maps.values())


def test_maps_that_cannot_be_solved_are_left_out(script, tmp_path):
    (tmp_path / "notes.txt").write_text("nothing of interest\n")
    (tmp_path / "tiny.txt").write_text("# unit: um\n" + "1 2 3\n2 3 1\n3 1 2\n")
    rough = self_affine_surface((80, 100), 1e-6, hurst=0.8, shortest=8e-6, longest=4e-5, rms_height=1e-7)
    text = "# Width: 100 µm\n# Height: 80 µm\n# Value units: m\n"
    np.savetxt(tmp_path / "rough.txt", rough.values, header=text, comments="")
    np.savetxt(tmp_path / "bare.txt", rough.values * 1e6)  # the work does not depend on the scale
    found = {name: (window, square) for name, window, square in script.cases.measured_maps([tmp_path])}
    assert set(found) == {"rough.txt", "bare.txt"}
    window, square = found["rough.txt"]
    assert window.shape != square.shape
    assert square.shape[0] == square.shape[1]


@pytest.mark.parametrize("first", [2.0**-4, 2.0**-20])
def test_the_loosest_tolerance_is_found_from_above_and_from_below(script, first):
    asked = []

    def run(tolerance):
        asked.append(tolerance)
        return {"true_error": 0.01 * tolerance, "seconds": 1.0}

    found = script.race.loosest(run, first)
    assert found == {"tolerance": 2.0**-7, "true_error": 0.01 * 2.0**-7, "seconds": 1.0}
    assert len(asked) == len(set(asked))


def test_no_tolerance_is_found_where_none_does(script):
    assert script.race.loosest(lambda tolerance: {"true_error": 1.0}, 2.0**-10) == {}


def test_a_code_that_fails_is_not_asked_for_more(script):
    asked = []

    def run(tolerance):
        asked.append(tolerance)
        return {"true_error": np.inf, "seconds": np.inf}

    assert script.race.loosest(run, 2.0**-10) == {}
    assert asked == [2.0**-10]


def test_long_solves_are_timed_less_often(script):
    assert script.race.most_repeats(20.0) == 1
    assert script.race.most_repeats(4.0) == 2
    assert script.race.most_repeats(0.1) > 1000


def test_the_coarsest_grid_of_aspher_is_its_grid_over_a_power_of_two(script):
    found = [script.race.options_of("ASPHER", n)["coarsest"] for n in (256, 432, 270, 576, 2048)]
    assert found == [32, 27, 135, 36, 32]
    assert script.race.options_of("Tamaas", 256) == {}


def test_every_transform_is_counted(script, monkeypatch):
    """The pairs of a solve are the transforms that were made, each by the points of its grid."""
    made = []

    def counting(transform):
        def counted(self, *arguments):
            made.append(np.prod(self.shape))
            return transform(self, *arguments)

        return counted

    kinds = [fft.Plan]
    for kind in kinds:
        kinds += kind.__subclasses__()
        for name in ("forward", "inverse"):
            if name in vars(kind):
                monkeypatch.setattr(kind, name, counting(vars(kind)[name]))
    window = self_affine_surface((60, 96), 1.0, hurst=0.8, shortest=4.0, longest=30.0, rms_gradient=1.0)
    for load in (0.003, 0.3, 10.0):
        made.clear()
        contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=load)
        assert float(contact["operator_applications"][0]) == pytest.approx(0.5 * sum(made) / window.size)


def kept_records(script):
    """Return results as the script keeps them, of few cases with numbers that are easily checked."""

    def case(group, name, size, load, threads, **seconds):
        codes = {code: {"seconds": time, "true_error": 1e-4} for code, time in seconds.items()}
        known = {"group": group, "name": name, "size": size, "load": load, "threads": threads}
        return known | {"codes": codes}

    def solves(ratio):
        found = []
        for load in script.cases.LOADS:
            for tolerance, pairs in ((1e-4, 6.5), (1e-8, 11.0)):
                found.append(
                    {
                        "way": "default",
                        "load": load,
                        "tolerance": tolerance,
                        "pairs": pairs * ratio,
                        "converged": True,
                        "floor": 1e-13,
                        "bound": 1.02e-5,
                        "true_error": 1e-5,
                        "reference_error": 1e-12,
                        "ratio": 1.02,
                        "resolved": True,
                    }
                )
            found.append(found[-1] | {"way": "single precision", "pairs": 9.0, "tolerance": 1e-4})
        return found

    race = [
        case("made", "made 512 0", 512, 0.03, 1, roughcontact=0.01, ASPHER=0.04, Tamaas=1.0),
        case("made", "made 512 1", 512, 0.03, 1, roughcontact=0.01, ASPHER=0.09, Tamaas=4.0),
        case("measured", "a_map.sur", 432, 0.03, 1, roughcontact=0.01, ASPHER=0.06),
        case("made", "made 512 0", 512, 0.03, 2, roughcontact=0.005, ASPHER=0.04),
    ]
    process = {"whole": 0.5, "imports": 0.3, "first": 0.02, "second": 0.01}
    one = {"size": 512, "threads": 1}
    return {
        "about": {
            "machine": {"processor": "P", "cores": 2, "memory_GiB": 24, "system": "Linux", "python": "3.11"},
            "versions": {"roughcontact": {"roughcontact": "0.1.0"}},
        },
        "race": {str(number): each for number, each in enumerate(race)},
        "maps": {
            "a_map.sur": {"name": "a_map.sur", "shape": [432, 500], "solves": solves(1.0)},
            "b.sur": {"name": "b.sur", "shape": [432, 500], "solves": solves(2.0)},
        },
        "hard": {"primes": {"name": "primes", "solves": [s | {"seed": 0} for s in solves(1.0)]}},
        "growth": {
            str(size): {"kind": "made", "size": size, "load": 0.03, "pairs": [6.5, 11.0]}
            for size in (512, 1024)
        },
        "starts": {
            "installation": {"pip_seconds": 9.0, "first": process, "second": process},
            "process": process,
        },
        "pair": {"512": one | {"pairs": 6.5, "pair": 0.001, "solve": 0.008}},
        "sweep": {
            "512": one | {"one": {"seconds": 1.0, "pairs": 90.0}, "many": {"seconds": 2.0, "pairs": 100.0}}
        },
        "memory": {"512": {"code": "roughcontact", "size": 512, "bytes_per_point": 44.2}},
    }


def test_the_page_shows_every_row(script):
    text = script.speed_page.page(kept_records(script), "benchmark.png")
    for row in (
        "| made × 2 | 512² | 0.03 | 10 ms | 60 ms | 2 s | **6.0** | **200.0** |",
        "| a\\_map.sur | 432² | 0.03 | 10 ms | 60 ms | – | **6.0** | – |",
        "- ASPHER / roughcontact, all maps: geometric mean **6.0** over 3 cases, least **4.0** (made, 512²",
        "| made × 1 | 512² | 0.03 | 5 ms | 40 ms | **8.0** |",
        "| 1e-8 | 16.5 / 20.9 / 22.0 | 16.5 / 20.9 / 22.0 |",
        "| b.sur | 432 × 500 | 0.003 | 13.0 | 22.0 |",
        "| single precision | 9.0 / 9.0 / 9.0 | none |",
        "| 1e-4 | 8 | 1.020 | 1.020 | 1.020 | 0 |",
        "| primes | 6.5 | 11.0 | 0 | 0 |",
        "| made | 0.03 | 6.5 / 11.0 | 6.5 / 11.0 | 1.00 |",
        "| a process of an environment in use (median) | 500 ms |",
        "| 512² | 1 | 1 ms | 8 ms | 6.5 | **8.0** |",
        "| 512² | 1 | 1 s | 2 s | 50% | 90% |",
        "| roughcontact | 44 |",
        "| aim | trial | what it gave |",
        "## What is not met, and what was tried",
    ):
        assert row in text
    assert max(len(line) for line in text.splitlines() if not line.startswith(("|", "-"))) <= 110


def test_the_page_says_when_the_machine_was_busy(script):
    results = kept_records(script)
    assert "Other programs ran" not in script.speed_page.page(results, "benchmark.png")
    results["about"]["load"] = {"pair": 0.1, "race": 11.6}
    assert "(load average 12 before the start)" in script.speed_page.page(results, "benchmark.png")
    assert script.speed_page.sentence(results).startswith("On 2 measured maps")


def test_the_sentence_stands_on_the_page_and_between_its_marks(script, tmp_path):
    results = kept_records(script)
    said = script.speed_page.sentence(results)
    assert "On 2 measured maps a load takes a median of 9.8 pairs" in said.replace("\n", " ")
    assert said in script.speed_page.page(results, "benchmark.png")
    readme = tmp_path / "README.md"
    readme.write_text(f"before\n{script.speed_page.BEGIN}\nold\n{script.speed_page.END}\nafter\n")
    script.speed_page.write_sentence(results, readme)
    assert readme.read_text() == (
        f"before\n{script.speed_page.BEGIN}\n{said}\n{script.speed_page.END}\nafter\n"
    )
    readme.write_text("no marks\n")
    with pytest.raises(ValueError, match="has no lines"):
        script.speed_page.write_sentence(results, readme)


def test_the_page_and_its_figure_are_written(script, tmp_path):
    script.speed_page.write(kept_records(script), tmp_path / "benchmark.md")
    assert (tmp_path / "benchmark.md").read_text(encoding="utf-8").startswith("# Benchmark\n")
    assert (tmp_path / "benchmark.png").stat().st_size > 10_000


def test_a_stopped_measurement_goes_on(script, tmp_path):
    def study():
        options = script.speed.parse(["--work", str(tmp_path), "--rivals", str(tmp_path / "none")])
        return script.speed.Study(options)

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

    script.speed.PARTS["trial"] = part(interrupted)
    with pytest.raises(KeyboardInterrupt):
        study().measure("trial", again=False)
    script.speed.PARTS["trial"] = part(lambda name: {"of": name})
    study().measure("trial", again=False)
    assert runs == ["a", "b", "b", "c"]
    study().measure("trial", again=True)
    assert runs[4:] == ["a", "b", "c"]
    kept = json.loads((tmp_path / "speed.json").read_text())
    assert kept["trial"] == {name: {"of": name} for name in "abc"}
    del script.speed.PARTS["trial"]


def test_a_window_that_has_changed_drops_what_is_known_of_it(script, tmp_path):
    study = script.speed.Study(
        script.speed.parse(["--work", str(tmp_path), "--rivals", str(tmp_path / "none")])
    )
    path = study.measured("a.sur", np.zeros((4, 4)))
    truth = study.surfaces / f"truth 0.03 {path.name}"
    other = study.surfaces / "truth 0.03 measured b.sur.npy"
    for file in (truth, other):
        file.touch()
    study.results["rungs"] = {"a.sur 0.03 ASPHER": {}, "b.sur 0.03 ASPHER": {}}
    study.measured("a.sur", np.zeros((4, 4)))
    assert truth.exists()
    assert len(study.results["rungs"]) == 2
    study.measured("a.sur", np.ones((4, 4)))
    assert not truth.exists()
    assert other.exists()
    assert list(study.results["rungs"]) == ["b.sur 0.03 ASPHER"]


def test_a_case_of_the_race_from_end_to_end(script, tmp_path):
    """This solver alone, on one small map: the worker solves it to the true error that is asked for."""
    words = ["--work", str(tmp_path), "--rivals", str(tmp_path / "none"), "--sizes", "64", "--seeds", "0"]
    study = script.speed.Study(script.speed.parse([*words, "--threads", "1", "--repeats", "1"]))
    study.results["about"] = {}
    with study.workers:
        name, job = next(script.race.race(study))
        found = job()
    assert name == "made 64 0 0.003 threads 1"
    of_code = found["codes"]["roughcontact"]
    assert 0 < of_code["true_error"] <= 1e-4
    assert 0 < of_code["seconds"] < 5
