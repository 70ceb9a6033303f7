"""Added mass (docs/theory.md 16.9): the inertia of the water that moves along with the second marker's body.

The water is at rest in the ground, so velocities and accelerations are those seen from there. P is the second marker's origin,
V = (w, v_P) with v_P that of the material point. The 6x6 matrix A is given in one of three systems of axes:

FIRST, the first marker's, which do not turn: wrench about P = -A (alpha, v_P'), as in linear theory of bodies at the surface; A is
    constant and no product of velocities acts.
HEADING, those turned about z by the body's yaw psi, A(psi): wrench = -(A V' + psi' A_psi V - 1/2 V^T A_psi V grad psi), the
    Lagrangian equation of psi and P, A_psi = dA/dpsi. In plane motion it is that of BODY.
BODY, the second marker's, for a body deep in water: Kirchhoff's equations (Lamb, Hydrodynamics, section 124).

All three keep the energy 1/2 V^T A V + what acts on the body. In `dynamics/inertia.py` it is part of the body's inertia (I, H, M), about the origin.
"""

from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import markers
from ..signatures import DATA, MODEL, void
from . import six_by_six
from .six_by_six import BODY, FIRST, HEADING


@inlined
def is_in_moving_water(m, k):
    """Whether force k has added mass, and the ground is one that moves."""
    return m.six_by_six_adds[k] == 1 and m.marker_body[m.six_by_six_from[k]] > 0


@inlined
def axes(m, d, k):
    """Rotation to O of the axes in which the prepared blocks of force k are: of the ground, its first marker, or its body."""
    if m.six_by_six_axes[k] == BODY:
        return al.mat3(d.A, m.marker_body[m.six_by_six_to[k]])

    if m.six_by_six_axes[k] == HEADING:
        moved, turned, columns = six_by_six.displacement(m, d, k)
        return al.mat_mat(
            markers.axes(m, d, m.six_by_six_from[k]), six_by_six.turned_axes(m, d, k, turned[2])
        )

    return al.mat3(d.A, m.marker_body[m.six_by_six_from[k]])


@inlined
def blocks(m, d, k):
    """(I, H, M) of force k's added mass in inertial axes about its body's origin.

    With P at p: M' = M, H' = H + p~ M, I' = I + p~ H^T - H' p~.
    """
    I = al.sym3(d.added_I, k)
    H = al.mat3(d.added_H, k)
    M = al.sym3(d.added_M, k)

    # the axes of a ground that stands still are the inertial ones
    if m.six_by_six_axes[k] != FIRST or is_in_moving_water(m, k):
        A = axes(m, d, k)
        I = al.sym_rotate(A, I)
        H = al.mat_mat(al.mat_mat(A, H), al.transpose(A))
        M = al.sym_rotate(A, M)

    p = markers.arm(m, d, m.six_by_six_to[k])
    shifted = al.mat_add(H, al.cross_mat(p, al.mat_of_sym(M)))
    turned = al.mat_add(
        al.cross_mat(p, al.transpose(H)), al.transpose(al.cross_mat(p, al.transpose(shifted)))
    )
    return al.sym_add(I, al.sym_of_mat(turned)), shifted, M


@inlined
def wrench(I, H, M, w, v):
    """(moment, force) of the 6x6 matrix with blocks I, H, M times (w, v)."""
    return al.add(al.sym_vec(I, w), al.mat_vec(H, v)), al.add(al.matT_vec(H, w), al.sym_vec(M, v))


@inlined
def push(H, M, v):
    """`wrench` at w = 0, of blocks H, M."""
    return al.mat_vec(H, v), al.sym_vec(M, v)


@inlined
def carried(m, d, k):
    """(angular velocity, velocity) of the ground at the origin of force k's body."""
    g = m.marker_body[m.six_by_six_from[k]]
    return al.vec3(d.w, g), markers.point_velocity(m, d, g, al.vec3(d.r, m.marker_body[m.six_by_six_to[k]]))


@inlined
def swept(m, d, k, w, v):
    """(b, c) of alpha + b and rdd + c, the accelerations of force k's body as they are seen from a ground that moves.

    w, v : its velocities seen from there. The ground's own accelerations are given: its biases.
    """
    g = m.marker_body[m.six_by_six_from[k]]
    w_g = al.vec3(d.w, g)
    arm = al.sub(al.vec3(d.r, m.marker_body[m.six_by_six_to[k]]), al.vec3(d.r, g))
    c = al.add(
        al.cross(al.vec3(d.bias_w, g), arm), al.cross(w_g, al.add(al.cross(w_g, arm), al.scale(2.0, v)))
    )
    return al.neg(al.add(al.vec3(d.bias_w, g), al.cross(w_g, w))), al.neg(al.add(al.vec3(d.bias_r, g), c))


