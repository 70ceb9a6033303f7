"""Questions to an FMU of any maker that no static validator asks, each in a process of its own.

What an FMU and its runs are is in `fmu` and, for model exchange, `exchange`; the questions are in `questions`
and `exchange_questions`, the processes here.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from .answers import FAULT, Answer

LIMIT = 30.0
"""s, that a question may take."""


def probe(
    path: str | os.PathLike, limit: float = LIMIT, progress: Callable[[str], None] = lambda text: None
) -> Iterator[Answer]:
    """The answers of an FMU (a file), one by one as they come, for each kind that it is.

    progress : is told what is asked. A question that brings its process down, or takes longer than `limit`
    (s), is answered by that.
    """
    import fmpy

    from .kinds import KINDS

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        fmpy.extract(str(path), folder)
        description = fmpy.read_model_description(folder, validate=False)

        asked = [
            (kind, name, words_of(question))
            for kind, (_, questions) in KINDS.items()
            if getattr(description, kind[0].lower() + kind[1:]) is not None
            for name, question in questions.items()
        ]

        for n, (kind, name, words) in enumerate(asked, 1):
            progress(f"{n} of {len(asked)}: {words}")
            verdict, seen = _ask(folder, kind, name, limit)
            yield Answer(words, verdict, seen, kind)


def words_of(question: Callable) -> str:
    """What a question asks."""
    return (question.__doc__ or "").splitlines()[0].rstrip(".")


def _ask(folder, kind, name, limit):
    """(verdict, what was seen) of a question, from a process of its own."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as own:
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        environment |= dict.fromkeys(("TMPDIR", "TEMP", "TMP"), own)
        answer = Path(own) / "answer.json"
        command = [sys.executable, "-m", __name__, folder, kind, name, str(answer)]

        done = subprocess.Popen(
            command,
            env=environment,
            cwd=own,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        )

        try:
            told, _ = done.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            _end(done)
            return FAULT, f"no answer within {limit:g} s"

        if answer.is_file():
            verdict, seen = json.loads(answer.read_text())
            return verdict, seen

        if done.returncode < 0:
            return FAULT, f"brings its process down ({signal.Signals(-done.returncode).name})"

        said = [line for line in told.splitlines() if line.strip()]
        return FAULT, said[-1] if said else f"its process ends with {done.returncode}"


def _end(process):
    """Ends a process, and those that it started."""
    if os.name == "posix":
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()

    process.communicate()
