"""Ways against each other: within what their tolerances allow, or to the bit.

How far two ways may part is measured, not guessed: the reference is run again with its state kicked at every shared point by random
changes as small as KICK. What comes of these at an output, from the start up to a time, over KICK, is how far an error of a step there
may go (GROWTH below). Where that is beyond all use, as in chaotic motions, the comparison counts as loose.
"""

import re

import numpy as np

from .findings import Finding
from .ways import KICK, TIGHT

# errors of a step of tolerance 1, in kicks: steps between two kicks are many, and errors of some add up
SAFETY = 100.0

# part of the largest value of an output that rounding may take
ROUNDING = 1e-11

# an output is not worth comparing where more than this part of its largest value is allowed
LOOSE = 0.1

# of steppers with a fixed step: error, in differences to half the step
HALVING = 5.0

# told of the work done, by formulations in their own way, or bounded by a law of its own
APART = ("solver.", "multipliers", "constraint_gap", "constraint_rate")


class Reference:
    """The reference and its kicked runs; `ignored`: groups of outputs that are not determined."""

    def __init__(self, run, kicked, ignored=()):
        self.run = run
        self.times, self.phases = np.array(run.times), np.array(run.phases)
        self.values = np.array(run.values)
        self.groups = {g: c for g, c in groups(run.names).items() if not g.startswith(APART) and g not in ignored}
        self.scale = {g: np.abs(self.values[:, c]).max() for g, c in self.groups.items()}
        n = min([len(self.values), *(len(k.values) for k in kicked)])
        self.times, self.phases, self.values = self.times[:n], self.phases[:n], self.values[:n]
        self.growth = {}

        for g, columns in self.groups.items():
            parted = [difference(g, np.array(k.values)[:n][:, columns], self.values[:, columns]) for k in kicked]
            self.growth[g] = np.maximum.accumulate(np.max(parted, axis=0)) / KICK

    def rows(self, run):
        """(rows of a run, rows here) at the same times and phases."""
        times, phases = np.array(run.times), np.array(run.phases)
        theirs, ours = [], []
        near = 1e-9 * max(self.times[-1], 1e-300)

        for phase in (0, 1):
            a, b = np.flatnonzero(phases == phase), np.flatnonzero(self.phases == phase)

            if len(a) and len(b):
                k = np.clip(np.searchsorted(self.times[b], times[a] - near), 0, len(b) - 1)
                same = np.abs(self.times[b][k] - times[a]) <= near
                theirs.append(a[same])
                ours.append(b[k[same]])

        return np.concatenate(theirs or [[]]).astype(int), np.concatenate(ours or [[]]).astype(int)


def groups(names):
    """Name without index -> columns of its components."""
    found = {}

    for k, name in enumerate(names):
        found.setdefault(re.sub(r"\[[\d,]+\]$", "", name), []).append(k)

    return found


def difference(group, a, b):
    """How far rows (n, k) of a group of outputs are apart (n,): E and -E are one orientation, angles of yaw, pitch, roll turn around."""
    apart = np.abs(a - b)

    if group.endswith("euler_parameters"):
        return np.minimum(apart.max(axis=1), np.abs(a + b).max(axis=1))

    if group.endswith("zyx"):
        apart = np.abs((a - b + np.pi) % (2 * np.pi) - np.pi)

    return apart.max(axis=1)


def near(reference, run, count, halved=None, tolerance=None):
    """Findings where a run is off the reference by more than its tolerance allows.

    halved : the same way with half the step, of a fixed step. tolerance : other than the way's, as of the same way compiled.
    """
    if not run.values or run.names != reference.run.names:
        return []

    theirs, ours = reference.rows(run)
    tolerance = TIGHT if run.way.step else run.way.tolerance if tolerance is None else tolerance
    values = np.array(run.values)
    worst = None

    for g, columns in reference.groups.items():
        off = difference(g, values[theirs][:, columns], reference.values[ours][:, columns])
        allowed = SAFETY * (tolerance + TIGHT) * reference.growth[g][ours] + ROUNDING * reference.scale[g]

        if halved is not None:
            n = min(len(values), len(halved.values))
            finer = np.array(halved.values)[:n][:, columns]
            between = np.zeros(len(values))
            between[:n] = np.maximum.accumulate(difference(g, values[:n][:, columns], finer))
            between[n:] = np.inf
            allowed = allowed + HALVING * between[theirs]

        loose = ~(allowed <= LOOSE * reference.scale[g] + ROUNDING)
        count.loose += int(loose.sum())
        count.made += len(off)
        beyond = np.where(loose, 0.0, off / np.maximum(allowed, 1e-300))
        beyond[~np.isfinite(off)] = np.inf

        if len(beyond) and beyond.max() > 1.0 and (worst is None or beyond.max() > worst[0]):
            k = int(np.argmax(beyond > 1.0))
            c = columns[int(np.argmax(np.abs(values[theirs[k]][columns] - reference.values[ours[k]][columns])))]
            worst = beyond.max(), Finding(
                "ways part", str(run.way), run.names[c], run.times[theirs[k]], values[theirs[k], c], reference.values[ours[k], c],
                allowed[k], f"at worst {beyond.max():.3g} times what is allowed; the reference is {reference.run.way}",
            )  # fmt: skip

    return [worst[1]] if worst else []


def same(run, other, why):
    """Findings where two runs that must be equal to the bit are not."""
    if run.names != other.names:
        return [Finding("not the same", str(run.way), text=f"{why}: other outputs than [{other.way}]")]

    ends = [(r.stopped is not None, r.refused is not None, len(r.values)) for r in (run, other)]

    if ends[0] != ends[1] and not (run.cut or other.cut):
        said = [r.refused or r.stopped or "comes to its end" for r in (run, other)]
        return [Finding("not the same", str(run.way), text=f"{why}: {said[0]!r}, the other: {said[1]!r}")]

    n = min(len(run.values), len(other.values))

    for k in range(n):
        differ = np.flatnonzero(run.values[k] != other.values[k])

        if len(differ):
            c = int(differ[0])
            return [Finding("not the same", str(run.way), run.names[c], run.times[k], run.values[k][c], other.values[k][c], 0.0, why)]

    return []
