"""The problem files of `reference/`, and scenes of what they describe.

Their conventions: SI; `inertia` = [xx, yy, zz, xy, xz, yz] about the centre of mass in body axes; `r0` centre
of mass, `q0` its orientation, scalar part FIRST; `v0`, `w0` in inertial axes; a joint's `point` and `axis`
inertial, at t = 0. `quantities` and `values`, one row a time, are the reference digits; `how_obtained` says
where from.
"""

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mbdfmi.compiler.frames import axes_with_z

REFERENCE = Path(__file__).parent / "reference"


def problem_file(name: str) -> dict:
    """A problem file; beside what it holds, `column`: quantity -> (n,), and the times `t` (n,), s."""
    data = json.loads((REFERENCE / f"{name}.json").read_text(encoding="utf-8"))
    data |= data.get("reference", {})
    data["column"] = dict(zip(data["quantities"], np.array(data["values"], float).T))
    data["t"] = data["column"].get("t")
    return data


def pose_of(body: dict) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass (3,) m and axes (3, 3), inertial, in columns, of a problem file's body at t = 0."""
    w, x, y, z = body.get("q0", [1, 0, 0, 0])
    return np.array(body.get("r0", [0, 0, 0]), float), Rotation.from_quat([x, y, z, w]).as_matrix()


def scene_of(data: dict, body_output=(), **extra) -> dict:
    """The scene of a problem's bodies, joints, spring-dampers, torques, gravity and start velocities.

    Joint markers stand at the joint's point with z along its axis, so that all joint coordinates start at
    zero. Bodies without joints get free ones. body_output: outputs of every body. `extra`: further keys of
    the scene; tables are merged.
    """
    bodies = {body["name"]: _Body(body) for body in data["bodies"]}
    bodies["ground"] = _Body({"name": "ground"})
    joints, forces = {}, {}

    for k, joint in enumerate(data["joints"]):
        axis = np.array(joint.get("axis", [0, 0, 1]), float)
        axes = axes_with_z(axis / np.linalg.norm(axis))
        name = f"{joint['type']} {k + 1}"
        ends = [bodies[joint[side]] for side in ("body_i", "body_j")]
        joints[name] = {
            joint["type"]: {},
            "between": [end.marker(f"j{k + 1}", joint["point"], axes) for end in ends],
        }
        relative = ends[1].w - ends[0].w

        if joint["type"] == "revolute" and relative @ axis:
            joints[name]["start"] = {"speed": float(relative @ axis / np.linalg.norm(axis))}
        elif joint["type"] == "spherical":
            joints[name]["start"] = {"omega": (axes.T @ relative).tolist()}

    for k, force in enumerate(data["forces"]):
        if force["type"] == "torque":
            name = bodies[force["body"]].marker(f"f{k + 1}", bodies[force["body"]].r, np.eye(3))
            forces[f"torque {k + 1}"] = {"load": {"moment": force["vector"]}, "on": name}
            continue

        ends = [
            bodies[force[f"body_{side}"]].marker(f"f{k + 1}", force[f"point_{side}"], np.eye(3))
            for side in "ij"
        ]
        spring = {"stiffness": force["k"], "damping": force["c"], "rest_length": force["l0"]}
        forces[f"spring {k + 1}"] = {"spring_damper": spring, "between": ends}

    jointed = {joint[side] for joint in data["joints"] for side in ("body_i", "body_j")}

    for name, body in bodies.items():
        if name != "ground" and name not in jointed:
            joints[f"free {name}"] = {
                "free": {},
                "between": ["ground", name],
                "start": {
                    "position": body.r.tolist(),
                    "axes": {"x": body.A[:, 0].tolist(), "y": body.A[:, 1].tolist()},
                    "velocity": body.v.tolist(),
                    "omega": body.w.tolist(),
                },
            }

    ground = bodies.pop("ground")
    tables = {
        "name": data["id"],
        "gravity": data["gravity"],
        "ground": {"marker": ground.markers},
        "body": {name: body.table() | {"output": list(body_output)} for name, body in bodies.items()},
        "joint": joints,
        "force": forces,
    }

    for key, value in extra.items():
        tables[key] = tables.get(key, {}) | value if isinstance(value, dict) else value

    return tables


class _Body:
    def __init__(self, data):
        self.data = data
        self.r, self.A = pose_of(data)
        self.v = np.array(data.get("v0", [0, 0, 0]), float)
        self.w = np.array(data.get("w0", [0, 0, 0]), float)
        self.markers = {}

    def marker(self, name, point, axes):
        """Full name of a marker at a point of the inertial frame, with these axes (columns, inertial)."""
        local = self.A.T @ axes
        self.markers[name] = {
            "position": (self.A.T @ (np.array(point, float) - self.r)).tolist(),
            "axes": {"x": local[:, 0].tolist(), "y": local[:, 1].tolist()},
        }
        return f"{self.data['name']}.{name}"

    def table(self):
        """The body as a table of a scene, its own frame at the centre of mass."""
        return {"mass": self.data["mass"], "inertia": self.data["inertia"], "marker": self.markers}
