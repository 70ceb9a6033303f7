"""The scene as a system of equations."""

import numpy as np

from . import joints, outputs
from .acting import element
from .contacts import COUNT, Contact
from .efforts import JointParts
from .equations import STILL, of_kind
from .instant import Hints, Instant
from .mass import mass_properties
from .motion import Driver, Ground, Inputs
from .reading import Parameters, cross, kind_of, listed, pose, si
from .simulate import run
from .starts import motions_at_start

SIXES = ("linear", "bushing", "torsion", "hydrodynamics")
COUPLINGS = ("gear", "rack", "screw", "linear")


def unknown(data):
    """Names of the joints and forces of a scene that this route has no equations for: it knows no waves at members."""
    waves = "waves" in data.get("sea", {})
    members = [name for name, table in data.get("force", {}).items() if "member" in table]
    pushed = [n for n in members if data["force"][n]["member"].get("added_mass") is not None]
    return (members if waves else pushed) + [
        name
        for name, table in data.get("joint", {}).items()
        if not any(kind in table for kind in joints.KINDS)
    ]


class Joint:
    """A joint of the scene: its kind and options, what acts in it, its driver."""

    def __init__(self, given, name, table):
        self.name = name
        self.kind = kind_of(table, joints.KINDS)
        self.options = dict(table[self.kind])
        # what leaves a spin free has other equations
        self.kind += " free" if self.options.get("spin") == "free" else ""
        self.ends = table["between"]
        self.coordinates = joints.COORDINATES.get(self.kind, [])
        self.geometry = joints.geometry(self.kind, self.options)
        self.parts = JointParts(given, name, table) if self.kind in joints.SINGLE else None
        self.inputs = listed(table.get("input"))
        self.start = table.get("start") or {}
        self.driver = None
        turning = table.get("turning")
        self.rotor = turning and tuple(
            given(turning[key], name, "turning", key) for key in ("inertia", "ratio")
        )

        if self.kind == "prescribed":
            self.pose = self._pose_drivers(given, table["driver"])
        elif table.get("driver"):
            self.driver = Driver(given, [name], table["driver"], joints.SINGLE.get(self.kind, "s"))

    def _pose_drivers(self, given, table):
        """(driver, where it starts) of each of x, y, z, yaw, pitch, roll; what none moves is held."""
        start = [*self.start.get("position", [0.0] * 3), *si(self.start, "zyx", np.zeros(3))]
        names = zip(("x", "y", "z", "yaw", "pitch", "roll"), ["position"] * 3 + ["angle"] * 3)
        return [
            (Driver(given, [self.name, key], table.get(key) or {"hold": True}, quantity), float(at))
            for (key, quantity), at in zip(names, start)
        ]

    def asked(self, t, begun, inputs, seen=None):
        """(3, 6) what the drivers of a prescribed joint ask for at t, with rates and second rates, NaN where nobody knows.

        begun : s, time of the start. seen : the same, of what inputs do not tell.
        """
        seen = [[None] * 6] * 3 if seen is None else seen
        found = [
            driver.target(t, (start, begun), inputs, [row[k] for row in seen])
            for k, (driver, start) in enumerate(self.pose)
        ]
        return np.array(found, float).T

    def angle_names(self):
        """(index of the coordinate, name of the output, its element) of each angle."""
        names = [name for name, _, _ in self.coordinates]
        return [
            (k, name, names[:k].count(name) if names.count(name) > 1 else None)
            for k, (name, _, angular) in enumerate(self.coordinates) if angular
        ]  # fmt: skip


class Coupling:
    """Factors times coordinates add up to a constant; None: to what they are at the start."""

    def __init__(self, name, table):
        kind = kind_of(table, COUPLINGS)
        spec = table[kind]
        self.name, self.between = name, table["between"]

        if "coefficients" in spec:
            self.factors, self.constant = np.array(spec["coefficients"], float), spec.get("constant")
            return

        ratio = (
            spec["radius"]
            if kind == "rack"
            else spec["pitch"] / (2 * np.pi)
            if kind == "screw"
            else spec["ratio"]
        )
        self.factors, self.constant = np.array([-ratio, 1.0]), si(spec, "offset")


