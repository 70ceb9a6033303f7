"""Inertias of the bodies, and what follows: weight, bias wrenches, momenta, energies (docs/theory.md 5, 16.2).

Legend: I, H, M blocks of a 6x6 inertia: moment = I alpha + H rdd, force = H^T alpha + M rdd; suffix _a:
articulated (ABA) or composite (CRBA). For a rigid body H = h x, M = m 1. S motion subspace, U = I_a S, D = S^T U.
"""

from ..forces import added_mass, shared_water
from ..joints import rotors, virtual
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..signatures import DATA, MODEL, void
from . import holding


@inlined
def momentum(m, d, i):
    """(angular about the body's origin, linear) momentum of body i, added mass in still water included."""
    w = al.vec3(d.w, i)
    rd = al.vec3(d.rd, i)
    I = al.sym3(d.I, i)

    if m.body_added[i] == 1:
        H = al.mat3(d.H, i)
        return (
            al.add(al.sym_vec(I, w), al.mat_vec(H, rd)),
            al.add(al.matT_vec(H, w), al.sym_vec(al.sym3(d.M, i), rd)),
        )

    h = al.vec3(d.h, i)
    return (
        al.add(al.sym_vec(I, w), al.cross(h, rd)),
        al.add(al.cross(w, h), al.scale(d.body_m[i], rd)),
    )


@apart(void(MODEL, DATA))
def inertias(m, d):
    """Inertias in inertial axes, velocity-dependent bias wrenches; starts the applied wrench with weight.

    Added mass is inertia as well, but has no weight.
    """
    g = al.vec3(m.gravity, 0)
    al.set_vec3(d.moment, 0, al.ZERO3)
    al.set_vec3(d.force, 0, al.ZERO3)
    al.set_vec3(d.bias_moment, 0, al.ZERO3)

    for i in range(1, m.n_body):
        A = al.mat3(d.A, i)
        w = al.vec3(d.w, i)
        mass = d.body_m[i]
        h = al.mat_vec(A, al.vec3(d.body_h, i))
        al.set_vec3(d.h, i, h)
        al.set_vec3(d.moment, i, al.cross(h, g))
        al.set_vec3(d.force, i, al.scale(mass, g))
        I = al.sym_rotate(A, al.sym3(d.body_I, i))
        al.set_sym3(d.I, i, I)
        al.set_vec3(d.bias_moment, i, al.cross(w, al.sym_vec(I, w)))
        al.set_vec3(d.bias_force, i, al.cross(w, al.cross(w, h)))

        if m.body_added[i] == 1:
            al.set_mat3(d.H, i, al.skew(h))
            al.set_sym3(d.M, i, (mass, mass, mass, 0.0, 0.0, 0.0))

    if m.n_six_by_six > 0:
        added_mass.add(m, d)

    for k in range(m.n_rotor):
        host = rotors.host(m, m.rotor_body[k])
        L = rotors.momentum(m, d, m.rotor_body[k])
        al.add_vec3(d.bias_moment, host, al.cross(al.vec3(d.w, host), L))


@inlined
def inertia_blocks(m, d, i):
    """(I, H, M) of body i, in inertial axes about its origin."""
    if m.body_added[i] == 1:
        return (al.sym3(d.I, i), al.mat3(d.H, i), al.sym3(d.M, i))

    mass = d.body_m[i]
    return (al.sym3(d.I, i), al.skew(al.vec3(d.h, i)), (mass, mass, mass, 0.0, 0.0, 0.0))


@inlined
def start_articulated(m, d):
    """I_a, H_a, M_a of every body alone."""
    for i in range(1, m.n_body):
        I, H, M = inertia_blocks(m, d, i)
        al.set_sym3(d.I_a, i, I)
        al.set_mat3(d.H_a, i, H)
        al.set_sym3(d.M_a, i, M)

    if d.lends[0] > 0.0:
        virtual.add(m, d)

    if d.weighs[0] > 0.0:
        holding.add_weights(m, d)


@kernel
def kinetic_energy(m, d):
    """Kinetic energy (J) of all bodies, that of the water moved with added mass included."""
    energy = 0.0

    for i in range(1, m.n_body):
        L, p = momentum(m, d, i)
        energy += 0.5 * (al.dot(al.vec3(d.w, i), L) + al.dot(al.vec3(d.rd, i), p))

    for k in range(m.n_six_by_six):
        if added_mass.is_in_moving_water(m, k):
            i = m.marker_body[m.six_by_six_to[k]]
            w, rd = added_mass.carried(m, d, k)
            L, p = added_mass.borne(m, d, k)
            energy -= al.dot(al.axpy(-0.5, w, al.vec3(d.w, i)), L) + al.dot(
                al.axpy(-0.5, rd, al.vec3(d.rd, i)), p
            )

    for k in range(m.n_rotor):
        energy += rotors.energy(m, d, m.rotor_body[k])

    return energy + shared_water.energy(m, d)


@kernel
def gravity_energy(m, d):
    """Potential energy (J) of the weight of all bodies, those that stand still too, zero at the origin of O."""
    g = al.vec3(m.gravity, 0)
    energy = -al.dot(g, al.vec3(d.body_h, 0))

    for i in range(1, m.n_body):
        energy -= d.body_m[i] * al.dot(g, al.vec3(d.r, i)) + al.dot(g, al.vec3(d.h, i))

    return energy


@kernel
def total_momentum(m, d):
    """(angular about O's origin, linear) momentum of all bodies that move, added mass included."""
    angular = al.ZERO3
    linear = al.ZERO3

    for i in range(1, m.n_body):
        L, p = momentum(m, d, i)
        angular = al.add(angular, al.add(L, al.cross(al.vec3(d.r, i), p)))
        linear = al.add(linear, p)

    for k in range(m.n_six_by_six):
        if added_mass.is_in_moving_water(m, k):
            L, p = added_mass.borne(m, d, k)
            r = al.vec3(d.r, m.marker_body[m.six_by_six_to[k]])
            angular = al.sub(angular, al.add(L, al.cross(r, p)))
            linear = al.sub(linear, p)

    for k in range(m.n_shared_water):
        L, p = shared_water.momentum(m, d, k)
        angular = al.add(angular, L)
        linear = al.add(linear, p)

    for k in range(m.n_rotor):
        angular = al.add(angular, rotors.momentum(m, d, m.rotor_body[k]))

    return angular, linear


@kernel
def center_of_mass(m, d):
    """Centre of mass (m, in O) of all bodies, those that stand still too."""
    mass = d.body_m[0]
    moment = al.vec3(d.body_h, 0)

    for i in range(1, m.n_body):
        mass += d.body_m[i]
        moment = al.add(moment, al.axpy(d.body_m[i], al.vec3(d.r, i), al.vec3(d.h, i)))

    return al.scale(1.0 / mass, moment)
