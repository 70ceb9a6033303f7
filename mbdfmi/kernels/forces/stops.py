"""Bump stops along joint coordinates (docs/theory.md 16.5)."""

from ..language import inlined
from ..motion import coordinates


@inlined
def penetration(m, k, x):
    """How far x is beyond an end of stop k: positive beyond the upper one, negative beyond the lower one."""
    return max(0.0, x - m.stop_upper[k]) - max(0.0, m.stop_lower[k] - x)


@inlined
def resistance(m, k, x, rate):
    """What stop k bears: spring and damper while in touch. It pushes only."""
    beyond = penetration(m, k, x)
    effort = m.stop_stiffness[k] * beyond + m.stop_damping[k] * rate

    if beyond > 0.0:
        return max(0.0, effort)

    if beyond < 0.0:
        return min(0.0, effort)

    return 0.0


@inlined
def resisted(m, d, k):
    """What stop k bears now."""
    c = m.stop_coordinate[k]
    return resistance(m, k, coordinates.value(m, d, c), coordinates.rate(m, d, c))


@inlined
def add(m, d):
    """Their efforts onto the coordinates."""
    for k in range(m.n_stop):
        coordinates.add_effort(m, d, m.stop_coordinate[k], -resisted(m, d, k))


@inlined
def effort_along(m, d, c):
    """Effort (N m or N) of all of them along coordinate c."""
    effort = 0.0

    for k in range(m.n_stop):
        if m.stop_coordinate[k] == c:
            effort -= resisted(m, d, k)

    return effort


@inlined
def energy(m, d):
    """J, stored."""
    total = 0.0

    for k in range(m.n_stop):
        beyond = penetration(m, k, coordinates.value(m, d, m.stop_coordinate[k]))
        total += 0.5 * m.stop_stiffness[k] * beyond * beyond

    return total


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_stop):
        total -= resisted(m, d, k) * coordinates.rate(m, d, m.stop_coordinate[k])

    return total


@inlined
def dissipated(m, d):
    """W, lost in their dampers; what the damper would pull, and must not, is stored energy lost."""
    total = 0.0

    for k in range(m.n_stop):
        elastic = m.stop_stiffness[k] * penetration(m, k, coordinates.value(m, d, m.stop_coordinate[k]))
        total += (resisted(m, d, k) - elastic) * coordinates.rate(m, d, m.stop_coordinate[k])

    return total
