"""What the waves that a body makes, and that it made before, do to it: linear memory by states (docs/theory.md 16.16).

x' = A x + B V, force on the body = -C x, V = (v_P, omega) of its marker P, all in axes of water_axes.py. A stands in pairs (sigma, omega) and
single poles: x_j' = sigma_j x_j + omega_j x_mate + B_j . V, omega of the two of a pair being of opposite sign and 0 of a single one.
Bodies that feel each other's waves share their states, each with rows of B and C of its own, and stand one after the other.
The states follow the angles outside the tree in z.
"""

from ..language import inlined
from ..math import algebra as al
from ..motion import markers
from . import water_axes


@inlined
def first(m):
    """Where the states stand in z."""
    return m.n_s + m.n_turn


@inlined
def reset(m, d):
    """At the start no wave was made."""
    for j in range(m.n_memory):
        d.z[first(m) + j] = 0.0


@inlined
def row_times(p, j, v, w):
    """Row j of a matrix of rows of 6 in p, times (v, w)."""
    k = 6 * j
    return (
        p[k] * v[0] + p[k + 1] * v[1] + p[k + 2] * v[2] + p[k + 3] * w[0] + p[k + 4] * w[1] + p[k + 5] * w[2]
    )


@inlined
def is_first(m, k):
    """Whether element k is the first of those that share its states."""
    return k == 0 or m.radiation_memory[k - 1] != m.radiation_memory[k]


@inlined
def state_rates(m, d):
    """x' of all of them into d.z_rate; needs kinematics."""
    z = first(m)

    for k in range(m.n_radiation):
        b = m.radiation_marker[k]
        v, w = water_axes.motion(m, d, m.radiation_axes[k], b)
        begin = m.radiation_memory[k]
        row = m.radiation_row[k] - begin
        leads = is_first(m, k)

        for j in range(begin, begin + m.radiation_memories[k]):
            driven = row_times(m.memory_from, row + j, v, w)

            if leads:
                own = m.memory_pole[2 * j] * d.z[z + j] + m.memory_pole[2 * j + 1] * d.z[z + m.memory_mate[j]]
                d.z_rate[z + j] = own + driven
            else:
                d.z_rate[z + j] += driven


@inlined
def wrench(m, d, k):
    """Of element k on its body at its marker: (moment N m, force N), inertial axes."""
    z = first(m)
    force = al.ZERO3
    moment = al.ZERO3
    begin = m.radiation_memory[k]
    row = m.radiation_row[k] - begin

    for j in range(begin, begin + m.radiation_memories[k]):
        x = -d.z[z + j]
        force = al.axpy(x, al.vec3(m.memory_to, 2 * (row + j)), force)
        moment = al.axpy(x, al.vec3(m.memory_to, 2 * (row + j) + 1), moment)

    return water_axes.out(m, d, m.radiation_axes[k], m.radiation_marker[k], moment, force)


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_radiation):
        moment, force = wrench(m, d, k)
        b = m.radiation_marker[k]
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), moment, force)


@inlined
def power_of(m, d, k):
    """W, of element k on its body."""
    moment, force = wrench(m, d, k)
    return markers.power(m, d, m.radiation_marker[k], moment, force)


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_radiation):
        total += power_of(m, d, k)

    return total


@inlined
def dissipated(m, d):
    """W, that waves carry off; negative while they bring some of it back."""
    return -power(m, d)
