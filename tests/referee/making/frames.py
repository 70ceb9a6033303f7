"""Places and orientations, and the ways to write them. A pose is (r (3,) in m, A (3, 3): frame to base)."""

import numpy as np
from scipy.spatial.transform import Rotation

NAMED = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "-x": (-1, 0, 0), "-y": (0, -1, 0), "-z": (0, 0, -1)}
WAYS = ("euler_parameters", "zyx_deg", "zyx_rad", "axis_deg", "axis_rad", "axes")
HERE = (np.zeros(3), np.eye(3))


def compose(outer, inner):
    """Pose of a frame that is given in one at `outer`."""
    return outer[0] + outer[1] @ inner[0], outer[1] @ inner[1]


def inverse(pose):
    """The pose the other way round."""
    return -pose[1].T @ pose[0], pose[1].T


def unit(vector):
    """(n,) of length 1."""
    return np.asarray(vector, float) / np.linalg.norm(vector)


def about(axis, angle):
    """Rotation matrix about a unit vector."""
    return Rotation.from_rotvec(angle * np.asarray(axis)).as_matrix()


def plane_axes(normal):
    """(3, 3): the x axis (the y axis where the normal is x) projected into a plane, what is normal to both,
    and the normal."""
    helper = np.eye(3)[0 if np.linalg.norm(normal[1:]) > 1e-6 else 1]
    x = unit(helper - normal * (normal @ helper))
    return np.column_stack([x, np.cross(normal, x), normal])


def axis(dice, names=0.6):
    """An axis as (written, unit vector (3,))."""
    if dice.chance(names):
        written = dice.pick(NAMED)
        return written, np.array(NAMED[written], float)

    while np.linalg.norm(written := dice.vector(1.0)) < 0.3:
        pass

    return written, unit(written)


def written_orientation(dice, A, ways=WAYS):
    """The keys of an orientation (3, 3), to rounding, in one of the ways."""
    turn, way = Rotation.from_matrix(A), dice.pick(ways)

    # yaw and roll are not told apart where the pitch is 90 degrees
    if way == "euler_parameters" or (way.startswith("zyx") and abs(A[2, 0]) > 0.999):
        return {"euler_parameters": turn.as_quat().tolist()}

    if way.startswith("zyx"):
        return {way: turn.as_euler("ZYX", degrees=way == "zyx_deg").tolist()}

    if way.startswith("axis"):
        rotvec = turn.as_rotvec()
        angle = float(np.linalg.norm(rotvec))
        direction = (rotvec / angle).tolist() if angle > 1e-9 else "z"
        value = float(np.degrees(angle)) if way == "axis_deg" else angle
        return {"axis_angle": {"axis": direction, f"angle{way[4:]}": value}}

    first, second = dice.some("xyz", 2)[:2]
    scale = dice.number(0.5, 2.0)
    return {
        "axes": {
            first: A[:, "xyz".index(first)].tolist(),
            second: (scale * A[:, "xyz".index(second)]).tolist(),
        }
    }


def orientation(dice):
    """A random orientation as (its keys in round numbers, A (3, 3))."""
    way = dice.pick(WAYS)

    if way == "euler_parameters":
        E = unit(
            dice.vector(1.0, 4)
            if dice.chance(0.5)
            else dice.pick([[0, 0, 1, 1], [1, 0, 0, 1], [1, 1, 1, 1], [0, 1, 0, 0]])
        )
        return {way: E.tolist()}, Rotation.from_quat(E).as_matrix()

    if way.startswith("zyx"):
        angles = (
            dice.numbers(3, -3, 3)
            if way == "zyx_rad"
            else [float(dice.pick(range(-180, 181, 15))) for _ in range(3)]
        )
        return {way: angles}, Rotation.from_euler("ZYX", angles, degrees=way == "zyx_deg").as_matrix()

    if way.startswith("axis"):
        written, direction = axis(dice)
        angle = dice.number(-3, 3) if way == "axis_rad" else float(dice.pick(range(-360, 361, 15)))
        turned = np.radians(angle) if way == "axis_deg" else angle
        return {"axis_angle": {"axis": written, f"angle{way[4:]}": angle}}, about(direction, turned)

    while True:
        (a, u), (b, v) = axis(dice), axis(dice)

        if np.linalg.norm(np.cross(u, v)) > 0.2:
            break

    first, second = dice.some("xyz", 2)[:2]
    columns = np.empty((3, 3))
    i, j = "xyz".index(first), "xyz".index(second)
    columns[i], columns[j] = u, unit(v - u * (u @ v))
    k = 3 - i - j
    columns[k] = np.cross(columns[(k + 1) % 3], columns[(k + 2) % 3])
    return {"axes": {first: a, second: b}}, columns.T


def place(dice, size=0.5, turned=0.6):
    """A random pose as (its keys, pose); what is zero may be left out."""
    keys, r, A = {}, np.zeros(3), np.eye(3)

    if dice.chance(0.85):
        keys["position"] = dice.vector(size)
        r = np.array(keys["position"])

    if dice.chance(turned):
        turn, A = orientation(dice)
        keys |= turn

    return keys, (r, A)


def written_pose(dice, pose, ways=WAYS):
    """The keys of a pose; what is zero may be left out."""
    r, A = pose
    keys = {} if np.abs(r).max() == 0.0 else {"position": np.asarray(r).tolist()}
    return keys if np.array_equal(A, np.eye(3)) else keys | written_orientation(dice, A, ways)
