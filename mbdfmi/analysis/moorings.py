"""Mooring lines as they hang where a scene starts, and what they do as that is pulled aside."""

from dataclasses import dataclass

import numpy as np

from ..compiler.model import compile_scene
from ..kernels.forces import catenaries
from ..kernels.motion import markers
from ..run.instance import Instance
from ..scene import SceneData
from ..scene.ends import stands_still

POINTS = 60

# of the longest line: by so much both ways the slope of the force is found
STRIDE = 1e-5


@dataclass(frozen=True)
class MooringLine:
    """A catenary at one place of its ends.

    lower, upper : (3,) m, in the inertial frame. tension, lower_tension : N, at these ends. grounded : m,
    that lies on the bed. body : of the upper end. shape : (n, 3) m, from the lower end to the upper one.
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

    def lines_at(x):
        return [_line(instance, scene, k, name, x * along) for k, name in enumerate(names)]

    def force_of(lines):
        return -sum(line.force @ along for line, holds in zip(lines, held) if holds)

    now, offsets = lines_at(0.0), np.linspace(-offset, offset, points)
    there = [lines_at(x) for x in offsets]
    force = np.array([force_of(lines) for lines in there])
    tension = np.array([[line.tension for line in lines] for lines in there])
    step = STRIDE * max(line.length for line in now)
    stiffness = (force_of(lines_at(step)) - force_of(lines_at(-step))) / (2 * step)
    return Moorings(now, offsets, force, float(stiffness), tension, instance.notices)


def _line(instance, scene, k, name, moved):
    """Line k with its ends on bodies moved (m)."""
    m, d = instance.m, instance.d
    ends = []

    for marker, end in zip((int(m.line_from[k]), int(m.line_to[k])), scene.force[name].between):
        place = np.array(markers.position(m, d, marker))
        ends.append(place if stands_still(end) else place + moved)

    # without a bed the lower end is the first
    swapped = m.line_bed[k] == 0 and ends[1][2] < ends[0][2]
    lower, upper = ends[::-1] if swapped else ends
    span = upper - lower
    across = float(np.hypot(span[0], span[1]))
    H, V = catenaries.pull(m, d, k, across, float(span[2]))
    w, L, EA = float(catenaries.weight(m, k)), float(m.line_length[k]), float(m.line_stiffness[k])
    bed = m.line_bed[k] == 1
    lowest = max(V - w * L, 0.0) if bed else V - w * L
    away = np.array([span[0], span[1], 0.0]) / across if across > 0.0 else np.zeros(3)
    curve = _shape(H, V, w, L, EA, bed)
    on_upper = -H * away - [0.0, 0.0, V]
    return MooringLine(
        name,
        L,
        lower,
        upper,
        float(np.hypot(H, V)),
        float(np.hypot(H, lowest)),
        max(0.0, L - V / w) if bed else 0.0,
        scene.force[name].between[0 if swapped else 1].partition(".")[0],
        lower + curve[:, :1] * away + curve[:, 1:] * [0.0, 0.0, 1.0],
        H * away + [0.0, 0.0, lowest] if swapped else on_upper,
        on_upper,
    )


def _shape(H, V, w, L, EA, bed):
    """(n, 2) m: along and up from the lower end, of an elastic line pulled with H and V at its upper end."""
    lying = max(0.0, L - V / w) if bed else 0.0
    s = np.linspace(lying, L, POINTS) - lying
    start = V - w * (L - lying)
    pull = np.hypot(H, start + w * s)

    # x' = H / T + H / EA, z' = v / T + v / EA
    along = H * s / EA
    if H > 0.0:
        along = along + H / w * (np.arcsinh((start + w * s) / H) - np.arcsinh(start / H))
    up = (pull - pull[0]) / w + (start * s + w * s * s / 2) / EA
    found = np.column_stack([along + lying * (1 + H / EA), up])
    return np.vstack([np.zeros((1, 2)), found]) if lying > 0.0 else found
