"""Outcome of a check (passed, note, look, failed or not made) with its sentence, and the worst of several."""

import textwrap
from collections.abc import Iterable
from typing import NamedTuple

from roughcontact.variables import ANSWERS

PASSED, LOOK, FAILED = "passed", "look", "failed"
NOTE = "note"  # worth knowing, but in the interval or in what was asked for; it does not affect the verdict
NOT_MADE = "not made"  # for lack of data; it does not affect the verdict
_SHORT = 200  # letters of a sentence in a list
_ASKED = ("relative_contact_area", "mean_contact_pressure")
VERDICTS = {PASSED: "use", LOOK: "review", FAILED: "do not use"}  # in the order of the flag `verdict`


class Check(NamedTuple):
    """One check: its name, its outcome (one of those above), and sentences with the numbers.

    The last sentence of a check that did not pass says what to do. `answers` are the keys of `ANSWERS` that
    it concerns.
    """

    name: str
    outcome: str
    sentence: str
    answers: tuple[str, ...] = tuple(ANSWERS)


def verdict(checks: Iterable[Check], *answers: str) -> str:
    """Return the worst outcome among the checks, a key of `VERDICTS`; `look` where none was made.

    Only those count that concern one of the answers, by default contact area and pressure in contact, which
    every load is asked for. Notes count as passed, checks that were not made not at all.

    Examples
    --------
    >>> dust = Check("Isolated peak", LOOK, "One summit stands out.", ("max_pressure",))
    >>> found = [Check("Slopes", PASSED, "Small."), dust]
    >>> verdict(found), verdict(found, "max_pressure")
    ('passed', 'look')
    """
    asked = set(answers or _ASKED)
    outcomes = {
        PASSED if check.outcome == NOTE else check.outcome for check in checks if asked & {*check.answers}
    }
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
    """Return name, answers concerned, first sentence and last, which says what to do, of a check for lists.

    Examples
    --------
    >>> reason(Check("Slopes", LOOK, "The rms gradient is 0.4: steep. It matters. Measure finer."))
    'Slopes: The rms gradient is 0.4: steep. Measure finer'
    >>> reason(Check("Sample", LOOK, "The map is small.", ("mean_gap", "sealing")))
    'Sample (mean gap, sealing): The map is small'
    """
    first, *others = check.sentence.rstrip(".").split(". ")
    sentences = [textwrap.shorten(each, _SHORT, placeholder=" …") for each in (first, *others[-1:])]
    concerned = f" ({concerns(check)})" if concerns(check) else ""
    return f"{check.name}{concerned}: {'. '.join(sentences)}"


def concerns(check: Check) -> str:
    """Return the answers that a check concerns in words; empty where that is all of them.

    Examples
    --------
    >>> concerns(Check("Sample", LOOK, "The map is small.", ("mean_gap", "sealing")))
    'mean gap, sealing'
    """
    others = [words for answer, words in ANSWERS.items() if answer not in check.answers]
    if len(others) < len(check.answers):
        return f"all but {', '.join(others)}" if others else ""
    return ", ".join(ANSWERS[answer] for answer in check.answers)
