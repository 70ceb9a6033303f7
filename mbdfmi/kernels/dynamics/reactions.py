"""Reactions: the wrench that a joint passes on to its second marker's body (docs/theory.md 17).

It is all that the bodies of the joint exert on each other through it: what keeps it together and what acts in it (spring,
damper, friction, stop, input, drive, coupling), so that Newton's and Euler's equations of a body hold with the
reactions of its joints and the loads beside them. For a joint of the tree it is what the bodies behind it need beyond what
is applied to them; for one that closes a loop, its rows' wrenches times their multipliers.
"""

from .. import forces, joints
from ..joints import rotors
from ..language import inlined, kernel
from ..math import algebra as al
from ..motion import coordinates, drives, markers
from . import inertia, inverse, rows


@inlined
def add_coupling_efforts(m, d, row, factor):
    """Efforts of a coupling, or of a drive of a joint that closes a loop, in the joints that it acts in."""
    for t in range(m.row_term[row], rows.last_term(m, row)):
        coordinates.add_effort(m, d, m.term_coordinate[t], factor * m.term_factor[t])


@kernel
def find_joint_wrenches(m, d):
    """`inverse.joint_wrenches` with the constraints' wrenches; needs accelerations and multipliers.

    Leaves in tau and coordinate_effort what acts along the joints' coordinates beside the drives of joints in the tree.
    """
    inertia.inertias(m, d)
    forces.apply(m, d)

    for row in range(m.n_row):
        c = m.row_constraint[row]
        factor = d.multiplier[row]

        if m.row_kind[row] == rows.COUPLING:
            add_coupling_efforts(m, d, row, factor)
            continue

        a = m.marker_body[m.constraint_from[c]]
        b = m.marker_body[m.constraint_to[c]]
        al.add_vec3(d.moment, a, al.scale(factor, al.vec3(d.row_moment_from, row)))
        al.add_vec3(d.force, a, al.scale(factor, al.vec3(d.row_force_from, row)))
        al.add_vec3(d.moment, b, al.scale(factor, al.vec3(d.row_moment_to, row)))
        al.add_vec3(d.force, b, al.scale(factor, al.vec3(d.row_force_to, row)))

    inverse.joint_wrenches(m, d)


@inlined
def loop_wrench(m, d, c):
    """Wrench of constraint c on its second marker's body: (moment about the marker's origin, force), inertial axes."""
    a = m.constraint_from[c]
    b = m.constraint_to[c]
    moment = al.ZERO3
    force = al.ZERO3

    for row in range(m.constraint_row[c], m.constraint_row[c] + m.constraint_rows[c]):
        moment = al.axpy(d.multiplier[row], al.vec3(d.row_moment_to, row), moment)
        force = al.axpy(d.multiplier[row], al.vec3(d.row_force_to, row), force)

    moment = al.sub(moment, al.cross(markers.arm(m, d, b), force))

    # what acts in the joint, whose markers no other has
    for k in range(m.n_coordinate):
        if m.coordinate_kind[k] != coordinates.IN_TREE and m.coordinate_from[k] == a:
            A = markers.axes(m, d, a)
            slides = m.coordinate_kind[k] == coordinates.SLIDE
            z = (A[0][2], A[1][2], A[2][2])

            if m.coordinate_kind[k] == coordinates.PARAMETER:
                slides = True
                z = coordinates.along(m, d, k)

            along = al.scale(d.coordinate_effort[k], z)

            if slides:
                force = al.add(force, along)
            else:
                moment = al.add(moment, along)

    return moment, force


@inlined
def tree_wrench(m, d, i, b):
    """Wrench on body i through the joint to its parent: (moment about marker b's origin, force), inertial axes."""
    force = al.vec3(d.bias_force, i)
    lever = al.sub(al.vec3(d.r, i), markers.position(m, d, b))
    return al.add(al.vec3(d.bias_moment, i), al.cross(lever, force)), force


