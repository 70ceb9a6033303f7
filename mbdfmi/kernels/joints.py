"""The one place that knows what a joint kind is.

A joint kind is its transform from the joint frame F on the parent to the body, its motion subspace S,
its bias (the relative acceleration at v' = 0) and how q' follows from v. F is at rest in the parent; the body's
frame coincides with F at q = 0.

==========  ===========================  ====================================
kind        q                            v
==========  ===========================  ====================================
REVOLUTE    angle about z of F           angular speed
PRISMATIC   displacement along z of F    speed
SPHERICAL   E                            angular velocity in the body's axes
FREE        position in F, then E        velocity in F, angular velocity in the body's axes
FIXED       none                         none
==========  ===========================  ====================================
"""

import math

from . import algebra as al
from .language import inlined, kernel

REVOLUTE = 0
PRISMATIC = 1
SPHERICAL = 2
FREE = 3
FIXED = 4  # held for good; where nothing asks for its reaction, the compiler makes one node of its two

KINDS = {"revolute": REVOLUTE, "prismatic": PRISMATIC, "spherical": SPHERICAL, "free": FREE, "fixed": FIXED}
N_Q = {REVOLUTE: 1, PRISMATIC: 1, SPHERICAL: 4, FREE: 7, FIXED: 0}
N_V = {REVOLUTE: 1, PRISMATIC: 1, SPHERICAL: 3, FREE: 6, FIXED: 0}


@inlined
def rotated_about_z(A, angle):
    """A Rz(angle)."""
    c = math.cos(angle)
    s = math.sin(angle)
    return (
        (c * A[0][0] + s * A[0][1], c * A[0][1] - s * A[0][0], A[0][2]),
        (c * A[1][0] + s * A[1][1], c * A[1][1] - s * A[1][0], A[1][2]),
        (c * A[2][0] + s * A[2][1], c * A[2][1] - s * A[2][0], A[2][2]),
    )


@inlined
def move(m, d, i):
    """Pose, velocity and bias of body i from those of its parent and its joint's q, v.

    Writes A, r, w, rd, arm, axis or joint_axes, bias_w, bias_r; all in inertial axes. Angular velocities are coordinates in
    the body's own axes, in which its inertia does not change: a body that tumbles is a much smoother motion there.
    """
    parent = m.body_parent[i]
    kind = m.body_joint[i]
    q = m.body_q[i]
    v = m.n_q + m.body_v[i]

    A_joint = al.mat3(m.body_A, i)

    # turned before the chain of products over the bodies, not in it
    if kind == REVOLUTE:
        A_joint = rotated_about_z(A_joint, d.x[q])

    A_parent = al.mat3(d.A, parent)
    w_parent = al.vec3(d.w, parent)
    F = al.mat_mat(A_parent, A_joint)
    arm = al.mat_vec(A_parent, al.vec3(m.body_r, i))

    # relative motion: r_rel along the arm, w_rel, rd_rel
    if kind == REVOLUTE:
        axis = (F[0][2], F[1][2], F[2][2])
        w_rel = al.scale(d.x[v], axis)
        al.set_vec3(d.axis, i, axis)
        al.set_mat3(d.A, i, F)
        al.set_vec3(d.w, i, al.add(w_parent, w_rel))
        al.set_vec3(d.bias_w, i, al.cross(w_parent, w_rel))
        spin = al.cross(w_parent, arm)
        velocity = spin
        bias_r = al.cross(w_parent, spin)

    elif kind == PRISMATIC:
        axis = (F[0][2], F[1][2], F[2][2])
        rd_rel = al.scale(d.x[v], axis)
        arm = al.axpy(d.x[q], axis, arm)
        al.set_vec3(d.axis, i, axis)
        al.set_mat3(d.A, i, F)
        al.set_vec3(d.w, i, w_parent)
        al.set_vec3(d.bias_w, i, al.ZERO3)
        spin = al.cross(w_parent, arm)
        velocity = al.add(spin, rd_rel)
        bias_r = al.cross(w_parent, al.axpy(2.0, rd_rel, spin))

    elif kind == SPHERICAL:
        A = al.mat_mat(F, al.E_matrix(al.E_at(d.x, q)))
        w_rel = al.mat_vec(A, al.vec_at(d.x, v))
        al.set_mat3(d.A, i, A)
        al.set_vec3(d.w, i, al.add(w_parent, w_rel))
        al.set_vec3(d.bias_w, i, al.cross(w_parent, w_rel))
        spin = al.cross(w_parent, arm)
        velocity = spin
        bias_r = al.cross(w_parent, spin)

    elif kind == FIXED:
        d.held[i] = 1.0
        al.set_mat3(d.A, i, F)
        al.set_vec3(d.w, i, w_parent)
        al.set_vec3(d.bias_w, i, al.ZERO3)
        velocity = al.cross(w_parent, arm)
        bias_r = al.cross(w_parent, velocity)

    else:
        rd_rel = al.mat_vec(F, al.vec_at(d.x, v))
        A = al.mat_mat(F, al.E_matrix(al.E_at(d.x, q + 3)))
        w_rel = al.mat_vec(A, al.vec_at(d.x, v + 3))
        arm = al.add(arm, al.mat_vec(F, al.vec_at(d.x, q)))
        al.set_mat3(d.joint_axes, i, F)
        al.set_mat3(d.A, i, A)
        al.set_vec3(d.w, i, al.add(w_parent, w_rel))
        al.set_vec3(d.bias_w, i, al.cross(w_parent, w_rel))
        spin = al.cross(w_parent, arm)
        velocity = al.add(spin, rd_rel)
        bias_r = al.cross(w_parent, al.axpy(2.0, rd_rel, spin))

    al.set_vec3(d.arm, i, arm)
    al.set_vec3(d.r, i, al.add(al.vec3(d.r, parent), arm))
    al.set_vec3(d.rd, i, al.add(al.vec3(d.rd, parent), velocity))
    al.set_vec3(d.bias_r, i, bias_r)


