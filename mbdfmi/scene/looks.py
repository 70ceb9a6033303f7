"""What things look like: shapes, colours, and how a scene is shown. No mass, no number of the simulation depends on it."""

from typing import Annotated, ClassVar

from pydantic import AfterValidator, BeforeValidator, Field

from ..lazily import webcolors
from .errors import did_you_mean, show
from .fields import Axis, Number, OneOf, Part, Positive, Vector, by_key, number
from .geometry import (
    BoxGeometry,
    CapsuleGeometry,
    ConeGeometry,
    CylinderGeometry,
    MeshGeometry,
    SphereGeometry,
    TubeGeometry,
)
from .orientation import Placed


def _colour(value):
    if not isinstance(value, str):
        raise ValueError(f'needs a colour as "steelblue" or "#4682b4", found {show(value)}')
    try:
        red_green_blue(value)
    except ValueError:
        near = did_you_mean(value, webcolors.names("css3"))
        raise ValueError(
            f'no colour {show(value)}; there are the names of CSS, as "steelblue", and "#rrggbb".{near}'
        ) from None
    return value


def red_green_blue(colour):
    """(3,) from 0 to 1 (sRGB) of a colour's name or "#rrggbb". Raises ValueError."""
    parse = webcolors.hex_to_rgb if colour.startswith("#") else webcolors.name_to_rgb
    return tuple(part / 255 for part in parse(colour))


def _opacity(value):
    if not 0 < number(value) <= 1:
        raise ValueError(f"must be above 0 (unseen) and at most 1 (solid), found {show(value)}")
    return number(value)


Colour = Annotated[str, BeforeValidator(_colour)]
Opacity = Annotated[float, BeforeValidator(_opacity)]


class Tinted(Part):
    """What may have a colour of its own."""

    colour: Colour | None = None


class Drawn(Tinted, Placed):
    """A shape at a place on what it is drawn on; position is that of its centre.

    colour : by default that of the whole.
    opacity : from 0 (unseen) to 1.
    """

    opacity: Opacity = 1.0


class AxialDrawn(Drawn):
    """A shape of revolution; axis is its own, in the axes of its orientation."""

    axis: Axis = "z"


class SphereShape(Drawn):
    """sphere = { radius }"""

    kind: ClassVar[str] = "sphere"
    sphere: SphereGeometry


class BoxShape(Drawn):
    """box = { size }"""

    kind: ClassVar[str] = "box"
    box: BoxGeometry


class CylinderShape(AxialDrawn):
    """cylinder = { radius, length }"""

    kind: ClassVar[str] = "cylinder"
    cylinder: CylinderGeometry


class TubeShape(AxialDrawn):
    """tube = { radius, inner_radius, length }"""

    kind: ClassVar[str] = "tube"
    tube: TubeGeometry


class CapsuleShape(AxialDrawn):
    """capsule = { radius, length }"""

    kind: ClassVar[str] = "capsule"
    capsule: CapsuleGeometry


class ConeShape(AxialDrawn):
    """cone = { radius, top_radius, length }"""

    kind: ClassVar[str] = "cone"
    cone: ConeGeometry


class MeshShape(Drawn):
    """mesh = { file, scale }; without a colour each part in its own, where its file has some (no textures)."""

    kind: ClassVar[str] = "mesh"
    mesh: MeshGeometry


def _line(value):
    if (
        not isinstance(value, (list, tuple))
        or not all(isinstance(end, str) for end in value)
        or len(value) < 2
    ):
        raise ValueError(f'needs a list of two or more ends, as ["arm", "arm.tip"], found {show(value)}')
    return [".".join(part.strip() for part in end.split(".")) for end in value]


Line = Annotated[list[str], BeforeValidator(_line)]


class LineShape(Tinted):
    """line = [end, end, ...], a rod from one end to the next.

    line : each the name of what it is drawn on (its own frame) or a marker of that, as in ["arm", "arm.elbow"].
    radius : m, by default a thin one.
    """

    kind: ClassVar[str] = "line"
    line: Line = Field(description='ends of one body or of the ground, as in ["arm", "arm.elbow"]')
    radius: Positive | None = None
    opacity: Opacity = 1.0


ShapeKind = by_key(
    "a shape",
    SphereShape,
    BoxShape,
    CylinderShape,
    TubeShape,
    CapsuleShape,
    ConeShape,
    MeshShape,
    LineShape,
)


def _as_list(value):
    return value if value is None or isinstance(value, (list, tuple)) else [value]


Shapes = Annotated[list[ShapeKind] | None, BeforeValidator(_as_list)]


class Shown(Tinted):
    """What can be given a look. None of it has mass, or is a parameter.

    shape : one shape or a list of them, in its axes.
    colour : of shapes and solids that have none of their own; by default one of a palette.
    """

    shape: Shapes = None


def _texts(value):
    value = [value] if isinstance(value, str) else value
    if not isinstance(value, (list, tuple)) or not all(isinstance(item, str) for item in value):
        raise ValueError(f"needs a list of names in quotes, found {show(value)}")
    return [item.strip() for item in value]


def _direction(value):
    if value is not None and not any(value):
        raise ValueError("needs a direction, found [0, 0, 0]")
    return value


def _text(value):
    if not isinstance(value, str):
        raise ValueError(f"needs a name in quotes, found {show(value)}")
    return value.strip()


FrameName = Annotated[str, BeforeValidator(_text)]
Names = Annotated[list[str], BeforeValidator(_texts)]


class View(Part):
    """How a scene is shown by `mbdfmi view`, as an icon, in a notebook. No number depends on it.

    up : axis of the inertial frame; by default against gravity, else z.
    water : m, height of a water plane along `up`.
    ground : "grid" draws one through the origin of the ground (under the water), "none" leaves it out.
    frame : what stays still in the picture: "ground", "inertial", or a body that is followed.
    look_from : direction from the scene to the eye, in the inertial frame.
    paths : ends ("body", "body.marker") whose paths are drawn.
    plots : outputs or inputs by name that are plotted beside the picture from the start; others can be chosen there.
    """

    up: Axis | None = None
    water: Number | None = None
    ground: OneOf("grid", "none") = "grid"
    frame: FrameName = "ground"
    look_from: Annotated[Vector | None, AfterValidator(_direction)] = None
    paths: Names = []
    plots: Names = []
