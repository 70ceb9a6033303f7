"""Efforts along joint coordinates that are inputs."""

from ..language import inlined
from ..motion import coordinates


@inlined
def add(m, d):
    """Their efforts onto the coordinates."""
    for k in range(m.n_effort_input):
        coordinates.add_effort(m, d, m.effort_coordinate[k], d.input[m.effort_u[k]])


@inlined
def effort_along(m, d, c):
    """Effort (N m or N) of all of them along coordinate c."""
    effort = 0.0

    for k in range(m.n_effort_input):
        if m.effort_coordinate[k] == c:
            effort += d.input[m.effort_u[k]]

    return effort


@inlined
def power(m, d):
    """W, on the bodies: all of it is supplied."""
    total = 0.0

    for k in range(m.n_effort_input):
        total += d.input[m.effort_u[k]] * coordinates.rate(m, d, m.effort_coordinate[k])

    return total
