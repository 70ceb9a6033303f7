"""Exact derivatives of a scene about a state that a manifold looks at, where its equations can be traced."""

from typing import NamedTuple

import numpy as np

from ..trace.functions import derivatives
from ..trace.graph import Untraceable

# nodes of the tree up to which a scene is traced: beyond, differences cost less by far
LARGEST = 12

# parts of the largest rate by which a trace may differ from what the kernels say: rounding, in another order
SAME = 1e-9


class Exact(NamedTuple):
    """Derivatives along the independent coordinates, and by inputs.

    along : (n, n_states) of the free accelerations, rates of force elements' states, outputs, then where the
        state is: free positions, velocities (body axes), states of force elements. by_inputs : (n_seen, n_u)
        of the first three.
    """

    along: np.ndarray
    by_inputs: np.ndarray


def exact(manifold, y_at, u_at) -> Exact | None:
    """The derivatives by a trace; None where the scene is too large or cannot be traced, or where states go
    along with others by what is not traced.
    """
    m = manifold.m

    # parameters of end frames and counted turns follow from positions
    if m.n_body > LARGEST or m.n_s or m.n_turn:
        return None

    manifold.put()
    here = manifold.accelerations().copy()

    try:
        found = derivatives(manifold.mechanism.instance, outputs=bool(len(y_at)))
    except Untraceable:
        return None

    v = m.n_q + manifold.free
    seen = np.concatenate([v, manifold.z])
    off = np.abs(found.rates[v] - here).max(initial=0.0)

    if not off <= SAME * max(1.0, np.abs(here).max(initial=0.0)):
        return None

    ways, speeds = _ways(manifold), np.zeros((m.n_x, len(manifold.free)))
    speeds[v] = np.eye(len(manifold.free))
    places, V = ways @ manifold.P, speeds @ manifold.V
    moved = _kept(manifold, speeds, found.gap_rates_by_states, places)
    states = np.zeros((m.n_x, len(manifold.z)))
    states[manifold.z] = np.eye(len(manifold.z))
    along = np.hstack([places + speeds @ moved, V, states])
    n_v, n_z = len(manifold.speeds), len(manifold.z)
    of_ways = np.hstack([manifold.P, np.zeros((len(manifold.free), n_v + n_z))])
    of = np.vstack([found.A[seen], found.C[y_at]] if len(y_at) else [found.A[seen]])
    by = np.vstack([found.B[seen], found.D[y_at]] if len(y_at) else [found.B[seen]])
    whole = np.vstack([of @ along, of_ways, along[v], along[manifold.z]])
    return Exact(whole, by[:, u_at]) if np.isfinite(whole).all() and np.isfinite(by).all() else None


def _ways(manifold):
    """(n_x, n): change of the state by that of the free positions, as `Manifold.moved` has it."""
    found = np.zeros((manifold.m.n_x, len(manifold.free)))
    found[manifold.line_q, manifold.line_k] = 1.0

    for E, k in zip(manifold.turn_q, manifold.turn_k):
        found[np.ix_(E, k)] = _turning(manifold.x[E])

    return found


def _turning(E):
    """(4, 3): change of Euler parameters by a rotation vector in the body's axes: half of E times it."""
    a, b, c, s = 0.5 * E
    return np.array([[s, -c, b], [c, s, -a], [-b, a, s], [-a, -b, -c]])


def _kept(manifold, speeds, by_states, places):
    """(n, n_p) change of the free velocities that keeps to the constraints as positions change."""
    n = len(manifold.free)

    if not manifold.m.n_row or manifold.rests:
        return np.zeros((n, places.shape[1]))

    scale = manifold.unit
    of_speeds = by_states @ speeds * scale
    return scale[:, None] * np.linalg.lstsq(of_speeds, -by_states @ places, rcond=None)[0]
