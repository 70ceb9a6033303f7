"""Wave loads on the fixed barge: the linear theory of a floating vertical cylinder, solved exactly.

The barge is replaced by a truncated circular cylinder of equal waterplane area and draught.
C. J. R. Garrett: Wave forces on a circular dock, J. Fluid Mech. 46 (1971) 129: the potential is a
sum of eigenfunctions in the water around the cylinder and another in the water below it, matched
where they meet.
"""

import numpy as np
from scipy.special import h2vp, hankel2, ive, jv, jvp, kve

GRAVITY = 9.80665  # m/s2
WATER = 1025.0  # kg/m3


def cylinder_excitation(omega, radius, draught, depth, around=80, below=60):
    """Surge force (N/m), heave force (N/m) and pitch moment (N m/m) per metre of wave amplitude.

    omega: angular frequency, rad/s; radius, draught, depth: m; around, below: number of terms.
    Three complex numbers X: a wave travelling along +x whose elevation at the axis is cos(omega t)
    gives the load Re(X exp(i omega t)); the moment is about the axis on the waterline.
    """
    # wave numbers of the water around: i k of the wave itself, then the evanescent ones, from
    # omega^2 / g = -kappa tan(kappa depth) by fixed points
    nu = omega**2 / GRAVITY
    k = nu
    for _ in range(200):
        k = nu / np.tanh(k * depth)
    n = np.arange(1, around)
    y = np.zeros(around - 1)
    for _ in range(60):
        y = np.arctan(nu * depth / (n * np.pi - y))
    evanescent = (n * np.pi - y) / depth
    kappa = np.r_[1j * k, evanescent]

    # eigenfunctions cos(kappa s) / norm around and cos(lam s) below, s the height above the bed
    gap = depth - draught
    lam = np.arange(below) * np.pi / gap
    norm = np.sqrt(depth / 2 + np.sin(2 * kappa * depth) / (4 * kappa))
    norm_below = np.r_[gap, np.full(below - 1, gap / 2)]

    def overlap(x):
        return np.sin(x * gap) / x

    shift = 1e-12  # keeps 0 / 0 away where both are zero
    product = (overlap(kappa[:, None] + lam + shift) + overlap(kappa[:, None] - lam + shift)) / 2
    product = (product / norm[:, None]).real

    # integrals over the wetted side of an eigenfunction and of z times it
    def first_moment(s):
        return (s - depth) * np.sin(kappa * s) / kappa + np.cos(kappa * s) / kappa**2

    side = (np.sin(kappa * depth) - np.sin(kappa * gap)) / kappa / norm
    side_z = (first_moment(depth) - first_moment(gap)) / norm
    x_around, x_below = evanescent * radius, lam[1:] * radius
    sign = (-1.0) ** np.arange(below)

    def amplitudes(m):
        """Of cos(m theta): the pressure head around and below, per eigenfunction."""
        wave = (1 + m) * (-1j) ** m * norm[0] / np.cosh(k * depth)
        head = np.r_[wave * jv(m, k * radius), np.zeros(around - 1)]
        slope = np.r_[wave * k * jvp(m, k * radius), np.zeros(around - 1)]
        slope_around = np.r_[
            k * h2vp(m, k * radius) / hankel2(m, k * radius),
            evanescent * (m / x_around - kve(m + 1, x_around) / kve(m, x_around)),
        ]
        slope_below = np.r_[m / radius, lam[1:] * (m / x_below + ive(m + 1, x_below) / ive(m, x_below))]
        coupling = product * (slope_below / norm_below) @ product.T
        scattered = np.linalg.solve(np.diag(slope_around) - coupling, coupling @ head - slope)
        return head + scattered, product.T @ (head + scattered) / norm_below

    _, under = amplitudes(0)
    disc = np.r_[radius**2 / 2, radius / lam[1:] * ive(1, x_below) / ive(0, x_below)]
    heave = 2 * np.pi * np.sum(sign * under * disc)

    beside, under = amplitudes(1)
    disc = np.r_[radius**3 / 4, radius**2 / lam[1:] * ive(2, x_below) / ive(1, x_below)]
    surge = -np.pi * radius * np.sum(beside * side)
    pitch = -np.pi * radius * np.sum(beside * side_z) - np.pi * np.sum(sign * under * disc)

    return WATER * GRAVITY * np.array([surge, heave, pitch])
