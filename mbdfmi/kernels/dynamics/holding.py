"""Which start values a projection keeps, and how heavily the others count.

A joint is held when all its coordinates are kept. One kept in part (a free joint's forward speed) is made heavy along what is
kept, and what that gives way is put back until nothing does. With weights d.weight[n_v] a joint counts as if it had that much
inertia of its own.
"""

from .. import joints
from ..language import inlined, kernel
from ..math import algebra as al

POSITION = 1
VELOCITY = 2

# what is kept counts as that many of what is not, what is given but cannot be kept as that many
HEAVY = 1e4
GIVEN = 1e2

# of d.weighs: which coordinates have weights
PARTS = 1.0
ALL = 2.0

# ... and in the metric of the coordinates themselves each counts as that many times the whole scene
UNIFORM = 1e3


@inlined
def keep_given(m, d, what):
    """Mark in d.kept the coordinates whose start values are given for `what` (POSITION, VELOCITY)."""
    for v in range(m.n_v):
        d.kept[v] = float((m.v_given[v] // what) % 2)


@inlined
def weigh_none(m, d):
    """The metric of the inertia alone."""
    d.weighs[0] = 0.0

    for v in range(m.n_v):
        d.weight[v] = 0.0


@inlined
def keep_none(m, d):
    """No start value is kept, nothing has a weight."""
    weigh_none(m, d)

    for v in range(m.n_v):
        d.kept[v] = 0.0


@inlined
def hold(m, d):
    """Joints with a drive are held, and those all of whose coordinates are kept. Returns whether one is kept in part."""
    partly = False

    for i in range(1, m.n_body):
        n = joints.n_v(m.body_joint[i])
        count = 0

        for v in range(m.body_v[i], m.body_v[i] + n):
            count += 1 if d.kept[v] > 0.0 else 0

        held = m.body_drive[i] >= 0 or count == n
        d.held[i] = 1.0 if held else 0.0
        partly = partly or (count > 0 and not held)

    return partly


@kernel
def weigh_parts(m, d):
    """Weights for joints that are kept in part alone."""
    for i in range(1, m.n_body):
        inertia = d.body_I[6 * i] + d.body_I[6 * i + 1] + d.body_I[6 * i + 2]

        for k in range(joints.n_v(m.body_joint[i])):
            v = m.body_v[i] + k
            size = d.body_m[i] if joints.slides(m.body_joint[i], k) else inertia
            d.weight[v] = HEAVY * size if d.kept[v] > 0.0 and d.held[i] == 0.0 else 0.0

    d.weighs[0] = PARTS


@kernel
def weigh_all(m, d, what):
    """The metric of the coordinates themselves (rad, or parts of the scene's length), given and kept ones heavy."""
    mass = 0.0

    for i in range(1, m.n_body):
        mass += d.body_m[i]

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i])):
            v = m.body_v[i] + k
            size = mass if joints.slides(m.body_joint[i], k) else mass * m.scene_length[0] * m.scene_length[0]
            factor = GIVEN if (m.v_given[v] // what) % 2 == 1 else 1.0
            d.weight[v] = UNIFORM * size * (HEAVY if d.kept[v] > 0.0 else factor)

    d.weighs[0] = ALL


@inlined
def begin(m, d, what):
    """Hold joints, and weigh what cannot be held. Returns whether a joint is kept in part."""
    partly = hold(m, d)

    if d.weighs[0] == ALL:
        weigh_all(m, d, what)
    elif partly:
        weigh_parts(m, d)

    return partly


@inlined
def direction(m, d, i, k):
    """What coordinate k of a spherical or free joint's start values is of the body's motion: its rate is w.c + r'.e.

    Returns (c, e) in inertial axes, r' of the body's origin. Needs kinematics.
    """
    kind = m.body_joint[i]
    A = al.mat3(d.A, i)
    q = m.body_q[i] + joints.E_offset(kind)
    F = al.mat_mat(A, al.transpose(al.E_matrix(al.E_at(d.q, q))))
    reverse = m.body_reversed[i] == 1
    first, second = (A, F) if reverse else (F, A)

    if joints.slides(kind, k):
        e = al.column(first, k)

        if not reverse:
            return al.ZERO3, e

        return al.cross(al.mat_vec(F, al.vec_at(d.q, m.body_q[i])), e), al.neg(e)

    return al.column(second if m.body_spins[i] == 1 else first, k % 3), al.ZERO3


@kernel
def add_weights(m, d):
    """The weights of spherical and free joints to I_a, H_a, M_a of their bodies; needs kinematics."""
    for i in range(1, m.n_body):
        kind = m.body_joint[i]

        if joints.E_offset(kind) < 0:
            continue

        for k in range(joints.n_v(kind)):
            weight = d.weight[m.body_v[i] + k]
            c, e = direction(m, d, i, k)
            al.set_sym3(d.I_a, i, al.sym_add(al.sym3(d.I_a, i), al.sym_outer(weight, c)))
            al.set_mat3(d.H_a, i, al.mat_add(al.mat3(d.H_a, i), al.outer(al.scale(weight, c), e)))
            al.set_sym3(d.M_a, i, al.sym_add(al.sym3(d.M_a, i), al.sym_outer(weight, e)))


@inlined
def put_back(m, d, what):
    """Kept coordinates of joints kept in part to their start values. Returns the largest that one was off (SI)."""
    off = 0.0

    for i in range(1, m.n_body):
        kind = m.body_joint[i]

        if d.held[i] > 0.0 or joints.E_offset(kind) < 0:
            continue

        for k in range(joints.n_v(kind)):
            v = m.body_v[i] + k

            # an orientation is kept as a whole
            if d.kept[v] == 0.0 or (what == POSITION and not joints.slides(m.body_joint[i], k) and k % 3 > 0):
                continue

            off = max(off, joints.put_back(m, d, i, k, what == POSITION))

    return off


@inlined
def deviation(m, d, i, k, what):
    """How far (rad, rad/s, or parts of the scene's length) coordinate k of body i's joint is from its start value."""
    kind = m.body_joint[i]
    scale = 1.0 / m.scene_length[0] if joints.slides(m.body_joint[i], k) else 1.0

    if joints.is_one_axis(kind):
        if what == POSITION:
            return scale * abs(d.q[m.body_q[i]] - m.q_start[m.body_q[i]])

        return scale * abs(d.v[m.body_v[i]] - m.v_start[m.body_v[i]])

    return scale * abs(joints.off_start(m, d, i, k, what == POSITION))
