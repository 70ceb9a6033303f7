"""What water does to bodies."""

import numpy as np

from ..kernels import outputs
from ..kernels.forces.stations import HERE
from ..scene import Problem, SceneError
from ..scene.sea import Sea
from ..vectors import dot, norm
from ..vocabulary import HYDROSTATICS_OUTPUTS, MEMBER_OUTPUTS
from .builder import Place, Source
from .hulls import hull_of
from .hydrodynamics import add_added_mass
from .sea_limits import tell_hull_aground, tell_member_aground
from .seas import add_waves
from .start import start_pose
from .variables import dotted

# words of the scene -> kinds of kernels/outputs.py
HYDROSTATICS_KINDS = {
    "volume": outputs.HULL_VOLUME,
    "center_of_buoyancy": outputs.HULL_CENTER,
    "draught": outputs.HULL_DRAUGHT,
    "waterplane_area": outputs.WATERPLANE_AREA,
    "waterplane_center": outputs.WATERPLANE_CENTER,
    "waterplane_moments": outputs.WATERPLANE_MOMENTS,
    "force": outputs.HULL_FORCE,
    "moment": outputs.HULL_MOMENT,
    "power": outputs.HULL_POWER,
}


def add_hydrostatics(builder, name, force, ends):
    """A hull on a marker."""
    tables = builder.tables
    density = (builder.scene.sea or Sea()).density
    position, A = force.hydrostatics.pose()
    points, polygons = hull_of(force.hydrostatics)
    first, first_polygon = tables["n_hull_vertex"].length, tables["n_polygon"].length

    corners = position + dot(np.asarray(points), A.T)
    tell_hull_aground(builder, name, force.on, corners)

    for r in corners:
        tables["n_hull_vertex"].add(vertex_r=r)

    for polygon in polygons:
        tables["n_polygon"].add(polygon_corner=tables["n_corner"].length, polygon_corners=len(polygon))

        for k in polygon:
            tables["n_corner"].add(corner_vertex=first + k)

    row = tables["n_hull"].add(
        hull_marker=ends[0],
        hull_vertex=first,
        hull_vertices=len(points),
        hull_polygon=first_polygon,
        hull_polygons=len(polygons),
        hull_density=density,
    )
    about = f"density of the water around {name}"
    builder.add_parameters(dotted(name, "density"), Place("hull_density", row), density, "kg/m3", about)

    for output in force.output:
        quantity = HYDROSTATICS_OUTPUTS[output]
        source = Source(HYDROSTATICS_KINDS[output], row)
        nodes = [builder.node_of(force.on)]
        builder.add_outputs(dotted(name, output), source, quantity.unit, f"{name}: {quantity.text}", nodes)


def add_member(builder, name, force, ends):
    """A member that water drags at."""
    spec, sea, tables = force.member, builder.scene.sea or Sea(), builder.tables
    current = sea.current
    first, second = (builder.scene.marker_pose(end)[1] for end in force.between)

    if not norm(second - first) > 0.0:
        text = "both ends are at one place: a member needs a length"
        raise SceneError([Problem(("force", name, "between"), text)])

    if current and not tables["n_current"].length:
        profile = [current.exponent, sea.depth or 1.0]
        tables["n_current"].add(current_velocity=current.velocity, current_profile=profile)
        about = "velocity of the current at the surface"
        builder.add_parameters("sea.current", Place("current_velocity"), current.velocity, "m/s", about)

    tell_member_aground(builder, name, force)
    pushed = spec.added_mass is not None
    waves = bool(sea.waves) and spec.waves
    value = [spec.diameter, spec.drag, spec.axial_drag, spec.added_mass if pushed else -1.0]
    row = tables["n_member_drag"].add(
        member_from=ends[0],
        member_to=ends[1],
        member_sections=spec.sections,
        member_station=_waves_at(builder, force, ends) if waves else -1,
        member_value=[*value, spec.axial_added_mass],
        member_density=sea.density,
    )

    if pushed:
        _add_member_inertia(builder, name, force, ends, sea.density)

    for k, (key, about) in enumerate((("drag", "across"), ("axial_drag", "along")), 1):
        place = Place("member_value", row, k)
        about = f"drag coefficient {about} {name}"
        builder.add_parameters(dotted(name, key), place, getattr(spec, key), None, about)

    for output in force.output:
        quantity = MEMBER_OUTPUTS[output]
        kind = outputs.MEMBER_FORCE if output == "force" else outputs.MEMBER_POWER
        nodes = [builder.node_of(force.between[0])]
        builder.add_outputs(
            dotted(name, output), Source(kind, row), quantity.unit, f"{name}: {quantity.text}", nodes
        )


# Gauss points of a unit interval
GAUSS = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))


def _waves_at(builder, force, ends):
    """The first of a member's stations, those of its sections' points and its ends; HERE where it feels the waves of where it is."""
    add_waves(builder)

    if force.member.position == "now":
        return HERE

    first, second = (start_pose(builder, end)[0] for end in force.between)
    sections = force.member.sections
    parts = [(j + g) / sections for j in range(sections) for g in GAUSS] + [0.0, 1.0]
    rows = [builder.tables["n_station"].add(station_r=first + part * (second - first)) for part in parts]
    builder.wave_places += [("station_r", row, 3, ends, part) for row, part in zip(rows, parts)]
    return rows[0]


def _add_member_inertia(builder, name, force, ends, density):
    """The water that moves along with what of a member is wet at the start, as added mass about its first end."""
    spec, scene = force.member, builder.scene

    def added(first, second):
        return _member_inertia(spec, density, first, second)

    row = add_added_mass(builder, ends[0], added(*(start_pose(builder, end)[0] for end in force.between)))
    builder.wet_members.append((row, ends, added))
    node = builder.node_of(force.between[0])
    others = [
        other
        for other, known in scene.force.items()
        if known.kind == "hydrodynamics" and any(builder.node_of(end) == node for end in known.between)
    ]

    if others:
        text = f"counts the inertia of the water twice: {others[0]} knows of it; leave added_mass out beside hydrodynamics"
        builder.notice(("force", name, "member", "added_mass"), text)


def _member_inertia(spec, density, first, second):
    """(6, 6) of the water that moves along with what is wet of a member from first to second (m), about first."""
    way = second - first
    length = norm(way)
    along = np.outer(way, way) / length**2
    begin, last = _wet_span(first[2], second[2])
    across = density * np.pi * spec.diameter**2 / 4 * spec.added_mass * (np.eye(3) - along)
    disc = density * np.pi * spec.diameter**3 / 12 * spec.axial_added_mass * along
    wet = last - begin
    added = sum(_inertia_at(wet / 2 * length * across, (begin + wet * g) * way) for g in GAUSS)
    ends = (part for part, z in ((0, first[2]), (1, second[2])) if z <= 0.0)
    return added + sum(_inertia_at(disc, part * way) for part in ends)


def _wet_span(start, end):
    """From where to where of its way, from 0 to 1, a member is under water whose ends are at two z (m)."""
    if (start <= 0.0) == (end <= 0.0):
        return 0.0, float(start <= 0.0)

    comes_out = start / (start - end)
    return (0.0, comes_out) if start <= 0.0 else (comes_out, 1.0)


def _inertia_at(mass, r):
    """(6, 6) of a mass (3, 3) at r (m) about the origin: force and moment from accelerations."""
    x, y, z = r
    moves = np.hstack([np.eye(3), [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]])
    return dot(moves.T, mass, moves)
