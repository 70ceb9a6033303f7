"""Joints that close loops, rolling and couplings as rows, in an order that keeps their factor sparse."""

from ..kernels.dynamics import rows
from ..kernels.joints import KINDS, N_V
from ..vectors import norm
from .builder import Constraint, Place
from .couplings import coordinate_ends, coupling_constraints, drive_constraints
from .elimination import elimination, neighbours
from .joint_kinds import kind_of
from .start import start_pose


def add_constraints(builder):
    """All constraints of the scene, and the arrays that their factor needs."""
    constraints = [_joint_constraint(builder, name) for name in builder.tree.cuts]
    constraints += drive_constraints(builder) + coupling_constraints(builder)
    constraints = [c for c in constraints if c.rows]

    if not constraints:
        return

    # the joint-space mass matrix spreads every row over all coordinates
    every = list(range(1, len(builder.nodes)))
    path = [every if builder.embeds else _path(builder, c) for c in constraints]
    free = [[i for i in nodes if i not in builder.drive_of] for nodes in path]
    order, earlier = elimination(neighbours(free))
    constraints = [constraints[k] for k in order]
    builder.constraint_names = [c.name for c in constraints]
    builder.constraint_nodes = [c.nodes for c in constraints]
    builder.joint_constraints = {c.name: k for k, c in enumerate(constraints) if not c.terms}
    _add_tables(builder, constraints, [path[k] for k in order], earlier)
    everywhere = _not_given(builder, builder.tree.cuts)
    builder.loop_hints = [_hint(builder, c) or everywhere for c in constraints]
    about = "largest gap of a closed loop, m and rad"
    builder.add_parameters(
        "solver.closing_tolerance",
        Place("closing_tolerance"),
        builder.scene.solver.closing_tolerance,
        None,
        about,
    )

    for c in constraints:
        of_velocity = all(kind == rows.KNIFE for kind, _, _ in c.rows)
        nodes = _involved(builder, c)
        builder.restricted[0].update(set() if of_velocity or c.at_start else nodes)
        builder.restricted[1].update(nodes)


def _involved(builder, constraint):
    """Nodes whose joints a constraint is about: those between its ends, and joints that it couples."""
    nodes = set()
    ends = [coordinate_ends(builder, k) for k, _ in constraint.terms] or [(0, constraint.markers)]

    for node, markers in ends:
        if node:
            nodes.add(node)
        else:
            a, b = (set(_way(builder, builder.marker_node(marker))) for marker in markers)
            nodes |= a ^ b

    return nodes - set(builder.drive_of)


def _way(builder, i):
    """Node i and those between it and the ground."""
    while i > 0:
        yield i
        i = builder.nodes[i].parent


def _hint(builder, constraint):
    """Whose starts matter to a constraint that cannot be closed; "" where no joint of the tree is involved."""
    names = dict.fromkeys(
        builder.nodes[i].joint for i in sorted(_involved(builder, constraint)) if builder.nodes[i].joint
    )
    return _not_given(builder, names) if names else ""


def _not_given(builder, names):
    """Those of some joints whose starts are not given, if there are, else all, in words."""
    free = [name for name in names if not builder.scene.joint[name].holds_position]
    return f"of {', '.join(free or names)}" if names else "none of its joints can move"


def _joint_constraint(builder, name):
    """A joint outside the tree as a constraint."""
    joint = builder.scene.joint[name]
    kind = kind_of(joint)
    value = kind.value(joint)
    at_start = value is None

    if at_start:
        first, second = (start_pose(builder, end)[0] for end in joint.between)
        value = norm(second - first) or 1.0

    # of an end frame on a curve or surface: which it is
    end_frame = builder.end_frames.get(name, 0)
    markers = [builder.joint_marker(name, side, turn) for side, turn in enumerate(kind.turns(joint))]

    return Constraint(
        name=name,
        markers=(markers[0], markers[1]),
        nodes=builder.nodes_of(name),
        rows=[
            (row, i, end_frame if row in (rows.CONTACT, rows.FRAME, rows.SLIP) else j)
            for row, i, j in builder.tree.rows_of(joint)
        ],
        value=value,
        at_start=at_start,
    )


def _path(builder, constraint):
    """Nodes between a constraint and the ground, ascending; none where it is between parts of one rigid body."""
    path = set()

    if len({_rigid_part(builder, i) for i in constraint.nodes}) == 1 and not constraint.terms:
        return []

    for i in constraint.nodes:
        while i > 0:
            path.add(i)
            i = builder.nodes[i].parent

    return sorted(path)


def _rigid_part(builder, i):
    """The node that leads a rigid part of the tree, of which node i is one."""
    while builder.nodes[i].kind == "fixed":
        i = builder.nodes[i].parent

    return i


def _add_tables(builder, constraints, paths, earlier):
    """Tables of the constraints, in their order of elimination.

    Two arrays of the kernels are laid out here: whitened responses, one block a constraint of its rows by the velocities of its
    path (`response`); and the factor of C M^-1 C^T, by block rows: of each constraint a block with each earlier neighbour,
    then its own (`block`).
    """
    n_v = {i: N_V[KINDS[node.kind]] for i, node in enumerate(builder.nodes) if i}
    size = [len(constraint.rows) for constraint in constraints]
    response = block = row = 0

    for c, (constraint, path) in enumerate(zip(constraints, paths)):
        width = sum(n_v[i] for i in path)
        first_neighbour = builder.tables["n_neighbour"].length

        for e in earlier[c]:
            builder.tables["n_neighbour"].add(neighbour_constraint=e, neighbour_block=block)
            block += size[c] * size[e]

        builder.tables["n_constraint"].add(
            constraint_from=constraint.markers[0],
            constraint_to=constraint.markers[1],
            constraint_row=row,
            constraint_rows=size[c],
            constraint_path=builder.tables["n_path"].length,
            constraint_paths=len(path),
            constraint_response=response,
            constraint_width=width,
            constraint_neighbour=first_neighbour,
            constraint_neighbours=len(earlier[c]),
            constraint_block=block,
        )
        _add_path(builder, path, n_v)
        _add_rows(builder, c, constraint)
        block += size[c] ** 2
        response += size[c] * width
        row += size[c]

    builder.counts |= {"n_response": response, "n_factor": block}


def _add_path(builder, path, n_v):
    """Nodes of a constraint's path, and where their velocities stand among those of the path."""
    at = 0

    for i in path:
        builder.tables["n_path"].add(path_node=i, path_at=at)
        at += n_v[i]


def _add_rows(builder, c, constraint):
    """The rows of constraint c."""
    # how many products of axes there are tells which axes they keep parallel
    parallel = max(0, sum(kind in (rows.DOT, rows.FRAME) for kind, _, _ in constraint.rows) - 1)

    first_term = builder.tables["n_term"].length

    for coordinate, factor in constraint.terms:
        builder.tables["n_term"].add(term_coordinate=coordinate, term_factor=factor)

    for kind, i, j in constraint.rows:
        builder.tables["n_row"].add(
            row_constraint=c,
            row_kind=kind,
            row_i=i,
            row_j=j,
            row_value=constraint.value,
            row_term=first_term,
            row_terms=len(constraint.terms),
            row_offset=constraint.offset,
            row_drive=constraint.drive,
            row_at_start=constraint.at_start,
            row_parallel=parallel if kind in (rows.DOT, rows.FRAME) else 0,
        )
