"""Hold the computed closure of three rock fractures against the measured one, loading and unloading.

    python benchmarks/experiment.py FOLDER --write

FOLDER has for each specimen N `granodiorite-N.npz` (`aperture_um` (y, x), the distance of the two measured
faces before loading, with `dx`, `dy` in m) and `granodiorite-N-closure.csv` (normal stress in MPa, closure in
µm, up and down). Nothing is fitted: the faces fit one another, so that the pair is the contact of the negated
aperture with a flat, of two halves of the same rock. The largest square within the disc is divided into nine
parts, as the ± of a map is; each is levelled, made periodic and solved, and the mean of the parts has the
interval of Student's t, combined with that of the modulus. Source of the data: Vogler and others (2018),
J. Geophys. Res. Solid Earth 123, 1186; no licence is stated, so that they are not in this repository.
"""

import argparse
import math
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc

RESULTS = Path(__file__).parent / "results" / "experiment.csv"
PICTURE = Path(__file__).parents[1] / "docs" / "explanation" / "experiment.png"
MODULI = (10e9, 12e9)  # Pa, measured (Young's modulus)
POISSONS_RATIO = 0.33  # assumed by the authors
HARDNESSES = (200e6, 400e6, 800e6)  # Pa; not measured
PARTS = 3  # along each side
SEATED = 1e6  # Pa: closure counts from the first load above, before which faces still find their place
UNREADABLE = 65535
STEP = 1e-3 / 255  # m, of the colours that the apertures were read from


