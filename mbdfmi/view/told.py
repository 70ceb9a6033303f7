"""What a page tells beside its picture: names, markers, axes of joints, plots, from where it is looked at."""

import numpy as np

from ..compiler.variables import array_of
from ..rotations import Rotation
from ..scene.fields import unit_vector
from .lines import beds
from .numbers import exact, packed

# points of a plot, and numbers of all plots in a page
PLOT_POINTS = 1200
PLOT_NUMBERS = 200_000

# components of a sea that a page shows
MOST_WAVES = 200

# of the radius: how far below the lowest point the grid lies
BELOW = 0.02


def told(picture, results=None, notes=()):
    """The page's data of a picture, ready for JSON; results: of a run, for plots."""
    scene, moves = picture.scene, picture.moves
    centre, radius = picture.reach
    root = picture.root
    run = len(moves.times) > 1
    ground = unseen_ground(picture)
    bodies = [body for body in moves.bodies if body != "ground"]
    view = scene.view
    return {
        "title": picture.title,
        "notes": list(notes),
        "bodies": order(picture),
        "labels": [_labelled(scene, body) for body in bodies],
        "markers": list(_markers(scene)),
        "axes": list(_axes(scene)),
        "ends": list(_ends(scene)),
        "times": [float(moves.times[0]), float(moves.times[-1])] if run else None,
        "grid": grid_cell(radius) if view.ground == "grid" else None,
        "floor": ground,
        "water": view.water,
        "waves": waves(scene, picture.states) if run and view.water == 0.0 else None,
        "centre": (root @ centre).tolist(),
        "radius": radius,
        "eye": (root @ eye(picture)).tolist(),
        "follow": [*(["ground"] if scene.view.frame == "inertial" and scene.ground.motion else []), *bodies],
        "followed": view.frame if view.frame in scene.body and run else "",
        "paths": list(view.paths),
        "plots": plots(scene, results) if run and results is not None else None,
        "arrows": None,  # see arrows.py
        "lines": None,  # see lines.py
    }


def waves(scene, states=None):
    """The strongest of the sea's components, None without waves; states: of a run, which may have had another
    sea than the scene's.

    Of each amplitude (m), frequency (rad/s), phase (rad), wave numbers along x and y (rad/m).
    """
    if not (scene.sea and scene.sea.waves) or scene.ground.motion:
        return None

    from ..compiler.seas import sea_components
    from ..hydro.spectra import wave_number

    found = sea_components(scene, states.given("sea.") if states is not None else None)
    k = wave_number(found.omega, scene.sea.depth, -scene.gravity[2])
    along = [k * np.cos(found.heading), k * np.sin(found.heading)]
    rows = np.column_stack([found.amplitude, found.omega, found.phase, *along])
    strongest = np.sort(np.argsort(-found.amplitude, kind="stable")[:MOST_WAVES])
    return [[float(f"{x:.7g}") for x in row] for row in rows[strongest]]


