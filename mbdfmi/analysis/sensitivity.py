"""How rest, outputs and modes change with parameters (docs/theory.md 19.9)."""

from dataclasses import dataclass

import numpy as np
import scipy  # which imports its parts when they are asked for

from ..run.inputs import known
from ..scene import variable_name
from .differences import derivative
from .linear import about
from .manifold import Manifold
from .places import state_at

# step of differences, as part of a parameter's size
STEP = 4e-3

# eigenvalues closer than that part of the largest are taken for one, whose derivative is not told
ALIKE = 1e-5


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives by parameters, SI.

    names, values : (n_p,) of the parameters.
    places : {coordinate: (n_p,)} of the state, of free joint coordinates (rad, m; of orientations the
        rotation vector in the body's axes). outputs : {output: (n_p,)}.
    eigenvalues : (n_modes, n_p) complex, 1/s, of the modes in their order; NaN of those that others are equal
        to.
    frequencies : (n_modes, n_p) Hz, undamped; damping : (n_modes, n_p) of the parts of critical damping.
    error : estimated relative error.
    """

    names: list[str]
    values: np.ndarray
    places: dict[str, np.ndarray]
    outputs: dict[str, np.ndarray]
    eigenvalues: np.ndarray
    frequencies: np.ndarray
    damping: np.ndarray
    error: float

    def relative(self, modes) -> np.ndarray:
        """(n_modes, n_p): change of the frequencies in parts of them by parts of the parameters."""
        sizes = np.array([mode.frequency for mode in modes])[:, None]
        return self.frequencies * self.values / np.where(sizes > 0.0, sizes, np.nan)


def sensitivities(scene, names, outputs, at, axes, hold, parameters, linear) -> Sensitivities:
    """Of what `linear` is about; names : of parameters, an array's name means all its elements."""
    mechanism = linear.manifold.mechanism
    by_name = {v.name: v for v in mechanism.model.of_causality("parameter")}
    parts = [part for name in names for part in known(variable_name(name), by_name, "parameter")]
    base = linear.modes()
    n = len(base)
    first = np.array([mode.eigenvalue for mode in base], complex)
    columns, values, worst = [], [], 0.0
    x = linear.manifold.x.copy()

    for name in parts:
        value = float(mechanism.instance.reals[by_name[name].index])

        def see(h, name=name, value=value):
            changed = (parameters or {}) | {name: value + h}
            found, _, _ = state_at(scene, at, hold, changed, like=mechanism)
            manifold = Manifold(found, axes)
            model = about(manifold, [], outputs)
            roots = np.array([mode.eigenvalue for mode in model.modes()], complex)
            moved = _away(linear.manifold, x, manifold.x)
            return np.concatenate([moved, model.y0, *_matched(first, roots)])

        step = STEP * abs(value) if value else STEP
        column, error = derivative(see, step, tries=2)
        columns.append(column)
        values.append(value)
        worst = max(worst, error)

    named = [coordinate.position for coordinate in linear.manifold.named]
    size = len(named) + len(linear.outputs) + 2 * n
    T = np.array(columns).reshape(len(columns), size).T
    places, shown, real, imag = np.split(T, np.cumsum([len(named), len(linear.outputs), n]))
    roots = real + 1j * imag
    roots[_crowded(first)] = np.nan
    size_ = np.abs(first)[:, None]
    safe = np.where(size_ > 0.0, size_, np.nan)
    # of |lambda| and of -Re lambda / |lambda|
    growing = (first[:, None].conj() * roots).real / safe
    swings = (first.imag > 0.0)[:, None]
    return Sensitivities(
        names=parts,
        values=np.array(values),
        places=dict(zip(named, places)),
        outputs=dict(zip(linear.outputs, shown)),
        eigenvalues=roots,
        frequencies=np.where(swings, growing / (2 * np.pi), 0.0),
        damping=np.where(swings, (-roots.real + first.real[:, None] * growing / safe) / safe, 0.0),
        error=worst,
    )


def _away(manifold, before, x):
    """(n,) from a state to another, along the free coordinates."""
    kept = manifold.x
    manifold.x = before

    try:
        return manifold.away(x)
    finally:
        manifold.x = kept


def _matched(first, roots):
    """(real (n,), imaginary (n,)) parts of roots in the order of the first ones; NaN where there is none."""
    found = np.full(len(first), np.nan, complex)

    if len(roots) and len(first):
        rows, columns = scipy.optimize.linear_sum_assignment(np.abs(first[:, None] - roots[None, :]))
        found[rows] = roots[columns]

    return found.real, found.imag


def _crowded(roots):
    """(n,) whether another root is as good as equal."""
    apart = np.abs(roots[:, None] - roots[None, :]) + np.diag(np.full(len(roots), np.inf))
    return apart.min(axis=1, initial=np.inf) <= ALIKE * np.abs(roots).max(initial=0.0)
