"""Mass, centre of mass and inertia of bodies, in all ways of writing them."""

import numpy as np

from . import frames

OUTPUTS = (
    "position", "velocity", "acceleration", "euler_parameters", "zyx", "zyx_rate", "omega", "alpha",
    "velocity_body", "acceleration_body", "omega_body", "alpha_body",
)  # fmt: skip
SORTS = {"inertia": 4, "solid": 4, "symmetric": 1, "point": 0.6, "massless": 0.6, "rod": 0.4}


def body(dice, sorts=SORTS, axis=None) -> dict:
    """The mass properties of a random body. axis (3,): it is of revolution about that, through its origin."""
    if axis is not None:
        return _wheel(dice, axis)

    sort = dice.weighted(sorts)

    if sort == "massless":
        return {"mass": 0.0}

    if sort == "solid":
        return _solids(dice)

    table = {"mass": dice.number(0.3, 3.0)}

    if dice.chance(0.8):
        table["com"] = dice.vector(0.4)

    if sort == "point":
        if dice.chance(0.5):
            return table | {"inertia": [0.0, 0.0, 0.0]}
        return {"solid": {"point": {"mass": table["mass"]}, "position": dice.vector(0.4)}}

    if sort == "rod":
        moments = [0.1, 0.1, 0.0]
        dice.rng.shuffle(moments)
        return table | {"inertia": moments}

    a, b, c = dice.numbers(3, 0.02, 0.4)
    moments = [a, a, min(b, 2 * a)] if sort == "symmetric" else [a + b, a + c, b + c]
    moments = [round(m, 4) for m in moments]

    if dice.chance(0.2) and sort == "inertia":
        # a tensor of a real body in other axes, by its six values or as a matrix
        _, A = frames.orientation(dice)
        I = (A @ np.diag(moments) @ A.T).round(5)
        I = (I + I.T) / 2
        six = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
        table["inertia"] = [float(x) for x in six] if dice.chance(0.5) else I.tolist()
    else:
        table["inertia"] = moments

    if dice.chance(0.4):
        table["inertia_axes"] = frames.orientation(dice)[0] if dice.chance(0.95) else {}

    return table


def _wheel(dice, axis):
    """A body of revolution about an axis through its origin."""
    mass, across, along = dice.number(0.5, 3.0), dice.number(0.05, 0.2), dice.number(0.02, 0.1)
    I = across * np.eye(3) + (along - across) * np.outer(axis, axis)
    return {"mass": mass, "inertia": I.tolist()}


def _solids(dice):
    solids = [_solid(dice) for _ in range(dice.weighted({1: 3, 2: 1, 3: 0.5}))]
    return {"solid": solids if len(solids) > 1 or dice.chance(0.15) else solids[0]}


def _solid(dice):
    kind = dice.weighted({"sphere": 1, "box": 1, "cylinder": 1.2, "tube": 1.2, "point": 1})
    heavy = (
        {"mass": dice.number(0.3, 2.0)}
        if kind == "point" or dice.chance(0.5)
        else {"density": float(dice.whole(50, 900))}
    )
    radius, length = dice.number(0.06, 0.2), dice.number(0.2, 1.0)
    shape = {
        "sphere": {"radius": radius},
        "box": {"size": dice.numbers(3, 0.1, 0.4)},
        "cylinder": {"radius": radius, "length": length},
        "tube": {
            "radius": radius,
            "inner_radius": 0.0 if dice.chance(0.1) else round(0.6 * radius, 4),
            "length": length,
        },
        "point": {},
    }[kind]
    solid = {kind: shape | heavy} | frames.place(dice, 0.4)[0]

    if kind in ("cylinder", "tube") and dice.chance(0.6):
        solid["axis"] = frames.axis(dice)[0]

    return solid
