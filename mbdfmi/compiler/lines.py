"""Lines that hang in the water or lie on the sea bed."""

import numpy as np

from ..kernels import outputs
from ..scene import Problem, SceneError
from ..scene.ends import stands_still
from ..scene.sea import Sea
from ..vectors import norm
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


# of the depth: how far above or under the sea's bed an anchor is still on it
NEAR_BED = 1.01

# by the distance of its ends: a line so long has its length in other units
FAR_TOO_LONG = 100.0

# strain by its own weight that no chain, wire or rope has
SOFT = 0.1


def add_catenary(builder, name, force, ends):
    """A catenary between two markers. Raises SceneError for a line that floats."""
    spec = force.catenary
    composite = spec.is_composite
    row = (_add_composite if composite else _add_line)(builder, name, force, ends)
    _watch(builder, name, row, composite)
    _tell_length(builder, name, force)
    _tell_places(builder, name, force)
    _tell_moving_bed(builder, name, force)
    nodes = [builder.node_of(end) for end in force.between]

    for output in force.output:
        quantity = LINE_OUTPUTS[output]
        source = Source(LINE_KINDS[output], row, int(composite))
        builder.add_outputs(dotted(name, output), source, quantity.unit, f"{name}: {quantity.text}", nodes)


def _add_line(builder, name, force, ends):
    """One without sections on a smooth bed, or none. Returns its row."""
    spec = force.catenary
    mass = _mass_in_water(builder, spec)

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

    for key, value, unit, about in (
        ("length", spec.length, "m", "unstretched length"),
        ("mass", mass, "kg/m", "mass by length, less that of the water displaced,"),
        ("stiffness", spec.stiffness, "N", "tension by strain"),
    ):
        place = Place(f"line_{key}", row)
        builder.add_parameters(dotted(name, key), place, value, unit, f"{about} of {name}")

    return row


def _add_composite(builder, name, force, ends):
    """One of several sections, or on a bed with friction. Returns its row. Raises SceneError for what floats and is held by friction."""
    spec, table = force.catenary, builder.tables["n_section"]
    density, bed = _density(builder), _has_bed(builder, force)
    masses = [_mass_in_water(builder, section) for section in spec.parts]
    clumps = [
        section.clump.mass - density * section.clump.volume if section.clump else 0.0
        for section in spec.parts
    ]
    floating = [k for k, pair in enumerate(zip(masses, clumps)) if min(pair) < 0.0]
    path = ("force", name, "catenary")

    if floating and (spec.sections is None or (bed and spec.friction > 0.0)):
        k = floating[0]
        what = (
            "the line"
            if spec.sections is None
            else f"section {k + 1}"
            if masses[k] < 0.0
            else f"the clump of section {k + 1}"
        )
        text = (
            f"{what} is lighter than the water that it displaces, by {-min(masses[k], clumps[k]):.3g} {'kg/m' if masses[k] < 0.0 else 'kg'}: "
            "friction of the bed goes with lines of which nothing floats"
        )
        raise SceneError([Problem((*path, "friction"), text)])

    if spec.friction > 0.0 and not bed:
        builder.notice(
            (*path, "friction"),
            "does nothing: the line has no bed, as its first end is not on one; bed = true gives it one",
        )

    first = table.length

    for section, mass, clump in zip(spec.parts, masses, clumps):
        table.add(
            section_length=section.length,
            section_mass=mass,
            section_stiffness=section.stiffness,
            section_clump=clump,
        )

    row = builder.tables["n_composite"].add(
        composite_from=ends[0],
        composite_to=ends[1],
        composite_bed=bed,
        composite_section=first,
        composite_sections=len(masses),
        composite_friction=spec.friction,
    )
    place = Place("composite_friction", row)
    about = "friction of the bed by the weight on it"
    builder.add_parameters(dotted(name, "friction"), place, spec.friction, None, f"{about}, of {name}")
    one = spec.sections is None

    for key, values, unit, about in (
        ("length", [section.length for section in spec.parts], "m", "unstretched length"),
        ("mass", masses, "kg/m", "mass by length, less that of the water displaced,"),
        ("stiffness", [section.stiffness for section in spec.parts], "N", "tension by strain"),
        ("clump", clumps[:-1], "kg", "mass between sections, less that of the water displaced,"),
    ):
        place = Place(f"section_{key}", first)
        given = values[0] if one and values else values
        of = f"{about} of {name}" if one or key == "clump" else f"{about} of sections of {name}"

        if values:
            builder.add_parameters(dotted(name, key), place, given, unit, of)

    return row


