"""Modes of a linear model: frequencies, damping, shapes, who takes part (docs/theory.md 19.5)."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy  # which imports its parts when they are asked for

from ..scene.errors import listed

# a column or row of A that small beside the largest element of its kind is nothing: what it is about does not
# matter
NOTHING = 1e-10

# parts of undamped, symmetric matrices below which they are that
SYMMETRIC = 1e-9

# an undamped frequency below that part of the highest (squared) is none
FREE = 1e-10

# shares below this are not told
TOLD = 0.01


@dataclass(frozen=True)
class Mode:
    """One mode: an eigenvalue (1/s), of a pair that with the positive imaginary part.

    vector : (n_states,) of the states. A positive damping dies away.
    """

    eigenvalue: complex
    vector: np.ndarray
    shares: "_Shares" = field(repr=False)

    @cached_property
    def _told(self):
        return self.shares.of(self.vector)

    @property
    def shape(self) -> np.ndarray:
        """(n,) complex change of all free joint coordinates, the largest of size 1 (rad, or the scene's
        length).
        """
        return self._told[0]

    @property
    def joints(self) -> dict[str, float]:
        """Shares by name, largest first, of the motion's inertia in the joints."""
        return self._told[1]

    @property
    def bodies(self) -> dict[str, float]:
        """Likewise of the kinetic energy of the bodies."""
        return self._told[2]

    @property
    def oscillates(self) -> bool:
        """Whether it is one of a pair."""
        return self.eigenvalue.imag > 0.0

    @property
    def frequency(self) -> float:
        """Hz, undamped: |eigenvalue| / 2 pi of one that oscillates, else 0."""
        return abs(self.eigenvalue) / (2 * np.pi) if self.oscillates else 0.0

    @property
    def damped_frequency(self) -> float:
        """Hz, of the motion."""
        return float(self.eigenvalue.imag) / (2 * np.pi)

    @property
    def damping(self) -> float:
        """Part of critical damping; negative where it grows."""
        size = abs(self.eigenvalue)
        return float(-self.eigenvalue.real / size) if size else 0.0

    @property
    def period(self) -> float:
        """s, of the motion; infinite where it does not oscillate."""
        return 1.0 / self.damped_frequency if self.oscillates else np.inf

    @property
    def stable(self) -> bool:
        """Whether it dies away or at least does not grow."""
        return self.eigenvalue.real <= NOTHING * abs(self.eigenvalue)


@dataclass(frozen=True)
class Modes:
    """The modes of a linear model (`Linear`), slowest first.

    eigenvalues : (n_states,) all of A, those that are zero by structure exactly. modes : of pairs one each;
    free : states that nothing depends on, or that nothing changes: an eigenvalue 0 each.
    """

    linear: Any = field(repr=False)
    eigenvalues: np.ndarray
    modes: list[Mode]
    free: list[str]

    def __len__(self):
        return len(self.modes)

    def __getitem__(self, k):
        return self.modes[k]

    def __iter__(self):
        return iter(self.modes)

    @property
    def frequencies(self):
        """(n,) Hz, undamped, of the modes that oscillate."""
        return np.array([mode.frequency for mode in self.modes if mode.oscillates])

    @property
    def stable(self) -> bool:
        """Whether no mode grows."""
        return all(mode.stable for mode in self.modes)

    @property
    def notices(self):
        """What a user should be told."""
        some = [f"{listed(self.free, limit=6)}: free, nothing calls them back"] if self.free else []
        return [*self.linear.notices, *some]

    def tables(self):
        """Arrays by name, to be saved: eigenvalues (1/s), shapes (n_states, n_modes), frequencies (Hz),
        damping.
        """
        modes = self.modes
        return {
            "eigenvalues": np.array([mode.eigenvalue for mode in modes], complex),
            "shapes": np.array([mode.vector for mode in modes], complex).reshape(len(modes), -1).T,
            "frequencies": np.array([mode.frequency for mode in modes]),
            "damped_frequencies": np.array([mode.damped_frequency for mode in modes]),
            "damping_ratios": np.array([mode.damping for mode in modes]),
        }


def modes_of(linear) -> Modes:
    """The modes of a `Linear`."""
    values, vectors, free = _eigen(linear)
    order = np.lexsort((values.imag, values.real, np.abs(values.imag) > 0, np.abs(values)))
    shares = _Shares(linear.manifold)
    modes = [Mode(complex(values[k]), vectors[:, k], shares) for k in order if values[k].imag >= 0.0]
    every = np.concatenate([np.zeros(len(free)), values])
    return Modes(linear, every, modes, free)


