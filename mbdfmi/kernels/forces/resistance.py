"""Damping of floating bodies beside the waves that they make (docs/theory.md 16.16).

F_i = -sum over j of (B_ij + Q_ij |V_j|) V_j with V = (v_P, omega) of the marker P, force and moment about it, in axes
of water_axes.py.
"""

from ..language import inlined
from ..math import algebra as al
from ..motion import markers
from . import six_by_six, water_axes


@inlined
def by_size(v):
    """Each component times its size."""
    return (abs(v[0]) * v[0], abs(v[1]) * v[1], abs(v[2]) * v[2])


@inlined
def wrench(m, d, k):
    """Of element k on its body at its marker: (moment N m, force N), inertial axes."""
    b = m.resistance_marker[k]
    v, w = water_axes.motion(m, d, m.resistance_axes[k], b)
    force, moment = six_by_six.six_times(m.resistance_linear, k, v, w)
    more_force, more_moment = six_by_six.six_times(m.resistance_quadratic, k, by_size(v), by_size(w))
    moment = al.neg(al.add(moment, more_moment))
    return water_axes.out(m, d, m.resistance_axes[k], b, moment, al.neg(al.add(force, more_force)))


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_resistance):
        moment, force = wrench(m, d, k)
        b = m.resistance_marker[k]
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), moment, force)


@inlined
def power_of(m, d, k):
    """W, of element k on its body."""
    moment, force = wrench(m, d, k)
    return markers.power(m, d, m.resistance_marker[k], moment, force)


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_resistance):
        total += power_of(m, d, k)

    return total


@inlined
def dissipated(m, d):
    """W, lost; negative where matrices give energy."""
    return -power(m, d)
