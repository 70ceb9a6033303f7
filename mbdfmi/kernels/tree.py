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

from . import added_mass, holding, joints, virtual
from . import algebra as al
from .language import apart, inlined, kernel
from .status import NOT_FINITE, OK, SINGULAR_INERTIA, status
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
def add_shifted_inertia(d, parent, r, I, H, M):
    """Add the inertia (I, H, M) of a child at arm r to the parent's I_a, H_a, M_a.

    [I H; H^T M] seen from the parent: K = H + r~ M, I' = I + r~ H^T - K r~ (entry ij: I_ij + (r x H_j)_i + (r x K_i)_j).
    """
    M_rows = al.mat_of_sym(M)
    rM = (
        al.sub(al.scale(r[1], M_rows[2]), al.scale(r[2], M_rows[1])),
        al.sub(al.scale(r[2], M_rows[0]), al.scale(r[0], M_rows[2])),
        al.sub(al.scale(r[0], M_rows[1]), al.scale(r[1], M_rows[0])),
    )
    K = al.mat_add(H, rM)
    rH_0 = al.cross(r, H[0])
    rH_1 = al.cross(r, H[1])
    rH_2 = al.cross(r, H[2])
    rK_0 = al.cross(r, K[0])
    rK_1 = al.cross(r, K[1])
    rK_2 = al.cross(r, K[2])
    shifted = (
        I[0] + rH_0[0] + rK_0[0],
        I[1] + rH_1[1] + rK_1[1],
        I[2] + rH_2[2] + rK_2[2],
        I[3] + rH_1[0] + rK_0[1],
        I[4] + rH_2[0] + rK_0[2],
        I[5] + rH_2[1] + rK_1[2],
    )
    al.set_sym3(d.I_a, parent, al.sym_add(al.sym3(d.I_a, parent), shifted))
    al.set_mat3(d.H_a, parent, al.mat_add(al.mat3(d.H_a, parent), K))
    al.set_sym3(d.M_a, parent, al.sym_add(al.sym3(d.M_a, parent), M))


@inlined
def add_shifted_wrench(d, parent, r, moment, force):
    """Add a child's bias wrench at arm r to the parent's."""
    al.add_vec3(d.bias_moment, parent, al.add(moment, al.cross(r, force)))
    al.add_vec3(d.bias_force, parent, force)


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


@inlined
def free_factor(d, i):
    """Factor the 6x6 inertia of a body on a free joint: D_M of M, N = H M^-1, D of I - N H^T. True when positive."""
    I = al.sym3(d.I_a, i)
    H = al.mat3(d.H_a, i)
    F_M = al.sym_factor(al.sym3(d.M_a, i))
    N = (al.sym_solve(F_M, H[0]), al.sym_solve(F_M, H[1]), al.sym_solve(F_M, H[2]))
    reduced = (
        I[0] - al.dot(H[0], N[0]),
        I[1] - al.dot(H[1], N[1]),
        I[2] - al.dot(H[2], N[2]),
        I[3] - al.dot(H[0], N[1]),
        I[4] - al.dot(H[0], N[2]),
        I[5] - al.dot(H[1], N[2]),
    )
    F_I = al.sym_factor(reduced)
    left = reduced[0] > al.ROUNDING * I[0] and reduced[1] > al.ROUNDING * I[1] and reduced[2] > al.ROUNDING * I[2]
    al.set_sym3(d.D_M, i, F_M)
    al.set_mat3(d.N, i, N)
    al.set_sym3(d.D, i, F_I)
    return left and al.sym_is_positive(F_M) and al.sym_is_regular(reduced, F_I, I[0] + I[1] + I[2])


@kernel
def lend_to_free(m, d, i):
    """What a body on a free joint lacks of mass and inertia is lent to it. True when free_factor finds enough then."""
    M = al.sym3(d.M_a, i)

    if not al.sym_is_positive(al.sym_factor(M)) and M[0] + M[1] + M[2] >= 0.0:
        virtual.lend(m, d, i, True)

        if free_factor(d, i):
            return True

    I = al.sym3(d.I_a, i)

    if I[0] + I[1] + I[2] >= 0.0:
        virtual.lend(m, d, i, False)

    return free_factor(d, i)


@inlined
def lacks(D, most):
    """Whether D is nothing but rounding of numbers of the size of `most`: no inertia, but no negative one either."""
    return abs(D) <= 100.0 * al.ROUNDING * most


@inlined
def no_inertia(D, i):
    """Status where the inertia D about body i's joint is not positive: a NaN comes from elsewhere."""
    return status(SINGULAR_INERTIA, i) if D == D else status(NOT_FINITE, 0)


