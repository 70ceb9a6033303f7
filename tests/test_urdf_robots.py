"""Robots of the package example-robot-data (PyPI): all of them are read, and move as Pinocchio says.

Long; skipped aloud where the package, or Pinocchio (PyPI: pin), is not there.
"""

import sysconfig
from pathlib import Path

import numpy as np
import pytest

import mbdfmi
from mbdfmi.run.instance import Instance
from mbdfmi.scene import SceneError
from mbdfmi.scene.import_ import UrdfOptions, read_urdf

pytestmark = pytest.mark.long

ROBOTS = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"
FILES = sorted(path.relative_to(ROBOTS).as_posix() for path in ROBOTS.rglob("*.urdf"))
NO_ROBOT = "ur_description/urdf/ur3.urdf"

REPAIRED = {
    "icub_description/robots/icub.urdf",
    "icub_description/robots/icub_reduced.urdf",
    "romeo_description/urdf/romeo_laas_small.urdf",
    "tiago_description/robots/tiago.urdf",
    "tiago_description/robots/tiago_dual.urdf",
    "tiago_description/robots/tiago_no_hand.urdf",
}
"""Robots with negative principal moments of inertia, which the reader raises to 0."""

STATES = 3
TOLERANCE = 1e-9

robots = pytest.mark.skipif(not FILES, reason="no example-robot-data (pip install example-robot-data pin)")


@robots
def test_all_are_there():
    """As many as were looked at when this was written."""
    assert len(FILES) == 69


@robots
def test_one_is_no_robot():
    with pytest.raises(SceneError, match="there is no <link> in it"):
        mbdfmi.load(ROBOTS / NO_ROBOT)


class Reference:
    """A robot in Pinocchio; joints that mimic others follow them by G, q = G q_independent + offset."""

    def __init__(self, path, free, moving):
        """`moving` names the joints of the scene: Pinocchio divides by zero where one moves nothing."""
        import pinocchio

        root = (pinocchio.JointModelFreeFlyer(),) if free else ()
        model = pinocchio.buildModelFromUrdf(str(path), *root)
        still = [
            k
            for k, name in enumerate(model.names)
            if k and name != "root_joint" and plain(name) not in moving
        ]
        reduced = pinocchio.buildReducedModel(model, still, pinocchio.neutral(model)) if still else model
        self.pin, self.model = pinocchio, reduced
        self.data = self.model.createData()

    def joints(self):
        """Names of the joints of one freedom."""
        return [name for name in self.model.names[1:] if name != "root_joint"]

    def accelerations(self, q, v, tau, followers):
        """{joint: acceleration}, and those of the base (6,), in the base's axes, or nothing.

        q, v, tau : {joint: number}, the base at rest in its zero position. followers : {joint: (leader, multiplier)}.
        """
        pin, model, data = self.pin, self.model, self.data
        position, speed, effort = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        places = {}

        for name in self.joints():
            joint = model.joints[model.getJointId(name)]
            places[name] = joint.idx_v
            speed[joint.idx_v], effort[joint.idx_v] = v[name], tau[name]
            position[joint.idx_q : joint.idx_q + joint.nq] = (
                [np.cos(q[name]), np.sin(q[name])] if joint.nq == 2 else [q[name]]
            )

        base = range(model.nv - len(places))
        free = [name for name in places if name not in followers]
        G = np.zeros((model.nv, len(base) + len(free)))
        G[base, base] = 1.0

        for k, name in enumerate(free, len(base)):
            G[places[name], k] = 1.0
        for name, (leader, ratio) in followers.items():
            G[places[name], len(base) + free.index(leader)] = ratio

        M = pin.crba(model, data, position)
        M = np.triu(M) + np.triu(M, 1).T
        bias = pin.nonLinearEffects(model, data, position, speed)

        if followers:
            a = G @ np.linalg.solve(G.T @ M @ G, G.T @ (effort - bias))
        else:
            a = pin.aba(model, data, position, speed, effort)

        return {name: a[k] for name, k in places.items()}, a[base]


