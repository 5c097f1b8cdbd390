"""Hold the ± against maps that are taken as true, and spoilt as instruments spoil them.

    python benchmarks/measurement.py FOLDER ... --write
    python benchmarks/measurement.py FOLDER ... --held-out --write
    python benchmarks/measurement.py FOLDER ... --quick         # four truths, printed

A truth is a synthetic surface, or a part of a measured map in one of the folders, solved by default settings.
It is spoilt by one error at a time (window, noise, lens, tip, scale, modulus, pixels), what an operator would
know of the error is stated, and the spoilt map is evaluated at the same mean pressures. Its intervals of the
surface and of this map are held against the truth, the true map in its band of waves; those of one octave
shorter, where pixels were merged. `--held-out` does so with other truths, which played no part in the choice
of any constant: maps of other instruments and specimens, and synthetic surfaces of other kinds.
"""

import argparse
import json
import os
import sys
import warnings
import zlib
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import calibrate
import instruments
import pages

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import self_affine_surface
from roughcontact.surface.window.rectangle import largest_rectangle
from validation.masters import master_surface

SHOWN = {  # quantities: names in the tables
    "relative_contact_area": "area",
    "mean_gap": "gap",
    "mean_contact_pressure": "pressure",
    "max_pressure": "peak",
    "conductance_per_conductivity": "conductance",
}
JUDGED = ("inside of these (%)", "misses to review (%)")
WORK = Path(__file__).parent / "work" / "measurement"
LOADS = (0.02, 0.1, 0.4)  # of E* times the rms gradient of the true window
MODULUS = 1e7  # Pa, of a rubber: metals would yield at these loads, which is no error of the map
SIDES = (220, 192, 176, 144, 124, 102)  # maps whose window is in the same place with pixels twice as large
INTERVALS = {"map_": "map", "": "surface", "octave_": "octave"}  # in the dataset: in the tables
FLAGS = ("Sample", "Resolution", "Smoothed", "Noise", "Isolated peak")  # checks that warn of such errors
WAVELENGTH = 550e-9
ANY, OPTICAL, PROBED = (0.0, np.inf), (7e-8, 4e-6), (0.0, 4e-8)  # pitches for which an error makes sense (m)


class Made(NamedTuple):
    """A synthetic surface: kind of `master_surface` or self-affine down to the pixels."""

    kind: str
    pitch: float
    gradient: float
    hurst: float = 0.8


MADE = {
    "random": Made("random", 5e-7, 0.10),
    "ground": Made("ground", 1e-6, 0.15),
    "honed": Made("honed", 5e-7, 0.10),
    "turned": Made("turned", 1e-6, 0.10),
    "worn": Made("worn", 2e-7, 0.05),
    "self-affine, H = 0.5, µm": Made("self-affine", 7e-7, 0.20, 0.5),
    "self-affine, H = 0.9, µm": Made("self-affine", 3e-7, 0.10, 0.9),
    "grainy": Made("grainy", 2e-9, 0.30),
    "dimpled": Made("dimpled", 1e-8, 0.20),
    "eroded": Made("eroded", 5e-9, 0.25),
    "self-affine, H = 0.3, nm": Made("self-affine", 5e-9, 0.20, 0.3),
    "self-affine, H = 0.8, nm": Made("self-affine", 1e-9, 0.40, 0.8),
    "random, H = 0.5, nm": Made("random", 2e-8, 0.15, 0.5),
}
MEASURED = (  # of different instruments, with spectra that fall down to their pixels
    "Hamby252_Barrel1_Bullet1_Land4.x3p",
    "KautschukInfiniteFocus.x3p",
    "SBS-PMMA.nid",
    "Veeco_20160622.003",
    "di-1.di",
    "di-3.di",
    "example_ps.tiff",
    "grid.nid",
    "nms-1.nms",
    "opd-1.opd",
    "sample-land.x3p",
    "spot_1-1000nm.ibw",
    "stp-1.stp",
    "test_1.opd",
    "test_uncompressed.sur",
    "x3p-2.x3p",
)
HELD_OUT_MADE = {
    f"{kind}, H = {hurst}": Made(kind, pitch, gradient, hurst)
    for kind, rows in {
        "cratered": ((6e-7, 0.1, 0.5), (4e-7, 0.25, 0.8), (2e-9, 0.3, 0.3)),
        "conical": ((8e-7, 0.15, 0.8), (3e-7, 0.3, 0.4), (6e-9, 0.2, 0.6)),
        "stretched": ((1e-6, 0.1, 0.7), (2e-7, 0.2, 0.4), (3e-9, 0.3, 0.9)),
        "lognormal": ((5e-7, 0.12, 0.6), (9e-7, 0.2, 0.9), (4e-9, 0.25, 0.4)),
    }.items()
    for pitch, gradient, hurst in rows
}
HELD_OUT = (  # in the repositories of SurfaceTopography, TopoStats, AFMReader, surfalize and bulletxtrctr
    "Hamby252_Barrel1_Bullet2_Land4.x3p",
    "di-2.di",
    "di-4.di",
    "di-5.di",
    "di-6.di",
    "matrix-2.txt",
    "mnt-1.mnt",
    "nms-2.nms",
    "old_bruker.002",
    "old_bruker.004",
    "sample_0.jpk",
    "sample_0.stp",
    "sample_1_um_scale.stp",
    "test_2.opd",
    "top-1.top",
)
QUICK = ("random", "self-affine, H = 0.8, nm", "di-3.di", "test_1.opd")


