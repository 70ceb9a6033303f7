"""Linear models of a scene about a state: x' = A x + B u, y = C x + D u in minimal coordinates
(docs/theory.md 19.4).
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import scipy  # which imports its parts when they are asked for

from ..files import check_ending, replacing
from ..kernels import entry
from ..run.inputs import known
from ..scene import variable_name
from ..scene.errors import listed
from .differences import GOOD, derivative
from .exact import exact
from .manifold import Manifold

# relative error of a derivative from which on it is told
POOR = 1e-7

# relative error of exact derivatives, rounding in many sums
EXACT = 1e-15

# of their check: steps as parts of those of differences, how far these may be off, of what size at least
CLOSER = 0.1
ROUGH = 1e-2
SMALL = 1e-3
ROUNDED = 1e-11

ENDINGS = (".npz", ".mat")

# accelerations (rad/s2, or of the scene's length) that are told: a steady state is known to some digits alone
STEADY = 1e-4


@dataclass(frozen=True)
class Linear:
    """A scene linearised about a state.

    A, B, C, D : x' = A x + B u, y = C x + D u, deviations from the state looked at, SI.
    states, inputs, outputs : names; units : of all of these, by name.
    n_places, n_speeds : how many of the states, in this order, are positions and velocities; the others are
        states of force elements.
    u0, y0 : inputs and outputs of the state. acceleration : (n_speeds,) v' there; rate : (n_states,) x'
        there.
    time : s. inertia : (n_speeds, n_speeds) the reduced mass matrix.
    sensitivities : derivatives by parameters, where they were asked for (`Sensitivities`), else None.
    error : estimated relative error of the derivatives. notices : what a user should be told. where : what
        state it is, in words.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    states: list[str]
    inputs: list[str]
    outputs: list[str]
    units: dict[str, str | None]
    n_places: int
    n_speeds: int
    u0: np.ndarray
    y0: np.ndarray
    acceleration: np.ndarray
    time: float
    inertia: np.ndarray
    error: float
    title: str
    notices: list[str] = field(default_factory=list)
    manifold: Manifold | None = field(default=None, repr=False)
    sensitivities: Any = None
    where: str = ""

    def state_space(self):
        """The same as scipy.signal.StateSpace."""
        from scipy.signal import StateSpace

        return StateSpace(self.A, self.B, self.C, self.D)

    def control(self):
        """The same as control.StateSpace, with names, in which it takes no dots. Raises ImportError where
        python-control is missing.
        """
        try:
            import control
        except ImportError:
            raise ImportError("python-control is not installed: pip install control") from None

        told = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        names = {key: [name.replace(".", "_") for name in some] for key, some in told.items()}
        return control.ss(self.A, self.B, self.C, self.D, **names)

    @property
    def stiffness(self):
        """(n_speeds, n_speeds) efforts along the independent velocities by ways along these: the reduced
        stiffness, at rest.
        """
        return -self.inertia @ self._by_ways()

    @property
    def damping(self):
        """(n_speeds, n_speeds) likewise by velocities, gyroscopic terms included."""
        p, v = self.n_places, self.n_speeds
        return -self.inertia @ self.A[p : p + v, p : p + v]

    def _by_ways(self):
        """(n_speeds, n_speeds) accelerations by ways that velocities lead to."""
        p, v = self.n_places, self.n_speeds
        return self.A[p : p + v, :p] @ self.A[:p, p : p + v]

    def modes(self):
        """The modes; see `mbdfmi.analysis.modes.Modes`."""
        from .modes import modes_of

        return modes_of(self)

    def save(self, path) -> Path:
        """Write the matrices and the names to a file that numpy (.npz) or MATLAB (.mat) reads. Returns the
        path.
        """
        path = Path(path)
        check_matrices(path)
        tables = {key: getattr(self, key) for key in ("A", "B", "C", "D", "u0", "y0", "time")}
        tables |= {"mass": self.inertia, "stiffness": self.stiffness, "damping": self.damping}
        names = {key: getattr(self, key) for key in ("states", "inputs", "outputs")}
        names["state_units"] = [self.units[name] or "" for name in self.states]

        with replacing(path) as temporary, open(temporary, "wb") as file:
            if path.suffix.lower() == ".npz":
                arrays = tables | {key: np.array(some, str) for key, some in names.items()}
                np.savez(file, allow_pickle=False, **arrays)
            else:
                cells = {key: np.array(some, object).reshape(-1, 1) for key, some in names.items()}
                scipy.io.savemat(file, tables | cells)

        return path


def check_matrices(path):
    """Raises now the ValueError that `Linear.save` would raise later for a file's ending."""
    check_ending(path, "matrices are to be written", *ENDINGS)

    if Path(path).suffix.lower() not in ENDINGS:
        raise ValueError(f"{path}: let its name end in .npz (numpy) or .mat (MATLAB, Octave)")


