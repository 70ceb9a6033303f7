"""Runs the tests that reach a mutant against it, in a private copy of the package,
until one of them fails."""

import importlib
import json
import multiprocessing
import os
import shutil
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from . import reach
from .operators import Mutant
from .reach import PACKAGE, ROOT, environment

# what tests import takes longer than they do: it is there already in the processes that are forked for them
for module in ("numba.core", "scipy.integrate", "scipy.interpolate", "scipy.optimize",
               "scipy.spatial.transform", "pydantic", "hypothesis.strategies", "lxml.etree", "fmpy", "mpmath",
               "rich.progress", "llvmlite.binding"):  # fmt: skip
    importlib.import_module(module)

FORK = multiprocessing.get_context("fork")

BATCHES = (3.0, 40.0)
"""s of tests (timed with every line watched) in each run of pytest: a short one,
and one for what passes that."""

LONGEST, THOROUGHLY = 600.0, 180.0
"""s that the referee, or the tests of an undone mending, may take;
and whole files of tests against a mutant."""

THOROUGH = {
    "assembly given holding notes redundancy start_positions start_velocities start": "starts loops loops_not_exact",
    "commands courses doubts drives extrapolation inputs": "commands commanded_loops drivers turns",
    "massless virtual forward": "massless light_parts",
    "articulated constraints embedding multipliers rows": "loops massless",
    "jacobian linear": "jacobian",
    "exchange notes": "tables starts",
    "inverse reactions": "outputs reactions powers",
    "hydrostatics": "hydrostatics",
    "free kinds one_axis passing spherical told": "kernels_dynamics scene_mechanisms inverse_joints",
    "friction joint_springs loads six_by_six stops struts": "forces powers",
    "added_mass": "added_mass",
    "gravity_gradient": "gravity_gradient",
    "rotations": "rotations",
    "catenaries": "catenaries",
    "composite_lines composite_pulls composite_shapes line_ends line_pieces": "composite_lines",
    "radiation waves states": "hydrodynamics sea wave_loads",
    "solutions": "traced_sea",
    "resistance": "wave_loads",
    "natural": "natural_damping",
    "coordinates": "loops torsion couplings",
    "inertia kinematics markers output_values outputs": "outputs powers",
    "members": "members",
    "wind_rotors": "wind_rotors gusts",
    "rotors": "rotors",
    "ellipses": "elliptic_orbit",
    "prepare": "forces extremes rotors",
    "convex curves frames on_surfaces surfaces touching":
        "contacts end_frame_motions touching_surfaces end_frame_axes",
    "choice control early estimates fixed gauss integrate memory noise pairs radau rk4 rkc ros2 tableaux": "steppers integrate between_steps",
    "interpolation tables elastic": "tables drivers",
    "projection": "starts",
    "checks bodies orientation fields motion efforts forces solids tables":
        "scene scene_messages told starts tables",
    "notices light_parts": "told notices light_parts",
    "builder joints absolute": "structure starts inverse_joints",
}  # fmt: skip
"""Tests (tests/test_...) that are run whole where the quick ones notice nothing,
by names of the files of mutants."""

CAUGHT, BY_TIME, SURVIVED, UNREACHED = "caught", "caught by time", "survived", "reached by no quick test"
UNFINISHED = "not noticed in the time that whole files of tests have"


@dataclass(frozen=True)
class Verdict:
    """What came of a mutant: one of the outcomes above, the test that failed, and s that it took."""

    outcome: str
    by: str = ""
    seconds: float = 0.0


