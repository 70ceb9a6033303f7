"""The joint kinds of the tree (docs/theory.md 3.2): their numbers, and how many coordinates each has.

==========  ===========================  ====================================
kind        q                            v
==========  ===========================  ====================================
REVOLUTE    angle about z of F           angular speed
PRISMATIC   displacement along z of F    speed
SPHERICAL   E                            angular velocity in the body's axes
FREE        position in F, then E        velocity in F, angular velocity in the body's axes
FIXED       none                         none
==========  ===========================  ====================================
"""

from ..language import inlined

REVOLUTE = 0
PRISMATIC = 1
SPHERICAL = 2
FREE = 3
FIXED = 4  # held for good; where nothing asks for its reaction, the compiler makes one node of its two

KINDS = {"revolute": REVOLUTE, "prismatic": PRISMATIC, "spherical": SPHERICAL, "free": FREE, "fixed": FIXED}

# by kind: position and velocity coordinates, where E stands among the former (-1: no E), lengths among the latter
N_Q = (1, 1, 4, 7, 0)
N_V = (1, 1, 3, 6, 0)
E_OFFSET = (-1, -1, 0, 3, -1)
N_SLIDE = (0, 1, 0, 3, 0)


@inlined
def n_v(kind):
    """Number of velocity coordinates of a joint kind."""
    if kind == REVOLUTE or kind == PRISMATIC:
        return N_V[REVOLUTE]

    if kind == SPHERICAL:
        return N_V[SPHERICAL]

    return N_V[FREE] if kind == FREE else N_V[FIXED]


@inlined
def n_q(kind):
    """Number of position coordinates of a joint kind."""
    if kind == REVOLUTE or kind == PRISMATIC:
        return N_Q[REVOLUTE]

    if kind == SPHERICAL:
        return N_Q[SPHERICAL]

    return N_Q[FREE] if kind == FREE else N_Q[FIXED]


@inlined
def E_offset(kind):
    """Where E stands among the position coordinates of a joint kind, -1: it has none."""
    if kind == SPHERICAL:
        return E_OFFSET[SPHERICAL]

    return E_OFFSET[FREE] if kind == FREE else E_OFFSET[FIXED]


@inlined
def slides(kind, k):
    """Whether velocity coordinate k of a joint kind is along a length."""
    return kind == PRISMATIC or (kind == FREE and k < N_SLIDE[FREE])


@inlined
def turns(kind, k):
    """Whether velocity coordinate k of a joint kind is of an orientation kept as E."""
    return E_offset(kind) >= 0 and not slides(kind, k)


@inlined
def is_one_axis(kind):
    """Whether a joint kind has one freedom, about or along its axis."""
    return kind == REVOLUTE or kind == PRISMATIC