def _watch(builder, name, row, composite):
    """Has it told if a line comes under the sea's bed in a run."""
    sea = builder.scene.sea

    if sea and sea.depth:
        builder.tables["n_low"].add(
            low_line=row, low_composite=composite, low_place=builder.add_name(name), low_bed=-sea.depth
        )


def _density(builder):
    """kg/m3, of the water."""
    return (builder.scene.sea or Sea()).density


def _mass_in_water(builder, spec):
    """kg/m, of a line or a section, less that of the water displaced."""
    return spec.mass - _density(builder) * np.pi * spec.diameter**2 / 4


def _has_bed(builder, force):
    """Whether the line may lie on a bed."""
    anchor, sea = force.between[0], builder.scene.sea

    if force.catenary.bed is not None:
        return force.catenary.bed
    if not stands_still(anchor):
        return False

    first, second = _heights(builder, force)
    return second >= first and (not (sea and sea.depth) or first < -(2.0 - NEAR_BED) * sea.depth)


def _heights(builder, force):
    """z (m) of both ends at the start."""
    return [float(start_pose(builder, end)[0][2]) for end in force.between]


def _tell_length(builder, name, force):
    """Notices of a line that is soft, or shorter than the distance of its ends at the start, or many times as long."""
    first, second = (start_pose(builder, end)[0] for end in force.between)
    distance, spec = norm(second - first), force.catenary
    length = spec.total_length
    text = f"is {length:g} m long, and its ends are {distance:g} m apart at the start: "
    key, path = "length" if spec.sections is None else "sections", ("force", name, "catenary")
    # strain by tension, 1/N
    give = sum(section.length / section.stiffness for section in spec.parts) / length
    weight = sum(section.mass * section.length for section in spec.parts) * norm(builder.scene.gravity)

    # of one that hangs straight down, by half of its weight
    if weight * give > 2 * SOFT:
        soft = f"its own weight of {weight:.3g} N stretches it by {50 * weight * give:.2g} % where it hangs; stiffness is EA, in N"
        builder.notice((*path, "stiffness" if spec.sections is None else "sections"), soft)

    if distance > length:
        strain = distance / length - 1
        text += f"stretched by {100 * strain:.2g} %, with {strain / give:.3g} N"
    elif length > FAR_TOO_LONG * distance > 0.0:
        text += f"{length / distance:.0f} times as long; lengths are in m"
    else:
        return

    builder.notice((*path, key), text)


def _tell_places(builder, name, force):
    """A notice of an end under the sea's bed at the start, or of a line above the sea that is weighed as one in it."""
    spec, sea = force.catenary, builder.scene.sea
    heights = _heights(builder, force)
    deepest, path = min(heights), ("force", name)

    if sea and sea.depth and deepest < -NEAR_BED * sea.depth:
        end = force.between[heights.index(deepest)]
        text = f"{end} starts at z = {deepest:g} m, under the sea's bed: [sea] depth is {sea.depth:g} m"
        builder.notice((*path, "between"), text)

    if spec.bed and heights[1] < heights[0]:
        text = (
            f"{force.between[1]} starts {heights[0] - heights[1]:.4g} m below {force.between[0]}, and the bed is as high as that: a line that "
            "lies on it pulls along it alone and holds nothing up; bed = false hangs it up"
        )
        builder.notice((*path, "catenary", "bed"), text)

    carried = any(part.diameter > 0.0 or (part.clump and part.clump.volume > 0.0) for part in spec.parts)

    if sea and carried and min(heights) > 0.0:
        text = (
            f"both ends start above the water, at z = {heights[0]:g} and {heights[1]:g} m, and what the line displaces carries it as if "
            "it were in it: diameter = 0 in air"
        )
        builder.notice((*path, "catenary"), text)


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
