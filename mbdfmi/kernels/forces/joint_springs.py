"""Springs and dampers along joint coordinates (docs/theory.md 16.4)."""

from ..language import inlined
from ..motion import coordinates
from .elastic import damper_effort, spring_effort, stored_energy


@inlined
def efforts(m, d, k):
    """Efforts (N m or N) of joint spring k and of its damper along their coordinate."""
    c = m.joint_spring_coordinate[k]
    x = coordinates.value(m, d, c)
    spring = spring_effort(m, m.joint_spring_table[k], m.joint_stiffness[k], m.joint_rest[k], x)
    damper = damper_effort(m, m.joint_damper_table[k], m.joint_damping[k], coordinates.rate(m, d, c))
    return -spring, -damper


@inlined
def add(m, d):
    """Their efforts onto the coordinates."""
    for k in range(m.n_joint_spring):
        spring, damper = efforts(m, d, k)
        coordinates.add_effort(m, d, m.joint_spring_coordinate[k], spring + damper)


@inlined
def effort_along(m, d, c):
    """Effort (N m or N) of all of them along coordinate c."""
    effort = 0.0

    for k in range(m.n_joint_spring):
        if m.joint_spring_coordinate[k] == c:
            spring, damper = efforts(m, d, k)
            effort += spring + damper

    return effort


@inlined
def energy(m, d):
    """J, stored."""
    total = 0.0

    for k in range(m.n_joint_spring):
        x = coordinates.value(m, d, m.joint_spring_coordinate[k])
        total += stored_energy(m, m.joint_spring_table[k], m.joint_stiffness[k], m.joint_rest[k], x)

    return total


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_joint_spring):
        spring, damper = efforts(m, d, k)
        total += (spring + damper) * coordinates.rate(m, d, m.joint_spring_coordinate[k])

    return total


@inlined
def dissipated(m, d):
    """W, lost in the dampers."""
    total = 0.0

    for k in range(m.n_joint_spring):
        spring, damper = efforts(m, d, k)
        total -= damper * coordinates.rate(m, d, m.joint_spring_coordinate[k])

    return total
