"""Revolute and prismatic joints: one freedom about, or along, the z axis of the joint frame F.

S = (axis, 0) or (0, axis); U = I_a S, D = S^T U (+ its weight), u = tau - S^T p_a (docs/theory.md 6.2).
"""

import math

from ..language import inlined
from ..math import algebra as al
from ..status import OK
from . import passing, rotors, virtual
from .kinds import PRISMATIC, REVOLUTE


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
def move_revolute(m, d, i, F, w_parent, arm):
    """Orientation, angular velocity and bias of body i; F is turned already. Returns (arm, relative velocity, bias) of its origin."""
    axis = al.column(F, 2)
    w_rel = al.scale(d.v[m.body_v[i]], axis)
    al.set_vec3(d.axis, i, axis)
    al.set_mat3(d.A, i, F)
    al.set_vec3(d.w, i, al.add(w_parent, w_rel))
    al.set_vec3(d.bias_w, i, al.cross(w_parent, w_rel))
    spin = al.cross(w_parent, arm)
    return arm, spin, al.cross(w_parent, spin)


@inlined
def move_prismatic(m, d, i, F, w_parent, arm):
    """The same along the axis."""
    axis = al.column(F, 2)
    rd_rel = al.scale(d.v[m.body_v[i]], axis)
    arm = al.axpy(d.q[m.body_q[i]], axis, arm)
    al.set_vec3(d.axis, i, axis)
    al.set_mat3(d.A, i, F)
    al.set_vec3(d.w, i, w_parent)
    al.set_vec3(d.bias_w, i, al.ZERO3)
    spin = al.cross(w_parent, arm)
    return arm, al.add(spin, rd_rel), al.cross(w_parent, al.axpy(2.0, rd_rel, spin))


@inlined
def subspace(m, d, i, k):
    """The column of S: (angular, linear)."""
    axis = al.vec3(d.axis, i)
    return (axis, al.ZERO3) if m.body_joint[i] == REVOLUTE else (al.ZERO3, axis)


@inlined
def position_rates(m, d, i):
    """q' = v."""
    d.q_rate[m.body_q[i]] = d.v[m.body_v[i]]


@inlined
def start(m, d, i):
    """Start values into d.q and d.v. Returns True: all will do."""
    d.q[m.body_q[i]] = m.q_start[m.body_q[i]]
    d.v[m.body_v[i]] = m.v_start[m.body_v[i]]
    return True


@inlined
def retract(m, d, i, factor):
    """q moved along d.change, as if it were v for a time `factor`."""
    d.q[m.body_q[i]] += factor * d.change[m.body_v[i]]


@inlined
def weigh(m, d, i, rotation):
    """Error weights: an angle's is that of a rotation."""
    if m.body_joint[i] == REVOLUTE:
        d.x_scale[m.body_q[i]] = rotation


@inlined
def relative_E(m, d, i):
    """Euler parameters of the body relative to F; continuous in time."""
    if m.body_joint[i] == PRISMATIC:
        return al.E_IDENTITY

    return (0.0, 0.0, math.sin(0.5 * d.q[m.body_q[i]]), math.cos(0.5 * d.q[m.body_q[i]]))