def _eigen(linear):
    """(eigenvalues, eigenvectors of all states, names of the states that are free)."""
    A, p, v = linear.A, linear.n_places, linear.n_speeds
    kept, free = _essential(A, linear)

    if linear.manifold.rests and p == v and len(A) == p + v and np.all(np.isin(np.arange(p + v), kept)):
        found = _undamped(linear, A[v:, :v], A[v:, v:])

        if found is not None:
            return (*found, free)

    values, some = scipy.linalg.eig(A[np.ix_(kept, kept)]) if len(kept) else (np.zeros(0), np.zeros((0, 0)))
    values = np.where(np.abs(values) <= NOTHING * np.abs(values).max(initial=0.0), 0.0, values)
    vectors = np.zeros((len(A), len(kept)), complex)
    vectors[kept] = some
    left_out = np.setdiff1d(np.arange(len(A)), kept)

    # states that are driven along: lambda x = A x, as far as lambda is not 0
    for k, value in enumerate(values):
        if abs(value) > 0.0 and left_out.size:
            rest = value * np.eye(len(left_out)) - A[np.ix_(left_out, left_out)]
            vectors[left_out, k] = np.linalg.lstsq(rest, A[np.ix_(left_out, kept)] @ some[:, k], rcond=None)[
                0
            ]

    return values, vectors, free


def _essential(A, linear):
    """(states that matter to themselves and others, names of those that do not)."""
    size = np.ones(len(A))
    p = linear.n_places

    # positions beside velocities as far as the fastest motion makes them alike
    if len(A):
        size[:p] = 1.0 / max(1.0, np.sqrt(np.abs(A[p:, :p]).max(initial=0.0)))

    scaled = np.abs(A) * size[None, :] / size[:, None]
    tiny = NOTHING * max(scaled[:, :].max(initial=0.0), 1e-30)
    kept = np.arange(len(A))

    while True:
        block = scaled[np.ix_(kept, kept)]
        gone = (block.max(axis=0, initial=0.0) <= tiny) | (block.max(axis=1, initial=0.0) <= tiny)

        if not gone.any():
            break

        kept = kept[~gone]

    free = [linear.states[k] for k in np.setdiff1d(np.arange(len(A)), kept)]
    return kept, free


def _undamped(linear, by_ways, by_speeds):
    """(eigenvalues, vectors) of a conservative system at rest by its symmetric matrices; None for another."""
    n = len(by_ways)

    if np.abs(by_speeds).max(initial=0.0) > SYMMETRIC * np.sqrt(np.abs(by_ways).max(initial=1e-300)):
        return None

    stiffness = linear.inertia @ by_ways

    if np.abs(stiffness - stiffness.T).max(initial=0.0) > SYMMETRIC * np.abs(stiffness).max(initial=1e-300):
        return None

    # L L^T = M: in L^T v the mass is 1
    L = np.linalg.cholesky(linear.inertia)
    K = -L.T @ scipy.linalg.solve_triangular(L, by_ways.T, lower=True).T
    squares, shapes = np.linalg.eigh(0.5 * (K + K.T))
    squares[np.abs(squares) <= FREE * np.abs(squares).max(initial=0.0)] = 0.0
    roots = np.sqrt(-squares.astype(complex))
    shapes = scipy.linalg.solve_triangular(L, shapes, lower=True, trans="T")
    values = np.concatenate([roots, -roots])
    return values, np.block([[shapes, shapes], [shapes * roots, -shapes * roots]]).reshape(2 * n, 2 * n)


class _Shares:
    """Who takes part in the modes about the state that a manifold looks at."""

    def __init__(self, manifold):
        self.manifold = manifold
        self.bodies = [_told(node) for node in manifold.model.tree.nodes[1:]]

    @cached_property
    def _inertias(self):
        return self.manifold.inertias

    def of(self, vector):
        """(shape, shares of joints, shares of bodies) of an eigenvector of the states."""
        manifold = self.manifold
        blocks, twist, inertias = self._inertias
        p, n = len(manifold.places), len(manifold.speeds)
        own, ways = vector[p : p + n], vector[:p]
        places = manifold.P @ ways
        speeds = manifold.V @ own
        shape = places if np.abs(places / manifold.unit).max(initial=0.0) > 0.0 else speeds
        moving = speeds if np.abs(speeds / manifold.unit).max(initial=0.0) > 0.0 else places
        size = shape[np.argmax(np.abs(shape / manifold.unit))] if len(shape) else 1.0
        unit = manifold.unit[np.argmax(np.abs(shape / manifold.unit))] if len(shape) else 1.0
        shape = shape * unit / size if size else shape
        names = [named.joint for named in manifold.named]
        joints = _summed(names, np.abs(moving) ** 2 * inertias)
        twists = np.einsum("k,kni->ni", moving, twist)
        energies = np.einsum("ni,nij,nj->n", twists.conj(), blocks, twists).real
        return shape, joints, _summed(self.bodies, energies)


def _told(node):
    """A node by its first body."""
    more = len(node.bodies) - 1
    return f"{node.bodies[0]} (+{more})" if more > 0 else node.name


def _summed(names, values):
    """Shares by name of what is summed over its values, the largest first."""
    total = max(float(np.sum(values)), 1e-300)
    found: dict[str, float] = {}

    for name, value in zip(names, values):
        found[name] = found.get(name, 0.0) + float(value) / total

    return dict(sorted(found.items(), key=lambda item: -item[1]))
