"""The solution of a system at one instant: what moves, what acts, accelerations and multipliers."""

import numpy as np
from scipy.spatial.transform import Rotation

from .acting import ACTING
from .equations import SIX
from .joints import is_turned_over
from .motion import rotation_of_zyx, turning_axes, zyx
from .reading import axis, cross, dotted, listed, si

# singular values of the scaled system below this part of the largest are none
RANK = 1e-11


class Hints:
    """Values known from elsewhere, by variable name; arrays as one or by their elements."""

    def __init__(self, values):
        self.values = values or {}

    def __call__(self, *names):
        """A number, an array, or None."""
        for name in (dotted(*names), ".".join(names)):
            try:
                return np.array(self.values[name], float)
            except KeyError:
                pass

            parts = []

            while f"{name}[{len(parts) + 1}]" in self.values:
                parts.append(float(self.values[f"{name}[{len(parts) + 1}]"]))

            if parts:
                return np.array(parts)

        return None

    def number(self, name, output, element=None):
        """A number, or an element of an array; None too where another part of that name tells something
        else."""
        found = self(name, output)

        if found is None or (found.ndim == 0) != (element is None):
            return None

        return float(found if element is None else found[element])

    def pose(self, name):
        """The motion (r, A, v, w) of a body or of what a measure sees."""
        A = Rotation.from_quat(self(name, "euler_parameters")).as_matrix()
        return self(name, "position"), A, self(name, "velocity"), self(name, "omega")