@inlined
def n_v(kind):
    """Number of velocity coordinates of a joint kind."""
    if kind == REVOLUTE or kind == PRISMATIC:
        return 1

    if kind == SPHERICAL:
        return 3

    if kind == FIXED:
        return 0

    return 6


@inlined
def n_q(kind):
    """Number of position coordinates of a joint kind."""
    if kind == REVOLUTE or kind == PRISMATIC:
        return 1

    if kind == SPHERICAL:
        return 4

    if kind == FIXED:
        return 0

    return 7


@inlined
def subspace(m, d, i, k):
    """Column k of the motion subspace S of body i's joint: (angular, linear), inertial axes."""
    kind = m.body_joint[i]

    if kind == REVOLUTE:
        return (al.vec3(d.axis, i), al.ZERO3)

    if kind == PRISMATIC:
        return (al.ZERO3, al.vec3(d.axis, i))

    slides = kind == FREE and k < 3
    F = al.mat3(d.joint_axes, i) if slides else al.mat3(d.A, i)
    column = k % 3
    direction = al.ZERO3

    if column == 0:
        direction = (F[0][0], F[1][0], F[2][0])
    elif column == 1:
        direction = (F[0][1], F[1][1], F[2][1])
    else:
        direction = (F[0][2], F[1][2], F[2][2])

    if slides:
        return (al.ZERO3, direction)

    return (direction, al.ZERO3)


@inlined
def add_given_acceleration(m, d, i):
    """S v' to the bias of a joint whose v' is given (in d.x_rate)."""
    for k in range(n_v(m.body_joint[i])):
        S_w, S_r = subspace(m, d, i, k)
        rate = d.x_rate[m.n_q + m.body_v[i] + k]
        al.add_vec3(d.bias_w, i, al.scale(rate, S_w))
        al.add_vec3(d.bias_r, i, al.scale(rate, S_r))


@inlined
def position_rates(m, d, i):
    """q' of body i's joint from its v, into d.x_rate."""
    kind = m.body_joint[i]
    q = m.body_q[i]
    v = m.n_q + m.body_v[i]

    if kind == REVOLUTE or kind == PRISMATIC:
        d.x_rate[q] = d.x[v]

    elif kind == SPHERICAL:
        al.set_E_at(d.x_rate, q, al.E_rate(al.E_at(d.x, q), al.vec_at(d.x, v)))

    elif kind == FREE:
        al.set_vec_at(d.x_rate, q, al.vec_at(d.x, v))
        al.set_E_at(d.x_rate, q + 3, al.E_rate(al.E_at(d.x, q + 3), al.vec_at(d.x, v + 3)))


@inlined
def E_offset(kind):
    """Where E stands among the position coordinates of a joint kind, -1: it has none."""
    if kind == SPHERICAL:
        return 0

    if kind == FREE:
        return 3

    return -1


@inlined
def joint_E(m, d, i):
    """Euler parameters of body i relative to its joint frame F; continuous in time."""
    kind = m.body_joint[i]
    q = m.body_q[i]

    if kind == REVOLUTE:
        return (0.0, 0.0, math.sin(0.5 * d.x[q]), math.cos(0.5 * d.x[q]))

    if kind == PRISMATIC or kind == FIXED:
        return (0.0, 0.0, 0.0, 1.0)

    return al.E_at(d.x, q + E_offset(kind))


@inlined
def told_start(m, i):
    """A spherical or free joint's start values as told of its second marker in its first.

    (r, E of unit length, r', w); w in the second marker's axes where body_spins is 1, else in the first's like the rest.
    """
    kind = m.body_joint[i]
    q = m.body_q[i]
    v = m.body_v[i]
    k = E_offset(kind)
    E = al.E_at(m.q_start, q + k)
    E = al.E_scale(1.0 / math.sqrt(al.E_dot(E, E)), E)
    turned = al.vec3(m.zyx_start, i)
    told = al.vec3(m.zyx_told, i)

    if turned[0] != told[0] or turned[1] != told[1] or turned[2] != told[2]:
        E = al.zyx_E(turned)

    w = al.vec_at(m.v_start, v + k)

    if m.body_spins[i] == 1:
        w = al.matT_vec(al.E_matrix(E), w)

    if kind == FREE:
        return al.vec_at(m.q_start, q), E, al.vec_at(m.v_start, v), w

    return al.ZERO3, E, al.ZERO3, w


