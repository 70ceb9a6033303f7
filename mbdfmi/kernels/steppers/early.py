"""Stages of the step from the integrator's front on, found early: a few in each communication step that only reads off the state.

So the one that reaches the front has little left to do, and single steps cost about the same (docs/theory.md 18.5). Nothing of the motion
is changed by that. The rates stand in the work arrays, in the state how many: a restored run finds them again, to the bit.
"""

import math

import numpy as np

from ..dynamics.projection import keep_x
from ..dynamics.rates import evaluate_now, store_rate
from ..language import apart, inlined, kernel
from ..signatures import DATA, MODEL, float64, int64
from ..status import OK
from . import control, memory, noise
from .estimates import NOTHING, advance, judge, length_again
from .tableaux import NODES, NOISE, STAGE_COUNT, STAGE_TOTAL

# inner steps since an input jumped that make another jump unlikely, for then the work is lost
QUIET = 32.0

NONE_WILL_BE = -1.0


@inlined
def is_worth(m, d):
    """Whether inputs go on for long, as far as is known."""
    quiet = m.n_u == 0 or d.steps[0] - d.jump_steps[0] >= QUIET
    return quiet and d.u_varies[0] == 0.0 and d.early_stages[0] != NONE_WILL_BE


@inlined
def begun(d, pair):
    """How many stages are found, whatever a state from outside says."""
    return int(d.early_stages[0]) if 0.0 < d.early_stages[0] <= STAGE_COUNT[pair] else 0


@kernel
def find_stage(m, d, pair, stage):
    """The rates of a stage from the front (x_before) on. Returns a status."""
    if stage == 0:
        for k in range(m.n_x):
            d.x[k] = d.x_before[k]

        d.early_share[0] = -1.0
        d.early_share[1] = 1.0
        d.early_share[2] = -1.0

        if memory.recall_rate(m, d):
            return OK
    else:
        advance(m, d, pair, stage, d.early_step[0])

    d.now[0] = d.front_time[0] + NODES[pair, stage] * d.early_step[0]

    for k in range(m.n_u):
        d.input[k] = d.u_buffer[k]

    failure = evaluate_now(m, d)

    if failure != OK:
        return failure

    store_rate(m, d, stage)

    if m.n_row > 0:
        share = d.least_share[0]

        if stage == 0:
            d.early_share[0] = share

        d.early_share[1] = share if stage == 0 else min(share, d.early_share[1])
        d.early_share[2] = share if stage == 0 else max(share, d.early_share[2])

    return OK


@kernel
def find_again(m, d, pair, count):
    """The first `count` stages, if they do not stand here. Not counted. Returns a status."""
    if d.stages_here[0] == 1.0:
        return OK

    evaluations = d.evaluations[0]
    failure = OK

    for stage in range(count):
        if failure == OK:
            failure = find_stage(m, d, pair, stage)

    d.evaluations[0] = evaluations
    d.stages_here[0] = 1.0
    return failure


@kernel
def take(m, d, pair):
    """How many stages from x on are found, x being the front: a step uses them."""
    count = begun(d, pair)

    if count > 0:
        keep_x(m, d)

        if find_again(m, d, pair, count) != OK:
            count = 0

        for k in range(m.n_x):
            d.x[k] = d.x_before[k]

    d.early_stages[0] = 0.0
    return count


@kernel
def again(m, d, pair):
    """With all stages found: the step is shortened if it will not do. Returns how many stages are good for it, or NONE_WILL_BE."""
    for k in range(m.n_x):
        d.x[k] = d.x_before[k]

    control.weigh(m, d)
    error, _, _, singular = judge(
        m, d, pair, d.early_step[0], d.early_share[1], d.early_share[2], d.early_tries[0]
    )

    if error <= 1.0:
        return float(STAGE_COUNT[pair])

    if not error < math.inf:
        return NONE_WILL_BE

    if not singular and noise.is_due(m, d):
        d.now[0] = d.front_time[0]
        noise.find(m, d, NOISE[pair], d.early_step[0])

    near = singular and d.early_share[1] < NOTHING and d.early_share[0] >= NOTHING
    d.next_step[pair] = length_again(d, pair, d.early_step[0], error, near)
    d.early_tries[0] += 1.0
    d.early_step[0] = min(d.next_step[pair], m.max_step[0])
    d.early_share[1] = d.early_share[0] if d.early_share[0] >= 0.0 else 1.0
    d.early_share[2] = d.early_share[0]
    return 1.0


@apart(int64(MODEL, DATA, int64, float64))
def work(m, d, pair, H):
    """Stages of a step of `pair` from the front on, as many as are this communication step's (s) share. Leaves x. Returns OK."""
    count = begun(d, pair)

    if not (H > 0.0 and is_worth(m, d)) or count == STAGE_COUNT[pair]:
        return OK

    for k in range(m.n_x):
        d.x_own[k] = d.x[k]
        d.x[k] = d.front[k]

    keep_x(m, d)

    if count > 0 and find_again(m, d, pair, count) != OK:
        count = 0

    if count == 0:
        d.early_step[0] = min(d.next_step[pair], m.max_step[0])
        d.early_tries[0] = 0.0

    # what is left of the step, and the communication steps it is for
    share = np.ceil((STAGE_TOTAL[pair] - count) / (np.floor(d.ahead[0] / H) + 2.0))
    d.early_stages[0] = float(count)

    while share > 0.0 and count < STAGE_COUNT[pair] and d.early_stages[0] != NONE_WILL_BE:
        share -= 1.0
        d.early_stages[0] = float(count + 1) if find_stage(m, d, pair, count) == OK else NONE_WILL_BE
        count += 1

    if d.early_stages[0] == STAGE_COUNT[pair]:
        d.early_stages[0] = again(m, d, pair)

    d.stages_here[0] = 1.0

    for k in range(m.n_x):
        d.x[k] = d.x_own[k]

    return OK
