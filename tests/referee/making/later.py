"""What came to the schema later: drawn by dice of its own, so that the scenes of a seed stay what they were."""

import numpy as np

from ..independent.mass import mass_properties
from . import inside, kinds, looks
from .dice import Dice


def add(seed, mechanism, forces, gravity):
    """Rotors to joints of the tree, a torsion spring to the forces, a gradient to central gravity, meshes to solids."""
    dice = Dice(seed, 1)

    for joint in mechanism.joints:
        if joint.kind in kinds.ONE and joint.in_tree and dice.chance(0.12):
            _turn(dice, mechanism, joint)

    if dice.chance(0.25):
        _twist(dice, mechanism, forces)

    if "central_gravity" in gravity and dice.chance(0.9):
        gravity["central_gravity"]["gradient"] = dice.chance(0.6)

    looks.add_solid(Dice(seed, 3), mechanism)


def _turn(dice, mechanism, joint):
    """A rotor that its host can have in it."""
    host = joint.owners[0]
    most = 0.05

    if host in mechanism.body:
        most = 0.5 * np.linalg.eigvalsh(mass_properties(mechanism.body[host])[2])[0]

    if most > 1e-4:
        inertia = round(float(most * dice.rng.uniform(0.1, 1.0)), 6)
        joint.table["turning"] = {"inertia": inertia, "ratio": dice.signed(0.5, 8.0)}


def _twist(dice, mechanism, forces):
    """A torsion spring between two bodies whose z axes are not nearly opposite."""
    owners = ["ground", *mechanism.body]
    pairs = [(a, b) for a in owners for b in mechanism.body if a != b and _swing(mechanism, a, b) < 1.5]

    if pairs:
        options = inside.spring(dice, "revolute", 0.0)
        options |= {"damping": inside.damper(dice)} if dice.chance(0.6) else {}
        forces["the torsion spring"] = {"torsion": options, "between": list(dice.pick(pairs))}


def _swing(mechanism, a, b):
    """rad, between the z axes of two bodies where they are drawn."""
    return np.arccos(np.clip(mechanism.poses[a][1][:, 2] @ mechanism.poses[b][1][:, 2], -1.0, 1.0))
