"""How long the jobs of a run take, and how long those will take that are left."""

import time
from collections import Counter, defaultdict

# usual seconds of a job, and of a minute of its requested run time per thread, which is an upper limit
_START = dict.fromkeys(("prepare", "prepare_with_overview", "prepare_face", "superpose"), 3.0)
_START_OF_OTHERS, _PER_MINUTE = 6.0, 1.0
_OF_ALL = 6.0  # s of usual time by which the speed of all jobs counts for that of a rule
REPORT = "report"  # the rule with a single job, at the end
_TARGETS = ("all", "default")  # rules whose jobs do nothing


def duration(seconds: float) -> str:
    """Return a time in words.

    Examples
    --------
    >>> duration(0.2), duration(44.0), duration(100.0), duration(3000.0), duration(9000.0)
    ('1 s', '44 s', '2 min', '50 min', '2.5 h')
    """
    if seconds < 60:
        return f"{max(seconds, 1):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def usual(rule: str, minutes: float) -> float:
    """Return the time (s) that a job of so many expected `minutes` per thread usually takes."""
    return _START.get(rule, _START_OF_OTHERS) + _PER_MINUTE * minutes


class Clock:
    """The times of the jobs of a run.

    `expected`: (rule, result) -> minutes and threads of the jobs that have not begun, as the plan has them.
    """

    def __init__(self) -> None:
        self.begin = time.time()
        self.total = self.done = self.width = 0
        self.left: Counter[str] = Counter()  # jobs of each rule, running ones included
        self.taken: defaultdict[str, float] = defaultdict(float)  # seconds of those that have ended, by rule
        self.usual: defaultdict[str, float] = defaultdict(float)  # and the usual seconds of these
        self.expected: dict[tuple[str, str], tuple[float, int]] = {}
        self.running: dict[int, tuple[str, float, float, int]] = {}  # rule, begin, usual seconds, threads

    def plan(self, jobs: dict[str, int]) -> None:
        """Note the number of jobs of each rule."""
        self.left.update({rule: number for rule, number in jobs.items() if rule not in _TARGETS})
        self.total = sum(jobs.values())

    def start(self, job: int, rule: str, now: float, *, result: str = "", threads: int = 1) -> None:
        """Note a job that begins."""
        minutes, _ = self.expected.pop((rule, result), (0.0, 1))
        self.running[job] = (rule, now, usual(rule, minutes / threads), threads)
        self.width = max(self.width, sum(threads for *_, threads in self.running.values()))

    def finish(self, job: int, now: float) -> None:
        """Note a job that has ended."""
        self.done += 1
        if job in self.running:  # a target has done nothing
            rule, begin, seconds, _ = self.running.pop(job)
            self.left[rule] -= 1
            self.taken[rule] += now - begin
            self.usual[rule] += seconds

    def fail(self, job: int) -> None:
        """Note a job that has failed: it is repeated, or never done."""
        self.running.pop(job, None)

    def seconds(self, now: float) -> float | None:
        """Return the time (s) that is left, None until a job has ended.

        The time of a job is its usual one, scaled by the times over the usual ones of its rule so far.
        """
        if not self.usual:
            return None
        speed = sum(self.taken.values()) / sum(self.usual.values())
        work = longest = alone = 0.0
        for rule, jobs in self.left.items():
            scale = (self.taken[rule] + _OF_ALL * speed) / (self.usual[rule] + _OF_ALL)
            running = [job[1:] for job in self.running.values() if job[0] == rule]
            # a job that takes longer than expected is not taken to end at once
            left = [
                (max(scale * seconds - (now - begin), (now - begin) / 4), threads)
                for begin, seconds, threads in running
            ]
            open_jobs = [job for (name, _), job in self.expected.items() if name == rule] or [(0.0, 1)]
            used = [(minutes, max(min(threads, self.width), 1)) for minutes, threads in open_jobs]
            waiting = [(scale * usual(rule, minutes / threads), threads) for minutes, threads in used]
            number = max(jobs - len(running), 0)
            last = max((seconds for seconds, _ in [*left, *(waiting if number else [])]), default=0.0)
            if rule == REPORT:
                alone += last if jobs else 0.0
                continue
            work += sum(seconds * threads for seconds, threads in left)
            work += number * sum(seconds * threads for seconds, threads in waiting) / len(waiting)
            longest = max(longest, last if jobs else 0.0)
        return max(work / max(self.width, 1), longest) + alone

    def words(self, now: float) -> str:
        """Return the time that is left as the end of a line; nothing where it is not known."""
        seconds = self.seconds(now)
        return f", about {duration(seconds)} left" if seconds and self.done < self.total else ""