@inlined
def told_motion(m, d, i):
    """The same of the motion in d.x."""
    kind = m.body_joint[i]
    q = m.body_q[i]
    v = m.n_q + m.body_v[i]
    k = E_offset(kind)
    E = al.E_at(d.x, q + k)
    A = al.E_matrix(E)
    w_own = al.vec_at(d.x, v + k)
    r = al.ZERO3
    rd = al.ZERO3

    if kind == FREE:
        r = al.vec_at(d.x, q)
        rd = al.vec_at(d.x, v)

    if m.body_reversed[i] == 0:
        return r, E, rd, w_own if m.body_spins[i] == 1 else al.mat_vec(A, w_own)

    r = al.neg(al.matT_vec(A, r))
    w = al.neg(w_own)
    rd = al.sub(al.cross(w, r), al.matT_vec(A, rd))
    return r, al.E_conjugate(E), rd, al.mat_vec(A, w) if m.body_spins[i] == 1 else w


@inlined
def take_motion(m, d, i, r, E, rd, w):
    """A spherical or free joint's motion as told (see told_start) into d.x.

    Where the first marker is on the body, not on the parent, the tree needs the inverse motion:
    r -> -A^T r, r' -> A^T (w x r - r'), w -> -A^T w.
    """
    kind = m.body_joint[i]
    q = m.body_q[i]
    v = m.n_q + m.body_v[i]
    k = E_offset(kind)
    A = al.E_matrix(E)
    spins = m.body_spins[i] == 1

    if m.body_reversed[i] == 0:
        w_own = w if spins else al.matT_vec(A, w)
    else:
        first = al.mat_vec(A, w) if spins else w
        w_own = al.neg(first)
        rd = al.matT_vec(A, al.sub(al.cross(first, r), rd))
        r = al.neg(al.matT_vec(A, r))
        E = al.E_conjugate(E)

    if kind == FREE:
        al.set_vec_at(d.x, q, r)
        al.set_vec_at(d.x, v, rd)

    al.set_E_at(d.x, q + k, E)
    al.set_vec_at(d.x, v + k, w_own)


@inlined
def start(m, d, i):
    """Start values of body i's joint into d.x, from q_start and v_start. False: E has no length."""
    kind = m.body_joint[i]
    q = m.body_q[i]

    if kind == REVOLUTE or kind == PRISMATIC:
        d.x[q] = m.q_start[q]
        d.x[m.n_q + m.body_v[i]] = m.v_start[m.body_v[i]]
        return True

    if kind == FIXED:
        return True

    E = al.E_at(m.q_start, q + E_offset(kind))

    if not al.E_dot(E, E) > 0.0:
        return False

    r, E, rd, w = told_start(m, i)
    take_motion(m, d, i, r, E, rd, w)
    return True


@inlined
def turn_between(E, F):
    """Angle (rad) of the rotation from E to F, both of unit length."""
    turn = al.E_product(al.E_conjugate(E), F)
    return 2.0 * math.asin(min(1.0, al.norm((turn[0], turn[1], turn[2]))))


@inlined
def off_start(m, d, i, k, positions):
    """How far coordinate k of a spherical or free joint, as told, is from its start value: m, rad, or m/s, rad/s."""
    r, E, rd, w = told_start(m, i)
    r_now, E_now, rd_now, w_now = told_motion(m, d, i)
    moves = m.body_joint[i] == FREE and k < 3

    if positions:
        return r_now[k] - r[k] if moves else turn_between(E, E_now)

    return rd_now[k] - rd[k] if moves else w_now[k % 3] - w[k % 3]


@inlined
def with_component(u, k, value):
    """The vector u with component k replaced."""
    return (value if k == 0 else u[0], value if k == 1 else u[1], value if k == 2 else u[2])


@kernel
def put_back(m, d, i, k, positions):
    """Coordinate k of a spherical or free joint, as told, to its start value; an orientation as a whole. Returns how far it was off."""
    off = abs(off_start(m, d, i, k, positions))
    r, E, rd, w = told_start(m, i)
    r_now, E_now, rd_now, w_now = told_motion(m, d, i)
    moves = m.body_joint[i] == FREE and k < 3

    if positions and moves:
        r_now = with_component(r_now, k, r[k])
    elif positions:
        E_now = E
    elif moves:
        rd_now = with_component(rd_now, k, rd[k])
    else:
        w_now = with_component(w_now, k % 3, w[k % 3])

    take_motion(m, d, i, r_now, E_now, rd_now, w_now)
    return off
