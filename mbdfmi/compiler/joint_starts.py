"""How joints start: start values as parameters, and what of them is told where it cannot be kept."""

from ..kernels import notes
from ..scene.starts import ENDINGS
from .builder import Place, Told
from .drives import driven_coordinates
from .joint_kinds import kind_of, led_too, scalars
from .start import position_at_start
from .variables import dotted

TOLD = {
    "position": (notes.PLACE, notes.MARKER_PLACE),
    "orientation": (notes.ORIENTATION, notes.MARKER_ORIENTATION),
    "velocity": (notes.VELOCITY, notes.MARKER_VELOCITY),
    "omega": (notes.OMEGA, notes.MARKER_OMEGA),
}
"""By what is told, of a joint in the tree and of one outside it."""


def add_start(builder, name, joint):
    """Start values of a joint in the tree as parameters."""
    if kind_of(joint).is_pose:
        _add_pose_start(builder, name, joint, builder.joint_nodes[name][0])
        return

    q, v = joint.start_position(), joint.start_velocity()
    driven = driven_coordinates(builder, name, joint) if joint.driver else []
    q = [position_at_start(of.driver, of.start[0]) for of in driven] or led_too(joint, q)
    v = led_too(joint, v)
    led = kind_of(joint).led(joint)

    for k, (i, (coordinate, ending)) in enumerate(zip(builder.joint_nodes[name], scalars(joint))):
        builder.single["q_start"][builder.q[i]] = q[k]
        builder.single["v_start"][builder.v[i]] = v[k]

        if joint.driver or k in led:
            continue

        for quantity, array, at, value in (
            (coordinate.position, "q_start", builder.q[i], q[k]),
            (coordinate.rate, "v_start", builder.v[i], v[k]),
        ):
            variable = dotted(name, f"{quantity.name}_start") + ending
            builder.add_start(
                variable, Place(array, at), value, quantity.unit, f"{quantity.text} of {name} at the start", i
            )


def _add_pose_start(builder, name, joint, i):
    """The same of a spherical or free joint; i: its node."""
    q, v = joint.start_position(), joint.start_velocity()
    builder.single["q_start"][builder.q[i] : builder.q[i] + len(q)] = q
    builder.single["v_start"][builder.v[i] : builder.v[i] + len(v)] = v
    positions = [coordinate.position for coordinate in joint.coordinates]
    rates = [coordinate.rate for coordinate in joint.coordinates]

    for array, at, values, quantities in (
        ("q_start", builder.q[i], q, positions),
        ("v_start", builder.v[i], v, rates),
    ):
        for quantity in quantities:
            about = f"{quantity.text.rstrip(',')} of {name} at the start"
            size = quantity.width
            builder.add_start(
                dotted(name, f"{quantity.name}_start"),
                Place(array, at),
                values[:size],
                quantity.unit,
                about,
                i,
            )

            if quantity.name == "euler_parameters":
                builder.add_zyx(dotted(name, "zyx_start"), name, i, values[:size])

            values = values[size:]
            at += size


def tell_start(builder, name, joint):
    """What was given of the start, so that it can be told where it is not kept."""
    if kind_of(joint).is_pose:
        _tell_pose(builder, name, joint)
        return

    in_tree = name in builder.joint_nodes and not builder.starts_elsewhere
    led = kind_of(joint).led(joint)

    for which, written, start in (
        (0, joint.given_position(), joint.start_position),
        (1, joint.given_velocity(), joint.start_velocity),
    ):
        if not any(ending is not None for ending in written):
            continue

        values = led_too(joint, start())

        for k, (ending, (coordinate, index)) in enumerate(zip(written, scalars(joint))):
            if ending is None or k in led:
                continue

            if in_tree:
                told = Told((notes.POSITION, notes.SPEED)[which], builder.joint_nodes[name][k])
            else:
                told = Told((notes.COORDINATE, notes.RATE)[which], builder.coordinate(name, k))

            text = _told_name(coordinate[which].name + index, name, ending)
            builder.tell(told, text, values[k], ENDINGS[ending])


def _tell_pose(builder, name, joint):
    """The same of a spherical or free joint."""
    ends = [builder.marker(end) for end in joint.between]
    in_tree = name in builder.joint_nodes and not builder.starts_elsewhere
    node = builder.joint_nodes[name][0] if in_tree else None
    q, v = joint.start_position(), joint.start_velocity()
    A = joint.start.rotation()

    for which, written, values in ((0, joint.given_position(), q), (1, joint.given_velocity(), v)):
        for k, ending in enumerate(written):
            turns = k >= len(written) - 3
            quantity = joint.coordinates[-1 if turns else 0][which].name.replace(
                "euler_parameters", "orientation"
            )

            # an orientation is told as a whole
            if ending is None or (quantity == "orientation" and k > len(written) - 3):
                continue

            kind = TOLD[quantity][node is None]
            text, value, unit = f"{quantity}[{k % 3 + 1}]", values[k], 1.0

            if quantity == "orientation":
                text, value, unit = quantity, values[-4:], ENDINGS["_deg"]
            elif quantity == "omega" and ending == "_body":
                value = A.inv().apply(v[-3:])[k % 3]
                kind = notes.MARKER_OMEGA_BODY if node is None else kind

            told = Told(kind, *ends, k % 3) if node is None else Told(kind, node, component=k % 3)
            builder.tell(told, _told_name(text, name, ""), value, unit)


def _told_name(quantity, joint, ending):
    """What a message calls a start value."""
    unit = {"_deg": " in deg", "_rpm": " in rpm"}.get(ending, "")
    unit = " in deg/s" if ending == "_deg" and "speed" in quantity else unit
    return f"the {quantity.replace('_', ' ')} of {joint}{unit}"
