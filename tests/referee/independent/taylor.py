"""Frames and equations as functions of the time tau from now on, and what CasADi's derivatives make of them.

An owner (a body, or the ground) moves from the pose (r, A) with the velocities (v, w) and unknown
accelerations (a, alpha): r(tau) = r + v tau + a tau^2 / 2 and A(tau) = exp(phi) A, phi = w tau + alpha tau^2
/ 2, since phi' = w and phi'' = alpha at phi = 0. The exponential is needed to the second power of tau alone,
so it is a polynomial and has no singular place.
"""

import casadi as ca
import numpy as np

STATE = 18  # numbers of an owner: r, A by rows, v, w


def skew(u):
    """The matrix of u x."""
    return ca.vertcat(ca.horzcat(0, -u[2], u[1]), ca.horzcat(u[2], 0, -u[0]), ca.horzcat(-u[1], u[0], 0))


class Frame:
    """A frame over tau: origin r, axes A (by column, inertial), velocity v of its origin,
    angular velocity w."""

    def __init__(self, r, A, v, w):
        self.r, self.A, self.v, self.w = r, A, v, w


def moving(state, acceleration, tau):
    """The frame of an owner over tau. state (18,), acceleration (6,): symbols."""
    r, A, v, w = state[:3], ca.reshape(state[3:12], 3, 3).T, state[12:15], state[15:]
    a, alpha = acceleration[:3], acceleration[3:]
    phi = skew(w * tau + alpha * tau**2 / 2)
    turned = (ca.SX.eye(3) + phi + phi @ phi / 2) @ A
    return Frame(r + v * tau + a * tau**2 / 2, turned, v + a * tau, w + alpha * tau)


class Pair:
    """Two frames, the second as seen from the first: d (3,) and R (3, 3) in its axes,
    velocities as seen from there."""

    def __init__(self, first, second):
        self.first, self.second = first, second
        span = second.r - first.r
        back = first.A.T
        self.d = back @ span
        self.R = back @ second.A
        self.v = back @ (second.v - first.v - ca.cross(first.w, span))
        self.w = back @ (second.w - first.w)


def vee(R):
    """Half the axial vector of a matrix's skew part:
    the rotation vector up to the second power of the angle."""
    return ca.vertcat(R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]) / 2


def swing_and_twist(R, R_now, E_now):
    """(rx, ry, rz) of R = exp(rx, ry, 0) Rz(rz) over tau. R_now, E_now :
    R at tau = 0 and its Euler parameters."""
    phi = vee(R @ R_now.T)
    x, y, z, w = ca.vertsplit(E_now)

    # the small rotation from now on, before the present one
    change = ca.vertcat(phi / 2, 1 - ca.dot(phi, phi) / 8)
    a, b, c, d = ca.vertsplit(change)
    E = ca.vertcat(d * x + a * w + b * z - c * y, d * y + b * w + c * x - a * z,
                   d * z + c * w + a * y - b * x,
                   d * w - a * x - b * y - c * z)  # fmt: skip
    n = ca.sqrt(E[2] ** 2 + E[3] ** 2)
    s, c = E[2] / n, E[3] / n

    # swing: E after the twist undone
    sx, sy = E[0] * c - E[1] * s, E[1] * c + E[0] * s
    square = sx**2 + sy**2
    small = square < 1e-4
    safe = ca.if_else(small, 0.25, square)
    series = 2 * (1 + square / 6 + 3 * square**2 / 40 + 5 * square**3 / 112 + 35 * square**4 / 1152)
    stretch = ca.if_else(small, series, 2 * ca.atan2(ca.sqrt(safe), ca.if_else(small, 1, n)) / ca.sqrt(safe))
    return ca.vertcat(stretch * sx, stretch * sy, 2 * ca.atan2(E[2], E[3]))


class Signals:
    """Expressions over tau, collected by name: of positions, or of velocities.

    After `compile`, a call gives for each of them its value, its rate (of positions), its highest rate at
    zero accelerations, and J, the highest rate's derivative by the accelerations: the row of the Jacobian by
    the velocities.
    """

    def __init__(self):
        self.parts = {"position": [], "velocity": []}
        self.places = {}
        self.lengths = {"position": 0, "velocity": 0}

    def add(self, name, expression, of="position"):
        """Some more rows, an SX column or a list."""
        column = ca.vertcat(ca.SX(0, 1), *expression) if isinstance(expression, (list, tuple)) else expression
        n = column.shape[0]
        self.places[name] = (of, slice(self.lengths[of], self.lengths[of] + n))
        self.parts[of].append(column)
        self.lengths[of] += n

    def compile(self, tau, accelerations, inputs):
        """The CasADi function of all signals; accelerations : the unknowns; inputs : all other symbols."""
        results = []

        for of, order in (("position", 2), ("velocity", 1)):
            y = ca.vertcat(*self.parts[of]) if self.parts[of] else ca.SX(0, 1)
            rates = [y]

            for _ in range(order):
                rates.append(ca.jacobian(rates[-1], tau))

            results += [*rates, ca.jacobian(rates[-1], accelerations)]

        zero = [ca.SX(0), ca.SX.zeros(accelerations.shape)]
        results = ca.substitute(results, [tau, accelerations], zero)
        self.function = ca.Function("signals", [inputs], results)

    def __call__(self, numbers):
        """Name -> (value, rate, highest rate at zero accelerations, J) for these inputs;
        of velocities value and rate are one."""
        p, p1, p2, Jp, v, v1, Jv = (np.asarray(part) for part in self.function(numbers))
        blocks = {
            "position": (p.ravel(), p1.ravel(), p2.ravel(), Jp),
            "velocity": (v.ravel(), v.ravel(), v1.ravel(), Jv),
        }
        return {name: tuple(part[rows] for part in blocks[of]) for name, (of, rows) in self.places.items()}
