"""Force elements between two markers."""

import numpy as np

from ..kernels import outputs
from ..variables import dotted
from .start import start_pose


def add_forces(builder):
    """All force elements of the scene."""
    for name, force in builder.scene.force.items():
        ends = [builder.marker(end) for end in force.between]

        if force.kind == "linear":
            _add_linear(builder, name, force.linear, ends)
        else:
            _add_strut(builder, name, force, ends)


def _add_strut(builder, name, force, ends):
    """A spring-damper along the line between two markers."""
    spec = force.spring_damper
    rest = spec.rest_length

    if rest is None:
        first, second = (start_pose(builder, end)[0] for end in force.between)
        rest = float(np.linalg.norm(second - first))

    row = builder.tables["n_strut"].add(
        strut_from=ends[0],
        strut_to=ends[1],
        strut_stiffness=spec.stiffness,
        strut_damping=spec.damping,
        strut_rest=rest,
    )
    about = f"stiffness of {name}"
    builder.add_parameters(dotted(name, "stiffness"), "strut_stiffness", row, spec.stiffness, "N/m", about)
    about = f"damping of {name}"
    builder.add_parameters(dotted(name, "damping"), "strut_damping", row, spec.damping, "N.s/m", about)
    about = f"length of {name} without force"
    builder.add_parameters(dotted(name, "rest_length"), "strut_rest", row, rest, "m", about)
    nodes = [builder.node_of(end) for end in force.between]

    for output in force.output:
        kind = outputs.STRUT_LENGTH if output == "length" else outputs.STRUT_FORCE
        unit, about = ("m", "length") if output == "length" else ("N", "tension")
        builder.add_outputs(dotted(name, output), kind, unit, f"{about} of {name}", nodes, row)


def _add_linear(builder, name, spec, ends):
    """A 6x6 force."""
    stiffness = spec.stiffness_matrix()
    damping = spec.damping_matrix()
    added = spec.added_mass_matrix()
    preload = spec.preload_vector()
    row = builder.tables["n_linear"].add(
        linear_from=ends[0],
        linear_to=ends[1],
        linear_adds=bool(np.any(added)),
        linear_stiffness=stiffness,
        linear_damping=damping,
        linear_added=added,
        linear_preload=preload,
    )
    blocks = {
        "stiffness": ("linear_stiffness", stiffness, ("N/m", "N/rad", "N", "N.m/rad")),
        "damping": ("linear_damping", damping, ("N.s/m", "N.s/rad", "N.s", "N.m.s/rad")),
        "added_mass": ("linear_added", added, ("kg", "kg.m", "kg.m", "kg.m2")),
    }

    for quantity, (array, matrix, units) in blocks.items():
        if np.any(matrix):
            unit = [units[2 * (j > 2) + (k > 2)] for j in range(6) for k in range(6)]
            about = f"{quantity.replace('_', ' ')} of {name} (x, y, z, rx, ry, rz)"
            builder.add_parameters(dotted(name, quantity), array, row, matrix, unit, about)

    if np.any(preload):
        about = f"constant force and moment of {name}"
        builder.add_parameters(
            dotted(name, "preload"), "linear_preload", row, preload, ["N"] * 3 + ["N.m"] * 3, about
        )
