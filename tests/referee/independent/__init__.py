"""A second route to the motion of a scene over the whole schema, that shares nothing with the package.

It reads the dict of a scene's TOML file by docs/scene.md alone and writes down the textbook: absolute
coordinates of every body, each joint a few equations between two frames, one dense system [M C^T; C 0] for
accelerations and multipliers (Haug 1989, section 11.3). There is no tree, there are no joint coordinates and
no spatial shifts: fixed joints stay joints, and what the ground bears is what its joints say. Each equation
is written once, as of positions (or of velocities, where something rolls); its Jacobian and its second
derivative come from CasADi's automatic differentiation.

The dense system is solved by its singular values. Solutions that it leaves open,
as reactions of redundant joints, are known as such, and what depends on them is not told.
It does not know surfaces that touch or roll: `unknown` names these, and tests/test_touching_by_supports.py has a route of their own, by
support functions. What waves do to a body it takes from what is told.

    reading        units, axes, orientations, names; the scene in SI units
    mass           solids to mass properties
    interpolation  tables between their points; splines: those of motions
    curves         curves and surfaces by their parameters, with their derivatives
    taylor         frames and equations as functions of time about the present, and what CasADi makes of them
    contacts       end frames on curves and surfaces
    joints         the equations and the coordinates of each kind of joint
    motion         what drivers and the ground's motion ask for
    efforts        springs, dampers, friction and stops
    elements       forces between two frames, loads, inputs, added mass
    lines          lines by bisection, drag on members
    hulls          what water carries, by convex bodies
    wind           rotors in the wind by splines of their tables, bodies that make waves
    acting         which of these a force of the scene is
    system         System: all of it together
    instant        its solution at one instant
    outputs        what can be told of a solution
    starts         where start values alone put the bodies
    simulate       a run by scipy, kept on the constraints
"""

from .system import System, unknown

__all__ = ["System", "unknown"]
