"""Spring-dampers along the line between two markers, and inputs along it (docs/theory.md 16.6)."""

from ..language import inlined
from ..math import algebra as al
from ..motion import markers
from .elastic import damper_effort, spring_effort, stored_energy


@inlined
def pull(m, d, k):
    """Spring-damper k between two markers: (length m, its rate m/s, direction from first to second in O, tension N).

    At zero length it has no direction and pulls nowhere.
    """
    length, rate, direction = motion(m, d, k)
    spring, damper, pulled = tensions(m, d, k, length, rate)
    return length, rate, direction, spring + damper + pulled


@inlined
def motion(m, d, k):
    """(length m, its rate m/s, direction from first to second in O) of strut k."""
    a = m.strut_from[k]
    b = m.strut_to[k]
    span = al.sub(markers.position(m, d, b), markers.position(m, d, a))
    length = al.norm(span)
    direction = al.scale(1.0 / length if length > 0.0 else 0.0, span)
    return length, al.dot(direction, al.sub(markers.velocity(m, d, b), markers.velocity(m, d, a))), direction


@inlined
def keep_start_lengths(m, d):
    """Lengths of all struts at the start; needs kinematics of it."""
    for k in range(m.n_strut):
        d.strut_start[k] = motion(m, d, k)[0]


@inlined
def rest(m, d, k):
    """Rest length (m) of strut k: where the scene leaves it open and nobody has set it, the length at the start."""
    slack = m.strut_slack[k] == 1 and m.strut_rest[k] == m.strut_told[k]
    return d.strut_start[k] if slack else m.strut_rest[k]


@inlined
def tensions(m, d, k, length, rate):
    """Tensions (N) of strut k's spring, damper and input."""
    spring = spring_effort(m, m.strut_spring_table[k], m.strut_stiffness[k], rest(m, d, k), length)
    damper = damper_effort(m, m.strut_damper_table[k], m.strut_damping[k], rate)
    return spring, damper, d.input[m.strut_u[k]] if m.strut_u[k] >= 0 else 0.0


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_strut):
        a = m.strut_from[k]
        b = m.strut_to[k]
        length, rate, direction, tension = pull(m, d, k)
        force = al.scale(tension, direction)
        markers.add_wrench(m, d, m.marker_body[a], markers.position(m, d, a), al.ZERO3, force)
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), al.ZERO3, al.neg(force))


@inlined
def energy(m, d):
    """J, stored."""
    total = 0.0

    for k in range(m.n_strut):
        length = motion(m, d, k)[0]
        total += stored_energy(m, m.strut_spring_table[k], m.strut_stiffness[k], rest(m, d, k), length)

    return total


@inlined
def power_of(m, d, k):
    """W, of strut k on the bodies."""
    length, rate, direction, tension = pull(m, d, k)
    return -tension * rate


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_strut):
        total += power_of(m, d, k)

    return total


@inlined
def supplied(m, d):
    """W, by the inputs."""
    total = 0.0

    for k in range(m.n_strut):
        if m.strut_u[k] >= 0:
            length, rate, direction = motion(m, d, k)
            total -= d.input[m.strut_u[k]] * rate

    return total


@inlined
def dissipated(m, d):
    """W, lost in the dampers."""
    total = 0.0

    for k in range(m.n_strut):
        length, rate, direction = motion(m, d, k)
        spring, damper, pulled = tensions(m, d, k, length, rate)
        total += damper * rate

    return total
