"""What model exchange adds to the variables: states in the order of x = q | v | z (kernels/layout.py), rates, indicators of events."""

from dataclasses import dataclass, replace

import numpy as np

from ..kernels.joints.kinds import E_OFFSET, KINDS, N_Q, N_SLIDE, N_V
from ..kernels.motion import coordinates
from .dependencies import islands
from .end_frames import n_normal, parameter_units
from .variables import Variable, dotted, subscripts

# units of rates
RATES = {"m": "m/s", "rad": "rad/s", "m/s": "m/s2", "rad/s": "rad/s2", "m/s2": "m/s3", None: "1/s"}

MOST_DEPENDENCIES = 300_000
"""Of outputs on states, that a description may list; a larger model is for co-simulation only."""


@dataclass(frozen=True)
class _State:
    """One state: what it is an element of, its unit, its words, its size, the node whose it is (0: of none)."""

    array: str
    unit: str | None
    description: str
    nominal: float
    node: int = 0


def list_states(builder, length: float) -> list[_State]:
    """The states of a model in the making; `length`: m, size of its parts."""
    q, v = [], []

    for i, node in enumerate(builder.nodes[1:], 1):
        q += _positions(builder, i, node, length)
        v += _velocities(builder, i, node, length)

    return [*q, *v, *_parameters(builder, length), *_turns(builder), *_memories(builder)]


def _size(builder, array, first, n, least):
    """Size of n numbers that start with those of an array."""
    start = np.abs(np.asarray(builder.single[array], float)[first : first + n])
    return float(max(least, *start)) if n else least


def _positions(builder, i, node, length):
    """States of node i's joint among q."""
    kind, joint = KINDS[node.kind], node.joint or node.part or "ground"
    slides = N_Q[kind] if E_OFFSET[kind] < 0 and N_SLIDE[kind] else max(E_OFFSET[kind], 0)
    turns = N_Q[kind] - slides
    name = dotted(joint)
    size = _size(builder, "q_start", builder.q[i], slides, length)
    states = [_State(f"{name}.state_position", "m", f"position coordinate of {joint}", size, i)] * slides

    if E_OFFSET[kind] >= 0:
        about = f"Euler parameters of {joint}, scalar part last"
        return states + [_State(f"{name}.state_euler_parameters", None, about, 1.0, i)] * turns

    return states + [_State(f"{name}.state_angle", "rad", f"angle of {joint}", 1.0, i)] * turns


def _velocities(builder, i, node, length):
    """States of node i's joint among v."""
    kind, joint = KINDS[node.kind], node.joint or node.part or "ground"
    slides = N_SLIDE[kind]
    turns = N_V[kind] - slides
    name, first = dotted(joint), builder.v[i]
    size = _size(builder, "v_start", first, slides, length)
    spin = _size(builder, "v_start", first + slides, turns, 1.0)
    about = f"speed along the position coordinate of {joint}"
    about_spin = f"angular speed of {joint}" + (", in the axes of its body" if E_OFFSET[kind] >= 0 else "")
    return [_State(f"{name}.state_velocity", "m/s", about, size, i)] * slides + [
        _State(f"{name}.state_omega", "rad/s", about_spin, spin, i)
    ] * turns


def _parameters(builder, length):
    """Parameters of end frames on curves and surfaces, each with the unit vector that they are read off, if any."""
    states = []

    for name in builder.end_frames:
        joint = builder.scene.joint[name]

        for unit in parameter_units(builder, joint):
            size = length if unit == "m" else 1.0
            states.append(_State(f"{dotted(name)}.state_s", unit, f"parameter of {name}", size))

        about = f"unit vector along which the first surface of {name} is touched, in its marker's axes"
        states += [_State(f"{dotted(name)}.state_normal", None, about, 1.0)] * n_normal(builder, joint)

    return states


def _turns(builder):
    """Angles outside the tree, in the order of the coordinates that they belong to."""
    owner = {index: name for (name, _), index in builder.coordinates.items()}
    columns = builder.tables["n_turn"].columns
    kinds = builder.tables["n_coordinate"].columns.get("coordinate_kind", [])
    states = []

    for k in np.ravel(columns.get("turn_coordinate", [])):
        name = dotted(owner[k]) if k in owner else "state"
        twist = int(kinds[k][0]) == coordinates.TWIST
        about = f"{'twist' if twist else 'angle'} of {owner.get(k, 'a torsion spring')}, with its full turns"
        states.append(_State(f"{name}.state_turn", "rad", about, 1.0))

    return states


def _memories(builder):
    """States of the waves that bodies made."""
    tables, states = builder.tables, []
    of_marker = tables["n_marker"].columns["marker_body"]
    columns = tables["n_radiation"].columns
    known = set()

    for name, marker, first, count in zip(
        builder.radiations,
        *(columns.get(f"radiation_{word}", []) for word in ("marker", "memory", "memories")),
    ):
        # bodies that feel each other's waves share them
        if int(first[0]) in known:
            continue

        known.add(int(first[0]))
        about = f"memory of the waves that the body of {name} made"
        node = int(of_marker[int(marker[0])][0])
        states += [_State(f"{dotted(name)}.state_memory", "m/s2", about, 1.0, node)] * int(count[0])

    return states


def state_variables(states: list[_State]) -> list[Variable]:
    """Variables of the states, the elements of an array in a row; `index` is their place in x."""
    count = dict.fromkeys((state.array for state in states), 0)
    found = {array: [] for array in count}

    for state in states:
        count[state.array] += 1

    for index, state in enumerate(states):
        elements = found[state.array]
        ending = subscripts((count[state.array],))[len(elements)] if count[state.array] > 1 else ""
        name = state.array + ending
        elements.append(Variable(name, "state", "continuous", None, state.unit, state.description, index))

    return [variable for elements in found.values() for variable in elements]


def rate_variables(states: list[Variable]) -> list[Variable]:
    """Variables of the states' rates, in the same order."""
    return [
        replace(
            v,
            name=f"der({v.name})",
            causality="rate",
            unit=RATES[v.unit],
            description=f"rate of: {v.description}",
        )
        for v in states
    ]


def indicator_variables(builder) -> list[Variable]:
    """How far the coordinates of joints with stops are from these."""
    owner = {index: name for (name, _), index in builder.coordinates.items()}
    units = {parameter.name: parameter.unit for parameter in builder.parameters}
    found = []

    for k in np.ravel(builder.tables["n_stop"].columns.get("stop_coordinate", [])):
        joint = owner[int(k)]
        unit = units[dotted(joint, "stop", "stiffness")].split("/")[-1]

        for end, about in (("upper", "below its upper stop"), ("lower", "above its lower stop")):
            name = dotted(joint, "stop", f"to_{end}")
            about = f"how far {joint} is {about}"
            found.append(Variable(name, "indicator", "continuous", None, unit, about, len(found)))

    return found


def led_by(builder, states: list[_State]) -> list[tuple[int, ...]] | None:
    """For each output the places in x of the states that it may depend on: those of the bodies that joints, constraints and
    forces connect with what it is about. None where these lists are too long; one of all states beside no input is not written
    (`export.description`), so it does not count.
    """
    island = islands(builder.nodes, builder.constraint_nodes + builder.force_nodes)
    known, found, total = {}, [], 0

    for output in builder.outputs:
        key = frozenset(island[i] for i in output.nodes | output.moved_by)

        if key not in known:
            known[key] = tuple(k for k, s in enumerate(states) if s.node == 0 or island[s.node] in key)

        found.append(known[key])
        total += len(known[key]) if builder.inputs or len(known[key]) < len(states) else 0

    return found if total <= MOST_DEPENDENCIES else None