class Instant:
    """The system at one instant: what moves, what acts, and what follows.

    x : accelerations of all owners (6 each: of the origin, angular), second rates of the parameters s,
    multipliers.
    open : directions (k, len(x)) that the equations leave open, or commands whose acceleration is not known.
    """

    def __init__(self, system, t, motions, inputs, hints):
        self.system, self.t, self.inputs, self.hints = system, t, inputs, hints
        ground = system.ground.at(t, inputs, _whole(motions.get("ground")))
        self.motions = {**motions, "ground": ground}
        self._frames = {}
        self.first = system.started is None

        if self.first:
            system.started = {"time": t, "side": self._sides()}

        self._see()
        self._place_coordinates()

        if self.first:
            self._start()

        self._act()
        self._gather_rows()
        self._solve()

    def _sides(self):
        """On which side of its plane each thing rolls."""
        sides = {}

        for name, joint in self.system.joints.items():
            if joint.kind.startswith("rolling"):
                (r1, A1, _, _), (r2, _, _, _) = (self.frame(end) for end in joint.ends)
                sides[name] = -1.0 if A1[:, 2] @ (r2 - r1) < 0 else 1.0

        return sides

    def frame(self, end):
        """(r, A, v, w) of an end."""
        if end not in self._frames:
            self._frames[end] = self.system.frame(self.motions, end)

        return self._frames[end]

    def _see(self):
        """Equations of all joints and elements,
        with the parameters s where end frames touch and their rates."""
        system = self.system
        self.s, self.s_rate, self.places, self.values = {}, {}, {}, {}
        at = 6 * len(system.owners)

        for name, joint in system.joints.items():
            numbers = np.append(joint.geometry, system.started["side"].get(name, 1.0))
            place = slice(0, 0)

            if name in system.contacts:
                numbers = np.concatenate([numbers, self._touch(name, numbers)])
                place = slice(at, at + system.contacts[name].count)
                at = place.stop
                self.places[name] = place

            found, owners = system.signals(self.motions, joint.kind, joint.ends, numbers)
            self._keep(name, system.spread(found, owners, place))

        for e in system.sixes:
            (_, A1, _, _), (_, A2, _, _) = (self.frame(end) for end in e.ends)
            R = A1.T @ A2
            E = Rotation.from_matrix(R).as_quat()
            found, owners = system.signals(
                self.motions, SIX, e.ends, np.concatenate([R.ravel(), E if E[3] >= 0 else -E])
            )
            self._keep(e.name, system.spread(found, owners))

    def _keep(self, name, found):
        self.values |= {(what, name): values for what, values in found.items()}

    def _touch(self, name, numbers):
        """Finds s and its rate; numbers of the contact there."""
        contact = self.system.contacts[name]
        ends = contact.joint.ends
        s = self.s[name] = contact.find([self.frame(end) for end in ends], self.hints(name, "s"))
        still = np.concatenate([numbers, contact.numbers(s, np.zeros(contact.count))])
        _, rate, _, J = self.system.signals(self.motions, contact.joint.kind, ends, still)[0]["joint"]
        self.s_rate[name] = -np.linalg.lstsq(J[:, 12:], rate, rcond=1e-12)[0]
        return contact.numbers(s, self.s_rate[name])

    def _place_coordinates(self):
        """Coordinates of joints on their whole turns: q[name] (n,), and their rates."""
        self.q, self.rate = {}, {}

        for name, joint in self.system.joints.items():
            q, rate, _, _ = self.values["coordinates", name]
            q = q.copy()

            for k, output, element in joint.angle_names():
                near = self.hints.number(name, output, element)
                near = self._turn_without_hint(joint, q, output, element) if near is None else near
                q[k] += 2 * np.pi * np.round((near - q[k]) / (2 * np.pi))

            self.q[name], self.rate[name] = q, rate

    def _turn_without_hint(self, joint, q, output, element):
        """About where an angle is: by a screw's advance, by its driver, by its start."""
        if joint.kind == "screw":
            return 2 * np.pi * q[0] / joint.options["pitch"]

        if (
            joint.driver
            and self.system.started
            and ("q" in self.system.started or not joint.driver.starts_here)
        ):
            start = self.system.started.get("q", {}).get(joint.name, [0.0])
            return joint.driver.target(
                self.t, (start[0], self.system.started["time"]), self.inputs, (None,) * 3
            )[0]

        start = si(joint.start, output, 0.0)

        if isinstance(start, dict):
            keys = ("first", "second")
            factor = np.pi / 180 if f"{output}_deg" in joint.start else 1.0
            return factor * start.get(keys[element or 0], 0.0)

        return float(np.broadcast_to(start, 2)[element or 0])

    def _start(self):
        """What the scene leaves to the start."""
        started = self.system.started
        started["q"] = dict(self.q)
        started["along"] = self.q | self.s
        started["constant"] = {}
        started["length"] = {}

        for name, coupling in self.system.couplings.items():
            started["constant"][name] = coupling.factors @ [self.q[joint][0] for joint in coupling.between]

        for name, joint in self.system.joints.items():
            if joint.kind == "distance":
                started["length"][name] = self.values["joint", name][0][0]

        for e in self.system.elements.values():
            if e.kind == "spring_damper" and e.rest_is_of_start:
                (r1, *_), (r2, *_) = (self.frame(end) for end in e.ends)
                started["length"][e.name] = np.linalg.norm(r2 - r1)

    # what acts

    def _act(self):
        """Generalised forces of all that is applied, mass matrix and what products of velocities make,
        on all owners."""
        system = self.system
        n = system.width
        self.M = np.zeros((n, n))
        self.bias = np.zeros(n)
        self.weight = np.zeros(n)
        self.pull = np.zeros(n)
        self.input_power = self.load_power = self.dissipated = 0.0
        self.efforts = {}
        self.inside = {name: np.zeros(n) for name in system.joints}

        for name in system.bodies:
            self._add_body(name)

        for name, joint in system.joints.items():
            self._add_joint(name, joint)

        for e in system.elements.values():
            adders = {"spring_damper": self._add_strut, "load": self._add_load, "torsion": self._add_torsion}
            adders |= dict.fromkeys((*ACTING, "hydrodynamics"), lambda e: e.act(self))
            adders.get(e.kind, self.add_six)(e)

        for name, body in system.data.get("body", {}).items():
            for path, table in (
                ((name,), body),
                *(((name, key), m) for key, m in body.get("marker", {}).items()),
            ):
                self._add_inputs(path, table)

        for force in self.inside.values():
            self.pull += force

    def _padded(self, f):
        return np.concatenate([f, np.zeros(self.system.n_s)])

    def _add_body(self, name):
        mass, com, inertia = self.system.mass[name]
        r, A, _, w = self.motions[name][:4]
        at, c = self.system.place[name], A @ com
        J = A @ inertia @ A.T + mass * (c @ c * np.eye(3) - np.outer(c, c))
        self.M[at, at] += _body_matrix(mass, c, J)
        self.bias[at] += np.concatenate([mass * cross(w, cross(w, c)), cross(w, J @ w)])
        weight = mass * self.system.gravity
        place = r + c

        if self.system.mu:
            weight = weight - self.system.mu * mass * place / np.linalg.norm(place) ** 3

        self.weight[at] += np.concatenate([weight, cross(c, weight)])

        if self.system.gradient and mass > 0:
            moment, force = gradient(self.system.mu, place, A @ inertia @ A.T)
            self.weight[at] += np.concatenate([force, moment + cross(c, force)])

    def push(self, end, force, moment=(0.0, 0.0, 0.0)):
        """A force and a moment onto an end; their power (W)."""
        self.pull += self._padded(self.system.wrench_on(self.motions, end, force, np.array(moment)))
        _, _, v, w = self.frame(end)
        return force @ v + np.array(moment) @ w

    def _add_joint(self, name, joint):
        """Efforts along the joint's coordinates, and torques of a spherical one."""
        J = self.values["coordinates", name][3]
        efforts = {}

        if joint.parts:
            x, speed = self.q[name][0], self.rate[name][0]
            efforts = joint.parts.efforts(x, speed)
            self.dissipated += joint.parts.dissipated(x, speed)

        for what in joint.inputs:
            if joint.kind == "spherical":
                first, second = joint.ends
                (_, A1, _, w1), (_, _, _, w2) = self.frame(first), self.frame(second)
                torque = A1 @ self.inputs(name, "torque", size=3)[0]
                on = self.system.wrench_on(self.motions, second, np.zeros(3), torque)
                self.inside[name] += self._padded(
                    on - self.system.wrench_on(self.motions, first, np.zeros(3), torque)
                )
                self.input_power += torque @ (w2 - w1)
                continue

            k = next(
                k for k, (_, _, angular) in enumerate(joint.coordinates) if angular == (what == "torque")
            )
            effort = self.inputs(name, what)[0]
            self.inside[name] += effort * J[k]
            self.input_power += effort * self.rate[name][k]
            efforts["input"] = effort

        for part, effort in efforts.items():
            if part != "input":
                self.inside[name] += effort * J[0]

        self.efforts[name] = efforts

        if joint.rotor:
            self._add_rotor(name, joint)

    def rotor(self, name):
        """Of a joint with a rotor: (J, n, axis, the host's angular velocity along it by all accelerations)."""
        joint = self.system.joints[name]
        owner = self.system.end(joint.ends[0])[0]
        _, A, _, _ = self.frame(joint.ends[0])
        along = A @ axis(joint.options.get("axis", "z"))
        host = np.zeros(self.system.width)

        if owner != "inertial":
            host[self.system.place[owner]][3:] = along

        return *joint.rotor, along, host

    def _add_rotor(self, name, joint):
        """It turns with n times the joint's rate relative to its host, which has it as if locked."""
        J, n, along, host = self.rotor(name)
        C, bias = self.values["coordinates", name][3][0], self.values["coordinates", name][2][0]
        self.M += n * n * J * np.outer(C, C) + n * J * (np.outer(C, host) + np.outer(host, C))
        self.bias += n * n * J * bias * C + n * J * bias * host
        w, owner = self.frame(joint.ends[0])[3], self.system.end(joint.ends[0])[0]

        if owner != "inertial":
            self.bias[self.system.place[owner]][3:] += n * J * self.rate[name][0] * cross(w, along)

    def rotor_effort(self, name, acceleration):
        """What the rotor takes of the efforts along its joint's coordinate."""
        J, n, _, host = self.rotor(name)
        _, _, bias, C = self.values["coordinates", name]
        return n * n * J * (C[0] @ acceleration + bias[0]) + n * J * host @ acceleration

    def _add_strut(self, e):
        (r1, _, v1, _), (r2, _, v2, _) = (self.frame(end) for end in e.ends)
        length = np.linalg.norm(r2 - r1)
        direction = (r2 - r1) / length if length else np.zeros(3)
        rate = direction @ (v2 - v1)
        pulled = self.inputs(e.name, "force")[0] if e.has_input else 0.0

        if e.rest_is_of_start:
            e.spring.rest = self.system.started["length"][e.name]

        e.now = length, rate, e.tensions(length, rate, pulled)
        tension = sum(e.now[2])
        self.pull += self._padded(self.system.wrench_on(self.motions, e.ends[0], tension * direction))
        self.pull -= self._padded(self.system.wrench_on(self.motions, e.ends[1], tension * direction))
        self.input_power -= pulled * rate
        self.dissipated += e.now[2][1] * rate

    def add_six(self, e):
        moved, moving_, _, J = self.values["moved", e.name]
        seen, _, bias, J_seen = self.values["seen", e.name]
        (_, A1, _, _), (_, A2, _, _) = (self.frame(end) for end in e.ends)
        turned, yaw = A1.T @ A2, moved[5]
        elastic, drag = e.elastic(moved), e.drag(seen, turned, yaw)
        self.pull += J.T @ elastic + J_seen.T @ drag
        self.dissipated += e.dissipated(seen, moved, moving_, turned, yaw)

        # (rx', ry', rz') = T w
        T = J[3:] @ np.linalg.pinv(J_seen[3:])
        e.now = elastic[:3] + drag[:3], T.T @ elastic[3:] + drag[3:], moved, seen

        if e.adds:
            A, h = e.water(seen, turned, yaw, T[2])
            self.M += J_seen.T @ A @ J_seen
            self.bias += J_seen.T @ (A @ bias + h)
            e.mass_now = A, J_seen

    def _add_torsion(self, e):
        moved, moving_, _, J = self.values["moved", e.name]
        near = self.hints.number(e.name, "angle") or 0.0
        angle = moved[5] + 2 * np.pi * np.round((near - moved[5]) / (2 * np.pi))
        e.now = angle, moving_[5], (-e.spring(angle), -e.damper(moving_[5]))
        self.pull += sum(e.now[2]) * J[5]
        self.dissipated -= e.now[2][1] * moving_[5]

    def _add_load(self, e):
        _, A, v, w = self.frame(e.ends[0])
        force, moment = e.wrench(self.t)
        force, moment = (A @ force, A @ moment) if e.follows else (force, moment)
        self.pull += self._padded(self.system.wrench_on(self.motions, e.ends[0], force, moment))
        e.now = force @ v + moment @ w
        self.load_power += e.now

    def _add_inputs(self, path, table):
        """Forces and moments that are inputs, at a body's frame or a marker."""
        told = listed(table.get("input"))

        if not told:
            return

        _, A, v, w = self.frame(".".join(path))
        A = A if table.get("input_axes", "inertial") == "body" else np.eye(3)
        force, moment = (
            A @ self.inputs(*path, what, size=3)[0] if what in told else np.zeros(3)
            for what in ("force", "moment")
        )
        self.pull += self._padded(self.system.wrench_on(self.motions, ".".join(path), force, moment))
        self.input_power += force @ v + moment @ w

    # rows

    def _gather_rows(self):
        """All constraints, C a + bias = 0, with residuals and rates; rows_of[joint] are those of a joint."""
        self.rows, self.rows_of, self.unknown, self.turned = [], {}, [], {}
        count = 0

        def add(owner, C, bias, residual, rate):
            nonlocal count
            C = np.atleast_2d(C)
            self.rows.append((C, np.atleast_1d(bias), np.atleast_1d(residual), np.atleast_1d(rate)))
            self.rows_of.setdefault(owner, []).extend(range(count, count + len(C)))
            count += len(C)

        for name, joint in self.system.joints.items():
            value, rate, bias, C = self.values["joint", name]
            add(name, C, bias, value - self._rest(name, joint, len(value)), rate)

            slip, _, bias, C = self.values["slip", name]

            if joint.kind == "prescribed":
                residual, rate, asked = self._prescribed(joint, slip)
                self.unknown += [count + k for k in np.flatnonzero(np.isnan(asked))]
                add(name, C, bias - np.nan_to_num(asked), residual, rate)
                continue

            add(name, C, bias, 0 * slip, slip)

            q, q_rate = self.q[name], self.rate[name]
            _, _, q_bias, J = self.values["coordinates", name]

            # driven along a curve
            if joint.driver and name in self.s:
                q, q_rate, q_bias, J = self.s[name], self.s_rate[name], np.zeros(1), self._second_rate(name)

            if joint.kind == "screw":
                h = joint.options["pitch"] / (2 * np.pi)
                add(
                    name,
                    J[0] - h * J[1],
                    q_bias[0] - h * q_bias[1],
                    q[0] - h * q[1],
                    q_rate[0] - h * q_rate[1],
                )

            if joint.driver:
                started = self.system.started
                seen = q[0], q_rate[0], self.hints.number(name, "acceleration")
                x, speed, acceleration = joint.driver.target(
                    self.t, (started["along"][name][0], started["time"]), self.inputs, seen
                )

                # a command of which nobody knows how it goes on
                if acceleration is None:
                    self.unknown.append(count)

                add(("driver", name), J[0], q_bias[0] - (acceleration or 0.0), q[0] - x, q_rate[0] - speed)

        for name, coupling in self.system.couplings.items():
            factors, constant = coupling.factors, coupling.constant
            constant = self.system.started["constant"][name] if constant is None else constant
            coordinates = [self.values["coordinates", j] for j in coupling.between]
            add(
                ("coupling", name),
                factors @ [c[3][0] for c in coordinates],
                factors @ [c[2][0] for c in coordinates],
                factors @ [self.q[j][0] for j in coupling.between] - constant,
                factors @ [self.rate[j][0] for j in coupling.between],
            )

        width = self.system.width
        self.C = np.vstack([C for C, *_ in self.rows]) if self.rows else np.zeros((0, width))
        self.row_bias, self.residuals, self.rates = (
            np.concatenate([row[k] for row in self.rows]) if self.rows else np.zeros(0) for k in (1, 2, 3)
        )

    def _second_rate(self, name):
        """(1, n): the second rate of the parameter of a joint on a curve, of all unknowns."""
        found = np.zeros((1, self.system.width))
        found[0, self.places[name]] = 1.0
        return found

    def _prescribed(self, joint, slip):
        """(residuals, rates of these, accelerations that are asked for) of a joint whose pose is prescribed, of place and turn."""
        (r1, A1, *_), (r2, A2, *_) = (self.frame(end) for end in joint.ends)
        d, R = A1.T @ (r2 - r1), A1.T @ A2
        begun, nothing = self.system.started["time"], [None] * 3
        here, rates = self.hints(joint.name, "zyx"), self.hints(joint.name, "zyx_rate")

        # a body of that name tells its own
        if here is not None and joint.name in self.system.bodies:
            here = zyx(R, None)
            x, *_ = joint.asked(self.t, begun, self.inputs, [[*d, *here], [*slip[:3], *nothing], 2 * nothing])
            rates = np.linalg.lstsq(turning_axes(x[3:]), slip[3:], rcond=None)[0]

        seen = [
            [*d, *(nothing if here is None else here)],
            [*slip[:3], *(nothing if rates is None else rates)],
        ]
        x, speed, acceleration = joint.asked(self.t, begun, self.inputs, [*seen, 2 * nothing])
        self.turned[joint.name] = x[3:]
        E, w, alpha = rotation_of_zyx(x[3:], speed[3:], acceleration[3:])
        residual = np.concatenate([d - x[:3], Rotation.from_matrix(E.T @ R).as_rotvec()])
        rate = slip - np.concatenate([speed[:3], w])
        return residual, rate, np.concatenate([acceleration[:3], alpha])

    def _rest(self, name, joint, count):
        """What a joint's equations of positions are where it holds;
        far off where frames stand the wrong way round."""
        rest = np.zeros(count)
        (_, A1, _, _), (_, A2, _, _) = (self.frame(end) for end in joint.ends)

        if is_turned_over(joint.kind, joint.options, A1.T @ A2):
            rest += 1.0

        if joint.kind == "distance":
            length = joint.options.get("length")
            rest[0] = self.system.started["length"][name] if length is None else length

        return rest

    def _solve(self):
        """Accelerations and multipliers, and the directions that are open."""
        given = slice(0, 6)  # the ground's
        ground = np.concatenate(self.motions["ground"][4:6])
        n = len(self.bias)
        M, C = self.M[6:, 6:], self.C[:, 6:]
        right = (self.weight + self.pull - self.bias)[6:] - self.M[6:, given] @ ground
        K = np.block([[M, C.T], [C, np.zeros((len(C), len(C)))]])
        b = np.concatenate([right, -self.row_bias - self.C[:, given] @ ground])

        # scaled so that bodies weigh 1, where they weigh anything, and rows have unit length
        size = np.abs(np.diag(M))
        usual = np.median(size[size > 0]) if np.any(size > 0) else 1.0
        scale = 1 / np.sqrt(np.where(size > 1e-14 * usual, size, usual))
        lengths = np.linalg.norm(C * scale, axis=1)
        scale = np.concatenate([scale, 1 / np.where(lengths > 0, lengths, 1.0)])
        U, sigma, Vt = np.linalg.svd(scale[:, None] * K * scale)
        kept = sigma > RANK * sigma[0] if len(sigma) else sigma > 0
        inverse = scale[:, None] * (Vt[kept].T / sigma[kept]) @ (U[:, kept].T * scale)
        x = inverse @ b
        x += inverse @ (b - K @ x)
        x[n - 6 :] *= -1
        self.x = np.concatenate([ground, x])
        opened = np.vstack([Vt[~kept] * scale, *(inverse[:, n - 6 + row] for row in self.unknown)])
        opened[:, n - 6 :] *= -1
        self.open = np.hstack([np.zeros((len(opened), 6)), opened])

    @property
    def undecided(self):
        """The solution gone on by as much as it is large along what is open; None where nothing is."""
        if not len(self.open):
            return None

        weights = np.cos(1.0 + np.arange(len(self.open)))
        way = weights @ self.open
        return self.x + way * max(1.0, np.abs(self.x).max()) / np.abs(way).max()


def gradient(mu, r, inertia):
    """(moment about the centre of mass at r, force) of -mu / (2 |r|^3) (tr I - 3 e . I e), e = r / |r|."""
    length = np.linalg.norm(r)
    e = r / length
    slope = (np.trace(inertia) - 5 * e @ inertia @ e) * e + 2 * inertia @ e
    return 3 * mu / length**3 * cross(e, inertia @ e), -1.5 * mu / length**4 * slope


def _body_matrix(mass, c, J):
    """(6, 6) of a body about its origin, c : its centre of mass from there:
    force and moment of (a, alpha)."""
    cross = np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
    return np.block([[mass * np.eye(3), -mass * cross], [mass * cross, J]])


def _whole(motion):
    """A motion of the ground with its accelerations, None where they are not known."""
    return None if motion is None else (*motion, *[None] * (6 - len(motion)))
