"""What there is to draw of a scene: its looks, else its solids, else boxes of equal inertia and sticks
between the joints.
"""

import itertools
from typing import NamedTuple

import numpy as np

from ..compiler.frames import axes_with_z
from ..compiler.hulls import hull_of
from ..scene.fields import unit_vector
from ..scene.looks import red_green_blue
from ..scene.meshes import load_mesh, mesh_parts
from ..scene.rare import END_FRAMES
from . import curves, forms

PALETTE = ("#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#76b7b2", "#edc948", "#b07aa1", "#ff9da7", "#9c755f")
GROUND, TRACK, SPRING, SEA = "#8c949c", "#5b6b7a", "#7a5195", "#2f7fb5"

# joints that leave nothing to see at the ground
LOOSE = (
    "free",
    "translation",
    "planar",
    "rolling_disk",
    "rolling_sphere",
    *(rare.kind for rare in END_FRAMES),
)

# how much of a guess is seen
GUESS = 0.45
SEEN_THROUGH = 0.35

# of the scene's size: radius of sticks, of point masses
STICK = 0.007
DOT = 0.018


class Piece(NamedTuple):
    """A surface on a body ("ground" too), in the body's axes.

    colour : (3,), sRGB from 0 to 1. layer : "bodies", "curves" or "surfaces".
    """

    body: str
    surface: forms.Triangles
    colour: tuple
    opacity: float = 1.0
    layer: str = "bodies"


class Link(NamedTuple):
    """Something straight between two ends, as a spring: it gets longer and shorter."""

    name: str
    ends: tuple
    radius: float
    colour: tuple


def pieces(scene, size) -> list[Piece]:
    """All surfaces of a scene of that size (m)."""
    found, ends = [], joint_ends(scene)

    for k, (name, body) in enumerate(scene.body.items()):
        colour = red_green_blue(body.colour or PALETTE[k % len(PALETTE)])
        drawn = _looks(scene, name, body, colour, size) or _solids(name, body, colour, size)
        drawn = drawn or _hulls(scene, name, colour)
        found += drawn or _guess(scene, name, body, ends.get(name, {}), colour, size)
        found += _tracks(name, body, size)

    colour = red_green_blue(scene.ground.colour or GROUND)
    drawn = _looks(scene, "ground", scene.ground, colour, size)
    found += drawn or _feet(scene, ends.get("ground", {}), colour, size)
    return found + _tracks("ground", scene.ground, size) + _water(scene, size)


def check_meshes(scene):
    """Raises ValueError that names the place of every mesh of a look that cannot be read."""
    wrong = []

    for place, holder in _holders(scene):
        for k, shape in enumerate(holder.shape or [], 1):
            if shape.kind == "mesh":
                try:
                    mesh_parts(shape.mesh.file)
                except ValueError as error:
                    key = "shape" if len(holder.shape) == 1 else f"shape[{k}]"
                    wrong.append(f"[{place}] {key}.mesh: {error}")

    if wrong:
        raise ValueError("\n".join(wrong))


def _holders(scene):
    """(table, what may have shapes) of a scene: the ground, bodies, and their markers."""
    bodies = [(f"body.{name}", body) for name, body in scene.body.items()]

    for place, holder in [("ground", scene.ground), *bodies]:
        yield place, holder
        yield from ((f"{place}.marker.{name}", marker) for name, marker in holder.marker.items())


def links(scene, size) -> list[Link]:
    """Springs, and rods that are distances kept."""
    struts = [(name, f.between) for name, f in scene.force.items() if f.kind == "spring_damper"]
    rods = [(name, j.between) for name, j in scene.joint.items() if j.kind == "distance"]
    made = [(struts, 0.6, SPRING), (rods, 0.8, GROUND)]
    return [
        Link(name, tuple(ends), part * STICK * size, red_green_blue(colour))
        for found, part, colour in made
        for name, ends in found
    ]


