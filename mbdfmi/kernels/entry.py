"""What an FMU, or an in-process run, calls. Each takes m and d and returns a status.

`ENTRIES` are those that the C wrapper knows.
"""

import math

from . import exchange, forces, joints, notes, output_values, outputs
from .dynamics import assembly, ends, forward, inertia, projection, rates, reactions, rows
from .forces import radiation, sagging, solutions, struts
from .joints import virtual
from .language import apart, inlined
from .motion import commands, drives, kinematics
from .prepare import prepare
from .signatures import DATA, MODEL, REALS, float64, int64
from .status import BAD_START_ORIENTATION, BAD_STEP, OK, OUTPUT_NOT_FINITE, status
from .steppers import integrate


@apart(int64(MODEL, DATA, float64), "mbdfmi_initialise")
def initialise(m, d, t0):
    """The state at the start time t0 (s) from the start values. Returns a status."""
    d.time[0] = t0
    d.time[1] = 0.0
    d.now[0] = t0
    d.start_time[0] = t0
    integrate.start(m, d)
    commands.forget(m, d)
    commands.plan(m, d, 0.0)
    virtual.forget(m, d)

    for i in range(1, m.n_body):
        if m.body_drive[i] < 0 and not joints.start(m, d, i):
            return status(BAD_START_ORIENTATION, i)

    failure = assembly.assemble(m, d)

    if failure != OK:
        return notes.tell_open(m, d, failure)

    kinematics.kinematics(m, d)
    struts.keep_start_lengths(m, d)
    radiation.reset(m, d)
    sagging.reset(m, d)
    notes.tell_of_start(m, d)
    return OK


@inlined
def advance_time(d, h):
    """time += h with compensated summation (Kahan)."""
    y = h - d.time[1]
    t = d.time[0] + y
    d.time[1] = (t - d.time[0]) - y
    d.time[0] = t


@apart(int64(MODEL, DATA, float64), "mbdfmi_step")
def step(m, d, H):
    """Advance the state, and the inputs by their derivatives and commands, by H (s). Returns a status.

    On failure the state is that of the last accepted inner step.
    """
    if not H >= 0.0:
        return status(BAD_STEP, 0)

    jumps = commands.begin(m, d, H)
    onward = integrate.inputs_go_on(m, d, H)
    failure = OK
    reached = H

    if m.n_x > 0:
        failure, reached = integrate.advance(m, d, H, onward, jumps)

    commands.end(m, d, reached)
    advance_time(d, reached)
    return failure


@apart(int64(MODEL, DATA, REALS), "mbdfmi_outputs")
def compute_outputs(m, d, y):
    """All outputs y[n_y] of the state and the inputs (their values alone) now, all finite, or a failure. Returns a status."""
    failure = OK
    needs = m.output_needs
    rates.set_time(m, d, 0.0)
    commands.plan(m, d, 0.0)
    drives.prescribe(m, d)
    follows = m.n_command > 0 and m.n_row > 0

    if follows:
        for k in range(m.n_x):
            d.x_own[k] = d.x[k]

        projection.follow_commands(m, d)

    kinematics.kinematics(m, d)

    if (needs & (outputs.NEED_INERTIAS | outputs.NEED_ACCELERATIONS)) != 0:
        inertia.inertias(m, d)

    if (needs & outputs.NEED_ACCELERATIONS) != 0:
        forces.apply(m, d)
        failure = forward.accelerate(m, d)
    elif (needs & outputs.NEED_ROWS) != 0:
        rows.write_rows(m, d)

    if (needs & outputs.NEED_REACTIONS) != 0 and failure == OK:
        reactions.find_joint_wrenches(m, d)

    output_values.write_outputs(m, d, y)

    if follows:
        for k in range(m.n_x):
            d.x[k] = d.x_own[k]

    n_place = m.n_body + 2 * m.n_constraint + m.n_told + m.n_stop

    for k in range(m.n_y):
        if failure == OK and not math.isfinite(y[k]):
            failure = status(OUTPUT_NOT_FINITE, n_place + k)

    return failure


ENTRIES = {
    "mbdfmi_prepare": prepare,
    "mbdfmi_initialise": initialise,
    "mbdfmi_step": step,
    "mbdfmi_outputs": compute_outputs,
    "mbdfmi_lead": exchange.lead,
    "mbdfmi_rates": exchange.rates_now,
    "mbdfmi_indicators": exchange.indicators,
    "mbdfmi_complete": ends.complete,
    "mbdfmi_next_kink": exchange.next_kink,
    "mbdfmi_solve": solutions.solve,
}
"""What the C wrapper calls. In native code a view is the addresses of its buffers, in their order (see views.py)."""
