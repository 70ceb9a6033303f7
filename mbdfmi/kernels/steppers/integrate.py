"""How a stepper takes the state over a communication step: the choice of the method, and what it starts from.

All keep to x' = f(t, x, u(t)) over a communication step, then project(x). Time inside it is counted from its start, so
results do not depend on how a master sums its time. What a stepper remembers across communication points (the step to try
next, rates, a Jacobian) stands in the state: a restored run goes on to the same bits.

Where inputs go on as they were, the inner steps of a pair do not stop at communication points: the integrator's front
lies ahead, and the state at the communication point is read off the step's continuous extension, then projected. The
front waits in the state. When an input jumps at the communication point, it is given up and the motion goes on from there.
"""

from ...steppers import RK32, RKC, STEPPERS
from ..dynamics.ends import see_ends
from ..dynamics.projection import keep_x, project, restore_x
from ..dynamics.rates import set_time
from ..language import inlined, kernel
from ..motion import commands, inputs
from ..status import CHANGE_METHOD, CHANGE_PAIR, NOT_STIFF, OK, STIFF, status, tell
from . import choice, control, early, fixed, memory, noise, pairs, radau, rkc

AUTO, RK54, RK853, RADAU = (STEPPERS[name].number for name in ("auto", "rk54", "rk853", "radau"))

# by how much of its size an input, and of its change in a communication step, that goes on may be off: rounding, or this part of the tolerance
ROUNDING = 1e-13
OFF = 1e-3
MOST_OFF = 1e-9

# a step of 3(2) is tried where one of 5(4) could be so many times as long, if it were not for inputs; and where it was too long, the step
# that is tried again grows by that from one communication step to the next
MUCH_LONGER = 9.0
FORGETS = 1.02


@inlined
def misfit(m, d, k, H, reach):
    """How input k, which varies, is off what it was before, if that went on: (its value, it over `reach` (s), allowed).

    Allowed is a part of its size and change in a communication step of H (s).
    """
    n = m.n_u
    joint = abs(d.u_buffer[k] - d.u_course[k])
    off = joint
    size = max(abs(d.u_buffer[k]), abs(d.u_course[k]))
    near = 1.0
    far = 1.0

    for row in range(1, inputs.N_DERIVATIVE):
        u = d.u_buffer[row * n + k]
        near *= H / row
        far *= reach / row
        off += far * abs(u - d.u_course[row * n + k])
        size += near * abs(u)

    return joint, off, size * max(ROUNDING, min(MOST_OFF, OFF * m.tolerance[0]))


@kernel
def inputs_go_on(m, d, H):
    """Whether the inputs go on over a communication step of H (s) as over the one before: held, or along the same polynomials."""
    n = m.n_u
    known = n == 0 or d.u_known[0] == 1.0
    same = known
    joins = known
    constant = True
    tried = d.next_step[RADAU] if d.method[0] == RADAU else d.next_step[pair_in_use(d)]
    reach = max(d.ahead[0], H + tried)

    for k in range(n):
        varied = False

        for row in range(1, inputs.N_DERIVATIVE):
            constant = constant and d.u_buffer[row * n + k] == 0.0
            varied = varied or d.u_buffer[row * n + k] != 0.0 or d.u_course[row * n + k] != 0.0

        if varied:
            joint, off, allowed = misfit(m, d, k, H, reach)
            same = same and off <= allowed
            joins = joins and joint <= allowed
        else:
            same = same and d.u_buffer[k] == d.u_course[k]
            joins = joins and d.u_buffer[k] == d.u_course[k]

    rest = commands.is_at_rest(m, d)
    d.u_varies[0] = 0.0 if constant else 1.0
    d.u_known[0] = 1.0 if rest else 0.0
    d.u_joins[0] = 1.0 if joins and rest else 0.0
    return same and rest


@kernel
def start(m, d):
    """Nothing to remember yet."""
    memory.forget(d)
    d.u_known[0] = 0.0
    d.jacobian_known[0] = 0.0
    d.lu_step[0] = 0.0
    d.lu_known[0] = 0.0
    d.next_step[RK54] = 0.0
    d.next_step[RK853] = 0.0
    d.next_step[RK32.number] = 0.0
    d.next_step[RADAU] = 0.0
    d.next_step[RKC.number] = 0.0
    choice.start(d)
    noise.start(d)
    d.steps[0] = 0.0
    d.jump_steps[0] = -early.QUIET
    d.rejected[0] = 0.0
    d.evaluations[0] = 0.0
    d.error_sum[0] = 0.0
    d.linear_work[0] = 0.0
    d.singular_told[0] = 0.0
    d.method[0] = m.integrator

    if m.integrator == AUTO:
        d.method[0] = RK853


