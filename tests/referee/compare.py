"""Ways against each other: within what their tolerances allow, or to the bit.

How far two ways may part is measured, not guessed: the reference is run again with its state kicked at every
communication point by random changes as small as KICK. What comes of these at an output, from the start up to a
time, over KICK, is how far an error of a step there may go (GROWTH below). Where that is beyond all use, as
in chaotic motions, the comparison counts as loose.
"""

import re

import numpy as np

from .findings import Finding
from .ways import ARRIVING, KICK, TIGHT

# how much larger than a kick's what an error of the tolerance's size does may be, and the same for each step
# between two kicks
SAFETY = 60.0
OF_A_STEP = 6.0
STEPS_UNKNOWN = 40

# steps may pass over a jump of a force with an error that their estimate does not see: so many times as much
# is allowed there
OF_KINKS = 30.0

# part of the largest value of an output that rounding may take
ROUNDING = 1e-11

# what rounding is as an error of a step, relative
ULPS = 1e-13

# an output is not worth comparing where more than this part of the largest value of its unit is allowed
LOOSE = 0.1

# order of steppers with a fixed step: half of it and a quarter differ by about the error over two to that
# power; so many times that may the error be
ORDERS = {"rk4": 4, "ros2": 2, "gauss": 8}
HALVING = 20.0

# where things are: whether a stop is touched, a joint sticks, hangs on these
PLACES = (".position", ".angle", ".angles", ".distance", ".length")

# told of the work done, by formulations in their own way, or bounded by a law of its own
APART = ("solver.", "multipliers", "constraint_gap", "constraint_rate")


class Reference:
    """The reference and its kicked runs.

    units : of outputs by name. exact : `exactness.Exactness`, what can be asked of the scene.
    size : of a group, the largest value of all outputs of its unit. rounding : what rounding may take of it.
    """

    def __init__(self, run, kicked, units, exact):
        self.exact = exact
        self.run = run
        self.times, self.phases = np.array(run.times), np.array(run.phases)
        self.values = np.array(run.values)
        self.groups = {
            g: c
            for g, c in groups(run.names).items()
            if not g.startswith(APART) and g not in exact.undetermined
        }
        of_unit = {}

        for columns in self.groups.values():
            unit = units[run.names[columns[0]]]
            of_unit[unit] = max(of_unit.get(unit, 0.1), np.abs(self.values[:, columns]).max())

        self.size = {g: of_unit[units[run.names[c[0]]]] for g, c in self.groups.items()}
        # accelerations are sums of forces over inertias, which round before they cancel
        of_forces = {
            acceleration: ULPS * of_unit.get(force, 0.0) / inertia
            for acceleration, force, inertia in zip(("m/s2", "rad/s2"), ("N", "N.m"), exact.lightest)
        }
        self.rounding = {
            g: max(ROUNDING, exact.carried) * self.size[g] + of_forces.get(units[run.names[c[0]]], 0.0)
            for g, c in self.groups.items()
        }
        n = min([len(self.values), *(len(k.values) for k in kicked)])
        self.times, self.phases, self.values = self.times[:n], self.phases[:n], self.values[:n]
        self.intervals = max(1, int(np.sum(self.phases == ARRIVING)) - 1)
        self.growth = {}

        for g, columns in self.groups.items():
            parted = [
                difference(g, np.array(k.values)[:n][:, columns], self.values[:, columns]) for k in kicked
            ]
            growth = np.maximum.accumulate(np.max(parted, axis=0)) / KICK

            # the start, before the first kick, is as far off as what it was kicked to
            growth[:1] = growth[1:2] if n > 1 else growth[:1]
            self.growth[g] = growth

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
    """Name without index -> columns of its components;
    without those that a joint and a body of one name share."""
    found = {}

    for k, name in enumerate(names):
        found.setdefault(re.sub(r"\[[\d,]+\]$", "", name), []).append(k)

    return {name: columns for name, columns in found.items() if len({names[k] == name for k in columns}) == 1}


def difference(group, a, b):
    """How far rows (n, k) of a group of outputs are apart (n,): E and -E are one orientation, angles of yaw,
    pitch, roll turn around."""
    apart = np.abs(a - b)

    if group.endswith("euler_parameters"):
        return np.minimum(apart.max(axis=1), np.abs(a + b).max(axis=1))

    if group.endswith("zyx"):
        apart = np.abs((a - b + np.pi) % (2 * np.pi) - np.pi)

    return apart.max(axis=1)


