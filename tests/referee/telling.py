"""A scene that tells all that it can: every output of every part."""

import copy
import unicodedata

MARKER = [
    "position", "velocity", "acceleration", "euler_parameters", "zyx", "zyx_rate", "omega", "alpha",
    "velocity_body", "acceleration_body", "omega_body", "alpha_body",
]  # fmt: skip
MEASURE = [
    "distance", "distance_rate", "angle", "position", "velocity", "acceleration", "euler_parameters", "zyx",
    "zyx_rate", "omega",
]  # fmt: skip
REACTIONS = ["reaction_force", "reaction_moment", "reaction_force_body", "reaction_moment_body"]
PARTS = ("spring", "damper", "friction", "stop", "input", "driver")
SCENE = [
    "kinetic_energy", "potential_energy", "total_energy", "gravity_energy", "spring_energy", "input_power",
    "load_power", "driver_power", "dissipated_power", "linear_momentum", "angular_momentum", "center_of_mass",
    "constraint_gap", "constraint_rate",
]  # fmt: skip
JOINT = {
    "revolute": ["angle", "speed", "acceleration", "power"],
    "prismatic": ["position", "speed", "acceleration", "power"],
    "cylindrical": ["position", "speed", "angle", "angular_speed"],
    "screw": ["position", "speed", "angle", "angular_speed"],
    "universal": ["angles", "speeds"],
    "spherical": ["euler_parameters", "zyx", "zyx_rate", "omega", "alpha"],
    "planar": ["position", "angle", "velocity", "angular_speed"],
    "translation": ["position", "velocity"],
    "free": ["position", "velocity", "euler_parameters", "zyx", "zyx_rate", "omega"],
    "point_on_curve": ["s", "s_rate", "tangent"],
    "curve_on_curve": ["s", "s_rate", "tangent", "binormal", "normal"],
    "point_on_surface": ["s", "s_rate", "tangent", "binormal", "normal"],
    "frame_on_curve": ["s", "s_rate", "tangent", "binormal", "normal"],
    "frame_on_surface": ["s", "s_rate", "tangent", "binormal", "normal"],
    "surface_on_surface": ["s", "s_rate", "contact_point", "normal_force"],
    "rolling_surface": ["s", "s_rate", "contact_point", "normal_force", "friction_force"],
    "prescribed": [
        "position",
        "velocity",
        "euler_parameters",
        "zyx",
        "zyx_rate",
        "omega",
        "driver_force",
        "driver_torque",
    ],
}
SEEN = {"seen_x": [1.0, 0.0, 0.0], "seen_y": [0.0, 1.0, 0.0], "seen_z": [0.0, 0.0, 1.0]}
HULL = [
    "volume", "center_of_buoyancy", "draught", "waterplane_area", "waterplane_center", "waterplane_moments",
    "force", "moment", "power",
]  # fmt: skip
SIX = ["force", "moment", "displacement", "rotation", "power"]


def all_told(data):
    """The scene, a dict as of its TOML file, with every output in it."""
    data = with_ground_seen(data)
    data["output"] = SCENE
    data.setdefault("ground", {})["output"] = ["reaction_force", "reaction_moment"]

    for body in data["body"].values():
        for frame in (body, *body.get("marker", {}).values()):
            frame["output"] = MARKER

    for joint in data.get("joint", {}).values():
        kind = next((kind for kind in JOINT if kind in joint), None)
        joint["output"] = JOINT.get(kind, []) + (REACTIONS if kind != "free" else [])

        if kind in ("revolute", "prismatic"):
            joint["output"] = joint["output"] + [f"{part}_effort" for part in PARTS if joint.get(part)]
            joint["output"] += ["effort"] if joint.get("driver") else []

    for coupling in data.get("coupling", {}).values():
        coupling["output"] = ["efforts"]

    for force in data.get("force", {}).values():
        force["output"] = ["power"] if "load" in force else SIX

        if "hydrostatics" in force:
            force["output"] = HULL

        if "torsion" in force:
            force["output"] = ["angle", "rate", "moment", "spring_moment", "damper_moment", "power"]

        if "spring_damper" in force:
            force["output"] = ["length", "rate", "tension", "spring_force", "damper_force", "power"]
            force["output"] = force["output"] + (["input_force"] if force.get("input") else ["force"])

    for measure in data.get("measure", {}).values():
        measure["output"] = MEASURE

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
