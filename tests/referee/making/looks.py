"""Looks, which no number may depend on, and solids from files: drawn by dice of their own."""

from pathlib import Path

from . import frames
from .dice import Dice

WEDGE = str(Path(__file__).parents[1] / "meshes" / "wedge.stl")
"""A tetrahedron, in mm."""

COLOURS = ("steelblue", "tomato", "#336699", "#fa0")
KINDS = ("sphere", "box", "cylinder", "tube", "capsule", "cone", "mesh", "line")


def add_solid(dice, mechanism):
    """A mesh among the solids of a body."""
    for body in mechanism.body.values():
        if "solid" in body and dice.chance(0.3):
            heavy = {"mass": dice.number(0.1, 0.5)} if dice.chance(0.5) else {"density": dice.number(50, 500)}
            mesh = {"mesh": {"file": WEDGE, "scale": 0.001} | heavy} | frames.place(dice, 0.2)[0]
            solids = body["solid"] if isinstance(body["solid"], list) else [body["solid"]]
            body["solid"] = [*solids, mesh]


def add(seed, data):
    """Shapes and colours to a scene's bodies, ground and markers, and how it is looked at."""
    dice = Dice(seed, 2)

    for owner, holder in [("ground", data.get("ground", {})), *data["body"].items()]:
        _paint(dice, holder, owner, holder.get("marker", {}))

        for marker in holder.get("marker", {}).values():
            _paint(dice, marker, owner, holder["marker"])

        if owner == "ground" and holder:
            data["ground"] = holder

    _place_more(Dice(seed, 8), data)

    if dice.chance(0.4):
        data["view"] = _view(dice, data)

    if dice.chance(0.3):
        start = dice.number(-1.0, 1.0)
        data["experiment"] = {"start": start, "stop": start + 5.0, "step": 0.05, "tolerance": 1e-6}

    # what is said here changes no number: libraries are compiled and parameters bound where it is asked for
    if dice.chance(0.1):
        data["code"] = {"specialise": False, "sources": False, "bind": []}


def _place_more(dice, data):
    """More shapes on the ground and its markers, and on bodies, turned in every way."""
    ground = data.get("ground", {})
    holders = [holder for holder in (ground, *ground.get("marker", {}).values()) if dice.chance(0.6)]
    holders += [body for body in data["body"].values() if dice.chance(0.15)]

    for holder in holders:
        own = holder.get("shape", [])
        more = [_shape(dice, "ground", {}, KINDS[:-1], turned=1.0) for _ in range(3)]
        holder["shape"] = [*(own if isinstance(own, list) else [own]), *more]

    if ground:
        data["ground"] = ground


def _paint(dice, holder, owner, markers):
    if dice.chance(0.2):
        holder["colour"] = dice.pick(COLOURS)

    if dice.chance(0.3):
        shapes = [_shape(dice, owner, markers) for _ in range(dice.whole(1, 3))]
        holder["shape"] = shapes[0] if len(shapes) == 1 and dice.chance(0.5) else shapes


def _shape(dice, owner, markers, kinds=KINDS, turned=0.6):
    kind = dice.pick(kinds)
    look = {"colour": dice.pick(COLOURS)} if dice.chance(0.3) else {}
    look |= {"opacity": dice.number(0.1, 1.0)} if dice.chance(0.3) else {}

    if kind == "line":
        ends = [owner, *(f"{owner}.{name}" for name in dice.some(markers)), owner]
        return {"line": ends} | look | ({"radius": dice.number(0.01, 0.1)} if dice.chance(0.5) else {})

    radius, length = dice.number(0.1, 0.3), dice.number(0.2, 0.8)
    form = {
        "sphere": {"radius": radius},
        "box": {"size": dice.numbers(3, 0.1, 0.5)},
        "cylinder": {"radius": radius, "length": length},
        "tube": {"radius": radius, "inner_radius": round(0.5 * radius, 4), "length": length},
        "capsule": {"radius": radius, "length": length},
        "cone": {"radius": radius, "length": length} | ({"top_radius": 0.05} if dice.chance(0.5) else {}),
        "mesh": {"file": WEDGE, "scale": 0.001 if dice.chance(0.5) else [0.001, 0.002, -0.001]},
    }[kind]
    along = kind in ("cylinder", "tube", "capsule", "cone") and dice.chance(0.5)
    axis = {"axis": frames.axis(dice)[0]} if along else {}
    return {kind: form} | frames.place(dice, 0.3, turned)[0] | look | axis


def _view(dice, data):
    ends = [*data["body"], *(f"{b}.{m}" for b, body in data["body"].items() for m in body.get("marker", {}))]
    view = {"ground": dice.pick(["grid", "none"]), "frame": dice.pick(["ground", "inertial", *data["body"]])}
    view |= {"up": frames.axis(dice)[0]} if dice.chance(0.5) else {}
    view |= {"water": dice.number(-1, 1)} if dice.chance(0.5) else {}
    view |= {"look_from": [1.0, *dice.vector(1.0, 2)]} if dice.chance(0.5) else {}
    view |= {"paths": dice.some(ends)} if dice.chance(0.5) else {}
    return view | ({"plots": ["total_energy"]} if dice.chance(0.3) else {})
