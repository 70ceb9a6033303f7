"""Start values in absolute coordinates, found in relative ones."""

import numpy as np

from ..kernels import entry
from ..kernels.dynamics import rates
from ..kernels.joints import KINDS, N_Q, N_V
from ..kernels.motion import coordinates
from ..kernels.status import MESSAGES, OK, SINGULAR_INERTIA
from ..rotations import Rotation
from ..scene import Problem, SceneError
from ..vectors import cross, dot
from .builder import Place
from .variables import dotted


def start_motion(model):
    """How the bodies and joints of a model in relative coordinates start once its loops are closed.

    Returns (body -> (q (7,) [r m, E], v (6,) [velocity m/s, angular velocity rad/s]) of the body's node, in the ground's axes, and
    (joint of the tree, which of its nodes) -> (its q, its v); angles of joints: (joint, which of its coordinates) -> rad).
    """
    m, d = model.views()

    told = [entry.prepare(m, d), entry.initialise(m, d, 0.0)]
    told += [rates.evaluate(m, d, 0.0)] if told == [OK, OK] else []
    _check_inertia(model, next((status for status in told if status != OK), OK))

    # for the poses and velocities that outputs are of; what else fails here, as a loop that does not close, fails too when
    # the model in absolute coordinates starts, and is told then
    entry.compute_outputs(m, d, np.zeros(model.n_y))
    r, rd, w = (array.reshape(-1, 3) for array in (d.r, d.rd, d.w))
    A = d.A.reshape(-1, 3, 3)
    g = model.tree.home["ground"][0]
    motion = {}

    to_ground = A[g].T

    for body, (i, _) in model.tree.home.items():
        span = r[i] - r[g]
        seen = rd[i] - rd[g] - cross(w[g], span)
        E = Rotation.from_matrix(dot(to_ground, A[i])).as_quat()
        q = np.concatenate([dot(to_ground, span), E])
        v = np.concatenate([dot(to_ground, seen), dot(to_ground, w[i] - w[g])])
        motion[body] = (q, v)

    for i, node in enumerate(model.tree.nodes):
        if node.joint:
            q, v = m.body_q[i], m.body_v[i]
            kind = KINDS[node.kind]
            motion[node.joint, node.coordinate] = (d.q[q : q + N_Q[kind]], d.v[v : v + N_V[kind]])

    return motion, _angles(model, m, d)


def keeps_start(model) -> bool:
    """Whether a model's loops are closed at its start values, so that its start does not move them."""
    m, d = model.views()

    if entry.prepare(m, d) != OK or entry.initialise(m, d, 0.0) != OK:
        return False

    given = np.concatenate([m.q_start, m.v_start])
    return bool(np.all(np.abs(d.x[: len(given)] - given) < 1e-8 * (1.0 + np.abs(given))))


def _check_inertia(model, told):
    """Raises SceneError where a part's motion is not determined: absolute coordinates do not tell a hinge's from an idle turn."""
    if told % 256 == SINGULAR_INERTIA:
        raise SceneError([Problem((), MESSAGES[SINGULAR_INERTIA] % model.places[told // 256])])


def _angles(model, m, d):
    """(joint, which of its coordinates) -> angle (rad), turns included."""
    angles = {
        (node.joint, node.coordinate): float(d.q[m.body_q[i]])
        for i, node in enumerate(model.tree.nodes)
        if node.kind == "revolute"
    }
    turns = {key: m.coordinate_turn[k] for key, k in model.coordinates.items()}
    return angles | {key: float(d.z[coordinates.turn(m, t)]) for key, t in turns.items() if t >= 0}


def add_absolute_starts(builder, motion):
    """Start values of nodes that hang freely on the ground, as parameters named after their first body.

    And of joints that are in the tree still, whose parameters joint_starts.py has added.
    """
    ground = builder.tree.home["ground"][0]

    for i, node in enumerate(builder.nodes):
        if i <= ground:
            continue

        if node.part and node.coordinate > 0:  # of a chain whose first node has the values of all
            continue

        q, v = motion[node.part if node.part else (node.joint, node.coordinate)]
        builder.single["q_start"][builder.q[i] : builder.q[i] + len(q)] = q
        builder.single["v_start"][builder.v[i] : builder.v[i] + len(v)] = v

        if node.part:
            _add_parameters(builder, i, node, q, v)


def _add_parameters(builder, i, node, q, v):
    """The start values of a part that hangs on the ground as parameters: of a pose, or of a motion in a plane."""
    name, free = node.part, node.kind == "free"
    n = 3 if free else 2
    frame = (
        "its frame in the ground's axes"
        if free
        else "along two axes of the plane that all moves in, and about its normal"
    )

    for quantity, array, at, values, unit in (
        ("position", "q_start", builder.q[i], q[:n], "m"),
        (
            "euler_parameters" if free else "angle",
            "q_start",
            builder.q[i] + n,
            q[n:],
            None if free else "rad",
        ),
        ("velocity", "v_start", builder.v[i], v[:n], "m/s"),
        ("omega", "v_start", builder.v[i] + n, v[n:], "rad/s"),
    ):
        about = f"{quantity.replace('_', ' ')} of the moving part of {name} at the start, {frame}"
        values = values if len(values) > 1 else float(values[0])
        builder.add_start(dotted(name, f"{quantity}_start"), Place(array, at), values, unit, about, i)

    if free:
        builder.add_zyx(dotted(name, "zyx_start"), f"the moving part of {name}", i, q[3:])
