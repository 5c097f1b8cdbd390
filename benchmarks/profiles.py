"""Calibrate the ± of surfaces behind profiles on maps that are cut into profiles.

    python benchmarks/profiles.py FOLDER ...    # solve: results/profiles/errors.csv
    python benchmarks/profiles.py               # calibrate anew from that table, and print what is reached

Maps are made ones (self-affine, Gaussian and skewed both ways) and all those in the folders whose texture
aspect ratio Str is above 0.5. Rows of each, five and one, are taken for stylus profiles; the surfaces behind
them are held against the map at p' = 0.02, 0.1 and 0.4, p' being the mean pressure over E* and the rms
gradient of the map. With each map left out the others are calibrated, and its errors held against their
intervals. Files that hold the same map count once. No part of the calibration, and listed by themselves, are
a lithographic pattern, holes in rows, which is no random surface, and maps with a lay along an axis: profiles
across it are solved with as many along it.
"""

import argparse
import contextlib
import json
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from cases import SCALES

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.errors import RoughContactError
from roughcontact.evaluation.kinds.profiles.ridge_contrast import LOADS, ridge_contrast
from roughcontact.evaluation.kinds.profiles.surface_behind import member_surfaces, moments
from roughcontact.surface.profiles.surface import fit_profiles, stacked
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.roughness.texture import texture_parameters
from roughcontact.uncertainty.calibration import entry
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.scales import (
    ANSWERS,
    AREA,
    CONSTRICTIONS,
    GAP,
    PEAK,
    from_scale,
    inverse_erf_area,
    to_scale,
)

HERE = Path(__file__).parent
ERRORS = HERE / "results" / "profiles" / "errors.csv"
CALIBRATION = HERE.parent / "workflow/lib/roughcontact/uncertainty/calibration.json"
MEMBERS, SEEDS = 9, 6
CUTS = (0.5, 0.25)  # where the profiles lie between one another
MOST = 512  # points per side of a map
ISOTROPIC = 0.5  # Str
PATTERNS = {"circles_holes.nid"}
CALIBRATING = ["made", "measured"]  # kinds of maps
COVERAGE = 0.95
MIN_SPREAD = 0.02  # of a logarithm, and of a mean gap; less is chance
SHARES = np.linspace(0, 1, 21)  # of the contrast, that are tried
NORMAL_MEDIAN = 0.6745  # of |e| over its standard deviation
QUANTITIES = (AREA, GAP, PEAK, *ANSWERS)
OFF_AXIS = 10.0  # degrees of the strongest waves from an axis, up to which profiles run across and along
# Hurst exponent, longest and shortest wavelength in points, s of heights -sign(s) exp(-s h), and how many
# times as long waves are along y
KINDS = {
    "H 0.4": (0.4, 40, 2.5, 0.0, 1),
    "H 0.7": (0.7, 50, 3.3, 0.0, 1),
    "H 1": (1.0, 50, 4.0, 0.0, 1),
    "plateaus": (0.8, 40, 4.0, 0.5, 1),
    "peaks": (0.8, 40, 4.0, -0.5, 1),
    "lay 3": (0.8, 40, 4.0, 0.0, 3),
    "lay 8": (0.8, 40, 4.0, 0.0, 8),
}


def made(kind: str, seed: int, points: int = 384) -> xr.DataArray:
    """Return a levelled piece (points, points) of a surface, of flat spectrum above its longest wave."""
    hurst, longest, shortest, skew, stretch = KINDS[kind]
    q = np.hypot(stretch * np.fft.fftfreq(2 * points)[:, None], np.fft.rfftfreq(2 * points))
    amplitude = np.maximum(q, 1 / longest) ** (-1 - hurst) * ((q < 1 / shortest) & (q > 0))
    noise = np.random.default_rng(seed).standard_normal((2 * points,) * 2)
    heights = np.fft.irfft2(np.fft.rfft2(noise) * amplitude, s=noise.shape)
    heights /= heights.std()
    if skew:
        heights = -np.sign(skew) * np.exp(-skew * heights)
    return rc.level(height_map(3e-7 * heights[:points, :points], 1e-6))


