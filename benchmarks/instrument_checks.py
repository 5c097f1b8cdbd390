"""How often the checks of the instrument flag maps with a made fault, and maps as they are.

    python benchmarks/instrument_checks.py FOLDER... [--write]

Maps are the files in the folders (measured ones), and made surfaces: `self-affine`, `ground` and `roll-off`
down to the pixel, `band-limited` to six of them. Of each, 216 x 216 points are taken as measured. Maps with a
pixel below 0.1 µm are enlarged to one of 0.3 µm, so that a lens or a stylus has something to act on. A fault
counts where it matters: the contact area changes by more than 5 % (noise: 10 %), the largest pressure by more
than 30 % (dust); interpolation always. The limits were chosen in sight of all measured maps, and of made
surfaces with other seeds: halves that agree say only that no single map decides.
"""

import argparse
import multiprocessing
import pathlib
import warnings

import instruments
import numpy as np
import pandas as pd
import xarray as xr

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.statistics import instrument_checks as checks
from roughcontact.surface.synthetic import self_affine_surface
from validation.masters import KINDS, master_surface
from validation.surfaces import ground_surface

SIDE, PIXEL, GREEN = 216, 0.3e-6, 550e-9
LOADS = (0.02, 0.1)  # of E* g
AREA, LESS_AREA, PRESSURE = 0.05, -0.1, 0.3  # changes that matter
RESULTS = pathlib.Path(__file__).parent / "results" / "instrument_checks.csv"
AGAIN = {"matrix-3.txt", "sample-land-cran.x3p"}  # the same maps as two others


def measured(folders: list[pathlib.Path]) -> dict[str, xr.DataArray]:
    """Return the maps that are read without further words, and are large enough."""
    maps_by_name = {}
    for path in sorted(path for folder in folders for path in folder.iterdir()):
        try:
            height = rc.read_height_map(path)
        except (rc.RoughContactError, OSError):
            continue
        if min(height.shape) >= 75 and height.isnull().mean() < 0.4 and path.name not in AGAIN:
            maps_by_name[path.name] = height
    return maps_by_name


def part_of(height: xr.DataArray) -> xr.DataArray:
    """Return the part of a map with the fewest missing points, filled in, and pixels of at least 0.1 µm."""
    starts = [np.linspace(0, max(n - SIDE, 0), 5).astype(int) for n in height.shape]
    parts = [height.isel(y=slice(y, y + SIDE), x=slice(x, x + SIDE)) for y in starts[0] for x in starts[1]]
    part = min(parts, key=lambda candidate: int(candidate.isnull().sum()))
    if part.isnull().any():
        part = rc.level(part, form="none", outlier_threshold=None, line_alignment="none")
        part = part.fillna(part.mean()).drop_vars("filled")
    zoom = PIXEL / max(spacing(part)) if max(spacing(part)) < 1e-7 else 1.0
    return instruments.scaled(part, zoom, zoom)


def made() -> dict[tuple[str, str], xr.DataArray]:
    """Return made surfaces that are not periodic, by kind and name."""
    sides, pitch, surfaces = (256, 256), 1e-6, {}
    for seed, (hurst, slope) in enumerate((h, g) for h in (0.3, 0.5, 0.8, 0.95) for g in (0.1, 0.4)):
        band = {"shortest": 2e-6, "longest": 1e-4, "seed": seed}
        surface = self_affine_surface(sides, pitch, hurst=hurst, rms_gradient=slope, **band)
        surfaces["self-affine", f"H = {hurst}, g = {slope}"] = surface
    for seed, (hurst, power) in enumerate((h, k) for h in (0.5, 0.8) for k in (1.0, 2.0)):
        band = {"shortest": 2e-6, "longest": 6e-5, "rms_height": 3e-7, "seed": seed}
        surface = ground_surface(sides, pitch, hurst=hurst, skewness_power=power, **band)
        surfaces["ground", f"H = {hurst}, power {power}"] = surface
    wave = 2 * np.pi * np.hypot(np.fft.fftfreq(256)[:, None], np.fft.rfftfreq(256)[None, :])
    for seed, exponent in enumerate((4, 5, 5.5, 6)):
        noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal(sides))
        heights = np.fft.irfft2(noise * (1 + (4 * wave) ** 2) ** (-exponent / 4), s=sides)
        surfaces["roll-off", f"q^-{exponent}"] = height_map(3e-7 / heights.std() * heights, pitch)
    for seed, kind in enumerate(KINDS):
        surface = master_surface(kind, 256, longest=0.4, seed=seed)
        surfaces["band-limited", kind] = instruments.scaled(surface, 256e-6, 256e-6)
    return {key: surface.isel(y=slice(SIDE), x=slice(SIDE)) for key, surface in surfaces.items()}


def fourier_finer(height: xr.DataArray) -> xr.DataArray:
    """Return the map with pixels half as large, interpolated by its waves and those of its mirror images."""
    (ny, nx), doubled = height.shape, np.pad(height.values, [(0, n) for n in height.shape], mode="symmetric")
    waves, finer = np.fft.fftshift(np.fft.fft2(doubled)), np.zeros((4 * ny, 4 * nx), complex)
    finer[ny : 3 * ny, nx : 3 * nx] = 4 * waves
    values = np.fft.ifft2(np.fft.ifftshift(finer)).real
    return height_map(values[: 2 * ny, : 2 * nx], [d / 2 for d in spacing(height)])


