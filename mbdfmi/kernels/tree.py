"""Kinematics and dynamics of the spanning tree: RNEA, CRBA, ABA.

After Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 5 to 7, with every spatial quantity in
inertial axes about the origin of its own body, and with classical instead of spatial accelerations (so that
`alpha` and `rdd` are what an accelerometer at the origin shows). Transforms between bodies are then
pure shifts by `arm`.

Legend: I, H, M blocks of a 6x6 inertia: moment = I alpha + H rdd, force = H^T alpha + M rdd; suffix _a:
articulated (ABA) or composite (CRBA). For a rigid body H = h x, M = m 1. S motion subspace, U = I_a S, D = S^T U.
Indices: i body, parent its parent.
"""

from numba.types import int64, void

from . import added_mass, holding, joints, passing, virtual
from . import algebra as al
from .language import apart, inlined, kernel
from .status import OK
from .views import DATA, MODEL


@apart(void(MODEL, DATA))
def kinematics(m, d):
    """Poses, velocities and biases of all bodies from d.x."""
    al.set_vec3(d.r, 0, al.ZERO3)
    al.set_vec3(d.rd, 0, al.ZERO3)
    al.set_vec3(d.w, 0, al.ZERO3)
    al.set_mat3(d.A, 0, al.IDENTITY3)

    for i in range(1, m.n_body):
        joints.move(m, d, i)

        if d.held[i] > 0.0:
            joints.add_given_acceleration(m, d, i)


@inlined
def momentum(m, d, i):
    """(angular about the body's origin, linear) momentum of body i, added mass in still water included."""
    w = al.vec3(d.w, i)
    rd = al.vec3(d.rd, i)
    I = al.sym3(d.I, i)

    if m.body_added[i] == 1:
        H = al.mat3(d.H, i)
        return (
            al.add(al.sym_vec(I, w), al.mat_vec(H, rd)),
            al.add(al.matT_vec(H, w), al.sym_vec(al.sym3(d.M, i), rd)),
        )

    h = al.vec3(d.h, i)
    return (
        al.add(al.sym_vec(I, w), al.cross(h, rd)),
        al.add(al.cross(w, h), al.scale(d.body_m[i], rd)),
    )


@apart(void(MODEL, DATA))
def inertias(m, d):
    """Inertias in inertial axes, velocity-dependent bias wrenches; starts the applied wrench with weight.

    Added mass is inertia as well, but has no weight.
    """
    g = al.vec3(m.gravity, 0)
    al.set_vec3(d.moment, 0, al.ZERO3)
    al.set_vec3(d.force, 0, al.ZERO3)

    for i in range(1, m.n_body):
        A = al.mat3(d.A, i)
        w = al.vec3(d.w, i)
        mass = d.body_m[i]
        h = al.mat_vec(A, al.vec3(d.body_h, i))
        al.set_vec3(d.h, i, h)
        al.set_vec3(d.moment, i, al.cross(h, g))
        al.set_vec3(d.force, i, al.scale(mass, g))
        I = al.sym_rotate(A, al.sym3(d.body_I, i))
        al.set_sym3(d.I, i, I)
        al.set_vec3(d.bias_moment, i, al.cross(w, al.sym_vec(I, w)))
        al.set_vec3(d.bias_force, i, al.cross(w, al.cross(w, h)))

        if m.body_added[i] == 1:
            al.set_mat3(d.H, i, al.skew(h))
            al.set_sym3(d.M, i, (mass, mass, mass, 0.0, 0.0, 0.0))

    added_mass.add(m, d)


@inlined
def inertia_blocks(m, d, i):
    """(I, H, M) of body i, in inertial axes about its origin."""
    if m.body_added[i] == 1:
        return (al.sym3(d.I, i), al.mat3(d.H, i), al.sym3(d.M, i))

    mass = d.body_m[i]
    return (al.sym3(d.I, i), al.skew(al.vec3(d.h, i)), (mass, mass, mass, 0.0, 0.0, 0.0))


@inlined
def start_articulated(m, d):
    """I_a, H_a, M_a of every body alone."""
    for i in range(1, m.n_body):
        I, H, M = inertia_blocks(m, d, i)
        al.set_sym3(d.I_a, i, I)
        al.set_mat3(d.H_a, i, H)
        al.set_sym3(d.M_a, i, M)

    if d.lends[0] > 0.0:
        virtual.add(m, d)

    if d.weighs[0] > 0.0:
        holding.add_weights(m, d)


