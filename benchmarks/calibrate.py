"""Calibrate the ± on a bank of surfaces: errors of parts of measured and synthetic maps, and what told them.

    python benchmarks/calibrate.py FOLDER ... --write          # the bank, the calibration, the tables
    python benchmarks/calibrate.py --fit --write               # calibration and tables from the bank as it is
    python benchmarks/calibrate.py FOLDER ... --held-out       # coverage on maps that are not in the bank

Every map in the folders that is read without being told anything, with 192 points or more along each side, is
cut into 3 x 3 and, where these have 128 points, into 2 x 2 parts. Each part is processed by default settings as
if it were the measurement, at mean pressures p/(E* g) of the whole map. The bank (`results/bank`) keeps, for
each part and load, the results on their scales (`roughcontact.uncertainty.scales`) and the features of
`roughcontact.uncertainty.subwindows`; no heights. Synthetic surfaces of the kinds of `validation.masters` and
of `instruments.other_surface` are treated alike.

Truths: of *the surface* the mean of the other parts, of *the next map* each of them, of the *longer* surface the
whole map, of *one octave shorter* the part itself, its evaluation being that of the part with pixels merged
2 x 2. For *this map* windows of measured maps and synthetic surfaces are taken for one period of a periodic
surface, and measured from another first point, tilted, with spots missing.

The size of the error is fitted to all of them (Student's t with 4 degrees of freedom, so that single outliers
do not decide), arms are quantiles of error over size, each map with the same weight. Coverage, width and
Winkler score (Winkler 1972, J. Am. Stat. Assoc. 67, 187) are those of maps left out one after the other.
"""

import itertools
import json
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import instruments
import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.contact.loads import plan_loads
from roughcontact.errors import RoughContactError
from roughcontact.maps import height_map, spacing
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.magnification import without_shortest_waves
from roughcontact.uncertainty.scales import (
    AREA,
    CONDUCTANCE,
    CONSTRICTIONS,
    GAP,
    PEAK,
    to_scale,
)
from roughcontact.uncertainty.subwindows import scatter_of_subwindows
from roughcontact.validation.masters import KINDS, master_surface

LOADS = (0.005, 0.02, 0.1, 0.4, 1.0)  # of E* times the rms gradient of the whole map
SMALLEST, LARGEST = 192, 540  # points along the sides of a map; larger ones are cut to their middle
CUTS = (3, 2)
LEAST_PART = {3: 64, 2: 128}  # points
MADE_SIDE = 160  # points of a part of a synthetic surface
LONGEST = (1 / 8, 1 / 3, 1.0)  # waves of synthetic surfaces, of the length of a part
OTHER_KINDS = ("cratered", "conical", "stretched", "lognormal")
NAMES = (AREA, GAP, PEAK, CONDUCTANCE, *CONSTRICTIONS)
SHORT = {
    AREA: "area",
    GAP: "gap",
    PEAK: "peak",
    CONDUCTANCE: "conductance",
    "critical_constriction": "narrowest",
}
PLACES = {CONSTRICTIONS[0]: "narrowest_x", CONSTRICTIONS[1]: "narrowest_y"}
FEATURES = ("scatter", "gradient", "height", "lay")
COVERAGE = 0.95
FREEDOM = 4.0  # of Student's t for the errors, in the fit of their size
RIDGE = 0.02  # on the slopes of the features, in their standard deviations
LARGEST_ERROR = 6.0  # of a logarithm; more is a closed gap
BANK = Path(__file__).parent / "results" / "bank"
TABLE = Path(__file__).parents[1] / "workflow/lib/roughcontact/uncertainty/calibration.json"


def evaluated(height, loads: list[float]) -> dict | None:
    """Return results and features (load) of a map by default settings (E* = 1); None where it is refused."""
    try:
        levelled = rc.level(height)
        window = rc.periodic_window(levelled)
        contact = {"contact_modulus": 1.0, "mean_pressure": loads}
        values = solve_member(window, contact, tolerance=1e-4, names=NAMES)
        scatter = scatter_of_subwindows(levelled, window, contact=contact, arguments={}, values=values)
        shorter = without_shortest_waves(window, 2)
        coarse = solve_member(shorter, contact, tolerance=1e-3, names=NAMES)
    except RoughContactError:
        return None
    found = {"shape": levelled.shape}
    with np.errstate(all="ignore"):
        for name in NAMES:
            key = PLACES.get(name) or SHORT[name]
            unit = values[GAP] if name in PLACES else 1.0
            found[key] = to_scale(name, values[name]) / unit
            found[f"{key}_octave"] = found[key] - to_scale(name, coarse[name]) / unit
            features = scatter.features[name] if scatter.features else {}
            found[f"{key}_scatter"] = features.get("scatter", np.full(len(loads), np.nan))
            for feature in FEATURES[1:]:
                found[feature] = np.full(len(loads), features.get(feature, np.nan))
    return found


