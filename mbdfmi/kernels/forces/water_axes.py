"""Axes that coefficients of potential flow are in (docs/theory.md 16.16): of six_by_six.py, where added mass is told of.

FIRST, the inertial ones, whatever way the body turns. HEADING, those turned about z by the yaw of the body's marker. BODY, the marker's.
Velocities go into them, forces and moments out of them, so that what takes energy there takes it here.
"""

from ..language import inlined
from ..math import algebra as al
from ..motion import markers
from .six_by_six import BODY, FIRST


@inlined
def heading(A):
    """(cosine, sine) of the yaw of a rotation A: of its twist about z, 0 where it is upside down and has none (docs/theory.md 2.6)."""
    E = al.matrix_E(A)
    n = E[2] * E[2] + E[3] * E[3]
    share = 1.0 / n if n > 0.0 else 0.0
    return (share * (E[3] * E[3] - E[2] * E[2]) if n > 0.0 else 1.0), share * 2.0 * E[2] * E[3]


@inlined
def turned(c, s):
    """The rotation about z by an angle of cosine c, sine s."""
    return ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0))


@inlined
def of_marker(m, d, axes, b):
    """Rotation to O of the axes that the coefficients of marker b's body are in, not FIRST."""
    A = markers.axes(m, d, b)

    if axes == BODY:
        return A

    c, s = heading(A)
    return turned(c, s)


@inlined
def motion(m, d, axes, b):
    """(velocity m/s, angular velocity rad/s) of marker b in these axes."""
    v = markers.velocity(m, d, b)
    w = markers.angular_velocity(m, d, b)

    if axes == FIRST:
        return v, w

    A = of_marker(m, d, axes, b)
    return al.matT_vec(A, v), al.matT_vec(A, w)


@inlined
def out(m, d, axes, b, moment, force):
    """A wrench in these axes at marker b, in inertial ones: (moment, force)."""
    if axes == FIRST:
        return moment, force

    A = of_marker(m, d, axes, b)
    return al.mat_vec(A, moment), al.mat_vec(A, force)
