"""The problems of the report: what moves, for how long, and which quantities are compared with reference
digits.

A problem is told to every contestant in the words of its file (see `problem_files`), and every contestant
answers in the same words: the motion of all bodies' centres of mass at the reference times (`Motion`). So one
function finds the compared quantities for all of them. Problems that those words cannot tell (`scene`) are
run by our own steppers.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from .problem_files import pose_of, problem_file, scene_of
from .reference.derive import HOLD, arm_torques

# of each body at each time: position (m), Euler parameters (scalar LAST), velocity (m/s), angular velocity
# (rad/s)
MOTION_SIZE = 13
BODY_OUTPUT = ("position", "euler_parameters", "velocity", "omega")

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
STEP_PARTS = (1, 1 / 4, 1 / 16, 1 / 64, 1 / 256)


class Motion:
    """Motion of a problem's bodies: table (n_t, n_body, MOTION_SIZE), of centres of mass, inertial axes."""

    def __init__(self, data: dict, table: np.ndarray):
        self.bodies = {body["name"]: k for k, body in enumerate(data["bodies"])}
        self.data = data
        self.table = table

    def position(self, body: str) -> np.ndarray:
        """(3, n_t), m."""
        return self._columns(body, 0, 3)

    def velocity(self, body: str) -> np.ndarray:
        """(3, n_t), m/s."""
        return self._columns(body, 7, 10)

    def omega(self, body: str) -> np.ndarray:
        """(3, n_t), rad/s, inertial axes."""
        return self._columns(body, 10, 13)

    def quaternion(self, body: str) -> np.ndarray:
        """(4, n_t), scalar part FIRST, as in the problem files."""
        return self._columns(body, 3, 7)[[3, 0, 1, 2]]

    def axes(self, body: str) -> np.ndarray:
        """(n_t, 3, 3): columns are the body's axes, inertial."""
        return Rotation.from_quat(self._columns(body, 3, 7).T).as_matrix()

    def omega_body(self, body: str) -> np.ndarray:
        """(3, n_t), rad/s, body axes."""
        return np.einsum("tji,jt->it", self.axes(body), self.omega(body))

    def angle(self, body: str) -> np.ndarray:
        """(n_t,) rad, in (-pi, pi], of the body's x axis from the inertial one, about z."""
        A = self.axes(body)
        return np.arctan2(A[:, 1, 0], A[:, 0, 0])

    def point(self, body: str, point) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity (3, n_t) of a body's point, given where it is at t = 0 (m, inertial)."""
        r, A = pose_of(self.data["bodies"][self.bodies[body]])
        arm = np.einsum("tij,j->it", self.axes(body), A.T @ (np.array(point, float) - r))
        return self.position(body) + arm, self.velocity(body) + np.cross(self.omega(body), arm, axis=0)

    def _columns(self, body, start, stop):
        return self.table[:, self.bodies[body], start:stop].T


