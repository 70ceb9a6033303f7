"""Which quick tests reach which lines of the package:
measured once for each test file and kept in the user's cache.

Also a plugin of pytest: it times every test, stops those that take longer than a limit, and,
while lines are measured, writes down the lines that each test runs.
"""

import hashlib
import inspect
import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from difflib import SequenceMatcher
from functools import cache
from pathlib import Path

import coverage
import pytest
from hypothesis import Phase, settings

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "mbdfmi"
PARTS = ("kernels", "compiler", "scene")
"""Parts of the package in which mutants live."""

QUICK = 2.0
"""s of the processor, with every line watched, that a quick test takes at most."""

SETS = 5
"""Sets of parameters of one test, and random examples of one, that are run."""

APART = (
    "fmu", "export", "cosim", "same_bytes", "speed_against", "long_run", "cli", "benchmarks",
    "evaluation_cost", "docs",
)  # fmt: skip
"""In names of test files that need a compiled library, other packages, or an idle machine."""


def test_files():
    """Test files with quick tests."""
    found = sorted((ROOT / "tests").glob("test_*.py"))
    return [path for path in found if not any(word in path.name for word in APART)]


def environment(root, **more):
    """Environment of a process that runs the tests of the copy at `root` on interpreted kernels."""
    return (
        os.environ
        | {"MBDFMI_INTERPRETED": "1", "PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"}
        | more
    )


def cache_folder():
    """Folder of the user's cache, in $XDG_CACHE_HOME or ~/.cache."""
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "mbdfmi-mutants"


def sources() -> dict[str, str]:
    """Text by file, relative to the package, of the parts in which mutants live."""
    paths = sorted(path for part in PARTS for path in (PACKAGE / part).rglob("*.py"))
    return {path.relative_to(PACKAGE).as_posix(): path.read_text(encoding="utf-8") for path in paths}


def _hash(text):
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def measured(test_file, anew=False):
    """({test: {"time": s, "passed": bool, "lines": {file: [lines]}}} of a test file, the sources that it was
    measured on).

    From the cache, be it of other sources than those now, or measured now.
    """
    relative = test_file.relative_to(ROOT).as_posix()
    name = f"{test_file.stem}-{_hash(test_file.read_text(encoding='utf-8'))}.json"
    here = cache_folder() / _hash(json.dumps(sources()))
    known = sorted(cache_folder().glob(f"*/{name}"), key=lambda path: path.stat().st_mtime)
    kept = known[-1] if known and not anew else here / name

    if anew or not known:
        here.mkdir(parents=True, exist_ok=True)
        (here / "sources.json").write_text(json.dumps(sources()))
        part = kept.with_suffix(f".{os.getpid()}-{test_file.stem}")
        plugins = ["-p", "no:cacheprovider", "-p", "tests.mutants.reach"]
        command = [sys.executable, "-m", "pytest", "-q", "--tb=no", *plugins, relative]
        variables = environment(ROOT, MUTANTS_RESULTS=str(part))
        subprocess.run(command, cwd=ROOT, env=variables, stdout=subprocess.DEVNULL, check=False)
        part.rename(kept)

    return json.loads(kept.read_text()), _sources_at(kept.parent)


@cache
def _sources_at(folder):
    return json.loads((folder / "sources.json").read_text())


@cache
def _moved(before, after):
    """{line: line} of those that two texts share."""
    blocks = SequenceMatcher(
        None, before.split("\n"), after.split("\n"), autojunk=False
    ).get_matching_blocks()
    return {i + k + 1: j + k + 1 for i, j, size in blocks for k in range(size)}


def tests_by_line(jobs=1, progress=lambda name: None):
    """({(file, line): [tests]}, {test: s}) of all quick tests that pass; `progress(file)` as each is known;
    files relative to the package's root; `jobs` files are measured side by side."""
    reaching, times = {}, {}
    now = sources()

    with ThreadPoolExecutor(jobs) as pool:
        measuring = {pool.submit(measured, path): path.name for path in test_files()}

        for done in as_completed(measuring):
            progress(measuring[done])

    for done in measuring:
        results, before = done.result()

        for test, found in results.items():
            if found["passed"]:
                times[test] = found["time"]

                for file, lines in found["lines"].items():
                    moved = _moved(before[file], now.get(file, "")) if before[file] != now.get(file) else None

                    for line in lines if moved is None else (moved[line] for line in lines if line in moved):
                        reaching.setdefault((file, line), []).append(test)

    return reaching, times


class TooSlow(BaseException):
    """A test took longer than its limit."""


class Watch:
    """The plugin. chosen : {test: s that it may take}, run in this order; without it, a few of each test are
    run and the lines that they reach are watched. results : file for what came of each test.
    """

    def __init__(self, results, chosen=None):
        self.file = results
        self.chosen = chosen
        self.results = {}
        self.slow = set()

        if not chosen:
            self.lines = coverage.Coverage(
                data_file=None, include=[str(PACKAGE / part / "*") for part in PARTS]
            )
            self.lines.start()

    def pytest_collection_modifyitems(self, items):
        """The tests chosen, or a few sets of parameters of each, evenly spread; and a few random examples."""
        by_name, alike = {item.nodeid: item for item in items}, {}

        for item in items:
            if any(word in inspect.getsource(item.function).lower() for word in ("fmu", "export(", "capsys")):
                continue

            alike.setdefault(item.nodeid.partition("[")[0], []).append(item)

        if self.chosen:
            items[:] = [by_name[test] for test in self.chosen if test in by_name]
        else:
            few = lambda found: (
                [found[k * (len(found) - 1) // (SETS - 1)] for k in range(SETS)]
                if len(found) > SETS
                else found
            )
            items[:] = [item for found in alike.values() for item in few(found)]

        for item in items:
            if used := getattr(item.obj, "_hypothesis_internal_use_settings", None):
                number = min(SETS, used.max_examples)
                phases = (Phase.explicit, Phase.generate)
                item.obj._hypothesis_internal_use_settings = settings(
                    used, max_examples=number, phases=phases
                )

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        if not self.chosen:
            self.lines.switch_context(item.nodeid)

        begin = time.process_time()
        self.results[item.nodeid] = {"passed": True, "failed": False}
        result = yield
        self.results[item.nodeid]["time"] = time.process_time() - begin
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item):
        function = item.nodeid.partition("[")[0]

        if function in self.slow and not self.chosen:
            pytest.skip("another set of parameters is too slow")

        signal.signal(signal.SIGPROF, self.stop)
        signal.setitimer(signal.ITIMER_PROF, self.chosen[item.nodeid] if self.chosen else QUICK)

        try:
            return (yield)
        except TooSlow:
            self.slow.add(function)
            self.results[item.nodeid]["slow"] = True
            raise
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)

    def stop(self, _, frame):
        # not while a lock is held that somebody waits for later
        if any(part in frame.f_code.co_filename for part in ("coverage", "threading", "logging")):
            signal.setitimer(signal.ITIMER_PROF, 0.01)
        else:
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
    """Watch all lines, where the environment says so."""
    if results := os.environ.get("MUTANTS_RESULTS"):
        config.pluginmanager.register(Watch(results))
