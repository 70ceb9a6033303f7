"""Constraints on joint coordinates: couplings, screws, drives of joints that close loops."""

from ..kernels import outputs
from ..kernels.dynamics import rows
from ..vocabulary import COUPLING_OUTPUTS
from .builder import Constraint, Source
from .joint_kinds import kind_of, units_along
from .variables import dotted


def drive_constraints(builder):
    """Constraints of driven joints that close loops: one row on the joint's coordinate each."""
    return [
        _coordinate_constraint(builder, name, [(builder.coordinate(name), 1.0)], drive=drive)
        for name, drive in builder.driven_cuts.items()
    ]


def coupling_constraints(builder):
    """Couplings, and coordinates that follow others in their own joint, as those of screws."""
    constraints = []

    for name, coupling in builder.scene.coupling.items():
        terms = [(builder.coordinate(joint), factor) for joint, factor in coupling.terms]
        at_start = coupling.offset is None
        constraints.append(
            _coordinate_constraint(builder, name, terms, offset=coupling.offset or 0.0, at_start=at_start)
        )

    for name, joint in builder.scene.joint.items():
        for k, (other, ratio) in kind_of(joint).led(joint).items():
            terms = [(builder.coordinate(name, k), 1.0), (builder.coordinate(name, other), -ratio)]
            constraints.append(_coordinate_constraint(builder, name, terms))

    return constraints


def add_coupling_outputs(builder):
    """Efforts of couplings in their joints, once the rows are known."""
    columns = builder.tables["n_constraint"].columns

    for name, coupling in builder.scene.coupling.items():
        for output in coupling.output:
            c = next(c for c, owner in enumerate(builder.constraint_names) if owner == name)
            row = int(columns["constraint_row"][c][0])

            for side, joint in enumerate(coupling.between):
                _, unit = units_along(builder.scene.joint[joint])
                about = f"{COUPLING_OUTPUTS[output].text} of {name} on the second marker of {joint}"
                variable = f"{dotted(name, output)}[{side + 1}]"
                source = Source(outputs.COUPLING_EFFORT, row, side)
                builder.add_outputs(variable, source, unit, about, builder.constraint_nodes[c])


def coordinate_ends(builder, k):
    """(node, markers) of coordinate k: the node whose joint it is, or 0 and the markers between which it closes a loop."""
    columns = builder.tables["n_coordinate"].columns
    node, a, b = (
        int(columns[name][k][0]) for name in ("coordinate_body", "coordinate_from", "coordinate_to")
    )
    return node, (a, b)


def _coordinate_constraint(builder, name, terms, **more):
    """A constraint of one row on joint coordinates; terms : (coordinate, factor) of each; `more` of it."""
    ends = [coordinate_ends(builder, k) for k, _ in terms]
    nodes = []

    for node, markers in ends:
        nodes += [node] if node else [builder.marker_node(marker) for marker in markers]

    return Constraint(name, ends[0][1], nodes, [(rows.COUPLING, -1, -1)], terms=tuple(terms), **more)
