"""Branches of the kernels that a trace takes as they are where it is recorded, in words of the scene."""

from collections.abc import Iterable

from .record import Guard

CHECKS = {
    "prepare": "masses and inertia are possible",
    "joints": "inertia about joints is positive",
    "math.algebra": "inertia is positive",
    "math.linear": "what is solved for is determined",
    "entry": "numbers are finite",
    "dynamics.forward": "accelerations are determined",
    "dynamics.massless": "accelerations of parts without mass are determined",
    "dynamics.multipliers": "the same equations of loops are independent, and solved in the same order",
}
"""By the beginning of a kernel's dotted name: what holds along with most motions."""

MOTION = {
    "forces.hydrostatics": "the same panels of hulls are in the water, cut by its surface in the same way",
    "forces.catenaries": "the same part of each line lies on the bed",
    "forces.composite_lines": "the same part of each line lies on the bed",
    "forces.composite_pulls": "the same part of each line lies on the bed",
    "forces.composite_shapes": "the same part of each line lies on the bed",
    "forces.line_ends": "the same part of each line lies on the bed",
    "forces.line_pieces": "the same part of each line lies on the bed",
    "forces.members": "the same parts of members are in the water",
    "forces.stops": "coordinates are on the same sides of their stops",
    "forces.friction": "friction acts in the same way",
    "forces.six_by_six": "bodies are turned against each other by less than half a turn",
    "forces.wind_rotors": "rotors work in the same range of their tables",
    "end_frames": "points are on the same parts of curves and surfaces",
    "motion": "what moves by time or commands does so as at the start",
}
"""Likewise what ends as a scene moves."""


def words(guards: Iterable[Guard]) -> tuple[list[str], list[str]]:
    """(what ends as the scene moves, what holds along with most motions) of what a trace rests on, each
    once."""
    places = {guard.place.partition(",")[0] for guard in guards}
    moving, lasting = set(), set()

    for place in places:
        if (found := _of(CHECKS, place)) is not None:
            lasting.add(found)
        else:
            moving.add(_of(MOTION, place) or f"{place.rpartition('.')[0]} goes the same way")

    return sorted(moving), sorted(lasting)


def _of(table, place):
    return next(
        (text for start, text in table.items() if place == start or place.startswith(f"{start}.")), None
    )
