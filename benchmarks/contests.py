"""Error against CPU time: all contestants on a problem, in turns.

A contestant has `name`, `how` (it is used), `kind` (a key of KINDS), `settings(problem)`, from loose to
tight, and `prepare(problem, setting)`, which gives a run: `run()` starts from t = 0 again and returns the
CPU seconds of the integration alone and the motion at the reference times. What a contestant cannot do it
says by raising `Cannot`, and the report tells it.
"""

from collections.abc import Callable, Container, Iterable
from dataclasses import asdict, dataclass, field

import numpy as np

from .problems import Problem

QUICK_LEVELS = (1, 2, 3)
KINDS = {
    "ours": "a stepper of mbdfmi",
    "package": "a peer that integrates by itself",
    "loop": "a peer's dynamics in a loop of ours",
    "limit": "a program for that one mechanism",
}
AIMS = (1e-8, 1e-10)  # errors at which CPU times are compared


class Cannot(Exception):
    """A contestant cannot run this; the text says why."""


@dataclass(frozen=True)
class Setting:
    """One setting of a contestant.

    label : in words.  values : by the contestant's own names.  level : 0 the loosest.
    series : settings of one series differ in their level alone.
    """

    label: str
    values: dict
    level: int
    series: str = ""


@dataclass(frozen=True)
class Limits:
    """How much time is spent.

    levels : of the settings that are run, 0 the loosest.
    rounds : of all contestants, at most.
    longest : s of CPU; what takes longer is not run at the tighter settings of its series.
    enough : s of CPU; what has taken so much in all rounds together is not repeated.
    """

    levels: Container[int] = range(100)
    rounds: int = 7
    longest: float = 3.0
    enough: float = 0.3


QUICK = Limits(levels=QUICK_LEVELS, rounds=2, longest=0.4, enough=0.2)


@dataclass
class Point:
    """One contestant at one setting.

    cpu_s : least of the rounds, None when it failed.  error : of the state (see Problem.error).
    effort : what the contestant counts beside, as steps.  reason : why there is no figure.
    """

    setting: str
    values: dict
    cpu_s: float | None = None
    error: float | None = None
    rounds: int = 0
    effort: dict = field(default_factory=dict)
    reason: str | None = None
    spent: float = 0.0

    def take(self, run, problem: Problem):
        """Runs once more, and keeps the least time."""
        seconds, table = run.run()

        if not np.all(np.isfinite(table)):
            raise Cannot("the motion is not finite")

        self.spent += seconds
        self.rounds += 1
        self.cpu_s = min(seconds, self.cpu_s or np.inf)

        if self.error is None:
            self.error = problem.error(table)
            self.effort = dict(getattr(run, "effort", {}))


def contest(problem: Problem, contestants: Iterable, limits: Limits, tell: Callable[[str], None]) -> dict:
    """name -> list of Points (as dicts), of every contestant on a problem.

    tell : called with what comes next.
    """
    results, running = {}, []

    for contestant in contestants:
        tell(f"{problem.title}: {contestant.name}")
        points = results[contestant.name] = []

        too_long = {}

        for setting in contestant.settings(problem):
            if setting.level not in limits.levels:
                continue

            point = Point(setting.label, setting.values)
            points.append(point)

            if setting.series in too_long:
                before = too_long[setting.series]
                point.reason = f"not run: {before.setting} took {before.cpu_s:.1f} s"
                continue

            try:
                run = contestant.prepare(problem, setting)
            except Cannot as why:
                point.reason = str(why)
                break

            try:
                point.take(run, problem)
            except Cannot as why:
                point.reason = str(why)
            else:
                running.append((run, point))

                if point.cpu_s > limits.longest:
                    too_long[setting.series] = point

    for k in range(1, limits.rounds):
        tell(f"{problem.title}: round {k + 1} of {limits.rounds}")

        for run, point in running:
            if point.spent < limits.enough:
                point.take(run, problem)

    return {name: [asdict(point) for point in points] for name, points in results.items()}


def front_of(points: list[dict]) -> list[dict]:
    """Of points with `cpu_s` and `error`, those that no other beats in both, by time."""
    front = []

    for point in sorted(points, key=lambda point: (point["cpu_s"], point["error"])):
        if not front or point["error"] < front[-1]["error"]:
            front.append(point)

    return front


def cpu_at(points: list[dict], error: float) -> float | None:
    """CPU seconds that an error costs, by lines in log-log along the front; None where no point is so exact.

    Nothing is made up beyond the front: whoever is more exact than asked for at its fastest is given that
    time.
    """
    front = front_of([point for point in points if point["cpu_s"]])
    exact = [k for k, point in enumerate(front) if point["error"] <= error]

    if not exact:
        return None

    k = exact[0]

    if k == 0:
        return front[0]["cpu_s"]

    x = np.log([max(point["error"], 1e-17) for point in front[k - 1 : k + 1]])
    y = np.log([point["cpu_s"] for point in front[k - 1 : k + 1]])
    return float(np.exp(y[0] + (np.log(error) - x[0]) / (x[1] - x[0]) * (y[1] - y[0])))
