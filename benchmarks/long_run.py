"""Long runs: what each stepper does to energy, momentum and phase over 1e5 periods, at modest steps.

Errors of order p that a stepper makes in one direction add up to a drift that grows with time, and in the
phase with its square; a symmetric stepper of fixed step leaves energy within bounds. The loop over
communication points is compiled.
"""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Group
from rich.table import Column, Table

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.files import replacing
from mbdfmi.kernels import loops
from mbdfmi.kernels.status import OK
from mbdfmi.run.instance import Instance, explain

from .machine import machine
from .markdown import table as markdown_table
from .orbits import ORBITS, Orbit

PERIODS = 100_000
QUICK_PERIODS = 100

# communication steps in a period
POINTS = 8

INTRODUCTION = """# The long run

{machine}.

Written by `python -m benchmarks --long-run`. Largest relative change of what ought to be constant, and error of the state by its
size (2 is as wrong as can be), in {points} communication steps a period; behind them, in brackets, the exponent of their
growth with time."""

# periods at which figures are taken, in a decade
SAMPLES = 6

# by name: the integrator, and its tolerance or its step as part of a radian of the fastest rotation
STEPPERS = {
    "rk4": ("rk4", {"step": 0.1}),
    "rk54": ("rk54", {"tolerance": 1e-8}),
    "rk853": ("rk853", {"tolerance": 1e-8}),
    "rk853 fine": ("rk853", {"tolerance": 1e-11}),
    "radau": ("radau", {"tolerance": 1e-8}),
    "auto": ("auto", {"tolerance": 1e-8}),
    "gauss": ("gauss", {"step": 0.2}),
    "ros2": ("ros2", {"step": 0.05}),
}


@dataclass(frozen=True)
class LongRunReport:
    """What was found.

    rows : one for each orbit and stepper: `orbit`, `title`, `stepper`, `integrator`, `settings`; `periods`
    (n,) at which figures were taken; `drift`: name of a constant -> (n,) its largest change since the one
    before, by its size; `error` (n,) of the state at the end of these periods, by its size; `growth`: name of
    a constant, or "state" -> exponent of the growth with time over the last decades; `seconds` of CPU,
    `steps`, `evaluations`; and `stopped`, why it stopped early, or None.
    """

    rows: list[dict]

    def as_dict(self) -> dict:
        """All figures, for JSON."""
        return {"rows": self.rows}

    def save(self, folder: Path) -> list[Path]:
        """Writes long_run.json, long_run.md and, where matplotlib is, long_run.png into a folder; returns the
        paths.
        """
        try:
            figure = self.figure()
        except ImportError:
            figure = None

        texts = {
            "long_run.json": json.dumps(self.as_dict(), indent=1) + "\n",
            "long_run.md": self._page(bool(figure)),
        }
        written = [Path(folder) / name for name in texts]

        for place, text in zip(written, texts.values()):
            with replacing(place) as path:
                path.write_text(text, encoding="utf-8")

        if figure:
            written.append(Path(folder) / "long_run.png")

            with replacing(written[-1]) as path:
                figure.savefig(path, format="png", dpi=110)

        return written

    def _page(self, pictured):
        """The tables as a page of Markdown."""
        parts = [INTRODUCTION.format(machine=", ".join(machine().values()), points=POINTS)]
        parts += ["![Drift against time](long_run.png)"] if pictured else []

        for orbit in self._orbits():
            title, headings, rows = self._lines(orbit)
            parts += [f"## {title}", markdown_table(headings, rows)]

        parts += [f"- {note}" for note in self._notes()]
        return "\n\n".join(parts) + "\n"

    def _orbits(self):
        """Names, in order."""
        return list(dict.fromkeys(row["orbit"] for row in self.rows))

    def _notes(self):
        """What stopped early."""
        return [f"{row['stepper']}, {row['orbit']}: {row['stopped']}" for row in self.rows if row["stopped"]]

    def figure(self):
        """Drift against time, log-log: an orbit a row; energy, momentum, state. Raises ImportError."""
        from matplotlib import colormaps
        from matplotlib.figure import Figure

        orbits = self._orbits()
        steppers = list(dict.fromkeys(row["stepper"] for row in self.rows))
        colour = {name: colormaps["tab10"](k) for k, name in enumerate(steppers)}
        figure = Figure(figsize=(13, 3.6 * len(orbits)), layout="constrained")
        axes = figure.subplots(len(orbits), 3, sharex=True, squeeze=False)

        for line, orbit in zip(axes, orbits):
            for row in (row for row in self.rows if row["orbit"] == orbit):
                curves = [row["drift"]["energy"], row["drift"]["angular momentum"], row["error"]]

                for ax, values in zip(line, curves):
                    # rounding may leave nothing at all
                    shown = np.maximum(values, 1e-17)
                    ax.loglog(row["periods"], shown, label=row["stepper"], color=colour[row["stepper"]])

            for ax, what in zip(line, ("energy", "angular momentum", "state")):
                ax.set_title(f"{orbit}: {what}", fontsize=10)
                ax.grid(alpha=0.3)

            line[0].set_ylabel("relative change or error")

        for ax in axes[-1]:
            ax.set_xlabel("periods")

        figure.legend(
            *axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=len(steppers)
        )
        return figure

    def __rich__(self):
        tables = [self._table(orbit) for orbit in self._orbits()]
        return Group(*tables, *(f"* {note}" for note in self._notes()))

    def _lines(self, orbit):
        """(title, headings, rows) of an orbit's table."""
        rows = [row for row in self.rows if row["orbit"] == orbit]
        constants = list(rows[0]["drift"])
        periods = max((row["periods"][-1] for row in rows if row["periods"]), default=0)
        title = f"{rows[0]['title']}: largest change in {periods:,} periods (exponent of its growth)"
        headings = ["stepper", *constants, "state", "steps a period", "µs a period"]
        return title, headings, [_cells(row, constants) for row in rows]

    def _table(self, orbit):
        title, (first, *others), rows = self._lines(orbit)
        table = Table(first, *(Column(heading, justify="right") for heading in others), title=title)

        for row in rows:
            table.add_row(*row)

        return table


