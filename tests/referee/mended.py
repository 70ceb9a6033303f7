"""Small scenes in which a mended fault would show, each with what must come of it.

In corpus/ stand scenes as users write them, each with a table `referee` beside: `undone` names the mendings
of tests/mutants/undone.py that it watches, `seed` says what is done to the scene and in which ways it runs,
`until` (s) how long. A scene must run, unless `refused` is true. `told` are patterns of what a user must be
told, `untold` of what not; `start` are outputs at the start.
"""

import re
import tomllib
from pathlib import Path

from .findings import Finding

CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.toml"))
NEAR = 1e-8

# mendings that no scene shows, and why
ELSEWHERE = {
    "nobody looks at the error of what is read off between inner steps": (
        "a reading between two inner steps must fall on a kink: tests/test_between_steps.py draws many"
    ),
    "a kink or a stiff mode that the step's own estimate does not see may spoil what is read off": (
        "likewise"
    ),
    "estimated_error leaves out what is read off": (
        "the solver's estimate of its own error is compared with nothing: tests/test_between_steps.py"
    ),
    "the turn of an angle outside the tree is that nearest to the last step": (
        "tests/test_turns.py; of a contact a scene shows it"
    ),
    "what follows through couplings is found only nearby": (
        "another way through the start finds it too in small scenes: tests/test_starts.py"
    ),
    "the first assembly found is taken, however far": (
        "which of two assemblies is nearer follows no law of motion: tests/test_starts.py"
    ),
    "a singular start is not told apart": "words of one message: tests/test_loops.py",
    "the closing tolerance is no setting": (
        "undone, loops close to 1e-9, which is no fault to see: tests/test_loops.py"
    ),
    "functions of time are held over the communication step": (
        "only few plans are run by `simulate`: tests/test_inputs.py"
    ),
    "commanded motion is of order 1 in the communication step": (
        "without derivatives all ways share one course, with them none is guessed: tests/test_commands.py"
    ),
    "bodies jump with what the last step was off": "likewise: tests/test_commands.py",
    "the ground jumps with what its last turn was off": "likewise: tests/test_commands.py",
    "commands that contradict each other are not told": (
        "a plan's commands belong together: tests/test_commands.py"
    ),
    "outputs that are not finite are handed out": (
        "scenes hold no numbers above 1e30; masters set them: tests/test_extremes.py"
    ),
    "a step backwards is taken": "no master here steps back: tests/test_bounded_work.py",
    "masses whose sums overflow are taken": "likewise: tests/test_extremes.py",
    "a gap that is no number is none": "likewise, no number is NaN here: tests/test_extremes.py",
    "setting a parameter to the value it has restarts the solver": (
        "any scene shows it, as a difference between process and FMU: test_random_scenes_stand"
    ),
    "parts without mass that constraints determine are refused": (
        "a slider-crank starts without them: tests/test_massless.py"
    ),
    "a file that is read is written over": "files: tests/test_files.py",
    "a link is replaced instead of what it points to": "files: tests/test_files.py",
    "pipes and devices are replaced by files": "files: tests/test_files.py",
    "a table is written into a file that promises another format": "files: tests/test_files.py",
    "any tolerance is taken, as a parameter": "no plan sets tolerances: tests/test_told.py",
    "names beyond ASCII are unknown in Python": "names in Python alone: tests/test_told.py",
    "a file of another kind is read as TOML": "files: tests/test_told.py",
    "light parts cost constraints their digits": (
        "in absolute coordinates, within what ways may part: tests/test_light_parts.py"
    ),
}


def read(path):
    """(scene, what must come of it) of a file."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    return data, data.pop("referee")


def findings(data, wanted, judge):
    """What is found in a scene, by a `verdicts.judge`, and what does not come of it that must."""
    verdict = judge(data, wanted["seed"], until=wanted["until"])
    found = list(verdict.findings)

    if (verdict.refused is not None) != wanted.get("refused", False):
        found.append(Finding("refused", "reference", text=verdict.refused or "it must not run"))

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
