"""The spherical joint: E, and the angular velocity relative to the parent in the body's own axes.

S^T I_a S is the whole rotational block I, so only a mass at the joint is passed on to the parent
(docs/theory.md 6.3).
"""

import math

from ..language import inlined
from ..math import algebra as al
from ..status import OK
from . import passing, told, virtual


@inlined
def move(m, d, i, F, w_parent, arm):
    """Orientation, angular velocity and bias of body i. Returns (arm, relative velocity, bias) of its origin."""
    A = al.mat_mat(F, al.E_matrix(al.E_at(d.q, m.body_q[i])))
    w_rel = al.mat_vec(A, al.vec_at(d.v, m.body_v[i]))
    al.set_mat3(d.A, i, A)
    al.set_vec3(d.w, i, al.add(w_parent, w_rel))
    al.set_vec3(d.bias_w, i, al.cross(w_parent, w_rel))
    spin = al.cross(w_parent, arm)
    return arm, spin, al.cross(w_parent, spin)


@inlined
def subspace(m, d, i, k):
    """Column k of S: (angular, linear)."""
    return al.column(al.mat3(d.A, i), k), al.ZERO3


@inlined
def position_rates(m, d, i):
    """E' = L^T(E) w / 2."""
    q = m.body_q[i]
    al.set_E_at(d.q_rate, q, al.E_rate(al.E_at(d.q, q), al.vec_at(d.v, m.body_v[i])))


@inlined
def start(m, d, i):
    """Start values into d.q and d.v. Returns False where E has no length."""
    return told.start(m, d, i)


@inlined
def retract(m, d, i, factor):
    """E turned along d.change, as if it were w for a time `factor`."""
    turn_E(d, m.body_q[i], m.body_v[i], factor)


@inlined
def turn_E(d, q, v, factor):
    """E at d.q[q:] moved along its rate by d.change[v:], and made of unit length."""
    E = al.E_at(d.q, q)
    rate = al.E_rate(E, al.scale(factor, al.vec_at(d.change, v)))
    E = (E[0] + rate[0], E[1] + rate[1], E[2] + rate[2], E[3] + rate[3])
    al.set_E_at(d.q, q, al.E_scale(1.0 / math.sqrt(al.E_dot(E, E)), E))


@inlined
def weigh(m, d, i, rotation):
    """Error weights: those of a rotation."""
    for k in range(4):
        d.x_scale[m.body_q[i] + k] = rotation


@inlined
def relative_E(m, d, i):
    """Euler parameters of the body relative to F; continuous in time."""
    return al.E_at(d.q, m.body_q[i])


@inlined
def articulate(m, d, i, I, H, M, moment, force):
    """D = L D L^T of I, u = tau - p_a; M - H^T I^-1 H and the wrench go to the parent. Returns a status."""
    torque = al.mat_vec(al.mat3(d.A, i), al.vec_at(d.tau, m.body_v[i]))
    effort = al.sub(torque, moment)
    F = al.sym_factor(I)
    size = I[0] + I[1] + I[2]

    if not al.sym_is_regular(I, F, size):
        if not (size >= 0.0 and virtual.lend(m, d, i, False) > 0.0):
            return passing.no_inertia(size, i)

        I = al.sym3(d.I_a, i)
        F = al.sym_factor(I)

        if not al.sym_is_positive(F):
            return passing.no_inertia(size, i)

    al.set_sym3(d.D, i, F)
    al.set_vec3(d.effort, i, effort)
    parent = m.body_parent[i]

    if parent > 0:
        arm = al.vec3(d.arm, i)
        H_T = al.transpose(H)
        N = al.transpose((al.sym_solve(F, H_T[0]), al.sym_solve(F, H_T[1]), al.sym_solve(F, H_T[2])))
        M = al.sym_sub(M, al.sym_of_mat(al.mat_mat(H_T, N)))
        force = al.add(force, al.sym_vec(M, al.vec3(d.bias_r, i)))
        force = al.add(force, al.matT_vec(N, effort))
        zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        passing.add_inertia(d, parent, arm, zero, (al.ZERO3, al.ZERO3, al.ZERO3), M)
        passing.add_wrench(d, parent, arm, torque, force)

    return OK


@inlined
def lacks_inertia(d, i):
    """Whether the articulated inertia leaves a rotation without any (not: a negative or NaN one)."""
    I = al.sym3(d.I_a, i)
    size = I[0] + I[1] + I[2]
    return size >= 0.0 and not al.sym_is_regular(I, al.sym_factor(I), size)


@inlined
def accelerate(m, d, i, alpha, rdd):
    """v' into d.v_rate; (alpha, rdd) of the body from those with the joint at rest."""
    left = al.sub(al.vec3(d.effort, i), al.mat_vec(al.mat3(d.H_a, i), rdd))
    turned = al.sym_solve(al.sym3(d.D, i), left)
    al.set_vec_at(d.v_rate, m.body_v[i], al.matT_vec(al.mat3(d.A, i), al.sub(turned, alpha)))
    return turned, rdd


@inlined
def pass_wrench(m, d, p, i, at, coefficient):
    """Whitened response to p[at:]. Returns what is left of the wrench: (True: something, moment, force)."""
    F = al.sym3(d.D, i)
    e = al.vec3(d.passed_moment, i)
    al.set_vec_at(p, at, al.sym_whiten(F, e))
    taken = al.neg(al.matT_vec(al.mat3(d.H_a, i), al.sym_solve(F, e)))
    return True, al.ZERO3, al.add(al.vec3(d.passed_force, i), taken)


@inlined
def respond(m, d, i, alpha, rdd):
    """Change of v' by the whitened efforts into d.change; (alpha, rdd) of the body from those with the joint at rest."""
    v = m.body_v[i]
    F = al.sym3(d.D, i)
    turned = al.sym_unwhiten(F, al.vec_at(d.white, v))
    turned = al.sub(turned, al.sym_solve(F, al.mat_vec(al.mat3(d.H_a, i), rdd)))
    al.set_vec_at(d.change, v, al.matT_vec(al.mat3(d.A, i), al.sub(turned, alpha)))
    return turned, rdd


@inlined
def compliance(m, d, i, square):
    """What a unit moment, and a unit force at arms of this square (m2), could do in the joint, by its least pivot."""
    return (1.0 + square) * (1.0 / al.least_pivot(al.sym3(d.D, i)))