def measured(folders: Sequence[Path]) -> Iterator[tuple[str, xr.DataArray, float]]:
    """Yield name, levelled map and Str of each map in the folders, once, but those without, or oblique.

    Of those with a lay x is across it.
    """
    seen = set()
    for path in sorted(path for folder in folders for path in folder.iterdir() if path.is_file()):
        for scale in SCALES:
            with contextlib.suppress(RoughContactError):
                levelled = rc.level(rc.read_height_map(path, **scale).astype(float))
                if min(levelled.shape) < 100:
                    break
                texture = texture_parameters(rc.periodic_window(levelled))
                aspect, strongest = texture["Str"], texture["Std"]
                name = (levelled.shape, round(aspect, 3), f"{levelled.attrs['Sku']:.3g}")
                on_axis = abs((strongest + 45) % 90 - 45) <= OFF_AXIS
                if (aspect > ISOTROPIC or (aspect <= ISOTROPIC and on_axis)) and name not in seen:
                    across_y = aspect <= ISOTROPIC and 45 < strongest < 135
                    yield path.name, transposed(levelled) if across_y else levelled, aspect
                seen.add(name)
                break


def profiles_of(levelled: xr.DataArray, number: int, cut: float) -> list[xr.DataArray]:
    """Return rows of a map, as long as its window may be, without missing points."""
    values = levelled.values[:, np.isfinite(levelled.values).mean(axis=0) > 0.5]
    complete = values[np.isfinite(values).all(axis=1)]
    if len(complete) < 20:  # a round map: its middle half
        quarter = values.shape[1] // 4
        middle = values[:, quarter:-quarter]
        complete = middle[np.isfinite(middle).all(axis=1)]
    rows = complete[((np.arange(number) + cut) / number * len(complete)).astype(int)]
    return [rc.level(height_map(row, spacing(levelled)[1]), outlier_threshold=None) for row in rows]


def transposed(levelled: xr.DataArray) -> xr.DataArray:
    """Return a map with its axes exchanged."""
    return levelled.rename(x="y", y="x").transpose("y", "x")


def rows_of(name: str, kind: str, aspect: float, levelled: xr.DataArray) -> list[dict]:
    """Return the rows of the table of one map: errors of the surfaces behind its profiles."""
    print(name, flush=True)
    side = min(MOST, *levelled.shape)
    truth = rc.periodic_window(levelled[:side, :side])
    pressures = LOADS * rms_gradient(truth)
    contact = {"contact_modulus": 1.0, "mean_pressure": pressures, "on_failure": "flag"}
    true = solve_member(truth, contact, tolerance=1e-3, names=QUANTITIES)
    rows = []
    for number, cut in ((number, cut) for number in (1, 5) for cut in CUTS):
        try:
            profiles = profiles_of(levelled, number, cut)
            along = profiles_of(transposed(levelled), number, cut) if kind.endswith("lay") else []
            window = rc.surface_from_profiles(profiles, along=along, points=min(truth.shape))
            fit = fit_profiles(stacked(profiles, along))
        except RoughContactError as error:
            print(name, number, cut, error)
            continue
        result = solve_member(window, contact, tolerance=1e-2, names=QUANTITIES)
        surfaces = list(member_surfaces(fit, window, MEMBERS))
        results_of_surfaces = [
            solve_member(surface, contact, tolerance=1e-2, names=QUANTITIES) for surface in surfaces
        ]
        contrast = ridge_contrast(fit.pieces, surfaces)
        for quantity in QUANTITIES:
            unit = result[GAP] if quantity in CONSTRICTIONS else 1.0
            members = np.array([result[quantity] for result in results_of_surfaces])
            mean, scatter = moments(quantity, members, result[quantity], result[GAP])
            error = (to_scale(quantity, true[quantity]) - to_scale(quantity, result[quantity])) / unit - mean
            for load, p in enumerate(LOADS):
                case = {"map": name, "kind": kind, "Str": round(aspect, 2), "profiles": number, "cut": cut}
                columns = {"area": result[AREA], "error": error, "scatter": scatter, "truth": true[quantity]}
                columns["contrast"] = contrast[quantity]
                numbers = {key: f"{column[load]:.4g}" for key, column in columns.items()}
                rows.append(case | {"load": p, "quantity": quantity} | numbers)
    return rows


def solve(folders: Sequence[Path]) -> None:
    """Write the table of errors of all maps."""
    maps = [
        (f"{kind}, seed {seed}", "made lay" if stretch > 1 else "made", 1 / stretch, made(kind, seed))
        for kind, (*_, stretch) in KINDS.items()
        for seed in range(SEEDS)
    ]
    for name, levelled, aspect in measured(folders):
        kind = "measured" if aspect > ISOTROPIC else "measured lay"
        maps.append((name, "pattern" if name in PATTERNS else kind, aspect, levelled))
    with ProcessPoolExecutor(2) as pool:
        rows = [row for part in pool.map(rows_of, *zip(*maps, strict=True)) for row in part]
    ERRORS.parent.mkdir(exist_ok=True)
    pd.DataFrame(rows).to_csv(ERRORS, index=False)


