"""Random scenes with closed loops: a random tree at a random pose, then joints between markers that fit there."""

import numpy as np
from scenes import random_orientation, rotation
from scipy.spatial.transform import Rotation

from mbdfmi import Scene
from mbdfmi.compiler.frames import IDENTITY, compose, inverse
from mbdfmi.scene.fields import plane_axes

# freedoms that a joint leaves
TREE = {
    "revolute": 1,
    "prismatic": 1,
    "screw": 1,
    "cylindrical": 2,
    "universal": 2,
    "planar": 3,
    "spherical": 3,
    "translation": 3,
    "free": 6,
}
LOOP = TREE | {
    "fixed": 0,
    "point_on_line": 4,
    "point_on_plane": 5,
    "distance": 5,
    "rolling_sphere": 3,
    "rolling_disk": 3,
    "knife_edge": 5,
    "constant_velocity": 2,
    "angle": 5,
}
del LOOP["free"]


def unit(rng):
    """A unit vector (3,)."""
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def random_pose(rng, size=0.5):
    """A pose (r, A)."""
    return size * rng.normal(size=3), rotation(random_orientation(rng)).as_matrix()


def pose_table(pose):
    """A pose as keys of a marker or of a start."""
    r, A = pose
    return {"position": r.tolist(), "euler_parameters": Rotation.from_matrix(A).as_quat().tolist()}


def about(axis, angle):
    """Rotation matrix."""
    return Rotation.from_rotvec(angle * axis).as_matrix()


def random_joint(kind, rng):
    """A joint of a kind somewhere in its range: (its table, start values as a table, pose of its second marker in the first)."""
    axis = unit(rng)
    q, v = rng.normal(size=(2, 6))
    turn = rotation(random_orientation(rng)).as_matrix()
    E = Rotation.from_matrix(turn).as_quat().tolist()
    options, start, pose = {"axis": axis.tolist()}, {}, IDENTITY

    if kind == "revolute":
        start = {"angle": q[0], "speed": v[0]}
        pose = np.zeros(3), about(axis, q[0])
    elif kind == "prismatic":
        start = {"position": q[0], "speed": v[0]}
        pose = q[0] * axis, np.eye(3)
    elif kind == "screw":
        options["pitch"] = rng.uniform(0.5, 2.0)
        start = {"angle": q[0], "angular_speed": v[0]}
        pose = options["pitch"] * q[0] / (2 * np.pi) * axis, about(axis, q[0])
    elif kind == "cylindrical":
        start = {"position": q[0], "angle": q[1], "speed": v[0], "angular_speed": v[1]}
        pose = q[0] * axis, about(axis, q[1])
    elif kind == "universal":
        axes = turn[:, :2].T
        options = {"axes": axes.tolist()}
        start = {"angles": q[:2].tolist(), "speeds": v[:2].tolist()}
        pose = np.zeros(3), about(axes[0], q[0]) @ about(axes[1], q[1])
    elif kind == "planar":
        options = {"normal": axis.tolist()}
        start = {"position": q[:2].tolist(), "angle": q[2], "velocity": v[:2].tolist(), "angular_speed": v[2]}
        pose = plane_axes(axis)[:, :2] @ q[:2], about(axis, q[2])
    elif kind == "translation":
        options = {}
        start = {"position": q[:3].tolist(), "velocity": v[:3].tolist()}
        pose = q[:3], np.eye(3)
    elif kind == "spherical":
        options = {}
        start = {"euler_parameters": E, "omega": v[:3].tolist()}
        pose = np.zeros(3), turn
    elif kind == "free":
        options = {}
        start = pose_table((q[:3], turn)) | {"velocity": v[:3].tolist(), "omega": v[3:].tolist()}
        pose = q[:3], turn
    elif kind == "point_on_plane":
        options = {"normal": axis.tolist()}
        pose = np.cross(axis, q[:3]), turn
    elif kind == "point_on_line":
        pose = q[0] * axis, turn
    elif kind in ("distance", "fixed"):
        options = {}
        pose = (q[:3], turn) if kind == "distance" else IDENTITY
    elif kind == "knife_edge":
        options = {"lateral": axis.tolist()}
        pose = q[:3], turn
    elif kind == "constant_velocity":
        normal = np.cross(axis, q[:3])
        pose = np.zeros(3), about(normal / np.linalg.norm(normal), q[3])
    elif kind == "angle":
        other = unit(rng)
        options = {
            "axes": [axis.tolist(), other.tolist()],
            "angle_deg": np.degrees(np.arccos(axis @ turn @ other)),
        }
        pose = q[:3], turn
    elif kind == "rolling_sphere":
        options = {"radius": rng.uniform(0.2, 1.0)}
        pose = np.array([q[0], q[1], options["radius"]]), turn
    elif kind == "rolling_disk":
        options["radius"] = rng.uniform(0.2, 1.0)
        height = options["radius"] * np.linalg.norm(np.cross(turn @ axis, [0, 0, 1]))
        pose = np.array([q[0], q[1], height]), turn

    return {kind: options}, start, pose


