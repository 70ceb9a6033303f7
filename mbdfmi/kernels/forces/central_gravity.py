"""Central gravity (docs/theory.md 16.3): -mu r / |r|^3 per mass, at each solid's centre of mass, from O."""

from ..language import inlined
from ..math import algebra as al
from ..motion import markers


@inlined
def solid_com(m, d, k):
    """Centre of mass of solid k (m, in O)."""
    i = m.solid_body[k]
    com = al.add(al.vec3(m.solid_r, k), al.mat_vec(al.mat3(m.solid_A, k), al.vec3(m.solid_com, k)))
    return al.add(al.vec3(d.r, i), al.mat_vec(al.mat3(d.A, i), com))


@inlined
def add(m, d):
    """Add it to the applied wrenches."""
    for c in range(m.n_central):
        for k in range(m.n_solid):
            # what has no mass may be at the centre
            if m.solid_mass[k] == 0.0:
                continue

            r = solid_com(m, d, k)
            distance = al.norm(r)
            weight = al.scale(-m.central_mu[c] * m.solid_mass[k] / (distance * distance * distance), r)
            markers.add_wrench(m, d, m.solid_body[k], r, al.ZERO3, weight)


@inlined
def energy(m, d):
    """Its potential energy (J), zero at infinity, of all bodies."""
    energy = 0.0

    for c in range(m.n_central):
        for k in range(m.n_solid):
            if m.solid_mass[k] == 0.0:
                continue

            energy -= m.central_mu[c] * m.solid_mass[k] / al.norm(solid_com(m, d, k))

    return energy


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for c in range(m.n_central):
        for k in range(m.n_solid):
            if m.solid_mass[k] == 0.0:
                continue

            r = solid_com(m, d, k)
            distance = al.norm(r)
            velocity = markers.point_velocity(m, d, m.solid_body[k], r)
            total -= (
                m.central_mu[c] * m.solid_mass[k] / (distance * distance * distance) * al.dot(r, velocity)
            )

    return total
