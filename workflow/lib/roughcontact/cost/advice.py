"""The cheapest grid and tolerance for a wanted error, in words."""

from itertools import groupby

import pandas as pd

from roughcontact.quantities import number, percent

WORDS = {
    "relative_contact_area": "contact area",
    "mean_gap": "mean gap",
    "max_pressure": "largest pressure",
}
_TARGETS = (0.05, 0.01, 0.002)


def choices(table: pd.DataFrame) -> pd.DataFrame:
    """Return one row for each grid and tolerance: seconds, and the errors to count on.

    The error to count on is the largest over the loads, of this choice and of all that are finer or tighter:
    a coarse grid that comes out right by chance is not to be trusted.

    Parameters
    ----------
    table : DataFrame
        as `measure.run_time_against_error` returns it.
    """
    keys = ["points_x", "points_y", "tolerance"]
    errors = [f"{name}_error" for name in WORDS]
    grouped = table.groupby(keys, as_index=False).agg({"seconds": "first"} | dict.fromkeys(errors, "max"))
    rows = []
    for _, row in grouped.iterrows():
        finer = (grouped[keys[:2]] >= row[keys[:2]]).all(axis=1) & (grouped["tolerance"] <= row["tolerance"])
        rows.append({"seconds": row["seconds"], **row[keys], **grouped.loc[finer, errors].max()})
    return pd.DataFrame(rows).astype({"points_x": int, "points_y": int})


def cheapest(table: pd.DataFrame, quantity: str, target: float):
    """Return the row of `choices` that reaches the target soonest; None where none does."""
    options = choices(table)
    reached = options[options[f"{quantity}_error"] <= target]
    return None if reached.empty else reached.loc[reached["seconds"].idxmin()]


def advice(table: pd.DataFrame) -> list[str]:
    """Return sentences like: for 1 % in contact area, solve at 1024 × 1024 with tolerance 1e-3: 0.4 s."""
    sentences = []
    options = choices(table)
    for quantity, words in WORDS.items():
        found = {target: cheapest(table, quantity, target) for target in _TARGETS}
        reached = [target for target, row in found.items() if row is not None]
        # targets that one choice serves stand in one sentence
        for _, targets in groupby(reached, key=lambda target: in_words(found[target])):
            targets = list(targets)
            row = found[targets[-1]]
            wanted = " or ".join(f"{100 * target:g} %" for target in targets)
            sentences.append(
                f"For {wanted} in {words}, solve at {in_words(row)}: {number(row['seconds'], digits=2)} s."
            )
        missed = [target for target, row in found.items() if row is None]
        if missed:
            best = options.loc[options[f"{quantity}_error"].idxmin()]
            left = percent(best[f"{quantity}_error"])
            sentences.append(
                f"For {100 * missed[0]:g} % in {words}, no grid that was tried is fine enough; the best, "
                f"{in_words(best)}, leaves {left}."
            )
    return sentences


def in_words(row) -> str:
    """Return a grid, x first, or the points of a profile, and the tolerance."""
    sides = [f"{int(row[f'points_{axis}'])}" for axis in ("x", "y") if row[f"points_{axis}"] > 1]
    return f"{' × '.join(sides)} with tolerance {short(row['tolerance'])}"


def short(tolerance: float) -> str:
    """Return 0.001 as 1e-3."""
    return f"{tolerance:.0e}".replace("e-0", "e-")
