"""The gradient of central gravity on bodies by their inertia (docs/theory.md 16.13): what 16.3 leaves out, to second order.

By its potential -mu / (2 |r|^3) (tr I - 3 e . I e) each solid feels a moment about its centre of mass and a force there, I its inertia
about that and e = r / |r|.
"""

from ..language import inlined
from ..math import algebra as al
from ..motion import markers
from .central_gravity import solid_com


@inlined
def acts_on(m, c, k):
    """Whether field c has a gradient that solid k feels: what has no mass may be at the centre."""
    return m.central_gradient[c] == 1 and m.solid_mass[k] > 0.0


@inlined
def solid_inertia(m, d, k):
    """Inertia (kg m2) of solid k about its centre of mass, in inertial axes."""
    A = al.mat_mat(al.mat3(d.A, m.solid_body[k]), al.mat3(m.solid_A, k))
    return al.sym_rotate(A, al.sym3(m.solid_inertia, k))


@inlined
def wrench(m, d, c, k):
    """Field c's on solid k at its centre of mass r (m, in O): (r, moment N m, force N), in inertial axes."""
    r = solid_com(m, d, k)
    I = solid_inertia(m, d, k)
    square = al.dot(r, r)
    Ir = al.sym_vec(I, r)
    strength = 3.0 * m.central_mu[c] / (square * square * al.norm(r))
    trace = I[0] + I[1] + I[2]
    pull = al.axpy(trace - 5.0 * al.dot(r, Ir) / square, r, al.scale(2.0, Ir))
    return r, al.scale(strength, al.cross(r, Ir)), al.scale(-0.5 * strength, pull)


@inlined
def add(m, d):
    """Add it to the applied wrenches."""
    for c in range(m.n_central):
        for k in range(m.n_solid):
            if acts_on(m, c, k):
                r, moment, force = wrench(m, d, c, k)
                markers.add_wrench(m, d, m.solid_body[k], r, moment, force)


@inlined
def energy(m, d):
    """Its potential energy (J), zero at infinity, of all bodies."""
    energy = 0.0

    for c in range(m.n_central):
        for k in range(m.n_solid):
            if acts_on(m, c, k):
                r = solid_com(m, d, k)
                I = solid_inertia(m, d, k)
                square = al.dot(r, r)
                spread = I[0] + I[1] + I[2] - 3.0 * al.dot(r, al.sym_vec(I, r)) / square
                energy -= 0.5 * m.central_mu[c] / (square * al.norm(r)) * spread

    return energy


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for c in range(m.n_central):
        for k in range(m.n_solid):
            if acts_on(m, c, k):
                i = m.solid_body[k]
                r, moment, force = wrench(m, d, c, k)
                total += al.dot(moment, al.vec3(d.w, i)) + al.dot(force, markers.point_velocity(m, d, i, r))

    return total
