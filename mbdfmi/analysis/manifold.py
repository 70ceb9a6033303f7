"""States on the constraints near one of them, in minimal coordinates (docs/theory.md 19.3).

A state is told by independent coordinates: of the positions relative to the state looked at (of an
orientation the rotation vector in the body's axes), of the velocities, and states of force elements. All
others follow. Where there are rolling or knife-edge constraints there are fewer velocities than positions.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy  # which imports its parts when they are asked for

from ..compiler.joint_kinds import scalars
from ..compiler.variables import dotted
from ..kernels import exchange, forces, joints
from ..kernels.dynamics import forward, inertia, rates, rows
from ..kernels.joints import rotors
from ..kernels.joints.kinds import E_OFFSET
from ..kernels.motion import coordinates, drives, kinematics
from ..kernels.status import OK
from ..run.instance import explain
from .differences import STEP

# preference for coordinates of joints and for turning over the way of a free body, among the independent
# ones: a steady turn looks the same at all times in those
OF_WAY = 0.1

# likewise of positions whose rates are independent too
ALREADY = 1e3

AUTO, BODY, INERTIAL = "auto", "body", "inertial"

# step of velocities, in which motions are nearly of degree 2, as part of the largest speed or 1 rad/s
QUICKER = 0.02

# rad/s and sine of an angle that are none
SLOW = 1e-9
ALONG = 1e-7

# part by which the efforts of a summed inertia may be off those of a response
ALIKE = 1e-10


class NoState(ArithmeticError, ValueError):
    """A state that is asked for is not there: loops do not close, or inertias are singular."""


@dataclass(frozen=True)
class Frame:
    """Axes in which an orientation and its rate are told: the body's, or those of the joint's first side, and
    the angular velocity (3,) with which they turn from there on, in the latter.
    """

    of_body: bool
    turning: np.ndarray


@dataclass(frozen=True)
class Named:
    """What a coordinate is called: of its position, of its rate, its joint; units of both."""

    position: str
    rate: str
    joint: str
    unit: str | None
    rate_unit: str | None


class Manifold:
    """States near the one that a mechanism is in, which keeps to its constraints.

    free : velocity coordinates of joints that no drive holds; all below are of these.
    named : what each is called. P, V : (n, n_p), (n, n_v) their change by the independent positions and
        velocities, SI. places, speeds : which of them these are. z : states of force elements, in x.
    """

    def __init__(self, mechanism, axes=AUTO):
        self.mechanism = mechanism
        self.axes = axes
        self.model, self.m, self.d = mechanism.model, mechanism.m, mechanism.d
        self.free = np.array(mechanism.free, int)
        m = self.m
        self._find_coordinates()
        first = m.n_q + m.n_v + m.n_s + m.n_turn
        self.z = np.arange(first, m.n_x)
        self.look()

    def _find_coordinates(self):
        """Where free coordinates stand in q: lines, and orientations with their angular velocities."""
        m, lines, turns, slides = self.m, [], [], []
        self.turning = []
        at = {v: k for k, v in enumerate(self.free.tolist())}

        for i in range(1, m.n_body):
            kind, q, v = m.body_joint[i], m.body_q[i], m.body_v[i]
            n = joints.N_V[kind] if v in at else 0
            turning = n > 0 and E_OFFSET[kind] >= 0
            lines += [(q + k, at[v + k]) for k in range(n - 3 * turning)]
            slides += [at[v + k] for k in range(min(n, joints.N_SLIDE[kind]))]

            if turning:
                E, w = q + E_OFFSET[kind], at[v + joints.N_SLIDE[kind]]
                turns.append((range(E, E + 4), range(w, w + 3)))
                self.turning.append((i, np.arange(E, E + 4), np.arange(w, w + 3)))

        # what compares with a radian (SI)
        self.unit = np.ones(len(self.free))
        self.unit[slides] = m.scene_length[0]
        self.line_q, self.line_k = np.array(lines, int).reshape(-1, 2).T
        self.turn_q = np.array([E for E, _ in turns], int).reshape(-1, 4)
        self.turn_k = np.array([w for _, w in turns], int).reshape(-1, 3)

    def look(self):
        """Takes the state of the mechanism as the one looked at: where motions go from there."""
        m = self.m
        self._check(exchange.lead(m, self.d))
        self._read_turns()
        self.x = self.d.x.copy()
        mechanism = self.mechanism
        self.v0 = self.x[m.n_q : m.n_q + m.n_v][self.free]
        self.rate0 = self.accelerations().copy()
        self.place = mechanism.here()
        self.d.x[:] = self.x
        self.frames = [self._frame(i, *at) for i, *at in self.turning]
        self._named = None
        unit = mechanism.units
        moves = self.place.motions if m.n_row else np.eye(len(self.free))
        holonomic = [r for r in range(m.n_row) if not rows.is_of_velocity(m, r)]
        self.holonomic = len(holonomic) == m.n_row
        wanders = moves

        if not self.holonomic:
            place = self.place
            wanders = replace(
                place,
                C=place.C[holonomic],
                scale=place.scale[holonomic],
                constraint=place.constraint[holonomic],
            ).motions

        weights = np.ones(len(self.free))

        for i in range(1, m.n_body):
            if m.body_joint[i] == joints.FREE:
                weights[(self.free >= m.body_v[i]) & (self.free < m.body_v[i] + 3)] = OF_WAY

        self.speeds = _independent(moves, weights)
        weights[self.speeds] = ALREADY
        self.places = self.speeds if self.holonomic else _independent(wanders, weights)
        self.V = _by_own(moves, self.speeds, unit)
        self.P = self.V if self.holonomic else _by_own(wanders, self.places, unit)

    @property
    def named(self):
        """What each free coordinate is called (`Named`)."""
        if self._named is None:
            turned = zip(self.turning, self.frames)
            self._named = names(self.mechanism, {i for (i, *_), frame in turned if not frame.of_body})

        return self._named

    @property
    def rests(self):
        """Whether no joint moves in the state looked at."""
        return bool(np.all(self.x[self.m.n_q : self.m.n_q + self.m.n_v] == 0.0))

    @property
    def states(self):
        """Names and units of the independent coordinates: positions, velocities, states of force elements."""
        names = [(self.named[k].position, self.named[k].unit) for k in self.places]
        names += [(self.named[k].rate, self.named[k].rate_unit) for k in self.speeds]
        return names + [(f"force.state[{k + 1}]", None) for k in range(len(self.z))]

    @property
    def n_states(self):
        """Number of these."""
        return len(self.places) + len(self.speeds) + len(self.z)

    # the state, moved

    def moved(self, change):
        """x (..., n_x) with positions moved by changes (..., n) of the free coordinates."""
        x = np.tile(self.x, (*change.shape[:-1], 1)) if change.ndim > 1 else self.x.copy()
        x[..., self.line_q] += change[..., self.line_k]

        if len(self.turn_q):
            x[..., self.turn_q] = _product(self.x[self.turn_q], _turn(change[..., self.turn_k]))

        return x

    def away(self, x):
        """(n,) what `moved` takes to the positions of x."""
        change = np.empty(len(self.free))
        change[self.line_k] = x[self.line_q] - self.x[self.line_q]

        if len(self.turn_q):
            back = self.x[self.turn_q] * [-1, -1, -1, 1]
            change[self.turn_k] = _turned(_product(back, x[self.turn_q]))

        return change

    def put(self, change=None, velocity=None, z=None):
        """The state moved, onto the constraints. Raises NoState where there is none."""
        x = self.x if change is None else self.moved(change)

        if velocity is not None or z is not None:
            x = x.copy()

        if velocity is not None:
            x[self.m.n_q + self.free] += velocity

        if z is not None:
            x[self.z] += z

        self._put(x)

    def _put(self, x):
        """The state x, onto the constraints."""
        m, d = self.m, self.d
        d.x[:] = x

        if m.n_row:
            self._check(exchange.lead(m, d))

        self._read_turns()

    def _read_turns(self):
        """Angles of torsion springs from their markers, on the nearest turn; loops do as they close."""
        m, d = self.m, self.d

        if m.n_turn and not m.n_row:
            rates.set_time(m, d, 0.0)
            kinematics.kinematics(m, d)
            coordinates.read_turns(m, d)

    def accelerations(self):
        """(n,) v' of the free coordinates, of the state as it is."""
        self._check(rates.evaluate(self.m, self.d, 0.0))
        return self.d.v_rate[self.free]

    def _check(self, status):
        if status != OK:
            raise NoState(explain(self.model, status))

    # derivatives

    def directions(self):
        """(kind, change (n,) or z (k,), step) of each independent coordinate."""
        unit = self.unit
        speed = max(1.0, np.abs(self.v0 / unit).max(initial=0.0))
        found = [(0, self.P[:, k], STEP * unit[at]) for k, at in enumerate(self.places)]
        found += [(1, self.V[:, k], QUICKER * speed * unit[at]) for k, at in enumerate(self.speeds)]
        size = np.maximum(1.0, np.abs(self.x[self.z]))
        return found + [(2, row, STEP * s) for row, s in zip(np.eye(len(self.z)), size)]

    def go(self, kind, direction, h):
        """The state moved by h along one of `directions`."""
        parts: list = [None, None, None]
        parts[kind] = h * direction
        self.put(*parts)

    def drift(self, away, speed, rate):
        """What is told of deviations of positions, velocities and accelerations (n, k), SI, body axes: these
        in the axes of `frames`, (ways, speeds, rates of the ways, rates of the speeds), along the motion as
        it goes on.
        """
        ways, speeds, turned, hastened = away.copy(), speed.copy(), speed.copy(), rate.copy()

        for (i, E, w), frame in zip(self.turning, self.frames):
            A = _matrix(self.x[E])
            spin, spin_rate = self.v0[w], self.rate0[w]
            way = A @ away[w]
            quick = A @ (speed[w] - np.cross(spin, away[w].T).T)
            hasty = A @ (rate[w] - np.cross(spin_rate, away[w].T).T)
            turn = quick + _cross(A @ spin, way) - _cross(frame.turning, way)
            hasty -= _cross(frame.turning, quick)
            back = A.T if frame.of_body else np.eye(3)
            ways[w], speeds[w], turned[w], hastened[w] = (back @ part for part in (way, quick, turn, hasty))

            if self.m.body_joint[i] == joints.FREE and np.any(frame.turning):
                r = w - 3
                turned[r] = speed[r] - _cross(frame.turning, away[r])
                hastened[r] = rate[r] - _cross(frame.turning, speed[r])

        return ways, speeds, turned, hastened

    def unsteady(self):
        """(n,) accelerations of the state looked at, in the axes of `frames`: 0 where it is steady."""
        found = self.rate0.copy()

        for (i, E, w), frame in zip(self.turning, self.frames):
            A = _matrix(self.x[E])
            found[w] = A @ self.rate0[w] - np.cross(frame.turning, A @ self.v0[w])

            if self.m.body_joint[i] == joints.FREE:
                found[w - 3] -= np.cross(frame.turning, self.v0[w - 3])

        return found

    def _frame(self, i, E, w):
        """The axes in which deviations of node i's joint are told: those in which its motion is steady, if
        any are.

        They turn about gravity: with the body, where that turns about it, as one in a steady turn; at the
        rate at which its angular velocity does, as that of a top that precesses; or not at all, as of a wheel
        that rolls straight on. What spins about an axis that is not gravity's is taken to be round about
        that.
        """
        A = _matrix(self.x[E])
        spin = A @ self.v0[w]
        fixed, with_body = Frame(False, np.zeros(3)), Frame(True, spin)

        if self.axes != AUTO:
            return with_body if self.axes == BODY else fixed

        m, d = self.m, self.d
        parent = m.body_parent[i]
        speed = np.linalg.norm(spin)

        if speed <= SLOW or np.abs(d.w[3 * parent : 3 * parent + 3]).max() > SLOW:
            return with_body

        down = A @ d.A.reshape(-1, 3, 3)[i].T @ m.gravity
        weight = np.linalg.norm(down)

        if weight == 0.0 or np.linalg.norm(np.cross(spin, down)) <= ALONG * speed * weight:
            return with_body

        down /= weight
        level = np.cross(down, spin)
        return Frame(False, (A @ self.rate0[w]) @ level / (level @ level) * down)

    def inertia(self):
        """(n_v, n_v) reduced mass: efforts along the independent velocities by their rates."""
        found = self._summed_inertia()
        return np.linalg.inv(self._inverse_by_responses()) if found is None else found

    def _summed_inertia(self):
        """The reduced mass by the kinetic energies of nodes and rotors; None where more moves than that,
        which the response to a drawn effort tells.
        """
        own = self.speeds

        if not len(own):
            return np.zeros((0, 0))

        blocks, twist, _ = self.inertias
        ways = np.tensordot(self.V.T, twist, 1)
        carried = np.einsum("nij,vnj->vni", blocks, ways)
        n = len(own)
        found = ways.reshape(n, -1) @ carried.reshape(n, -1).T + self.V.T @ self._of_rotors() @ self.V
        found = 0.5 * (found + found.T)

        # where a motion has no inertia the kernels lend it some
        if not _is_regular(found * self.unit[own] * self.unit[own, None]):
            return None

        efforts = found @ (np.random.default_rng(1).uniform(0.5, 1.0, n) * self.unit[own])
        self._ready()
        off = (found @ self._response(self.free[own], efforts) - efforts) * self.unit[own]
        return found if np.abs(off).max() <= ALIKE * np.abs(efforts * self.unit[own]).max() else None

    def _of_rotors(self):
        """(n, n) what rotors add to the inertia of the free coordinates."""
        m, d = self.m, self.d
        found = np.zeros((len(self.free), len(self.free)))

        for i in m.rotor_body[: m.n_rotor].tolist():
            at = np.flatnonzero(self.free == m.body_v[i])
            turn = self.place.twist[:, rotors.host(m, i), :3] @ d.axis[3 * i : 3 * i + 3]
            found[at] += rotors.coupling(m, i) * turn
            found[:, at] += rotors.coupling(m, i) * turn[:, None]
            found[at, at] += rotors.own(m, i)

        return found

    @property
    def inertias(self):
        """(blocks (n_body - 1, 6, 6), twists (n, n_body - 1, 6) by free coordinates, inertias (n,) that each
        moves alone), of the nodes at the state looked at, about their origins, inertial axes.
        """
        m, d = self.m, self.d
        self.put()
        kinematics.kinematics(m, d)
        inertia.inertias(m, d)
        blocks = _spatial(m, d)
        twist = self.place.twist[:, 1:]
        carried = np.einsum("nij,knj->kni", blocks, twist)
        own = np.einsum("kni,kni->k", twist, carried) + np.diag(self._of_rotors())

        return blocks, twist, own

    def _ready(self):
        """The state looked at, as far as responses to efforts need it."""
        m, d = self.m, self.d
        self.put()
        rates.set_time(m, d, 0.0)
        drives.prescribe(m, d)
        kinematics.kinematics(m, d)

    def _response(self, at, efforts):
        """(n_v,) change of the independent accelerations by efforts at velocity coordinates."""
        m, d = self.m, self.d
        found = []

        for sign in (1.0, -1.0):
            inertia.inertias(m, d)
            forces.apply(m, d)
            d.tau[at] += sign * efforts
            self._check(forward.accelerate(m, d))
            found.append(d.v_rate[self.free[self.speeds]].copy())

        return 0.5 * (found[0] - found[1])

    def _inverse_by_responses(self):
        found = np.empty((len(self.speeds), len(self.speeds)))
        self._ready()

        for k, at in enumerate(self.free[self.speeds].tolist()):
            size = 1.0

            # efforts that make accelerations of the size of 1
            for _ in range(2):
                found[k] = self._response(at, size) / size
                size = 1.0 / max(np.abs(found[k]).max(), 1e-300)

                if 1e-4 < size < 1e4:
                    break

        return 0.5 * (found + found.T)

    def stiffness(self):
        """(n_v, n_v): -derivatives of the independent accelerations by ways along the independent velocities,
        by differences of order 2: for Newton's method.
        """
        h = 1e-5 * self.unit[self.speeds]
        found = np.empty((2, len(h), len(h)))

        for side, ways in enumerate((-h * self.V, h * self.V)):
            for k, x in enumerate(self.moved(ways.T)):
                self._put(x)
                found[side, :, k] = self.accelerations()[self.speeds]

        return (found[0] - found[1]) / (2.0 * h)


