"""Virtual inertia (docs/theory.md 14.1): what a part is lent where a joint would have none to move.

A part without mass (a pulley, a rod, a frame), a particle, or a rod without inertia about itself may be moved by constraints,
couplings and drives all the same. The tree's factors need an inertia there: a small one is lent to the part, about its
origin, for the factors and for the metric of projections. Accelerations are then corrected to those without it (massless.py).
Nothing is lent, and nothing of this costs, where every joint has inertia of its own to move, as that of a frame without mass has which
carries others.
"""

from ..language import inlined, kernel
from ..math import algebra as al

# of the mean mass, and of the mean inertia: large enough not to cost digits, small enough to correct quickly
PART = 0.1


@kernel
def measure(m, d):
    """(mass kg, inertia kg m2) that parts are lent: of the size of the others'."""
    mass = 0.0
    inertia = 0.0
    masses = 0
    inertias = 0
    length = 0.0
    lengths = 0

    for i in range(1, m.n_body):
        size = (d.body_I[6 * i] + d.body_I[6 * i + 1] + d.body_I[6 * i + 2]) / 3.0
        arm = al.norm(al.vec3(m.body_r, i))

        if d.body_m[i] > 0.0:
            mass += d.body_m[i]
            masses += 1

        if size > 0.0:
            inertia += size
            inertias += 1

        if arm > 0.0:
            length += arm
            lengths += 1

    for k in range(m.n_marker):
        arm = al.norm(al.vec3(m.marker_r, k))

        if arm > 0.0:
            length += arm
            lengths += 1

    mass = PART * (mass / masses if masses > 0 else 1.0)
    length = length / lengths if lengths > 0 else 1.0
    return mass, PART * inertia / inertias if inertias > 0 else mass * length * length


@kernel
def lend(m, d, i, slides):
    """Lend body i mass (when it `slides`), or inertia. Returns how much: 0 when it has been lent some before."""
    mass, inertia = measure(m, d)

    if slides:
        if d.lent_mass[i] > 0.0:
            return 0.0

        d.lent_mass[i] = mass
        al.add_to_diagonal(d.M_a, i, mass)
    else:
        if d.lent_inertia[i] > 0.0:
            return 0.0

        d.lent_inertia[i] = inertia
        al.add_to_diagonal(d.I_a, i, inertia)

    d.lends[0] = 1.0
    d.lent_known[i] = 0.0
    return mass if slides else inertia


@inlined
def lacks_inertia(d, i):
    """Whether the inertia of body i about its centre of mass is singular."""
    I = al.sym3(d.body_I, i)
    size = I[0] + I[1] + I[2]

    if d.body_m[i] > 0.0:
        com = al.scale(1.0 / d.body_m[i], al.vec3(d.body_h, i))
        I = al.sym_sub(I, al.sym_point(d.body_m[i], com))

    return not al.sym_is_regular(I, al.sym_factor(I), size)


@kernel
def lend_to_all(m, d, part):
    """All parts that have no inertia of their own are lent some, times `part`. Returns whether there are such."""
    mass, inertia = measure(m, d)
    forget(m, d)

    for k in range(m.n_solid):
        i = m.solid_body[k]

        if i > 0 and m.body_added[i] == 0:
            d.lent_mass[i] = part * mass if d.body_m[i] == 0.0 else 0.0
            d.lent_inertia[i] = part * inertia if lacks_inertia(d, i) else 0.0

            if d.lent_mass[i] + d.lent_inertia[i] > 0.0:
                d.lends[0] = 1.0

    return d.lends[0] > 0.0


@inlined
def add(m, d):
    """What bodies are lent, to their I_a and M_a."""
    for i in range(1, m.n_body):
        al.add_to_diagonal(d.M_a, i, d.lent_mass[i])
        al.add_to_diagonal(d.I_a, i, d.lent_inertia[i])


@inlined
def add_bias(m, d):
    """Wrenches that the lent inertia takes at accelerations alpha and rdd, to the bias wrenches."""
    for i in range(1, m.n_body):
        al.add_vec3(d.bias_moment, i, al.scale(d.lent_inertia[i], al.vec3(d.alpha, i)))
        al.add_vec3(d.bias_force, i, al.scale(d.lent_mass[i], al.vec3(d.rdd, i)))


@kernel
def forget(m, d):
    """Nobody is lent anything."""
    d.lends[0] = 0.0

    for i in range(m.n_body):
        d.lent_mass[i] = 0.0
        d.lent_inertia[i] = 0.0
        d.lent_known[i] = 0.0