class Measurement(NamedTuple):
    """A spoilt map (y, x; m), what is stated of its instrument, and the modulus (Pa) that is used."""

    height: xr.DataArray
    instrument: dict | None = None
    modulus: float = MODULUS
    modulus_uncertainty: float | None = None


class Spoiler(NamedTuple):
    """An error: its cause in the tables, the pitches (m) for which it makes sense, and its simulation.

    The simulation takes the true map and a seed.
    """

    cause: str
    pitches: tuple[float, float]
    spoil: Callable[[xr.DataArray, int], Measurement]


def noisy(share: float, height: xr.DataArray, seed: int) -> Measurement:
    """Return a map with white noise of a share of Sq."""
    rms = share * float(height.std())
    return Measurement(instruments.add_noise(height, rms, seed), {"noise": rms})


def blurred(numerical_aperture: float, height: xr.DataArray, seed: int) -> Measurement:
    """Return a map as a lens transmits it."""
    lens = {"numerical_aperture": numerical_aperture, "wavelength": WAVELENGTH}
    return Measurement(instruments.through_lens(height, **lens), lens)


def traced(tip_radius: float, height: xr.DataArray, seed: int) -> Measurement:
    """Return a map as a tip of a radius (m) traces it."""
    return Measurement(instruments.traced_by(height, tip_radius), {"tip_radius": tip_radius})


def rounded(share: float, height: xr.DataArray, seed: int) -> Measurement:
    """Return a map with heights rounded to a share of Sq, which the map itself tells."""
    return Measurement(instruments.rounded(height, share * float(height.std())))


def wrongly_scaled(bound: float, height: xr.DataArray, seed: int) -> Measurement:
    """Return a map whose heights are too large by a share of at most `bound`."""
    factor = 1 + bound * np.random.default_rng(seed).uniform(-1, 1)
    return Measurement(instruments.scaled(height, z=factor), {"amplification_z": bound})


def wrong_modulus(bound: float, height: xr.DataArray, seed: int) -> Measurement:
    """Return the map, with a modulus that is too large by a share of at most `bound`."""
    factor = 1 + bound * np.random.default_rng(seed).uniform(-1, 1)
    return Measurement(height, modulus=factor * MODULUS, modulus_uncertainty=bound)


def of_one_period(height: xr.DataArray, seed: int) -> Measurement:
    """Return one period of the periodic window of a map, from another first point, tilted, with holes."""
    window = rc.periodic_window(rc.level(height))
    return Measurement(calibrate.of_one_period(window, np.random.default_rng(seed)))


def merged(height: xr.DataArray, seed: int) -> Measurement:
    """Return a map with pixels twice as large."""
    return Measurement(instruments.coarser(height, 2))


def corrected(error: str, height: xr.DataArray, seed: int) -> Measurement:
    """Return a map with an error of `SPOILERS`, for which it is to be corrected."""
    case = SPOILERS[error].spoil(height, seed)
    return case._replace(instrument=case.instrument | {"correct": True})