def random_state(tables, random):
    """q, v and tau by joint of the scene, of those that follow no other; followers {joint: (leader, ratio, offset)}."""
    followers = {}

    for coupling in tables.get("coupling", {}).values():
        leader, follower = coupling["between"]
        followers[follower] = (leader, coupling["linear"]["ratio"], coupling["linear"]["offset"])

    moving = [name for name, joint in tables["joint"].items() if {"revolute", "prismatic"} & set(joint)]
    q, v, tau = ({name: random.normal() for name in moving} for _ in range(3))

    for name in moving:
        chain, ratio, offset = name, 1.0, 0.0
        while chain in followers:
            chain, by, more = followers[chain]
            ratio, offset = ratio * by, offset + ratio * more if chain != name else more
        if chain != name:
            q[name], v[name], tau[name] = ratio * q[chain] + offset, ratio * v[chain], 0.0
            followers[name] = (chain, ratio, offset)

    return q, v, tau, followers


def compared(file, base):
    """The largest difference of accelerations from Pinocchio's by their size, over random states."""
    imported = read_urdf(ROBOTS / file, UrdfOptions(base=base))
    tables, free = imported.tables, base == "free"
    changed = any("raised to 0" in line for line in imported.decided)
    random = np.random.default_rng(1)

    moving = [name for name, joint in tables["joint"].items() if {"revolute", "prismatic"} & set(joint)]

    for name in moving:
        tables["joint"][name]["output"] = ["acceleration"]
    if free:
        root = tables["joint"]["base"]["between"][1]
        tables["body"][root]["output"] = ["acceleration", "alpha"]

    model = mbdfmi.Scene(**tables).compile()
    reference, worst = Reference(ROBOTS / file, free, moving), 0.0
    names = {plain(name): name for name in reference.joints()}

    for _ in range(STATES):
        q, v, tau, followers = random_state(tables, random)
        parameters, inputs = {}, {}
        places = {variable.name: variable.index for variable in model.of_causality("input")}

        for name in q:
            kind = "angle" if "revolute" in tables["joint"][name] else "position"
            if name not in followers:
                parameters |= {f"{name}.{kind}_start": q[name], f"{name}.speed_start": v[name]}
                effort = f"{mbdfmi.scene.fmi_name(name)}.{'torque' if kind == 'angle' else 'force'}"
                inputs[places[effort]] = tau[name]

        instance = Instance(model, parameters, inputs=inputs)
        found = dict(zip((variable.name for variable in model.of_causality("output")), instance.outputs()))

        for name in q:
            joint = tables["joint"][name]
            friction = joint.get("friction", {}).get("coulomb", 0.0)
            tau[name] -= joint.get("damper", 0.0) * v[name] + friction * np.tanh(v[name] / 3.7e-7)

        expected, of_base = reference.accelerations(
            *({names[name]: values.get(name, 0.0) for name in names} for values in (q, v, tau)),
            {names[name]: (names[leader], ratio) for name, (leader, ratio, _) in followers.items()},
        )
        own = np.array([found[f"{mbdfmi.scene.fmi_name(name)}.acceleration"] for name in q])
        theirs = np.array([expected[names[name]] for name in q])

        if free:
            body = mbdfmi.scene.fmi_name(root)
            own = np.append(
                own, [found[f"{body}.{key}[{i}]"] for key in ("acceleration", "alpha") for i in (1, 2, 3)]
            )
            theirs = np.append(theirs, of_base)

        assert np.all(np.isfinite(theirs))
        worst = max(worst, np.abs(own - theirs).max(initial=0.0) / np.abs(theirs).max(initial=1.0))

    return worst, changed


def plain(name):
    """A joint's name in a scene."""
    return name.replace(".", "_")


@robots
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", [file for file in FILES if file != NO_ROBOT])
def test_accelerations_are_those_of_pinocchio(file, base):
    pytest.importorskip("pinocchio", reason="no Pinocchio (pip install pin)")
    worst, changed = compared(file, base)

    assert changed == (file in REPAIRED)
    assert worst < TOLERANCE or changed