def unseen_ground(picture):
    """Height of the grid: that of the bed of the sea where lines lie on it, else of the ground's origin, or
    just below all that is drawn where that is lower.
    """
    if levels := beds(picture):
        return levels[0][0][1]

    heights = [
        (picture.moves.points(piece.body, points[:: max(1, len(points) // 40)]) @ picture.root[1]).min()
        for piece in picture.pieces
        if piece.layer == "bodies" and len(points := piece.surface.points)
    ]
    lowest, radius = min(heights, default=0.0), picture.reach[1]
    # what rolls or stands on the ground may reach a little into it
    return 0.0 if lowest > -1.5 * BELOW * radius else float(lowest - BELOW * radius)


def grid_cell(radius):
    """m: a round length of which some fit into the radius."""
    power = 10 ** np.floor(np.log10(radius / 2.5))
    return float(power * max(part for part in (1, 2, 5) if part * power <= radius / 2.5))


def order(picture):
    """Names of the bodies in the order of their nodes in the file."""

    def walk(node):
        if node.extras.get("kind") == "body":
            yield node.name
        for child in node.children:
            yield from walk(child)

    return list(walk(picture.tree()))


def _labelled(scene, body):
    mass, com, _ = scene.body[body].mass_properties()
    return {"name": body, "body": body, "r": [float(x) for x in com] if mass else [0.0, 0.0, 0.0]}


def _holders(scene):
    return [("ground", scene.ground), *scene.body.items()]


def _markers(scene):
    for owner, holder in _holders(scene):
        for name, marker in holder.marker.items():
            r, A = marker.pose()
            q = Rotation.from_matrix(A).as_quat()
            yield {"name": f"{owner}.{name}", "body": owner, "r": r.tolist(), "q": q.tolist()}


def _ends(scene):
    for owner, holder in _holders(scene):
        if owner != "ground":
            yield {"name": owner, "body": owner, "r": [0.0, 0.0, 0.0]}
            for name, marker in holder.marker.items():
                yield {"name": f"{owner}.{name}", "body": owner, "r": marker.pose()[0].tolist()}


def _axes(scene):
    """Joints with an axis: it is told in the first marker's axes, a universal joint's second in the
    second's.
    """
    for name, joint in scene.joint.items():
        for end, axis in _axes_of(joint):
            body, r, A = scene.marker_pose(end)
            if body != "inertial":
                yield {"name": name, "body": body, "r": r.tolist(), "axis": (A @ axis).tolist()}


def _axes_of(joint):
    if joint.kind in ("revolute", "prismatic", "cylindrical", "screw", "rolling_disk"):
        end = joint.between[1] if joint.kind == "rolling_disk" else joint.between[0]
        return [(end, np.asarray(joint.axis))]
    if joint.kind == "universal":
        return [(end, np.asarray(unit_vector(axis))) for end, axis in zip(joint.between, joint.axes)]
    return []


def eye(picture):
    """(3,): from where the scene is looked at, in the picture's frame."""
    scene, root = picture.scene, picture.root

    if scene.view.look_from is not None:
        return picture.moves.inertial[1][0].T @ np.array(scene.view.look_from)

    # a mechanism in a plane is seen best from across it, a little from above
    axes = np.array([picture.ends_axis(axis) for axis in _axes(scene)]).reshape(-1, 3)
    up = root.T @ np.array([0.0, 1.0, 0.0])

    if len(axes) and np.abs(axes @ axes[0]).min() > 0.999 and abs(axes[0] @ up) < 0.9:
        across = axes[0] - (axes[0] @ up) * up
        # from the front: towards the viewer of x to the right, where there is a choice
        across *= 1 if (root @ across)[2] > -1e-9 else -1
        across /= np.linalg.norm(across)
        return across + 0.3 * up + 0.25 * np.cross(up, across)

    return root.T @ np.array([0.75, 0.5, 1.0])


def plots(scene, results):
    """The variables of a run, an array in one plot, the chosen ones shown. Raises ValueError for a chosen
    one that is not there.
    """
    names = {}

    for name in results:
        if name != "time":
            names.setdefault(array_of(name), []).append(name)

    try:
        shown = list(dict.fromkeys(array_of(results.known(name)[0]) for name in scene.view.plots))
    except KeyError as error:
        raise ValueError(f"[view] plots: {error.args[0]}") from None

    rows = _rows(len(results["time"]))
    chosen = [*shown, *(name for name in names if name not in shown)]
    items, left = [], PLOT_NUMBERS

    for name in chosen:
        left -= len(rows) * len(names[name])
        if left < 0 and name not in shown:
            continue

        lines = [
            {"label": column.removeprefix(name)} | packed(results[column][rows]) for column in names[name]
        ]
        items.append({"name": name, "unit": results.units.get(names[name][0]) or "", "lines": lines})

    items.sort(key=lambda item: list(names).index(item["name"]))
    return {"times": exact(results["time"][rows]), "items": items, "shown": shown}


def _rows(n):
    return np.unique(np.linspace(0, n - 1, min(n, PLOT_POINTS)).round().astype(int))
