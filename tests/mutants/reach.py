"""Which quick tests reach which lines of the package: measured once for each test file and kept in the user's cache.

Also a plugin of pytest: it times every test, stops those that take longer than a limit, and, while lines are measured,
writes down the lines that each test runs.
"""

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from functools import cache
from pathlib import Path

import coverage
import pytest
from hypothesis import Phase, settings

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "mbdfmi"
PARTS = ("kernels", "compiler", "scene")
"""Parts of the package in which mutants live."""

QUICK = 3.0
"""s, with every line watched, that a quick test takes at most."""

SETS = 5
"""Sets of parameters of one test, and random examples of one, that are run."""

APART = ("fmu", "export", "cosim", "same_bytes", "speed_against", "long_run", "cli", "benchmarks", "evaluation_cost", "docs")
"""In names of test files that need a compiled library, other packages, or an idle machine."""


def test_files():
    """Test files with quick tests."""
    found = sorted((ROOT / "tests").glob("test_*.py"))
    return [path for path in found if not any(word in path.name for word in APART)]


def environment(root, **more):
    """Environment of a process that runs the tests of the copy at `root` on interpreted kernels."""
    return os.environ | {"MBDFMI_INTERPRETED": "1", "PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"} | more


def cache_folder():
    """Folder of the user's cache, in $XDG_CACHE_HOME or ~/.cache."""
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "mbdfmi-mutants"


@cache
def package_hash():
    """Hash (hex) of the parts in which mutants live, for which lines were measured."""
    digest = hashlib.sha256()

    for path in sorted(path for part in PARTS for path in (PACKAGE / part).glob("*.py")):
        digest.update(path.name.encode() + path.read_bytes())

    return digest.hexdigest()[:16]


def measured(test_file):
    """{test: {"time": s, "passed": bool, "lines": {file: [lines]}}} of one test file, from the cache or measured now."""
    relative = test_file.relative_to(ROOT).as_posix()
    name = hashlib.sha256(relative.encode() + test_file.read_bytes()).hexdigest()[:16]
    kept = cache_folder() / package_hash() / f"{test_file.stem}-{name}.json"

    if not kept.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(f".{os.getpid()}")
        command = [sys.executable, "-m", "pytest", "-q", "--tb=no", "-p", "no:cacheprovider", "-p", "tests.mutants.reach", relative]
        variables = environment(ROOT, MUTANTS_RESULTS=str(part))
        subprocess.run(command, cwd=ROOT, env=variables, stdout=subprocess.DEVNULL, check=False)
        part.rename(kept)

    return json.loads(kept.read_text())


def tests_by_line(progress=None):
    """({(file, line): [tests]}, {test: s}) of all quick tests that pass; files relative to the package's root."""
    reaching, times = {}, {}

    for test_file in test_files():
        if progress:
            progress(test_file.name)

        for test, found in measured(test_file).items():
            if found["passed"]:
                times[test] = found["time"]

                for file, lines in found["lines"].items():
                    for line in lines:
                        reaching.setdefault((file, line), []).append(test)

    return reaching, times


class TooSlow(BaseException):
    """A test took longer than its limit."""


class Watch:
    """The plugin. chosen : {test: s that it may take}, run in this order; without it, a few of each test are run and the lines
    that they reach are watched. results : file for what came of each test.
    """

    def __init__(self, results, chosen=None):
        self.file = results
        self.chosen = chosen
        self.results = {}
        self.slow = set()

        if not chosen:
            self.lines = coverage.Coverage(data_file=None, include=[str(PACKAGE / part / "*") for part in PARTS])
            self.lines.start()

    def pytest_collection_modifyitems(self, items):
        """The tests chosen, or a few sets of parameters of each, evenly spread; and a few random examples."""
        by_name, alike = {item.nodeid: item for item in items}, {}

        for item in items:
            alike.setdefault(item.nodeid.partition("[")[0], []).append(item)

        if self.chosen:
            items[:] = [by_name[test] for test in self.chosen if test in by_name]
        else:
            few = lambda found: [found[k * (len(found) - 1) // (SETS - 1)] for k in range(SETS)] if len(found) > SETS else found
            items[:] = [item for found in alike.values() for item in few(found)]

        for item in items:
            if used := getattr(item.obj, "_hypothesis_internal_use_settings", None):
                number = min(SETS, used.max_examples)
                phases = (Phase.explicit, Phase.generate)
                item.obj._hypothesis_internal_use_settings = settings(used, max_examples=number, phases=phases)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        if not self.chosen:
            self.lines.switch_context(item.nodeid)

        begin = time.perf_counter()
        self.results[item.nodeid] = {"passed": True, "failed": False}
        result = yield
        self.results[item.nodeid]["time"] = time.perf_counter() - begin
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item):
        function = item.nodeid.partition("[")[0]

        if function in self.slow and not self.chosen:
            pytest.skip("another set of parameters is too slow")

        signal.signal(signal.SIGALRM, self.stop)
        signal.setitimer(signal.ITIMER_REAL, self.chosen[item.nodeid] if self.chosen else QUICK)

        try:
            return (yield)
        except TooSlow:
            self.slow.add(function)
            self.results[item.nodeid]["slow"] = True
            raise
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)

    def stop(self, *_):
        raise TooSlow

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        report = yield
        result = self.results[item.nodeid]
        result["passed"] &= report.passed
        result["failed"] |= report.failed
        return report

    def pytest_sessionfinish(self):
        if not self.chosen:
            self.add_lines()

        Path(self.file).write_text(json.dumps(self.results))

    def add_lines(self):
        """Lines by file to each result."""
        self.lines.stop()
        data = self.lines.get_data()

        for result in self.results.values():
            result["lines"] = {}

        for file in data.measured_files():
            relative = Path(file).relative_to(PACKAGE).as_posix()

            for line, tests in data.contexts_by_lineno(file).items():
                for test in set(tests) & self.results.keys():
                    self.results[test]["lines"].setdefault(relative, []).append(line)


def pytest_configure(config):
    """Register the watch that the environment asks for."""
    if results := os.environ.get("MUTANTS_RESULTS"):
        chosen = os.environ.get("MUTANTS_CHOSEN")
        config.pluginmanager.register(Watch(results, json.loads(Path(chosen).read_text()) if chosen else None))
