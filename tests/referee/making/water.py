"""Water and wind: hulls, lines, members, waves, bodies that make waves, rotors in the wind."""

from pathlib import Path

import numpy as np

from . import frames, looks

FILES = Path(__file__).parents[1] / "water"
"""Coefficients of a body, components and a record of a sea, coefficients of a rotor."""

WAVES = {"regular": 1.4, "jonswap": 2.7, "pierson_moskowitz": 2.9, "components": 1.4, "series": 1.2}
DENSITIES = (4.0, 10.0)
"""kg/m3, of seas with bodies that make waves, whose memory is fitted once for each."""


def fill(dice, mechanism, forces, water):
    """Maybe hulls on bodies, most of which cut the water plane."""
    if dice.chance(0.7):
        water["sea"] = {"density": dice.number(1.0, 20.0)} if dice.chance(0.8) else {}

        for k in range(dice.whole(1, 3)):
            shape = dice.pick(("box", "cylinder", "mesh"))
            options = {
                "box": {"size": dice.numbers(3, 0.3, 1.5)},
                "cylinder": {"radius": dice.number(0.2, 0.8), "length": dice.number(0.4, 1.5)},
                "mesh": {"file": looks.WEDGE, "scale": dice.number(0.002, 0.006)},
            }[shape]

            if shape == "cylinder" and dice.chance(0.7):
                options["sides"] = float(dice.whole(3, 9))

            hull = {shape: options} | (frames.place(dice, 0.5)[0] if dice.chance(0.6) else {})
            forces[f"hull {k}"] = {"hydrostatics": hull, "on": dice.pick(mechanism.body)}

    if dice.chance(0.4):
        _hang(dice, mechanism, forces)

    if dice.chance(0.4):
        _drag(dice, mechanism, forces, water)


def _hang(dice, mechanism, forces):
    """A line from the ground or a body to another."""
    first, second = dice.some(["ground", *mechanism.body], 2)[:2]
    pair = (second, first) if second == "ground" else (first, second)
    spans = [np.zeros(3) if owner == "ground" else mechanism.poses[owner][0] for owner in pair]
    distance = max(0.3, float(np.linalg.norm(spans[1] - spans[0])))
    line = {"length": round(distance * dice.number(0.8, 1.8), 3), "mass": dice.number(0.2, 2.0)}
    line["stiffness"] = dice.number(50.0, 500.0)

    if dice.chance(0.5):
        line["diameter"] = 0.01
    if pair[0] == "ground" and dice.chance(0.5):
        line["bed"] = dice.chance(0.5)

    forces["the line"] = {"catenary": line, "between": list(pair)}


def lay(dice, forces, sea):
    """Maybe friction of the bed under a line, or a line of sections, some of which may float where nothing lies."""
    if "the line" not in forces or not dice.chance(0.6):
        return

    force = forces["the line"]
    line, density = force["catenary"], sea.get("density", 1025.0)
    bed = line.get("bed", force["between"][0].partition(".")[0] == "ground")

    if bed and dice.chance(0.7):
        line["friction"] = dice.number(0.1, 2.0)

    if dice.chance(0.6):
        count = dice.whole(2, 3)
        whole = {key: line.pop(key) for key in ("length", "mass", "stiffness")}
        line.pop("diameter", None)
        line["sections"] = []

        for k in range(count):
            part = {
                "length": round(whole["length"] / count, 4),
                "mass": round(whole["mass"] * dice.number(0.5, 2.0), 4),
                "stiffness": round(whole["stiffness"] * dice.number(0.5, 2.0), 4),
            }
            part |= {"diameter": 0.01} if dice.chance(0.4) else {}

            if k < count - 1 and dice.chance(0.7):
                part["clump"] = {"mass": dice.number(0.1, 1.0)}
                part["clump"] |= (
                    {
                        "volume": round(
                            dice.number(0.0, 0.5 if bed else 2.0) * part["clump"]["mass"] / density, 5
                        )
                    }
                    if dice.chance(0.7)
                    else {}
                )

            line["sections"].append(part)