def _is_regular(mass):
    """Whether a symmetric matrix is positive, and not by rounding alone."""
    try:
        pivots = np.diag(np.linalg.cholesky(mass))
    except np.linalg.LinAlgError:
        return False

    return pivots.min() > 1e-7 * pivots.max()


def _spatial(m, d):
    """(n_body - 1, 6, 6) inertias of the nodes about their origins, inertial axes, as angular then linear."""
    found = np.zeros((m.n_body, 6, 6))
    found[:, :3, :3] = _symmetric(d.I)
    h, mass = d.h.reshape(-1, 3), d.body_m
    found[:, :3, 3:] = _crossed(h)
    found[:, 3:, 3:] = mass[:, None, None] * np.eye(3)
    added = m.body_added == 1

    if added.any():
        found[added, :3, 3:] = d.H.reshape(-1, 3, 3)[added]
        found[added, 3:, 3:] = _symmetric(d.M)[added]

    found[:, 3:, :3] = found[:, :3, 3:].transpose(0, 2, 1)
    return found[1:]


def _symmetric(values):
    """(n, 3, 3) of (xx, yy, zz, xy, xz, yz) each."""
    return values.reshape(-1, 6)[:, [[0, 3, 4], [3, 1, 5], [4, 5, 2]]]


def _crossed(vectors):
    """(n, 3, 3): matrices of the cross products with vectors (n, 3)."""
    found = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    found[:, 2, 1], found[:, 0, 2], found[:, 1, 0] = x, y, z
    found[:, 1, 2], found[:, 2, 0], found[:, 0, 1] = -x, -y, -z
    return found