@apart(int64(MODEL, DATA))
def aba(m, d):
    """Forward dynamics by articulated bodies: v' into d.x_rate, alpha and rdd of all bodies. Returns a status.

    Needs kinematics, inertias, the applied wrenches (moment, force) and joint efforts tau (Featherstone
    2008, table 7.1).
    """
    start_articulated(m, d)

    # articulated inertias and bias wrenches, leaves to root
    for i in range(m.n_body - 1, 0, -1):
        moment = al.sub(al.vec3(d.bias_moment, i), al.vec3(d.moment, i))
        force = al.sub(al.vec3(d.bias_force, i), al.vec3(d.force, i))
        failure = joints.articulate(m, d, i, moment, force)

        if failure != OK:
            return failure

    # accelerations, root to leaves
    al.set_vec3(d.alpha, 0, al.ZERO3)
    al.set_vec3(d.rdd, 0, al.ZERO3)

    for i in range(1, m.n_body):
        parent = m.body_parent[i]
        alpha_parent = al.vec3(d.alpha, parent)
        alpha = al.add(alpha_parent, al.vec3(d.bias_w, i))
        rdd = al.add(al.vec3(d.rdd, parent), al.cross(alpha_parent, al.vec3(d.arm, i)))
        rdd = al.add(rdd, al.vec3(d.bias_r, i))
        alpha, rdd = joints.accelerate(m, d, i, alpha, rdd)
        al.set_vec3(d.alpha, i, alpha)
        al.set_vec3(d.rdd, i, rdd)

    return OK


@kernel
def read_pivots(m, d, p):
    """The pivots of the joints' inertias that aba has left, to p[n_v]; 1 where joints are held."""
    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i])):
            p[m.body_v[i] + k] = 1.0 if d.held[i] > 0.0 else joints.pivot(m, d, i, k)


@kernel
def accelerations(m, d):
    """alpha and rdd of all bodies from the v' in d.x_rate; needs kinematics."""
    al.set_vec3(d.alpha, 0, al.ZERO3)
    al.set_vec3(d.rdd, 0, al.ZERO3)

    for i in range(1, m.n_body):
        parent = m.body_parent[i]
        alpha_parent = al.vec3(d.alpha, parent)
        alpha = al.add(alpha_parent, al.vec3(d.bias_w, i))
        rdd = al.add(al.vec3(d.rdd, parent), al.cross(alpha_parent, al.vec3(d.arm, i)))
        rdd = al.add(rdd, al.vec3(d.bias_r, i))

        # a given acceleration is in the bias already
        for k in range(joints.n_v(m.body_joint[i]) if d.held[i] == 0.0 else 0):
            S_w, S_r = joints.subspace(m, d, i, k)
            rate = d.x_rate[m.n_q + m.body_v[i] + k]
            alpha = al.axpy(rate, S_w, alpha)
            rdd = al.axpy(rate, S_r, rdd)

        al.set_vec3(d.alpha, i, alpha)
        al.set_vec3(d.rdd, i, rdd)


@apart(void(MODEL, DATA))
def joint_wrenches(m, d):
    """Wrench on every body through the joint to its parent, about the body's origin, into bias_moment and bias_force.

    What the accelerations alpha and rdd of all bodies need beside the applied wrenches; needs inertias.
    """
    added_mass.add_reactions(m, d)

    for i in range(1, m.n_body):
        alpha = al.vec3(d.alpha, i)
        rdd = al.vec3(d.rdd, i)
        I, H, M = inertia_blocks(m, d, i)
        moment = al.add(al.sym_vec(I, alpha), al.mat_vec(H, rdd))
        force = al.add(al.matT_vec(H, alpha), al.sym_vec(M, rdd))
        al.add_vec3(d.bias_moment, i, al.sub(moment, al.vec3(d.moment, i)))
        al.add_vec3(d.bias_force, i, al.sub(force, al.vec3(d.force, i)))

    for i in range(m.n_body - 1, 0, -1):
        if m.body_parent[i] > 0:
            moment = al.vec3(d.bias_moment, i)
            passing.add_wrench(d, m.body_parent[i], al.vec3(d.arm, i), moment, al.vec3(d.bias_force, i))


@kernel
def rnea(m, d, tau):
    """Inverse dynamics: the joint efforts tau[n_v] that give the v' in d.x_rate, beside the applied wrenches.

    Needs kinematics, inertias and the applied wrenches (Featherstone 2008, table 5.1).
    """
    accelerations(m, d)
    joint_wrenches(m, d)

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i])):
            S_w, S_r = joints.subspace(m, d, i, k)
            power = al.dot(S_w, al.vec3(d.bias_moment, i)) + al.dot(S_r, al.vec3(d.bias_force, i))
            tau[m.body_v[i] + k] = power


