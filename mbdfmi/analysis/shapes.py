"""Mode shapes as a motion to be looked at."""

import numpy as np

from ..kernels.motion import kinematics
from ..run.results import Results
from ..run.states import States

# rad, or parts of the scene's length, of the largest coordinate; how far bodies go, as part of the scene's
# extent
AMPLITUDE = 0.35
FURTHEST = 0.2

# s and pictures of each mode, and how often it swings in that
SHOWN = 4.0
PICTURES = 96
SWINGS = 2

HALVINGS = 8


def shapes(modes, which=None) -> Results:
    """Modes one after another, as the results of a run: each swings slowly for some seconds, whatever its
    frequency and damping.

    which : numbers of the modes, counted from 1; by default all of up to 12. Raises ValueError for one that
        there is not.
    """
    which = list(range(1, min(len(modes), 12) + 1)) if which is None else list(which)

    for k in which:
        if not 1 <= k <= len(modes):
            raise ValueError(f"there is no mode {k}; there are {len(modes)}")

    manifold = modes.linear.manifold
    instance = manifold.mechanism.instance
    start = float(manifold.d.time[0])
    n = PICTURES * len(which)
    states = States(manifold.model, n)
    times = SHOWN * np.arange(n) / PICTURES
    numbers, told = np.repeat(which, PICTURES).astype(float), []
    phases = np.exp(2j * np.pi * SWINGS * np.arange(PICTURES) / PICTURES)

    try:
        for i, k in enumerate(which):
            mode = modes[k - 1]
            told.append(f"{SHOWN * i:g} to {SHOWN * (i + 1):g} s: mode {k}, {words(mode)}")

            for j, change in enumerate(_motion(manifold, mode.shape, phases)):
                manifold.put(change)
                manifold.d.v[:] = 0.0
                manifold.d.time[0] = times[PICTURES * i + j]
                states.keep(PICTURES * i + j, instance)
    finally:
        manifold.d.time[0] = start
        manifold.put()

    columns = {"time": times, "mode": numbers}
    return Results(columns, {"time": "s", "mode": None}, f"modes of {modes.linear.title}", told, states)


def words(mode):
    """Frequency and damping in words."""
    if mode.oscillates:
        text = f"{mode.frequency:.4g} Hz"
        return text if abs(mode.damping) < 1e-9 else f"{text}, damping {100 * mode.damping:.3g} %"

    rate = mode.eigenvalue.real
    return f"{'grows' if rate > 0 else 'dies away'} with {rate:.4g} 1/s" if rate else "free"


def _motion(manifold, shape, phases):
    """Changes (n,) of the free coordinates over a swing, as large as looks well and as loops can follow."""
    size = AMPLITUDE

    for _ in range(HALVINGS):
        changes = [size * (shape * phase).real for phase in phases]

        try:
            reach = max(_displaced(manifold, change) for change in changes[::8])
        except ArithmeticError:
            reach = np.inf

        if reach <= FURTHEST:
            break

        size *= max(0.5 * FURTHEST / reach, 0.25) if np.isfinite(reach) else 0.5

    return changes


def _displaced(manifold, change):
    """How far bodies go, as part of the scene's extent."""
    m, d = manifold.m, manifold.d
    manifold.put()
    kinematics.kinematics(m, d)
    before = d.r.reshape(-1, 3)[1:].copy()
    manifold.put(change)
    kinematics.kinematics(m, d)
    away = np.linalg.norm(d.r.reshape(-1, 3)[1:] - before, axis=1).max(initial=0.0)
    return away / max(np.ptp(before, axis=0).max(initial=0.0), m.scene_length[0])
