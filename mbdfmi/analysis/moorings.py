"""Mooring lines as they hang where a scene starts, and what they do as that is pulled aside."""

import itertools
from dataclasses import dataclass

import numpy as np

from ..compiler.model import compile_scene
from ..kernels.forces import catenaries, composite_lines, composite_pulls, composite_shapes
from ..kernels.forces.line_pieces import piece
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

    # each kind is numbered by itself
    rows, count = {}, [0, 0]

    for name in names:
        kind = int(scene.force[name].catenary.is_composite)
        rows[name] = (_composite if kind else _line, count[kind])
        count[kind] += 1

    def lines_at(x):
        return [of(instance, scene, k, name, x * along) for name, (of, k) in rows.items()]

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


def _ends(instance, scene, name, first, second, moved):
    """(3,) m each: the places of two markers, those on bodies moved (m)."""
    places = [np.array(markers.position(instance.m, instance.d, int(marker))) for marker in (first, second)]
    ends = scene.force[name].between
    return [place if stands_still(end) else place + moved for place, end in zip(places, ends)]


def _composite(instance, scene, k, name, moved):
    """Line k of those of several sections, or with friction of the bed, with its ends on bodies moved (m)."""
    m, d = instance.m, instance.d
    first, second = _ends(instance, scene, name, m.composite_from[k], m.composite_to[k], moved)
    span = second - first
    across = float(np.hypot(span[0], span[1]))
    H, V = composite_pulls.pull(m, d, k, across, float(span[2]))
    away = np.array([span[0], span[1], 0.0]) / across if across > 0.0 else np.zeros(3)
    curve, lying, joints = _shape_of_sections(m, d, k, H, V)
    points = first + curve[:, :1] * away + curve[:, 1:] * [0.0, 0.0, 1.0]
    force = -H * away - [0.0, 0.0, V]
    return MooringLine(
        name,
        scene.force[name].catenary.total_length,
        first,
        second,
        float(np.hypot(H, V)),
        float(np.hypot(*composite_lines.anchor_pull(m, d, k, H, V))),
        float(lying[:, 1].sum()),
        scene.force[name].between[1].partition(".")[0],
        points,
        lying[:, 0] > 0.0,
        points[joints],
        force,
        force,
    )


def _shape_of_sections(m, d, k, H, V):
    """Line k, asked for at this pull.

    Returns its points, (n, 2) m, along and up from the first end; (n - 1, 2) whether what is between them
    lies, and how long it is unstretched (m); at which points sections meet.
    """
    first, last = int(m.composite_section[k]), composite_shapes.last_section(m, k)
    pull = max(H, composite_shapes.least_pull(d, k))
    points, lying, joints = [np.zeros(2)], [], []

    def go(w, L, EA, h, top, bottom, lies):
        now = piece(w, L, EA, h, top, bottom)
        points.append(points[-1] + [now.x, now.z])
        lying.append((float(lies), L if lies else 0.0))

    for i in range(first, last + 1):
        w, EA = composite_shapes.weight(m, i), float(m.section_stiffness[i])
        floor, cap = composite_shapes.bounds(m, d, k, i, V)
        of = composite_shapes.parts(m, d, k, i, floor.at, cap.at, H, V)
        joints += [len(points) - 1] if i > first else []

        for part in ("down", "flat", "up"):
            length = getattr(of, part)
            if not length > 0.0:
                continue
            if part == "flat":
                # stretched by what it is pulled with, where it is tight
                held = 0.5 * (of.pull + composite_shapes.pull_below(m, k, i, of)) * of.slid / length
                go(0.0, length, EA, max(held, pull * 1e-9), 0.0, 0.0, True)
                continue

            steps = np.linspace(getattr(of, f"{part}_bottom"), getattr(of, f"{part}_top"), POINTS)

            for low, high in itertools.pairwise(steps):
                go(w, length / (POINTS - 1), EA, pull, high, low, False)

    return np.array(points), np.array(lying), joints


def _line(instance, scene, k, name, moved):
    """Line k with its ends on bodies moved (m)."""
    m, d = instance.m, instance.d
    ends = _ends(instance, scene, name, m.line_from[k], m.line_to[k], moved)

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
    lying = np.zeros(len(curve) - 1, bool)
    lying[0] = len(curve) > POINTS
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
        lying,
        np.zeros((0, 3)),
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
