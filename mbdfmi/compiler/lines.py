"""Lines that hang in the water or lie on the sea bed."""

import numpy as np

from ..kernels import outputs
from ..scene import Problem, SceneError
from ..scene.ends import stands_still
from ..scene.sea import Sea
from ..vocabulary import LINE_OUTPUTS
from .builder import Place, Source
from .start import start_pose
from .variables import dotted

# words of the scene -> kinds of kernels/outputs.py
LINE_KINDS = {
    "tension": outputs.LINE_TENSION,
    "anchor_tension": outputs.LINE_ANCHOR_TENSION,
    "grounded_length": outputs.LINE_GROUNDED,
    "force": outputs.LINE_FORCE,
    "power": outputs.LINE_POWER,
}


def add_catenary(builder, name, force, ends):
    """A catenary between two markers. Raises SceneError for a line that floats."""
    spec = force.catenary
    density = (builder.scene.sea or Sea()).density
    mass = spec.mass - density * np.pi * spec.diameter**2 / 4

    if not mass > 0.0:
        text = (
            f"the line is lighter than the water that it displaces: {spec.mass:g} kg/m, and {spec.mass - mass:g} kg/m of water at a "
            f"diameter of {spec.diameter:g} m; a line must sink"
        )
        raise SceneError([Problem(("force", name, "catenary", "diameter"), text)])

    row = builder.tables["n_line"].add(
        line_from=ends[0],
        line_to=ends[1],
        line_bed=_has_bed(builder, force),
        line_length=spec.length,
        line_mass=mass,
        line_stiffness=spec.stiffness,
    )
    _tell_stretch(builder, name, force)
    _tell_moving_bed(builder, name, force)

    for key, value, unit, about in (
        ("length", spec.length, "m", "unstretched length"),
        ("mass", mass, "kg/m", "mass by length, less that of the water displaced,"),
        ("stiffness", spec.stiffness, "N", "tension by strain"),
    ):
        place = Place(f"line_{key}", row)
        builder.add_parameters(dotted(name, key), place, value, unit, f"{about} of {name}")

    nodes = [builder.node_of(end) for end in force.between]

    for output in force.output:
        quantity = LINE_OUTPUTS[output]
        source = Source(LINE_KINDS[output], row)
        builder.add_outputs(dotted(name, output), source, quantity.unit, f"{name}: {quantity.text}", nodes)


def _has_bed(builder, force):
    """Whether the line may lie on a bed."""
    anchor, sea = force.between[0], builder.scene.sea

    if force.catenary.bed is not None:
        return force.catenary.bed
    if not stands_still(anchor):
        return False
    return not (sea and sea.depth) or start_pose(builder, anchor)[0][2] < -0.99 * sea.depth


def _tell_stretch(builder, name, force):
    """A notice of a line that is shorter than the distance of its ends at the start."""
    first, second = (start_pose(builder, end)[0] for end in force.between)
    distance, spec = np.linalg.norm(second - first), force.catenary

    if distance > spec.length:
        strain = distance / spec.length - 1
        text = (
            f"is {spec.length:g} m long, and its ends are {distance:g} m apart at the start: stretched by {100 * strain:.2g} %, with "
            f"{strain * spec.stiffness:.3g} N"
        )
        builder.notice(("force", name, "catenary", "length"), text)


def _tell_moving_bed(builder, name, force):
    """A notice of a bed that may rise and fall with what the line is anchored to."""
    anchor = force.between[0]
    moves = builder.scene.ground.motion if anchor.partition(".")[0] == "ground" else not stands_still(anchor)

    if moves and _has_bed(builder, force):
        text = (
            "is as high as the first end, which moves: what a bed that rises or falls does to the line is in no power and no energy; "
            "bed = false goes without"
        )
        builder.notice(("force", name, "catenary", "bed"), text)
