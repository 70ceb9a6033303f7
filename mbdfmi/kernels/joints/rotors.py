"""Rotors that turn with joints of one freedom, n times as fast, as those of geared motors (docs/theory.md 5.5).

The *host* bears the rotor: the body of the joint's first marker, in whose inertia the rotor counts as if locked. The joint's rate v
gives it the momentum n J v about the joint's axis on top of that. A joint that the tree leads through backwards has its axis
turned round, and the host is the body behind it.
"""

from ..language import inlined
from ..math import algebra as al
from .kinds import REVOLUTE


@inlined
def has(m, i):
    """Whether a rotor turns with the joint of body i."""
    return m.n_rotor > 0 and m.body_rotor[i] >= 0


@inlined
def host(m, i):
    """The body that bears the rotor of body i's joint."""
    return i if m.body_reversed[i] == 1 else m.body_parent[i]


@inlined
def coupling(m, i):
    """n J along the joint's axis in the tree: kg m2 (kg m): angular momentum of the host by the joint's rate."""
    k = m.body_rotor[i]
    nJ = m.rotor_ratio[k] * m.rotor_inertia[k]
    return -nJ if m.body_reversed[i] == 1 else nJ


@inlined
def own(m, i):
    """n^2 J (kg m2, kg): inertia along the joint's coordinate while the host is at rest."""
    k = m.body_rotor[i]
    return m.rotor_ratio[k] * m.rotor_ratio[k] * m.rotor_inertia[k]


@inlined
def inertia(m, i):
    """What the rotor adds to the inertia in the joint of body i (kg m2, kg) while the parent is at rest."""
    if m.body_reversed[i] == 1 and m.body_joint[i] == REVOLUTE:
        return own(m, i) + 2.0 * coupling(m, i)

    return own(m, i)


@inlined
def momentum(m, d, i):
    """The host's angular momentum (kg m2/s) by the joint's rate, in inertial axes."""
    return al.scale(coupling(m, i) * d.v[m.body_v[i]], al.vec3(d.axis, i))


@inlined
def reaction(m, d, i):
    """Moment (N m) that the host needs for the joint's acceleration."""
    return al.scale(coupling(m, i) * d.v_rate[m.body_v[i]], al.vec3(d.axis, i))


@inlined
def effort(m, d, i):
    """Effort (N m, N) that the rotor takes of the joint's, with the host's acceleration."""
    along = al.dot(al.vec3(d.axis, i), al.vec3(d.alpha, host(m, i)))
    return own(m, i) * d.v_rate[m.body_v[i]] + coupling(m, i) * along


@inlined
def energy(m, d, i):
    """Kinetic energy (J) on top of the rotor's share in the host's."""
    v = d.v[m.body_v[i]]
    along = al.dot(al.vec3(d.axis, i), al.vec3(d.w, host(m, i)))
    return (0.5 * own(m, i) * v + coupling(m, i) * along) * v
