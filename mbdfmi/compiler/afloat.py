"""Whether what carries a body and what waves do to it are of one hull: in the longest waves both are rho g times the waterplane."""

import numpy as np

from ..hydro.consistency import long_waves_lift
from ..scene.ends import stands_still
from ..scene.sea import Sea
from ..vectors import dot
from .hulls import hull_of
from .start import start_pose

# parts by which the two may differ, beside what the file leaves open
APART = 0.05
DOUBTS = 2.0


def tell_other_waterplane(builder, name, force, coefficients):
    """A notice of bodies whose stiffness in heave, of all that carries them, is not what long waves lift them by."""
    for j, end in enumerate(force.between):
        lift = long_waves_lift(coefficients, j)
        stiffness, by = _heave_stiffness(builder, builder.node_of(end))

        if lift is None or not stiffness > 0.0 or not lift[0] > 0.0:
            continue

        off = abs(lift[0] - stiffness)

        if off > APART * stiffness + DOUBTS * lift[1]:
            text = (
                f"the longest waves lift {end} by {lift[0]:.4g} N a metre, and {' and '.join(by)} by {stiffness:.4g}: both are rho g times "
                f"the area at the water plane, and {100 * off / stiffness:.3g} % apart; another hull, another scale, or another density?"
            )
            builder.notice(("force", name, "hydrodynamics", "file"), text)


def _heave_stiffness(builder, node):
    """(N/m, names of the forces that make it) of what carries a node from the ground where it starts."""
    total, by = 0.0, []

    for name, force in builder.scene.force.items():
        found = 0.0

        if (
            force.kind == "linear"
            and builder.node_of(force.between[1]) == node
            and stands_still(force.between[0])
        ):
            found = float(force.linear.stiffness_matrix()[2, 2])
        elif force.kind == "hydrostatics" and builder.node_of(force.on) == node:
            density = (builder.scene.sea or Sea()).density
            found = density * -builder.scene.gravity[2] * _waterplane(builder, force)

        if found:
            total, by = total + found, [*by, name]

    return total, by


def _waterplane(builder, force):
    """m2, of a hull at z = 0 where it starts: what its wet faces do not close, seen from above."""
    position, A = force.hydrostatics.pose()
    points, polygons = hull_of(force.hydrostatics)
    place, turned = start_pose(builder, force.on)
    corners = place + dot(position + dot(np.asarray(points), A.T), turned.T)
    return -sum(_seen_from_above(_under(corners[list(polygon)])) for polygon in polygons)


def _under(corners):
    """Corners (n, 3) of what of a polygon is under z = 0."""
    found = []

    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        if a[2] <= 0.0:
            found.append(a)
        if (a[2] <= 0.0) != (b[2] <= 0.0):
            found.append(a + a[2] / (a[2] - b[2]) * (b - a))

    return np.array(found).reshape(-1, 3)


def _seen_from_above(corners):
    """m2, of a polygon's corners (n, 3), positive where it turns left."""
    x, y = corners[:, 0], corners[:, 1]
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