def near(reference, run, count, halved=None, twin=None, until=np.inf, kinked=False):
    """Findings where a run is off the reference by more than its tolerance allows.

    halved : of a fixed step, the same way with half and with a quarter of it. twin : a run of the same way,
    which it may be off by no more than rounding, grown as errors grow. until : s, up to which they are
    compared. kinked : forces may jump. What hangs on whether one did tells nothing where the motion is too wild.
    """
    if not run.values:
        return []

    theirs, ours = reference.rows(run)
    safety = OF_KINKS if kinked else 1.0
    halving = HALVING * safety
    steps = run.steps or STEPS_UNKNOWN * reference.intervals
    safety = safety * (SAFETY + OF_A_STEP * steps / reference.intervals)
    n = len(twin.values) if twin else len(run.values)
    seen = (theirs < n) & (reference.times[ours] < until)
    theirs, ours = theirs[seen], ours[seen]
    exact = reference.exact
    tolerance = exact.start + exact.carried + TIGHT + (0.0 if run.way.step else run.way.tolerance)
    tolerance = ULPS if twin else tolerance
    values, at = np.array(run.values), {name: k for k, name in enumerate(run.names)}
    parts = []

    for g, columns in reference.groups.items():
        names = [reference.run.names[c] for c in columns]

        # among a run's own outputs a name may be another part's
        ambiguous = run.way.plain and g.rpartition(".")[0] in exact.shared

        if ambiguous or not all(name in at for name in names):
            continue

        mine = values[:, [at[name] for name in names]]
        wanted = (
            np.array(twin.values)[theirs][:, [at[name] for name in names]]
            if twin
            else reference.values[ours][:, columns]
        )
        off = difference(g, mine[theirs], wanted)
        allowed = safety * tolerance * reference.growth[g][ours] + reference.rounding[g]

        if halved is not None:
            allowed = (
                allowed
                + halving
                * 2.0 ** ORDERS[run.way.integrator]
                * _halving(g, halved, at, names, len(mine))[theirs]
            )

        loose = ~(allowed <= LOOSE * reference.size[g])
        parts.append((names, mine[theirs], wanted, off, allowed, loose))

    places = [loose for names, *_, loose in parts if names[0].partition("[")[0].endswith(PLACES)]
    wild = kinked and np.any([np.zeros(len(theirs), bool), *places], axis=0)
    return _worst(reference, run, twin, theirs, parts, wild, count)


def _worst(reference, run, twin, theirs, parts, wild, count):
    """The worst of what is off, as a list. parts : of each group (names, values, wanted, off, allowed, loose); theirs :
    rows of the run. wild : rows at which nothing is compared."""
    beyond, worst = 0.0, None

    for names, mine, wanted, off, allowed, loose in parts:
        loose = loose | wild
        count.loose += int(loose.sum())
        count.made += len(off)
        ratio = np.where(loose, 0.0, off / allowed)
        ratio[~np.isfinite(off)] = np.inf
        count.worst(str(run.way.integrator), ratio.max(initial=0.0))

        if ratio.max(initial=0.0) > max(beyond, 1.0):
            beyond = ratio.max()
            k = int(np.argmax(ratio > 1.0))
            c = int(np.argmax(np.abs(mine[k] - wanted[k])))
            text = f"the other way is {(twin or reference.run).way}"
            worst = Finding(
                "ways part",
                str(run.way),
                names[c],
                run.times[theirs[k]],
                mine[k, c],
                wanted[k, c],
                allowed[k],
                text,
                float(beyond),
            )

    return [worst] if worst else []


def _halving(group, halved, at, names, n):
    """How far, up to each of n rows, runs with half the step and a quarter of it are apart;
    infinite where one has ended."""
    one, two = (
        np.array(other.values).reshape(len(other.values), -1)[:n, [at[name] for name in names]]
        for other in halved
    )
    off, both = np.full(n, np.inf), min(len(one), len(two))
    off[:both] = np.maximum.accumulate(difference(group, one[:both], two[:both])) if both else 0.0
    return off


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
            return [
                Finding(
                    "not the same",
                    str(run.way),
                    run.names[c],
                    run.times[k],
                    run.values[k][c],
                    other.values[k][c],
                    0.0,
                    why,
                )
            ]

    return []
