"""A scene that tells all that it can: every output of every part."""

import copy
import unicodedata

from .making import bodies, forces, telling

# beside what a point on a curve tells: normals, which jump where it is straight
TOLD = telling.JOINT | {"point_on_curve": ("s", "s_rate", "tangent")}
SCENE = [output for output in telling.SCENE if output != "multipliers"]
SEEN = {"seen_x": [1.0, 0.0, 0.0], "seen_y": [0.0, 1.0, 0.0], "seen_z": [0.0, 0.0, 1.0]}


def all_told(data):
    """The scene, a dict as of its TOML file, with every output in it."""
    data = with_ground_seen(data)
    data["output"] = SCENE
    data.setdefault("ground", {})["output"] = ["reaction_force", "reaction_moment"]

    for body in data["body"].values():
        for frame in (body, *body.get("marker", {}).values()):
            frame["output"] = list(bodies.OUTPUTS)

    for joint in data.get("joint", {}).values():
        kind = next((kind for kind in TOLD if kind in joint), None)
        joint["output"] = [*TOLD.get(kind, ()), *(telling.REACTIONS if kind != "free" else ())]

        if kind in ("revolute", "prismatic"):
            joint["output"] += [effort for part, effort in telling.EFFORTS.items() if joint.get(part)]
            joint["output"] += ["driver_effort", "effort"] if joint.get("driver") else []

        # along a curve
        if joint.get("driver") and kind in ("point_on_curve", "frame_on_curve"):
            joint["output"] += ["effort", "driver_power"]

    for coupling in data.get("coupling", {}).values():
        coupling["output"] = ["efforts"]

    for force in data.get("force", {}).values():
        force["output"] = list(forces.WRENCH)

        for kind, told in telling.FORCES.items():
            if kind in force:
                force["output"] = list(told)

        if "hydrodynamics" in force:
            force["output"] = telling.of_potential(force, data.get("sea"))

        if "torsion" in force:
            force["output"] = ["angle", *telling.TORSION]

        if "spring_damper" in force:
            force["output"] = [*telling.STRUT, "input_force" if force.get("input") else "force"]

    for measure in data.get("measure", {}).values():
        measure["output"] = list(telling.MEASURES)

    return _without_clashes(data)


def with_ground_seen(data):
    """A copy of the scene; where inputs command the ground, with measures of it from the inertial frame,
    which tell what inputs do not."""
    data = copy.deepcopy(data)

    if not data.get("ground", {}).get("motion", {}).get("input"):
        return data

    markers, measures = data["ground"].setdefault("marker", {}), data.setdefault("measure", {})
    measures["ground_seen"] = {"between": ["inertial", "ground"]}

    for name, place in SEEN.items():
        markers[name] = {"position": place}
        measures[f"ground_{name}"] = {"between": ["inertial", f"ground.{name}"]}

    return data


def _without_clashes(data):
    """Of parts of one name only the first tells what several could."""
    taken = set()

    for parts in ("body", "joint", "coupling", "force", "measure"):
        for name, part in data.get(parts, {}).items():
            known = [unicodedata.normalize("NFKD", name).encode("ascii", "ignore"), name]
            outputs = [
                output for output in part["output"] if not any((key, output) in taken for key in known)
            ]
            taken |= {(key, output) for key in known for output in outputs}
            part["output"] = outputs

            if not outputs:
                del part["output"]

    # a measure must tell something
    data["measure"] = {
        name: measure for name, measure in data.get("measure", {}).items() if "output" in measure
    }
    return data
