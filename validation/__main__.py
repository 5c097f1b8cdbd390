"""Compute all sections of the validation side by side: `python3 run.py validation`."""

import argparse
import multiprocessing
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from roughcontact.errors import RoughContactError
from validation import SECTIONS
from validation.lines import Section
from validation.page import check, write_page, write_table
from validation.sections import validate

SAMPLE = Path(__file__).parents[1] / "data_samples/sandblasted.x3p"


def compute(*, finest_grid: int, cores: int | None = None) -> list[Section]:
    """Compute all sections, each in a process with one thread: sums do not depend on the computer."""
    os.environ["OMP_NUM_THREADS"] = "1"
    one = partial(validate, sample=SAMPLE, finest_grid=finest_grid)
    with ProcessPoolExecutor(cores, multiprocessing.get_context("spawn")) as processes:
        return list(processes.map(one, SECTIONS))


def main(arguments: Sequence[str]) -> int:
    """Write page and table, print how many lines hold, and return 1 where one does not."""
    parser = argparse.ArgumentParser(prog="run.py validation", description=__doc__)
    parser.add_argument(
        "--finest-grid", type=int, default=2048, help="points along the finest grid, a power of 2 from 256 on"
    )
    parser.add_argument("--cores", "-c", type=int, help="sections computed at once")
    parser.add_argument(
        "--directory", "-d", type=Path, default=Path(), help="where results/validation is written"
    )
    options = parser.parse_args(arguments)
    folder = options.directory / "results/validation"
    page = folder / "validation.html"
    try:
        sections = compute(finest_grid=options.finest_grid, cores=options.cores)
        folder.mkdir(parents=True, exist_ok=True)
        write_page(page, sections)
        write_table(folder / "lines.csv", sections)
        count = check(sections, page)
    except RoughContactError as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    print(f"all {count} lines hold: {page}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