@inlined
def go_to_front(m, d, H, pair):
    """With the front ahead: to it, when it lies in this communication step, else to H (s). Returns the time reached."""
    if d.ahead[0] > H * (1.0 + 1e-14):
        keep_x(m, d)

        if pairs.extend(m, d, pair, H) == OK:
            d.ahead[0] -= H

            if d.border_pair[0] != choice.STABILISED:
                early.work(m, d, method_at_border(d) if m.integrator == AUTO else pair, H)

            return H

        restore_x(m, d)
        memory.forget(d)
        return 0.0

    s = min(H, d.ahead[0])
    d.ahead[0] = 0.0

    for k in range(m.n_x):
        d.x[k] = d.front[k]

    return s


@kernel
def adaptive(m, d, H, onward):
    """By a pair or Radau's method, whichever is in use; `auto` changes between them. Returns (status, time reached)."""
    auto = m.integrator == AUTO
    s = 0.0
    failure = OK

    if d.ahead[0] > 0.0:
        s = go_to_front(m, d, H, pair_in_use(d))

    if auto and d.method[0] != RADAU and s < H:
        d.method[0] = pair_for(m, d, H, onward)

    while s < H:
        if d.method[0] == RADAU:
            failure, s = radau.adaptive(m, d, s, H, auto)
        elif d.method[0] == RKC.number:
            failure, s = rkc.adaptive(m, d, s, H)
        else:
            failure, s = pairs.adaptive(m, d, s, H, pair_in_use(d), onward, auto)

        if failure == status(CHANGE_METHOD, 0):
            change_method(m, d)
        elif failure == status(CHANGE_PAIR, 0):
            d.method[0] = method_at_border(d)
            d.error_before[0] = control.LEAST_ERROR
        else:
            break

        failure = OK

    return failure, s


@inlined
def pair_in_use(d):
    """The explicit pair of d.method; one of them, whatever a state from outside says."""
    return int(d.method[0]) if d.method[0] == RK54 or d.method[0] == RK32.number else RK853


@inlined
def method_at_border(d):
    """The method that `auto` takes where inputs go on: of order 8, at the border of stability that which costs less."""
    if d.border_pair[0] == choice.STABILISED:
        return RKC.number

    return RK54 if d.border_pair[0] == choice.LOWER else RK853


@inlined
def pair_for(m, d, H, onward):
    """The pair that `auto` takes: of a lower order where inputs jump so often that it, too, makes one step from jump to jump."""
    many = d.next_step[RK54] > 0.0 and d.next_step[RK54] < 0.5 * H

    if onward or many or d.border_pair[0] != choice.NONE or d.next_step[RK853] < 2.0 * H:
        return method_at_border(d)

    if d.next_step[RK32.number] == 0.0 and d.next_step[RK54] > MUCH_LONGER * H:
        d.next_step[RK32.number] = H

    if d.next_step[RK32.number] >= H:
        return RK32.number

    d.next_step[RK32.number] *= FORGETS
    return RK54


@inlined
def change_method(m, d):
    """From a pair to Radau's method or back; says so in the log."""
    memory.forget(d)
    d.jacobian_known[0] = 0.0
    choice.change(d)

    if d.method[0] == RADAU:
        d.method[0] = RK853
        tell(d, status(NOT_STIFF, 0), 0.0, 0.0)
    else:
        stabilised = d.method[0] == RKC.number
        d.next_step[RADAU] = d.next_step[RKC.number if stabilised else pair_in_use(d)]
        d.method[0] = RADAU
        tell(d, status(STIFF, 0), 0.0, 0.0)


@kernel
def follow_jump(m, d):
    """Loops at once where commands jumped to, as rigid bodies are knocked: no step may average over it. Returns a status."""
    set_time(m, d, 0.0)
    keep_x(m, d)
    failure = project(m, d)

    if failure != OK:
        restore_x(m, d)

    return failure


@kernel
def advance(m, d, H, onward, jumps):
    """The state by H (s); `onward`: inputs stay as they were; `jumps`: commands do. Returns (status, time reached within H)."""
    if not onward:
        # a rate holds where values go on
        joins = d.u_joins[0] == 1.0 and d.ahead[0] == 0.0 and d.rate_known[0] == 1.0
        memory.forget(d)
        d.rate_known[0] = 1.0 if joins else 0.0

        # a first step is no jump
        if d.steps[0] > 0.0:
            d.jump_steps[0] = d.steps[0]

    control.limit_work(m, d)
    failure = follow_jump(m, d) if jumps and m.n_row > 0 else OK
    reached = 0.0

    if failure == OK and fixed.is_one(m.integrator):
        failure, reached = fixed.equal_steps(m, d, H)
    elif failure == OK:
        failure, reached = adaptive(m, d, H, onward)

    see_ends(m, d)

    if failure != OK:
        memory.forget(d)

    return failure, reached
