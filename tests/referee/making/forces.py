"""Forces between bodies, on one, and of water."""

import numpy as np

from . import frames, inside, motions

KINDS = {"spring_damper": 2, "linear": 2, "bushing": 1.3, "load": 1.6}
WRENCH = ("force", "moment", "displacement", "rotation", "power")


def force(dice, mechanism, kind, taste) -> dict:
    """A force of a kind at random ends."""
    owners = list(mechanism.body) + ["ground"] + (["inertial"] if dice.chance(0.2) else [])

    if kind == "load":
        return {"load": _load(dice), "on": _end(dice, mechanism, dice.pick(mechanism.body))}

    if kind == "linear":
        options = _linear(dice, taste)
        if "added_mass" in options:
            pair = [dice.weighted({"ground": 3, "inertial": 1}), dice.pick(mechanism.body)]
            return {"linear": options, "between": [_end(dice, mechanism, owner) for owner in pair]}
        return {"linear": options, "between": _pair(dice, mechanism, owners)}

    if kind == "bushing":
        return {"bushing": _bushing(dice), "between": _pair(dice, mechanism, owners)}

    return _strut(dice, mechanism, owners, taste)


def _end(dice, mechanism, owner, pose=None):
    keys = pose or (frames.place(dice, 0.5)[0] if dice.chance(0.75) else {})

    if owner == "ground" and mechanism.site.any():
        at = np.array(keys.get("position", [0.0, 0.0, 0.0])) + mechanism.site
        keys = keys | {"position": at.tolist()}

    return mechanism.end(owner, keys)


def _pair(dice, mechanism, owners):
    a, b = dice.some(owners, 2)[:2]
    if a in ("ground", "inertial") and b in ("ground", "inertial"):
        b = dice.pick(mechanism.body)
    return [_end(dice, mechanism, owner) for owner in (a, b)]


def _strut(dice, mechanism, owners, taste):
    options = {}

    if dice.chance(0.4):
        lengths, forces = inside.graph(dice, 0.1, 3.0, dice.number(0.5, 5.0), dice.number(0.5, 1.5))
        options["table"] = {"length": lengths, "force": forces} | inside.reading(dice)
    else:
        options["stiffness"] = dice.number(0.5, 10.0) if dice.chance(0.93) else dice.pick([0.0, 300.0])
        if dice.chance(0.6):
            options["rest_length"] = dice.number(0.2, 1.5)

    if dice.chance(0.7):
        options["damping"] = inside.damper(dice, "force")

    # ends well apart, since at length 0 a strut has no direction
    a, b = dice.some(owners, 2)[:2]
    if a in ("ground", "inertial") and b in ("ground", "inertial"):
        a = dice.pick(mechanism.body)
    arm = frames.unit(dice.vector(1.0)) * dice.number(0.5, 1.0)
    first, second = (
        _end(dice, mechanism, a, {"position": arm.tolist()} if a != "inertial" else {}),
        _end(dice, mechanism, b),
    )
    table = {"spring_damper": options, "between": [first, second]}

    if dice.chance(taste["input"]):
        table["input"] = "force" if dice.chance(0.5) else ["force"]

    return table


def _definite(dice, diagonal, couplings=0.2):
    """(6, 6) symmetric, positive definite, with about such a diagonal."""
    L = np.eye(6) + couplings * dice.rng.normal(size=(6, 6))
    scale = np.sqrt(np.array(diagonal))
    M = (scale[:, None] * (L @ L.T) * scale).round(4)
    return ((M + M.T) / 2).tolist()


def _diagonal(dice, force, moment):
    return [*dice.numbers(3, 0.2 * force, force), *dice.numbers(3, 0.2 * moment, moment)]


def _linear(dice, taste):
    options = {}

    if dice.chance(taste["added mass"]):
        options["added_mass"] = _definite(dice, _diagonal(dice, 3.0, 0.3))
    if dice.chance(0.5):
        options["stiffness"] = _definite(dice, _diagonal(dice, 6.0, 2.0))
    if dice.chance(0.5):
        options["damping"] = _definite(dice, _diagonal(dice, 0.8, 0.2))
    if dice.chance(0.4) or not options:
        options["preload"] = [*dice.vector(1.0), *dice.vector(0.2)]
    if dice.chance(0.75):
        options["axes"] = dice.pick(["first", "heading", "body"])

    return options


def _bushing(dice):
    options = {}

    for key in dice.some(("stiffness", "damping"), 1):
        diagonal = _diagonal(dice, *((8.0, 2.0) if key == "stiffness" else (0.8, 0.2)))
        options[key] = diagonal if dice.chance(0.5) else _definite(dice, diagonal)

    return options


def _load(dice):
    axes = {"axes": dice.pick(["inertial", "body"])} if dice.chance(0.7) else {}

    if dice.chance(0.55):
        return {"table": motions.load_over_time(dice)} | axes

    return {
        key: dice.vector(3.0 if key == "force" else 0.5) for key in dice.some(("force", "moment"), 1)
    } | axes