@inlined
def articulate(m, d, i, I, H, M, moment, force):
    """U, D and u of the joint from the articulated inertia (I, H, M) and bias wrench of body i, both passed on to the parent.

    Returns a status. The bias on the whole inertia, which is known before D, goes to the parent less what the joint gives way.
    """
    revolute = m.body_joint[i] == REVOLUTE
    v = m.body_v[i]
    axis = al.vec3(d.axis, i)

    if revolute:
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

    if rotors.has(m, i):
        U_w = al.axpy(rotors.coupling(m, i), axis, U_w)
        D += rotors.inertia(m, i)

    if not D > al.ROUNDING * most:
        more = virtual.lend(m, d, i, not revolute) if lacks(D, most) else 0.0

        if more == 0.0:
            return passing.no_inertia(d.I_a[6 * i], i)

        D += more
        I = al.sym3(d.I_a, i)
        M = al.sym3(d.M_a, i)

        if revolute:
            U_w = al.axpy(more, axis, U_w)
        else:
            U_r = al.axpy(more, axis, U_r)

    D += d.weight[v]
    al.set_vec3(d.U_w, i, U_w)
    al.set_vec3(d.U_r, i, U_r)
    d.D[6 * i] = D
    d.effort[3 * i] = effort
    parent = m.body_parent[i]

    if parent > 0:
        arm = al.vec3(d.arm, i)
        bias_w = al.vec3(d.bias_w, i)
        bias_r = al.vec3(d.bias_r, i)
        left = effort - al.dot(U_w, bias_w) - al.dot(U_r, bias_r)
        inverse = 1.0 / D
        W_w = al.scale(inverse, U_w)
        W_r = al.scale(inverse, U_r)
        moment = al.add(moment, al.add(al.sym_vec(I, bias_w), al.mat_vec(H, bias_r)))
        moment = al.axpy(left, W_w, moment)
        force = al.add(force, al.add(al.matT_vec(H, bias_w), al.sym_vec(M, bias_r)))
        force = al.axpy(left, W_r, force)
        I = al.sym_sub(I, al.sym_outer(inverse, U_w))
        H = al.mat_sub(H, al.outer(W_w, U_r))
        M = al.sym_sub(M, al.sym_outer(inverse, U_r))
        passing.add_inertia(d, parent, arm, I, H, M)
        passing.add_wrench(d, parent, arm, moment, force)

    return OK


@inlined
def lacks(D, most):
    """Whether D is nothing but rounding of numbers of the size of `most`: no inertia, but no negative one either."""
    return abs(D) <= 100.0 * al.ROUNDING * most


@inlined
def give_way(m, d, i, rate, alpha, rdd):
    """(alpha, rdd) with the joint's acceleration `rate` along its axis."""
    axis = al.vec3(d.axis, i)

    if m.body_joint[i] == REVOLUTE:
        return al.axpy(rate, axis, alpha), rdd

    return alpha, al.axpy(rate, axis, rdd)


@inlined
def accelerate(m, d, i, alpha, rdd):
    """v' = (u - U^T a) / D into d.v_rate; (alpha, rdd) of the body from those with the joint at rest."""
    carried = al.dot(al.vec3(d.U_w, i), alpha) + al.dot(al.vec3(d.U_r, i), rdd)
    rate = (d.effort[3 * i] - carried) * (1.0 / d.D[6 * i])  # the division does not wait for the parent
    d.v_rate[m.body_v[i]] = rate
    return give_way(m, d, i, rate, alpha, rdd)


@inlined
def pass_wrench(m, d, p, i, at, coefficient):
    """Whitened response D^-1/2 S^T f of the joint to p[at]. Returns what it does not give way to: (True: something, moment, force)."""
    moment = al.vec3(d.passed_moment, i)
    force = al.vec3(d.passed_force, i)
    e = coefficient + al.dot(al.vec3(d.axis, i), moment if m.body_joint[i] == REVOLUTE else force)
    inverse = 1.0 / d.D[6 * i]
    p[at] = e * math.sqrt(inverse)
    taken = -(e * inverse)
    moment = al.add(moment, al.scale(taken, al.vec3(d.U_w, i)))
    return True, moment, al.add(force, al.scale(taken, al.vec3(d.U_r, i)))


@inlined
def respond(m, d, i, alpha, rdd):
    """Change of v' by the whitened effort into d.change; (alpha, rdd) of the body from those with the joint at rest."""
    v = m.body_v[i]
    inverse = 1.0 / d.D[6 * i]
    carried = al.dot(al.vec3(d.U_w, i), alpha) + al.dot(al.vec3(d.U_r, i), rdd)
    rate = d.white[v] * math.sqrt(inverse) - carried * inverse
    d.change[v] = rate
    return give_way(m, d, i, rate, alpha, rdd)


@inlined
def compliance(m, d, i, square):
    """What a unit moment, and a unit force at arms of this square (m2), could do in the joint."""
    return (1.0 + square if m.body_joint[i] == REVOLUTE else 1.0) * (1.0 / d.D[6 * i])


@inlined
def largest_effort(kind, moment, force, lever):
    """Square of what a wrench could be as effort in the joint if it met the axis as well as it can.

    lever : m, from the joint to where the force acts.
    """
    square = al.dot(force, force)

    if kind == PRISMATIC:
        return square

    return al.dot(moment, moment) + square * al.dot(lever, lever)
