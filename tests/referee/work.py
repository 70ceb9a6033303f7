"""What a process of the referee does with a seed; apart from `__main__`, which other processes cannot read."""

import tomllib
import traceback

from . import coverage, shrink
from .findings import Finding
from .generator import draw
from .interpreter import Interpreter
from .verdicts import Verdict, judge

TRIES = 60  # scenes tried to make a failing one smaller


def one(seed, options, interpreter=None):
    """The verdict on a seed as a dict for JSON;
    where there are findings the scene is made smaller and written."""
    if interpreter is None:
        with Interpreter() as own:
            return one(seed, options, own)

    data = _scene(seed, options)
    verdict = _verdict(data, seed, options, interpreter)
    line = {
        "seed": seed, "focus": options.focus, "seconds": round(verdict.seconds, 2),
        "refused": verdict.refused, "findings": [str(finding) for finding in verdict.findings],
        "made": verdict.count.made, "loose": verdict.count.loose,
        "other": verdict.count.other, "keys": sorted(coverage.keys_of(data)),
    }  # fmt: skip

    if verdict.findings:
        line["file"] = str(_write(data, seed, verdict.findings, options, interpreter))

    return line


def _verdict(data, seed, options, interpreter) -> Verdict:
    try:
        return judge(
            data, seed, None if options.no_interpreted else interpreter, not options.no_fmu, options.ways
        )
    except Exception:
        return Verdict(seed, findings=[Finding("crashed", "judging", text=traceback.format_exc())])


def _scene(seed, options):
    if options.scene:
        return tomllib.loads(options.scene.read_text(encoding="utf-8"))

    return draw(seed, options.size, options.focus)


def _write(data, seed, findings, options, interpreter):
    """The failing scene as a file, made smaller as long as the first verdict that fails still does."""
    kind = findings[0].verdict

    def fails(smaller):
        return any(
            finding.verdict == kind for finding in _verdict(smaller, seed, options, interpreter).findings
        )

    smallest = data if options.no_shrink else shrink.shrink(data, fails, TRIES)
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / f"{seed}_{kind.replace(' ', '_')}.toml"
    text = "".join(f"# {line}\n" for finding in findings[:5] for line in str(finding).splitlines())
    path.write_text(text + shrink.toml(smallest), encoding="utf-8")
    return path