def random_body(rng):
    """Mass, centre of mass and inertia of a real body."""
    p = rng.uniform(0.05, 0.5, 3)
    return {
        "mass": rng.uniform(0.5, 2.0),
        "com": rng.normal(size=3).tolist(),
        "inertia": [p[1] + p[2], p[0] + p[2], p[0] + p[1]],
        "inertia_axes": {"euler_parameters": random_orientation(rng).tolist()},
        "marker": {},
    }


def random_loops(
    seed, loops, *, tree=tuple(TREE), couplings=0, elements=True, solver=None, freedoms=1, **tables
):
    """A random scene (a dict) with closed loops.

    loops : kinds of the joints that close them. tree : kinds of the joints of the tree, of which there are so many that
    `freedoms` or more are left. couplings : at most so many, between joints of one freedom. elements : springs, dampers, a
    strut, a load.
    """
    rng = np.random.default_rng(seed)
    bodies, joints, poses = {}, {}, {"ground": IDENTITY}
    ground = {}
    need = sum(6 - LOOP[kind] for kind in loops) + couplings + freedoms
    free = 0

    def add_marker(owner, pose):
        markers = ground if owner == "ground" else bodies[owner]["marker"]
        name = f"m{len(markers)}"
        markers[name] = pose_table(pose)
        return f"{owner}.{name}"

    while free < need or len(bodies) < 2:
        kind = str(rng.choice(tree))
        parent = str(rng.choice(list(poses)))
        name = f"body{len(bodies)}"
        bodies[name] = random_body(rng)
        near, far = random_pose(rng), random_pose(rng)
        joint, start, pose = random_joint(kind, rng)
        ends = [add_marker(parent, near), add_marker(name, far)]

        if rng.random() < 0.5:
            ends, pose = ends[::-1], inverse(pose)

        poses[name] = compose(compose(poses[parent], compose(near, pose)), inverse(far))
        joint |= {"between": ends, "start": start}

        if elements and kind in ("revolute", "prismatic"):
            joint |= {"spring": {"stiffness": rng.uniform(0, 5)}, "damper": rng.uniform(0, 1)}

        joints[f"joint{len(joints)}"] = joint
        free += TREE[kind]

    coupled = [name for name, joint in joints.items() if "revolute" in joint or "prismatic" in joint]
    rng.shuffle(coupled)
    links = {
        f"coupling{k}": {"linear": {"ratio": rng.uniform(0.5, 2)}, "between": [str(a), str(b)]}
        for k, (a, b) in enumerate(zip(coupled[: 2 * couplings : 2], coupled[1 : 2 * couplings : 2]))
    }

    for k, kind in enumerate(loops):
        first, second = rng.choice(list(poses), 2, replace=False)
        joint, _, pose = random_joint(kind, rng)
        near = random_pose(rng)
        far = compose(inverse(poses[second]), compose(poses[first], compose(near, pose)))
        joint |= {"between": [add_marker(first, near), add_marker(second, far)]}
        joints[f"loop{k}"] = joint

    scene = {
        "name": "loops",
        "gravity": (5 * unit(rng)).tolist(),
        "ground": {"marker": ground},
        "body": bodies,
        "joint": joints,
        "coupling": links,
        "solver": solver or {},
    } | tables

    if elements:
        pair = [
            add_marker(str(owner), random_pose(rng)) for owner in rng.choice(list(poses), 2, replace=False)
        ]
        name = str(rng.choice(list(bodies)))
        scene["force"] = {
            "strut": {
                "spring_damper": {"stiffness": 3.0, "damping": 0.5, "rest_length": 0.5},
                "between": pair,
            },
            "load": {
                "load": {"force": rng.normal(size=3).tolist(), "moment": rng.normal(size=3).tolist()},
                "on": name,
            },
        }

    return scene


def with_solver(scene, **solver):
    """The scene with other settings."""
    return Scene.model_validate(scene | {"solver": scene["solver"] | solver})
