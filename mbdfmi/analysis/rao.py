"""Response amplitude operators: what a scene's outputs do in small regular waves (docs/theory.md 19.4)."""

from dataclasses import dataclass, replace

import numpy as np

from ..scene import SceneData
from ..scene.errors import show
from .linear import Linear, _Look, about
from .manifold import Manifold
from .places import state_at

# m, amplitude of the waves by which loads are found: so small that drag of it is nothing
SMALL = 1e-3

# periods (s), and how many, where nobody asks for others
SHORTEST, LONGEST, USUALLY = 4.0, 30.0, 105

# of a frequency
ROUNDED = 1e-9

# outputs that are told unless others are named
USUAL = ("position", "zyx")


@dataclass(frozen=True)
class Rao:
    """Answers of outputs to waves of amplitude 1 m with their crest at the origin at time 0: Re(answer
    exp(i omega t)).

    omega : (n,) rad/s. outputs : names; units : of them. answers : (n, outputs) complex. direction : rad, the
    way they travel. where : what state it is about.
    """

    omega: np.ndarray
    outputs: list[str]
    units: list[str | None]
    answers: np.ndarray
    direction: float
    where: str
    notices: list[str]


def rao(scene: SceneData, omega=None, direction=0.0, outputs=None, at=None) -> Rao:
    """Response of a scene, linearised about a state, to waves.

    omega : (n,) rad/s; by default those that the files of its bodies know, 4 to 30 s at most. outputs :
        names, an array's name means all its elements; by default positions and angles that the scene asks
        for, else all.
    at : as of `linearise`. Raises ValueError where nothing feels waves, and what `linearise` raises.
    """
    manifold, linear = _linear(_in_small_waves(scene, direction), outputs, at)
    mechanism = manifold.mechanism
    m, d = mechanism.m, mechanism.d

    if not m.n_excitation and not (m.member_station != -1).any():
        deaf = [
            f"[force.{name}] hydrodynamics.excitation is {show(force.hydrodynamics.excitation)}"
            for name, force in scene.force.items()
            if force.kind == "hydrodynamics"
        ]
        found = f"; found {', '.join(deaf)}" if deaf else ""
        raise ValueError(
            f"{scene.name}: nothing in it feels waves, as hydrodynamics with excitation = true or a member "
            f"would{found}"
        )

    known = _known(m)
    omega = _usual(known) if omega is None else np.asarray(omega, float)
    names = {v.name: v for v in mechanism.model.of_causality("output")}
    look = _Look(manifold, np.array([names[name].index for name in linear.outputs], int))
    speeds, n, n_seen = manifold.speeds, len(manifold.free), look.n_rates
    answers = np.empty((len(omega), len(linear.outputs)), complex)
    still = _seen(look, m, d, 0.0, omega[0], 0.0)

    for k, w in enumerate(omega):
        # the real part of exp(i (omega t + phase)) at two phases
        load = [_seen(look, m, d, SMALL, w, turn - w * d.time[0]) - still for turn in (0.0, -np.pi / 2)]
        load = (load[0] + 1j * load[1]) / SMALL
        rates = np.concatenate([np.zeros(linear.n_places), load[:n][speeds], load[n:n_seen]])
        state = np.linalg.solve(1j * w * np.eye(len(linear.A)) - linear.A, rates)
        answers[k] = linear.C @ state + load[n_seen:]

    units = [linear.units[name] for name in linear.outputs]
    notices = linear.notices + _outside(omega, known) + _large(omega, linear.outputs, units, answers)
    return Rao(omega, linear.outputs, units, answers, direction, linear.where, notices)


def _known(m):
    """(least, largest) frequency (rad/s) at which the files of all bodies know the loads of waves."""
    first, count = m.excitation_grid[::4], m.excitation_grid[1::4]
    least = [m.grid_value[k] for k in first]
    return max(least, default=0.0), min(
        (m.grid_value[k + n - 1] for k, n in zip(first, count)), default=np.inf
    )


def _usual(known):
    """Frequencies of periods that are evenly spaced, ascending."""
    longest = min(LONGEST, 2 * np.pi / known[0]) if known[0] > 0.0 else LONGEST
    return 2 * np.pi / np.linspace(longest, max(SHORTEST, 2 * np.pi / known[1]), USUALLY)


def _outside(omega, known):
    """A notice of frequencies that a file does not know."""
    if omega.min() >= known[0] * (1 - ROUNDED) and omega.max() <= known[1] * (1 + ROUNDED):
        return []

    return [
        f"excitation is known for periods from {2 * np.pi / known[1]:.4g} to {2 * np.pi / known[0]:.4g} s; "
        "outside the nearest is taken"
    ]


def _large(omega, outputs, units, answers):
    """A notice of angles of more than a radian a metre: not small, or about a rest that nobody meant."""
    told = []

    for name, unit, answer in zip(outputs, units, np.abs(answers).T):
        k = int(np.argmax(answer))
        if unit == "rad" and answer[k] > 1.0:
            told.append(f"{name} by {np.degrees(answer[k]):.3g} deg at {2 * np.pi / omega[k]:.3g} s")

    if not told:
        return []

    return [
        f"a metre of wave turns {', '.join(told)}: linear answers say little there; does it rest as it "
        "should (mbdfmi equilibrium), or is nothing there that damps?"
    ]


def _in_small_waves(scene, direction):
    """The scene with one regular wave, whose frequency is set later."""
    data = scene.model_dump(exclude_unset=True)
    waves = {"regular": {"height": 2 * SMALL, "period": 10.0}, "direction_deg": float(np.degrees(direction))}
    data["sea"] = (data.get("sea") or {}) | {"waves": waves}
    return type(scene).model_validate(data)


def _linear(scene, outputs, at) -> tuple[Manifold, Linear]:
    """The linear model of the scene without its waves, and the states near where it is."""
    mechanism, where, notices = state_at(scene, at)
    mechanism.m.sea_unit[::4] = 0.0
    mechanism.d.sea_known[:] = 0.0

    if outputs is None:
        every = [v.name for v in mechanism.model.of_causality("output")]
        outputs = [name for name in every if name.partition("[")[0].rpartition(".")[2] in USUAL] or every

    manifold = Manifold(mechanism)
    return manifold, replace(about(manifold, [], outputs, notices, traced=True), where=where)


def _seen(look, m, d, amplitude, omega, phase):
    """Rates and outputs of the state looked at in one wave."""
    look.manifold.put()
    height, period, _, _ = m.sea_value[:4]
    m.sea_unit[:3] = amplitude / height, omega * period, phase
    d.sea_known[:] = 0.0
    return look.here()
