"""What came to the schema later: drawn by dice of its own, so that the scenes of a seed stay what they were."""

import numpy as np

from ..independent.mass import mass_properties
from . import inside, kinds, led, looks, water
from .dice import Dice


def add(seed, mechanism, forces, gravity):
    """Rotors to joints of the tree, a torsion spring to the forces, a gradient to central gravity, water and wind, surfaces
    to the ground that nothing touches, a word to frames that may not spin, meshes to solids."""
    dice = Dice(seed, 1)

    for joint in mechanism.joints:
        if joint.kind in kinds.ONE and joint.in_tree and dice.chance(0.12):
            _turn(dice, mechanism, joint)

    if dice.chance(0.25):
        _twist(dice, mechanism, forces)

    if "central_gravity" in gravity and dice.chance(0.95):
        gravity["central_gravity"]["gradient"] = dice.chance(0.55)

    if gravity.get("gravity", [0, 0, -9.81])[:2] == [0, 0] and gravity.get("gravity", [0, 0, -9.81])[2] < 0:
        water.fill(Dice(seed, 7), mechanism, forces, gravity)
        water.lay(Dice(seed, 171), forces, gravity.get("sea", {}))
        water.wave(Dice(seed, 11), mechanism, forces, gravity)
        water.stir(Dice(seed, 18), forces, gravity.get("sea", {}))

    if "the radiation" in forces and Dice(seed, 17).chance(0.5):
        forces["the radiation"]["hydrodynamics"]["bodies"] = [1.0]

    if "the radiation" in forces:
        water.feel(Dice(seed, 21), forces["the radiation"], gravity.get("sea", {}))

    water.head(Dice(seed, 23), forces, gravity.get("sea", {}))

    if mechanism.taste["sea"] or Dice(seed, 12).chance(0.07):
        water.blow(Dice(seed, 13), mechanism, forces, gravity)
        water.gust(Dice(seed, 22), gravity["wind"])

    dice = Dice(seed, 6)
    for marker in mechanism.ground_marker.values():
        if "surface" not in marker and dice.chance(0.04):
            marker["surface"] = dice.pick(
                [{"disk": {"radius": 0.2}}, {"ellipsoid": {"semi_axes": [0.3, 0.2, 0.1]}}]
            )

    dice = Dice(seed, 9)
    for joint in mechanism.joints:
        options = joint.table.get(joint.kind)
        if joint.kind.startswith("frame_on") and "spin" not in options and dice.chance(0.9):
            options["spin"] = "held"

    looks.add_solid(Dice(seed, 3), mechanism)


def begin(seed) -> dict:
    """Maybe how it starts. A run of the compiled scene starts as given in any case: what is asked for there is not."""
    dice = Dice(seed, 8)
    return {"start": dice.pick(["given", "equilibrium"])} if dice.chance(0.1) else {}


def trim(seed, data) -> dict:
    """Maybe what it is trimmed to, which a run that starts as given passes over as well."""
    dice = Dice(seed, 10)
    joints = list(data["joint"])

    if not joints or not dice.chance(0.1):
        return {}

    names = [f"{name}.position" for name in joints[: dice.whole(1, 3)]]
    rest = dice.chance(0.3)
    found = {"find": dice.pick([names, dict.fromkeys(names, dice.number(0.1, 1.0))])}
    found |= {"rest": True} if rest else {"rest": False, "steady": dice.pick([True, joints[:1]])}
    return {"trim": found | ({"keep": {f"{joints[-1]}.speed": 0.0}} if rest or dice.chance(0.5) else {})}


def lead(seed, mechanism, least):
    """Maybe a body that moves as prescribed, where there is room for others."""
    dice = Dice(seed, 4)

    if mechanism.taste["size"] > 1 and (least or dice.chance(0.07)):
        _by(dice, mechanism, lambda: mechanism.add_body(led.prescribed(dice)))


def close(seed, mechanism, least):
    """Maybe a loop by surfaces that touch, or along a curve with a driver; at least so many."""
    dice = Dice(seed, 5)

    for _ in range(max(least, dice.chance(0.25))):
        _by(dice, mechanism, lambda: mechanism.close(led.CLOSING, led.draw))


def _by(dice, mechanism, do):
    """Does something with a mechanism by other dice than its own."""
    own, mechanism.dice = mechanism.dice, dice
    do()
    mechanism.dice = own


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
