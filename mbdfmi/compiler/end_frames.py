"""Curves and surfaces of markers, and the joints whose end frames are on them."""

import numpy as np

from ..kernels import notes, outputs
from ..kernels.end_frames import curves, surfaces, touching
from ..kernels.math import tables
from ..lazily import scipy
from ..scene import Problem, SceneError
from ..vocabulary import CONTACT_OUTPUTS, END_FRAME_AXES, PARAMETER_EFFORTS, PARAMETERS, parameter_of
from .builder import Place, Source, Told
from .sides import default_side, side_of, spline_of
from .start import start_position
from .variables import dotted


def add_end_frames(builder):
    """All end frames on curves and surfaces, and these."""
    builder.single["s_start"] = []

    for name, joint in builder.scene.joint.items():
        if joint.kind in touching.KINDS:
            builder.end_frames[name] = _add_end_frame(builder, name, joint)


def _add_end_frame(builder, name, joint):
    """Index of the end frame of a joint: its place on one shape, or where two touch."""
    _check_lines(builder, name, joint)
    shapes = [_shape(builder, end, what) for end, what in zip(joint.between, joint.shapes)]

    if joint.kind == "frame_on_curve":
        curve = builder.scene.marker(joint.between[0]).curve
        builder.tables["n_curve"].columns["curve_side"][shapes[0]][:] = side_of(name, joint, curve)

    first = len(builder.single["s_start"])
    units = parameter_units(builder, joint)
    given = joint.start_s is not None
    start = joint.start_s if given else ()
    start = [start_position(joint)] if joint.driver else start
    turning = n_normal(builder, joint)
    builder.single["s_start"] += [*start, *np.zeros(len(units) + turning - len(start))]

    if given and not joint.driver:
        endings = [""] if len(units) == 1 else [f"[{k + 1}]" for k in range(len(units))]

        for k, (value, unit, ending) in enumerate(zip(start, units, endings)):
            about = f"parameter of {name} at the start"
            variable = dotted(name, "s_start") + ending
            builder.add_parameters(variable, Place("s_start", first + k), value, unit, about, "fixed")
            builder.tell(Told(notes.PARAMETER, first + k), f"the parameter s{ending} of {name}", 0.0)

    row = builder.tables["n_end_frame"].add(
        end_frame_kind=touching.KINDS[joint.kind],
        end_frame_a=builder.joint_marker(name, 0, np.eye(3)),
        end_frame_b=builder.joint_marker(name, 1, np.eye(3)),
        end_frame_from=shapes[0],
        end_frame_to=shapes[1],
        end_frame_z=first,
        end_frame_given=given or joint.driver is not None,
    )
    _watch_ends(builder, name, row, joint, shapes)
    return row


def _watch_ends(builder, name, row, joint, shapes):
    """Watch for the ends of splines and of tables of surfaces, beyond which these are straight."""
    units = parameter_units(builder, joint)
    k = 0

    for shape, index, end in zip(joint.shapes, shapes, joint.between):
        count = {"curve": 1, "surface": 2}.get(shape, 0)
        names = [f"s[{i + 1}]" if len(units) > 1 else "s" for i in range(k, k + count)]
        sources = [Source(outputs.CONTACT_S, row, i) for i in range(k, k + count)]

        curve = _open_spline(builder, shape, index, end)

        if curve >= 0:
            first = builder.tables["n_curve"].columns["curve_table"][curve].item()
            builder.watch(dotted(name, names[0]), units[k], sources[0], first, first + 1, first + 2)
        elif shape == "surface" and builder.scene.marker(end).surface.kind == "table":
            for i, table in enumerate(builder.tables["n_surface"].columns["surface_table"][index]):
                builder.watch(dotted(name, names[i]), units[k + i], sources[i], int(table), edges=1)

        k += count


def _open_spline(builder, shape, index, end):
    """Index of the curve along a first parameter that is a spline with ends; -1 where there is none."""
    if shape not in ("curve", "surface"):
        return -1

    curve = getattr(builder.scene.marker(end), shape)

    if curve.kind == "prism":
        curve, index = curve.profile, builder.tables["n_surface"].columns["surface_curve"][index].item()

    return index if getattr(curve, "closed", True) is False else -1


def n_normal(builder, joint):
    """How many numbers a round first surface takes after its parameters: the unit vector that these are read off."""
    round_first = joint.shapes[0] == "surface" and builder.scene.marker(joint.between[0]).surface.semi_axes
    return 3 if round_first else 0


def _check_lines(builder, name, joint):
    """Raises SceneError where two lines are to touch: they would do so everywhere."""
    if joint.kind != "curve_on_curve":
        return

    if all(builder.scene.marker(end).curve.kind == "line" for end in joint.between):
        text = (
            "two straight lines touch everywhere or nowhere; use a planar joint, or point_on_line "
            "at two points"
        )
        raise SceneError([Problem(("joint", name, "between"), text)])


def _shape(builder, end, what):
    """Index of the curve or surface of a marker; -1 where none is needed."""
    if what == "curve":
        return _add_curve(builder, builder.scene.marker(end).curve)

    if what == "surface":
        return _add_surface(builder, builder.scene.marker(end).surface)

    return -1


def _add_curve(builder, curve):
    """Index of a curve."""
    kind = curves.KINDS[curve.kind]
    row = dict(curve_kind=kind, curve_table=0, curve_value=0.0, curve_side=(0.0, 0.0, 1.0), curve_size=0.0)

    if kind == curves.SPLINE:
        points, s = curve.points, curve.s
        spline = spline_of(curve)
        row["curve_table"] = builder.tables["n_table"].length
        row["curve_size"] = np.linalg.norm(points, axis=1).max()

        for component in range(3):
            builder.table(scipy.interpolate.PPoly(spline.c[:, :, component], spline.x), tables.LINEAR)

        if curve.closed:
            row["curve_value"] = s[-1] - s[0]

        row["curve_side"] = default_side(curve)

    elif kind == curves.CIRCLE:
        row |= {"curve_value": curve.radius, "curve_size": curve.radius}
    elif kind == curves.CYCLOID:
        row["curve_value"] = curve.radius
    elif kind == curves.PARABOLA:
        row["curve_value"] = curve.coefficient

    return builder.tables["n_curve"].add(**row)


