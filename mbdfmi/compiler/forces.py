"""Force elements between two markers, and loads on one."""

from importlib import import_module

import numpy as np

from ..kernels import outputs
from ..kernels.forces.six_by_six import BODY, FIRST, HEADING
from ..kernels.motion.coordinates import TWIST
from ..vectors import norm
from ..vocabulary import LOAD_OUTPUTS, SIX_BY_SIX_OUTPUTS, STRUT_INPUT, STRUT_OUTPUTS, TORSION_OUTPUTS
from .builder import Place, Source
from .elastic import add_along, damper_of, spring_of, watch
from .start import start_pose
from .variables import dotted

AXES = {"first": FIRST, "heading": HEADING, "body": BODY}

# words of the scene -> kinds of kernels/outputs.py
STRUT_KINDS = {
    "length": outputs.STRUT_LENGTH,
    "rate": outputs.STRUT_RATE,
    "force": outputs.STRUT_FORCE,
    "tension": outputs.STRUT_FORCE,
    "spring_force": outputs.STRUT_SPRING,
    "damper_force": outputs.STRUT_DAMPER,
    "input_force": outputs.STRUT_INPUT,
    "power": outputs.STRUT_POWER,
}
FED_BY_INPUT = ("tension", "input_force", "power")
TORSION_KINDS = {
    "angle": outputs.COORDINATE,
    "rate": outputs.RATE,
    "moment": outputs.EFFORT,
    "power": outputs.JOINT_POWER,
    "spring_moment": outputs.SPRING_EFFORT,
    "damper_moment": outputs.DAMPER_EFFORT,
}
OF_SPRING = ("spring_moment", "damper_moment")
SIX_BY_SIX_KINDS = {
    "force": outputs.LINEAR_FORCE,
    "moment": outputs.LINEAR_MOMENT,
    "displacement": outputs.POSITION,
    "rotation": outputs.LINEAR_ROTATION,
    "power": outputs.LINEAR_POWER,
}


def add_forces(builder):
    """All force elements of the scene."""
    for name, force in builder.scene.force.items():
        ends = [builder.marker(end) for end in force.between]
        builder.force_nodes.append([builder.marker_node(end) for end in ends])
        _adder(force.kind)(builder, name, force, ends)


def _adder(kind):
    """What adds an element of a kind."""
    if kind not in RARE:
        return ELEMENTS[kind]

    module, name = RARE[kind]
    return getattr(import_module(f".{module}", __package__), name)


# of each kind: the builder, the element's name and table, its markers


def _add_strut(builder, name, force, ends):
    """A spring-damper along the line between two markers."""
    spec = force.spring_damper
    nodes = [builder.node_of(end) for end in force.between]
    spring = spring_of(builder, spec.table, spec.stiffness, spec.rest_length)
    damper = damper_of(builder, spec.damping)
    u = -1

    if force.input:
        about = f"{STRUT_INPUT.text} of {name} beside its spring, tension positive"
        u = builder.add_inputs(dotted(name, STRUT_INPUT.name), STRUT_INPUT, about, nodes)

    slack = spring.rest is None

    if slack:
        first, second = (start_pose(builder, end)[0] for end in force.between)
        spring = spring._replace(rest=norm(second - first))

    row = builder.tables["n_strut"].add(
        strut_from=ends[0],
        strut_to=ends[1],
        strut_spring_table=spring.table,
        strut_damper_table=damper.table,
        strut_u=u,
        strut_slack=slack,
        strut_stiffness=spring.stiffness,
        strut_damping=damper.damping,
        strut_rest=spring.rest,
        strut_told=spring.rest,
    )
    watch(
        builder, name, "m", Source(outputs.STRUT_LENGTH, row), Source(outputs.STRUT_RATE, row), spring, damper
    )

    if spring.is_linear:
        about, place = f"stiffness of {name}", Place("strut_stiffness", row)
        builder.add_parameters(dotted(name, "stiffness"), place, spring.stiffness, "N/m", about)
        about = f"length of {name} without force"
        about += "; left as it is, the length at the start of the run" * slack
        builder.add_parameters(dotted(name, "rest_length"), Place("strut_rest", row), spring.rest, "m", about)

    if damper.table < 0:
        about, place = f"damping of {name}", Place("strut_damping", row)
        builder.add_parameters(dotted(name, "damping"), place, damper.damping, "N.s/m", about)

    for output in force.output:
        quantity = STRUT_OUTPUTS[output]
        fed_by = [u] if output in FED_BY_INPUT and force.input else []
        source = Source(STRUT_KINDS[output], row)
        builder.add_outputs(
            dotted(name, output), source, quantity.unit, f"{quantity.text} of {name}", nodes, fed_by
        )