def _drag(dice, mechanism, forces, water):
    """Members on a body, maybe a current."""
    owner = dice.pick(mechanism.body)
    pile = {"diameter": dice.number(0.02, 0.2)}
    pile |= {key: dice.number(0.2, 1.5) for key in ("drag", "axial_drag") if dice.chance(0.7)}
    pile |= {"sections": float(dice.whole(1, 6))} if dice.chance(0.6) else {}
    ends = [
        mechanism.end(owner, {"position": dice.vector(0.5)}),
        mechanism.end(owner, {"position": dice.vector(0.5)}),
    ]

    if ends[0] != ends[1]:
        forces["the pile"] = {"member": pile, "between": ends}
        sea = water.setdefault("sea", {"density": dice.number(1.0, 20.0)})

        if dice.chance(0.6):
            sea["depth"] = 20.0
            sea["current"] = {"velocity": dice.vector(0.5)} | ({"exponent": 0.5} if dice.chance(0.5) else {})


def wave(dice, mechanism, forces, water):
    """Maybe waves, and maybe a body that feels them and makes its own."""
    if not (mechanism.taste["sea"] or dice.chance(0.12)):
        return

    sea = water.setdefault("sea", {})

    if dice.chance(0.85):
        sea["waves"] = _waves(dice)
        sea |= {"output": ["elevation"]} if dice.chance(0.7) else {}

    if dice.chance(0.75):
        sea["density"] = dice.pick(DENSITIES)
        options = {"file": str(FILES / "body.1")}
        options |= {"scale": 0.9} if dice.chance(0.3) else {}
        options |= {"radiation": _memory(dice)} if dice.chance(0.9) else {}
        options |= {"excitation": dice.chance(0.5)} if dice.chance(0.6) else {}
        owner = dice.pick(mechanism.body)
        at = mechanism.end(owner, {"position": dice.vector(0.3)} if dice.chance(0.5) else {})
        forces["the radiation"] = {"hydrodynamics": options, "on": at}


def stir(dice, forces, sea):
    """Maybe how the sea's waves go on above the mean surface; maybe a member that they leave alone, or that moves water with it."""
    if "waves" in sea and dice.chance(0.7):
        sea["stretching"] = dice.pick(["none", "wheeler"])

    if "the pile" in forces:
        pile = forces["the pile"]["member"]
        pile |= {"waves": dice.chance(0.5)} if dice.chance(0.7) else {}

        if dice.chance(0.5):
            pile["added_mass"] = dice.number(0.1, 1.2)
            pile |= {"axial_added_mass": dice.number(0.1, 1.0)} if dice.chance(0.6) else {}


def ask(dice, data):
    """Maybe how high the sea is at bodies and markers."""
    if "waves" in data.get("sea", {}):
        for body in data["body"].values():
            for frame in (body, *body.get("marker", {}).values()):
                if dice.chance(0.3):
                    frame["output"] = [*frame.get("output", []), "elevation"]


def _memory(dice):
    """Of waves made."""
    way = dice.pick(["error", "states", "file", True, False])
    return {
        "error": {"error": 0.03}, "states": {"states": 4.0}, "file": {"file": str(FILES / "memory.ss")},
    }.get(way, way)  # fmt: skip


def _waves(dice):
    """Of any kind, as long as the bodies are small."""
    kind = dice.weighted(WAVES)
    options = {"file": str(FILES / ("components.csv" if kind == "components" else "elevation.csv"))}

    if kind == "regular":
        options = {"height": dice.number(0.05, 0.4), "period": dice.number(1.0, 5.0)}
        options |= {"phase_deg": dice.number(-180, 180)} if dice.chance(0.85) else {}
    elif kind in ("jonswap", "pierson_moskowitz"):
        options = {"hs": dice.number(0.05, 0.4), "tp": dice.number(1.5, 4.0)}
        options["components"] = float(dice.whole(1, 40))
        options |= {"seed": float(dice.whole(0, 99))} if dice.chance(0.8) else {}
        options |= {"spacing": dice.pick(["energy", "frequency"])} if dice.chance(0.9) else {}
        options |= {"gamma": dice.number(1.0, 5.0)} if kind == "jonswap" and dice.chance(0.8) else {}

        if dice.chance(0.8):
            options["spread"] = dice.number(1.0, 10.0)
            options |= {"directions": float(dice.whole(2, 7))} if dice.chance(0.8) else {}

    waves = {kind: options}
    return waves | (
        {"direction_deg": dice.number(-180, 180)} if kind != "components" and dice.chance(0.7) else {}
    )


