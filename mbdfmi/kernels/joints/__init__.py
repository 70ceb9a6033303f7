"""What a joint kind is, behind one face: the only dispatch on kinds.

A joint leads from the joint frame F, at rest in the parent, to the body, whose frame coincides with F at q = 0. A kind is a file
here, and each has the same functions (docs/theory.md 3 and 6.3); below they are chosen by `body_joint`.
All vectors are in inertial axes.

    move            pose, velocity and bias of the body from those of its parent and q, v
    subspace        columns of the motion subspace S
    position_rates  q' from v
    start           start values into the state; retract moves q along a change of v; weigh tells how errors count
    relative_E      orientation relative to F as Euler parameters
    articulate      articulated inertia and bias wrench through the joint to the parent (ABA, leaves to root)
    accelerate      v' and the body's acceleration (ABA, root to leaves)
    pass_wrench     a wrench through the joint to the parent, and the joint's whitened response (leaves to root)
    respond         changes of v' and of the body's acceleration by whitened efforts (root to leaves)
    compliance      what unit wrenches could do in the joint, by its least pivots

To add a kind: a file with these, its row in kinds.py, its branch in each function below (docs/contributing.md).
"""

from ..language import inlined
from ..math import algebra as al
from . import fixed, free, one_axis, rotors, spherical
from .kinds import (
    FIXED,
    FREE,
    KINDS,
    N_Q,
    N_SLIDE,
    N_V,
    PRISMATIC,
    REVOLUTE,
    SPHERICAL,
    E_offset,
    is_one_axis,
    n_q,
    n_v,
    slides,
    turns,
)
from .told import off_start, put_back, told_motion, told_start, turn_between

__all__ = [
    "FIXED",
    "FREE",
    "KINDS",
    "N_Q",
    "N_SLIDE",
    "N_V",
    "PRISMATIC",
    "REVOLUTE",
    "SPHERICAL",
    "E_offset",
    "is_one_axis",
    "n_q",
    "n_v",
    "off_start",
    "put_back",
    "slides",
    "told_motion",
    "told_start",
    "turn_between",
    "turns",
]  # fmt: skip


@inlined
def move(m, d, i):
    """Pose, velocity and bias of body i from those of its parent and its joint's q, v.

    Writes A, r, w, rd, arm, axis or joint_axes, bias_w, bias_r; all in inertial axes. Angular velocities are coordinates in
    the body's own axes, in which its inertia does not change: a body that tumbles is a much smoother motion there.
    """
    parent = m.body_parent[i]
    kind = m.body_joint[i]
    A_joint = al.mat3(m.body_A, i)

    # turned before the chain of products over the bodies, not in it
    if kind == REVOLUTE:
        A_joint = one_axis.rotated_about_z(A_joint, d.q[m.body_q[i]])

    A_parent = al.mat3(d.A, parent)
    w_parent = al.vec3(d.w, parent)
    F = al.mat_mat(A_parent, A_joint)
    arm = al.mat_vec(A_parent, al.vec3(m.body_r, i))

    if kind == REVOLUTE:
        arm, velocity, bias_r = one_axis.move_revolute(m, d, i, F, w_parent, arm)
    elif kind == PRISMATIC:
        arm, velocity, bias_r = one_axis.move_prismatic(m, d, i, F, w_parent, arm)
    elif kind == SPHERICAL:
        arm, velocity, bias_r = spherical.move(m, d, i, F, w_parent, arm)
    elif kind == FIXED:
        arm, velocity, bias_r = fixed.move(m, d, i, F, w_parent, arm)
    else:
        arm, velocity, bias_r = free.move(m, d, i, F, w_parent, arm)

    al.set_vec3(d.arm, i, arm)
    al.set_vec3(d.r, i, al.add(al.vec3(d.r, parent), arm))
    al.set_vec3(d.rd, i, al.add(al.vec3(d.rd, parent), velocity))
    al.set_vec3(d.bias_r, i, bias_r)


@inlined
def subspace(m, d, i, k):
    """Column k of the motion subspace S of body i's joint: (angular, linear), inertial axes."""
    kind = m.body_joint[i]

    if is_one_axis(kind):
        return one_axis.subspace(m, d, i, k)

    if kind == SPHERICAL:
        return spherical.subspace(m, d, i, k)

    return free.subspace(m, d, i, k)


@inlined
def add_given_acceleration(m, d, i):
    """S v' to the bias of a joint whose v' is given (in d.v_rate)."""
    for k in range(n_v(m.body_joint[i])):
        S_w, S_r = subspace(m, d, i, k)
        rate = d.v_rate[m.body_v[i] + k]
        al.add_vec3(d.bias_w, i, al.scale(rate, S_w))
        al.add_vec3(d.bias_r, i, al.scale(rate, S_r))


@inlined
def position_rates(m, d, i):
    """q' of body i's joint from its v, into d.q_rate."""
    kind = m.body_joint[i]

    if is_one_axis(kind):
        one_axis.position_rates(m, d, i)
    elif kind == SPHERICAL:
        spherical.position_rates(m, d, i)
    elif kind == FREE:
        free.position_rates(m, d, i)


@inlined
def start(m, d, i):
    """Start values of body i's joint into d.q and d.v, from q_start and v_start. False: E has no length."""
    kind = m.body_joint[i]

    if is_one_axis(kind):
        return one_axis.start(m, d, i)

    if kind == SPHERICAL:
        return spherical.start(m, d, i)

    return free.start(m, d, i) if kind == FREE else True


