"""The terminal: what is printed, what is told of errors, what shows that work goes on."""

import os
import sys
from contextlib import contextmanager
from functools import cached_property

from ..hydro.progress import Progress

# width of tables where nobody says how wide the output is: into a file or a pipe, where names are looked for
PIPED = 160


class _Terminal:
    """A console of rich's, which is imported when it is first asked for something."""

    def __init__(self, stderr=False):
        self._stderr = stderr

    @cached_property
    def console(self):
        """The console itself."""
        from rich.console import Console

        stream = sys.stderr if self._stderr else sys.stdout
        wide = None if stream.isatty() or "COLUMNS" in os.environ else PIPED

        # names and titles are free text: nothing in them is markup, an emoji or to be coloured
        return Console(markup=False, highlight=False, emoji=False, stderr=self._stderr, width=wide)

    def __getattr__(self, name):
        return getattr(self.console, name)

    def __enter__(self):
        return self.console.__enter__()

    def __exit__(self, *raised):
        return self.console.__exit__(*raised)


out = _Terminal()
err = _Terminal(stderr=True)


def carry_out(parser, arguments=None) -> int:
    """Parse arguments and call their `run`; what a user can mend is told without a traceback.

    Returns the exit status.
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")

    Progress.shown = staticmethod(doing)
    options = parser.parse_args(arguments)

    try:
        options.run(options)
    except Exception as error:
        if not is_told(error):
            raise

        err.print("error: ", style="bold red", end="")
        err.print(text_of(error), soft_wrap=True)
        return 1
    except KeyboardInterrupt:
        err.print("stopped")
        return 130

    return 0


def is_told(error):
    """Whether an error is a user's to read; others are ours and keep their traceback."""
    from ..scene import SceneError

    if isinstance(error, (SceneError, OSError, ImportError, ValueError, KeyError)):
        return True

    from ..export.aot import CompileError
    from ..export.link import LinkError
    from ..run.instance import SimulationError

    if isinstance(error, (CompileError, LinkError, SimulationError)):
        return True

    from ..cosim import CouplingError

    return isinstance(error, CouplingError)


def text_of(error):
    """What a user reads of an error."""
    if isinstance(error, OSError) and error.filename and error.strerror:
        return f"{error.filename}: {error.strerror}"

    return str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)


def note(notices):
    """Tells notices, beside the results."""
    for notice in notices:
        err.print(f"note: {notice}", soft_wrap=True)


# what a terminal shows now; one thing at a time
_shown: list = []


@contextmanager
def doing(text):
    """Shows what takes time; yields a function to call with what comes next."""
    if not err.is_terminal:
        yield lambda text: err.print(text, soft_wrap=True)
        return

    with doing_here(text) as tell:
        yield tell


@contextmanager
def doing_here(text):
    """Shows on a terminal what takes some time; yields a function to call with what comes next."""
    if not err.is_terminal:
        yield lambda text: None
    elif _shown:
        _shown[-1].update(text)
        yield _shown[-1].update
    else:
        with err.status(text) as status:
            _shown.append(status)

            try:
                yield status.update
            finally:
                _shown.pop()


def compile_first():
    """Makes the library of the kernels if it is not there yet, and shows that."""
    from ..kernels import language
    from ..native import library as native

    if not (language.INTERPRETED or language.JIT or native.find()):
        with doing("looking for compiled kernels") as tell:
            native.ready(tell)


@contextmanager
def time_bar(until):
    """A bar over the simulated time; yields a function to call with the time reached (s)."""
    if not err.is_terminal:
        yield None
        return

    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=None),
        TextColumn("{task.completed:.4g} of {task.total:.4g} s"),
        TimeRemainingColumn(),
    )

    with Progress(*columns, console=err.console, transient=True) as bar:
        task = bar.add_task("simulating", total=until)
        yield lambda time: bar.update(task, completed=time)
