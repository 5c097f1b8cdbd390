"""Measure the whole chain: stages by size of the map, studies by number of surfaces, against plain scripts.

    python benchmarks/chain.py --write

Every process is measured by itself (`clock/sitecustomize.py`). Results are kept in the output folder after
every part; a later call adds to them or replaces what it measures again.
"""

import argparse
import json
import os
import platform
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pages
import pandas as pd
from cases import relative_error, surface
from speed import machine

import roughcontact as rc
from roughcontact.arguments.maps import spacing
from roughcontact.surface.roughness.parameters import rms_gradient

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
LIBRARY = ROOT / "workflow/lib"
SLOPE = 0.1  # rms gradient of the maps, whose points are 1 um apart
MODULUS = 1e9  # Pa
STAGES = ("prepare", "contact", "panel", "report")
ONCE = ("", "report", "imports", "run")  # whatever the number of surfaces
FEW, MANY = [0.01, 0.05, 0.2], np.geomspace(0.003, 0.3, 8).tolist()  # over E* and the rms gradient
CASES = {
    "hard": {},
    "soft": {"contact": {"contact_modulus": MODULUS / 10}},
    "raw": {"window": {"method": "raw"}},
}
RIVALS = {"Tamaas": "plain_tamaas.py", "ContactMechanics": "plain_contactmechanics.py"}


def heights(folder: Path, size: int, seed: int = 0) -> Path:
    """Return the file of a made map in um, written where it is missing."""
    path = folder / f"map-{size}-{seed}.npy"
    if not path.exists():
        np.save(path, SLOPE * size * surface(size, seed))
    return path