def _add_surface(builder, surface):
    """Index of a surface."""
    kind = surfaces.KINDS[surface.kind]
    row = dict(
        surface_kind=kind,
        surface_curve=0,
        surface_table=(0, 0),
        surface_patch=0,
        surface_value=(0.0, 0.0, 0.0),
    )

    if kind == surfaces.PRISM:
        row["surface_curve"] = _add_curve(builder, surface.profile)
    elif kind == surfaces.TORUS:
        row["surface_value"] = surface.radius, surface.tube, 0.0
    elif kind == surfaces.CYLINDER:
        row["surface_value"] = surface.radius, 0.0, 0.0
    elif surface.semi_axes:
        row["surface_value"] = surface.semi_axes
    elif kind == surfaces.TABLE:
        row |= _add_patches(builder, surface)

    return builder.tables["n_surface"].add(**row)


def _add_patches(builder, surface):
    """Bicubic patches through a grid of points, with a frame of straight ones around it."""
    spline = scipy.interpolate.CubicSpline(surface.s1, surface.points)
    edges1, across = _with_straight_ends(spline.x, spline.c)
    spline = scipy.interpolate.CubicSpline(surface.s2, across, axis=2)
    edges2, along = _with_straight_ends(spline.x, spline.c)

    # from (power of s2, patch by s2, power of s1, patch by s1, component), highest powers first
    patches = along[::-1, :, ::-1].transpose(3, 1, 4, 2, 0)
    first = builder.tables["n_patch"].length

    for coefficients in patches.reshape(-1, 48):
        builder.tables["n_patch"].add(patch_c=coefficients)

    edges = [
        builder.table(scipy.interpolate.PPoly(np.zeros((1, len(x) - 1)), x), tables.LINEAR)
        for x in (edges1, edges2)
    ]
    return {"surface_patch": first, "surface_table": edges}


def _with_straight_ends(x, c):
    """A spline's breakpoints (n + 1,) and coefficients (4, n, ...), with a straight piece more
    at both ends.
    """
    width = (x[-1] - x[0]) / (len(x) - 1)
    h = x[-1] - x[-2]
    left, right = np.zeros((2, 4, 1, *c.shape[2:]))
    left[2, 0] = c[2, 0]
    left[3, 0] = c[3, 0] - width * c[2, 0]
    right[2, 0] = c[2, -1] + h * (2.0 * c[1, -1] + 3.0 * h * c[0, -1])
    right[3, 0] = c[3, -1] + h * (c[2, -1] + h * (c[1, -1] + h * c[0, -1]))
    return np.concatenate([[x[0] - width], x, [x[-1] + width]]), np.concatenate([left, c, right], axis=1)


def add_parameter_outputs(builder, name, joint, output):
    """Parameters of an end frame, or their rates."""
    units = parameter_units(builder, joint)
    kind = outputs.CONTACT_S if output == "s" else outputs.CONTACT_RATE
    nodes = builder.nodes_of(name)

    for k, unit in enumerate(units):
        if output == "s_rate":
            unit = f"{unit}/s" if unit else "1/s"

        ending = f"[{k + 1}]" if len(units) > 1 else ""
        about = f"{PARAMETERS[output].text} of {name}"
        builder.add_outputs(
            dotted(name, output) + ending, Source(kind, builder.end_frames[name], k), unit, about, nodes
        )


def add_parameter_effort(builder, name, joint, output):
    """What drives the parameter of a curve along it, or its power."""
    kind = outputs.DRIVE_EFFORT if output == "effort" else outputs.DRIVEN_JOINT_POWER
    unit = parameter_of(parameter_units(builder, joint)[0]).effort.unit if output == "effort" else "W"
    about = f"{PARAMETER_EFFORTS[output].text} of {name}, along its parameter"
    source = Source(kind, builder.coordinate(name))
    builder.add_outputs(dotted(name, output), source, unit, about, builder.nodes_of(name))


def add_axis_output(builder, name, output):
    """An axis of an end frame."""
    about = f"{END_FRAME_AXES[output].text} of {name}, in its first marker's axes"
    source = Source(outputs.END_FRAME_AXIS, builder.end_frames[name], list(END_FRAME_AXES).index(output))
    builder.add_outputs(dotted(name, output), source, None, about, builder.nodes_of(name))


CONTACT_KINDS = {
    "contact_point": outputs.CONTACT_POINT,
    "normal_force": outputs.NORMAL_FORCE,
    "friction_force": outputs.FRICTION_FORCE,
}


def add_contact_output(builder, name, output):
    """Where two surfaces touch, or what one does there to the other."""
    quantity = CONTACT_OUTPUTS[output]
    source = Source(CONTACT_KINDS[output], builder.end_frames[name], builder.reaction(name))
    about = f"{quantity.text} of {name}"
    builder.add_outputs(dotted(name, output), source, quantity.unit, about, builder.nodes_of(name))


def parameter_units(builder, joint):
    """Unit of each parameter of an end frame's joint; None where the user gave them."""
    units = []

    for end, shape in zip(joint.between, joint.shapes):
        if shape == "curve":
            units.append(builder.scene.marker(end).curve.unit)
        elif shape == "surface":
            units += builder.scene.marker(end).surface.units

    return units