def about(manifold: Manifold, inputs=None, outputs=None, notices=(), traced=False) -> Linear:
    """The same of the state that a manifold looks at; traced : by exact derivatives, where there are some."""
    model, m, d = manifold.model, manifold.m, manifold.d
    u_at, u_names, left = _inputs(model, m, inputs)
    y_at, y_names = _chosen(model, outputs, "output")
    look = _Look(manifold, y_at)
    n, n_z, n_seen = len(manifold.free), len(manifold.z), look.n_rates
    here = look.here()
    T, by_inputs, worst = look.derivatives(u_at, here, traced)
    manifold.put()
    rate, z_rate, shown, away, speed, z = np.split(T, np.cumsum([n, n_z, len(y_at), n, n]))
    P, V = manifold.places, manifold.speeds
    away, speed, turning, rate = manifold.drift(away, speed, rate)
    S = np.vstack([away[P], speed[V], z])
    R = np.vstack([turning[P], rate[V], z_rate])
    back = np.linalg.inv(S) if len(S) else S
    states = manifold.states
    units = dict(states)
    units |= {v.name: v.unit for v in model.variables}
    notes = [*notices, *_unsteady(manifold)]

    if left:
        notes.append(
            f"{listed(left)} {'commands' if len(left) == 1 else 'command'} motion, which acts by its rates "
            "too: held, no input of the linear model"
        )
    if look.kinks[n_seen:].any():
        names = [name for name, bent in zip(y_names, look.kinks[n_seen:]) if bent]
        notes.append(f"{listed(names, limit=6)}: a kink is here, and the derivative a mean of its two sides")

    if worst > POOR:
        notes.append(
            f"derivatives are known to {worst:.1g} alone: the state is at, or within differences of, a kink "
            "(a stop, a rope that comes taut, friction)"
        )

    return Linear(
        A=R @ back,
        B=np.vstack([np.zeros((len(P), len(u_at))), by_inputs[:n][V], by_inputs[n:n_seen]]),
        C=shown @ back,
        D=by_inputs[n_seen:],
        states=[name for name, _ in states],
        inputs=u_names,
        outputs=y_names,
        units=units,
        n_places=len(P),
        n_speeds=len(V),
        u0=d.u_buffer[u_at].copy(),
        y0=here[n_seen:],
        acceleration=here[:n][V],
        time=float(d.time[0]),
        inertia=manifold.inertia(),
        error=worst,
        title=model.title,
        notices=notes,
        manifold=manifold,
    )


def _chosen(model, names, causality):
    """(positions in the buffer, names) of variables, by default of all."""
    by_name = {v.name: v for v in model.of_causality(causality)}

    if names is None:
        parts = list(by_name)
    else:
        names = [names] if isinstance(names, str) else names
        parts = [part for name in names for part in known(variable_name(name), by_name, causality)]

    return np.array([by_name[part].index for part in parts], int), parts


def _inputs(model, m, names):
    """(positions in u, names) of inputs, and those left out as they command motion. Raises ValueError."""
    at, parts = _chosen(model, names, "input")
    commands = set(m.command_u[: 3 * m.n_command].tolist())
    # all inputs of the ground are of its motion
    left = [part for k, part in zip(at, parts) if k in commands or part.startswith("ground.")]

    if names is not None and left:
        raise ValueError(
            f"{listed(left)}: commands motion, which acts by its rates too; it is no input of a linear model"
        )

    keep = [(k, part) for k, part in zip(at, parts) if part not in left]
    return np.array([k for k, _ in keep], int), [part for _, part in keep], left


