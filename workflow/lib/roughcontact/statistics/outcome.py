"""Outcome of a check (passed, note, look, failed or not made) with its sentence, and the worst of several."""

import textwrap
from collections.abc import Iterable
from typing import NamedTuple

PASSED, LOOK, FAILED = "passed", "look", "failed"
NOTE = "note"  # worth knowing, but in the interval or in what was asked for; it does not affect the verdict
NOT_MADE = "not made"  # for lack of data; it does not affect the verdict
_SHORT = 80  # letters of a first sentence that is followed by its interpretation
VERDICTS = {PASSED: "use", LOOK: "review", FAILED: "do not use"}  # in the order of the flag `verdict`


class Check(NamedTuple):
    """One check: its name, its outcome (one of those above), and a sentence with the numbers."""

    name: str
    outcome: str
    sentence: str


def verdict(checks: Iterable[Check]) -> str:
    """Return the worst outcome among the checks, a key of `VERDICTS`; `look` where none was made.

    Notes count as passed, checks that were not made not at all.

    Examples
    --------
    >>> verdict([Check("Form", PASSED, "No bow."), Check("Slopes", LOOK, "Steep.")])
    'look'
    """
    outcomes = {PASSED if check.outcome == NOTE else check.outcome for check in checks}
    return next((outcome for outcome in (FAILED, LOOK, PASSED) if outcome in outcomes), LOOK)


def reasons(checks: Iterable[Check]) -> list[Check]:
    """Return the checks that did not pass: warnings (`look`) and failures.

    Examples
    --------
    >>> [check.name for check in reasons([Check("Form", PASSED, "No bow."), Check("Slopes", LOOK, "Steep.")])]
    ['Slopes']
    """
    return [check for check in checks if check.outcome in (FAILED, LOOK)]


def reason(check: Check) -> str:
    """Return the name of a check and its first sentence, or two where that is short, for lists of reasons.

    Examples
    --------
    >>> reason(Check("Slopes", LOOK, "The rms gradient is 0.4: steep. Treat the numbers as estimates."))
    'Slopes: The rms gradient is 0.4: steep. Treat the numbers as estimates'
    """
    first, *others = check.sentence.rstrip(".").split(". ")
    text = f"{first}. {others[0]}" if others and len(first) < _SHORT else first
    return f"{check.name}: {textwrap.shorten(text, 240, placeholder=' …')}"
