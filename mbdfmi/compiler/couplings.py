"""Constraints on one or two joint coordinates: couplings, screws, drives of joints that close loops."""

from ..kernels import outputs
from ..kernels.dynamics import rows
from ..vocabulary import COUPLING_OUTPUTS
from .builder import Constraint, Source
from .joint_kinds import kind_of, units_along
from .variables import dotted


def drive_constraints(builder):
    """Constraints of driven joints that close loops: one row on the joint's coordinate each."""
    return [
        _coordinate_constraint(builder, name, [builder.coordinate(name), -1], (1.0, 0.0), drive=drive)
        for name, drive in builder.driven_cuts.items()
    ]


def coupling_constraints(builder):
    """Couplings, and coordinates that follow others in their own joint, as those of screws."""
    constraints = []

    for name, coupling in builder.scene.coupling.items():
        first, second = coupling.between
        pair = [builder.coordinate(first), builder.coordinate(second)]
        at_start = coupling.offset is None
        constraints.append(
            _coordinate_constraint(
                builder, name, pair, (coupling.ratio, -1.0), coupling.offset or 0.0, at_start=at_start
            )
        )

    for name, joint in builder.scene.joint.items():
        for k, (other, ratio) in kind_of(joint).led(joint).items():
            pair = [builder.coordinate(name, k), builder.coordinate(name, other)]
            constraints.append(_coordinate_constraint(builder, name, pair, (1.0, -ratio)))

    return constraints


def add_coupling_outputs(builder):
    """Efforts of couplings in their two joints, once the rows are known."""
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


def _coordinate_constraint(builder, name, pair, factors, offset=0.0, **more):
    """A constraint of one row on one or two joint coordinates; `more` of it."""
    markers, nodes = [], []
    columns = builder.tables["n_coordinate"].columns

    for k in pair:
        here = [0, 0] if k >= 0 else [-1, -1]

        if k >= 0:
            body = int(columns["coordinate_body"][k][0])

            if body > 0:
                nodes.append(body)
            else:
                here = [int(columns[name][k][0]) for name in ("coordinate_from", "coordinate_to")]
                nodes += [builder.marker_node(marker) for marker in here]

        markers += here

    # a second coordinate in the tree has no markers
    if markers[2:] == [0, 0]:
        markers[2:] = [-1, -1]

    return Constraint(name, tuple(markers), nodes, [(rows.COUPLING, *pair)], factors, offset, **more)
