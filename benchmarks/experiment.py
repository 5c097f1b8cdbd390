"""Hold the computed closure of three rock fractures against the measured one, loading and unloading.

    python benchmarks/experiment.py FOLDER --write

FOLDER has for each specimen N `granodiorite-N.npz` (`aperture_um` (y, x), the distance of the two measured
faces before loading, with `dx`, `dy` in m) and `granodiorite-N-closure.csv` (normal stress in MPa, closure in
µm, up and down). Nothing is fitted: the faces fit one another, so that the pair is the contact of the negated
aperture with a flat, of two halves of the same rock. The largest square within the disc is solved as a whole
and cut into 4, 9 and 16 parts, each levelled and made periodic. The parts tell how the face scatters; nothing
tells which cut is right: a part settles by itself, as the specimen cannot, and the whole square has a period
that the specimen has not. The closure is the mean over the cuts, within a rectangular distribution over their
range (JCGM 100:2008, 4.3.7). Source of the data: Vogler and others (2018), J. Geophys. Res. Solid Earth 123,
1186; no licence is stated, so that they are not in this repository.
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
CUTS = (1, 2, 3, 4)  # parts along each side
SEATED = 1e6  # Pa: closure counts from the first load above, before which faces still find their place
UNREADABLE = 65535
STEP = 1e-3 / 255  # m, of the colours that the apertures were read from
# Pa, of the water that a pump feeds at 5 ml/min into the middle of the fracture, at 0.26 and 10.27 MPa
FLUID_PRESSURE = {1: (111.7e3, 197.2e3), 2: (125.5e3, 1810.6e3), 3: (114.5e3, 2505.6e3)}
PUMPED, VISCOSITY = 5e-6 / 60, 1e-3  # m3/s, and Pa s
RADII_RATIO = (
    15  # of specimen and borehole, which is not stated; the aperture goes as the cube root of its ln
)


def parts_of(aperture: np.ndarray, dy: float, dx: float, *, cut: int) -> list:
    """Return the levelled, periodic windows (m) of cut x cut parts of the largest square in the disc."""
    ny, nx = aperture.shape
    points = int(min(ny, nx) / math.sqrt(2) / cut) // 2 * 2
    windows = []
    for row in range(cut):
        for column in range(cut):
            y0, x0 = (n // 2 - cut * points // 2 + k * points for n, k in ((ny, row), (nx, column)))
            height = rc.height_map(-aperture[y0 : y0 + points, x0 : x0 + points], (dy, dx))
            windows.append(rc.periodic_window(rc.level(height, outlier_threshold=None)))
    return windows


def closures(
    windows: list, loads: np.ndarray, modulus: float, first_load: int, *, hardness: float | None = None
) -> np.ndarray:
    """Return the closure (m) of each window from one of the loads on; with a hardness of both ways."""
    rows = []
    for window in windows:
        solved = rc.solve_contact(window, contact_modulus=modulus, mean_pressure=loads, hardness=hardness)
        row = solved["approach"].values
        if hardness is not None:
            row = np.append(row, rc.unload(solved, mean_pressure=loads[::-1])["approach"].values)
        rows.append(row[first_load] - row)
    return np.array(rows)


def interval(cuts: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return mean over the cuts and half-width (95 %) from the closures (modulus, part, load) of each cut."""
    means = np.array([closure.mean(1) for closure in cuts])
    of_cuts, of_moduli = means.mean(1), means.mean(0)
    scatter = [
        (closure.var(1, ddof=1) / closure.shape[1]).mean(0) for closure in cuts if closure.shape[1] > 1
    ]
    variance = np.mean(scatter, axis=0) + (np.ptp(of_cuts, axis=0) ** 2 + np.ptp(of_moduli, axis=0) ** 2) / 12
    freedom = sum(closure.shape[1] - 1 for closure in cuts)
    # the colours are steps of STEP: an error of the mean gap, uniform within a step
    return of_moduli.mean(0), stats.t.ppf(0.975, freedom) * np.sqrt(variance + STEP**2 / 12)


def contact_modulus(youngs_modulus: float) -> float:
    """Return E* (Pa) of two halves of the same rock."""
    return youngs_modulus / (2 * (1 - POISSONS_RATIO**2))


def read_specimen(folder: Path, number: int) -> tuple[np.ndarray, float, float, np.ndarray]:
    """Return aperture (y, x; m), dy and dx (m), and the columns of measured stress (Pa) and closure (m)."""
    with np.load(folder / f"granodiorite-{number}.npz") as file:
        raw, dy, dx = file["aperture_um"], float(file["dy"]), float(file["dx"])
    measured = np.loadtxt(folder / f"granodiorite-{number}-closure.csv", delimiter=",", skiprows=1)
    return np.where(raw == UNREADABLE, np.nan, raw * 1e-6), dy, dx, measured * (1e6, 1e-6)