@apart(int64(MODEL, DATA))
def aba(m, d):
    """Forward dynamics by articulated bodies: v' into d.x_rate, alpha and rdd of all bodies. Returns a status.

    Needs kinematics, inertias, the applied wrenches (moment, force) and joint efforts tau (Featherstone
    2008, table 7.1). For a spherical joint S^T I_a S is the whole rotational block, so only a mass at the
    joint is passed on; a free joint passes on its effort alone.
    """
    start_articulated(m, d)

    # articulated inertias and bias wrenches, leaves to root
    for i in range(m.n_body - 1, 0, -1):
        parent = m.body_parent[i]
        kind = m.body_joint[i]
        v = m.body_v[i]
        I = al.sym3(d.I_a, i)
        H = al.mat3(d.H_a, i)
        M = al.sym3(d.M_a, i)
        moment = al.sub(al.vec3(d.bias_moment, i), al.vec3(d.moment, i))
        force = al.sub(al.vec3(d.bias_force, i), al.vec3(d.force, i))
        arm = al.vec3(d.arm, i)
        bias_w = al.vec3(d.bias_w, i)
        bias_r = al.vec3(d.bias_r, i)

        if d.held[i] > 0.0:
            # its acceleration is known and part of the bias: the joint is rigid
            moment = al.add(moment, al.add(al.sym_vec(I, bias_w), al.mat_vec(H, bias_r)))
            force = al.add(force, al.add(al.matT_vec(H, bias_w), al.sym_vec(M, bias_r)))

            if parent > 0:
                add_shifted_inertia(d, parent, arm, I, H, M)
                add_shifted_wrench(d, parent, arm, moment, force)

        elif kind == joints.REVOLUTE or kind == joints.PRISMATIC:
            axis = al.vec3(d.axis, i)

            if kind == joints.REVOLUTE:
                U_w = al.sym_vec(I, axis)
                U_r = al.matT_vec(H, axis)
                D = al.dot(axis, U_w)
                effort = d.tau[v] - al.dot(axis, moment)
                most = I[0] + I[1] + I[2]
            else:
                U_w = al.mat_vec(H, axis)
                U_r = al.sym_vec(M, axis)
                D = al.dot(axis, U_r)
                effort = d.tau[v] - al.dot(axis, force)
                most = M[0] + M[1] + M[2]

            if not D > al.ROUNDING * most:
                more = virtual.lend(m, d, i, kind == joints.PRISMATIC) if lacks(D, most) else 0.0

                if more == 0.0:
                    return no_inertia(d.I_a[6 * i], i)

                D += more
                I = al.sym3(d.I_a, i)
                M = al.sym3(d.M_a, i)

                if kind == joints.REVOLUTE:
                    U_w = al.axpy(more, axis, U_w)
                else:
                    U_r = al.axpy(more, axis, U_r)

            D += d.weight[v]
            al.set_vec3(d.U_w, i, U_w)
            al.set_vec3(d.U_r, i, U_r)
            d.D[6 * i] = D
            d.effort[3 * i] = effort

            if parent > 0:
                # the bias on the whole inertia, which is known before D, less what the joint gives way
                left = effort - al.dot(U_w, bias_w) - al.dot(U_r, bias_r)
                W_w = al.scale(1.0 / D, U_w)
                W_r = al.scale(1.0 / D, U_r)
                moment = al.add(moment, al.add(al.sym_vec(I, bias_w), al.mat_vec(H, bias_r)))
                moment = al.axpy(left, W_w, moment)
                force = al.add(force, al.add(al.matT_vec(H, bias_w), al.sym_vec(M, bias_r)))
                force = al.axpy(left, W_r, force)
                I = al.sym_sub(I, al.sym_outer(1.0 / D, U_w))
                H = al.mat_sub(H, al.outer(W_w, U_r))
                M = al.sym_sub(M, al.sym_outer(1.0 / D, U_r))
                add_shifted_inertia(d, parent, arm, I, H, M)
                add_shifted_wrench(d, parent, arm, moment, force)

        elif kind == joints.SPHERICAL:
            torque = al.mat_vec(al.mat3(d.A, i), al.vec_at(d.tau, v))
            effort3 = al.sub(torque, moment)
            F = al.sym_factor(I)
            size = I[0] + I[1] + I[2]

            if not al.sym_is_regular(I, F, size):
                if not (size >= 0.0 and virtual.lend(m, d, i, False) > 0.0):
                    return no_inertia(size, i)

                I = al.sym3(d.I_a, i)
                F = al.sym_factor(I)

                if not al.sym_is_positive(F):
                    return no_inertia(size, i)

            al.set_sym3(d.D, i, F)
            al.set_vec3(d.effort, i, effort3)

            if parent > 0:
                H_T = al.transpose(H)
                N = al.transpose((al.sym_solve(F, H_T[0]), al.sym_solve(F, H_T[1]), al.sym_solve(F, H_T[2])))
                M = al.sym_sub(M, al.sym_of_mat(al.mat_mat(H_T, N)))
                force = al.add(force, al.sym_vec(M, bias_r))
                force = al.add(force, al.matT_vec(N, effort3))
                zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
                add_shifted_inertia(d, parent, arm, zero, (al.ZERO3, al.ZERO3, al.ZERO3), M)
                add_shifted_wrench(d, parent, arm, torque, force)

        else:
            F_axes = al.mat3(d.joint_axes, i)
            push = al.mat_vec(F_axes, al.vec_at(d.tau, v))
            torque = al.mat_vec(al.mat3(d.A, i), al.vec_at(d.tau, v + 3))
            al.set_vec3(d.U_w, i, al.sub(torque, moment))
            al.set_vec3(d.U_r, i, al.sub(push, force))

            if not free_factor(d, i) and not lend_to_free(m, d, i):
                return no_inertia(d.I_a[6 * i], i)

            if parent > 0:
                add_shifted_wrench(d, parent, arm, torque, push)

    # accelerations, root to leaves
    al.set_vec3(d.alpha, 0, al.ZERO3)
    al.set_vec3(d.rdd, 0, al.ZERO3)

    for i in range(1, m.n_body):
        parent = m.body_parent[i]
        kind = m.body_joint[i]
        v = m.n_q + m.body_v[i]
        alpha_parent = al.vec3(d.alpha, parent)
        alpha = al.add(alpha_parent, al.vec3(d.bias_w, i))
        rdd = al.add(al.vec3(d.rdd, parent), al.cross(alpha_parent, al.vec3(d.arm, i)))
        rdd = al.add(rdd, al.vec3(d.bias_r, i))

        if d.held[i] > 0.0:
            pass

        elif kind == joints.REVOLUTE or kind == joints.PRISMATIC:
            carried = al.dot(al.vec3(d.U_w, i), alpha) + al.dot(al.vec3(d.U_r, i), rdd)
            rate = (d.effort[3 * i] - carried) * (1.0 / d.D[6 * i])  # the division does not wait for the parent
            d.x_rate[v] = rate

            if kind == joints.REVOLUTE:
                alpha = al.axpy(rate, al.vec3(d.axis, i), alpha)
            else:
                rdd = al.axpy(rate, al.vec3(d.axis, i), rdd)

        elif kind == joints.SPHERICAL:
            left = al.sub(al.vec3(d.effort, i), al.mat_vec(al.mat3(d.H_a, i), rdd))
            turned = al.sym_solve(al.sym3(d.D, i), left)
            al.set_vec_at(d.x_rate, v, al.matT_vec(al.mat3(d.A, i), al.sub(turned, alpha)))
            alpha = turned

        else:
            N = al.mat3(d.N, i)
            force = al.vec3(d.U_r, i)
            turned = al.sym_solve(al.sym3(d.D, i), al.sub(al.vec3(d.U_w, i), al.mat_vec(N, force)))
            moved = al.sub(al.sym_solve(al.sym3(d.D_M, i), force), al.matT_vec(N, turned))
            F_axes = al.mat3(d.joint_axes, i)
            al.set_vec_at(d.x_rate, v, al.matT_vec(F_axes, al.sub(moved, rdd)))
            al.set_vec_at(d.x_rate, v + 3, al.matT_vec(al.mat3(d.A, i), al.sub(turned, alpha)))
            alpha = turned
            rdd = moved

        al.set_vec3(d.alpha, i, alpha)
        al.set_vec3(d.rdd, i, rdd)

    return OK


@kernel
def read_pivots(m, d, p):
    """The pivots of the joints' inertias that aba has left, to p[n_v]; 1 where joints are held."""
    for i in range(1, m.n_body):
        kind = m.body_joint[i]

        for k in range(joints.n_v(kind)):
            slides = kind == joints.FREE and k < 3
            pivot = d.D_M[6 * i + k] if slides else d.D[6 * i + k % 3]
            p[m.body_v[i] + k] = 1.0 if d.held[i] > 0.0 else pivot


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
            add_shifted_wrench(d, m.body_parent[i], al.vec3(d.arm, i), moment, al.vec3(d.bias_force, i))


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
            add_shifted_inertia(d, m.body_parent[i], al.vec3(d.arm, i), I, H, M)

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
            if m.body_joint[i] == joints.REVOLUTE or m.body_joint[i] == joints.PRISMATIC:
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
