"""The free joint: position and velocity in F, E and the angular velocity in the body's own axes.

The body takes all that acts on it: only the joint's own effort is passed on (docs/theory.md 6.3).
"""

from ..language import inlined, kernel
from ..math import algebra as al
from ..status import OK
from . import passing, spherical, told, virtual


@inlined
def move(m, d, i, F, w_parent, arm):
    """Orientation, angular velocity and bias of body i. Returns (arm, relative velocity, bias) of its origin."""
    q = m.body_q[i]
    v = m.body_v[i]
    rd_rel = al.mat_vec(F, al.vec_at(d.v, v))
    A = al.mat_mat(F, al.E_matrix(al.E_at(d.q, q + 3)))
    w_rel = al.mat_vec(A, al.vec_at(d.v, v + 3))
    arm = al.add(arm, al.mat_vec(F, al.vec_at(d.q, q)))
    al.set_mat3(d.joint_axes, i, F)
    al.set_mat3(d.A, i, A)
    al.set_vec3(d.w, i, al.add(w_parent, w_rel))
    al.set_vec3(d.bias_w, i, al.cross(w_parent, w_rel))
    spin = al.cross(w_parent, arm)
    return arm, al.add(spin, rd_rel), al.cross(w_parent, al.axpy(2.0, rd_rel, spin))


@inlined
def subspace(m, d, i, k):
    """Column k of S: (angular, linear)."""
    if k < 3:
        return al.ZERO3, al.column(al.mat3(d.joint_axes, i), k)

    return al.column(al.mat3(d.A, i), k - 3), al.ZERO3


@inlined
def position_rates(m, d, i):
    """r' = v, E' = L^T(E) w / 2."""
    q = m.body_q[i]
    v = m.body_v[i]
    al.set_vec_at(d.q_rate, q, al.vec_at(d.v, v))
    al.set_E_at(d.q_rate, q + 3, al.E_rate(al.E_at(d.q, q + 3), al.vec_at(d.v, v + 3)))


@inlined
def start(m, d, i):
    """Start values into d.q and d.v. Returns False where E has no length."""
    return told.start(m, d, i)


@inlined
def retract(m, d, i, factor):
    """Position and E moved along d.change, as if it were v for a time `factor`."""
    q = m.body_q[i]
    v = m.body_v[i]
    al.set_vec_at(d.q, q, al.axpy(factor, al.vec_at(d.change, v), al.vec_at(d.q, q)))
    spherical.turn_E(d, q + 3, v + 3, factor)


@inlined
def weigh(m, d, i, rotation):
    """Error weights: of E those of a rotation."""
    for k in range(3, 7):
        d.x_scale[m.body_q[i] + k] = rotation


@inlined
def relative_E(m, d, i):
    """Euler parameters of the body relative to F; continuous in time."""
    return al.E_at(d.q, m.body_q[i] + 3)


@inlined
def factor(d, i):
    """Factor the 6x6 inertia of the body: D_M of M, N = H M^-1, D of I - N H^T. True when positive."""
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
    left = (
        reduced[0] > al.ROUNDING * I[0]
        and reduced[1] > al.ROUNDING * I[1]
        and reduced[2] > al.ROUNDING * I[2]
    )
    al.set_sym3(d.D_M, i, F_M)
    al.set_mat3(d.N, i, N)
    al.set_sym3(d.D, i, F_I)
    return left and al.sym_is_positive(F_M) and al.sym_is_regular(reduced, F_I, I[0] + I[1] + I[2])


@kernel
def lend(m, d, i):
    """What the body lacks of mass and inertia is lent to it. True when `factor` finds enough then."""
    M = al.sym3(d.M_a, i)

    if not al.sym_is_positive(al.sym_factor(M)) and M[0] + M[1] + M[2] >= 0.0:
        virtual.lend(m, d, i, True)

        if factor(d, i):
            return True

    I = al.sym3(d.I_a, i)

    if I[0] + I[1] + I[2] >= 0.0:
        virtual.lend(m, d, i, False)

    return factor(d, i)


@inlined
def articulate(m, d, i, I, H, M, moment, force):
    """The factor and the wrench u = tau - p_a; the effort goes to the parent. Returns a status."""
    v = m.body_v[i]
    push = al.mat_vec(al.mat3(d.joint_axes, i), al.vec_at(d.tau, v))
    torque = al.mat_vec(al.mat3(d.A, i), al.vec_at(d.tau, v + 3))
    al.set_vec3(d.U_w, i, al.sub(torque, moment))
    al.set_vec3(d.U_r, i, al.sub(push, force))

    if not factor(d, i) and not lend(m, d, i):
        return passing.no_inertia(d.I_a[6 * i], i)

    if m.body_parent[i] > 0:
        passing.add_wrench(d, m.body_parent[i], al.vec3(d.arm, i), torque, push)

    return OK


@inlined
def accelerate(m, d, i, alpha, rdd):
    """v' into d.v_rate; (alpha, rdd) of the body from those with the joint at rest."""
    v = m.body_v[i]
    N = al.mat3(d.N, i)
    force = al.vec3(d.U_r, i)
    turned = al.sym_solve(al.sym3(d.D, i), al.sub(al.vec3(d.U_w, i), al.mat_vec(N, force)))
    moved = al.sub(al.sym_solve(al.sym3(d.D_M, i), force), al.matT_vec(N, turned))
    al.set_vec_at(d.v_rate, v, al.matT_vec(al.mat3(d.joint_axes, i), al.sub(moved, rdd)))
    al.set_vec_at(d.v_rate, v + 3, al.matT_vec(al.mat3(d.A, i), al.sub(turned, alpha)))
    return turned, moved


@inlined
def pass_wrench(m, d, p, i, at, coefficient):
    """Whitened response to p[at:]. Returns what is left of the wrench: nothing."""
    force = al.vec3(d.passed_force, i)
    left = al.sub(al.vec3(d.passed_moment, i), al.mat_vec(al.mat3(d.N, i), force))
    al.set_vec_at(p, at, al.sym_whiten(al.sym3(d.D_M, i), force))
    al.set_vec_at(p, at + 3, al.sym_whiten(al.sym3(d.D, i), left))
    return False, al.ZERO3, al.ZERO3


@inlined
def respond(m, d, i, alpha, rdd):
    """Change of v' by the whitened efforts into d.change; (alpha, rdd) of the body from those with the joint at rest."""
    v = m.body_v[i]
    turned = al.sym_unwhiten(al.sym3(d.D, i), al.vec_at(d.white, v + 3))
    moved = al.sym_unwhiten(al.sym3(d.D_M, i), al.vec_at(d.white, v))
    moved = al.sub(moved, al.matT_vec(al.mat3(d.N, i), turned))
    al.set_vec_at(d.change, v, al.matT_vec(al.mat3(d.joint_axes, i), al.sub(moved, rdd)))
    al.set_vec_at(d.change, v + 3, al.matT_vec(al.mat3(d.A, i), al.sub(turned, alpha)))
    return turned, moved


@inlined
def compliance(m, d, i, square):
    """What a unit moment, and a unit force at arms of this square (m2), could do in the joint, by its least pivots."""
    return (1.0 + square) * (1.0 / al.least_pivot(al.sym3(d.D, i))) + 1.0 / al.least_pivot(al.sym3(d.D_M, i))
