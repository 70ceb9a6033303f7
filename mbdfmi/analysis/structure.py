"""What a scene's joints leave free, in words: true degrees of freedom by rank, equations that repeat others,
reactions that are not determined.
"""

from dataclasses import dataclass

import numpy as np

from ..compiler.joint_kinds import kind_of
from ..kernels.dynamics import rows
from .mechanism import ZERO, Mechanism
from .stress import stresses


@dataclass(frozen=True)
class Equation:
    """A constraint equation: the joint or coupling it belongs to, and what it keeps, in words
    (inertial axes).
    """

    owner: str
    keeps: str


@dataclass(frozen=True)
class Reaction:
    """What of a joint's reaction is not determined, in words (inertial axes)."""

    owner: str
    what: str


@dataclass(frozen=True)
class Structure:
    """What the joints of a scene leave free.

    coordinates : velocity coordinates of the tree's joints, without the driven ones.
    equations, rank : constraint equations of what closes loops, rolls or couples; how many are
    independent.
    freedom : degrees of freedom, coordinates less rank.
    freedom_at_start : the same at the start alone; more than `freedom` at a singular position.
    driven : joints whose motion is prescribed.
    closing : joints that close loops: they are not in the tree.
    driveable : joints any one of which takes a freedom away when it is driven.
    redundant : equations that follow from others in every position, those that the solver leaves
    out.
    undetermined : reactions that rigid bodies do not determine.
    """

    coordinates: int
    equations: int
    rank: int
    freedom_at_start: int
    driven: list[str]
    closing: list[str]
    driveable: list[str]
    redundant: list[Equation]
    undetermined: list[Reaction]

    @property
    def freedom(self) -> int:
        """Degrees of freedom: independent velocities."""
        return self.coordinates - self.rank


def structure(scene) -> Structure:
    """The structure of a scene at its start.

    Raises SceneError; SimulationError where a loop cannot be closed.
    """
    mechanism = Mechanism(_with_all_joints(scene))
    here, generic = mechanism.here(), mechanism.generic()
    model = mechanism.model

    return Structure(
        coordinates=len(mechanism.free),
        equations=model.n_row,
        rank=generic.rank,
        freedom_at_start=len(mechanism.free) - here.rank,
        driven=[name for name, joint in scene.joint.items() if joint.driver],
        closing=[name for name in model.tree.cuts if kind_of(scene.joint[name]).in_trees],
        driveable=mechanism.driveable(generic),
        redundant=[_equation(mechanism, row, here) for row in mechanism.redundant],
        undetermined=_undetermined(mechanism, generic),
    )


def _with_all_joints(scene):
    """The scene with fixed joints that are not welds, for then they have equations and reactions.

    Bodies that only welds made solid (lines, points, mere frames) then need inertia of their own; ranks do
    not depend on it, nor on rotors, which would keep their joints in the tree.
    """
    kept = {}

    for name, joint in scene.joint.items():
        changed: dict = {"turning": None} if getattr(joint, "turning", None) else {}

        if joint.kind == "fixed" and not joint.output:
            changed["output"] = ["reaction_force"]

        kept[name] = joint.model_copy(update=changed)

    solver = scene.solver.model_copy(update={"formulation": "recursive"})
    bodies = {name: _with_inertia(body) for name, body in scene.body.items()}
    return scene.model_copy(update={"body": bodies, "joint": kept, "solver": solver})


def _with_inertia(body):
    """The body itself, or if it has no inertia about some axis, one that has."""
    mass, com, inertia = body.mass_properties()
    moments = np.linalg.eigvalsh(inertia)

    if mass > 0.0 and moments[0] > ZERO * moments[-1]:
        return body

    arms = [com, *(marker.pose()[0] for marker in body.marker.values())]
    length = max(np.linalg.norm(arm) for arm in arms) or 1.0
    mass = mass or 1.0
    inertia = inertia + mass * length**2 * np.eye(3)
    properties = {"mass": mass, "com": tuple(com), "inertia": inertia.tolist()}
    return body.model_copy(update=properties | {"inertia_axes": None, "solid": None})


def _equation(mechanism, row, place) -> Equation:
    """A row in words."""
    owner = mechanism.owner(row)

    if mechanism.m.row_kind[row] == rows.COUPLING:
        keeps = "prescribed motion" if mechanism.m.row_drive[row] >= 0 else "coupled motion"
        return Equation(owner, keeps)

    force, moment = place.loads.force[row], place.loads.moment[row]

    if mechanism.m.row_kind[row] in (rows.DOT, rows.TWIST, rows.FRAME):
        return Equation(owner, f"rotation {_along('about', moment[:, None])}")

    rolling = mechanism.m.row_kind[row] in (rows.KNIFE, rows.SLIP, rows.ROLL_SPHERE, rows.ROLL_DISK)
    what = "velocity" if rolling else "position"
    return Equation(owner, f"{what} {_along('along', force[:, None])}")


def _undetermined(mechanism, place) -> list[Reaction]:
    """Reactions that a self-stress touches at a place."""
    found = []

    for owner, stress in stresses(mechanism, place).items():
        parts = []

        for what, how, vectors in (
            ("force", "along", stress.force),
            ("moment", "about", stress.moment / mechanism.length),
        ):
            if np.linalg.norm(vectors) * mechanism.length > 10 * ZERO:
                parts.append(f"{what} {_along(how, vectors)}".strip())

        if np.linalg.norm(stress.coupling) > 10 * ZERO:
            parts.append("coupling effort")

        if np.linalg.norm(stress.driving) > 10 * ZERO:
            parts.append("driving effort")

        if parts:
            found.append(Reaction(owner, ", ".join(parts)))

    return found


def _along(how, vectors):
    """The directions that vectors (3, k) span, in words: "along z", "about x and y", "normal to
    ..."; all: "".
    """
    U, s, _ = np.linalg.svd(vectors, full_matrices=False)
    rank = int(np.sum(s > 1e-4 * s[0]))

    if rank == 3:
        return ""

    projector = U[:, :rank] @ U[:, :rank].T
    named = [axis for k, axis in enumerate("xyz") if projector[k, k] > 1.0 - 1e-6]

    if len(named) == rank:
        return f"{how} {' and '.join(named)}"

    direction = U[:, 0] if rank == 1 else np.cross(U[:, 0], U[:, 1])
    direction = direction * np.sign(direction[np.argmax(np.round(np.abs(direction), 6))])
    text = "({:.3g}, {:.3g}, {:.3g})".format(*np.where(np.abs(direction) < 1e-6, 0.0, direction))
    return f"{how} {text}" if rank == 1 else f"normal to {text}"
