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
    """Return one row for each grid and tolerance: seconds, and the expected errors.

    The expected error is the largest over the loads, of this choice and of all finer or tighter ones: a
    coarse grid that is right by chance is not reliable.

    Parameters
    ----------
    table : DataFrame
        as `measure.run_time_against_error` returns it.

    Returns
    -------
    DataFrame
        `seconds`, `points_x`, `points_y`, `tolerance`, and for each quantity of `WORDS` its relative
        `..._error`.
    """
    keys = ["points_x", "points_y", "tolerance"]
    errors = [f"{name}_error" for name in WORDS]
    grouped = table.groupby(keys, as_index=False).agg({"seconds": "first"} | dict.fromkeys(errors, "max"))
    rows = []
    for _, row in grouped.iterrows():
        finer = (grouped[keys[:2]] >= row[keys[:2]]).all(axis=1) & (grouped["tolerance"] <= row["tolerance"])
        rows.append(pd.concat([row[["seconds", *keys]], grouped.loc[finer, errors].max()]))
    return pd.DataFrame(rows).astype({"points_x": int, "points_y": int})


def cheapest(table: pd.DataFrame, quantity: str, target: float) -> pd.Series | None:
    """Return the fastest row of `choices` with at most a relative error of `target` in a key of `WORDS`.

    None where no choice reaches it.
    """
    options = choices(table)
    reached = options[options[f"{quantity}_error"] <= target]
    return None if reached.empty else reached.iloc[reached["seconds"].argmin()]


def advice(table: pd.DataFrame) -> list[str]:
    """Return sentences like: for 1 % in contact area, solve at 1024 × 1024 with tolerance 1e-3: 0.4 s.

    There is one for each quantity of `WORDS` and the targets 5 %, 1 % and 0.2 %; targets with the same choice
    share a sentence.

    Examples
    --------
    >>> import pandas as pd
    >>> grid = {"points_x": [64], "points_y": [64], "tolerance": [1e-3], "seconds": [0.02]}
    >>> advice(pd.DataFrame(grid | {f"{name}_error": [0.03] for name in WORDS}))[0]
    'For 5 % in contact area, solve at 64 × 64 with tolerance 1e-3: 0.020 s.'
    """
    sentences = []
    options = choices(table)
    for quantity, words in WORDS.items():
        found = {target: cheapest(table, quantity, target) for target in _TARGETS}
        reached = [(target, row) for target, row in found.items() if row is not None]
        for _, group in groupby(reached, key=lambda pair: in_words(pair[1])):
            targets, rows = zip(*group, strict=True)
            wanted = " or ".join(f"{100 * target:g} %" for target in targets)
            seconds = number(rows[-1]["seconds"], digits=2)
            sentences.append(f"For {wanted} in {words}, solve at {in_words(rows[-1])}: {seconds} s.")
        missed = [target for target, row in found.items() if row is None]
        if missed:
            best = options.iloc[options[f"{quantity}_error"].argmin()]
            left = percent(best[f"{quantity}_error"])
            sentences.append(
                f"For {100 * missed[0]:g} % in {words}, no grid of this comparison is fine enough; the best, "
                f"{in_words(best)}, has {left}."
            )
    return sentences


def in_words(row: pd.Series) -> str:
    """Return the grid, x first, or the points of a profile, and the tolerance of a row of `choices`.

    Examples
    --------
    >>> import pandas as pd
    >>> in_words(pd.Series({"points_x": 1024.0, "points_y": 1.0, "tolerance": 1e-3}))
    '1024 with tolerance 1e-3'
    """
    sides = [f"{int(row[f'points_{axis}'])}" for axis in ("x", "y") if row[f"points_{axis}"] > 1]
    return f"{' × '.join(sides)} with tolerance {short(row['tolerance'])}"


def short(tolerance: float) -> str:
    """Return a tolerance as it is written in the settings, with one digit and a short exponent.

    Examples
    --------
    >>> short(0.001), short(1e-10)
    ('1e-3', '1e-10')
    """
    return f"{tolerance:.0e}".replace("e-0", "e-")
