"""Mechanisms to measure with: chains and trees of revolute joints, in no library's own form."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from mbdfmi import Scene

GRAVITY = (0.0, 0.0, -9.81)
AXES = "xyz"


@dataclass(frozen=True)
class Link:
    """One body and the revolute joint that hangs it on its parent.

    parent : index of the link it hangs on, -1 the ground; parents come first.
    axis : 0, 1, 2, the coordinate axis that the joint turns about.
    position (3,) m, rotation (3, 3) : joint in the parent's frame, and body's frame at angle 0.
    mass : kg.  com (3,) : m.  inertia (3, 3) : kg m2 about the centre of mass. In the body's frame.
    angle, speed, torque : rad, rad/s, N m; the state and the input to evaluate at.
    """

    parent: int
    axis: int
    position: np.ndarray
    rotation: np.ndarray
    mass: float
    com: np.ndarray
    inertia: np.ndarray
    angle: float
    speed: float
    torque: float


def chain_parents(n: int) -> list[int]:
    """Each body hangs on the one before."""
    return list(range(-1, n - 1))


def tree_parents(n: int) -> list[int]:
    """Each body carries two others as long as there are any, depth first."""
    parents = []

    def grow(k, parent):
        if k < n:
            parents.append(parent)
            here = len(parents) - 1
            grow(2 * k + 1, here)
            grow(2 * k + 2, here)

    grow(0, -1)
    return parents


def links_of(parents: list[int], seed: int = 0) -> list[Link]:
    """Links on these parents: alternating axes, everything else at random."""
    rng = np.random.default_rng(seed)
    links = []

    for i, parent in enumerate(parents):
        principal = rng.uniform(0.01, 0.03, 3)
        Q = Rotation.from_quat(rng.normal(size=4)).as_matrix()
        links.append(
            Link(
                parent=parent,
                axis=i % 3,
                position=rng.uniform(-0.3, 0.3, 3) * (parent >= 0),
                rotation=Rotation.from_quat(rng.normal(size=4)).as_matrix(),
                mass=rng.uniform(0.5, 2.0),
                com=rng.uniform(-0.2, 0.2, 3),
                inertia=Q @ np.diag(principal.sum() - principal) @ Q.T,
                angle=rng.uniform(-3.0, 3.0),
                speed=rng.uniform(-1.0, 1.0),
                torque=rng.uniform(-1.0, 1.0),
            )
        )

    return links


def scene_of(links: list[Link], formulation: str = "recursive") -> Scene:
    """The scene: body0, body1 ... on joint0, joint1 ...; torques are inputs, accelerations outputs."""
    ground = {"marker": {}}
    bodies = {}
    joints = {}

    for i, link in enumerate(links):
        inertia = 0.5 * (link.inertia + link.inertia.T)
        bodies[f"body{i}"] = {
            "mass": link.mass,
            "com": list(link.com),
            "inertia": inertia.tolist(),
            "marker": {},
        }
        owner = f"body{link.parent}" if link.parent >= 0 else "ground"
        x, _, z = link.rotation.T.tolist()
        marker = {"position": list(link.position), "axes": {"z": z, "x": x}}
        bodies.get(owner, ground)["marker"][f"joint{i}"] = marker
        joints[f"joint{i}"] = {
            "revolute": {"axis": AXES[link.axis]},
            "between": [f"{owner}.joint{i}", f"body{i}"],
            "start": {"angle": link.angle, "speed": link.speed},
            "input": "torque",
            "output": ["acceleration"],
        }

    name = f"{len(links)} links"
    solver = {"formulation": formulation, "integrator": "rk54"}  # which keeps no Jacobian
    return Scene(name=name, gravity=GRAVITY, solver=solver, ground=ground, body=bodies, joint=joints)
