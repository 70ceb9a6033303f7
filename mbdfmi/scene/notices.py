"""What is odd in a scene but may be meant: it runs, and whoever runs it is told.

Each of `RULES` takes a valid scene and yields a `Problem` (where, and what) for each thing it finds odd. They are told by
`mbdfmi check`, `info`, `simulate`, as `scene.notices`, in `Results.notices`, and as warnings in the log of an FMU when its
initialisation ends. Of what the compiler or the kernels do with a scene: `Builder.notice`, `kernels/status.py`.
"""

from functools import cache
from math import hypot, pi

import numpy as np

from ..steppers import STEPPERS
from ..vectors import norm
from . import weather
from .bodies import MOMENTS_ROUNDED, inertia_matrix, principal_moments
from .errors import Problem, show
from .fields import Part

# how much longer a body is than the next shorter one when one of them may be in other units: mm for m is 1000
JUMP = 300.0

# m/s or rad/s, a smoothing speed of friction below which sticking is stiff
SHARP = 1e-4


def far_angles(scene):
    """Angles given in rad that read like degrees: beyond a full turn, and whole or halves."""
    for path, part in _parts(scene):
        for key in _angles(type(part)):
            value = getattr(part, key)

            for name, one in value.items() if isinstance(value, dict) else [(None, value)]:
                values = _numbers(one) if value is not None else ()

                if len(values) <= 2 and any(abs(v) > 2 * pi and 2 * v == round(2 * v) for v in values):
                    turns = ", ".join(f"{v / (2 * pi):.3g}" for v in values)
                    degrees = f"{{ {name} = {show(one)} }}" if name else show(one)
                    text = (
                        f"{show(one)} is in rad, {turns} full turns; for degrees write {key}_deg = {degrees}"
                    )
                    yield Problem((*path, key, *([name] if name else [])), text)


@cache
def _angles(kind):
    """Keys of a kind of Part that are angles in rad, and could be given in degrees."""
    fields = kind.known_keys()
    return [key for key in fields if f"{key}_deg" in fields and "speed" not in key]


def far_sizes(scene):
    """Bodies far longer than the others, as one in mm among those in m: no more than the others are."""
    sizes = sorted((size, name) for name, body in scene.body.items() if (size := _body_size(body)) > 0.0)

    for k, (size, _) in enumerate(sizes[1:], 1):
        if size > JUMP * sizes[k - 1][0] and 2 * k >= len(sizes):
            for size, name in sizes[k:]:
                text = f"reaches {size:.6g} m, other bodies {sizes[k - 1][0]:.6g} m at most; lengths are in m, not mm"
                yield Problem(("body", name), text)
            return


def coarse_tolerance(scene):
    """An absolute tolerance far coarser, against the scene's lengths, than the relative one."""
    solver, length = scene.solver, _scene_size(scene)
    part = solver.absolute_tolerance / length if length > 0.0 else 0.0

    if not solver.fixed_step and part > max(10.0 * solver.tolerance, 1e-4):
        text = f"{solver.absolute_tolerance:g} (in m, too) is {part:.2g} of the scene's size, {length:.3g} m; make it smaller"
        yield Problem(("solver", "absolute_tolerance"), text)


def stiff_friction(scene):
    """Dry friction that sticks within a speed next to nothing, under a stepper that is not made for stiff motions."""
    solver = scene.solver
    sharp = [
        name
        for name, joint in scene.joint.items()
        if joint.friction and max(joint.friction.coulomb, joint.friction.static) > 0.0
        and joint.friction.smoothing_speed < SHARP
    ]  # fmt: skip

    if sharp and not STEPPERS[solver.integrator].implicit:
        text = (
            f"what sticks by friction ({', '.join(sharp)}) is stiff: {solver.integrator} takes hundreds of thousands of steps or "
            'fails; take "auto" or "radau", or a smoothing_speed of 1e-3 or more'
        )
        yield Problem(("solver", "integrator"), text)


def inertia_of_no_body(scene):
    """Moments of inertia that no distribution of mass has, as those identified from motions of robots may be."""
    for name, body in scene.body.items():
        if body.inertia is None:
            continue

        moments = np.linalg.eigvalsh(inertia_matrix(body.inertia))

        if moments[0] + moments[1] < moments[2] * (1 - MOMENTS_ROUNDED):
            text = (
                "no principal moment exceeds the sum of the other two on a real body; it is taken as it is: "
            )
            yield Problem(("body", name, "inertia"), text + principal_moments(moments))