@dataclass(frozen=True)
class Problem:
    """One problem.

    name : of its file in `reference/`.
    title : for tables and plots.
    observe : Motion -> the compared quantities, names as in the file -> (n_t,).
    step : s, the longest step of contestants of fixed step; they are given parts of it.
    until : s, the last reference time, or None.
    change : data -> changes to the file's data that leave the compared motion as it is, or None.
    scene : data -> our scene where the file's words do not tell it, or None.
    inputs : data -> (s that they are held for, their values (n, n_u)) of our scene, or None.
    sharper : factor of the tolerances, where the motion makes errors grow.
    quick : whether `--quick` has it.
    """

    name: str
    title: str
    observe: Callable[[Motion], dict]
    step: float
    until: float | None = None
    change: Callable[[dict], dict] | None = None
    scene: Callable[[dict], dict] | None = None
    inputs: Callable[[dict], tuple[float, np.ndarray]] | None = None
    sharper: float = 1.0
    quick: bool = False

    @cached_property
    def data(self) -> dict:
        """The problem file, with `t` (n_t,) and `column` up to the last reference time compared."""
        data = problem_file(self.name)
        used = (data["t"] > 0) & (data["t"] <= (self.until or np.inf))
        data["column"] = {name: column[used] for name, column in data["column"].items()}
        data["t"] = data["t"][used]
        return data | (self.change(data) if self.change else {})

    @property
    def times(self) -> np.ndarray:
        """Reference times (n_t,), s, after the start at 0."""
        return self.data["t"]

    @property
    def tolerances(self) -> list[float]:
        """Of adaptive contestants, from loose to tight."""
        return [tolerance * self.sharper for tolerance in TOLERANCES]

    @property
    def steps(self) -> list[float]:
        """Of contestants of fixed step, s, from long to short."""
        return [part * self.step for part in STEP_PARTS]

    def scene_tables(self, solver: dict) -> dict:
        """Our scene, as a dict, with these solver settings; outputs: BODY_OUTPUT of every body in order."""
        if not self.scene:
            return scene_of(self.data, BODY_OUTPUT, solver=solver)

        return self.scene(self.data) | {"solver": solver}

    def error(self, table: np.ndarray) -> float:
        """The error of a motion (n_t, n_body, MOTION_SIZE).

        The largest difference of any compared quantity at any reference time, in the largest reference value
        of that quantity; of Euler parameters (both signs are one orientation) and of angles, in 1.
        """
        wanted = self.data["column"]
        found = self.observe(Motion(self.data, table))

        if "q0" in found:
            names = ["q0", "q1", "q2", "q3"]
            sign = np.sign(sum(found[name] * wanted[name] for name in names))
            found = found | {name: sign * found[name] for name in names}

        return float(max(self._difference(name, x, wanted[name]).max() for name, x in found.items()))

    def _difference(self, name, found, wanted):
        if name in ANGLES or name.startswith("q"):
            difference = found - wanted
            turns = np.round(difference / (2 * np.pi)) if name in ANGLES else 0.0
            return np.abs(difference - 2 * np.pi * turns)

        return np.abs(found - wanted) / np.abs(wanted).max()


# quantities that are known but for full turns
ANGLES = {"theta1", "theta2", "theta3", "theta4", "theta5", "theta6", "theta7", "theta8", "theta9", "theta10"}
ANGLES |= {
    "beta",
    "theta",
    "gamma",
    "phi",
    "delta",
    "omega",
    "epsilon",
    "shaft_angle",
    "crank",
    "coupler",
    "rocker",
}


# what is compared


def _chain(n, rates=False, velocities=True):
    """Tip and angles, from the lowest position, of n bars in a row."""

    def observe(motion):
        name = f"bar{n}"
        r0, A0 = pose_of(motion.data["bodies"][-1])
        r, v = motion.point(name, r0 + 0.5 * A0[:, 0])
        found = {"tip_x": r[0], "tip_y": r[1]}
        found |= {"tip_vx": v[0], "tip_vy": v[1]} if velocities else {}

        for k in range(1, n + 1):
            found[f"theta{k}"] = motion.angle(f"bar{k}") + np.pi / 2
            found |= {f"theta{k}d": motion.omega(f"bar{k}")[2]} if rates else {}

        return found

    return observe


def _pose(body, *parts):
    """The parts "position", "velocity", "quaternion", "omega_body" of one body."""
    names = {
        "position": ("x", "y", "z"),
        "velocity": ("vx", "vy", "vz"),
        "quaternion": ("q0", "q1", "q2", "q3"),
        "omega_body": ("wx_body", "wy_body", "wz_body"),
    }

    def observe(motion):
        return {name: x for part in parts for name, x in zip(names[part], getattr(motion, part)(body))}

    return observe


def _four_bar(motion):
    x, y, _ = motion.position("coupler")
    found = {name: motion.angle(name) for name in ("crank", "coupler", "rocker")}
    return found | {"crank_rate": motion.omega("crank")[2], "coupler_x": x, "coupler_y": y}


def _many_four_bars(motion):
    r, v = motion.point("V0", [0, 1, 0])
    return {"B0_x": r[0], "B0_y": r[1], "B0_vx": v[0], "B0_vy": v[1]}


def _andrews(motion):
    """Angles of the mechanism from those of its bodies, and their rates."""
    found = {}

    for suffix, of in (("", motion.angle), ("_dot", lambda body: motion.omega(body)[2])):
        beta, gamma, delta, epsilon = (of(name) for name in ("K1_OF", "K3_BDE", "K5_AG", "K7_AH"))
        angles = {
            "beta": beta,
            "theta": of("K2_FE") - beta,
            "gamma": gamma,
            "delta": delta,
            "epsilon": epsilon,
        }
        angles |= {"phi": of("K4_EG") - delta, "omega": of("K6_HE") - epsilon}
        found |= {f"{name}{suffix}": angle for name, angle in angles.items()}

    return found


