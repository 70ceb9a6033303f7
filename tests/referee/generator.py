"""Random scenes over the whole schema: `draw(seed)` gives one as `tomllib` would.

Kinds of joints, loops, couplings, drivers, forces, ground motions and starts are drawn each for itself, so
that all combine. A mechanism grows as a tree at a start of its own; loops, contacts and couplings are then
put where they fit there, and only if they leave something that moves. Speeds are drawn among those that all
of these allow. What of that start is written is another draw: all, where alone, parts, nothing, or not quite
right.
"""

import math

import numpy as np

from mbdfmi import Scene, SceneError

from .making import forces, frames, kinds, later, looks, motions, names, telling, water
from .making.bodies import SORTS
from .making.dice import Dice
from .making.mechanism import Mechanism

TREE = {
    "revolute": 6, "prismatic": 6, "spherical": 2.2, "free": 1.5, "cylindrical": 1.2, "universal": 3.5,
    "planar": 1.5, "translation": 2, "screw": 2.6, "fixed": 1,
}  # fmt: skip
LOOPS = {
    "revolute": 2.5, "prismatic": 2, "spherical": 1.2, "cylindrical": 1.2, "universal": 1.2, "planar": 1.2,
    "translation": 1, "screw": 1.2, "fixed": 0.8, "free": 0.3, "point_on_plane": 1, "point_on_line": 1,
    "distance": 1.2, "rolling_sphere": 1, "rolling_disk": 1.8, "knife_edge": 1, "point_on_curve": 2,
    "constant_velocity": 1, "angle": 1,
    "curve_on_curve": 2.3, "point_on_surface": 3.8, "frame_on_curve": 1.5, "frame_on_surface": 2.3,
}  # fmt: skip
# kinds of trees: what they are mostly of
FAMILIES = {
    "all": (3, TREE),
    "slides": (0, {"revolute": 5, "prismatic": 9}),
    "hinges": (3, {"revolute": 5, "prismatic": 7}),
    "turned": (
        0,
        {"spherical": 3, "universal": 5, "screw": 2, "fixed": 1, "cylindrical": 1, "revolute": 1, "free": 1},
    ),
    "loose": (2, {"free": 4, "spherical": 1, "planar": 1, "translation": 1, "cylindrical": 1, "revolute": 1}),
}

# how starts are written, and how far joints then are from their zero positions
STARTS = {"fit": 5, "places": 1.5, "part": 5, "none": 1, "off": 1, "contradicting": 0.3}
RANGES = {"part": (1.0, 0.2, 0.0), "none": (0.0, 0.05)}

# loops that find their place less often than others
SELDOM = {
    "constant_velocity": 20.0,
    "frame_on_curve": 3.0,
    "frame_on_surface": 6.0,
    "curve_on_curve": 2.5,
    "rolling_sphere": 2.0,
}

# small scenes rich in one feature each
FOCUS = {
    "couplings": {
        "size": 5,
        "couplings": (3, 4),
        "wheel": 0.6,
        "loops": (0, 0),
        "fast": 0.7,
        "family": "hinges",
        "offset": 1.0,
        "outputs": {"all": 1},
    },
    "turns": {"size": 4, "family": "hinges", "couplings": (1, 3), "wheel": 0.8, "fast": 1.0, "loops": (0, 1)},
    "tables": {
        "spring": 0.5,
        "damper": 0.5,
        "size": 6,
        "driver": 0.95,
        "family": "slides",
        "forces": (1, 3),
        "drivers": {"table": 1.5, "speed_table": 1.2},
    },
    "starts": {
        "size": 4,
        "family": "turned",
        "loops": (1, 2),
        "couplings": (0, 2),
        "starts": STARTS | {"fit": 1, "off": 3, "part": 6},
    },
    "between steps": {"stop": 0.7, "damper": 0.7, "friction": 0.3, "planar": 0.3},
    "loops": {"loops": (1, 3), "planar": 0.5, "off axis": 0.4},
    "contacts": {
        "size": 3,
        "loops": (1, 3),
        "cuts": dict.fromkeys(kinds.CONSTRAINTS, 1.0) | SELDOM,
        "family": "loose",
        "outputs": {"all": 1},
    },
    "commands": {
        "size": 3,
        "family": "hinges",
        "driver": 0.6,
        "drivers": {"input": 1},
        "ground": 0.6,
        "grounds": {"input": 3, "table": 1},
    },
    "drivers": {
        "size": 5,
        "driver": 0.95,
        "family": "slides",
        "drivers": motions.WAYS
        | {
            "hold": 3.5,
            "constant_speed": 9.0,
            "input": 3,
            "harmonic": 3.2,
            "harmonics": 2.6,
            "polynomial": 1.8,
            "ramp": 2.2,
        },
    },
    "friction": {"friction": 0.8, "central": 0.9},
    "massless": {"bodies": {"massless": 3, "point": 2, "rod": 2, "inertia": 3}, "loops": (0, 2)},
    "added mass": {"family": "loose", "forces": (1, 3), "force kinds": {"linear": 1}, "added mass": 0.9},
    "outputs": {
        "family": "turned",
        "central": 0.9,
        "outputs": {"all": 1},
        "forces": (1, 3),
        "measures": (1, 2),
        "loops": (0, 1),
    },
    "ground": {
        "ground": 1.0,
        "grounds": motions.GROUND | {"orbit": 2.4},
        "forces": (0, 2),
        "central": 0.95,
    },
    "sea": {"sea": 1, "family": "loose", "loops": (0, 1), "outputs": {"all": 1, "some": 1}},
    "led": {"led": 1, "family": "loose", "loops": (0, 0), "couplings": (0, 1)},
}

