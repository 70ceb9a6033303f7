"""Bodies, the tree of joints that holds them, and what closes loops, couples and drives:
with starts that fit together."""

import numpy as np
from scipy.linalg import null_space

from . import bodies, frames, inside, kinds, motions, names

# singular values below this part of the largest count as none: loops near a singular position are not drawn
RANK = 2e-3


class Mechanism:
    """A mechanism in the making.

    poses : of the owners of markers ("ground", "inertial", bodies) at the start, in the inertial frame. paths
    : of the same, a dict from each velocity coordinate to its twist (6,): angular velocity, and velocity at
    the inertial origin, inertial axes.
    site : m, by which all on the ground is shifted; centre_free : whether bodies may be at the inertial
    origin; roots : of the owners, "ground" or "inertial", which are one where the ground rests, or a
    body that moves as prescribed.
    rows, rates : what velocities v must obey, rows @ v = rates (None where a rate is not known).
    """

    def __init__(
        self, dice, taste, ground_pose=frames.HERE, site=(0.0, 0.0, 0.0), centre_free=True, ground_moves=False
    ):
        self.centre_free = centre_free
        self.dice, self.taste, self.site = dice, taste, np.array(site)
        self.names = names.Names(dice)
        self.body, self.ground_marker, self.coupling = {}, {}, {}
        self.joints, self.closings = [], []
        self.poses = {"ground": ground_pose, "inertial": frames.HERE}
        self.paths = {"ground": {}, "inertial": {}}
        self.roots = {"ground": "ground", "inertial": "inertial" if ground_moves else "ground"}
        self.n = 0
        self.rows, self.rates = np.zeros((0, 0)), []

    # the tree

    def grow(self):
        """One more body, or a chain of them that is to be closed in its plane."""
        dice = self.dice
        room = self.taste["size"] - len(self.body)

        if room >= 2 and dice.chance(self.taste["planar"]):
            self._add_chain(dice.whole(2, min(room, 4)))
        elif dice.chance(self.taste["wheel"]):
            self._add_wheel()
        else:
            self.add_body(kinds.draw(dice, dice.weighted(self.taste["tree"]), self._range()))

    def _range(self):
        """How far a joint may be from its zero position: not far where its start is not to be given."""
        return self.dice.pick(self.taste["range"])

    def parent(self):
        """An owner that a new body may hang on."""
        dice = self.dice

        if self.body and not dice.chance(self.taste["branching"]):
            return list(self.body)[-1]

        owners = ["ground", *self.body] + (["inertial"] if dice.chance(0.15) and self.centre_free else [])
        return dice.pick(owners)

    def add_body(self, joint, parent=None, near=None, far=None, table=None, reverse=None):
        """A body on a new joint of the tree; near, far: poses of the markers on its parent and on itself.
        Returns its name."""
        dice = self.dice
        parent = parent or self.parent()
        name = self.names.new(names.BODIES)
        self.body[name] = table or bodies.body(dice, self.taste["bodies"])
        reverse = dice.chance(0.3) if reverse is None else reverse
        self._drive(joint)
        near = near or self._somewhere(parent)
        far = far or (frames.place(dice, 0.4) if dice.chance(0.6) else ({}, frames.HERE))
        pose = frames.inverse(joint.pose) if reverse else joint.pose
        world_near = frames.compose(self.poses[parent], near[1])
        world_far = frames.compose(world_near, pose)
        self.poses[name] = frames.compose(world_far, frames.inverse(far[1]))
        owners = [(parent, near, world_near), (name, far, world_far)]
        self._enter(joint, owners[::-1] if reverse else owners, name if reverse else None)
        first, second = [world for _, _, world in (owners[::-1] if reverse else owners)]
        path = dict(self.paths[parent])

        for motion in joint.motions:
            w, v = first[1] @ motion[:3], first[1] @ motion[3:]
            twist = np.concatenate([w, v + np.cross(second[0], w)])
            path[self.n] = -twist if reverse else twist
            self.n += 1

        self.paths[name] = path
        self.roots[name] = name if joint.led else self.roots[parent]
        return name

    def _somewhere(self, owner):
        if owner == "inertial":
            return {}, frames.HERE

        keys, (r, A) = frames.place(self.dice, 0.6) if self.dice.chance(0.85) else ({}, frames.HERE)

        if owner == "ground" and self.site.any():
            r = r + self.site
            keys = keys | {"position": r.tolist()}

        return keys, (r, A)

    def _enter(self, joint, owners, name=None):
        """A joint among the others: its name and its ends."""
        taken = {other.name for other in self.joints}
        own = name or next((o for o, _, _ in owners if o not in ("ground", "inertial")), None)
        joint.name = own if own not in taken and self.dice.chance(0.15) else self.names.new(names.JOINTS)
        ends = [(owner, keys | shape) for (owner, (keys, _), _), shape in zip(owners, joint.shapes)]
        joint.ends = tuple(self.end(owner, keys) for owner, keys in ends)
        joint.world = tuple(world for _, _, world in owners)
        joint.owners = tuple(owner for owner, _, _ in owners)
        self.joints.append(joint)

    def end(self, owner, keys):
        """The name of an end on an owner: the owner itself where it may, else a new marker."""
        if owner == "inertial" or (not keys and self.dice.chance(0.7)):
            return owner

        markers = self.ground_marker if owner == "ground" else self.body[owner].setdefault("marker", {})
        name = self.names.new(names.MARKERS)
        markers[name] = keys
        return f"{owner}.{name}"

    def _drive(self, joint):
        """Maybe a driver for a joint of one freedom, which is moved to where that starts,
        and what else acts in it."""
        if joint.kind not in kinds.ONE:
            self._torque(joint)
            return

        if self.dice.chance(self.taste["driver"]):
            self._prescribe(joint)

        inside.add(self.dice, joint, self.taste)

    def _torque(self, joint):
        efforts = {"screw": ["torque"], "cylindrical": ["force", "torque"], "spherical": ["torque"]}.get(
            joint.kind
        )

        if efforts and self.dice.chance(self.taste["input"]):
            some = self.dice.some(efforts, 1)
            joint.table["input"] = some[0] if len(some) == 1 and self.dice.chance(0.5) else some

    def _prescribe(self, joint):
        key = "angle" if joint.kind == "revolute" else "position"
        table, q, rate, says = motions.driver(self.dice, joint.kind, joint.q[key], self.taste["drivers"])
        direction = joint.motions[0, :3] + joint.motions[0, 3:]
        joint.q[key], joint.rate, joint.says = q, rate, says
        joint.pose = (
            (np.zeros(3), frames.about(direction, q)) if key == "angle" else (q * direction, np.eye(3))
        )
        joint.table["driver"] = table

    def _add_wheel(self):
        """A body of revolution on a hinge through its axis, which may spin fast."""
        dice = self.dice
        turn = frames.axis(dice)
        joint = kinds.draw(dice, "revolute", 1.0, direction=turn)
        # about the axis of its own frame, since its joint's marker there is its own
        self.add_body(joint, far=({}, frames.HERE), table=bodies.body(dice, axis=turn[1]))
        joint.fast = True

    def _add_chain(self, n):
        """n bodies in a plane, one after the other by hinges, maybe a slider, to be closed by a hinge:
        redundant in space."""
        dice = self.dice
        axis = frames.axis(dice)
        base = self.parent()
        # what closes it needs a marker there
        base = "ground" if base == "inertial" else base
        near, owner = self._somewhere(base), base
        parallelogram = n == 3 and dice.chance(0.15)
        lengths = dice.numbers(n, 0.3, 0.8) if not parallelogram else [0.5, 0.8, 0.5]
        angles = [dice.number(0.3, 1.3) * dice.pick([1, 1, -1]) for _ in range(n)]
        if parallelogram:
            angles = [angles[0], -angles[0], angles[0]]
        plane = frames.plane_axes(axis[1])

        for length, angle in zip(lengths, angles):
            joint = kinds.draw(dice, "revolute", 1.0, q=angle, direction=axis)
            owner = self.add_body(joint, owner, near, ({}, frames.HERE), reverse=False)
            near = ({"position": (length * plane[:, 0]).tolist()}, (length * plane[:, 0], np.eye(3)))

        self.closings.append((base, owner, axis, near))

    # what closes loops

    def twists(self, owner):
        """(6, n)"""
        T = np.zeros((6, self.n))

        for k, twist in self.paths[owner].items():
            T[:, k] = twist

        return T

    def seen(self, joint):
        """(6, n): the second marker's angular velocity in the first, and its origin's velocity,
        in the first's axes."""
        (first, second), (a, b) = joint.world, joint.owners
        T = self.twists(b) - self.twists(a)
        v = T[3:] + np.cross(T[:3], second[0], axis=0)
        return np.vstack([first[1].T @ T[:3], first[1].T @ v])

    def still(self, joint):
        """0.0 where what the rows of a joint see rests while the bodies do,
        None where a motion that is prescribed is in between."""
        a, b = joint.owners
        if joint.led:
            return None
        return 0.0 if self.roots[a] == self.roots[b] else None

    def freedom(self):
        """Velocities that are left."""
        return self.n - _rank(self.rows)

    def restrict(self, rows, rates, least=1, expected=None, locks=False):
        """Adds rows (k, n) if they are as many independent ones as expected and leave freedoms enough;
        whether they did.

        locks : whether joints that moved may move no more; else that is rare.
        """
        sizes = np.maximum(np.linalg.norm(rows, axis=1), 1e-9)
        rows = rows / sizes[:, None]
        rates = [None if rate is None else rate / size for rate, size in zip(rates, sizes)]
        both = np.vstack([self.rows, rows])
        gained = _rank(both) - _rank(self.rows)

        if gained != (len(rows) if expected is None else expected) or self.n - _rank(both) < least:
            return False
        if not locks and self.dice.chance(0.95) and _locked(both) > _locked(self.rows):
            return False

        self.rows, self.rates = both, self.rates + rates
        return True

    def close_chains(self):
        """Closes the planar chains, some not quite exactly."""
        for base, owner, axis, near in self.closings:
            joint = kinds.draw(self.dice, "revolute", 1.0, direction=axis)
            self._drive_closing(joint)
            off = self.dice.pick([1e-6, 1e-5, 3e-5]) if self.dice.chance(self.taste["off axis"]) else 0.0
            self._close(joint, owner, base, near, None, expected=2, off=off)

    def close(self, cuts=None, draw=kinds.draw):
        """A loop between two bodies by a joint of any kind, or of those of `cuts`,
        if one of some tries leaves a mechanism that moves."""
        dice = self.dice

        for attempt in range(16):
            # a kind is given up where it does not fit in four places
            if attempt % 4 == 0:
                kind = dice.weighted(cuts or self.taste["cuts"])

            joint = draw(dice, kind, self._range())
            rest = dice.chance(0.1) and self.centre_free and not any(joint.shapes)
            owners = [*self.body, "ground"] + (["inertial"] if rest else [])
            a, b = dice.some(owners, 2)[:2]
            if {a, b} == {"ground", "inertial"}:
                a = dice.pick(self.body)
            if any(joint.shapes) and dice.chance(0.55) and b != "ground":
                a = "ground"

            if kind in kinds.ONE:
                self._drive_closing(joint)
            else:
                self._torque(joint)

            if self._close(joint, a, b):
                return True

        return False

    def _drive_closing(self, joint):
        if self.dice.chance(0.5 * self.taste["driver"]):
            self._prescribe(joint)
        if self.dice.chance(0.5):
            inside.add(self.dice, joint, self.taste)

    def _close(self, joint, a, b, near=None, far=None, expected=None, off=0.0):
        """A joint between two owners where they are; whether it leaves a mechanism that moves."""
        dice = self.dice
        inner = frames.inverse(joint.pose)

        if near is None and (b == "inertial" or (a != "inertial" and dice.chance(0.5))):
            far = self._somewhere(b)
            world = frames.compose(self.poses[b], frames.compose(far[1], inner))
            near_pose = frames.compose(frames.inverse(self.poses[a]), world)
            near = frames.written_pose(dice, near_pose), near_pose
        else:
            near = near or self._somewhere(a)
            world = frames.compose(self.poses[a], frames.compose(near[1], joint.pose))
            far_pose = frames.compose(frames.inverse(self.poses[b]), world)
            if off:
                far_pose = far_pose[0], frames.about(frames.unit(dice.vector(1.0)), off) @ far_pose[1]
            far = frames.written_pose(dice, far_pose), far_pose

        owners = [(o, p, frames.compose(self.poses[o], p[1])) for o, p in ((a, near), (b, far))]
        joint.in_tree = False
        joint.world, joint.owners = tuple(w for _, _, w in owners), (a, b)
        rows = joint.rows @ self.seen(joint)

        fits = not len(rows) or self.restrict(rows, [self.still(joint)] * len(rows), expected=expected)

        # how fast the ground moves is not known here
        if not len(rows) and self.still(joint) is None:
            joint.says = "place"

        if fits:
            self._enter(joint, owners)
        return fits

    # couplings and drivers

    def row(self, joint):
        """(n,): rate of the coordinate of a joint of one freedom by the velocities."""
        return joint.motions[0] @ self.seen(joint)

    def hold_drivers(self):
        """Keeps the drivers that the loops allow and that leave something to move; drops the others."""
        for joint in self.joints:
            least = 0 if self.dice.chance(0.2) else 1
            rate = joint.rate if self.still(joint) is not None else None
            if (
                joint.driven
                and not joint.led
                and not self.restrict(self.row(joint)[None], [rate], least, locks=True)
            ):
                del joint.table["driver"]
                joint.rate, joint.says = None, "all"

    def couple(self):
        """A coupling between two joints of one freedom, often the last one's second and a third:
        a train of gears."""
        dice = self.dice
        joints = [joint for joint in self.joints if joint.kind in kinds.ONE]

        for _ in range(8 if len(joints) >= 2 else 0):
            first, second = dice.some(joints, 2)[:2]
            last = next(reversed(self.coupling.values()), None)
            if last and dice.chance(0.5):
                first = next(joint for joint in joints if joint.name == last["between"][1])
            elif first.kind == "prismatic" and dice.chance(0.9):
                first, second = second, first
            if first is second or (first.driven and second.driven):
                continue
            if len(joints) > 2 and dice.chance(0.2):
                return self._couple_many(joints)

            ratio = dice.signed(0.3, 3.0)
            if second.fast and dice.chance(0.7):
                ratio = float(dice.pick([5, 8, 10, -6, 12, 20] if dice.chance(0.9) else [50, -60]))
            if second.kind == "prismatic":
                ratio = dice.signed(0.05, 0.4)
            kind = self._coupling_kind(first, second)
            options, ratio = _ratio(kind, ratio)
            row = self.row(second) - ratio * self.row(first)

            rate = 0.0 if None not in (self.still(first), self.still(second)) else None
            if self.restrict(row[None], [rate]):
                offset = second.value - ratio * first.value
                if dice.chance(self.taste["offset"]):
                    if dice.chance(self.taste["misfit"]):
                        offset += dice.number(-0.2, 0.2)
                    in_degrees = kind == "gear" and dice.chance(0.5)
                    options |= {"offset_deg": float(np.degrees(offset))} if in_degrees else {"offset": offset}
                name = self.names.new(names.COUPLINGS)
                self.coupling[name] = {kind: options, "between": [first.name, second.name]}
                return True

        return False

    def _couple_many(self, joints):
        """A linear coupling of three or more joints of one freedom."""
        dice = self.dice
        chosen = dice.some(joints, 3)[:5]
        factors = [dice.signed(0.3, 3.0) for _ in chosen]
        row = sum(factor * self.row(joint) for factor, joint in zip(factors, chosen))
        rate = 0.0 if all(self.still(joint) is not None for joint in chosen) else None
        if all(joint.driven for joint in chosen) or not self.restrict(row[None], [rate]):
            return False

        options = {"coefficients": factors}
        if dice.chance(self.taste["offset"]):
            constant = sum(factor * joint.value for factor, joint in zip(factors, chosen))
            misfit = dice.number(-0.2, 0.2) if dice.chance(self.taste["misfit"]) else 0.0
            options["constant"] = constant + misfit
        name = self.names.new(names.COUPLINGS)
        self.coupling[name] = {"linear": options, "between": [joint.name for joint in chosen]}
        return True

    def _coupling_kind(self, first, second):
        pair = first.kind, second.kind
        options = {
            ("revolute", "revolute"): ["gear", "linear"],
            ("revolute", "prismatic"): ["rack", "screw", "rack", "rack", "screw"],
        }
        return self.dice.pick(options.get(pair, ["linear"]))

    # speeds

    def velocities(self, size):
        """Velocities (n,) that fit, or None where some that is prescribed is not known."""
        if None in self.rates:
            return None

        v = size * self.dice.rng.normal(size=self.n)

        for joint in self.joints:
            if joint.fast and self.dice.chance(self.taste["fast"]):
                v += self.dice.signed(10, 40) * self.row(joint)

        if not len(self.rows):
            return v

        return v + np.linalg.pinv(self.rows, rcond=RANK) @ (np.array(self.rates) - self.rows @ v)

    def velocity_of(self, joint, v):
        """A joint's velocity coordinates at velocities v (n,) of the tree's."""
        if not len(joint.motions):
            return np.zeros(0)

        return np.linalg.lstsq(joint.motions.T, self.seen(joint) @ v, rcond=None)[0]

    def undetermined(self, properties):
        """The least inertia (kg m2, kg) of motions that are left; properties:
        body -> (mass, com (3,), inertia (3, 3))."""
        free = null_space(self.rows, rcond=RANK) if len(self.rows) else np.eye(self.n)
        M = np.zeros((self.n, self.n))

        for name, (mass, com, inertia) in properties.items():
            r, A = self.poses[name]
            c = r + A @ com
            T = self.twists(name)
            v = T[3:] + np.cross(T[:3], c, axis=0)
            M += mass * v.T @ v + T[:3].T @ (A @ inertia @ A.T) @ T[:3]

        moments = np.linalg.eigvalsh(free.T @ M @ free)
        return float(moments[0]) if len(moments) else 1.0


def _locked(rows):
    """How many of the velocities rows (k, n) leave no freedom."""
    if not rows.size:
        return 0

    free = null_space(rows, rcond=RANK)
    return int(np.sum(np.linalg.norm(free, axis=1) < RANK))


def _rank(rows):
    if not rows.size:
        return 0

    s = np.linalg.svd(rows, compute_uv=False)
    return int(np.sum(s > RANK * max(s[0], 1e-9)))


def _ratio(kind, ratio):
    """(options, ratio in SI) of a coupling; `ratio` as wished."""
    if kind == "rack":
        return {"radius": ratio}, ratio

    if kind == "screw":
        pitch = round(2 * np.pi * ratio, 3)
        return {"pitch": pitch}, pitch / (2 * np.pi)

    return {"ratio": ratio}, ratio