def _independent(motions, weights):
    """Coordinates by which motions (n, k) are told best, ascending."""
    if motions.shape[1] == motions.shape[0]:
        return np.arange(motions.shape[0])

    _, pivots = scipy.linalg.qr((weights[:, None] * motions).T, mode="r", pivoting=True)
    return np.sort(pivots[: motions.shape[1]])


def _by_own(motions, own, unit):
    """(n, k) motions for a unit of each of their own coordinates, SI."""
    if not len(own):
        return np.zeros((motions.shape[0], 0))

    if len(own) == len(motions):
        return np.eye(len(own))

    found = unit[:, None] * np.linalg.solve(motions[own].T, motions.T).T / unit[own]
    found[own] = np.eye(len(own))
    return found


def _product(E, F):
    """Products of Euler parameters (n, 4) and (..., n, 4), scalar last."""
    x, y, z, w = E.T
    a, b, c, d = np.moveaxis(F, -1, 0)
    parts = [
        w * a + d * x + y * c - z * b,
        w * b + d * y + z * a - x * c,
        w * c + d * z + x * b - y * a,
        w * d - x * a - y * b - z * c,
    ]
    return np.stack(parts, axis=-1)


def _turn(vectors):
    """Euler parameters (..., 4) of rotation vectors (..., 3)."""
    half = 0.5 * np.sqrt((vectors * vectors).sum(axis=-1))
    found = np.empty((*vectors.shape[:-1], 4))
    # sin(a) / a, which is 1 to the last digit below
    small = half < 1e-8
    found[..., :3] = (
        np.where(small, 0.5, 0.5 * np.sin(half) / np.where(small, 1.0, half))[..., None] * vectors
    )
    found[..., 3] = np.cos(half)
    return found


