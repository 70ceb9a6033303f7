"""Forces and moments on markers that are inputs (docs/theory.md 16.8)."""

from ..language import inlined
from ..math import algebra as al
from ..motion import markers


@inlined
def wrench(m, d, k):
    """Wrench input k now: (moment N m, force N), inertial axes."""
    force = al.ZERO3
    moment = al.ZERO3

    if m.wrench_force[k] >= 0:
        force = al.vec_at(d.input, m.wrench_force[k])

    if m.wrench_moment[k] >= 0:
        moment = al.vec_at(d.input, m.wrench_moment[k])

    if m.wrench_axes[k] >= 0:
        A = markers.axes(m, d, m.wrench_axes[k])
        force = al.mat_vec(A, force)
        moment = al.mat_vec(A, moment)

    return moment, force


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_wrench_input):
        b = m.wrench_marker[k]
        moment, force = wrench(m, d, k)
        r = markers.position(m, d, b)
        markers.add_wrench(m, d, m.marker_body[b], r, moment, force)

        if m.wrench_reaction[k] >= 0:
            markers.add_wrench(m, d, m.marker_body[m.wrench_reaction[k]], r, al.neg(moment), al.neg(force))


@inlined
def power(m, d):
    """W, on the bodies: all of it is supplied."""
    total = 0.0

    for k in range(m.n_wrench_input):
        b = m.wrench_marker[k]
        moment, force = wrench(m, d, k)
        total += markers.power(m, d, b, moment, force)

        if m.wrench_reaction[k] >= 0:
            i = m.marker_body[m.wrench_reaction[k]]
            total -= al.dot(moment, al.vec3(d.w, i))
            total -= al.dot(force, markers.point_velocity(m, d, i, markers.position(m, d, b)))

    return total