@inlined
def still_bias(m, d, k, I, H, M, w, v):
    """`bias` in water that stands still. w, v : velocities of the body."""
    if m.six_by_six_axes[k] == BODY:
        # the momenta's body-fixed part sees rdd - w x rd
        L, momentum = wrench(I, H, M, w, v)
        moment, force = push(H, M, al.cross(w, v))
        turned = al.add(al.cross(w, L), al.cross(v, momentum))
        return al.sub(turned, moment), al.sub(al.cross(w, momentum), force)

    # P is a material point
    p = markers.arm(m, d, m.six_by_six_to[k])
    moment, force = push(H, M, al.cross(w, al.cross(w, p)))

    if m.six_by_six_axes[k] == HEADING:
        L, momentum = wrench(I, H, M, w, v)
        z, yaw = heading(m, d, k)
        v_P = al.add(v, al.cross(w, p))
        L_P = al.sub(L, al.cross(p, momentum))
        w_z = al.cross(z, w)
        back, back_force = wrench(I, H, M, w_z, al.sub(al.cross(z, v_P), al.cross(w_z, p)))
        turned_force = al.cross(z, momentum)
        turned = al.add(al.cross(z, L_P), al.cross(p, turned_force))
        rate = al.dot(yaw, w)
        lift = al.dot(z, al.add(al.cross(v_P, momentum), al.cross(w, L_P)))
        moment = al.add(moment, al.axpy(rate, al.sub(turned, back), al.scale(lift, yaw)))
        force = al.axpy(rate, al.sub(turned_force, back_force), force)

    return moment, force


@inlined
def heading(m, d, k):
    """(z axis of force k's first marker, gradient of the yaw psi: psi' = gradient . w), inertial axes."""
    A = markers.axes(m, d, m.six_by_six_from[k])
    moved, turned, columns = six_by_six.displacement(m, d, k)
    return (A[0][2], A[1][2], A[2][2]), al.mat_vec(
        A, six_by_six.moment_of_swing_twist(columns, (0.0, 0.0, 1.0))
    )


@inlined
def bias(m, d, k, I, H, M):
    """(moment, force) about its body's origin that force k's added mass, of blocks I, H, M, needs at zero alpha and rdd."""
    i = m.marker_body[m.six_by_six_to[k]]
    w = al.vec3(d.w, i)
    v = al.vec3(d.rd, i)

    if not is_in_moving_water(m, k):
        return still_bias(m, d, k, I, H, M, w, v)

    w_g, v_g = carried(m, d, k)
    w = al.sub(w, w_g)
    v = al.sub(v, v_g)
    b, c = swept(m, d, k, w, v)
    moment, force = wrench(I, H, M, b, c)
    still_moment, still_force = still_bias(m, d, k, I, H, M, w, v)
    return al.add(moment, still_moment), al.add(force, still_force)


@apart(void(MODEL, DATA))
def add(m, d):
    """Onto I, H, M and bias wrenches of the bodies."""
    for k in range(m.n_six_by_six):
        i = m.marker_body[m.six_by_six_to[k]]

        if m.six_by_six_adds[k] == 0:
            continue

        I, H, M = blocks(m, d, k)
        al.set_sym3(d.I, i, al.sym_add(al.sym3(d.I, i), I))
        al.set_mat3(d.H, i, al.mat_add(al.mat3(d.H, i), H))
        al.set_sym3(d.M, i, al.sym_add(al.sym3(d.M, i), M))
        moment, force = bias(m, d, k, I, H, M)
        al.add_vec3(d.bias_moment, i, moment)
        al.add_vec3(d.bias_force, i, force)


@kernel
def add_reactions(m, d):
    """What the added masses exert on the ground, the contrary of what they exert on the bodies, to its applied wrench.

    Needs accelerations; once after `inertias`.
    """
    for k in range(m.n_six_by_six):
        if m.six_by_six_adds[k] == 1:
            i = m.marker_body[m.six_by_six_to[k]]
            I, H, M = blocks(m, d, k)
            moment, force = wrench(I, H, M, al.vec3(d.alpha, i), al.vec3(d.rdd, i))
            bias_moment, bias_force = bias(m, d, k, I, H, M)
            moment = al.add(moment, bias_moment)
            markers.add_wrench(
                m, d, m.marker_body[m.six_by_six_from[k]], al.vec3(d.r, i), moment, al.add(force, bias_force)
            )


@inlined
def borne(m, d, k):
    """(angular about its body's origin, linear) momentum that force k's added mass has less for the ground's own motion."""
    I, H, M = blocks(m, d, k)
    w_g, v_g = carried(m, d, k)
    return wrench(I, H, M, w_g, v_g)