SPOILERS = {
    "none": Spoiler("none", ANY, lambda height, seed: Measurement(height)),
    "one period, tilted, 1 % missing": Spoiler("window", ANY, of_one_period),
    **{
        f"noise {share:.0%} of Sq": Spoiler("noise", ANY, partial(noisy, share))
        for share in (0.01, 0.03, 0.1)
    },
    **{
        f"lens NA {aperture:g}": Spoiler(
            "lens", (WAVELENGTH / aperture / 10, OPTICAL[1]), partial(blurred, aperture)
        )
        for aperture in (0.3, 0.55, 0.8)
    },
    **{
        f"stylus {radius:g} µm": Spoiler("stylus", OPTICAL, partial(traced, radius * 1e-6))
        for radius in (2, 5)
    },
    **{
        f"tip {radius:g} nm": Spoiler("tip", PROBED, partial(traced, radius * 1e-9))
        for radius in (10, 20, 50)
    },
    **{
        f"steps of {share:.0%} of Sq": Spoiler("steps", ANY, partial(rounded, share))
        for share in (0.03, 0.1, 0.2, 0.4)
    },
    "heights ± 1 %": Spoiler("scale", ANY, partial(wrongly_scaled, 0.01)),
    "E* ± 5 %": Spoiler("modulus", ANY, partial(wrong_modulus, 0.05)),
    "pixels × 2": Spoiler("pixels", ANY, merged),
}
SPOILERS |= {
    f"{error}, corrected": spoiler._replace(
        cause=f"{spoiler.cause}, corrected", spoil=partial(corrected, error)
    )
    for error, spoiler in SPOILERS.items()
    if spoiler.cause in ("noise", "lens")
}


def synthetic(name: str) -> xr.DataArray:
    """Return a part of a synthetic surface twice as long, whose waves are up to half as long as the map."""
    kind, pitch, gradient, hurst = (MADE | HELD_OUT_MADE)[name]
    side, seed = SIDES[0], zlib.crc32(name.encode())
    if name in HELD_OUT_MADE:
        surface = instruments.other_surface(kind, 2 * side, side / 2, hurst=hurst, seed=seed)
    elif kind == "self-affine":
        lengths = {"shortest": 2.0, "longest": side / 2}
        surface = self_affine_surface(
            (2 * side, 2 * side), 1.0, hurst=hurst, rms_height=1.0, seed=seed, **lengths
        )
    else:
        surface = master_surface(kind, 2 * side, longest=1 / 4, seed=seed, hurst=hurst)
    map_ = height_map(surface.values[:side, :side], pitch)
    return map_ * (gradient / rms_gradient(rc.periodic_window(rc.level(map_))))


def measured(path: Path) -> xr.DataArray:
    """Return the middle of a measured map, levelled and filled; nothing is kept of its instrument."""
    levelled = rc.level(rc.read_height_map(path).astype(float))
    top, left_column, *size = largest_rectangle(
        ~np.isnan(levelled.values), np.arange(max(levelled.shape) + 1)
    )
    sides = [next(side for side in SIDES if side <= length) for length in size]
    starts = [
        start + (length - side) // 2
        for start, length, side in zip((top, left_column), size, sides, strict=True)
    ]
    part = levelled.values[tuple(slice(s, s + side) for s, side in zip(starts, sides, strict=True))]
    return height_map(part, spacing(levelled))


def true_map(name: str, files: dict[str, Path], folder: Path) -> tuple[xr.DataArray, dict]:
    """Return a truth and its results, from the folder where they are kept.

    The results are the mean pressures (Pa), and by quantity a list (load).
    """
    map_file = folder / f"{name}.nc"
    if map_file.exists():
        height = xr.load_dataarray(map_file)
        return height, json.loads(height.attrs.pop("results"))
    height = synthetic(name) if name in MADE | HELD_OUT_MADE else measured(files[name])
    contact = {"contact_modulus": MODULUS, "relative_pressure": list(LOADS)}
    statistics = rc.evaluate(height, contact=contact, uncertainty={"sources": ["discretisation"]})
    results = {name: statistics[name].values.tolist() for name in ("mean_pressure", *SHOWN)}
    height.assign_attrs(results=json.dumps(results)).to_netcdf(map_file)
    return height, results


def spoilt(spoiler: str, name: str, height: xr.DataArray) -> Measurement:
    """Return a true map with an error, whose random numbers depend on both names alone."""
    return SPOILERS[spoiler].spoil(height, zlib.crc32(f"{name}, {spoiler}".encode()))


