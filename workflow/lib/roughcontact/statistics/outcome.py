"""Outcome of a check (passed, note, review, failed or not made), its sentences, the worst of several."""

import re
import textwrap
from collections.abc import Iterable
from functools import partial
from typing import NamedTuple

from roughcontact.arguments.answers import ANSWERS

PASSED, REVIEW, FAILED = "passed", "review", "failed"
NOTE = "note"  # worth knowing, but in the interval or in what was asked for; it does not affect the verdict
NOT_MADE = "not made"  # for lack of data; it does not affect the verdict
_ELLIPSIS = " …"
_MAX_SENTENCE_LENGTH = 200  # letters, in a list
VERDICTS = {PASSED: "use", REVIEW: "review", FAILED: "do not use"}  # in the order of the flag `verdict`


# names of the checks, by importance: errors of the map come before limits of the material
IMPORTANCE = (
    *("Units", "Height unit", "Pixel size", "Fluid", "Faces", "Lay", "Solver", "Outliers", "Isolated peak"),
    *("Missing points", "Slopes", "Steep places", "Points in contact", "Smoothed", "Noise", "Quantisation"),
    *("Resolution", "Scan lines", "Form", "Periodic window", "Longest wave", "Sample", "Band", "Window"),
    *("Layers", "Local scale", "Mean free path", "Plasticity", "Load range", "Reading the file"),
)


class Check(NamedTuple):
    """One check: its name, its outcome (one of those above), and complete sentences with the numbers."""

    name: str
    outcome: str
    finding: str  # what was found
    answers: tuple[str, ...] = tuple(ANSWERS)  # keys of `ANSWERS` that it concerns
    explanation: str = ""  # why it matters
    advice: str = ""  # what to do

    @property
    def sentence(self) -> str:
        """Return all sentences."""
        return " ".join(filter(None, (self.finding, self.explanation, self.advice)))


# a check by its outcome; `surface_checks` gives it its name, and the answers that it concerns
passed, noted, review, failed = (partial(Check, "", outcome) for outcome in (PASSED, NOTE, REVIEW, FAILED))


def not_made(reason: str, *, advice: str = "") -> Check:
    """Return a check that could not be made, for a reason."""
    return Check("", NOT_MADE, f"Not made: {reason}", advice=advice)


def worst_result(checks: Iterable[Check], *answers: str) -> str:
    """Return the worst outcome of the checks that concern an answer, by default area and pressure in contact.

    It is a key of `VERDICTS`; notes count as passed, and `review` stands where no check was made.
    """
    relevant = set(answers or (name for name, answer in ANSWERS.items() if answer.main))
    outcomes = {check.outcome for check in checks if relevant & {*check.answers}}
    if outcomes & {FAILED, REVIEW}:
        return FAILED if FAILED in outcomes else REVIEW
    # without any check nothing was judged
    return PASSED if outcomes & {PASSED, NOTE} else REVIEW


def not_passed(checks: Iterable[Check]) -> list[Check]:
    """Return the checks that did not pass: warnings (`review`) and failures."""
    return [check for check in checks if check.outcome in (FAILED, REVIEW)]


def sort_by_importance(checks: Iterable[Check]) -> list[Check]:
    """Return warnings and failed checks, failed ones first, each in the order of `IMPORTANCE`.

    Examples
    --------
    >>> flows, rejected = Check("Plasticity", REVIEW, "It flows."), Check("Outliers", REVIEW, "They carry.")
    >>> [check.name for check in sort_by_importance([flows, rejected, Check("Window", FAILED, "A step.")])]
    ['Window', 'Outliers', 'Plasticity']
    """
    return sorted(checks, key=lambda check: (check.outcome != FAILED, IMPORTANCE.index(check.name)))


def reason_text(check: Check, *, letters: int | None = None) -> str:
    """Return name, answers concerned, finding and advice of a check, in so many letters at the most.

    Examples
    --------
    >>> steep = Check("Slopes", REVIEW, "The rms gradient is 0.4.", advice="Refine.")
    >>> reason_text(steep)
    'Slopes: The rms gradient is 0.4. Refine'
    >>> reason_text(steep, letters=30)
    'Slopes: The rms … Refine'
    >>> reason_text(Check("Slopes", REVIEW, "It is steep (0.4 and more)."), letters=28)
    'Slopes: It is steep …'
    >>> reason_text(Check("Sample", REVIEW, "The map is small.", ("mean_gap", "sealing")))
    'Sample (mean gap, sealing): The map is small'
    """
    subject = f" ({concerns(check)})" if concerns(check) else ""
    head = f"{check.name}{subject}:"
    advice = textwrap.shorten(check.advice, _MAX_SENTENCE_LENGTH, placeholder=_ELLIPSIS)
    room = _MAX_SENTENCE_LENGTH if letters is None else max(letters - len(head) - len(advice) - 2, 0)
    # the finding is cut first: what to do stays
    finding = ""
    if room > len(_ELLIPSIS):
        finding = textwrap.shorten(check.finding, min(room, _MAX_SENTENCE_LENGTH), placeholder=_ELLIPSIS)
        finding = re.sub(rf" \([^()]*{_ELLIPSIS}$", _ELLIPSIS, finding)  # a bracket that was cut
    text = " ".join(filter(None, (head, finding, advice))).rstrip(".")
    return text if letters is None else textwrap.shorten(text, letters, placeholder=_ELLIPSIS)


def concerns(check: Check) -> str:
    """Return the answers that a check concerns in words; empty where that is all of them.

    Examples
    --------
    >>> concerns(Check("Sample", REVIEW, "The map is small.", ("mean_gap", "sealing")))
    'mean gap, sealing'
    """
    exceptions = [answer.words for name, answer in ANSWERS.items() if name not in check.answers]
    if len(exceptions) < len(check.answers):
        return f"all but {', '.join(exceptions)}" if exceptions else ""
    return ", ".join(ANSWERS[name].words for name in check.answers)
