"""Outcome of a check (passed, note, review, failed or not made), its sentences, the worst of several.

The outcomes of each check and their sentences are the rows of `checks.tsv`.
"""

import re
import string
from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from roughcontact.arguments.answers import ANSWERS
from roughcontact.arguments.quantities import percent, quantity
from roughcontact.arguments.rows import rows_beside

PASSED, REVIEW, FAILED = "passed", "review", "failed"
NOTE = "note"  # worth knowing, but in the interval or in what was asked for; it does not affect the verdict
NOT_MADE = "not made"  # for lack of data; it does not affect the verdict
_PART, _CONCERNS = "part", "concerns"  # of sentences, and answers, in the column of outcomes
VERDICTS = {PASSED: "use", REVIEW: "review", FAILED: "do not use"}  # in the order of the flag `verdict`


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


class _Sentence(string.Formatter):
    """Template of a sentence, with numbers as {share:%}, {length:m}, {ratio:2}: in a unit, of some digits."""

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a fact as sentences have it; three digits where none are stated."""
        match = re.fullmatch(r"(\d?) ?(%|m|N|Pa|Pa s)?", format_spec)
        if not match or not format_spec:
            return super().format_field(value, format_spec)
        digits, unit = int(match[1] or 3), match[2] or "1"
        number = float(value)
        return percent(number, digits=digits) if unit == "%" else quantity(number, unit, digits=digits)


def _cases() -> dict[str, dict[str, Check]]:
    """Return each check by name and case, its sentences to be filled in, with all their parts."""
    checks: dict[str, dict[str, Check]] = defaultdict(dict)
    parts: dict[str, dict[str, str]] = defaultdict(dict)
    answers: dict[str, tuple[str, ...]] = {}
    for check, case, outcome, *sentences in rows_beside(__file__, "checks.tsv"):
        finding, *further = (_with_parts(sentence, parts[check]) for sentence in sentences)
        if outcome == _PART:
            parts[check][case] = finding
        elif outcome == _CONCERNS:
            answers[check] = tuple(finding.split())
        else:
            checks[check][case] = Check(check, outcome, finding, answers.get(check, tuple(ANSWERS)), *further)
    return checks


def _with_parts(sentence: str, parts: Mapping[str, str]) -> str:
    """Return a sentence with its parts in place of their names in braces."""
    for name, text in parts.items():
        sentence = sentence.replace(f"{{{name}}}", text)
    return sentence


_CASES = _cases()


def judge(name: str, cases: Mapping[str, object], /, **facts: Any) -> Check:
    """Return a check by the first of its `cases` in `checks.tsv` that holds, "" where none does.

    Parameters
    ----------
    name : str
        of the check.
    cases : mapping
        of the check, the gravest first, each with what is true where it holds.
    **facts
        what the sentences name.

    Returns
    -------
    Check

    Examples
    --------
    >>> judge("Window", {"cropped": False}, share=0.81).sentence
    'The solved window covers 81.0 % of the measured map.'
    """
    case = next((case for case, holds in cases.items() if holds), "")
    check = _CASES[name][case]
    sentences = (check.finding, check.explanation, check.advice)
    finding, explanation, advice = (_Sentence().vformat(sentence, (), facts) for sentence in sentences)
    return check._replace(finding=finding, explanation=explanation, advice=advice)


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
    """Return warnings and failed checks, failed ones first, each in the order of `checks.tsv`.

    Examples
    --------
    >>> flows, rejected = Check("Plasticity", REVIEW, "It flows."), Check("Outliers", REVIEW, "They carry.")
    >>> [check.name for check in sort_by_importance([flows, rejected, Check("Window", FAILED, "A step.")])]
    ['Window', 'Outliers', 'Plasticity']
    """
    importance = [*_CASES]
    return sorted(checks, key=lambda check: (check.outcome != FAILED, importance.index(check.name)))


def reason_text(check: Check) -> str:
    """Return name, answers concerned, finding and advice of a check.

    Examples
    --------
    >>> reason_text(Check("Slopes", REVIEW, "The rms gradient is 0.4.", advice="Refine."))
    'Slopes: The rms gradient is 0.4. Refine'
    >>> reason_text(Check("Sample", REVIEW, "The map is small.", ("mean_gap", "sealing")))
    'Sample (mean gap, sealing): The map is small'
    """
    subject = f" ({concerns(check)})" if concerns(check) else ""
    text = " ".join(filter(None, (f"{check.name}{subject}:", check.finding, check.advice)))
    return text.rstrip(".")


def brief_reason(check: Check, letters: int) -> str:
    """Return the reason of a check, where it has more than so many letters what to do alone.

    Examples
    --------
    >>> steep = Check("Slopes", REVIEW, "The rms gradient is 0.4.", advice="Refine.")
    >>> brief_reason(steep, 40), brief_reason(steep, 20)
    ('Slopes: The rms gradient is 0.4. Refine', 'Slopes: Refine')
    """
    text = reason_text(check)
    return reason_text(check._replace(finding="")) if check.advice and len(text) > letters else text


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
