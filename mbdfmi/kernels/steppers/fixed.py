"""Steppers of a fixed step: equal inner steps, each projected.

A method is a file with `step`, which leaves x a step later in d.x or tells why not, and a line in `step` here.
"""

from ...steppers import STEPPERS
from ..dynamics.ends import see_ends
from ..dynamics.projection import keep_x, project, restore_x
from ..dynamics.rates import is_finite, set_time
from ..language import apart, inlined
from ..status import NOT_FINITE, OK, TOO_MUCH_WORK, status
from ..signatures import DATA, MODEL, Tuple, float64, int64
from . import control, gauss, rk4, ros2

RK4, ROS2, GAUSS = (STEPPERS[name].number for name in ("rk4", "ros2", "gauss"))


@inlined
def is_one(integrator):
    """Whether a stepper is one of these."""
    return integrator == RK4 or integrator == ROS2 or integrator == GAUSS


@inlined
def step(m, d, s, h):
    """d.x a step of h (s) after x_before, at s (s) of the communication step. Returns a status."""
    if m.integrator == RK4:
        return rk4.step(m, d, s, h)

    if m.integrator == ROS2:
        return ros2.step(m, d, s, h)

    return gauss.step(m, d, s, h)


@apart(Tuple((int64, float64))(MODEL, DATA, float64))
def equal_steps(m, d, H):
    """Equal inner steps of at most m.step over H (s). Returns (status, time reached within H)."""
    n_step, h = control.equal_steps(H, m.step[0])
    done = 0

    while done < n_step:
        s = done * h

        if control.is_spent(d):
            return status(TOO_MUCH_WORK, 0), s

        see_ends(m, d)
        keep_x(m, d)
        failure = step(m, d, s, h)

        if failure == OK:
            # not every method has a stage at the end, where drives are to be met
            set_time(m, d, s + h)
            failure = project(m, d) if is_finite(d, m.n_x) else status(NOT_FINITE, 0)

        if failure != OK:
            restore_x(m, d)
            return failure, s

        d.steps[0] += 1.0
        done += 1

    return OK, H
