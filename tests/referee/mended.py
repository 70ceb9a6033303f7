"""Small scenes in which a mended fault would show, each with what must come of it.

In corpus/ stand scenes as users write them, each with a table `referee` beside: `undone` names the mendings
of tests/mutants/undone.py that it watches, `seed` says what is done to the scene and in which ways it runs,
`until` (s) how long. A scene must run to the end, unless `refused` is true. `told` are patterns of what a user
must be told, `untold` of what not; `start` are outputs at the start. `signals` are inputs, polynomials of time
by their coefficients, in place of those that are drawn.
"""

import re
import tomllib
from pathlib import Path

from .findings import Finding

CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.toml"))
NEAR = 1e-8

# mendings that no scene shows, and tests of test_referee.py that do
BESIDE = {
    "nobody looks at the error of what is read off between inner steps": "test_a_wheel_taken_along_by_a_one_way_clutch",
    "a kink or a stiff mode that the step's own estimate does not see may spoil what is read off": (
        "test_a_wheel_taken_along_by_a_one_way_clutch"
    ),
    "estimated_error leaves out what is read off": "test_the_true_error_is_no_more_than_the_sum_of_estimates",
    "outputs that are not finite are handed out": "test_an_instance_that_takes_all",
    "a step backwards is taken": "test_an_instance_that_takes_all",
    "masses whose sums overflow are taken": "test_an_instance_that_takes_all",
    "any tolerance is taken, as a parameter": "test_an_instance_that_takes_all",
    "setting a parameter to the value it has restarts the solver": "test_a_parameter_that_is_set_to_what_it_is",
    "a file that is read is written over": "test_what_users_do_with_files",
    "a link is replaced instead of what it points to": "test_what_users_do_with_files",
    "pipes and devices are replaced by files": "test_what_users_do_with_files",
    "a table is written into a file that promises another format": "test_what_users_do_with_files",
    "a file of another kind is read as TOML": "test_what_users_do_with_files",
}

# mendings that nothing here shows, and why
ELSEWHERE = {
    "a singular start is not told apart": (
        "loops open by so little are taken as not quite closed by now; in none of 40 starts with bars in line is a "
        "loop refused for it"
    ),
    "a gap that is no number is none": (
        "needs places whose sums overflow, starts of 1e308 m, which no scene holds; and then the state and the "
        "outputs, which are looked at by themselves, are refused all the same"
    ),
}


def read(path):
    """(scene, what must come of it) of a file."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    return data, data.pop("referee")


def findings(data, wanted, judge):
    """What is found in a scene, by a `verdicts.judge`, and what does not come of it that must."""
    verdict = judge(data, wanted["seed"], until=wanted["until"], signals=wanted.get("signals"))
    found = list(verdict.findings)

    if (verdict.refused is not None) != wanted.get("refused", False):
        found.append(Finding("refused", "reference", text=verdict.refused or "it must not run"))

    if verdict.stopped is not None:
        found.append(Finding("stopped", "reference", text=verdict.stopped))

    for pattern in wanted.get("told", ()):
        if not any(re.search(pattern, text) for text in verdict.told):
            found.append(Finding("not told", "reference", text=f"{pattern}, but {verdict.told}"))

    for pattern in wanted.get("untold", ()):
        if any(re.search(pattern, text) for text in verdict.told):
            found.append(Finding("told", "reference", text=f"{pattern} in {verdict.told}"))

    for name, value in wanted.get("start", {}).items():
        if name not in verdict.first or not abs(verdict.first[name] - value) <= NEAR * max(1.0, abs(value)):
            taken = verdict.first.get(name, float("nan"))
            found.append(Finding("start", "reference", name, 0.0, taken, value, NEAR))

    return found