def joint_ends(scene) -> dict:
    """Body, or "ground" -> ends of joints and springs on it, each once, and the joints at that end."""
    found = {}

    for user in [*scene.joint.values(), *(f for f in scene.force.values() if f.kind == "spring_damper")]:
        for end in user.between:
            joints = found.setdefault(end.split(".")[0], {}).setdefault(end, [])
            joints += [user] if user.kind != "spring_damper" else []

    return found


# shapes


def _looks(scene, name, holder, colour, size):
    """What the user drew on a body or on the ground, and on its markers."""
    found = []
    frames = [(np.zeros(3), np.eye(3), colour, holder)]

    for marker in holder.marker.values():
        own = red_green_blue(marker.colour) if marker.colour else colour
        frames.append((*marker.pose(), own, marker))

    for r, A, tint, drawn in frames:
        for shape in drawn.shape or []:
            own = red_green_blue(shape.colour) if shape.colour else tint
            if shape.kind == "line":
                found.append(Piece(name, _line(scene, shape, size), own, shape.opacity))
            else:
                found += [
                    Piece(name, forms.moved(surface, r, A), seen, shape.opacity)
                    for surface, seen in _shape(shape, own)
                ]
    return found


def _line(scene, shape, size):
    """Rods between ends on one body."""
    points = [scene.marker_pose(end)[1] for end in shape.line]
    radius = shape.radius or STICK * size
    return forms.join([forms.rod(a, b, radius) for a, b in itertools.pairwise(points)])


def _shape(shape, colour):
    """[(surface, colour)] of a shape at its place: of a mesh its parts, in their own colours if any."""
    position, A = shape.pose()

    if shape.kind != "mesh":
        return [(_placed(shape, getattr(shape, shape.kind), position, A), colour)]

    parts = mesh_parts(shape.mesh.file, shape.mesh.scale)
    return [
        (forms.moved(_sharp(mesh), position, A), colour if shape.colour or own is None else own)
        for mesh, own in parts
    ]


def _sharp(mesh):
    """The surface of a `trimesh.Trimesh`, its edges sharp."""
    return forms.sharp(np.asarray(mesh.vertices, float), np.asarray(mesh.faces))


def _placed(part, form, position, A):
    """The surface of a shape or solid of a form."""
    stretch = {
        "box": lambda: (forms.box(), form.size),
        "sphere": lambda: (forms.sphere(), 3 * [form.radius]),
        "cylinder": lambda: (forms.cylinder(), [form.radius, form.radius, form.length]),
        "tube": lambda: (forms.tube(form.radius, form.inner_radius, form.length), np.ones(3)),
        "capsule": lambda: (forms.capsule(form.radius, form.length), np.ones(3)),
        "cone": lambda: (forms.cone(form.radius, form.top_radius, form.length), np.ones(3)),
    }
    surface, size = stretch[part.kind]()
    turn = axes_with_z(unit_vector(part.axis)) if hasattr(part, "axis") else np.eye(3)
    return forms.moved(surface, position, A @ turn, np.asarray(size))


# solids, and guesses


def _solids(name, body, colour, size):
    found = []

    for solid in body.solid or []:
        position, A = solid.pose()
        form = getattr(solid, solid.kind)
        if solid.kind == "point":
            surface = forms.moved(forms.sphere(), position, A, 3 * [DOT * size])
        elif solid.kind == "mesh":
            mesh = load_mesh(form.file, form.scale)
            surface = forms.moved(_sharp(mesh), position, A)
        else:
            surface = _placed(solid, form, position, A)
        found.append(Piece(name, surface, colour))
    return found


def _hulls(scene, name, colour):
    """What water carries of a body that is drawn in no other way."""
    found = []

    for force in scene.force.values():
        if force.kind == "hydrostatics" and force.on.split(".")[0] == name:
            _, r, A = scene.marker_pose(force.on)
            position, turn = force.hydrostatics.pose()
            points, polygons = hull_of(force.hydrostatics)
            fans = [[p[0], a, b] for p in polygons for a, b in itertools.pairwise(p[1:])]
            surface = forms.sharp(np.asarray(points, float), np.array(fans))
            found.append(Piece(name, forms.moved(surface, r + A @ position, A @ turn), colour))

    return found


