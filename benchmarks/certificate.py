"""Compare the error bound of the solver with the true error, on many random maps.

    python benchmarks/certificate.py --number 1000 --figure docs/explanation/certificate.png

Surfaces of many kinds, 32 to 256 points per side, square or not, single rows, pixels up to a thousand times
longer than wide; loads from one pixel in contact to just below full contact; tolerances from 1e-2 to 1e-9.
The true error is that against a solution converged a thousand times further, in the norm of the bound: the
energy norm without the mean, relative. A reference is itself certified, so that it is known how far the true
error can be from what is printed. Left out, but counted, are cases whose bound is not at least 20 times that
of their reference: contacts of a few points that were solved to the rounding floor at once.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.fourier import halfplane_weights, wavenumbers
from roughcontact.maps import height_map

KINDS = ("self-affine", "white", "bump", "plateaus", "wave")
TIGHTER = 1e-3  # tolerance of the reference over the bound of the solution
TIGHTEST = 1e-14
RESOLVED = 0.05  # largest bound of the reference over that of the solution


def random_case(number: int) -> dict:
    """Return a height map (periodic, unit of length free), a load and a tolerance."""
    generator = np.random.default_rng([2024, number])
    ny, nx = (round(2 ** generator.uniform(5, 8)) for _ in range(2))
    group = generator.choice(["square pixels", "elongated pixels", "profile"], p=[0.6, 0.2, 0.2])
    if group == "profile":
        ny = 1
    elif generator.random() < 0.5:
        ny = nx
    dy = 10 ** generator.uniform(0.5, 3) if group == "elongated pixels" else 1.0
    spacing = (dy, 1.0) if generator.random() < 0.5 else (1.0, dy)
    kind = str(generator.choice(KINDS))
    window = height_map(_heights(kind, (ny, nx), generator), spacing)
    q = wavenumbers(window.shape, spacing)
    # full contact: p = mean + E*|q|/2 h, from the load at which that is nowhere negative
    fluctuation = np.fft.irfft2(0.5 * q * np.fft.rfft2(window.values), s=window.shape)
    one_pixel = 1e-3 / window.size
    load = -fluctuation.min() * 10 ** generator.uniform(np.log10(one_pixel), np.log10(0.99))
    return {
        "window": window,
        "spacing": spacing,
        "group": str(group),
        "kind": kind,
        "load": float(load),
        "tolerance": float(10 ** generator.uniform(-9, -2)),
    }


def _heights(kind: str, shape, generator) -> np.ndarray:
    """Return heights of one kind; distances are counted in points here."""
    ny, nx = shape
    y, x = np.arange(ny)[:, None] / ny, np.arange(nx)[None, :] / nx
    if kind == "white":
        return generator.standard_normal(shape)
    if kind == "bump":
        away_y, away_x = (np.minimum(t, 1 - t) for t in (y, x))
        return -(away_y**2) * (ny > 1) - generator.uniform(0.3, 3) * away_x**2
    if kind == "wave":
        wave = np.cos(2 * np.pi * generator.integers(1, 5) * x)
        return wave + (np.cos(2 * np.pi * generator.integers(1, 5) * y) if ny > 1 else 0)
    k = np.hypot(np.fft.fftfreq(ny, 1 / ny)[:, None], np.fft.rfftfreq(nx, 1 / nx)[None, :])
    k[0, 0] = np.inf
    cutoff = max(nx, ny) / 2 ** generator.uniform(1, 3)
    spectrum = np.fft.rfft2(generator.standard_normal(shape)) * k ** -(generator.uniform(0.2, 1) + 1)
    heights = np.fft.irfft2(np.where(k <= cutoff, spectrum, 0), s=shape)
    if kind == "plateaus":
        heights = np.minimum(heights, np.quantile(heights, generator.uniform(0.5, 0.95)))
    return heights


def energy_norm(field: np.ndarray, spacing) -> float:
    """Return ||field||_G, the energy norm without the mean (up to a factor that cancels in ratios)."""
    q = wavenumbers(field.shape, spacing)
    q[0, 0] = np.inf
    power = halfplane_weights(field.shape) * np.abs(np.fft.rfft2(field - field.mean())) ** 2
    return float(np.sqrt((power / q).sum()))


def measure(number: int) -> dict:
    """Return bound and true error of one random case."""
    case = random_case(number)
    found = {name: case[name] for name in ("group", "kind", "load", "tolerance")}
    found |= {"number": number, "shape": list(case["window"].shape), "spacing": list(case["spacing"])}

    def solve(tolerance):
        contact = rc.solve_contact(
            case["window"],
            contact_modulus=1.0,
            mean_pressure=case["load"],
            tolerance=tolerance,
            on_failure="flag",
        )
        return contact.isel(load=0)

    solution = solve(case["tolerance"])
    reference = solve(max(TIGHTER * float(solution["error_bound"]), TIGHTEST))
    return found | compare(solution, reference, case["spacing"])


def compare(solution, reference, spacing) -> dict:
    """Return bound and true error of a solution of one load, by a `reference` of the same load."""
    pressure, exact = solution["pressure"].values, reference["pressure"].values
    scale = energy_norm(pressure, spacing)
    reference_error = float(reference["error_bound"]) * energy_norm(exact, spacing) / scale
    found = {
        "contact": float(solution["contact"].mean()),
        "points": int(solution["contact"].sum()),
        "bound": float(solution["error_bound"]),
        "converged": bool(solution["converged"]),
        "floor": float(solution["rounding_floor"]),
        "true_error": energy_norm(pressure - exact, spacing) / scale,
        "reference_error": reference_error,
    }
    found["ratio"] = found["bound"] / max(found["true_error"], reference_error, np.finfo(float).tiny)
    found["resolved"] = found["converged"] and reference_error < RESOLVED * found["bound"]
    return found


def report(cases: list[dict]) -> str:
    """Return what the cases say, in words and by group."""
    resolved = [case for case in cases if case["resolved"]]
    missed = [case for case in cases if not case["converged"]]
    lines = [
        (
            f"{len(cases)} cases, contact from {min(c['points'] for c in cases)} point(s) to "
            f"{max(c['contact'] for c in cases):.1%}, true errors from "
            f"{min(c['true_error'] for c in resolved):.0e} to {max(c['true_error'] for c in resolved):.0e}."
        ),
        (
            f"{len(missed)} did not reach their tolerance, "
            f"{sum(case['floor'] > case['tolerance'] for case in missed)} of them because rounding in double "
            "precision hides more than that; "
            f"{sum(case['converged'] and not case['resolved'] for case in cases)} are left out: solved as "
            "well as their reference."
        ),
        "",
        "| maps | cases | bound below error | bound / error: 5 % | 50 % | 95 % | largest | within 3 |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    groups = {"all": resolved}
    for name in ("group", "kind"):
        for value in sorted({case[name] for case in resolved}):
            groups[value] = [case for case in resolved if case[name] == value]
    for name, group in groups.items():
        ratio = np.array([case["ratio"] for case in group])
        low, middle, high = np.quantile(ratio, (0.05, 0.5, 0.95))
        below = sum(is_below(case) for case in group)
        lines.append(
            f"| {name} | {len(group)} | {below} ({below / len(group):.1%}) | {low:.2f} | {middle:.2f} | "
            f"{high:.2f} | {ratio.max():.3g} | {(ratio <= 3).mean():.1%} |"
        )
    lines += ["", "Bounds below the true error:"] if any(map(is_below, resolved)) else []
    lines += [f"- {case}" for case in resolved if is_below(case)]
    worst = max(resolved, key=lambda case: case["ratio"])
    lines += ["", f"Loosest: {worst}"]
    return "\n".join(lines)


def is_below(case: dict) -> bool:
    """Return whether the bound is below the true error, beyond what the reference leaves open."""
    return case["bound"] < case["true_error"] - case["reference_error"]


def draw(cases: list[dict], path: Path) -> None:
    """Draw bound against true error, and the distribution of their ratio."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    resolved = [case for case in cases if case["resolved"] and case["true_error"] > 0]  # for the logarithm
    fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.9), layout="constrained")
    colours = {"square pixels": "#0b6e8f", "elongated pixels": "#c8553d", "profile": "#7a7a7a"}
    for group, colour in colours.items():
        chosen = [case for case in resolved if case["group"] == group]
        true, bound, ratio = (
            np.array([case[name] for case in chosen]) for name in ("true_error", "bound", "ratio")
        )
        left.loglog(true, bound, ".", color=colour, markersize=4, label=group)
        right.hist(
            np.clip(ratio, None, 10),
            np.geomspace(0.9, 10.5, 40),
            color=colour,
            histtype="step",
            label=group,
        )
    ends = np.array([min(case["true_error"] for case in resolved), max(case["bound"] for case in resolved)])
    left.loglog(ends, ends, color="0.3", linewidth=0.8)
    left.loglog(ends, 3 * ends, color="0.3", linewidth=0.8, linestyle=":")
    left.set_xlabel("true error")
    left.set_ylabel("error bound (lines: 1 and 3 times the true error)")
    left.legend(fontsize=8, frameon=False)
    right.set_xscale("log")
    right.set_xticks([1, 2, 3, 5, 10], ["1", "2", "3", "5", "10+"])
    right.minorticks_off()
    right.axvline(1, color="0.3", linewidth=0.8)
    right.axvline(3, color="0.3", linewidth=0.8, linestyle=":")
    right.set_xlabel("error bound / true error")
    right.set_ylabel("cases")
    for ax in (left, right):
        ax.spines[["top", "right"]].set_visible(False)
    fig.savefig(path, dpi=110)
    plt.close(fig)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--number", type=int, default=1000, help="of random cases")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--figure", type=Path, help="PNG or SVG to draw")
    parser.add_argument("--output", type=Path, help="JSON file for all cases")
    options = parser.parse_args()
    cases = []
    for number in range(options.first, options.first + options.number):
        cases.append(measure(number))
        if len(cases) % 100 == 0:
            print(f"{len(cases)} cases", file=sys.stderr, flush=True)
    print(report(cases))
    if options.output:
        options.output.write_text(json.dumps(cases), encoding="utf-8")
    if options.figure:
        draw(cases, options.figure)


if __name__ == "__main__":
    main()