def _turned(E):
    """Rotation vectors (n, 3) of Euler parameters (n, 4), the short way round."""
    E = np.where(E[:, 3:] < 0.0, -E, E)
    size = np.linalg.norm(E[:, :3], axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(size, E[:, 3:])
    return np.where(size > 1e-150, angle / np.where(size > 1e-150, size, 1.0), 2.0) * E[:, :3]


def _cross(a, columns):
    """(3, k) cross products of a vector with columns."""
    return np.cross(a, columns.T).T


def _matrix(E):
    """(3, 3) of Euler parameters (4,), scalar last: from the body's axes to the joint's first side's."""
    v, b = E[:3], E[3]
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + 2.0 * b * cross + 2.0 * cross @ cross


def names(mechanism, inertial=()):
    """What each free coordinate is called; inertial: nodes whose orientations are not told in the body's
    axes.
    """
    m, scene = mechanism.m, mechanism.scene
    found = {}

    for i, node in enumerate(mechanism.model.tree.nodes):
        if i == 0 or m.body_drive[i] >= 0:
            continue

        kind, v = m.body_joint[i], m.body_v[i]
        joint = scene.joint.get(node.joint)
        slides = joints.N_SLIDE[kind]

        if joint is not None and E_OFFSET[kind] < 0 and joints.N_V[kind] == 1:
            coordinate, ending = scalars(joint)[node.coordinate]
            found[v] = Named(
                dotted(node.joint, coordinate.position.name) + ending,
                dotted(node.joint, coordinate.rate.name) + ending,
                node.joint,
                coordinate.position.unit,
                coordinate.rate.unit,
            )
            continue

        name = node.joint or node.name

        for k in range(joints.N_V[kind]):
            if k < slides:
                words = ("position", "velocity", k + 1, "m", "m/s")
            else:
                omega = "omega" if i in inertial else "omega_body"
                words = ("rotation", omega, k - slides + 1, "rad", "rad/s")

            position, rate, index, *units = words
            found[v + k] = Named(
                dotted(name, f"{position}") + f"[{index}]",
                dotted(name, f"{rate}") + f"[{index}]",
                name,
                *units,
            )

    return [found[v] for v in mechanism.free]