LONG_RUN = {None: range(1, 501)} | {
    focus: range(1001 + 100 * k, 1001 + 100 * k + -(-1500 // len(FOCUS)))
    for k, focus in enumerate(sorted(FOCUS))
}
"""The seeds of each focus, and of none, in a run of two thousand: dice of a seed fall alike in every focus."""


def draw(seed: int, size: int | None = None, focus: str | None = None, start: str | None = None) -> dict:
    """The scene of a seed.

    size : number of bodies, else 1 to 30. focus : one of FOCUS, for a small scene rich in that. start : one
    of STARTS; where it is "fit" or "places", all that is written of the start can be kept (but for chains
    drawn not quite to close, to 1e-4).
    """
    for attempt in range(100):
        dice = Dice(seed, attempt)
        taste = _taste(dice, size, focus, start)
        data = _scene(dice, taste, seed)

        if data is not None:
            return data

    raise AssertionError(f"no scene came of seed {seed}")


def time_scale(data: dict) -> float:
    """s, about how long a motion of the scene takes: 1, or less where it turns fast or springs are stiff."""
    rates = [1.0]

    for joint in data.get("joint", {}).values():
        for part in (joint.get("start", {}), joint.get("driver", {})):
            for key, value in part.items():
                factor = (
                    math.pi / 180 if key.endswith("_deg") else math.pi / 30 if key.endswith("_rpm") else 1.0
                )
                if "speed" in key and isinstance(value, float):
                    rates.append(abs(value) * factor / 3)
        stiff = [joint.get(part, {}).get("stiffness", 0.0) for part in ("spring", "stop")]
        rates += [math.sqrt(k) / 3 for k in stiff]

    return 1.0 / max(rates)


def _taste(dice, size, focus, start):
    """What a scene is to be like."""
    n = size or (dice.whole(2, 5) if focus else dice.weighted(_sizes()))
    starts = start or dice.weighted(FOCUS.get(focus, {}).get("starts", STARTS))
    loops = dice.weighted({0: 2, 1: 3, 2: 2, 3: 1})
    couplings = dice.weighted({0: 4, 1: 3, 2: 2, 4: 0.7})
    weights = {name: weight for name, (weight, _) in FAMILIES.items()}
    weights["loose"] *= 3 if loops else 1
    weights["hinges"] *= 3 if couplings else 1
    family = FOCUS.get(focus, {}).get("family") or dice.weighted(weights)
    taste = {
        "size": n,
        "tree": FAMILIES[family][1],
        "cuts": LOOPS,
        "bodies": SORTS,
        "start": starts,
        "range": RANGES.get(starts, (1.0,)),
        "branching": dice.pick([0.0, 0.5, 1.0]),
        "planar": dice.pick([0.0, 0.0, 0.0, 0.25]),
        "wheel": dice.pick([0.0, 0.1, 0.4]),
        "fast": 0.3,
        "off axis": 0.1,
        "loops": (loops, loops),
        "couplings": (couplings, couplings),
        "offset": 0.5,
        "misfit": 0.5 if starts in ("off", "contradicting") else 0.0,
        "driver": dice.pick([0.0, 0.4, 0.7]),
        "drivers": motions.WAYS,
        "spring": 0.3,
        "damper": 0.3,
        "friction": 0.12,
        "stop": 0.2,
        "input": dice.pick([0.0, 0.2, 0.5]),
        "forces": (0, 1 + n // 3),
        "force kinds": forces.KINDS,
        "added mass": 0.4,
        "ground": 0.4,
        "grounds": motions.GROUND,
        "measures": (0, dice.pick([0, 1, 2])),
        "central": 0.05,
        "outputs": {"all": 2, "some": 3, "few": 2},
        "led": 0,
        "sea": 0,
    }
    return taste | {key: value for key, value in FOCUS.get(focus, {}).items() if key in taste}


def _sizes():
    """Weights of 1 to 30 bodies: mostly up to 5."""
    return {n: 1.0 if n <= 5 else 0.12 * math.exp(-(n - 5) / 10) for n in range(1, 31)}


def _scene(dice, taste, seed):
    """A valid scene, or None where chance led to none."""
    gravity = _gravity(dice, taste)
    far = dice.number(5.0, 8.0) if "central_gravity" in gravity else 0.0
    motion, pose = None, frames.HERE

    if dice.chance(taste["ground"]):
        if far:
            grounds = {"acceleration": 1, "orbit": 1, "table": 1}
            motion, pose = motions.ground(dice, grounds, far)
        else:
            motion, pose = motions.ground(dice, taste["grounds"])

    site = (far, 0.0, 0.0) if far and motion is None else (0.0, 0.0, 0.0)
    mechanism = Mechanism(dice, taste, pose, site, centre_free=not far, ground_moves=motion is not None)

    later.lead(seed, mechanism, taste["led"] and dice.chance(0.5))

    while len(mechanism.body) < taste["size"]:
        mechanism.grow()

    if not mechanism.n:
        return None

    mechanism.rows = np.zeros((0, mechanism.n))
    mechanism.close_chains()

    for _ in range(dice.whole(*taste["loops"])):
        mechanism.close()

    later.close(seed, mechanism, taste["led"])
    mechanism.hold_drivers()

    for _ in range(dice.whole(*taste["couplings"])):
        mechanism.couple()

    if not mechanism.freedom() and not (any(j.driven for j in mechanism.joints) or motion):
        return None

    v = mechanism.velocities(dice.number(0.3, 1.5))
    drawn = {}

    for _ in range(dice.whole(*taste["forces"])):
        table = forces.force(dice, mechanism, dice.weighted(taste["force kinds"]), taste)
        drawn[mechanism.names.new(names.FORCES)] = table

    later.add(seed, mechanism, drawn, gravity)
    begin = later.begin(seed)
    data = {"name": f"random {seed}"} | telling.texts(dice) | gravity
    teller = telling.Teller(dice, taste)
    solver = telling.solver(dice)
    ground = teller.output(("reaction_force", "reaction_moment")) | ({"motion": motion} if motion else {})

    if solver | begin:
        data["solver"] = solver | begin

    measures = _measures(dice, mechanism, taste, teller)
    data |= teller.output(telling.SCENE)

    for holder, frame in _frames(mechanism):
        for key, value in frame(teller).items():
            holder.setdefault(key, value)

    if mechanism.ground_marker:
        ground["marker"] = mechanism.ground_marker
    if ground:
        data["ground"] = ground

    data["body"] = dice.shuffled(mechanism.body)
    data["joint"] = dice.shuffled(
        {joint.name: _joint(dice, mechanism, joint, v, taste, teller) for joint in mechanism.joints}
    )
    couplings = {name: table | teller.output(["efforts"]) for name, table in mechanism.coupling.items()}
    loads = {name: table | teller.force(table, gravity.get("sea")) for name, table in drawn.items()}
    data |= {
        key: table
        for key, table in (("coupling", couplings), ("force", loads), ("measure", measures))
        if table
    }
    looks.add(seed, data)
    water.ask(Dice(seed, 19), data)

    if trimmed := later.trim(seed, data):
        data["solver"] = data.get("solver", {}) | trimmed

    data = _plain(data)
    return data if _fits(data, mechanism, dice) else None


def _plain(value):
    """A value as tomllib would give it: numpy's numbers as Python's."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value


def _gravity(dice, taste):
    """Of what sort, and how strong."""
    if taste["sea"]:
        return {}
    if dice.chance(taste["central"]):
        return {"central_gravity": {"mu": dice.number(50.0, 200.0)}}
    if dice.chance(0.3):
        return {}
    return {"gravity": dice.pick([[0.0, 0.0, -9.81], [0.0, 0.0, 0.0], dice.vector(5.0)])}


def _frames(mechanism):
    """(table of a body or of a marker, what is added to it)"""
    for body in mechanism.body.values():
        yield body, telling.Teller.frame

        for marker in body.get("marker", {}).values():
            yield marker, lambda teller: teller.decoration() | teller.frame()

    for marker in mechanism.ground_marker.values():
        yield marker, lambda teller: teller.decoration(0.13)


def _measures(dice, mechanism, taste, teller):
    """What is seen of one frame from another."""
    found = {}

    for _ in range(dice.whole(*taste["measures"])):
        owners = dice.some([*mechanism.body, "ground", "inertial"], 2)[:2]
        ends = [
            mechanism.end(owner, frames.place(dice, 0.5)[0] if owner != "inertial" else {})
            for owner in owners
        ]
        told = dice.some(telling.MEASURES, 1) if teller.much != "all" else list(telling.MEASURES)
        found[mechanism.names.new(names.MEASURES)] = {"between": ends, "output": told}

    return found


def _joint(dice, mechanism, joint, v, taste, teller):
    """A joint's whole table."""
    table = joint.table | {"between": list(joint.ends)} | teller.joint(joint)

    # variables of a body of the same name
    body = mechanism.body.get(joint.name, {})
    if taken := {*body.get("output", ()), *body.get("input", ())} & {*table.get("output", ())}:
        table["output"] = [name for name in table["output"] if name not in taken]
    if "force" in body.get("input", ()) and "force" in table.get("input", ()):
        del body["input"]
        body.pop("input_axes", None)

    start = _start(dice, mechanism, joint, v, taste["start"])
    return table | ({"start": start} if start or (dice.chance(0.02) and joint.kind in kinds.MOVING) else {})


def _start(dice, mechanism, joint, v, sort):
    """What is written of a joint's start."""
    if joint.led:
        return dict(joint.q)

    if joint.kind in kinds.CONTACTS + kinds.TOUCHING:
        return dict(joint.q) if dice.chance(0.7) else {}

    if not joint.q or joint.says == "" or sort == "none":
        return {}

    # a joint that closes a loop follows from the others; one whose driver starts at it must stand there
    given = joint.in_tree or joint.driven or dice.chance(0.6)
    rates = v is not None and joint.says == "all" and sort != "places"
    start = (
        kinds.start(dice, joint, mechanism.velocity_of(joint, v) if rates else np.zeros(0)) if given else {}
    )

    if sort == "part" and not joint.driven:
        return kinds.in_part(dice, joint, start) if dice.chance(0.85) else {}

    if sort in ("off", "contradicting") and dice.chance(0.5):
        return _shaken(dice, start, 0.03 if sort == "off" else 0.5)

    return kinds.in_tables(start) if dice.chance(0.3) else start


def _shaken(dice, start, size):
    """A start whose numbers are all a little off."""
    shaken = {}

    for key, value in start.items():
        if isinstance(value, float):
            size_here = size * (57.3 if key.endswith("_deg") else 9.55 if key.endswith("_rpm") else 1.0)
            value = value + dice.number(-size_here, size_here)
        elif key in ("position", "velocity", "angles", "speeds", "omega", "omega_body"):
            value = [x + dice.number(-size, size) for x in value]
        shaken[key] = value

    return shaken


def _fits(data, mechanism, dice):
    """Whether the scene is valid, and its motion determined (or, rarely, not)."""
    try:
        scene = Scene.model_validate(data)
    except SceneError:
        return False

    properties = {name: body.mass_properties() for name, body in scene.body.items()}
    return mechanism.undetermined(properties) > 1e-4 or dice.chance(0.02)