def measure(
    name: str, spoiler: str, files: dict[str, Path], folder: Path, *, again: bool, with_statement: bool
) -> list[dict]:
    """Return rows (load, quantity) of a spoilt truth, from the folder where they are kept unless `again`."""
    os.environ["OMP_NUM_THREADS"] = "1"
    warnings.simplefilter("ignore")
    rows_file = folder / f"{name}, {spoiler}, {'' if with_statement else 'un'}stated.json"
    if rows_file.exists() and not again:
        return json.loads(rows_file.read_text("utf-8"))
    height, truth = true_map(name, files, folder)
    case = spoilt(spoiler, name, height)
    contact = {"contact_modulus": case.modulus, "mean_pressure": truth["mean_pressure"]}
    statement = statements(case) if with_statement else {}
    statistics = rc.evaluate(case.height, contact=contact | statement.pop("contact", {}), **statement)
    flags = [
        [text.split(":")[0].split(" (")[0] for text in reasons]
        for _, reasons in json.loads(statistics.attrs["verdicts"])
    ]
    rows = [
        {
            "group": "synthetic" if name in MADE | HELD_OUT_MADE else "measured",
            "truth": name,
            "spoiler": spoiler,
            "stated": with_statement,
            "load": load,
            "quantity": label,
            "value": float(statistics[quantity][at]),
            **{
                which + side: float(statistics[f"{quantity}_{which}{side}"][at])
                for which in INTERVALS
                for side in ("lower", "upper")
            },
            "of_cause": of_cause(statistics, quantity, at),
            "true": truth[quantity][at],
            "flags": "; ".join(flags[at]),
            "verdict": float(statistics[f"{quantity}_verdict"][at])
            if f"{quantity}_verdict" in statistics
            else np.nan,
        }
        for at, load in enumerate(LOADS)
        for quantity, label in SHOWN.items()
    ]
    rows_file.write_text(json.dumps(rows, ensure_ascii=False), encoding="utf-8")
    return rows


def statements(case: Measurement) -> dict[str, dict]:
    """Return the settings that state what is known of an error."""
    settings = {"instrument": dict(case.instrument)} if case.instrument else {}
    if case.modulus_uncertainty is not None:
        settings["contact"] = {"contact_modulus_uncertainty": case.modulus_uncertainty}
    return settings


def of_cause(budget: xr.Dataset, quantity: str, at: int) -> float:
    """Return half of what instrument and material add to the length of an interval, without other sources."""
    parts = budget[f"{quantity}_components"][at].sel(source=["instrument", "material"])
    widths = np.sqrt((parts.sel(component=["down", "up"]) ** 2).sum("source")).sum()
    return float(widths + parts.sel(component=["shift_down", "shift_up"]).sum()) / 2