def merged(height):
    """Return a map with its pixels merged 2 x 2."""
    ny, nx = (n // 2 * 2 for n in height.shape)
    dy, dx = spacing(height)
    values = height.values[:ny, :nx].reshape(ny // 2, 2, nx // 2, 2).mean(axis=(1, 3))
    return height_map(values, (2 * dy, 2 * dx))


def rows_of(name: str, kind: str, height) -> list[dict]:
    """Return the rows of the bank of one map: the whole, its parts, the parts with merged pixels, one period."""
    start = [max(0, (n - LARGEST) // 2) for n in height.shape]
    height = height[start[0] : start[0] + LARGEST, start[1] : start[1] + LARGEST]
    try:
        window = rc.periodic_window(rc.level(height))
    except RoughContactError:
        return []
    loads = [float(p) for p in plan_loads(window, contact_modulus=1.0, relative_pressure=list(LOADS))]
    rows: list[dict] = []

    def add(what: str, number: int, found: dict | None) -> None:
        for index, load in enumerate(LOADS if found else ()):
            numbers = {key: column[index] for key, column in found.items() if key != "shape"}
            rows.append({"map": name, "kind": kind, "what": what, "part": number, "load": load} | numbers)

    add("whole", 0, evaluated(height, loads))
    for cuts in CUTS:
        edges = [np.arange(cuts + 1) * n // cuts for n in height.shape]
        if min(height.shape) // cuts < LEAST_PART[cuts]:
            continue
        for number, (i, j) in enumerate(itertools.product(range(cuts), repeat=2)):
            piece = height[edges[0][i] : edges[0][i + 1], edges[1][j] : edges[1][j + 1]]
            add(f"{cuts}x{cuts}", number, evaluated(piece, loads))
            if cuts == CUTS[0] and min(piece.shape) >= 96:
                add("merged", number, evaluated(merged(piece), loads))
    add("period", 0, evaluated(window, loads))
    generator = np.random.default_rng(len(rows))
    for number in range(2):
        add("measured period", number, evaluated(of_one_period(window, generator), loads))
    return rows


def of_one_period(window, generator):
    """Return one period of a periodic surface as it would be measured: from any point, tilted, with holes."""
    values = np.roll(window.values, generator.integers(0, window.shape), (0, 1)).copy()
    rms = values.std()
    tilt = generator.normal(0, 2 * rms, 2)
    values += sum(
        t * np.linspace(-1, 1, n).reshape([-1, 1] if axis == 0 else [1, -1])
        for axis, (t, n) in enumerate(zip(tilt, values.shape, strict=True))
    )
    values[generator.random(values.shape) < 0.01] = np.nan
    return height_map(values, spacing(window))


def synthetic() -> list[tuple[str, object]]:
    """Return names of synthetic surfaces, and functions that make them."""
    made = []
    for number, (kind, longest) in enumerate(itertools.product((*KINDS, *OTHER_KINDS), LONGEST)):
        made.append((f"{kind}, longest {longest:.2g}, seed {number}", partial(make, kind, longest, number)))
    return made


def make(kind: str, longest: float, seed: int):
    """Return a synthetic surface three times as long as its parts."""
    side, hurst = CUTS[0] * MADE_SIDE, (0.5, 0.7, 0.9)[seed % 3]
    if kind in OTHER_KINDS:
        return instruments.other_surface(kind, side, longest * MADE_SIDE, hurst=hurst, seed=seed)
    return master_surface(kind, side, longest=longest / CUTS[0], seed=seed, hurst=hurst)


def of_file(path: Path) -> list[dict]:
    """Return the rows of one file; none where it is no map, or too small a one."""
    warnings.simplefilter("ignore")
    try:
        height = rc.read_height_map(path).astype(float)
    except RoughContactError:
        return []
    return rows_of(path.name, "measured", height) if min(height.shape) >= SMALLEST else []


def of_synthetic(case: tuple) -> list[dict]:
    """Return the rows of one synthetic surface."""
    warnings.simplefilter("ignore")
    return rows_of(case[0], "synthetic", case[1]())


def bank_of(folders: list[Path], work: Path, *, made: bool) -> pd.DataFrame:
    """Return the rows of all maps, those of finished ones from the folder `work`."""
    work.mkdir(parents=True, exist_ok=True)
    files = sorted({path for folder in folders for path in folder.iterdir() if path.is_file()})
    jobs = [(path.name, of_file, path) for path in files]
    jobs += [(case[0], of_synthetic, case) for case in synthetic()] if made else []
    with ProcessPoolExecutor(2) as pool:
        pending = {}
        for name, function, argument in jobs:
            if not (work / f"{name}.json").exists():
                pending[name] = pool.submit(function, argument)
        for name, future in pending.items():
            rows = future.result()
            (work / f"{name}.json").write_text(pd.DataFrame(rows).to_json(orient="records"))
            print(name, len(rows), flush=True)
    rows = [row for name, *_ in jobs for row in json.loads((work / f"{name}.json").read_text())]
    return pd.DataFrame(rows)
