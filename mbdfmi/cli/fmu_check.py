"""An FMU of any maker: validated, and run for a few steps."""

import os
import subprocess
import sys
import tempfile

from .tables import count, print_table, table_of
from .terminal import doing, doing_here, note, out, text_of

# runs ten steps of an FMU
_TRIAL = """
import sys, fmpy
experiment = fmpy.read_model_description(sys.argv[1]).defaultExperiment
start = float(getattr(experiment, "startTime", None) or 0)
step = float(getattr(experiment, "stepSize", None) or 0.01)
fmpy.simulate_fmu(sys.argv[1], start_time=start, stop_time=start + 10 * step, output_interval=step)
"""


KINDS = {"CoSimulation": "in co-simulation", "ModelExchange": "in model exchange"}
"""Of FMUs, in words."""


def probe_fmu(path, limit=None):
    """Asks an FMU what no validator sees, and prints each answer as it comes.

    limit : s, for each question. Raises ValueError with the number of faults, those of validation among them.
    """
    import fmpy

    from ..probe import FAULT, LIMIT

    faults = []

    try:
        notes = check_fmu(path)
    except ValueError as error:
        if not _is_readable(path):
            raise
        notes, faults = "", str(error).splitlines()
        note(faults)

    if notes:
        raise ValueError(f"{path}: it holds no library for {fmpy.platform}, nothing can be asked")

    kind = None

    for answer in _answers(path, limit or LIMIT):
        _print_answer(answer, begins=answer.kind != kind)
        kind = answer.kind
        faults += [answer.question] if answer.verdict == FAULT else []

    if faults:
        raise ValueError(f"{path}: {count(len(faults), 'fault')} found")

    return ""


def _answers(path, limit):
    """The answers one by one; what is asked shows meanwhile, and is gone while an answer is printed."""
    from ..probe import probe

    tell = [lambda text: None]
    answers = probe(path, limit, lambda text: tell[0](text))

    while True:
        with doing_here(f"{path}: asking") as tell[0]:
            answer = next(answers, None)

        if answer is None:
            return

        yield answer


def _print_answer(answer, begins):
    """A row of the table of a kind of FMU, its heading first where it `begins`; as wide as all others."""
    from rich.text import Text

    from ..probe import FAULT, words_of
    from ..probe.kinds import KINDS as ASKED

    table = table_of("answer", KINDS[answer.kind], "seen")
    table.expand, table.show_header = True, begins
    longest = max(
        len(words_of(question)) for _, questions in ASKED.values() for question in questions.values()
    )
    table.columns[0].width = len("answer")
    table.columns[1].width = min(longest, (out.width - len("answer")) * 2 // 3)
    table.columns[2].ratio = 1
    style = {FAULT: "bold red", "good": "green"}.get(answer.verdict, "")
    table.add_row(Text(answer.verdict, style), answer.question, answer.seen)
    (print_table if begins else out.print)(table)


def _is_readable(path):
    """Whether there is an FMU of FMI 2 or 3 that can be run, valid or not."""
    import fmpy

    try:
        description = fmpy.read_model_description(str(path), validate=False)
        return description.fmiVersion[0] in "23" and fmpy.platform in fmpy.supported_platforms(str(path))
    except Exception:  # fmpy has no class of its own for what it finds
        return False


def check_fmu(path):
    """Raises ValueError with all that fmpy's validation finds, or with why a first run fails.

    Returns what there is to add when nothing was found.
    """
    import zipfile
    import zlib

    import fmpy
    from fmpy.validation import validate_fmu

    if not path.is_file():
        raise ValueError(f"{path}: there is no such file")

    try:
        with zipfile.ZipFile(path) as archive:
            damaged = archive.testzip()

        if damaged:
            raise ValueError(f"{path}: damaged, {damaged} in it cannot be read")
    except (zipfile.BadZipFile, zlib.error, EOFError) as error:
        raise ValueError(f"{path}: not an FMU, or damaged: an FMU is a zip archive ({error})") from error

    try:
        problems = validate_fmu(str(path))
    except Exception as error:  # fmpy has no class of its own for what it finds
        raise ValueError(f"{path}: its description cannot be read: {text_of(error)}") from error

    if problems:
        raise ValueError("\n".join(f"{path}: {problem}" for problem in problems))

    if fmpy.platform not in fmpy.supported_platforms(str(path)):
        return f" (not run: it holds no library for {fmpy.platform})"

    # in a process of its own, with a folder of its own: a bad library may bring its process down
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder, doing(f"{path}: a first run"):
        environment = os.environ | dict.fromkeys(("TMPDIR", "TEMP", "TMP"), folder)
        command = [sys.executable, "-c", _TRIAL, str(path)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, errors="replace")

    if done.returncode:
        said = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        reason = "it brings its process down" if done.returncode < 0 or not said else said[-1]
        raise ValueError(f"{path}: valid by its description, but a first run fails: {reason}")

    return ""
