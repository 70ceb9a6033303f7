"""A joint kind that is made of simple motions is a class of the scene and a record of the compiler, and nothing else."""

from typing import ClassVar

import numpy as np
import pytest

from mbdfmi import Scene
from mbdfmi.analysis.inverse import inverse
from mbdfmi.analysis.structure import structure
from mbdfmi.compiler.joint_kinds import IN_Z, JOINT_KINDS, LOCKED, JointKind
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.simulate import simulate
from mbdfmi.scene.fields import SomeOf, filled, plane_axes
from mbdfmi.scene.joint_base import NormalOptions, Plain
from mbdfmi.scene.starts import Start, Vector2
from mbdfmi.vocabulary import IN_PLANE, REACTIONS, coordinate_names

BODY = {
    "mass": 1.3,
    "com": [0.1, -0.2, 0.3],
    "inertia": [0.4, 0.5, 0.6, 0.02, -0.03, 0.01],
    "marker": {"end": {"position": [0.3, 0.2, -0.4], "zyx_deg": [20, -35, 50]}},
    "output": ["position", "acceleration"],
}


class SlotStart(Start):
    places = (("position", "xy"),)
    rates = (("velocity", "xy"),)

    position: Vector2 = (0.0, 0.0)
    velocity: Vector2 = (0.0, 0.0)

    def q(self):
        return filled(self.position, "xy")

    def v(self):
        return filled(self.velocity, "xy")


class Slot(Plain):
    """Two translations and no rotation. input : force (2,), N."""

    kind: ClassVar[str] = "slot"
    coordinates: ClassVar[tuple] = (IN_PLANE,)

    slot: NormalOptions
    start: SlotStart = SlotStart()
    input: SomeOf("force", bare=True) = []
    output: SomeOf(*coordinate_names(coordinates), *REACTIONS) = []

    @property
    def axes(self):
        """(3, 3): the axes of the plane and its normal by column."""
        return plane_axes(self.axis)


@pytest.fixture(autouse=True)
def record(monkeypatch):
    kind = JointKind(("prismatic",) * 2, axes=lambda joint: joint.axes.T[:2], rows=(*IN_Z, *LOCKED))
    monkeypatch.setitem(JOINT_KINDS, "slot", kind)


def scene(formulation):
    """A slot on a swinging arm."""
    slot = Slot(
        slot={"normal": "x"},
        between=["a.end", "b"],
        start={"position": [0.1, 0.2], "velocity": [0.3, -0.4]},
        input="force",
        output=["position", "velocity", "reaction_force", "reaction_moment"],
    )
    arm = {
        "revolute": {"axis": [1, 2, -1]},
        "between": ["ground", "a"],
        "start": {"angle": 0.3, "speed": 1.0},
    }
    placeholder = {"planar": {}, "between": ["a.end", "b"]}
    data = Scene(
        name="slot",
        gravity=[0.5, -1.0, -9.0],
        solver={"tolerance": 1e-9, "formulation": formulation},
        body={"a": BODY, "b": BODY},
        joint={"arm": arm, "slot": placeholder},
    )
    return data.model_copy(update={"joint": {"arm": data.joint["arm"], "slot": slot}})


@pytest.mark.parametrize("force", [None, (2.0, -3.0)])
def test_formulations_agree(force):
    inputs = {} if force is None else {"slot.force[1]": force[0], "slot.force[2]": force[1]}
    one, other = (
        simulate(compile_scene(scene(way)), 0.02, 0.01, inputs) for way in ("recursive", "augmented")
    )

    for name, column in one.items():
        if force is None or "reaction" not in name:
            np.testing.assert_allclose(column, other[name], atol=1e-8, err_msg=name)


def test_force_acts_along_its_axis():
    """On the second body, in the first one's axes: what it adds to the accelerations is linear in it."""
    start = [
        simulate(compile_scene(scene("recursive")), 1e-6, 1e-6, {"slot.force[1]": x, "slot.force[2]": y})
        for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (2.0, -3.0))
    ]
    none, x, y, both = (np.array([run[f"b.acceleration[{k}]"][0] for k in (1, 2, 3)]) for run in start)
    assert np.linalg.norm(x - none) > 0.1 < np.linalg.norm(y - none)
    np.testing.assert_allclose(both - none, 2.0 * (x - none) - 3.0 * (y - none), atol=1e-12)


def test_names_and_freedoms():
    names = {v.name for v in compile_scene(scene("recursive")).variables}
    assert {f"slot.{name}[2]" for name in ("position", "velocity", "force", "position_start")} <= names
    assert structure(scene("recursive")).freedom == 3


def test_inverse_dynamics_gives_the_force_back():
    run = simulate(
        compile_scene(scene("recursive")), 0.02, 0.001, {"slot.force[1]": 2.0, "slot.force[2]": -3.0}
    )
    motion = {name: run[name] for name in ("time", "slot.position[1]", "slot.position[2]")}
    needed = inverse(scene("recursive"), motion, hybrid=True)
    np.testing.assert_allclose(needed["slot.force[1]"], 2.0, atol=1e-3)
    np.testing.assert_allclose(needed["slot.force[2]"], -3.0, atol=1e-3)