def _cells(row, constants):
    """One line of a table, with a mark where the run stopped early."""
    name = row["stepper"] + (" *" if row["stopped"] else "")

    if not row["periods"]:
        return [name, *["-"] * (len(constants) + 3)]

    n = row["periods"][-1]
    drifts = [(max(row["drift"][name]), row["growth"].get(name)) for name in constants]
    drifts.append((max(row["error"]), row["growth"].get("state")))
    cells = [f"{drift:.1e}" + ("" if growth is None else f" ({growth:.1f})") for drift, growth in drifts]
    return [name, *cells, f"{row['steps'] / n:.0f}", f"{1e6 * row['seconds'] / n:.0f}"]


def run_long(
    periods: int = PERIODS,
    progress: Callable[[float, str], None] | None = None,
    steppers: list[str] | None = None,
) -> LongRunReport:
    """Runs each orbit with each stepper that this version has.

    periods : how many.  steppers : names of STEPPERS, or None for all.
    progress : called with the fraction done and what comes next.
    """
    progress = progress or (lambda fraction, text: None)
    names = list(steppers or STEPPERS)
    runs = [(orbit(), name) for orbit in ORBITS for name in names]
    rows = []

    for k, (orbit, name) in enumerate(runs):

        def tell(part, done=k, text=f"{orbit.name}, {name}"):
            progress((done + part) / len(runs), text)

        rows.append(_run(orbit, name, periods, tell))

    progress(1.0, "done")
    return LongRunReport(rows)


def _solver(orbit, name):
    """The solver table of a stepper."""
    integrator, settings = STEPPERS[name]
    settings = {key: value / orbit.rate if key == "step" else value for key, value in settings.items()}
    return {"integrator": integrator} | settings


def _run(orbit: Orbit, name: str, periods: int, progress):
    """A row of the report."""
    solver = _solver(orbit, name)
    instance = Instance(compile_scene(Scene.model_validate(orbit.scene | {"solver": solver})))
    outputs = [v.name for v in instance.model.of_causality("output")]
    state = [outputs.index(name) for name in orbit.state]
    constants = {
        key: ([outputs.index(name) for name in names], size) for key, (names, size) in orbit.constants.items()
    }
    first = instance.outputs().copy()
    widest = np.zeros(len(first))

    # loaded before the clock starts
    loops.widest(instance.m, instance.d, 1.0, 0, instance.y, first, widest)
    done, stopped = 0, None
    taken, errors = [], []
    drift = {key: [] for key in constants}
    began = time.process_time()

    for n in _samples(periods):
        widest[:] = 0.0
        failure = loops.widest(
            instance.m, instance.d, orbit.period / POINTS, (n - done) * POINTS, instance.y, first, widest
        )

        if failure != OK:
            stopped = f"{explain(instance.model, failure)} (after {instance.time / orbit.period:.6g} periods)"
            break

        for key, (places, size) in constants.items():
            drift[key].append(float(widest[places].max() / size))

        done = n
        taken.append(n)
        errors.append(orbit.error(n, instance.y[state]))
        progress(done / periods)

    return {
        "orbit": orbit.name,
        "title": orbit.title,
        "stepper": name,
        "integrator": solver["integrator"],
        "settings": {key: value for key, value in solver.items() if key != "integrator"},
        "periods": taken,
        "drift": drift,
        "error": errors,
        "growth": {key: _growth(taken, values) for key, values in (drift | {"state": errors}).items()},
        "seconds": time.process_time() - began,
        "steps": int(instance.d.steps[0]),
        "evaluations": int(instance.d.evaluations[0]),
        "stopped": stopped,
    }


def _samples(periods):
    """Numbers of periods, evenly spread by their logarithm, up to the last."""
    decades = np.log10(periods)
    return np.unique(np.round(np.logspace(0, decades, max(2, round(decades * SAMPLES)))).astype(int)).tolist()


def _growth(periods, values):
    """Slope of log value over log periods in the last two decades; None where there is no telling."""
    x, y = np.array(periods, float), np.array(values)
    at = (x >= x[-1] / 100) & (y > 0) & (y < 0.1) if len(x) else np.zeros(0, bool)
    return float(np.polyfit(np.log(x[at]), np.log(y[at]), 1)[0]) if at.sum() >= 4 else None
