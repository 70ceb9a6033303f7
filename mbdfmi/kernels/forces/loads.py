"""Wrenches on markers, constant or over time (docs/theory.md 16.8)."""

from ..language import inlined
from ..math import algebra as al
from ..math import tables
from ..motion import markers


@inlined
def table_vector(m, k, x):
    """The vector of the three tables from k on, at x."""
    return (tables.evaluate(m, k, x)[0], tables.evaluate(m, k + 1, x)[0], tables.evaluate(m, k + 2, x)[0])


@inlined
def wrench(m, d, k):
    """Load k now: (moment N m, force N), inertial axes."""
    force = al.vec3(m.load_force, k)
    moment = al.vec3(m.load_moment, k)

    if m.load_force_table[k] >= 0:
        force = table_vector(m, m.load_force_table[k], d.now[0])

    if m.load_moment_table[k] >= 0:
        moment = table_vector(m, m.load_moment_table[k], d.now[0])

    A = markers.axes(m, d, m.load_axes[k])
    return al.mat_vec(A, moment), al.mat_vec(A, force)


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_load):
        moment, force = wrench(m, d, k)
        b = m.load_marker[k]
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), moment, force)


@inlined
def power_of(m, d, k):
    """W, of load k on the bodies."""
    moment, force = wrench(m, d, k)
    return markers.power(m, d, m.load_marker[k], moment, force)


@inlined
def power(m, d):
    """W, on the bodies: all of it is supplied."""
    total = 0.0

    for k in range(m.n_load):
        total += power_of(m, d, k)

    return total