@inlined
def reaction(m, d, k):
    """Reaction k on its joint's second marker: (moment about the marker's origin N m, force N), in the first marker's axes.

    Needs find_joint_wrenches.
    """
    a = m.reaction_from[k]
    b = m.reaction_to[k]
    i = m.reaction_body[k]
    A = markers.axes(m, d, a)

    if i >= 0:
        moment, force = tree_wrench(m, d, i, b)

        if m.body_reversed[i] == 1:
            moment = al.neg(moment)
            force = al.neg(force)
    else:
        moment, force = loop_wrench(m, d, m.reaction_constraint[k])

    moment = al.matT_vec(A, moment)

    if m.reaction_input[k] >= 0:
        moment = al.add(moment, al.vec_at(d.input, m.wrench_moment[m.reaction_input[k]]))

    return moment, al.matT_vec(A, force)


@kernel
def on_ground(m, d, ground):
    """What all joints and forces together exert on the ground: (moment about its origin N m, force N), in its axes.

    ground : its node. One that moves is a body of its own: it bears the contrary of what moves it. Needs find_joint_wrenches.
    """
    if ground > 0:
        A = al.mat3(d.A, ground)
        moment = al.neg(al.vec3(d.bias_moment, ground))
        return al.matT_vec(A, moment), al.matT_vec(A, al.neg(al.vec3(d.bias_force, ground)))

    # weight of what is fixed to it, forces on it, rotors that it bears, joints
    g = al.vec3(m.gravity, 0)
    moment = al.add(al.vec3(d.moment, 0), al.cross(al.vec3(d.body_h, 0), g))
    moment = al.sub(moment, al.vec3(d.bias_moment, 0))
    force = al.axpy(d.body_m[0], g, al.vec3(d.force, 0))

    for i in range(1, m.n_body):
        if m.body_parent[i] == 0:
            passed = al.vec3(d.bias_force, i)
            moment = al.sub(moment, al.add(al.vec3(d.bias_moment, i), al.cross(al.vec3(d.r, i), passed)))
            force = al.sub(force, passed)

    return moment, force


@inlined
def held_effort(m, d, i):
    """Effort (N m or N) with which a drive holds the joint of body i, of one freedom, beside all else that acts along it.

    Needs find_joint_wrenches.
    """
    S_w, S_r = joints.subspace(m, d, i, 0)
    borne = al.dot(S_w, al.vec3(d.bias_moment, i)) + al.dot(S_r, al.vec3(d.bias_force, i))

    if rotors.has(m, i):
        borne += rotors.effort(m, d, i)

    return borne - d.tau[m.body_v[i]]


@inlined
def drive_effort(m, d, k):
    """Effort (N m or N) with which a drive holds coordinate k to its motion, beside all else that acts along it.

    Needs find_joint_wrenches.
    """
    if m.coordinate_kind[k] == coordinates.IN_TREE:
        return held_effort(m, d, m.coordinate_body[k])

    effort = 0.0

    for row in range(m.n_row):
        if m.row_drive[row] >= 0 and m.term_coordinate[m.row_term[row]] == k:
            effort += m.term_factor[m.row_term[row]] * d.multiplier[row]

    return effort


@kernel
def power_of_drives(m, d):
    """Power (W) of all drives of joints and of what moves the ground; needs find_joint_wrenches."""
    power = 0.0

    for k in range(m.n_drive):
        i = m.drive_body[k]

        if i >= 0 and m.drive_kind[k] < drives.GROUND_ACCELERATION:
            power += held_effort(m, d, i) * d.v[m.body_v[i]]
        elif i >= 0:
            power += al.dot(al.vec3(d.bias_moment, i), al.vec3(d.w, i))
            power += al.dot(al.vec3(d.bias_force, i), al.vec3(d.rd, i))

    for row in range(m.n_row):
        if m.row_drive[row] >= 0:
            t = m.row_term[row]
            power += m.term_factor[t] * d.multiplier[row] * coordinates.rate(m, d, m.term_coordinate[t])

    return power