@kernel
def crba(m, d, mass_matrix):
    """Joint-space mass matrix [n_v * n_v], by rows, by composite bodies; needs kinematics and inertias.

    Featherstone 2008, table 6.2.
    """
    start_articulated(m, d)

    for k in range(m.n_v * m.n_v):
        mass_matrix[k] = 0.0

    for i in range(m.n_body - 1, 0, -1):
        I = al.sym3(d.I_a, i)
        H = al.mat3(d.H_a, i)
        M = al.sym3(d.M_a, i)

        if m.body_parent[i] > 0:
            passing.add_inertia(d, m.body_parent[i], al.vec3(d.arm, i), I, H, M)

        for k in range(joints.n_v(m.body_joint[i])):
            S_w, S_r = joints.subspace(m, d, i, k)
            column = m.body_v[i] + k
            moment = al.add(al.sym_vec(I, S_w), al.mat_vec(H, S_r))
            force = al.add(al.matT_vec(H, S_w), al.sym_vec(M, S_r))
            j = i

            while j > 0:
                for l in range(joints.n_v(m.body_joint[j])):
                    T_w, T_r = joints.subspace(m, d, j, l)
                    row = m.body_v[j] + l
                    value = al.dot(T_w, moment) + al.dot(T_r, force)
                    mass_matrix[m.n_v * row + column] = value
                    mass_matrix[m.n_v * column + row] = value

                moment = al.add(moment, al.cross(al.vec3(d.arm, j), force))
                j = m.body_parent[j]

    if d.weighs[0] > 0.0:
        for i in range(1, m.n_body):
            if joints.is_one_axis(m.body_joint[i]):
                mass_matrix[(m.n_v + 1) * m.body_v[i]] += d.weight[m.body_v[i]]


@kernel
def kinetic_energy(m, d):
    """Kinetic energy (J) of all bodies, that of the water moved with added mass included."""
    energy = 0.0

    for i in range(1, m.n_body):
        L, p = momentum(m, d, i)
        energy += 0.5 * (al.dot(al.vec3(d.w, i), L) + al.dot(al.vec3(d.rd, i), p))

    for k in range(m.n_linear):
        if added_mass.is_in_moving_water(m, k):
            i = m.marker_body[m.linear_to[k]]
            w, rd = added_mass.carried(m, d, k)
            L, p = added_mass.borne(m, d, k)
            energy -= al.dot(al.axpy(-0.5, w, al.vec3(d.w, i)), L) + al.dot(al.axpy(-0.5, rd, al.vec3(d.rd, i)), p)

    return energy


@kernel
def gravity_energy(m, d):
    """Potential energy (J) of the weight of all bodies, those that stand still too, zero at the origin of O."""
    g = al.vec3(m.gravity, 0)
    energy = -al.dot(g, al.vec3(d.body_h, 0))

    for i in range(1, m.n_body):
        energy -= d.body_m[i] * al.dot(g, al.vec3(d.r, i)) + al.dot(g, al.vec3(d.h, i))

    return energy


@kernel
def total_momentum(m, d):
    """(angular about O's origin, linear) momentum of all bodies that move, added mass included."""
    angular = al.ZERO3
    linear = al.ZERO3

    for i in range(1, m.n_body):
        L, p = momentum(m, d, i)
        angular = al.add(angular, al.add(L, al.cross(al.vec3(d.r, i), p)))
        linear = al.add(linear, p)

    for k in range(m.n_linear):
        if added_mass.is_in_moving_water(m, k):
            L, p = added_mass.borne(m, d, k)
            r = al.vec3(d.r, m.marker_body[m.linear_to[k]])
            angular = al.sub(angular, al.add(L, al.cross(r, p)))
            linear = al.sub(linear, p)

    return angular, linear


@kernel
def center_of_mass(m, d):
    """Centre of mass (m, in O) of all bodies, those that stand still too."""
    mass = d.body_m[0]
    moment = al.vec3(d.body_h, 0)

    for i in range(1, m.n_body):
        mass += d.body_m[i]
        moment = al.add(moment, al.axpy(d.body_m[i], al.vec3(d.r, i), al.vec3(d.h, i)))

    return al.scale(1.0 / mass, moment)