class Copy:
    """A copy of package and tests in a temporary folder, where one line at a time is broken."""

    def __enter__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="mutants-")
        self.root = Path(self._folder.name)
        skip = shutil.ignore_patterns("__pycache__", ".*")
        shutil.copytree(PACKAGE, self.root / "mbdfmi", ignore=skip)
        shutil.copytree(ROOT / "tests", self.root / "tests", ignore=skip)

        for name in (
            "benchmarks",
            "models",
            "docs",
            "fmu_src",
            "pyproject.toml",
            "README.md",
            "build_fmu.py",
        ):
            (self.root / name).symlink_to(ROOT / name)

        return self

    def __exit__(self, *_):
        self._folder.cleanup()

    def write(self, file, text):
        """Text of a file of the package."""
        (self.root / "mbdfmi" / file).write_text(text, encoding="utf-8")

    def first_failure(self, tests: list[str], times: dict[str, float]) -> Verdict | None:
        """The first of `tests` that fails, run in this order; a test gets several times what it took once."""
        chosen = self.root / "chosen.json"
        chosen.write_text(json.dumps({test: 5.0 + 5.0 * times[test] for test in tests}))
        files = sorted({test.partition("::")[0] for test in tests})
        return self.failure_of(
            files, 60.0 + 6.0 * sum(times[test] for test in tests), MUTANTS_CHOSEN=str(chosen)
        )

    def fails_unbroken(self, tests: set[str], times: dict[str, float]) -> Verdict | None:
        """The first of these tests that fails on the package as it is;
        of those without a time in as long as a whole file."""
        quick = sorted(tests & times.keys())
        others = sorted(test for test in tests - times.keys() if "::" in test)
        wrong = self.first_failure(quick, times) if quick else None
        return wrong or (self.failure_of(others, LONGEST) if others else None)

    def failure_of(self, files: list[str], limit: float, **variables) -> Verdict | None:
        """What fails first of files of tests, or of those that the plugin chooses, within so many s."""
        results = self.root / "results.json"
        results.unlink(missing_ok=True)
        variables = environment(self.root, MUTANTS_RESULTS=str(results), **variables)
        run = FORK.Process(target=_pytest, args=(self.root, variables, files))
        begin = time.perf_counter()
        run.start()
        run.join(limit)
        seconds = time.perf_counter() - begin

        if run.is_alive():
            run.kill()
            run.join()
            # only tests that were timed before are known to end sooner
            return Verdict(BY_TIME if "MUTANTS_CHOSEN" in variables else UNFINISHED, "the whole run", seconds)

        if run.exitcode == 0:
            return None

        ran = json.loads(results.read_text()) if results.exists() else {}

        for test, result in ran.items():
            if result["failed"]:
                return Verdict(BY_TIME if result.get("slow") else CAUGHT, test, seconds)

        return Verdict(CAUGHT, "importing package and tests", seconds)


class _Failures:
    """A plugin of pytest that writes what failed to a file, as `reach.Watch` does."""

    def __init__(self, file):
        self.file = file

    def pytest_runtest_logreport(self, report):
        if report.failed:
            Path(self.file).write_text(json.dumps({report.nodeid: {"failed": True}}))


def _pytest(root, variables, files):
    """In a process of its own: pytest at the root of a copy, silent."""
    os.chdir(root)
    os.environ.update(variables)
    sys.path.insert(0, str(root))
    sys.dont_write_bytecode = True
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    chosen, results = variables.get("MUTANTS_CHOSEN"), variables["MUTANTS_RESULTS"]
    watch = reach.Watch(results, json.loads(Path(chosen).read_text())) if chosen else _Failures(results)
    os._exit(pytest.main(["-q", "-x", "--tb=no", "-p", "no:cacheprovider", *files], [watch]))


def reaching(mutant: Mutant, by_line: dict, times: dict[str, float]) -> list[str]:
    """Tests that reach a mutant, the quickest first."""
    first, last = mutant.reached_by
    lines = range(first, last + 1) if last else (line for file, line in by_line if file == mutant.file)
    found = {test for line in lines for test in by_line.get((mutant.file, line), ()) if test in times}
    return sorted(found, key=times.get)


def judge_undone(undone, copy: Copy, referee: bool, by_line: dict, times: dict[str, float]) -> Verdict:
    """What comes of an undone mending: by the referee, or by the tests that it names,
    the quick ones first."""
    mutant = undone.mutant()
    files = undone.tests.split()
    some = [test for test in reaching(mutant, by_line, times) if test.partition("::")[0] in files]

    if referee:
        files = ["tests/referee"]
    elif some and (verdict := hunt(mutant, copy, by_line, {test: times[test] for test in some}, False)).by:
        return verdict

    begin = time.perf_counter()
    copy.write(mutant.file, mutant.mutated())

    try:
        found = copy.failure_of(files, LONGEST)
    finally:
        copy.write(mutant.file, mutant.source)

    return found or Verdict(SURVIVED, "", time.perf_counter() - begin)


def thorough_tests(mutant: Mutant) -> list[str]:
    """Files of tests, or single ones, that are run whole against a mutant."""
    subject = Path(mutant.file).stem
    named = " ".join(names for files, names in THOROUGH.items() if subject in files.split())
    parts = [name.partition("::") for name in dict.fromkeys(named.split())]
    return [f"tests/test_{file}.py{colons}{test}" for file, colons, test in parts]


def hunt(mutant: Mutant, copy: Copy, by_line: dict, times: dict[str, float], thorough=True) -> Verdict:
    """What comes of one mutant; `thorough`: by whole files of tests of its subject, too."""
    tests = reaching(mutant, by_line, times)
    reached = bool(tests)
    begin = time.perf_counter()
    copy.write(mutant.file, mutant.mutated())

    try:
        for budget in BATCHES:
            batch = []

            while tests and (not batch or sum(times[test] for test in batch) + times[tests[0]] <= budget):
                batch.append(tests.pop(0))

            if batch and (found := copy.first_failure(batch, times)):
                return found

        named = thorough_tests(mutant) if thorough else []

        if named and (found := copy.failure_of(named, THOROUGHLY)):
            return found
    finally:
        copy.write(mutant.file, mutant.source)

    return Verdict(SURVIVED if reached else UNREACHED, "", time.perf_counter() - begin)