def specimen(folder: Path, number: int, *, cuts: tuple[int, ...] = CUTS) -> pd.DataFrame:
    """Return a row for each load of a specimen: measured and computed closure (m), up and down."""
    aperture, dy, dx, measured = read_specimen(folder, number)
    top = int(measured[:, 0].argmax())
    up, down = measured[: top + 1], measured[top:][::-1]
    loads, first_load = up[:, 0], int(np.searchsorted(up[:, 0], SEATED))
    windows = [parts_of(aperture, dy, dx, cut=cut) for cut in cuts]
    mean, half = interval(
        [
            np.array([closures(parts, loads, contact_modulus(youngs), first_load) for youngs in MODULI])
            for parts in windows
        ]
    )
    columns = {"specimen": number, "way": "up", "mean_pressure_Pa": loads}
    tables = [pd.DataFrame(columns | {"measured_m": up[:, 1], "closure_m": mean, "half_width_m": half})]
    for hardness in HARDNESSES:
        closures_up_and_down = [
            closures(parts, loads, contact_modulus(np.mean(MODULI)), first_load, hardness=hardness).mean(0)
            for parts in windows
        ]
        measured_ways = {"up": (loads, up[:, 1]), "down": (loads[::-1], np.interp(loads[::-1], *down.T))}
        for (way, (load, closure)), computed in zip(
            measured_ways.items(), np.split(np.mean(closures_up_and_down, 0), 2), strict=True
        ):
            columns = {"specimen": number, "way": f"{way}, hardness {hardness / 1e6:.0f} MPa"}
            columns |= {"mean_pressure_Pa": load, "measured_m": closure, "closure_m": computed}
            tables.append(pd.DataFrame(columns))
    table = pd.concat(tables, ignore_index=True)
    return table.assign(measured_m=table["measured_m"] - up[first_load, 1])


def hydraulic_apertures(
    folder: Path,
    number: int,
    *,
    youngs_modulus: float = float(np.mean(MODULI)),
    hardness: float | None = None,
) -> tuple[float, float]:
    """Return the distance (m) of plates that let as much through: computed, measured at the largest load.

    The measured one is an upper end: by the rise of the fluid pressure alone, of which pipes have no share.
    """
    aperture, dy, dx, measured = read_specimen(folder, number)
    (window,) = parts_of(aperture, dy, dx, cut=1)
    solved = rc.solve_contact(
        window,
        contact_modulus=contact_modulus(youngs_modulus),
        mean_pressure=measured[:, 0].max(),
        hardness=hardness,
    )
    counted = rc.contact_statistics(solved, flow="always")
    factor = math.sqrt(float(counted["flow_factor_xx"][0] * counted["flow_factor_yy"][0]))
    low, high = FLUID_PRESSURE[number]
    # from a borehole to the edge of a disc between plates: Q = pi h^3 dp/(6 eta ln(R/r))
    cube = 6 * VISCOSITY * PUMPED * math.log(RADII_RATIO) / (math.pi * (high - low))
    return float(counted["mean_gap"][0]) * factor ** (1 / 3), cube ** (1 / 3)


def draw(table: pd.DataFrame, path: Path) -> None:
    """Draw measured closures as points over the computed ones: loading with its interval, both ways."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 3.6), layout="constrained")
    axes = figure.subplots(1, 3, sharey=True)
    for ax, (number, rows) in zip(axes, table.groupby("specimen"), strict=True):
        for way, color in (("up", "C0"), ("down", "C1")):
            if way == "up":
                loading = rows[rows["way"] == "up"]
                load, mean, half = (
                    loading[name] for name in ("mean_pressure_Pa", "closure_m", "half_width_m")
                )
                closure_interval = 1e6 * (mean - half), 1e6 * (mean + half)
                ax.fill_between(
                    load / 1e6, *closure_interval, color=color, alpha=0.25, lw=0, label="computed, 95 %"
                )
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
    parser.add_argument("--cuts", type=int, nargs="+", default=CUTS, help="parts along each side")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    table = pd.concat([specimen(options.folder, number, cuts=options.cuts) for number in FLUID_PRESSURE])
    up = table[(table["way"] == "up") & (table["closure_m"] > 0)]
    deviation = (up["measured_m"] - up["closure_m"]).abs()
    print(f"inside: {(deviation <= up['half_width_m']).sum()} of {len(up)}; ", end="")
    print(f"half-width, median: {100 * (up['half_width_m'] / up['closure_m']).median():.0f} %")
    columns = ["measured_m", "closure_m", "half_width_m"]
    print((up.set_index(["specimen", "mean_pressure_Pa"])[columns] * 1e6).round(1).to_string())
    for (number, way), rows in table[table["way"].str.startswith("down")].groupby(["specimen", "way"]):
        residual, reference = (1e6 * rows.iloc[-1][name] for name in ("closure_m", "measured_m"))
        print(number, way, f"{residual:.1f} µm left, measured {reference:.1f}")
    for number in FLUID_PRESSURE:
        computed, reference = (1e6 * value for value in hydraulic_apertures(options.folder, number))
        softer, _ = hydraulic_apertures(options.folder, number, youngs_modulus=MODULI[0] / 2)
        flowing, _ = hydraulic_apertures(options.folder, number, hardness=HARDNESSES[0])
        print(number, f"hydraulic aperture {computed:.0f} µm, measured {reference:.1f} at most; ", end="")
        print(f"with half the modulus {1e6 * softer:.0f}, with a hardness {1e6 * flowing:.0f} µm")
    if options.write:
        table.to_csv(RESULTS, index=False, float_format="%.6g")
        draw(table, PICTURE)


if __name__ == "__main__":
    main()
