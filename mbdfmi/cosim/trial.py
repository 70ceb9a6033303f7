"""The sequence of FMUs that feed each other in a circle, one after another: found by trying the first steps.

How far a sequence is off depends on which FMU answers within a step to what it is fed with: one that is stiff does well behind
those that feed it. No description tells that.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from .errors import CouplingError
from .graph import sequence, through
from .history import History
from .march import March
from .plan import Group, Plan
from .rig import Rig
from .schema import Master
from .start import initialise
from .watch import Watch

STEPS = (5, 25)
"""Steps that are tried, at the least and at most: a fortieth of the run."""

FINER = 4
"""Parts of a step of the run that sequences are compared with."""

CLEARLY = 0.8
"""Part of the error of the sequence of the dependencies below which another one is taken."""

MOST = 6
"""Sequences that are tried."""


def tried(net, chosen: Plan, master: Master, times: np.ndarray) -> Plan:
    """The plan with sequences of circles as the first steps advise, and why; the same plan where there is nothing to
    choose. times : communication points of the run (s).

    All FMUs are instantiated for it, and run for a few steps, several times.
    """
    groups = []
    reasons = list(chosen.reasons)

    for group in chosen.groups:
        names = group.names
        candidates = candidates_of(net, group, master)

        if len(candidates) > 1:
            names, reason = _best(net, chosen, group, candidates, master, times)
            reasons = [text for text in reasons if not text.startswith("sequence:")]
            reasons.append(reason)

        groups.append(replace(group, names=names))

    return replace(chosen, groups=groups, reasons=reasons)


def candidates_of(net, group: Group, master: Master) -> list[list[str]]:
    """Sequences of a group that are to be tried, that of the plan first; it alone where there is nothing to choose."""
    if group.method != "gauss-seidel" or not group.loop or master.sequence or not _can_be_tried(net):
        return [group.names]

    return _candidates(net, group)


def _can_be_tried(net):
    """Whether FMUs can be instantiated once more, and take shorter steps."""
    return all(
        member.can.variable_steps and not member.description.coSimulation.canBeInstantiatedOnlyOncePerProcess
        for member in net.members.values()
    )


def _candidates(net, group):
    """Sequences that dependencies allow: FMUs whose outputs depend on inputs at once stay behind."""
    late = [name for name in group.names if through(net, name)]
    free = [name for name in group.names if name not in late]
    in_circles = {name for circle in sequence(net) if len(circle) > 1 for name in circle}

    # what stands in no circle has its place by the links
    if not set(group.names) <= in_circles or len(free) < 2:
        return [group.names]

    orders = itertools.permutations(free) if len(free) <= 3 else (free, free[::-1])
    return [[*order, *late] for order in itertools.islice(orders, MOST)]


def _best(net, chosen, group, candidates, master, times):
    """(the best of the candidates, why)."""
    n = int(np.clip(len(times) // 40, *STEPS))
    points = times[: n + 1]
    fine = np.unique(np.concatenate([np.linspace(a, b, FINER + 1) for a, b in itertools.pairwise(points)]))
    words = f"sequence: {', '.join(candidates[0])}"

    try:
        right = _run(net, _with(chosen, group, candidates[0]), master, fine)[::FINER]
    except CouplingError as error:
        return candidates[0], f"{words} (could not be tried: {error.errors[0]})"

    size = np.abs(right).max(axis=0, initial=0.0)
    moves = np.ptp(right, axis=0) > 1e-9 * size
    errors = []

    for names in candidates:
        try:
            off = np.abs(_run(net, _with(chosen, group, names), master, points) - right)
            errors.append(float(np.max((off / np.maximum(size, 1e-300))[:, moves], initial=0.0)))
        except CouplingError:
            errors.append(np.inf)

    best = int(np.argmin(errors))

    if not errors[best] < CLEARLY * errors[0]:
        return candidates[0], f"{words} (others were no better in the first {n} steps)"

    gain = errors[0] / max(errors[best], 1e-300)
    return candidates[best], (
        f"sequence: {', '.join(candidates[best])} (in the first {n} steps {gain:.2g} times nearer than "
        f"{', '.join(candidates[0])} to steps of a {FINER}th)"
    )


def _with(chosen, group, names):
    groups = [replace(one, names=names) if one is group else one for one in chosen.groups]
    return replace(chosen, groups=groups)


def _run(net, chosen, master, points) -> np.ndarray:
    """What links carry (n, n_u) at the points of a run of FMUs of its own."""
    rig = Rig(net, {name: through(net, name) for name in net.names})
    history = History(net, rig.y, rig.end)
    well = False

    try:
        rig.open(float(points[0]), float(points[-1]))
        initialise(rig)
        rig.begin()
        march = March(rig, chosen, master, Watch(history, master.limit), history)
        rig.end[:] = rig.now
        history.add(float(points[0]))
        march.fixed(points, float(points[1] - points[0]), None)
        well = True
        return history.now()
    finally:
        rig.close(well)
