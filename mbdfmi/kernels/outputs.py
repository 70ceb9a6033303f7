"""Outputs: blocks of scalars, each of a kind, about a body, a force or a pair of markers.

The pair (a, b) stands for "marker b relative to a, in a's axes"; absolute quantities are relative to marker 0.
"""

from . import algebra as al
from . import coordinates, forces, markers, tree
from .language import kernel

# of joint coordinate a
COORDINATE = 0
RATE = 1
ACCELERATION = 2
# of marker b relative to a, in a's axes
POSITION = 3
VELOCITY = 4
EULER_PARAMETERS = 5
ZYX = 6
OMEGA = 7
ALPHA = 8
# of marker b relative to a, in b's own axes
VELOCITY_BODY = 9
OMEGA_BODY = 10
# of force a
STRUT_LENGTH = 11
STRUT_FORCE = 12
# of the whole scene
KINETIC_ENERGY = 13
POTENTIAL_ENERGY = 14
TOTAL_ENERGY = 15

WIDTH = {EULER_PARAMETERS: 4}
WIDTH |= {kind: 3 for kind in (POSITION, VELOCITY, ZYX, OMEGA, ALPHA, VELOCITY_BODY, OMEGA_BODY)}
ACCELERATES = {ACCELERATION, ALPHA}


@kernel
def write_outputs(m, d, y):
    """All outputs into y[n_y]. Needs kinematics and, where an output is an acceleration, aba."""
    for k in range(m.n_output):
        kind = m.output_kind[k]
        a = m.output_a[k]
        b = m.output_b[k]
        at = m.output_y[k]

        if kind == COORDINATE:
            y[at] = coordinates.value(m, d, a)

        elif kind == RATE:
            y[at] = coordinates.rate(m, d, a)

        elif kind == ACCELERATION:
            y[at] = coordinates.acceleration(m, d, a)

        elif kind == POSITION:
            al.set_vec_at(y, at, markers.relative_position(m, d, a, b))

        elif kind == VELOCITY:
            al.set_vec_at(y, at, markers.relative_velocity(m, d, a, b))

        elif kind == EULER_PARAMETERS:
            relative = al.E_product(al.E_conjugate(markers.E(m, d, a)), markers.E(m, d, b))
            al.set_E_at(y, at, relative)

        elif kind == ZYX:
            al.set_vec_at(y, at, al.matrix_zyx(markers.relative_axes(m, d, a, b)))

        elif kind == OMEGA:
            al.set_vec_at(y, at, markers.relative_angular_velocity(m, d, a, b))

        elif kind == ALPHA:
            al.set_vec_at(y, at, markers.relative_angular_acceleration(m, d, a, b))

        elif kind == VELOCITY_BODY:
            seen = markers.relative_velocity(m, d, a, b)
            al.set_vec_at(y, at, al.matT_vec(markers.relative_axes(m, d, a, b), seen))

        elif kind == OMEGA_BODY:
            seen = markers.relative_angular_velocity(m, d, a, b)
            al.set_vec_at(y, at, al.matT_vec(markers.relative_axes(m, d, a, b), seen))

        elif kind == STRUT_LENGTH or kind == STRUT_FORCE:
            length, direction, tension = forces.strut(m, d, a)
            y[at] = length if kind == STRUT_LENGTH else tension

        else:
            tree.inertias(m, d)
            kinetic = tree.kinetic_energy(m, d)
            potential = tree.gravity_energy(m, d) + forces.spring_energy(m, d)

            if kind == KINETIC_ENERGY:
                y[at] = kinetic
            elif kind == POTENTIAL_ENERGY:
                y[at] = potential
            else:
                y[at] = kinetic + potential