@inlined
def retract(m, d, i, factor):
    """q of body i's joint moved along d.change, as if it were v for a time `factor`."""
    kind = m.body_joint[i]

    if is_one_axis(kind):
        one_axis.retract(m, d, i, factor)
    elif kind == SPHERICAL:
        spherical.retract(m, d, i, factor)
    elif kind == FREE:
        free.retract(m, d, i, factor)


@inlined
def weigh(m, d, i, rotation):
    """Error weights of what is not a length among the q of body i's joint: `rotation`, that of a rotation."""
    kind = m.body_joint[i]

    if is_one_axis(kind):
        one_axis.weigh(m, d, i, rotation)
    elif kind == SPHERICAL:
        spherical.weigh(m, d, i, rotation)
    elif kind == FREE:
        free.weigh(m, d, i, rotation)


@inlined
def relative_E(m, d, i):
    """Euler parameters of body i relative to its joint frame F; continuous in time."""
    kind = m.body_joint[i]

    if is_one_axis(kind):
        return one_axis.relative_E(m, d, i)

    if kind == SPHERICAL:
        return spherical.relative_E(m, d, i)

    return free.relative_E(m, d, i) if kind == FREE else al.E_IDENTITY


@inlined
def articulate(m, d, i, moment, force):
    """Body i's articulated inertia (I_a, H_a, M_a) and bias wrench through its joint, what is left of them to the parent's.

    Leaves what `accelerate`, `pass_wrench` and `respond` need. Returns a status.
    """
    kind = m.body_joint[i]
    I = al.sym3(d.I_a, i)
    H = al.mat3(d.H_a, i)
    M = al.sym3(d.M_a, i)

    if d.held[i] > 0.0:
        if rotors.has(m, i):
            moment = al.add(moment, rotors.reaction(m, d, i))

        return fixed.articulate(m, d, i, I, H, M, moment, force)

    if is_one_axis(kind):
        return one_axis.articulate(m, d, i, I, H, M, moment, force)

    if kind == SPHERICAL:
        return spherical.articulate(m, d, i, I, H, M, moment, force)

    return free.articulate(m, d, i, I, H, M, moment, force)


@inlined
def accelerate(m, d, i, alpha, rdd):
    """v' of body i's joint into d.v_rate; its (alpha, rdd) from those it has with the joint's v' = 0."""
    kind = m.body_joint[i]

    # a given acceleration is in the bias already
    if d.held[i] > 0.0:
        return alpha, rdd

    if is_one_axis(kind):
        return one_axis.accelerate(m, d, i, alpha, rdd)

    if kind == SPHERICAL:
        return spherical.accelerate(m, d, i, alpha, rdd)

    return free.accelerate(m, d, i, alpha, rdd)


@inlined
def pass_wrench(m, d, p, i, at, coefficient):
    """Take a wrench (passed_moment, passed_force) past joint i: its whitened response to p from `at` on, the rest to the parent.

    `coefficient` is what comes with it as effort in the joint itself (couplings).
    """
    kind = m.body_joint[i]

    if d.held[i] > 0.0:
        passes, moment, force = fixed.pass_wrench(m, d, p, i, at, n_v(kind))
    elif is_one_axis(kind):
        passes, moment, force = one_axis.pass_wrench(m, d, p, i, at, coefficient)
    elif kind == SPHERICAL:
        passes, moment, force = spherical.pass_wrench(m, d, p, i, at, coefficient)
    else:
        passes, moment, force = free.pass_wrench(m, d, p, i, at, coefficient)

    if passes:
        parent = m.body_parent[i]
        al.add_vec3(d.passed_moment, parent, al.add(moment, al.cross(al.vec3(d.arm, i), force)))
        al.add_vec3(d.passed_force, parent, force)


@inlined
def respond(m, d, i, alpha, rdd):
    """Change of v' by the whitened efforts d.white into d.change; the body's (alpha, rdd) from those with the joint at rest."""
    kind = m.body_joint[i]

    if d.held[i] > 0.0:
        return fixed.respond(m, d, i, n_v(kind), alpha, rdd)

    if is_one_axis(kind):
        return one_axis.respond(m, d, i, alpha, rdd)

    if kind == SPHERICAL:
        return spherical.respond(m, d, i, alpha, rdd)

    return free.respond(m, d, i, alpha, rdd)


@inlined
def compliance(m, d, i, square):
    """What a unit moment, and a unit force at arms of this square (m2), could do in joint i by its articulated inertia."""
    kind = m.body_joint[i]

    if d.held[i] > 0.0:
        return 0.0

    if is_one_axis(kind):
        return one_axis.compliance(m, d, i, square)

    return spherical.compliance(m, d, i, square) if kind == SPHERICAL else free.compliance(m, d, i, square)


@inlined
def pivot(m, d, i, k):
    """The pivot of velocity coordinate k of body i's joint that `articulate` has left."""
    return d.D_M[6 * i + k] if m.body_joint[i] == FREE and k < 3 else d.D[6 * i + k % 3]


@inlined
def largest_effort(kind, moment, force, lever):
    """Square of what a wrench could be as effort in a joint of one freedom if it met the axis as well as it can; 0 in others.

    lever : m, from the joint to where the force acts.
    """
    return one_axis.largest_effort(kind, moment, force, lever) if is_one_axis(kind) else 0.0
