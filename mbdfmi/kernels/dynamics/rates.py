"""x' = f(t, x, u): what every stepper integrates (docs/theory.md 18.1)."""

from .. import forces, joints
from ..end_frames import touching
from ..language import apart, inlined
from ..motion import coordinates, drives, inputs, kinematics
from ..signatures import DATA, MODEL, float64, int64
from . import forward, inertia


@inlined
def set_time(m, d, s):
    """Time and inputs at s (s) after the start of the communication step: u + u' s + u'' s^2 / 2 + ... by their derivatives."""
    d.now[0] = d.time[0] + s

    if d.u_varies[0] == 0.0:
        for k in range(m.n_u):
            d.input[k] = d.u_buffer[k]
    else:
        for k in range(m.n_u):
            d.input[k] = inputs.polynomial(m, d, k, s)


@apart(int64(MODEL, DATA))
def evaluate_now(m, d):
    """x' into d.x_rate for d.x, the time and the inputs now. Returns a status."""
    if m.n_drive > 0:
        drives.prescribe(m, d)

    kinematics.kinematics(m, d)
    inertia.inertias(m, d)
    forces.apply(m, d)

    for i in range(1, m.n_body):
        joints.position_rates(m, d, i)

    if m.n_end_frame > 0:
        touching.parameter_rates(m, d)

    coordinates.turn_rates(m, d)
    forces.radiation.state_rates(m, d)
    d.evaluations[0] += 1.0
    return forward.accelerate(m, d)


@apart(int64(MODEL, DATA, float64))
def evaluate(m, d, s):
    """The same at time s (s) of the communication step."""
    set_time(m, d, s)
    return evaluate_now(m, d)


@inlined
def store_rate(m, d, stage):
    """Keep d.x_rate as that of a stage."""
    n = m.n_x

    for k in range(n):
        d.stage[stage * n + k] = d.x_rate[k]


@inlined
def is_finite(d, n):
    """True when x[:n] holds no NaN and no infinity."""
    total = 0.0

    for k in range(n):
        total += 0.0 * d.x[k]

    return total == 0.0