def parts_of(aperture: np.ndarray, dy: float, dx: float, *, parts: int = PARTS) -> list:
    """Return the levelled, periodic windows (m) of the parts of the largest square in the disc."""
    ny, nx = aperture.shape
    points = int(min(ny, nx) / math.sqrt(2) / parts) // 2 * 2
    windows = []
    for row in range(parts):
        for column in range(parts):
            y0, x0 = (n // 2 - parts * points // 2 + k * points for n, k in ((ny, row), (nx, column)))
            height = rc.height_map(-aperture[y0 : y0 + points, x0 : x0 + points], (dy, dx))
            windows.append(rc.periodic_window(rc.level(height, outlier_threshold=None)))
    return windows


def approaches(
    windows: list, loads: np.ndarray, modulus: float, *, hardness: float | None = None
) -> np.ndarray:
    """Return the approach (m) of each window under each load; with a hardness of the way back as well."""
    rows = []
    for window in windows:
        solved = rc.solve_contact(window, contact_modulus=modulus, mean_pressure=loads, hardness=hardness)
        row = solved["approach"].values
        if hardness is not None:
            row = np.append(row, rc.unload(solved, mean_pressure=loads[::-1])["approach"].values)
        rows.append(row)
    return np.array(rows)


def interval(samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and half-width (95 %) of the mean over the first axis, by Student's t."""
    count = len(samples)
    spread = samples.std(0, ddof=1) / math.sqrt(count)
    return samples.mean(0), stats.t.ppf(0.975, count - 1) * spread


def specimen(folder: Path, number: int, *, parts: int = PARTS) -> pd.DataFrame:
    """Return a row for each load of a specimen: measured and computed closure (m), up and down."""
    with np.load(folder / f"granodiorite-{number}.npz") as file:
        raw, dy, dx = file["aperture_um"], float(file["dy"]), float(file["dx"])
    aperture = np.where(raw == UNREADABLE, np.nan, raw.astype(float) * 1e-6)
    measured = np.loadtxt(folder / f"granodiorite-{number}-closure.csv", delimiter=",", skiprows=1)
    top = int(measured[:, 0].argmax())
    loads, first = measured[: top + 1, 0] * 1e6, int(np.searchsorted(measured[: top + 1, 0], SEATED / 1e6))
    windows = parts_of(aperture, dy, dx, parts=parts)
    by_modulus = []
    for youngs_modulus in MODULI:
        modulus = youngs_modulus / (2 * (1 - POISSONS_RATIO**2))
        approach = approaches(windows, loads, modulus)
        by_modulus.append(interval(approach[:, [first]] - approach))
    means, halves = (np.array(values) for values in zip(*by_modulus, strict=True))
    # the colours are steps of STEP: an error of each part's mean gap, uniform within a step
    rounding = 1.96 * STEP / math.sqrt(12) / math.sqrt(len(windows))
    half = np.hypot(halves.mean(0), rounding) + np.abs(np.diff(means, axis=0)[0]) / 2
    rows = pd.DataFrame(
        {
            "specimen": number,
            "way": "up",
            "mean_pressure_Pa": loads,
            "measured_m": (measured[: top + 1, 1] - measured[first, 1]) * 1e-6,
            "closure_m": means.mean(0),
            "half_width_m": half,
        }
    )
    tables, modulus = [rows], np.mean(MODULI) / (2 * (1 - POISSONS_RATIO**2))
    back = measured[top:][::-1]
    known = np.interp(loads[::-1] / 1e6, back[:, 0], back[:, 1]) - measured[first, 1]
    for hardness in HARDNESSES:
        approach = approaches(windows, loads, modulus, hardness=hardness)
        mean, _ = interval(approach[:, [first]] - approach)
        ways = {"up": loads, "down": loads[::-1]}
        for way, part in zip(ways, np.split(mean, 2), strict=True):
            columns = {"specimen": number, "way": f"{way}, hardness {hardness / 1e6:.0f} MPa"}
            columns |= {"mean_pressure_Pa": ways[way], "closure_m": part}
            columns["measured_m"] = rows["measured_m"].values if way == "up" else known * 1e-6
            tables.append(pd.DataFrame(columns))
    return pd.concat(tables, ignore_index=True)


def draw(table: pd.DataFrame, path: Path) -> None:
    """Draw measured closures as points over the computed ones: loading with its interval, both ways."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 3.6), layout="constrained")
    axes = figure.subplots(1, 3, sharey=True)
    for ax, (number, rows) in zip(axes, table.groupby("specimen"), strict=True):
        for way, color in (("up", "C0"), ("down", "C1")):
            if way == "up":
                part = rows[rows["way"] == "up"]
                load, mean, half = (part[name] for name in ("mean_pressure_Pa", "closure_m", "half_width_m"))
                ends = 1e6 * (mean - half), 1e6 * (mean + half)
                ax.fill_between(load / 1e6, *ends, color=color, alpha=0.25, lw=0, label="computed, 95 %")
                ax.plot(load / 1e6, 1e6 * mean, color=color, label="computed, elastic")
            for hardness, style in zip(HARDNESSES, (":", "--", "-."), strict=True):
                part = rows[rows["way"] == f"{way}, hardness {hardness / 1e6:.0f} MPa"]
                label = f"hardness {hardness / 1e6:.0f} MPa" if way == "down" else None
                ax.plot(
                    part["mean_pressure_Pa"] / 1e6,
                    1e6 * part["closure_m"],
                    color=color,
                    ls=style,
                    lw=1,
                    label=label,
                )
            measured = rows[rows["way"].isin([way, f"{way}, hardness {HARDNESSES[0] / 1e6:.0f} MPa"])]
            fill = color if way == "up" else "none"
            style = {"mec": color, "mfc": fill, "ls": "none", "label": f"measured, {way}"}
            ax.plot(measured["mean_pressure_Pa"] / 1e6, 1e6 * measured["measured_m"], "o", **style)
        ax.set(title=f"specimen {number}", xlabel="normal stress (MPa)")
    axes[0].set_ylabel("closure from the first load above 1 MPa (µm)")
    axes[2].legend(fontsize=7, loc="lower right")
    FigureCanvasAgg(figure).print_png(path)


def main() -> None:
    """Measure, print a summary, and write table and picture if asked."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--parts", type=int, default=PARTS, help="parts along each side")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    table = pd.concat([specimen(options.folder, number, parts=options.parts) for number in (1, 2, 3)])
    up = table[(table["way"] == "up") & (table["closure_m"] > 0)]
    off = (up["measured_m"] - up["closure_m"]).abs()
    print(f"inside: {(off <= up['half_width_m']).sum()} of {len(up)}; ", end="")
    print(f"half-width, median: {100 * (up['half_width_m'] / up['closure_m']).median():.0f} %")
    columns = ["measured_m", "closure_m", "half_width_m"]
    print((up.set_index(["specimen", "mean_pressure_Pa"])[columns] * 1e6).round(1).to_string())
    for (number, way), rows in table[table["way"].str.startswith("down")].groupby(["specimen", "way"]):
        least = rows.iloc[-1]
        print(
            number, way, f"{1e6 * least['closure_m']:.1f} µm left, measured {1e6 * least['measured_m']:.1f}"
        )
    if options.write:
        table.to_csv(RESULTS, index=False, float_format="%.6g")
        draw(table, PICTURE)


if __name__ == "__main__":
    main()
