"""The constraints of a model in numbers: their velocity Jacobian, its rank, and the motions that it leaves
free.

Ranks are those of the constraints' velocity Jacobian C (rows by velocity coordinates), made free
of units by a length of the scene. At a singular position (a parallelogram four-bar stretched out)
the rank falls for a moment; what holds in every position is looked for at two places near the
start.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..compiler.dependencies import joined
from ..compiler.frames import axes_with_z
from ..compiler.joint_kinds import kind_of
from ..compiler.model import compile_scene
from ..kernels import joints
from ..kernels.dynamics import projection, rates, rows
from ..kernels.motion import coordinates, drives, kinematics
from ..kernels.status import OK
from ..run.instance import Instance
from ..threads import one_thread

# singular values below this part of the largest are zero: positions are known to the square root
# of rounding near a singular one
ZERO = 1e-6

# arrays of the model that `freeze` changes
FROZEN = ("drive_value", "sea_unit", "wind_velocity")

# what the ground is called beside joints
GROUND = "ground"

# how far (rad, or parts of the scene's length) the places near the start are
NEARBY = (0.1, 0.23)


@dataclass(frozen=True)
class Loads:
    """What unit multipliers of the rows do to the nodes, SI.

    moment, force : (n_row, 3) wrench on the second marker's body about that marker's origin.
    row, node, wrench : (n,), (n,), (n, 6) each wrench of a row on a node: moment about the inertial
        origin, force.
    effort_row, effort_node, effort : (n,) efforts along nodes' own coordinates.
    """

    moment: np.ndarray
    force: np.ndarray
    row: np.ndarray
    node: np.ndarray
    wrench: np.ndarray
    effort_row: np.ndarray
    effort_node: np.ndarray
    effort: np.ndarray


NO_LOADS = Loads(
    moment=np.empty((0, 3)),
    force=np.empty((0, 3)),
    row=np.empty(0, int),
    node=np.empty(0, int),
    wrench=np.empty((0, 6)),
    effort_row=np.empty(0, int),
    effort_node=np.empty(0, int),
    effort=np.empty(0),
)
"""Where there are no rows."""


@dataclass
class Place:
    """The Jacobian at one position, and what was seen there.

    C : (n_row, n) rows' rates by free velocity coordinates, without units.
    scale : (n_row,) a row of C is this times the row in SI units.
    constraint : (n_row,) of each row.
    loads : what unit multipliers do to the nodes.
    twist : (n, n_body, 6) angular velocity and velocity of the nodes' origins for a unit of each
    coordinate, SI.
    r, A : (n_body, 3) m, (n_body, 3, 3) poses of the nodes.
    """

    C: np.ndarray
    scale: np.ndarray
    constraint: np.ndarray
    loads: Loads
    twist: np.ndarray
    r: np.ndarray
    A: np.ndarray

    @cached_property
    def _blocks(self):
        """(rows, columns, U, singular values, V^T) of each block of C: of loops that share no coordinate."""
        n_row, n = self.C.shape
        rows, columns = np.nonzero(self.C)
        links = zip(self.constraint[rows].tolist(), (n_row + columns).tolist())
        number = np.array(joined(n_row + n, links), int)
        order = np.argsort(number, kind="stable")
        blocks = []

        for members in np.split(order, np.flatnonzero(np.diff(number[order])) + 1):
            rows = np.flatnonzero(np.isin(self.constraint, members[members < n_row]))
            columns = members[members >= n_row] - n_row

            if rows.size or columns.size:
                blocks.append((rows, columns))

        with one_thread():
            return [(*block, *np.linalg.svd(self.C[np.ix_(*block)])) for block in blocks]

    @cached_property
    def _ranks(self):
        """Independent rows of each block."""
        largest = max((s[0] for _, _, _, s, _ in self._blocks if s.size), default=0.0)
        return [int(np.sum(s > ZERO * largest)) for _, _, _, s, _ in self._blocks]

    @property
    def rank(self) -> int:
        """Independent rows."""
        return sum(self._ranks)

    @cached_property
    def motions(self):
        """(n, n - rank): orthonormal columns of free motions, without units."""
        n = self.C.shape[1]
        motions = np.zeros((n, n - self.rank))
        first = 0

        for (_, columns, _, _, V), rank in zip(self._blocks, self._ranks):
            motions[columns, first : first + len(columns) - rank] = V[rank:].T
            first += len(columns) - rank

        return motions

    @property
    def self_stress(self):
        """[(rows, (n, k))]: of each block its rows; multipliers, SI, that do nothing along coordinates."""
        return [
            (rows, self.scale[rows, None] * U[:, rank:])
            for (rows, _, U, _, _), rank in zip(self._blocks, self._ranks)
            if rank < len(rows)
        ]


class Mechanism:
    """A model at its start, to be looked at from Python.

    free : velocity coordinates that no drive prescribes; units : (n,) the SI value of a unit-free
    1 of each.
    length : m, by which lengths are made unit-free. redundant : rows that the solver leaves out.
    first : joints that are in the tree before all others. joint_nodes : joint of the tree -> its nodes.
    stilled : joints whose drives moved them, GROUND, when it was frozen.
    parameters, inputs, start_time : as of an `Instance`. model : of the scene, if there is one.
    """

    def __init__(self, scene, first=(), parameters=None, inputs=None, start_time=0.0, model=None):
        if scene.solver.formulation == "auto":
            # by joint coordinates, whatever is cheaper to run
            solver = scene.solver.model_copy(update={"formulation": "recursive"})
            scene = scene.model_copy(update={"solver": solver})

        self.scene = scene
        self.model = compile_scene(scene, first, for_fmu=False) if model is None else model
        self._ints = self.model.ints.copy()
        self.held = dict(inputs or {})
        self._before: dict[str, np.ndarray] = {}
        self.stilled: list[str] = []
        self.instance = Instance(self.model, parameters, start_time, inputs)
        self.m, self.d = self.instance.m, self.instance.d
        m = self.m
        self.free, rotates = [], []

        for i in range(1, m.n_body):
            kind = m.body_joint[i]
            n = 0 if m.body_drive[i] >= 0 else joints.N_V[kind]
            self.free += range(m.body_v[i], m.body_v[i] + n)
            rotates += [k >= joints.N_SLIDE[kind] for k in range(n)]

        self.joint_nodes: dict[str, list[int]] = {}

        for i, node in enumerate(self.model.tree.nodes):
            if node.joint:
                self.joint_nodes.setdefault(node.joint, []).append(i)

        self.redundant = np.flatnonzero(self.d.row_redundant).tolist()
        kinematics.kinematics(m, self.d)
        self.length = self._length()
        self.units = np.where(rotates, 1.0, self.length) if rotates else np.empty(0)

    def _length(self):
        """m: mean distance of the constraints' markers from the origins of their nodes and from
        each other's nodes.
        """
        m, r = self.m, self.d.r.reshape(-1, 3)
        arms = []

        for c in range(m.n_constraint):
            markers = (m.constraint_from[c], m.constraint_to[c])
            nodes = [m.marker_body[k] for k in markers]
            arms += [np.linalg.norm(m.marker_r[3 * k : 3 * k + 3]) for k in markers]
            arms += [np.linalg.norm(r[nodes[1]] - r[nodes[0]])] if min(nodes) > 0 else []

        arms = [arm for arm in arms if arm > 0.0]
        return float(np.mean(arms)) if arms else 1.0

    def freeze(self, weather=False):
        """Drives hold what they move where it is now, and nothing has speed; no waves and no wind, unless
        `weather` or an input that was given tells it.
        """
        m, d = self.m, self.d
        rates.set_time(m, d, 0.0)
        drives.prescribe(m, d)

        # they hold already
        if self._before:
            d.v[:] = 0.0
            return

        self.stilled = self._moved()
        d.v[:] = 0.0

        self._before = {name: getattr(m, name).copy() for name in FROZEN} | {"u": d.u_buffer.copy()}

        if not weather:
            self._calm()

        for k in range(m.n_drive):
            i = m.drive_body[k]

            if i >= 0:
                d.v_rate[m.body_v[i] : m.body_v[i] + joints.N_V[m.body_joint[i]]] = 0.0
                m.drive_body[k] = -1
            else:
                position = drives.target(m, d, k)[0]
                m.drive_kind[k] = drives.POLYNOMIAL
                m.drive_terms[k] = 1
                m.drive_value[16 * k] = position

    def _moved(self):
        """What drives move now: names of joints, the ground."""
        m, d = self.m, self.d
        moving = []

        for k in range(m.n_drive):
            i = m.drive_body[k]

            if i >= 0:
                own = slice(m.body_v[i], m.body_v[i] + joints.N_V[m.body_joint[i]])
                moves = bool(np.any(d.v[own]) or np.any(d.v_rate[own]))
                name = self.model.tree.nodes[i].joint or GROUND
            else:
                moves = any(drives.target(m, d, k)[1:])
                name = next(self.owner(row) for row in range(m.n_row) if m.row_drive[row] == k)

            moving += [name] if moves and name not in moving else []

        return moving

    def _calm(self):
        """No waves, no wind."""
        m, d = self.m, self.d
        m.sea_unit[::4] = 0.0
        m.wind_velocity[:] = 0.0
        m.gust_table[:] = -1
        # what was made of the components
        d.sea_known[:] = 0.0

        for u in m.wind_u[: m.n_wind].tolist():
            told = [k for k in range(u, u + 3) if u >= 0 and k not in self.held]
            d.u_buffer[told] = 0.0

    @property
    def has_weather(self):
        """Whether there are waves or wind in the scene."""
        return bool(self.m.n_wind or self.m.n_sea_wave)

    def thaw(self):
        """Drives move again, and so do wind and waves."""
        if self._before:
            self.model.ints[:] = self._ints
            self.d.u_buffer[:] = self._before.pop("u")
            self.d.sea_known[:] = 0.0

            for name, values in self._before.items():
                getattr(self.m, name)[:] = values

            self._before = {}

    def again(self, parameters=None, inputs=None, start_time=0.0):
        """The same scene at its start, with other values; its structure is not made anew."""
        model = replace(self.model, ints=self._ints.copy())
        return Mechanism(self.scene, (), parameters, inputs, start_time, model)

    # places

    def here(self) -> Place:
        """What is seen at the position of the state."""
        m, d = self.m, self.d
        x = d.x.copy()
        d.v[:] = 0.0
        rest, _ = self._look()
        C = np.empty((m.n_row, len(self.free)))
        twist = np.empty((len(self.free), m.n_body, 6))

        for k, v in enumerate(self.free):
            d.v[v] = 1.0
            rate, twist[k] = self._look()
            C[:, k] = rate - rest
            d.v[v] = 0.0

        loads = self._loads()
        turning = (np.linalg.norm(loads.force, axis=1) == 0.0) | (m.row_kind == rows.FRAME)
        scale = np.where(turning, 1.0, 1.0 / self.length)
        scale = np.where(self.is_coupling(), self._coupling_scale(C), scale)
        place = Place(
            C=scale[:, None] * C * self.units,
            scale=scale,
            constraint=m.row_constraint,
            loads=loads,
            twist=twist,
            r=d.r.reshape(-1, 3).copy(),
            A=d.A.reshape(-1, 3, 3).copy(),
        )
        d.x[:] = x
        return place

    def _look(self):
        """Rates of all rows, twists of all nodes at the velocities of the state."""
        kinematics.kinematics(self.m, self.d)
        rows.write_rows(self.m, self.d)
        w, rd = self.d.w.reshape(-1, 3), self.d.rd.reshape(-1, 3)
        return self.d.row_rate.copy(), np.hstack([w, rd])

    def is_coupling(self):
        """(n_row,) whether a row is a coupling's, or of a prescribed motion."""
        return self.m.row_kind == rows.COUPLING

    def _coupling_scale(self, C):
        """1 / the largest unit-free element: what a coupling is about has units of its own."""
        largest = np.abs(C * self.units).max(axis=1, initial=0.0)
        return 1.0 / np.where(largest > 0.0, largest, 1.0)

    def _loads(self) -> Loads:
        """What the rows do as they were last written."""
        m, d = self.m, self.d

        if not m.n_row:
            return NO_LOADS

        every = np.arange(m.n_row)
        first, second = m.constraint_from[m.row_constraint], m.constraint_to[m.row_constraint]
        body = m.marker_body[second]
        force, moment = d.row_force_to.reshape(-1, 3), d.row_moment_to.reshape(-1, 3)
        arm = np.einsum("kij,kj->ki", d.A.reshape(-1, 3, 3)[body], m.marker_r.reshape(-1, 3)[second])
        acts = [
            (every, m.marker_body[first], d.row_moment_from, d.row_force_from),
            (every, body, d.row_moment_to, d.row_force_to),
        ]
        efforts = []

        for row in np.flatnonzero(self.is_coupling()).tolist():
            for t in range(m.row_term[row], m.row_term[row] + m.row_terms[row]):
                node = rows.body_of_term(m, t)

                if node:
                    efforts.append((row, node, m.term_factor[t]))
                elif t > m.row_term[row]:
                    a, b = rows.bodies_of_term(m, t)
                    at = slice(3 * t, 3 * t + 3)
                    acts.append(
                        (np.array([row]), np.array([a]), d.term_moment_from[at], d.term_force_from[at])
                    )
                    acts.append((np.array([row]), np.array([b]), d.term_moment_to[at], d.term_force_to[at]))

        node = np.concatenate([nodes for _, nodes, _, _ in acts])
        pull = np.concatenate([f for _, _, _, f in acts]).reshape(-1, 3)
        turn = np.concatenate([n for _, _, n, _ in acts]).reshape(-1, 3)
        turn = turn + np.cross(d.r.reshape(-1, 3)[node], pull)
        effort_row, effort_node, effort = np.array(efforts, float).reshape(-1, 3).T
        return Loads(
            moment=moment - np.cross(arm, force),
            force=force.copy(),
            row=np.concatenate([some for some, _, _, _ in acts]),
            node=node,
            wrench=np.hstack([turn, pull]),
            effort_row=effort_row.astype(int),
            effort_node=effort_node.astype(int),
            effort=effort,
        )

    def generic(self) -> Place:
        """The place of the greatest rank among the start and some near it; the start where that is
        one of them.
        """
        here = self.here()
        return max([here, *self._nearby(here)], key=lambda place: place.rank)

    def _nearby(self, here):
        """Places a little way along allowed motions in which every joint takes part; the state
        stays at the start.
        """
        start = self.d.x.copy()
        motions = here.motions
        places = []

        for k, step in enumerate(NEARBY if motions.size else ()):
            v = motions @ np.cos(1.7 * np.arange(motions.shape[1]) + k + 0.3)
            self._move(step * self.units * v / np.abs(v).max())

            if projection.close_gaps(self.m, self.d, self.m.closing_tolerance[0], 0.0) == OK:
                places.append(self.here())

            self.d.x[:] = start

        return places

    def _move(self, change):
        """The positions of the state, moved by small changes (n,) of the free coordinates, SI."""
        self.d.change[:] = 0.0
        self.d.change[self.free] = change
        projection.move_by_change(self.m, self.d, 1.0)

    def owner(self, row) -> str:
        """The joint or coupling that a row belongs to."""
        return self.model.places[self.m.n_body + self.m.row_constraint[row]]

    # joint coordinates

    def driveable(self, place) -> list[str]:
        """Joints any one of which could be driven: it takes a freedom away."""
        joints_ = self.scene.joint.items()
        free = [name for name, joint in joints_ if kind_of(joint).is_one_axis and not joint.driver]
        return [name for name in free if np.linalg.norm(self.rates(name, place) @ place.motions) > 10 * ZERO]

    def rates(self, name, place):
        """(n,) rate of a joint's coordinate by the free coordinates, without units."""
        length = 1.0 if self._turns(name) else self.length
        return self._rates_by_unit(name, place) * self.units / length

    def _rates_by_unit(self, name, place):
        """(n,) rate of a joint's coordinate for a unit of each free coordinate, SI."""
        (a, frame_a), (b, frame_b) = self._sides(name)
        z = (place.A[a] @ frame_a[1])[:, 2]
        w = place.twist[:, b, :3] - place.twist[:, a, :3]

        if self._turns(name):
            return w @ z

        point = place.r[b] + place.A[b] @ frame_b[0]
        v_b = place.twist[:, b, 3:] + np.cross(place.twist[:, b, :3], point - place.r[b])
        v_a = place.twist[:, a, 3:] + np.cross(place.twist[:, a, :3], point - place.r[a])
        return (v_b - v_a) @ z

    def position(self, name) -> float:
        """A joint's coordinate (rad, m) at the start; where the joint closes a loop, an angle is that
        nearest to its start value.
        """
        for i, node in enumerate(self.model.tree.nodes):
            if node.joint == name:
                return float(self.d.q[self.m.body_q[i]])

        place = self.here()
        (a, (r_a, A_a)), (b, (r_b, A_b)) = self._sides(name)
        turned_a, turned_b = place.A[a] @ A_a, place.A[b] @ A_b

        if self._turns(name):
            A = turned_a.T @ turned_b
            given = self.scene.joint[name].start_position()[0]
            return float(coordinates.unwrapped(np.arctan2(A[1, 0], A[0, 0]), given))

        span = place.r[b] + place.A[b] @ r_b - place.r[a] - place.A[a] @ r_a
        return float(turned_a[:, 2] @ span)

    def _turns(self, name):
        """Whether a joint's one coordinate is an angle."""
        return kind_of(self.scene.joint[name]).motions == ("revolute",)

    def _sides(self, name):
        """((node, pose), (node, pose)) of a joint's two markers, z along its axis."""
        turn = axes_with_z(self.scene.joint[name].axis)
        return [self.model.tree.joint_side(self.scene, name, side, turn) for side in (0, 1)]