def calibrated(errors: pd.DataFrame) -> dict[str, dict[str, list[float]]]:
    """Return share, spread and quantile of each quantity at each load.

    Made and measured maps weigh the same; the share of the contrast is that with the least mean |error|.
    """
    # the smallest value up to which that share of the weight lies
    quantile = partial(np.quantile, method="inverted_cdf")
    table: dict[str, dict[str, list[float]]] = {}
    errors = errors[errors["kind"].isin(CALIBRATING)]
    for quantity, group in errors.groupby(errors["quantity"].map(entry)):
        columns = []
        for _, rows in group[np.isfinite(group["error"])].groupby("load"):
            weight = 1 / rows.groupby("map")["error"].transform("size")
            weight = (weight / rows.groupby("kind")["map"].transform("nunique")).values
            residuals = np.abs(rows["error"].values - SHARES[:, None] * rows["contrast"].values)
            best = np.argmin((residuals @ weight).round(9))
            error, scatter = residuals[best], rows["scatter"].values
            spreads = np.geomspace(MIN_SPREAD, 3, 200)
            ratios = error / np.hypot(scatter, spreads[:, None])
            rising = np.argsort(ratios, axis=1)  # all medians at once: a hundred times as fast
            middle = (weight[rising].cumsum(axis=1) >= 0.5 * weight.sum()).argmax(axis=1)
            medians = np.take_along_axis(ratios, rising, axis=1)[np.arange(spreads.size), middle]
            spread = spreads[np.argmin(np.abs(medians - NORMAL_MEDIAN))]
            level = min(1.0, COVERAGE * (1 + 1 / rows.groupby("kind")["map"].nunique().min()))
            wide = quantile(error / np.hypot(scatter, spread), level, weights=weight)
            mean_area = np.log(inverse_erf_area(rows["area"].values)).mean()
            columns.append([mean_area, SHARES[best], spread, wide])
        columns = [[float(f"{value:.4g}") for value in column] for column in zip(*columns, strict=True)]
        table[str(quantity)] = dict(zip(("load", "share", "spread", "quantile"), columns, strict=True))
    return table


def judged(errors: pd.DataFrame, table: dict) -> pd.DataFrame:
    """Return errors less their share of the contrast, and which are inside the intervals of a calibration."""
    quantity = errors["quantity"].map(entry)
    x = np.log(inverse_erf_area(errors["area"].values))
    share, spread, wide = np.empty((3, x.size))
    for name in quantity.unique():
        rows, calibration = (quantity == name).values, table[name]
        for column, key in ((share, "share"), (spread, "spread"), (wide, "quantile")):
            column[rows] = np.interp(x[rows], calibration["load"], calibration[key])
    error = errors["error"] - share * errors["contrast"]
    return errors.assign(error=error, inside=error.abs() <= wide * np.hypot(errors["scatter"], spread))


def report(errors: pd.DataFrame) -> pd.DataFrame:
    """Return coverage with each map left out, and medians of |result/truth - 1| of area and gap."""
    errors = pd.concat(
        judged(rows, calibrated(errors[errors["map"] != name])) for name, rows in errors.groupby("map")
    )
    headline = errors[errors["quantity"].isin([AREA, GAP])]
    ratio = np.empty(len(headline))
    for name in (AREA, GAP):
        rows = (headline["quantity"] == name).values
        truth, error = (headline[key].values[rows] for key in ("truth", "error"))
        ratio[rows] = from_scale(name, to_scale(name, truth) - error) / truth
    headline = headline.assign(deviation=np.abs(ratio - 1))
    keys = ["kind", "profiles", "quantity"]
    deviation = headline.groupby([*keys, "load"])["deviation"].median().unstack()
    together = headline.groupby(keys)["deviation"].median().rename("all loads")
    coverage = errors.groupby(keys)["inside"].mean().rename("coverage")
    return coverage.to_frame().join(deviation).join(together).round(3)


def main() -> None:
    """Solve where folders are given, calibrate, and print what is reached."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="*", type=Path)
    folders = parser.parse_args().folders
    if folders:
        solve(folders)
    errors = pd.read_csv(ERRORS)
    used = errors[errors["kind"].isin(CALIBRATING)]
    content = json.loads(CALIBRATION.read_text()) | {"profiles": calibrated(used)}
    CALIBRATION.write_text(json.dumps(content, indent=1) + "\n")
    table = report(errors)
    table.to_csv(ERRORS.with_name("reached.csv"))
    print(table.to_string())


if __name__ == "__main__":
    main()
