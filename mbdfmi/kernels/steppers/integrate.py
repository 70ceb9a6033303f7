"""How a stepper takes the state over a communication step: the choice of the method, and what it starts from.

All keep to x' = f(t, x, u(t)) over a communication step, then project(x). Time inside it is counted from its start, so
results do not depend on how a master sums its time. What a stepper remembers across communication points (the step to try
next, rates, a Jacobian) stands in the state: a restored run goes on to the same bits.

Where inputs go on as they were, the inner steps of a pair do not stop at communication points: the integrator's front
lies ahead, and the state at the communication point is read off the step's continuous extension, then projected. The
front waits in the state. When an input jumps at the communication point, it is given up and the motion goes on from there.
"""

from ...steppers import STEPPERS
from ..dynamics.projection import keep_x, project, restore_x
from ..dynamics.rates import set_time
from ..language import inlined, kernel
from ..motion import commands
from ..status import CHANGE_METHOD, NOT_STIFF, OK, STIFF, status, tell
from . import choice, control, fixed, memory, pairs, radau

AUTO, RK54, RK853, RADAU = (STEPPERS[name].number for name in ("auto", "rk54", "rk853", "radau"))


@kernel
def inputs_go_on(m, d):
    """Whether the inputs are those of the communication step before, and remember them. They must not vary in a step."""
    n = m.n_u
    same = n == 0 or d.u_known[0] == 1.0
    constant = True

    for k in range(n):
        same = same and d.u_buffer[k] == d.u_before[k]
        d.u_before[k] = d.u_buffer[k]

        for row in range(1, commands.N_DERIVATIVE):
            constant = constant and d.u_buffer[row * n + k] == 0.0

    d.u_varies[0] = 0.0 if constant else 1.0
    constant = constant and commands.is_at_rest(m, d)
    d.u_known[0] = 1.0 if constant else 0.0
    return same and constant


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
    d.next_step[RADAU] = 0.0
    choice.start(d)
    d.steps[0] = 0.0
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
    watch = auto and m.n_jacobian > 0
    s = 0.0
    failure = OK

    if d.ahead[0] > 0.0:
        s = go_to_front(m, d, H, pair_in_use(d))
    elif auto and d.method[0] != RADAU:
        d.method[0] = pair_for(d, H, onward)

    while s < H:
        if d.method[0] == RADAU:
            failure, s = radau.adaptive(m, d, s, H, watch)
        else:
            failure, s = pairs.adaptive(m, d, s, H, pair_in_use(d), onward, watch)

        if failure != status(CHANGE_METHOD, 0):
            break

        change_method(m, d)
        failure = OK

    return failure, s


@inlined
def pair_in_use(d):
    """The explicit pair of d.method; one of them, whatever a state from outside says."""
    return RK54 if d.method[0] == RK54 else RK853


@inlined
def pair_for(d, H, onward):
    """The pair that `auto` takes: of order 8, but of order 5 where inputs jump so often that either makes one step of it."""
    many = d.next_step[RK54] > 0.0 and d.next_step[RK54] < 0.5 * H
    return RK853 if onward or many or d.next_step[RK853] < 2.0 * H else RK54


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
        d.next_step[RADAU] = d.next_step[pair_in_use(d)]
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
        memory.forget(d)

    control.limit_work(m, d)
    failure = follow_jump(m, d) if jumps and m.n_row > 0 else OK
    reached = 0.0

    if failure == OK and fixed.is_one(m.integrator):
        failure, reached = fixed.equal_steps(m, d, H)
    elif failure == OK:
        failure, reached = adaptive(m, d, H, onward)

    if failure != OK:
        memory.forget(d)

    return failure, reached