def judged(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows with the relative error, and for all intervals half-width, inside or not, and silence.

    An end that is missing is open: *at least*, or *at most*. A truth outside is silent where no check warns
    of such errors.
    """
    rows = rows.assign(error=(rows["true"] - rows["value"]).abs() / rows["value"].abs())
    rows = rows.assign(of_cause=rows["of_cause"] / rows["value"].abs())
    rounding = 1e-9 * rows["value"].abs()
    flagged = rows["flags"].fillna("").map(lambda flags: any(flag in flags.split("; ") for flag in FLAGS))
    for which in INTERVALS:
        lower, upper = rows[f"{which}lower"], rows[f"{which}upper"]
        outside = (rows["true"] < lower - rounding) | (rows["true"] > upper + rounding)
        rows[f"{which}inside"] = ~outside
        rows[f"{which}half_width"] = (upper - lower) / 2 / rows["value"].abs()
        rows[f"{which}silent"] = outside & ~flagged
    return rows


def counted(rows: pd.DataFrame, which: str = "") -> dict:
    """Return of some rows the shares inside and silent (%), and the widths by quantity.

    A width is the median half-width over the 95 % quantile of the errors, of the whole interval and of what
    the cause adds alone. `which` is one of `INTERVALS`.
    """
    row: dict = {"cases": len(rows[["truth", "spoiler"]].drop_duplicates())}
    for quantity in SHOWN.values():
        chosen = rows[rows["quantity"] == quantity]
        largest = chosen["error"].quantile(0.95)
        row[f"{quantity} inside (%)"] = 100 * chosen[f"{which}inside"].mean()
        # without an error there is nothing that a width could be held against
        row[f"{quantity} width"] = (
            chosen[f"{which}half_width"].median() / largest if largest > 1e-9 else np.nan
        )
        of_cause = chosen["of_cause"].median()
        row[f"{quantity} width of the cause"] = (
            of_cause / largest if min(largest, of_cause) > 1e-9 else np.nan
        )
    return row | {"silent (%)": 100 * rows[f"{which}silent"].mean()}


def tables(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return coverage and widths by error and by cause, of the intervals that should hold the truth."""
    rows = judged(rows)
    in_order = rows["spoiler"].map(list(SPOILERS).index)
    rows = rows.iloc[in_order.argsort(kind="stable")]
    rows = rows.assign(cause=rows["spoiler"].map(lambda name: SPOILERS[name].cause))
    errors, causes = [], []
    coarser = rows["cause"].str.startswith("pixels")
    for which, interval in INTERVALS.items():
        rows_of_interval = rows[coarser == (interval == "octave")]
        for error, part in rows_of_interval.groupby("spoiler", sort=False):
            errors.append({"interval": interval, "error": error} | counted(part, which))
        for cause, part in rows_of_interval.groupby("cause", sort=False):
            for group in ("synthetic", "measured", "all"):
                chosen = part if group == "all" else part[part["group"] == group]
                if len(chosen):
                    causes.append(
                        {"interval": interval, "cause": cause, "group": group} | counted(chosen, which)
                    )
    tables_by_name = {"errors": pd.DataFrame(errors), "causes": pd.DataFrame(causes)}
    return {
        name: pages.text(
            frame,
            {
                column: ".0f" if column.endswith("inside (%)") else ".1f"
                for column in frame.columns
                if column.endswith(("(%)", "width", "cause"))
            },
        )
        for name, frame in tables_by_name.items()
    }


def worth(rows: pd.DataFrame) -> dict:
    """Return the share of results with the verdict *use*, and what it is worth."""
    use = ~rows["flagged"]
    shares = (rows["inside"][use].mean(), rows["flagged"][~rows["inside"]].mean())
    return {"use (%)": 100 * use.mean()} | {
        name: 100 * share for name, share in zip(JUDGED, shares, strict=True)
    }


def unstated(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return by error, and of all, what the verdicts are worth where nothing is said of the instrument."""
    rows = judged(rows).dropna(subset="verdict")  # the conductance has none of its own
    rows = rows.assign(flagged=rows["verdict"] > 0)
    rows_by_error = [
        {"error": error, "maps": part["truth"].nunique(), "inside (%)": 100 * part["inside"].mean()}
        | worth(part)
        for error, part in (*rows.groupby("spoiler", sort=False), ("all", rows))
    ]
    table = pd.DataFrame(rows_by_error)
    return {"unstated": pages.text(table, dict.fromkeys(table.columns[2:], ".0f"))}


def main() -> None:
    """Measure what is asked for, keep the rows, print or write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folders", nargs="*", type=Path, help="folders of instrument files")
    parser.add_argument("--held-out", action="store_true", help="truths that no constant was chosen on")
    parser.add_argument("--quick", action="store_true", help="four truths")
    parser.add_argument("--only", nargs="+", choices=SPOILERS, default=list(SPOILERS), help="errors")
    parser.add_argument("--unstated", action="store_true", help="state nothing of instrument and modulus")
    parser.add_argument("--work", type=Path, default=WORK, help="where truths and rows are kept")
    parser.add_argument("--again", action="store_true", help="evaluate spoilt maps anew; truths are kept")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="write the tables and their page; else print")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    files = {path.name: path for folder in options.folders for path in folder.iterdir()}
    synthetic_names, measured_names = (HELD_OUT_MADE, HELD_OUT) if options.held_out else (MADE, MEASURED)
    names = [*synthetic_names, *(name for name in measured_names if name in files)]
    names = [name for name in names if name in QUICK or not options.quick]
    # of steps nothing is stated of the instrument
    errors = [error for error in options.only if not (options.unstated and "steps" in error)]
    options.work.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(options.processes) as pool:
        jobs = []
        for name, (height, _) in zip(
            names, pool.map(partial(true_map, files=files, folder=options.work), names), strict=True
        ):
            pitch = max(spacing(height))
            jobs += [
                (name, spoiler)
                for spoiler in errors
                if SPOILERS[spoiler].pitches[0] <= pitch <= SPOILERS[spoiler].pitches[1]
            ]
        run = partial(
            measure,
            files=files,
            folder=options.work,
            again=options.again,
            with_statement=not options.unstated,
        )
        rows = pd.DataFrame(
            [row for tables_by_name in pool.map(run, *zip(*jobs, strict=True)) for row in tables_by_name]
        )
    rows.to_csv(options.work / "rows.csv", index=False, float_format="%.6g", lineterminator="\n")
    tables_by_name = unstated(rows) if options.unstated else tables(rows)
    if options.write:
        pages.publish("held_out" if options.held_out else "measurement", tables_by_name)
    else:
        pages.show(tables_by_name)


if __name__ == "__main__":
    main()
