"""Problems for long runs: motions with a period, after which a closed form says where they are.

Each is a scene, its period, what stays constant, and the error of its state after whole periods. Periods and
advances are integrals over a smooth periodic function, which a sum over even points gives to rounding.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import ellipk

POINTS = 400


@dataclass(frozen=True)
class Orbit:
    """A motion and what is known of it.

    scene : without solver.
    period : s.
    rate : rad/s of its fastest rotation.
    constants : name -> outputs that stay constant together, and the size (in their unit) they are measured
    by. state : outputs that `error` needs. error : (whole periods, values of these outputs (n,)) -> relative
    error of the state.
    """

    name: str
    title: str
    scene: dict
    period: float
    rate: float
    constants: dict[str, tuple[list[str], float]]
    state: list[str]
    error: Callable[[int, np.ndarray], float]


def tumbling_body() -> Orbit:
    """A free body that turns about its intermediate axis and flips: w2 = sn, w1 = cn, w3 = dn of the time."""
    J = np.array([1.0, 2.0, 3.0])
    w = np.array([0.1, 1.0, 0.1])
    L2, T2 = np.sum((J * w) ** 2), np.sum(J * w**2)

    # Landau, Lifshitz, Mechanics, section 37, for L^2 > 2 T J2
    n = np.sqrt((J[2] - J[1]) * (L2 - T2 * J[0]) / J.prod())
    k2 = (J[1] - J[0]) * (T2 * J[2] - L2) / ((J[2] - J[1]) * (L2 - T2 * J[0]))
    names = [f"body.omega_body[{k}]" for k in (1, 2, 3)]
    momentum = [f"angular_momentum[{k}]" for k in (1, 2, 3)]
    return Orbit(
        name="tumbling body",
        title="free body, flips of its intermediate axis",
        scene={
            "name": "tumbling body",
            "gravity": [0, 0, 0],
            "body": {"body": {"mass": 1.0, "inertia": J.tolist(), "output": ["omega_body"]}},
            "joint": {"free": {"free": {}, "between": ["ground", "body"], "start": {"omega": w.tolist()}}},
            "output": ["total_energy", "angular_momentum"],
        },
        period=4 * ellipk(k2) / n,
        rate=float(np.linalg.norm(w)),
        constants={"energy": (["total_energy"], T2 / 2), "angular momentum": (momentum, np.sqrt(L2))},
        state=names,
        error=lambda periods, found: float(np.linalg.norm(found - w) / np.linalg.norm(w)),
    )


def heavy_top() -> Orbit:
    """A top let go with its axis at rest: it nutates between two heights, from cusp to cusp."""
    mass, length, gravity = 1.0, 0.1, 9.81
    across, axial, spin, tilt = 1.4e-2, 5e-3, 60.0, 1.0
    across_com = across - mass * length**2

    # u = cos of the tilt: u'^2 = p (u0 - u) (u - u1) (u2 - u), Goldstein, Classical Mechanics, section 5.7
    b, p, u0 = axial * spin / across, 2 * mass * gravity * length / across, np.cos(tilt)
    half = b**2 / (2 * p)
    root = np.sqrt(half**2 - 2 * half * u0 + 1)
    u1, u2 = half - root, half + root
    u = u1 + (u0 - u1) * np.sin(np.arange(POINTS) * np.pi / POINTS) ** 2
    period = 2 * np.pi * np.mean(1 / np.sqrt(p * (u2 - u)))
    advance = 2 * np.pi * np.mean(b * (u0 - u) / (1 - u**2) / np.sqrt(p * (u2 - u)))
    axis = np.array([0, -np.sin(tilt), np.cos(tilt)])

    def error(periods, tip):
        turned = periods * advance % (2 * np.pi)
        wanted = [np.sin(tilt) * np.sin(turned), -np.sin(tilt) * np.cos(turned), np.cos(tilt)]
        return float(np.linalg.norm(tip - wanted))

    return Orbit(
        name="heavy top",
        title="heavy top, from cusp to cusp",
        scene={
            "name": "heavy top",
            "gravity": [0, 0, -gravity],
            "body": {
                "top": {
                    "mass": mass,
                    "com": [0, 0, length],
                    "inertia": [across_com, across_com, axial],
                    "marker": {"tip": {"position": [0, 0, 1], "output": ["position"]}},
                    "output": ["omega_body"],
                }
            },
            "joint": {
                "foot": {
                    "spherical": {},
                    "between": ["ground", "top"],
                    "start": {"zyx_rad": [0, 0, tilt], "omega": (spin * axis).tolist()},
                }
            },
            "output": ["total_energy", "angular_momentum"],
        },
        period=period,
        rate=spin,
        constants={
            "energy": (["total_energy"], axial * spin**2 / 2),
            "angular momentum": (["angular_momentum[3]"], axial * spin),
            "spin": (["top.omega_body[3]"], spin),
        },
        state=[f"top.tip.position[{k}]" for k in (1, 2, 3)],
        error=error,
    )


def planets_on_a_spring() -> Orbit:
    """Two bodies in a plane, bound by a spring with a length of its own: rosettes from apocentre to
    apocentre.
    """
    m1, m2, stiffness, rest, far, speed = 2.0, 3.0, 20.0, 0.4, 1.0, 2.0
    mu = m1 * m2 / (m1 + m2)
    spin = mu * far * speed
    energy = mu * speed**2 / 2 + stiffness * (far - rest) ** 2 / 2

    # r^2 mu r'^2 / 2 = F(r) = (far - r) (r - near) Q(r)
    F = np.array(
        [-stiffness / 2, stiffness * rest, energy - stiffness * rest**2 / 2, 0, -(spin**2) / (2 * mu)]
    )
    roots = np.roots(F)
    roots = roots[np.isreal(roots)].real
    near = roots[(roots > 0) & (roots < far * (1 - 1e-6))].max()
    Q = -np.polydiv(np.polydiv(F, [1, -far])[0], [1, -near])[0]
    r = 0.5 * (far + near) + 0.5 * (far - near) * np.cos((np.arange(POINTS) + 0.5) * 2 * np.pi / POINTS)
    slowness = r / np.sqrt(2 / mu * np.polyval(Q, r))
    period = 2 * np.pi * np.mean(slowness)
    advance = 2 * np.pi * np.mean(slowness * spin / (mu * r**2))
    starts = {
        "one": {"position": [-far * m2 / (m1 + m2), 0], "velocity": [0, -speed * m2 / (m1 + m2)]},
        "two": {"position": [far * m1 / (m1 + m2), 0], "velocity": [0, speed * m1 / (m1 + m2)]},
    }
    masses = {"one": m1, "two": m2}

    def error(periods, found):
        turned = periods * advance % (2 * np.pi)
        return float(np.linalg.norm(found - far * np.array([np.cos(turned), np.sin(turned)])) / far)

    return Orbit(
        name="planets on a spring",
        title="two bodies in a plane, bound by a spring",
        scene={
            "name": "planets on a spring",
            "gravity": [0, 0, 0],
            "body": {name: {"mass": mass, "inertia": [0.1] * 3} for name, mass in masses.items()},
            "joint": {
                name: {"planar": {}, "between": ["ground", name], "start": start}
                for name, start in starts.items()
            },
            "force": {
                "spring": {
                    "spring_damper": {"stiffness": stiffness, "rest_length": rest},
                    "between": ["one", "two"],
                }
            },
            "measure": {"apart": {"between": ["one", "two"], "output": ["position"]}},
            "output": ["total_energy", "angular_momentum", "linear_momentum"],
        },
        period=period,
        rate=spin / (mu * near**2),
        constants={
            "energy": (["total_energy"], energy),
            "angular momentum": (["angular_momentum[3]"], spin),
            "momentum": (["linear_momentum[1]", "linear_momentum[2]"], mu * speed),
        },
        state=["apart.position[1]", "apart.position[2]"],
        error=error,
    )


ORBITS = (tumbling_body, heavy_top, planets_on_a_spring)
