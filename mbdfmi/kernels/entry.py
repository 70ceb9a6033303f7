"""What an FMU, or an in-process run, calls. Each entry takes the buffers' addresses and returns a status.

`ENTRIES` is the table that ahead-of-time compiling works from.
"""

from numba import types

from . import (
    coordinates,
    drives,
    dynamics,
    forces,
    integrate,
    joints,
    outputs,
    prepare,
    project,
    reactions,
    rows,
    tableaux,
    tree,
)
from .language import inlined, kernel
from .status import BAD_START_ORIENTATION, OK, status
from .views import INTS, REALS, data_view, model_view


@kernel
def prepare_model(m, d):
    """Derive what follows from parameters. To be called after any of them changed. Returns a status."""
    return prepare.prepare(m, d)


@kernel
def initialise(m, d, t0):
    """The state at the start time t0 (s) from the start values. Returns a status."""
    d.time[0] = t0
    d.time[1] = 0.0
    d.now[0] = t0
    d.start_time[0] = t0
    d.next_step[0] = 0.0
    d.steps[0] = 0.0
    d.rejected[0] = 0.0
    d.evaluations[0] = 0.0

    for i in range(1, m.n_body):
        if m.body_drive[i] < 0 and not joints.start(m, d, i):
            return status(BAD_START_ORIENTATION, i)

    for row in range(m.n_row):
        d.row_redundant[row] = 0.0

    failure = project.assemble(m, d)
    project.hold(m, d, 4)
    coordinates.follow_turns(m, d)
    return failure


@inlined
def advance_time(d, h):
    """time += h with compensated summation (Kahan)."""
    y = h - d.time[1]
    t = d.time[0] + y
    d.time[1] = (t - d.time[0]) - y
    d.time[0] = t


@kernel
def step(m, d, H):
    """Advance the state by H (s). On failure it is that of the last accepted inner step. Returns a status."""
    if m.n_x == 0:
        advance_time(d, H)
        return OK

    if m.integrator == integrate.RK4:
        failure, reached = integrate.rk4(m, d, H)
    elif m.integrator == integrate.RK54:
        failure, reached = integrate.adaptive(m, d, H, tableaux.PAIR_54)
    else:
        failure, reached = integrate.adaptive(m, d, H, tableaux.PAIR_853)

    advance_time(d, reached)
    drives.advance_inputs(m, d, reached)
    return failure


@kernel
def compute_outputs(m, d, y):
    """All outputs y[n_y] of the state and the inputs (their values alone) now. Returns a status."""
    failure = OK
    needs = m.output_needs
    integrate.set_time(m, d, 0.0)
    drives.prescribe(m, d)
    tree.kinematics(m, d)

    if (needs & (outputs.NEED_INERTIAS | outputs.NEED_ACCELERATIONS)) != 0:
        tree.inertias(m, d)

    if (needs & outputs.NEED_ACCELERATIONS) != 0:
        forces.apply(m, d)
        failure = dynamics.accelerate(m, d)
    elif (needs & outputs.NEED_ROWS) != 0:
        rows.write_rows(m, d)

    if (needs & outputs.NEED_REACTIONS) != 0 and failure == OK:
        reactions.find_joint_wrenches(m, d)

    outputs.write_outputs(m, d, y)
    return failure


@kernel
def mbdfmi_prepare(ints, reals, state, work):
    """`prepare_model` on addresses."""
    return prepare_model(model_view((ints, reals)), data_view((ints, state, work, work)))


@kernel
def mbdfmi_initialise(ints, reals, state, work, t0):
    """`initialise` on addresses."""
    return initialise(model_view((ints, reals)), data_view((ints, state, work, work)), t0)


@kernel
def mbdfmi_step(ints, reals, state, work, u, H):
    """`step` on addresses."""
    return step(model_view((ints, reals)), data_view((ints, state, work, u)), H)


@kernel
def mbdfmi_outputs(ints, reals, state, work, u, y):
    """`compute_outputs` on addresses."""
    return compute_outputs(model_view((ints, reals)), data_view((ints, state, work, u)), y)


_BUFFERS = (INTS, REALS, REALS, REALS)

ENTRIES = {
    "mbdfmi_prepare": (mbdfmi_prepare, types.int64(*_BUFFERS)),
    "mbdfmi_initialise": (mbdfmi_initialise, types.int64(*_BUFFERS, types.float64)),
    "mbdfmi_step": (mbdfmi_step, types.int64(*_BUFFERS, REALS, types.float64)),
    "mbdfmi_outputs": (mbdfmi_outputs, types.int64(*_BUFFERS, REALS, REALS)),
}
