"""Mooring lines as they hang where a scene starts, and what they do as that is pulled aside."""

from dataclasses import dataclass

import numpy as np

from ..compiler.model import compile_scene
from ..kernels.forces import catenaries, composite_lines
from ..kernels.motion import markers
from ..run import line_shapes
from ..run.instance import Instance
from ..scene import SceneData
from ..scene.ends import stands_still

POINTS = 60

# of the longest line: by so much both ways the slope of the force is found
STRIDE = 1e-5


@dataclass(frozen=True)
class MooringLine:
    """A catenary at one place of its ends.

    lower, upper : (3,) m, in the inertial frame; a line of sections or with friction has its first end as the
    lower one. tension, lower_tension : N, at these ends. grounded : m, that lies on the bed. body : of the
    upper end. shape : (n, 3) m, from the lower end to the upper one; lying : (n - 1,) whether what is between
    its points lies on the bed. joints : (j, 3) m, where sections meet.
    force, upper_force : (3,) N, on the scene's second end, on the upper end.
    """

    name: str
    length: float
    lower: np.ndarray
    upper: np.ndarray
    tension: float
    lower_tension: float
    grounded: float
    body: str
    shape: np.ndarray
    lying: np.ndarray
    joints: np.ndarray
    force: np.ndarray
    upper_force: np.ndarray


@dataclass(frozen=True)
class Moorings:
    """lines : at the start. offsets : (n,) m. force : (n,) N, of all lines on what they hold, against the
    offset; stiffness : N/m, its slope at the start; tension : (n, lines) N, at their upper ends. notices : of
    the scene and its start.
    """

    lines: list[MooringLine]
    offsets: np.ndarray
    force: np.ndarray
    stiffness: float
    tension: np.ndarray
    notices: list[str]


def moorings(scene: SceneData, offset: float, direction: float = 0.0, points: int = 41) -> Moorings:
    """The lines of a scene where it starts, and with all that they hold moved aside without turning.

    offset : m, so far both ways. direction : rad, from x towards y. Raises ValueError without lines.
    """
    names = [name for name, force in scene.force.items() if force.kind == "catenary"]

    if not names:
        raise ValueError(f"{scene.name}: has no catenaries, as in [force.line] catenary = {{ ... }}")

    instance = Instance(compile_scene(scene))
    instance.outputs()
    along = np.array([np.cos(direction), np.sin(direction), 0.0])
    held = [not stands_still(scene.force[name].between[1]) for name in names]

    rows = line_shapes.lines_of(scene)

    def lines_at(x):
        return [_hung(instance, scene, line, name, x * along) for name, line in rows.items()]

    def force_of(lines):
        return -sum(line.force @ along for line, holds in zip(lines, held) if holds)

    now, offsets = lines_at(0.0), np.linspace(-offset, offset, points)
    there = [lines_at(x) for x in offsets]
    force = np.array([force_of(lines) for lines in there])
    tension = np.array([[line.tension for line in lines] for lines in there])
    step = STRIDE * max(line.length for line in now)
    stiffness = (force_of(lines_at(step)) - force_of(lines_at(-step))) / (2 * step)
    notices = [*instance.notices, *_out_of_water(scene, now)]
    return Moorings(now, offsets, force, float(stiffness), tension, notices)


def _out_of_water(scene, lines):
    """Texts about lines that float up above the still water, where buoys would stop."""
    for line in lines:
        top = float(line.shape[:, 2].max())

        if scene.sea and top > max(0.0, line.lower[2], line.upper[2]) + 1e-6 * line.length:
            yield (
                f"[force.{line.name}] catenary: what floats lifts it to z = {top:.3g} m, above the water: "
                "it would stop there"
            )


def _ends(instance, scene, line, name, moved):
    """(3,) m each: the places of a line's ends, those on bodies moved (m)."""
    places = [np.array(markers.position(instance.m, instance.d, end)) for end in line.markers(instance.m)]
    ends = scene.force[name].between
    return [place if stands_still(end) else place + moved for place, end in zip(places, ends)]


def _hung(instance, scene, line, name, moved):
    """A line with its ends on bodies moved (m)."""
    m, d = instance.m, instance.d
    first, second = _ends(instance, scene, line, name, moved)
    span = second - first
    across = float(np.hypot(span[0], span[1]))
    away = np.array([span[0], span[1], 0.0]) / across if across > 0.0 else np.zeros(3)
    of = line_shapes.hang(m, d, line, across, span[2])
    H, V = float(of.H[0]), float(of.V[0])
    out, up = _anchor_pull(m, d, line, H, V)
    on_first, on_second = out * away + [0.0, 0.0, up], -H * away - [0.0, 0.0, V]
    s, lying, joints = _places(of)
    curve = line_shapes.points(of, s)[0]
    points = first + curve[:, :1] * away + curve[:, 1:] * [0.0, 0.0, 1.0]
    ends = scene.force[name].between

    # without a bed the lower end of one section is the first
    swapped = not line.composite and not line.has_bed(m) and span[2] < 0.0
    lower, upper = (second, first) if swapped else (first, second)
    tensions = float(np.linalg.norm(on_first)), float(np.linalg.norm(on_second))
    return MooringLine(
        name,
        scene.force[name].catenary.total_length,
        lower,
        upper,
        tensions[0 if swapped else 1],
        tensions[1 if swapped else 0],
        float(of.grounded[0]),
        ends[0 if swapped else 1].partition(".")[0],
        points[::-1] if swapped else points,
        lying[::-1] if swapped else lying,
        points[joints],
        on_second,
        on_first if swapped else on_second,
    )


def _anchor_pull(m, d, line, H, V):
    """(N towards the second end, N upwards) on the first end of a line that was hung last."""
    if line.composite:
        return composite_lines.anchor_pull(m, d, line.k, H, V)

    return H, float(catenaries.lower_pull(m, line.k, V))


def _places(of):
    """Of a line at one place: m along it, unstretched, where points are to be; whether it lies from each to
    the next; at which of them sections meet.
    """
    s, lying, joints = [0.0], [], []

    for length, lies, section, before in zip(of.length[0], of.lies, of.section, [0, *of.section]):
        joints += [len(s) - 1] if section > before else []

        if length > 0.0:
            n = 1 if lies else POINTS - 1
            s += (s[-1] + length * np.arange(1, n + 1) / n).tolist()
            lying += n * [bool(lies)]

    return s, np.array(lying), joints
