"""Force elements, a file each: what acts on the bodies beside weight and what joins them (docs/theory.md 16).

Each has, where it means something, all needing kinematics:

    add         its wrenches and efforts, onto moment, force, tau (which `inertias` began with weight)
    energy      J, stored
    power       W, with which it works on the bodies
    supplied    W of that, from outside, by inputs and loads (of inputs and loads alone: all of their power)
    dissipated  W, lost

so that power = supplied - dissipated - the rate of the energy, which one test asks of every element. To add one: a file with these,
its rows in layout.py, a line in each list below (docs/contributing.md).
"""

from ..language import apart, inlined, kernel
from ..motion import coordinates
from ..signatures import DATA, MODEL, void
from . import (
    catenaries,
    central_gravity,
    composite_lines,
    effort_inputs,
    friction,
    gravity_gradient,
    hydrostatics,
    joint_springs,
    loads,
    members,
    radiation,
    resistance,
    six_by_six,
    stops,
    struts,
    waves,
    wind_rotors,
    wrench_inputs,
)


@inlined
def add_along_coordinates(m, d):
    """All elements that act along joint coordinates."""
    for k in range(m.n_coordinate):
        d.coordinate_effort[k] = 0.0

    joint_springs.add(m, d)
    friction.add(m, d)
    stops.add(m, d)
    effort_inputs.add(m, d)


@apart(void(MODEL, DATA))
def apply(m, d):
    """Add all force elements and inputs to tau, moment and force."""
    for v in range(m.n_v):
        d.tau[v] = 0.0

    if m.n_coordinate > 0:
        add_along_coordinates(m, d)

    struts.add(m, d)
    six_by_six.add(m, d)
    wrench_inputs.add(m, d)
    loads.add(m, d)
    central_gravity.add(m, d)
    gravity_gradient.add(m, d)
    hydrostatics.add(m, d)
    catenaries.add(m, d)
    composite_lines.add(m, d)
    radiation.add(m, d)
    resistance.add(m, d)
    waves.add(m, d)
    wind_rotors.add(m, d)
    members.add(m, d)


@kernel
def stored_energy(m, d):
    """Energy (J) stored in springs, stops, 6x6 forces, lines and water; that of central gravity is told apart, with the weight's."""
    elastic = joint_springs.energy(m, d) + stops.energy(m, d) + struts.energy(m, d) + six_by_six.energy(m, d)
    return elastic + hydrostatics.energy(m, d) + catenaries.energy(m, d) + composite_lines.energy(m, d)


@kernel
def supplied_by_inputs(m, d):
    """Power (W) of all efforts, forces and moments that are inputs."""
    return effort_inputs.power(m, d) + struts.supplied(m, d) + wrench_inputs.power(m, d)


@kernel
def dissipated(m, d):
    """Power (W) that is lost in dampers, friction, stops, damping, waves made, and lines on the bed."""
    power = joint_springs.dissipated(m, d) + friction.dissipated(m, d) + stops.dissipated(m, d)
    return (
        power
        + struts.dissipated(m, d)
        + six_by_six.dissipated(m, d)
        + radiation.dissipated(m, d)
        + resistance.dissipated(m, d)
        + composite_lines.dissipated(m, d)
        + members.dissipated(m, d)
    )


@kernel
def effort_along(m, d, c):
    """Effort (N m or N) of all that acts along coordinate c but the drive: springs, dampers, friction, stops, inputs."""
    effort = joint_springs.effort_along(m, d, c) + friction.effort_along(m, d, c)
    effort += stops.effort_along(m, d, c) + effort_inputs.effort_along(m, d, c)
    return effort


@kernel
def power_along(m, d, c):
    """Power (W) of that."""
    return effort_along(m, d, c) * coordinates.rate(m, d, c)