class System:
    """A scene as the dict of its TOML file, with values of parameters by variable name.

    What a scene leaves to the start (a strut's rest length, the length of a distance, offsets of couplings,
    the side on which something rolls, where a held joint stands) is read off when `evaluate` is called first.
    """

    def __init__(self, data, parameters=None):
        self.given = given = Parameters(parameters)
        self.data = data
        bodies = data.get("body", {})
        self.bodies = list(bodies)
        self.owners = ["ground", *bodies]
        self.place = {owner: slice(6 * k, 6 * k + 6) for k, owner in enumerate(self.owners)}
        self._ends = {}
        self.mass = {}

        for name, body in bodies.items():
            mass, com, inertia = mass_properties(body)
            six = given(inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]], name, "inertia")
            inertia = np.array([[six[0], six[3], six[4]], [six[3], six[1], six[5]], [six[4], six[5], six[2]]])
            self.mass[name] = given(mass, name, "mass"), given(com, name, "com"), inertia

        central = data.get("central_gravity")
        self.mu = given(central["mu"], "central_gravity", "mu") if central else 0.0
        self.gradient = bool(central and central.get("gradient"))
        gravity = data.get("gravity", [0.0, 0.0, 0.0] if central else [0.0, 0.0, -9.81])
        self.gravity = given(np.array(gravity, float), "gravity")
        self.ground = Ground((data.get("ground") or {}).get("motion"))
        self.joints = {name: Joint(given, name, table) for name, table in data.get("joint", {}).items()}
        self.couplings = {name: Coupling(name, table) for name, table in data.get("coupling", {}).items()}
        self.elements = {
            name: element(given, name, self._about_its_point(name, table), data, self.end)
            for name, table in data.get("force", {}).items()
        }
        self.contacts = {
            name: Contact(joint, [self._frame_table(end) for end in joint.ends])
            for name, joint in self.joints.items() if joint.kind in COUNT
        }  # fmt: skip
        self.sixes = [e for e in self.elements.values() if e.kind in SIXES]
        self.n_s = sum(contact.count for contact in self.contacts.values())
        self.width = 6 * len(self.owners) + self.n_s
        self.started = None
        given.check()

    def changed(self, parameters):
        """The system with other values of some parameters from now on;
        what the scene leaves to the start stays."""
        system = System(self.data, self.given.values | Parameters(parameters).values)
        system.started = self.started
        return system

    # frames

    def _frame_table(self, end):
        """The table of a marker, {} for an owner's own frame."""
        owner, _, marker = end.partition(".")
        tables = self.data.get("ground") or {} if owner == "ground" else self.data["body"].get(owner, {})
        return tables["marker"][marker] if marker else {}

    def end(self, end):
        """(owner, position (3,), axes (3, 3)) of an end: "body", "body.marker", "ground", "ground.marker",
        "inertial".

        A ground that stands still is the inertial frame itself.
        """
        if end not in self._ends:
            owner = "ground" if end == "inertial" and not self.ground.spec else end.partition(".")[0]
            self._ends[end] = owner, *pose(self._frame_table(end) if "." in end else {})

        return self._ends[end]

    def _about_its_point(self, name, force):
        """A force whose end is the point that its coefficients are about."""
        place = force.get("hydrodynamics", {}).get("reference")

        if place is None:
            return force

        owner, position, axes = self.end(force["on"])
        self._ends[f"{owner}.reference of {name}"] = owner, position + axes @ np.array(place, float), axes
        return force | {"on": f"{owner}.reference of {name}"}

    def frame(self, motions, end):
        """(r, A, v, w) of an end."""
        owner, position, axes = self.end(end)

        if owner == "inertial":
            return np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3)

        r, A, v, w = motions[owner][:4]
        arm = A @ position
        return r + arm, A @ axes, v + cross(w, arm), w

    def wrench_on(self, motions, end, force, moment=0.0):
        """Generalised forces (6 n,) on all owners of a force and a moment at an end, inertial axes."""
        owner = self.end(end)[0]
        f = np.zeros(6 * len(self.owners))

        if owner != "inertial":
            arm = self.frame(motions, end)[0] - motions[owner][0]
            f[self.place[owner]] = np.concatenate([force, moment + cross(arm, force)])

        return f

    # equations

    def signals(self, motions, kind, ends, numbers):
        """The equations of a kind between two ends: name -> (value, rate, bias, J),
        J by all accelerations (see `Instant`)."""
        owners = [self.end(end)[0] for end in ends]
        states = [
            STILL if owner == "inertial" else np.concatenate([np.ravel(p) for p in motions[owner][:4]])
            for owner in owners
        ]
        poses = [np.concatenate([position, axes.ravel()]) for _, position, axes in map(self.end, ends)]
        return of_kind(kind)(np.concatenate([*states, *poses, numbers])), owners

    def spread(self, found, owners, s=slice(0, 0)):
        """Signals of two owners, whose J is by their accelerations, then those of parameters at s: by all."""
        told = {}

        for name, (value, rate, bias, J) in found.items():
            wide = np.zeros((len(J), self.width))
            wide[:, s] = J[:, 12:]

            for k, owner in enumerate(owners):
                if owner != "inertial":
                    wide[:, self.place[owner]] += J[:, 6 * k : 6 * k + 6]

            told[name] = value, rate, bias, wide

        return told

    # one instant

    def evaluate(self, t, motions, inputs=None, hints=None):
        """Everything that can be told at time t (s), by variable name,
        and the "constraint residuals" and "constraint rates".

        motions : body -> (r, A, v, w) of its own frame, inertial axes; "ground" too where inputs command its
            motion, with (a, alpha) after these where they are not commanded.
        inputs : name -> value, or array whose first axis is the order of the derivative.
        hints : what is known from elsewhere, by variable name: whole turns of angles, parameters s near which
            to look, the speed and acceleration of joints that inputs drive, the sign of Euler parameters.
        """
        return outputs.tell(self, self.solve(t, motions, inputs, hints))

    def solve(self, t, motions, inputs=None, hints=None):
        """The `Instant` at t; arguments as of `evaluate`."""
        return Instant(self, t, motions, Inputs(inputs), Hints(hints))

    def motions_of(self, told):
        """Motions of all bodies from outputs by name: position, euler_parameters, velocity, omega of each;
        and of the ground where measures from "inertial" tell it."""
        hints = Hints(told)
        motions = {body: hints.pose(body) for body in self.bodies}
        ground = self._ground_of(hints)
        return motions if ground is None else motions | {"ground": ground}

    def _ground_of(self, hints):
        """(r, A, v, w, a, alpha) by the measure of "ground" from "inertial",
        and by accelerations of markers on it; or None."""
        seen = {
            m["between"][1]: name
            for name, m in self.data.get("measure", {}).items()
            if m["between"][0] == "inertial"
        }
        seen = {end: name for end, name in seen.items() if end.partition(".")[0] == "ground"}

        if "ground" not in seen or hints(seen["ground"], "omega") is None:
            return None

        r, A, v, w = hints.pose(seen["ground"])
        rows, right = [], []

        for end, name in seen.items():
            arm = A @ self.end(end)[1]
            rows.append(np.hstack([np.eye(3), np.cross(np.eye(3), arm).T]))
            right.append(hints(name, "acceleration") - cross(w, cross(w, arm)))

        a, alpha = np.split(np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0], 2)
        return r, A, v, w, a, alpha if len(rows) > 2 else None

    def start_motions(self, t=0.0):
        """Motions of all bodies by start values alone, before loops are closed; see starts.py."""
        return motions_at_start(self, t)

    def simulate(self, times, motions, inputs=None, hints=None):
        """Motions at times, the first of which `motions` are at; see simulate.py."""
        return run(self, times, motions, inputs, hints)
