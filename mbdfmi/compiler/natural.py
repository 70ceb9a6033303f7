"""How a floating scene swings by itself: where the damping of its memories of waves counts most (docs/theory.md 16.16)."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..kernels import entry
from ..kernels.dynamics import inertia, rates
from ..kernels.motion import markers
from ..kernels.status import OK
from ..lazily import scipy

if TYPE_CHECKING:
    from ..hydro.database import Coefficients
    from ..hydro.memory import Memory

# of a displacement, m or rad or what else coordinates are
STEP = 1e-4

# damping ratios below which a motion does not decay
LEAST_DECAY = 1e-4

# digits of what is asked of a fit, that it does not hang on rounding
DIGITS = 4


class Fitted(NamedTuple):
    """The memory of a force, what it was fitted to, and the markers of its bodies."""

    markers: list
    coefficients: "Coefficients"
    memory: "Memory"


class Swings:
    """What the memories of a scene are to meet at its natural frequencies: found on its spanning tree, the same for all formulations.

    near : force -> ((omega rad/s, motion (6 N,)), ...), of those whose first fit missed it; None while that is not known.
    """

    def __init__(self):
        self.near = None
        self._again = False
        self._missed = {}

    def find(self, builder, model) -> bool:
        """Whether there is a memory that is to be fitted again; from now on it is known."""
        missed = _missed(builder, model)
        self.near = {name: near for name, (near, _) in missed.items()}
        self._again = bool(missed)
        return self._again

    def tell(self, builder, model):
        """Notices of damping that the second fit does not meet either."""
        if self._again:
            self._missed, self._again = _missed(builder, model), False

        for name, (_, (part, omega)) in self._missed.items():
            text = (
                f"the memory misses {100 * part:.2g} % of the damping at {2 * np.pi / omega:.4g} s, a period at which the scene swings by "
                "itself; no fit with as many states as it may have comes nearer"
            )
            builder.notice(("force", name, "hydrodynamics", "radiation"), text)


def shares_water(scene) -> bool:
    """Whether bodies move each other's water: then dynamics are by the joint-space mass matrix."""
    return any(f.kind == "hydrodynamics" and len(f.between) > 1 for f in scene.force.values())


def swings_of(scene, compile_with) -> Swings:
    """What is to be met by a scene that is not compiled on its spanning tree; compile_with : does that."""
    swings = Swings()

    if any(force.kind == "hydrodynamics" and force.hydrodynamics.radiation for force in scene.force.values()):
        compile_with(swings)

    return swings


def _missed(builder, model):
    """Of each force whose memory misses damping at a natural frequency by more than NEAR of its own value: all those, as
    ((omega rad/s, motion (6 N,)), ...), and the most that is missed, with its omega.
    """
    if not builder.fitted:
        return {}

    from ..hydro.memory import NEAR

    modes = _modes(model)
    found = {}

    for name, fitted in builder.fitted.items():
        near, worst = [], (0.0, 0.0)

        for mode in modes:
            motion = mode.motion_of(fitted.markers)
            told = _at_its_own(fitted, mode.square, mode.energy, motion)

            if told:
                near.append((told[0], tuple(_rounded(motion / np.abs(motion).max()).tolist())))
                worst = max(worst, told[::-1])

        if worst[0] > NEAR:
            found[name] = tuple(near), worst

    return found


class _Mode(NamedTuple):
    """A free swing: square of its frequency, kinetic energy (J) at velocities v (n_v,), views of the model."""

    square: float
    energy: float
    v: np.ndarray
    views: tuple

    def motion_of(self, marks):
        """(6 N,): velocities and angular velocities of markers."""
        m, d = self.views
        d.v[:] = self.v
        rates.evaluate(m, d, 0.0)
        return np.concatenate(
            [(*markers.velocity(m, d, k), *markers.angular_velocity(m, d, k)) for k in marks]
        )


def _at_its_own(fitted, square, energy, motion):
    """(omega rad/s with the added mass there, part of the damping that is missed there); None where nothing is to be met.

    square : of the frequency with added mass at infinite frequency. energy : J, kinetic, of that motion (6 N,).
    """
    data, memory = fitted.coefficients, fitted.memory
    added = motion @ (data.added - memory.infinite) @ motion
    omega = np.sqrt(square)

    for _ in range(20):
        omega = np.sqrt(square * energy / max(energy + np.interp(omega, data.omega, added) / 2, 0.1 * energy))

    omega = float(_rounded(omega))

    if not data.omega[0] <= omega <= data.omega[-1]:
        return None

    taken = motion @ data.damping @ motion
    wanted = float(scipy.interpolate.PchipInterpolator(data.omega, taken)(omega))

    if wanted < 4.0 * LEAST_DECAY * energy * omega:
        return None

    return omega, abs(motion @ memory.response([omega])[0].real @ motion / wanted - 1.0)


def _modes(model):
    """[_Mode] about the start, at rest; [] where that cannot be evaluated."""
    m, d = model.views()

    if entry.prepare(m, d) != OK or entry.initialise(m, d, 0.0) != OK:
        return []

    q, n = d.q.copy(), m.n_v
    pull = np.zeros((n, n))

    for k in range(n):
        d.q[:], d.v[:] = q, 0.0
        d.v[k] = 1.0

        if rates.evaluate(m, d, 0.0) != OK:
            return []

        way = d.q_rate.copy()
        d.v[:] = 0.0

        for side in (1.0, -1.0):
            d.q[:] = q + side * STEP * way

            if rates.evaluate(m, d, 0.0) != OK:
                return []

            pull[:, k] += side * d.v_rate / (2.0 * STEP)

    d.q[:] = q

    if not np.isfinite(pull).all():
        return []

    squares, shapes = np.linalg.eig(-pull)
    found = []

    for square, shape in zip(squares, shapes.T):
        if square.real > 0.0 and abs(square.imag) < 1e-6 * square.real:
            v = shape.real / np.abs(shape.real).max()
            d.v[:] = v
            rates.evaluate(m, d, 0.0)
            found.append(_Mode(float(square.real), inertia.kinetic_energy(m, d), v, (m, d)))

    return found


def _rounded(values):
    """To so many digits that nothing hangs on rounding."""
    return np.array([float(f"{value:.{DIGITS}g}") for value in np.ravel(values)]).reshape(np.shape(values))