class _Look:
    """What is seen of the states near the one that a manifold looks at: rates (of free velocities and force
    elements), then outputs.
    """

    def __init__(self, manifold, y_at):
        self.manifold, self.y_at = manifold, y_at
        self.m, self.d = manifold.m, manifold.d
        self.y = np.zeros(manifold.model.n_y)
        self.z_rates = manifold.z - self.m.n_q - self.m.n_v
        self.n_rates = len(manifold.free) + len(manifold.z)
        self.kinks = np.zeros(self.n_rates + len(y_at), bool)

    def here(self):
        """(n_rates + n_y,) of the state as it is."""
        manifold, d = self.manifold, self.d
        parts = [manifold.accelerations()]

        if len(self.z_rates):
            parts.append(d.z_rate[self.z_rates])

        if len(self.y_at):
            manifold._check(entry.compute_outputs(self.m, d, self.y))
            parts.append(self.y[self.y_at])

        return np.concatenate(parts)

    def _with_place(self):
        """The same, then where the state is: positions, velocities, states of force elements."""
        manifold, d = self.manifold, self.d
        return np.concatenate([self.here(), manifold.away(d.x), d.v[manifold.free], d.x[manifold.z]])

    def derivatives(self, u_at, here, traced):
        """(derivatives along the independent coordinates, by inputs, relative error); here : what is seen."""
        found = exact(self.manifold, self.y_at, u_at) if traced else None

        bent = self._bent(found.along, here) if found else np.ones(1, bool)

        if found and not bent[: self.n_rates].any():
            along, by_inputs = found

            if bent.any():
                along[: len(bent)][bent] = self.along(here)[0][: len(bent)][bent]

            return along, by_inputs, EXACT

        along, worst = self.along(here)
        self.manifold.put()
        return along, self.by_inputs(u_at), worst

    def _bent(self, along, here):
        """(n_rates + n_y,): what is not as differences of order 2 have it, as there is a kink near, on one
        side of which a trace is.
        """
        manifold = self.manifold
        n, p = len(here), len(manifold.places)
        own = n + len(manifold.free) + manifold.speeds
        by_speeds = along[:, p : p + len(own)]

        bent = np.zeros(n, bool)
        # rates are of one sort, outputs of many
        every = np.abs(along[:n])
        every[: self.n_rates] = every[: self.n_rates].max(axis=0, initial=0.0)

        for column, size, (kind, direction, step) in zip(along.T, every.T, manifold.directions()):
            step *= CLOSER
            seen = []

            for k in (-2, -1, 1, 2):
                manifold.go(kind, direction, k * step)
                speeds = self.d.v[manifold.free[manifold.speeds]]
                seen.append(np.concatenate([self.here(), speeds]))

            rate, speed = np.split((seen[2] - seen[1]) / (2.0 * step), [n])
            # on the constraints speeds may go along otherwise
            exact_rate = (column + by_speeds @ (speed - column[own]))[:n]
            near, far = (seen[1] + seen[2])[:n] - 2.0 * here, (seen[0] + seen[3])[:n] - 2.0 * here
            # of what is smooth the second is four times the first, at a kink twice
            off = np.abs(rate - exact_rate) + np.abs(far - 4.0 * near) / step
            bent |= ~(off <= ROUGH * np.maximum(size + off, SMALL) + ROUNDED * np.abs(seen[3][:n]) / step)

        self.kinks |= bent
        return bent

    def along(self, here):
        """(derivatives along the independent coordinates, by columns, of all of that; relative error)."""
        manifold = self.manifold
        measured = slice(0, self.n_rates)
        n, n_z = len(manifold.free), len(manifold.z)
        # without constraints directions are what they say
        exact = self.m.n_row == 0
        see = self.here if exact else self._with_place
        columns, worst = [], 0.0
        manifold.put()
        centre = here if exact else see()

        kinks = np.zeros(len(centre), bool)
        still = exact and manifold.rests and not len(self.y_at) and self._are_even_in_speeds()

        for kind, direction, step in manifold.directions():

            def at(h, kind=kind, direction=direction):
                manifold.go(kind, direction, h)
                return see()

            if kind == 1 and still:
                found, error = np.zeros(len(centre)), GOOD
            else:
                found, error = derivative(at, step, measured, here=centre, kinks=kinks)

            if exact:
                place = [np.zeros(n), np.zeros(n), np.zeros(n_z)]
                place[kind] = direction
                found = np.concatenate([found, *place])

            columns.append(found)
            worst = max(worst, error)

        self.kinks |= kinks[: len(self.kinks)]
        size = self.n_rates + len(self.y_at) + 2 * n + n_z
        return np.array(columns).reshape(len(columns), size).T, worst

    def _are_even_in_speeds(self):
        """Whether no rate depends on velocities in the first place, as at rest without dampers: two drawn
        ones that are turned round make no difference, which else is as likely as to draw a number twice.
        """
        manifold = self.manifold
        draw = np.random.default_rng(1)
        n = max(1, len(manifold.speeds))

        for _ in range(2):
            speeds = manifold.V @ (draw.uniform(0.5, 1.0, len(manifold.speeds)) / n) * manifold.unit

            for size in (1.0, 1e-2):
                manifold.put(velocity=size * speeds)
                ahead = self.here()
                manifold.put(velocity=-size * speeds)

                if np.abs(ahead - self.here()).max(initial=0.0) > GOOD * np.abs(ahead).max(initial=0.0):
                    return False

        return True

    def by_inputs(self, u_at):
        """(n_rates + n_y, n_u) derivatives by inputs."""
        m, d = self.m, self.d
        weight = max(1.0, m.solid_mass.sum() * 9.81) if m.n_solid else 1.0
        found = np.empty((self.n_rates + len(self.y_at), len(u_at)))

        for column, k in enumerate(u_at.tolist()):
            value = d.u_buffer[k]

            def at(h, k=k, value=value):
                d.u_buffer[k] = value + h
                return self.here()

            try:
                found[:, column], _ = derivative(at, max(abs(value), 1e-2 * weight), slice(0, self.n_rates))
            finally:
                d.u_buffer[k] = value

        return found


def _unsteady(manifold):
    """What is to be told where the motion is not steady: []."""
    rates_ = manifold.unsteady()
    sizes = np.abs(rates_) / manifold.unit

    if not len(manifold.speeds) or sizes.max(initial=0.0) <= STEADY:
        return []

    k = int(sizes.argmax())
    return [
        f"the state is not steady: {manifold.named[k].rate} changes by {rates_[k]:.3g} a second, so this "
        "holds for the moment alone"
    ]