def _bricard(motion):
    r, v = motion.point("rod3", [1, -1, 1])
    return {f"P3_{c}": r[k] for k, c in enumerate("xyz")} | {f"P3_v{c}": v[k] for k, c in enumerate("xyz")}


def _governor(motion):
    """beta : of the rods, below the horizontal; s : the slider's height."""
    A, w = motion.axes("shaft"), motion.omega("rod_AC") - motion.omega("shaft")
    return {
        "beta": -np.arcsin(motion.axes("rod_AC")[:, 2, 0]),
        "s": motion.position("slider")[2],
        "shaft_angle": motion.angle("shaft"),
        "beta_dot": np.einsum("tj,jt->t", A[:, :, 1], w),
        "s_dot": motion.velocity("slider")[2],
        "shaft_rate": motion.omega("shaft")[2],
    }


def _disk(motion):
    found = {f"com{c}": x for c, x in zip("xyz", motion.position("disk"))}
    found |= {f"comv{c}": x for c, x in zip("xyz", motion.velocity("disk"))}
    return found | _pose("disk", "quaternion", "omega_body")(motion)


def _bead(motion):
    return {"x": motion.position("bead")[0], "xd": motion.velocity("bead")[0]}


# changes that leave the motion as it is


def _with_thickness(data):
    """Bars that are thin by definition get a moment about their axis, about which they do not turn."""
    bodies = [
        body | {"inertia": [J or 1e-3 for J in body["inertia"][:3]] + [0, 0, 0]} for body in data["bodies"]
    ]
    return {"bodies": bodies}


def _with_a_ball(data):
    """The point becomes a ball of J = 0.1 kg m2 that does not spin, in 1 + J / (m l^2) times the weight."""
    body = data["bodies"][0] | {"inertia": [0.1, 0.1, 0.1, 0, 0, 0], "v0": [0, 2, 0], "w0": [0, 0, 2]}
    joint = {"type": "spherical", "body_i": "ground", "body_j": body["name"], "point": [0, 0, 0]}
    return {"bodies": [body], "joints": [joint], "forces": [], "gravity": [0, 0, -1.1 * 9.81]}


# scenes that the files' words cannot tell


def _disk_scene(data):
    body = data["bodies"][0]
    r, A = pose_of(body)
    w = A @ [0, 0, 3] + [0, 0, 0.5]
    m = np.array([0, 0, 1]) - A[2, 2] * A[:, 2]
    start = {
        "position": r.tolist(),
        "euler_parameters": [*body["q0"][1:], body["q0"][0]],
        "velocity": np.cross(w, m / np.linalg.norm(m)).tolist(),
        "omega": w.tolist(),
    }
    return {
        "name": "rolling disk",
        "gravity": data["gravity"],
        "body": {"disk": {"mass": body["mass"], "inertia": body["inertia"], "output": list(BODY_OUTPUT)}},
        "joint": {
            "free": {"free": {}, "between": ["ground", "disk"], "start": start},
            "roll": {"rolling_disk": {"radius": 1.0}, "between": ["ground", "disk"]},
        },
    }


def _bead_scene(data):
    start = {"position": data["bodies"][0]["r0"]}
    return {
        "name": "bead",
        "gravity": data["gravity"],
        "ground": {"marker": {"wire": {"curve": {"parabola": {"coefficient": 0.5}}}}},
        "body": {"bead": {"mass": 1.0, "inertia": [0.1] * 3, "output": list(BODY_OUTPUT)}},
        "joint": {
            "hold": {"translation": {}, "between": ["ground", "bead"], "start": start},
            "wire": {"point_on_curve": {}, "between": ["ground.wire", "bead"]},
        },
    }


def _lift(motion):
    """Of the shoe, and the height of the uppermost bar's middle."""
    top = motion.data["bodies"][-2]["name"]
    found = {"shoe_x": motion.position("shoe")[0], "shoe_vx": motion.velocity("shoe")[0]}
    return found | {"top_y": motion.position(top)[1]}


