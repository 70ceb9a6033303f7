"""What water does to bodies."""

import numpy as np

from ..kernels import outputs
from ..scene import Problem, SceneError
from ..scene.sea import Sea
from ..vectors import dot, norm
from ..vocabulary import HYDROSTATICS_OUTPUTS, MEMBER_OUTPUTS
from .builder import Place, Source
from .hulls import hull_of
from .sea_limits import tell_hull_aground
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

    row = tables["n_member_drag"].add(
        member_from=ends[0],
        member_to=ends[1],
        member_sections=spec.sections,
        member_value=[spec.diameter, spec.drag, spec.axial_drag],
        member_density=sea.density,
    )

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
