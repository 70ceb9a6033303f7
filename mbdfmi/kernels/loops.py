"""Loops over what a run calls, for those who measure: without Python in between."""

from . import entry, forces
from .dynamics import inertia, rates
from .language import apart
from .motion import kinematics
from .signatures import DATA, MODEL, REALS, float64, int64, void
from .status import OK


@apart(int64(MODEL, DATA, REALS, int64, REALS, REALS))
def follow(m, d, times, n, y, rows):
    """Outputs, rows (n*n_y,), at the times (n,), s, by one communication step to each. Returns a status.

    y : (n_y,) to work in.
    """
    for k in range(n):
        failure = entry.step(m, d, times[k] - d.time[0])

        if failure != OK:
            return failure

        failure = entry.compute_outputs(m, d, y)

        if failure != OK:
            return failure

        for j in range(m.n_y):
            rows[k * m.n_y + j] = y[j]

    return OK


@apart(int64(MODEL, DATA, float64, int64, REALS, REALS, REALS))
def widest(m, d, H, n, y, first, widest):
    """n communication steps of H (s), with outputs; widest[k] becomes the largest |y[k] - first[k]|. Returns a status."""
    for _ in range(n):
        failure = entry.step(m, d, H)

        if failure == OK:
            failure = entry.compute_outputs(m, d, y)

        if failure != OK:
            return failure

        for k in range(m.n_y):
            widest[k] = max(widest[k], abs(y[k] - first[k]))

    return OK


@apart(int64(MODEL, DATA, float64, int64))
def steps(m, d, H, n):
    """n steps of H (s), without outputs. Returns a status."""
    for _ in range(n):
        failure = entry.step(m, d, H)

        if failure != OK:
            return failure

    return OK


@apart(void(MODEL, DATA, int64))
def evaluations(m, d, n):
    """x' n times; a different x each time, so that nothing can be taken out of the loop."""
    for _ in range(n):
        d.x[0] += 1e-15
        rates.evaluate(m, d, 0.0)


@apart(void(MODEL, DATA, int64))
def preparations(m, d, n):
    """All that `evaluate` does before its last part, n times."""
    for _ in range(n):
        d.x[0] += 1e-15
        rates.set_time(m, d, 0.0)
        kinematics.kinematics(m, d)
        inertia.inertias(m, d)
        forces.apply(m, d)
