"""A run against the independent route: at every shared point, all that both can tell of the state there."""

from dataclasses import replace

import numpy as np

from mbdfmi.scene import fmi_name

from .compare import groups
from .findings import Finding
from .independent import System
from .telling import with_ground_seen
from .ways import LEAVING

# relative to the largest value of its kind, and what a constraint may be open
CLOSE = 1e-8
OPEN = 1e-7

# what a gap makes wrong, times the gap
OF_A_GAP = 10.0

SMALL = 6  # bodies up to which every shared point is looked at

# told by multipliers and accelerations: as good as the largest of them
FORCES = ("accel", "alpha", "effort", "reaction", "power", "moment", "force")


def agrees(data, plan, run, exact, count):
    """Findings where a run in process tells another thing than the independent route, of the same motion.

    exact : `exactness.Exactness`; what acts along loops is as good as they close.
    """
    columns = groups(list(plan.signals))

    leaving = np.flatnonzero(np.array(run.phases) == LEAVING)
    times = np.array(run.times)[leaving]
    system = None
    shared = {fmi_name(name) for name in data["body"] if name in data.get("joint", {})}
    stride = 1 + len(data["body"]) // SMALL

    for k, t in enumerate(plan.points[:-1]):
        row = leaving[np.abs(times - t) < 1e-9 * plan.until]

        if not len(row) or t >= exact.until:
            break

        changed = plan.settings.get(k, {})

        # what the scene leaves to the start stays as it was there
        if system is None:
            system = System(with_ground_seen(data), changed)
        elif changed:
            system = system.changed(changed)

        if k % stride:
            continue

        told = named(run.names, run.values[row[0]])
        inputs = {name: _input(plan, t, k, at) for name, at in columns.items()}
        own = system.evaluate(run.times[row[0]], system.motions_of(told), inputs, told)
        alone = {name: value for name, value in told.items() if name.rpartition(".")[0] not in shared}
        found = list(_instant(alone, own, run, run.times[row[0]], exact, count))

        if found:
            others = ", ".join(finding.variable for finding in found[1:9])
            more = f"and so do {others}" + (" and others" if found[9:] else "") if others else ""
            return [replace(found[0], text=more)]

    return []


def _input(plan, t, piece, columns):
    """The orders of an input that are told: numbers, or rows of an array's elements."""
    signals = [list(plan.signals.values())[column] for column in columns]
    values = plan.inputs(t, piece)[: None if all(signal.told for signal in signals) else 1, columns]
    return values[:, 0] if len(columns) == 1 else values


def _instant(told, own, run, t, exact, count):
    near, gap = max(CLOSE, OF_A_GAP * exact.start), max(OPEN, OF_A_GAP * exact.start)
    open_by = np.abs(own["constraint residuals"]).max(initial=0.0)
    size = {name: np.abs(value).max() for name, value in told.items()}
    position = max([1.0, *(size[name] for name in told if name.endswith("position"))])

    if open_by > gap * position:
        text = "what joints leave open"
        yield Finding("second route", str(run.way), "constraints", t, open_by, 0.0, gap * position, text)

    largest = 1.0 + max(
        (size[name] for name in told if any(word in name.rpartition(".")[2] for word in FORCES)), default=0.0
    )

    for name, value in told.items():
        if name not in own or name in exact.undetermined:
            continue

        wanted, value = np.atleast_1d(own[name]), np.atleast_1d(value)
        scale = largest if any(word in name.rpartition(".")[2] for word in FORCES) else 1.0 + size[name]
        off = np.abs(value - wanted)
        count.made += 1

        if name.endswith("euler_parameters"):
            off = np.minimum(off, np.abs(value + wanted))
        elif name.endswith("zyx"):
            off = np.abs((value - wanted + np.pi) % (2 * np.pi) - np.pi)

        if not off.max() <= near * scale:
            c = int(np.nanargmax(off)) if np.isfinite(off).any() else 0
            yield Finding("second route", str(run.way), name, t, value[c], wanted[c], near * scale)


def named(names, values):
    """Values by name, arrays as one."""
    found = {}

    for name, columns in groups(names).items():
        array = len(columns) > 1 or names[columns[0]] != name
        found[name] = np.array([values[c] for c in columns]) if array else float(values[columns[0]])

    return found
