"""Water that two bodies move: added mass between them (docs/theory.md 16.16).

P and Q are the origins of two markers on different bodies, V = (v, omega) of the material points there in inertial axes. The 6x6
matrix A of a pair makes the wrench -A V_P' at Q, and -A^T V_Q' at P: together they are the derivative of the kinetic energy V_Q^T A V_P,
A constant. Such inertias lie off the tree, so only the joint-space mass matrix has a place for them (dynamics/embedding.py).
"""

from .. import joints
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import markers
from ..signatures import DATA, MODEL, REALS, void
from .six_by_six import six_times


@inlined
def column(p, k, c, a, b):
    """Element `c` of the transpose of the 6x6 matrix k of p times (a, b)."""
    j = 36 * k + c
    of_force = a[0] * p[j] + a[1] * p[j + 6] + a[2] * p[j + 12]
    return of_force + b[0] * p[j + 18] + b[1] * p[j + 24] + b[2] * p[j + 30]


@inlined
def back_times(p, k, a, b):
    """The transpose of the 6x6 matrix k of p times (a, b), as two vectors."""
    return (
        (column(p, k, 0, a, b), column(p, k, 1, a, b), column(p, k, 2, a, b)),
        (column(p, k, 3, a, b), column(p, k, 4, a, b), column(p, k, 5, a, b)),
    )


@inlined
def carried(m, d, i, c, b):
    """(velocity of marker b's origin, angular velocity) by coordinate c of body i's joint alone, which carries it."""
    turning, moving = joints.subspace(m, d, i, c)
    lever = al.sub(markers.position(m, d, b), al.vec3(d.r, i))
    return al.add(moving, al.cross(turning, lever)), turning


@apart(void(MODEL, DATA, REALS))
def add_to_mass_matrix(m, d, mass_matrix):
    """J_Q^T A J_P and its transpose onto the joint-space mass matrix [n_v * n_v]."""
    for k in range(m.n_shared_water):
        a = m.shared_from[k]
        b = m.shared_to[k]
        i = m.marker_body[a]

        while i > 0:
            for c in range(joints.n_v(m.body_joint[i])):
                v, w = carried(m, d, i, c, a)
                force, moment = six_times(m.shared_added, k, v, w)
                add_column(m, d, mass_matrix, b, m.body_v[i] + c, force, moment)

            i = m.body_parent[i]


@kernel
def add_column(m, d, mass_matrix, b, column, force, moment):
    """Efforts that a force and a moment at marker b are in the joints that carry it, onto a column, and onto the row of its number."""
    j = m.marker_body[b]

    while j > 0:
        for e in range(joints.n_v(m.body_joint[j])):
            v, w = carried(m, d, j, e, b)
            value = al.dot(v, force) + al.dot(w, moment)
            row = m.body_v[j] + e
            mass_matrix[m.n_v * row + column] += value
            mass_matrix[m.n_v * column + row] += value

        j = m.body_parent[j]


@inlined
def need(m, d, b, moment, force):
    """A wrench at marker b onto what its body needs (bias_moment, bias_force); the ground bears it, as that of other added mass."""
    i = m.marker_body[b]
    al.add_vec3(d.bias_moment, i, al.add(moment, al.cross(markers.arm(m, d, b), force)))
    al.add_vec3(d.bias_force, i, force)
    markers.add_wrench(m, d, 0, markers.position(m, d, b), moment, force)


@inlined
def material(m, d, b):
    """(acceleration of the point of its body at marker b, angular acceleration)."""
    i = m.marker_body[b]
    return markers.point_acceleration(m, d, i, markers.position(m, d, b)), al.vec3(d.alpha, i)


@apart(void(MODEL, DATA))
def add_needs(m, d):
    """Onto bias_moment and bias_force what the accelerations of all bodies need."""
    for k in range(m.n_shared_water):
        a = m.shared_from[k]
        b = m.shared_to[k]
        r, alpha = material(m, d, a)
        force, moment = six_times(m.shared_added, k, r, alpha)
        need(m, d, b, moment, force)
        r, alpha = material(m, d, b)
        force, moment = back_times(m.shared_added, k, r, alpha)
        need(m, d, a, moment, force)


@inlined
def at_second(m, d, k):
    """(linear, angular) momentum at the second marker by the velocities of the first one."""
    a = m.shared_from[k]
    return six_times(m.shared_added, k, markers.velocity(m, d, a), markers.angular_velocity(m, d, a))


@inlined
def at_first(m, d, k):
    """The same at the first one by the second."""
    b = m.shared_to[k]
    return back_times(m.shared_added, k, markers.velocity(m, d, b), markers.angular_velocity(m, d, b))


@inlined
def energy(m, d):
    """J, kinetic, of all of them."""
    total = 0.0

    for k in range(m.n_shared_water):
        linear, angular = at_second(m, d, k)
        b = m.shared_to[k]
        total += al.dot(markers.velocity(m, d, b), linear)
        total += al.dot(markers.angular_velocity(m, d, b), angular)

    return total


@inlined
def momentum(m, d, k):
    """(angular about O's origin, linear) of pair k."""
    p_b, L_b = at_second(m, d, k)
    p_a, L_a = at_first(m, d, k)
    L_b = al.add(L_b, al.cross(markers.position(m, d, m.shared_to[k]), p_b))
    L_a = al.add(L_a, al.cross(markers.position(m, d, m.shared_from[k]), p_a))
    return al.add(L_a, L_b), al.add(p_a, p_b)
