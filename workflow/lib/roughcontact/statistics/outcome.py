"""What a check says: passed, look or failed, with a sentence; and the worst of several."""

from collections.abc import Iterable
from typing import NamedTuple

PASSED, LOOK, FAILED = "passed", "look", "failed"
VERDICTS = {PASSED: "trust", LOOK: "look at", FAILED: "do not trust"}


class Check(NamedTuple):
    """One check: its name, its outcome (passed, look, failed), and a sentence with the numbers."""

    name: str
    outcome: str
    sentence: str


def verdict(checks: Iterable[Check]) -> str:
    """Return the worst outcome among the checks.

    Parameters
    ----------
    checks : iterable of Check
        one at least.

    Returns
    -------
    str
        a key of `VERDICTS`.

    Examples
    --------
    >>> verdict([Check("Form", PASSED, "No bow."), Check("Slopes", LOOK, "Steep.")])
    'look'
    """
    outcomes = {check.outcome for check in checks}
    return next(outcome for outcome in (FAILED, LOOK, PASSED) if outcome in outcomes)