def blow(dice, mechanism, forces, air):
    """Wind, and a rotor in it."""
    steady = {"velocity": dice.vector(4.0)}

    if dice.chance(0.5):
        steady["exponent"] = dice.number(0.05, 0.3)
        steady |= {"reference_height": dice.number(1.0, 20.0)} if dice.chance(0.7) else {}

    air["wind"] = {"steady": steady} | ({"density": dice.number(0.5, 3.0)} if dice.chance(0.6) else {})
    air["wind"] |= {"input": ["velocity"]} if dice.chance(0.4) else {}
    options = {"radius": dice.number(0.3, 0.8), "table": str(FILES / "rotor.csv")}
    options |= {"pitch": dice.number(0.0, 0.4)} if dice.chance(0.6) else {}
    at = mechanism.end(dice.pick(mechanism.body), frames.place(dice, 0.4)[0] if dice.chance(0.7) else {})
    forces["the blades"] = {"rotor": options, "on": at}
    forces["the blades"] |= {"input": ["pitch"]} if dice.chance(0.5) else {}


def feel(dice, force, sea):
    """Maybe more of a body that makes waves: damping beside them, another point, another size, a sea from elsewhere."""
    options = force["hydrodynamics"]
    memory = options.get("radiation")
    ready = isinstance(memory, dict) and "file" in memory

    if dice.chance(0.3) and not ready:
        options["froude"] = dice.pick([1.1, 1.25])
    if dice.chance(0.35):
        options["reference"] = dice.vector(0.3)
    if dice.chance(0.35):
        options["spikes"] = dice.pick(["keep", "cut"])
    if dice.chance(0.35):
        options["damping"] = dice.pick([dice.numbers(6, 0.0, 2.0), _pulls_back(dice)])
    if dice.chance(0.35):
        options["quadratic"] = dice.pick([dice.numbers(6, 0.0, 2.0), _pulls_back(dice)])
    if dice.chance(0.3):
        options["excitation"] = "input"
    elif "waves" in sea and options.get("excitation", True) and dice.chance(0.5):
        options["position"] = dice.pick(["now", "now", "mean"])


def head(dice, forces, sea):
    """Maybe axes that turn with a body that makes waves, and a member that waves meet where it is."""
    if "the radiation" in forces and dice.chance(0.5):
        options = forces["the radiation"]["hydrodynamics"]
        loaded = "waves" in sea and options.get("excitation", True) is True
        options["axes"] = dice.pick(["first", "heading"] if loaded else ["heading", "body"])

    spec = sea.get("waves", {}).get("pierson_moskowitz")

    if spec and dice.chance(0.4):
        options = {key: value for key, value in spec.items() if key not in ("hs", "tp")}
        sea["waves"] = {"spectrum": {"file": str(FILES / "spectrum.csv")} | options} | {
            key: value for key, value in sea["waves"].items() if key == "direction_deg"
        }

    if "the pile" in forces and "waves" in sea and dice.chance(0.6):
        pile = forces["the pile"]["member"]
        pile |= {"position": dice.pick(["now", "now", "mean"])} if pile.get("waves", True) else {}


def _pulls_back(dice):
    """A symmetric matrix that takes energy, by rows."""
    half = np.array([dice.numbers(6, -0.5, 0.5) for _ in range(6)])
    return (half @ half.T + 0.05 * np.eye(6)).round(4).tolist()


def gust(dice, wind):
    """Maybe a gust."""
    kind = dice.pick(["eog", "step", "table", None])
    start = dice.number(0.0, 0.5)

    if kind == "eog":
        options = {"start": start, "period": dice.number(0.5, 3.0)}
        by_class = {"turbine_class": dice.pick(["I", "II", "III"]), "diameter": dice.number(1.0, 40.0)}
        by_class |= {"turbulence": dice.pick(["A+", "A", "B", "C"])} if dice.chance(0.9) else {}
        options |= by_class if dice.chance(0.55) else {"amplitude": dice.number(0.5, 3.0)}
    elif kind == "step":
        options = {"start": start, "velocity": dice.vector(2.0)}
        options |= {"rise": dice.pick([0.0, dice.number(0.2, 1.0)])} if dice.chance(0.8) else {}
    elif kind == "table":
        options = {"time": np.cumsum(dice.numbers(4, 0.1, 0.6)).round(4).tolist()}
        options["velocity"] = [dice.vector(2.0) for _ in range(4)]
        options |= (
            {"interpolation": dice.pick(["linear", "steps", "monotone", "cubic"])} if dice.chance(0.7) else {}
        )

    if kind:
        wind["gust"] = {kind: options}