def _add_torsion(builder, name, force, ends):
    """A spring and a damper along the twist between two markers."""
    spec = force.torsion
    turn = builder.tables["n_turn"].add(turn_coordinate=builder.tables["n_coordinate"].length, turn_start=0.0)
    coordinate = builder.tables["n_coordinate"].add(
        coordinate_kind=TWIST,
        coordinate_body=0,
        coordinate_from=ends[0],
        coordinate_to=ends[1],
        coordinate_turn=turn,
        coordinate_end_frame=-1,
    )
    spring = spring_of(builder, spec.table, spec.stiffness, spec.rest_value())
    damper = damper_of(builder, spec.damping)
    row = add_along(builder, name, coordinate, spring, damper, ("rad", "N.m"), "damping")
    nodes = [builder.node_of(end) for end in force.between]

    for output in force.output:
        quantity = TORSION_OUTPUTS[output]
        source = Source(TORSION_KINDS[output], row if output in OF_SPRING else coordinate)
        builder.add_outputs(dotted(name, output), source, quantity.unit, f"{quantity.text} of {name}", nodes)


def _add_six_by_six(builder, name, force, ends):
    """A linear force or a bushing: a wrench by 6x6 matrices."""
    spec = getattr(force, force.kind)
    added, preload = spec.added_mass_matrix(), spec.preload_vector()
    stiffness = spec.stiffness_matrix()
    damping = spec.damping_matrix()
    row = builder.tables["n_six_by_six"].add(
        six_by_six_from=ends[0],
        six_by_six_to=ends[1],
        six_by_six_adds=bool(np.any(added)) and builder.marker_node(ends[1]) > 0,
        six_by_six_axes=AXES[spec.axes],
        six_by_six_stiffness=stiffness,
        six_by_six_damping=damping,
        six_by_six_added=added,
        six_by_six_preload=preload,
    )
    blocks = {
        "stiffness": ("six_by_six_stiffness", stiffness, ("N/m", "N/rad", "N", "N.m/rad")),
        "damping": ("six_by_six_damping", damping, ("N.s/m", "N.s/rad", "N.s", "N.m.s/rad")),
        "added_mass": ("six_by_six_added", added, ("kg", "kg.m", "kg.m", "kg.m2")),
    }

    for quantity, (array, matrix, units) in blocks.items():
        if np.any(matrix):
            unit = [units[2 * (j > 2) + (k > 2)] for j in range(6) for k in range(6)]
            about = f"{quantity.replace('_', ' ')} of {name} (x, y, z, rx, ry, rz)"
            builder.add_parameters(dotted(name, quantity), Place(array, row), matrix, unit, about)

    if np.any(preload):
        about = f"constant force and moment of {name}"
        builder.add_parameters(
            dotted(name, "preload"), Place("six_by_six_preload", row), preload, ["N"] * 3 + ["N.m"] * 3, about
        )

    _add_six_by_six_outputs(builder, name, force, row, ends)


def _add_six_by_six_outputs(builder, name, force, row, ends):
    nodes = [builder.node_of(end) for end in force.between]

    for output in force.output:
        quantity = SIX_BY_SIX_OUTPUTS[output]
        source = Source(SIX_BY_SIX_KINDS[output], *(ends if output == "displacement" else (row,)))
        builder.add_outputs(dotted(name, output), source, quantity.unit, f"{name}: {quantity.text}", nodes)


def _add_load(builder, name, load, ends):
    """A wrench on a marker, constant or over time."""
    spec, (marker,) = load.load, ends
    force, moment = spec.force_vector(), spec.moment_vector()
    tables = {"force": -1, "moment": -1}

    if spec.table:
        time, *columns = spec.table.points()

        for quantity, vectors in zip(tables, columns):
            if np.any(vectors):
                tables[quantity] = builder.tables_over_time(spec.table.interpolation, time, vectors)

    row = builder.tables["n_load"].add(
        load_marker=marker,
        load_axes=marker if spec.axes == "body" else 0,
        load_force_table=tables["force"],
        load_moment_table=tables["moment"],
        load_force=force,
        load_moment=moment,
    )

    for quantity, value, unit in (("force", force, "N"), ("moment", moment, "N.m")):
        if getattr(spec, quantity) is not None:
            about = f"{quantity} of {name}, in {'its own' if spec.axes == 'body' else 'inertial'} axes"
            builder.add_parameters(dotted(name, quantity), Place(f"load_{quantity}", row), value, unit, about)

    nodes = [builder.node_of(load.on)]

    for output in load.output:
        quantity = LOAD_OUTPUTS[output]
        about = f"{quantity.text} of {name} on the bodies"
        builder.add_outputs(
            dotted(name, output), Source(outputs.LOAD_POWER, row), quantity.unit, about, nodes
        )


ELEMENTS = {
    "spring_damper": _add_strut,
    "torsion": _add_torsion,
    "linear": _add_six_by_six,
    "bushing": _add_six_by_six,
    "load": _add_load,
}

# modules and functions of those that few scenes have: imported for these alone
RARE = {
    "hydrostatics": ("water", "add_hydrostatics"),
    "hydrodynamics": ("hydrodynamics", "add_hydrodynamics"),
    "catenary": ("lines", "add_catenary"),
    "rotor": ("wind", "add_rotor"),
    "member": ("water", "add_member"),
}