def _water(scene, size):
    """The plane z = 0 where something floats in it, the ground stands still and no other water is drawn."""
    if scene.view.water is not None or scene.ground.motion:
        return []

    if not any(force.kind == "hydrostatics" for force in scene.force.values()):
        return []

    plane = np.array([2.0 * size, 2.0 * size, 1e-4 * size])
    surface = forms.moved(forms.box(), np.zeros(3), np.eye(3), plane)
    return [Piece("ground", surface, red_green_blue(SEA), SEEN_THROUGH)]


def _guess(scene, name, body, ends, colour, size):
    """Sticks from joint to joint, and what rolls; half transparent, a box of equal inertia."""
    mass, com, inertia = body.mass_properties()
    found = [Piece(name, surface, colour, GUESS) for surface in _rolling(scene, ends)]

    if not found and mass:
        moments, axes = np.linalg.eigh(inertia / mass)
        edges = np.sqrt(np.maximum(6 * (moments.sum() - 2 * moments), 0.0))

        if edges.max() > DOT * size:
            edges = np.maximum(edges, 0.4 * STICK * size)
            axes = axes * np.sign(np.linalg.det(axes))
            found.append(Piece(name, forms.moved(forms.box(), com, axes, edges), colour, GUESS))
        else:
            found.append(Piece(name, forms.moved(forms.sphere(), com, np.eye(3), 3 * [DOT * size]), colour))

    points = [scene.marker_pose(end)[1] for end in ends]
    return found + [Piece(name, stick, colour) for stick in _sticks(points, com if mass else None, size)]


def _rolling(scene, ends):
    """Disks and balls that roll, on the body with these ends that does."""
    for end, joint in ((end, joint) for end, joints in ends.items() for joint in joints):
        if joint.kind in ("rolling_disk", "rolling_sphere") and joint.between[1] == end:
            _, r, A = scene.marker_pose(end)
            if joint.kind == "rolling_sphere":
                yield forms.moved(forms.sphere(), r, A, 3 * [joint.radius])
            else:
                size = np.array([joint.radius, joint.radius, 0.04 * joint.radius])
                yield forms.moved(forms.cylinder(), r, A @ axes_with_z(joint.axis), size)


def _sticks(points, com, size):
    """Rods that join points (of the joints) and the centre of mass."""
    points = [np.asarray(p) for p in points]

    if len(points) == 1 and com is not None:
        points.append(np.asarray(com))
    if len(points) > 2:
        middle = np.mean(points, axis=0)
        pairs = [(middle, p) for p in points]
    else:
        pairs = list(itertools.pairwise(points))

    radius = STICK * size
    return [forms.rod(a, b, radius) for a, b in pairs if np.linalg.norm(b - a) > radius]


def _feet(scene, ends, colour, size):
    """Small blocks where joints hold to the ground."""
    found = []

    for end, joints in ends.items():
        r = scene.marker_pose(end)[1]
        if any(joint.kind not in LOOSE for joint in joints):
            found.append(
                Piece("ground", forms.moved(forms.box(), r, np.eye(3), 3 * [3.2 * STICK * size]), colour)
            )
    return found


def _tracks(name, holder, size):
    """Curves and surfaces on a body's markers."""
    found = []

    for marker in holder.marker.values():
        r, A = marker.pose()
        if marker.curve:
            points = curves.curve_points(marker.curve, 0.6 * size)
            rods = forms.polyline(points, 0.4 * STICK * size)
            found.append(Piece(name, forms.moved(rods, r, A), red_green_blue(TRACK), 1.0, "curves"))
        if marker.surface:
            surface = curves.surface(marker.surface, 0.6 * size)
            found.append(Piece(name, forms.moved(surface, r, A), red_green_blue(TRACK), 0.3, "surfaces"))
    return found