def idle_spins(scene):
    """Bodies between two ball joints whose spin about the line between these is all but free of inertia.

    The forces that they pass on have no moment about that line, but for rounding; an adaptive stepper follows what that does.
    """
    weight = (
        1e-16
        * max(hypot(*scene.gravity), 1.0)
        * max((body.mass_properties()[0] for body in scene.body.values()), default=0.0)
    )

    held = {name: [] for name in scene.body}

    for joint in scene.joint.values():
        for end in joint.between:
            held.get(end.split(".")[0], []).append((joint.kind, end))

    for name, body in scene.body.items():
        if len(held[name]) != 2 or any(kind not in ("spherical", "distance") for kind, _ in held[name]):
            continue

        a, b = (scene.marker_pose(end)[1] for _, end in held[name])
        length = norm(b - a)
        mass, com, inertia = body.mass_properties()
        line = (b - a) / length if length > 0.0 else b
        spin = line @ inertia @ line + mass * norm(np.cross(com - a, line)) ** 2

        if (
            length > 0.0
            and not scene.solver.fixed_step
            and 0.0 < spin * 30 * scene.solver.tolerance < weight * length
        ):
            text = (
                f"its spin about the line between its two joints, with {spin:.2g} kg m2, feels the rounding of what it carries: up "
                f"to {weight * length / spin:.1g} rad/s2, for which steps become small; take a distance joint in its place, a "
                "universal for one of the joints, or more inertia about that line"
            )
            yield Problem(("body", name), text)


def jumping_speeds(scene):
    """Positions over time that are read by straight lines, or that begin to move at once after the start."""
    motion = scene.ground.motion
    tables = [(("ground", "motion", "table"), motion.table)] if motion and motion.kind == "table" else []
    tables += [
        (("joint", name, "driver", "table"), joint.driver.table)
        for name, joint in scene.joint.items()
        if joint.driver and joint.driver.kind == "table"
    ]

    for path, table in tables:
        time, *rows = table.points()

        if table.interpolation == "linear":
            text = (
                "straight lines let the speed jump at each point: what hangs on it by joints gets no impulse then; "
                'interpolation = "smooth", or a speed_table, has none of that'
            )
            yield Problem((*path, "interpolation"), text)
        elif time[0] > 0.0 and _begins_to_move(table.interpolation, rows):
            text = (
                f"stands still until its first point, {show(float(time[0]))} s, and moves from there on: the speed jumps, and what "
                "hangs on it by joints gets no impulse then; begin at the start of the run, or with two equal points and "
                'interpolation = "smooth"'
            )
            yield Problem((*path, "time"), text)


def _begins_to_move(interpolation, rows):
    """Whether columns (n,) or (n, k) move at their first point: of two equal ones "smooth" alone makes a stand."""
    return any(np.any(row[0] != (row[1] if interpolation == "smooth" else row)) for row in rows)


def orbit_of_another_centre(scene):
    """A ground that goes round faster or slower than central gravity lets bodies go."""
    orbit = getattr(scene.ground.motion, "elliptic_orbit", None)

    if not (orbit and scene.central_gravity):
        return

    mu = orbit.mean_motion() ** 2 * orbit.semi_major_axis**3

    if abs(mu - scene.central_gravity.mu) > 1e-3 * scene.central_gravity.mu:
        text = (
            f"goes round as about a centre of mu = {mu:.6g} m3/s2, central_gravity.mu is "
            f"{scene.central_gravity.mu:.6g}: bodies do not keep up with the ground; lengths are in m, mu in m3/s2"
        )
        yield Problem(("ground", "motion", "elliptic_orbit"), text)


RULES = (
    far_angles,
    far_sizes,
    coarse_tolerance,
    stiff_friction,
    inertia_of_no_body,
    idle_spins,
    jumping_speeds,
    orbit_of_another_centre,
    *weather.RULES,
)


def notices(scene):
    """The `Problem`s of what is odd in a valid scene."""
    return [notice for rule in RULES for notice in rule(scene)]


def _parts(holder, path=()):
    """(path, Part) of all tables in a Part, a dict or a list."""
    if isinstance(holder, Part):
        yield path, holder
        items = list(holder)
    elif isinstance(holder, dict):
        items = list(holder.items())
    else:
        items = list(enumerate(holder))

    for key, value in items:
        if isinstance(value, (Part, dict, list)):
            yield from _parts(value, (*path, key))


def _numbers(value):
    """The numbers of a quantity that was written as one, as a vector, or in part as a table of components."""
    if isinstance(value, dict):
        return tuple(value.values())
    return value if isinstance(value, tuple) else (value,)


def _body_size(body):
    """m, how far a body's centre of mass, markers and solids reach from its origin or across."""
    reaches = [hypot(*body.com), *(hypot(*marker.position) for marker in body.marker.values())]

    for solid in body.solid or ():
        shape = getattr(solid, solid.kind)
        lengths = [
            *getattr(shape, "size", ()),
            getattr(shape, "length", 0.0),
            2 * getattr(shape, "radius", 0.0),
        ]
        reaches += [hypot(*solid.position), *lengths]

    return max(reaches)


def _scene_size(scene):
    """m, the greatest length that a scene is written with, 0 where there is none."""
    lengths = [_body_size(body) for body in scene.body.values()]
    lengths += [hypot(*marker.position) for marker in scene.ground.marker.values()]

    for joint in scene.joint.values():
        lengths.append(hypot(*_numbers(getattr(getattr(joint, "start", None), "position", 0.0))))
        lengths.append(getattr(joint.options, "radius", None) or 0.0)

    for force in scene.force.values():
        lengths.append(getattr(getattr(force, force.kind), "rest_length", None) or 0.0)

    return max(lengths, default=0.0)
