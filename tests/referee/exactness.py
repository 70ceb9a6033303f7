"""How exact the runs of a scene can be at best: what loops leave open, what rounding does,
until when a motion is determined, and which outputs are."""

import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from mbdfmi.run.instance import SimulationError
from mbdfmi.scene import SceneError, fmi_name

from .compare import groups
from .plan import order_of, pieces

EPS = 4e-16

# rad, of a swing by half a turn, which has no direction
NEAR_HALF = 1e-3

PARTS = ("body", "joint", "coupling", "force", "measure")


@dataclass(frozen=True)
class Exactness:
    """What can be asked of the runs of a scene.

    start : m and rad, to which loops close. carried : part of a command that rounding may take.
    lightest : kg and kg m2, the least mass and moment of inertia of a body, zeros left out.
    until : s, up to which the motion is determined. undetermined : groups of outputs that are not.
    shared : names that several parts have, in FMI's spelling.
    """

    start: float = 0.0
    carried: float = 0.0
    lightest: tuple[float, float] = (np.inf, np.inf)
    until: float = np.inf
    undetermined: frozenset[str] = frozenset()
    shared: frozenset[str] = frozenset()


def of(data, scene, model, plan, reference):
    """The `Exactness` of a scene (a dict, and as a `Scene`) whose reference run is given."""
    return Exactness(
        _start(data, model, reference),
        _carried(plan, reference),
        _lightest(scene),
        _until(data, reference),
        frozenset(undetermined(scene)),
        _shared(data),
    )


def _start(data, model, reference):
    """Loops close to their tolerance, or not quite."""
    gaps = [
        float(size)
        for text in reference.notices
        for size in re.findall(r"does not quite close.* stay (\S+) m", text)
    ]
    turns = [float(size) for text in reference.notices for size in re.findall(r"turned by (\S+) rad", text)]
    closes = data.get("solver", {}).get("closing_tolerance", 1e-9) if model.n_row else 0.0
    return max([closes, *gaps, *turns]) if gaps else closes


def _carried(plan, reference):
    """What is not told of a command's course comes from the last commands.

    Over short steps h their second difference is rounding over h^2, which a long step H takes along H^2.
    """
    if not any(order_of(name) is not None for name in plan.signals):
        return 0.0

    steps = [step for interval in pieces(plan, reference.way.pattern) for step in interval]
    return EPS * (max(steps) / min(steps)) ** 2


def _lightest(scene):
    properties = [body.mass_properties() for body in scene.body.values()]
    masses = [mass for mass, _, _ in properties]
    moments = [moment for _, _, inertia in properties for moment in np.linalg.eigvalsh(inertia)]
    return tuple(
        min((size for size in sizes if size > 1e-9 * max(sizes)), default=np.inf)
        for sizes in (masses, moments)
    )


def _until(data, reference):
    """The first time at which a linear force or a bushing is about half a turn off, so that its rotation has no direction."""
    columns = groups(reference.names)
    times = [np.inf]

    for name, force in data.get("force", {}).items():
        if "linear" in force or "bushing" in force:
            swings = np.array(reference.values)[:, columns[f"{fmi_name(name)}.rotation"][:2]]
            near = np.hypot(*swings.T) > np.pi - NEAR_HALF
            times += [reference.times[k] for k in np.flatnonzero(near)[:1]]

    return min(times)


def undetermined(scene):
    """Groups of outputs that rigid bodies do not determine: reactions,
    efforts and powers of joints that share a load."""
    from mbdfmi.analysis.structure import structure

    try:
        owners = {reaction.owner for reaction in structure(scene).undetermined}
    except (SceneError, SimulationError):
        return set()

    endings = (
        "reaction_force", "reaction_moment", "reaction_force_body", "reaction_moment_body", "effort",
        "driver_effort", "power",
    )  # fmt: skip
    return {f"{fmi_name(owner)}.{ending}" for owner in owners for ending in (*endings, "efforts")}


def _shared(data):
    names = Counter(fmi_name(name) for part in PARTS for name in data.get(part, {}))
    return frozenset(name for name, n in names.items() if n > 1)