def _net(motion):
    n = round(len(motion.bodies) ** 0.5)
    middle, corner = f"ball{n * (n // 2) + n // 2 + 1}", f"ball{n}"
    found = {"middle_z": motion.position(middle)[2], "middle_vz": motion.velocity(middle)[2]}
    return found | dict(zip(("corner_y", "corner_z"), motion.position(corner)[1:]))


def _bars(n):
    """Angles from the lowest position, and their rates, of n bars in a row."""

    def observe(motion):
        found = {f"theta{k}": motion.angle(f"bar{k}") + np.pi / 2 for k in range(1, n + 1)}
        return found | {f"theta{k}d": motion.omega(f"bar{k}")[2] for k in range(1, n + 1)}

    return observe


def _arm_scene(data):
    """Torques at both joints as inputs."""
    tables = scene_of(data, BODY_OUTPUT)
    tables["joint"] = {name: joint | {"input": "torque"} for name, joint in tables["joint"].items()}
    return tables


def _held_torques(data):
    """Of the arm, up to the last reference time."""
    return float(HOLD), arm_torques(round(data["t"][-1] / float(HOLD)))


def _stop_scene(data):
    """The joint's angle counts from where the bar starts."""
    tables = scene_of(data, BODY_OUTPUT)
    (joint,) = tables["joint"].values()
    A = pose_of(data["bodies"][0])[1]
    start = np.arctan2(A[1, 0], A[0, 0]) + np.pi / 2
    joint["stop"] = {"upper": data["stop"]["upper"] - start, "stiffness": data["stop"]["stiffness"]}
    return tables


PROBLEMS = (
    Problem("double_pendulum_bars", "double pendulum, 5 s", _chain(2, True, False), 0.02, 5.0, quick=True),
    Problem("chain_bars_N7", "chain of 7 bars, 5 s", _chain(7), 0.02, quick=True),
    Problem("chain_bars_N10", "chain of 10 bars, 1 s", _chain(10), 0.02),
    Problem("spherical_pendulum", "spherical pendulum, 10 s", _pose("P", "position", "velocity"), 0.02,
            change=_with_a_ball),
    Problem("heavy_top_bruls", "heavy top, 2 s", _pose("top", "position", "quaternion", "omega_body"), 2e-3,
            quick=True),
    Problem("steady_precession_cone_top", "cone in steady precession, 2 s",
            _pose("cone", "position", "quaternion"), 2e-3),
    Problem("torque_free_axisymmetric", "tumbling symmetric body, 100 s", _pose("body", "quaternion"), 0.05),
    Problem("dzhanibekov_jacobi", "body about its middle axis, 100 s",
            _pose("body", "quaternion", "omega_body"), 0.1, sharper=1e-2),
    Problem("gimbal_lock_pass", "ball through gimbal lock, 6.3 s", _pose("body", "quaternion"), 0.1),
    Problem("four_bar", "four-bar, 5 s", _four_bar, 0.01, quick=True),
    Problem("A02_n_four_bar_N1", "A02: four-bar with singular positions, 10 s", _many_four_bars, 0.01, 10.0,
            _with_thickness),
    Problem("A02_n_four_bar_N2", "A02: two four-bars in a row, 10 s", _many_four_bars, 0.01, 10.0,
            _with_thickness),
    Problem("A03_andrews_iftomm", "A03: Andrews' mechanism, 0.05 s", _andrews, 2e-4),
    Problem("ivp_andrews", "Andrews' mechanism of the IVP test set, 0.05 s", _andrews, 2e-4),
    Problem("A04_bricard_square", "A04: Bricard's mechanism, 10 s", _bricard, 0.01),
    Problem("A05_flyball_governor", "A05: stiff flyball governor, 10 s", _governor, 0.01),
    Problem("rolling_disk_thin", "rolling disk, 10 s", _disk, 0.02, scene=_disk_scene),
    Problem("bead_on_parabola", "bead on a parabola, 10 s", _bead, 0.02, scene=_bead_scene),
    Problem("scissor_lift_100", "scissor lift of 100 cells, 2 s", _lift, 0.01),
    Problem("spring_net_12", "net of 144 balls, 1 s", _net, 0.004),
    Problem("arm_held_torques", "arm, other torques every 2 ms, 5 s", _bars(2), 0.002, scene=_arm_scene,
            inputs=_held_torques),
    Problem("bar_on_a_stop", "bar on an elastic stop, 5 s", _bars(1), 0.005, scene=_stop_scene),
)  # fmt: skip