def study(folder: Path, *, files: list[Path], settings: dict) -> Path:
    """Write settings and table of a study of so many maps into an empty folder, and return it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    rows = ["surface\tpath\tunit\tdx\tdy"]
    rows += [f"s{i}\t{file}\tum\t1\t1" for i, file in enumerate(files)]
    (folder / "surfaces.tsv").write_text("\n".join(rows) + "\n")
    contact = {"contact": {"contact_modulus": MODULUS, "relative_pressure": FEW}}
    (folder / "settings.json").write_text(json.dumps({"surfaces": "surfaces.tsv"} | contact | settings))
    return folder


def take(command: list, folder: Path) -> dict:
    """Run a command; return its wall and CPU time, its output, and what each of its processes took."""
    clock = folder / "clock.jsonl"
    clock.unlink(missing_ok=True)
    paths = [str(HERE / "clock"), str(LIBRARY)]
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    # compiled modules are kept, as where nobody has said otherwise
    usual = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    variables = usual | threads | {"CLOCK": str(clock), "PYTHONPATH": os.pathsep.join(paths)}
    usage_before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    run = subprocess.run(
        list(map(str, command)), cwd=folder, env=variables, capture_output=True, text=True, check=False
    )
    wall, usage_after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}\n{run.stdout}{run.stderr}")
    used = usage_after.ru_utime + usage_after.ru_stime - usage_before.ru_utime - usage_before.ru_stime
    processes = [json.loads(line) for line in clock.read_text().splitlines()] if clock.exists() else []
    return {"wall": wall, "cpu": used, "output": run.stdout, "processes": processes}


def workflow(folder: Path, *arguments: str, cores: int = 1) -> dict:
    """Run the workflow in a folder."""
    words = [
        sys.executable,
        "-m",
        "roughcontact.interface",
        "run",
        "--configfile",
        "settings.json",
    ]
    return take([*words, "--cores", str(cores), *arguments], folder)


def stage_of(process: dict) -> str:
    """Return what a process of a run did: a job, `imports` of all, `run` of Snakemake, nothing of others."""
    script = Path(process["script"])
    if script.name == "server.py":
        return "imports"
    if script.parent.name == "scripts":
        return script.stem
    return "run" if "snakemake.cli" in "".join(process["command"][1:3]) else ""


def measure_stages(work: Path, size: int) -> dict:
    """Return CPU time and peak memory of every job of one map, three loads."""
    folder = study(work / "stages", files=[heights(work, size)], settings={})
    process_results = workflow(folder)
    stages = {
        stage: {"cpu": process["cpu"], "peak_MB": process["peak_MB"]}
        for process in process_results["processes"]
        if (stage := stage_of(process))
    }
    return {"size": size, "stages": stages, "cpu": process_results["cpu"], "wall": process_results["wall"]}


def measure_study(work: Path, *, number: int, size: int, cores: int) -> dict:
    """Return what a study of three cases takes, its second run, and the size of its pages."""
    files = [heights(work, size, seed) for seed in range(number)]
    folder = study(work / "study", files=files, settings={"cases": CASES})
    first_run = workflow(folder, cores=cores)
    second_run = workflow(folder, cores=cores)
    reports = [folder / "results/report.html", *folder.glob("results/pages/*")]
    jobs = [process for process in first_run["processes"] if stage_of(process) not in ("", "imports", "run")]
    snakemake_time = sum(process["cpu"] for process in first_run["processes"] if stage_of(process) == "run")
    cpu = sum(process["cpu"] for process in jobs)
    return {
        "surfaces": number,
        "cases": len(CASES),
        "points per side": size,
        "jobs": len(jobs),
        "CPU s of jobs": cpu,
        "CPU s for each result": cpu / number / len(CASES),
        "CPU s of Snakemake": snakemake_time,
        "wall s": first_run["wall"],
        "cores": cores,
        "second run (s)": second_run["wall"],
        "pages (MB)": sum(page.stat().st_size for page in reports) / 1e6,
    }


def measure_plan(work: Path, *, number: int) -> dict:
    """Return what the dry run of a study of three cases takes."""
    folder = study(work / "plan", files=[heights(work, 64)] * number, settings={"cases": CASES})
    usage = workflow(folder, "-n")
    lines = usage["output"].count("\n")
    return {
        "surfaces": number,
        "cases": len(CASES),
        "wall s": usage["wall"],
        "CPU s": usage["cpu"],
        "lines": lines,
    }


def measured(folder: Path, path: Path) -> tuple[Path, float]:
    """Return the file of a measured map, all steps 1 um, and the rms gradient of its window."""
    height = rc.read_height_map(path)
    file = folder / f"{path.stem}.npy"
    np.save(file, height.values / min(spacing(height)))
    return file, rms_gradient(rc.periodic_window(rc.level(height)))


def measure_scripts(
    work: Path, name: str, file: Path, gradient: float, *, python: Path, codes: list[str]
) -> list[dict]:
    """Return what one map with eight loads takes, file to numbers, by this program and by plain scripts."""
    loads = [MODULUS * gradient * load for load in MANY]
    own_command = [
        sys.executable,
        "-m",
        "roughcontact.interface",
        "solve",
        file,
        "--json",
        "--threads",
        "1",
    ]
    own_command += [
        "--dx",
        "1",
        "--dy",
        "1",
        "--unit",
        "um",
        "--contact-modulus",
        MODULUS,
        "--mean-pressure",
        *loads,
    ]
    plain = ["--level-form", "plane", "--window-method", "raw", "--uncertainty-sources"]
    take([*own_command, *plain], work)  # loads what is loaded once
    bare, budget = take([*own_command, *plain], work), take(own_command, work)
    contact = {"contact_modulus": MODULUS, "mean_pressure": loads}
    chain = workflow(study(work / "chain", files=[file], settings={"contact": contact}))
    jobs = sum(process["cpu"] for process in chain["processes"] if stage_of(process) not in ONCE)
    usages = {"without error budget": bare, "with error budget": budget, "whole chain": chain}
    row_of_map = {"map": name, "points": " × ".join(map(str, np.load(file, mmap_mode="r").shape))}
    rows = [row_of_map | {"what": what} | _times(usage) for what, usage in usages.items()]
    rows.append(row_of_map | {"what": "jobs of the surface alone", "CPU s": jobs})
    areas = [load["relative_contact_area_pixels"] for load in json.loads(bare["output"])["loads"]]
    for code in codes:
        usage = take([python, HERE / RIVALS[code], file, *(load / MODULUS for load in loads)], work)
        difference = relative_error(np.array(json.loads(usage["output"].splitlines()[-1])), np.array(areas))
        ratios = {f"times {what}": float(f"{usage['cpu'] / one['cpu']:.2g}") for what, one in usages.items()}
        rows.append(row_of_map | {"what": code} | _times(usage) | ratios | {"area off": f"{difference:.1e}"})
    return rows


def _times(usage: dict) -> dict:
    return {"CPU s": usage["cpu"], "wall s": usage["wall"]}


def tables(results: dict) -> dict[str, pd.DataFrame]:
    """Return CPU time and memory of the stages, and what studies, dry runs and scripts take."""
    stages = {f"{size}²": results["stages"][size] for size in sorted(results["stages"], key=int)}
    took = pd.DataFrame({size: entry["stages"] for size, entry in stages.items()}).reindex(
        [*STAGES, "imports", "run"]
    )
    used = {
        what: took.map(
            lambda usage_of_part, what=what: (
                usage_of_part[what] if isinstance(usage_of_part, dict) else np.nan
            )
        )
        for what in ("cpu", "peak_MB")
    }
    used["cpu"].loc["all, CPU s"] = [entry["cpu"] for entry in stages.values()]
    by_number = [
        pd.DataFrame([results[part][number] for number in sorted(results[part], key=int)])
        for part in ("studies", "plans")
    ]
    scripts = [row for rows in results["scripts"].values() for row in rows]
    return {
        "cpu": pages.text(used["cpu"].reset_index(names="stage")),
        "memory": pages.text(used["peak_MB"].reset_index(names="stage"), dict.fromkeys(stages, ".0f")),
        "studies": pages.text(by_number[0], {"CPU s for each result": ".2g", "second run (s)": ".2g"}),
        "plans": pages.text(by_number[1]),
        "scripts": pages.text(pd.DataFrame(scripts)),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure the whole chain.")
    add = parser.add_argument
    add("--sizes", type=int, nargs="*", default=[512, 1024, 2048], help="of maps, points per side")
    add("--studies", type=int, nargs="*", default=[12, 60], help="numbers of surfaces")
    add("--study-size", type=int, default=128, help="points per side of the maps of studies")
    add("--plans", type=int, nargs="*", default=[60, 600], help="numbers of surfaces of dry runs")
    add(
        "--script-sizes", type=int, nargs="*", default=[512], help="of made maps that plain scripts solve too"
    )
    add("--script-files", type=Path, nargs="*", default=[], help="measured maps that plain scripts solve too")
    add("--codes", nargs="*", choices=list(RIVALS), default=list(RIVALS), help="plain scripts")
    add("--rivals", type=Path, default=HERE / ".rivals", help="environment made by setup_rivals.sh")
    add("--cores", type=int, default=len(os.sched_getaffinity(0)), help="of studies")
    add("--output", type=Path, default=HERE / "work/chain", help="folder of maps, runs and results")
    add("--busy", action="store_true", help="say on the page that other work ran beside")
    add("--write", action="store_true", help="write tables and page; else they are printed")
    options = parser.parse_args()
    work = options.output.resolve()
    work.mkdir(parents=True, exist_ok=True)
    results_file = work / "results.json"
    results: dict = json.loads(results_file.read_text()) if results_file.exists() else {}
    for part in ("stages", "studies", "plans", "scripts"):
        results.setdefault(part, {})
    results["busy"] = options.busy
    results["machine"] = machine() | {"python": platform.python_version()}

    def keep(part: str, key: int | str, record: dict | list) -> None:
        results[part][str(key)] = record
        results_file.write_text(json.dumps(results, indent=1))
        print(part, key, flush=True)

    python = options.rivals.absolute() / "bin/python"
    codes = options.codes if python.exists() else []
    scripts = {f"synthetic-{size}": (heights(work, size), SLOPE) for size in options.script_sizes}
    scripts |= {path.name: measured(work, path) for path in options.script_files}
    if options.codes and scripts and not codes:
        print(
            f"no plain scripts: no environment in {options.rivals}; setup_rivals.sh makes it", file=sys.stderr
        )
    for name, (file, gradient) in scripts.items():
        keep("scripts", name, measure_scripts(work, name, file, gradient, python=python, codes=codes))
    for size in options.sizes:
        keep("stages", size, measure_stages(work, size))
    for number in options.plans:
        keep("plans", number, measure_plan(work, number=number))
    for number in options.studies:
        study_times = measure_study(work, number=number, size=options.study_size, cores=options.cores)
        keep("studies", number, study_times)
    if options.write:
        pages.publish("chain", tables(results), {name: results[name] for name in ("machine", "busy")})
    else:
        pages.show(tables(results))


if __name__ == "__main__":
    main()