def faults(height: xr.DataArray, seed: int) -> dict[str, xr.DataArray]:
    """Return the map with each of the faults."""
    generator, pixel, rms = np.random.default_rng(seed), max(spacing(height)), rc.level(height).std().item()
    maps_by_fault = {"none": height}
    for aperture in (0.3, 0.42, 0.55):
        if GREEN / (2 * aperture) >= 2 * pixel:  # the cut-off is resolved
            maps_by_fault[f"lens NA {aperture}"] = instruments.through_lens(height, aperture, GREEN)
    maps_by_fault["stylus 5 µm"] = instruments.traced_by(height, 5e-6)
    maps_by_fault["median 5 x 5"] = instruments.median_filtered(height, 5)
    maps_by_fault["Gauss 2 pixels"] = instruments.gauss_filtered(height, 2)
    maps_by_fault["Gauss 2 pixels, noise 0.3 %"] = instruments.add_noise(
        maps_by_fault["Gauss 2 pixels"], 0.003 * rms, seed
    )
    maps_by_fault["peaks compressed"] = instruments.with_compressed_peaks(height, 0.1, 0.3)
    quarter = height.isel(y=slice(SIDE // 2), x=slice(SIDE // 2))
    maps_by_fault |= {"quarter": quarter, "finer, cubic": instruments.finer(quarter, 2)}
    maps_by_fault["finer, Fourier"] = fourier_finer(quarter)
    for share in (0.03, 0.1):
        maps_by_fault[f"noise {100 * share:.0f} %"] = instruments.add_noise(height, share * rms, seed)
    for number in range(4):
        centre = [int(n * generator.uniform(0.15, 0.85)) for n in height.shape]
        width = generator.uniform(1.5, 8) / 2.355  # from full width at half of the height
        maps_by_fault[f"dust {number}"] = instruments.with_dust(
            height, generator.uniform(4, 10) * rms, width, centre
        )
    thirds = [np.array_split(np.arange(n), 3) for n in height.shape]
    for row, column in np.ndindex(3, 3):
        maps_by_fault[f"part {row}{column}"] = height.isel(y=thirds[0][row], x=thirds[1][column])
    return maps_by_fault


def counted(contact: xr.Dataset) -> xr.Dataset:
    """Return what the check of isolated peaks needs of a solution, and the contact area."""
    pressures = contact["pressure"].values
    columns = {
        "max_pressure": [pressure.max() for pressure in pressures],
        "mean_contact_pressure": [pressure[pressure > 0].mean() for pressure in pressures],
        "relative_contact_area_pixels": [(pressure > 0).mean() for pressure in pressures],
    }
    return xr.Dataset({name: ("load", values) for name, values in columns.items()})


def judged(task: tuple[str, str, xr.DataArray, int]) -> list[dict]:
    """Return what the checks say of one map with each fault, and what the fault changes."""
    kind, name, height, number = task
    rows, reference = [], {}
    warnings.simplefilter("ignore")
    for fault, faulty in faults(height, number).items():
        window = rc.periodic_window(rc.level(faulty))
        base = "quarter" if fault.startswith("finer") else "none"
        is_original = fault.startswith(("none", "part", "quarter"))
        slope = window.attrs["rms_gradient_after"] if is_original else reference[base][0]
        loads = [load * slope for load in LOADS]
        solved = counted(rc.solve_contact(window, contact_modulus=1.0, mean_pressure=loads, tolerance=1e-2))
        area, peak = (solved[name].values for name in ("relative_contact_area_pixels", "max_pressure"))
        reference.setdefault(fault, (slope, area, peak))
        _, area_before, peak_before = reference[base]
        check_results = [
            checks.smoothed(window.attrs),
            checks.noise(window.attrs),
            checks.isolated_peak(solved, window.attrs),
            checks.height_unit(height.attrs, window.attrs),
            checks.pixel_size(height.attrs, window.attrs),
        ]
        rows.append(
            {"kind": kind, "map": name, "half": ("even", "odd")[number % 2], "fault": fault}
            | {"area": float(area[1] / area_before[1] - 1), "peak": float((peak / peak_before).max() - 1)}
            | {check.name: check.outcome == "review" for check in check_results}
        )
    return rows


def matters(row: pd.Series) -> bool:
    """Return whether a fault changes the result of a map enough to be flagged."""
    if row.fault.startswith("dust"):
        return row.peak > PRESSURE
    if row.fault.startswith("noise"):
        return row.area < LESS_AREA
    return row.fault.startswith(("none", "part", "finer")) or abs(row.area) > AREA


def rates(rows: pd.DataFrame) -> pd.DataFrame:
    """Return how many maps each check flags, by fault, kind and half."""
    rows = rows[rows.fault != "quarter"].assign(
        fault=rows.fault.str.replace(r"(dust|part) \d+", r"\1", regex=True)
    )
    rows = rows[rows.apply(matters, axis=1)]
    names = ["Smoothed", "Noise", "Isolated peak"]
    table = rows.groupby(["fault", "kind", "half"])[names].agg(["sum"]).droplevel(1, axis=1)
    table.insert(0, "maps", rows.groupby(["fault", "kind", "half"]).size())
    return table.astype(int).reset_index()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=pathlib.Path, help="with measured maps")
    parser.add_argument("--write", action="store_true", help=f"write {RESULTS.name}")
    options = parser.parse_args()
    maps = [("measured", name, part_of(height)) for name, height in measured(options.folders).items()]
    maps += [(kind, name, surface) for (kind, name), surface in made().items()]
    with multiprocessing.Pool() as pool:
        tasks = [(*task, number) for number, task in enumerate(maps)]
        rows = [row for rows_of_map in pool.map(judged, tasks, chunksize=1) for row in rows_of_map]
    table = rates(pd.DataFrame(rows))
    print(table.to_string(index=False))
    if options.write:
        table.to_csv(RESULTS, index=False)


if __name__ == "__main__":
    main()
