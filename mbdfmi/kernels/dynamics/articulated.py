"""Dynamics by articulated bodies: forward dynamics (ABA), and how constraint rows move the joints.

After Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 7 (docs/theory.md 6.2 and 6.3). With
M = L_M L_M^T the joint-space inertia and C the rows' Jacobian, every row's response is kept whitened, R = C L_M^-T:
the articulated-body factor gives it in one pass from a row's bodies to the ground (the innovations form of the
operational-space inertia, docs/theory.md 6.4), and only in the joints on that way. embedding.py has the same face by
the joint-space matrix.

Legend: I, H, M blocks of a 6x6 inertia: moment = I alpha + H rdd, force = H^T alpha + M rdd; suffix _a:
articulated (ABA) or composite (CRBA). For a rigid body H = h x, M = m 1. S motion subspace, U = I_a S, D = S^T U.
"""

from .. import joints
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import kinematics, markers
from ..status import OK
from ..signatures import DATA, MODEL, boolean, int64, void
from . import inertia, multipliers, rows


@apart(int64(MODEL, DATA))
def aba(m, d):
    """Forward dynamics by articulated bodies: v' into d.v_rate, alpha and rdd of all bodies. Returns a status.

    Needs kinematics, inertias, applied wrenches (moment, force), efforts tau (docs/theory.md 6.2; Featherstone
    2008, table 7.1).
    """
    inertia.start_articulated(m, d)

    # articulated inertias and bias wrenches, leaves to root
    for i in range(m.n_body - 1, 0, -1):
        moment = al.sub(al.vec3(d.bias_moment, i), al.vec3(d.moment, i))
        force = al.sub(al.vec3(d.bias_force, i), al.vec3(d.force, i))
        failure = joints.articulate(m, d, i, moment, force)

        if failure != OK:
            return failure

    # accelerations, root to leaves
    al.set_vec3(d.alpha, 0, al.ZERO3)
    al.set_vec3(d.rdd, 0, al.ZERO3)

    for i in range(1, m.n_body):
        alpha, rdd = kinematics.carried(m, d, i)
        alpha, rdd = joints.accelerate(m, d, i, alpha, rdd)
        al.set_vec3(d.alpha, i, alpha)
        al.set_vec3(d.rdd, i, rdd)

    return OK


@kernel
def read_pivots(m, d, p):
    """The pivots of the joints' inertias that aba has left, to p[n_v]; 1 where joints are held."""
    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i])):
            p[m.body_v[i] + k] = 1.0 if d.held[i] > 0.0 else joints.pivot(m, d, i, k)


@inlined
def size_in_joint(m, d, r, i):
    """What the wrench on its way past joint i could move there if it met the axis. r : m, where its force acts."""
    kind = m.body_joint[i]

    if d.held[i] > 0.0 or not joints.is_one_axis(kind):
        return 0.0

    lever = al.sub(r, al.vec3(d.r, i))
    effort = joints.largest_effort(kind, al.vec3(d.passed_moment, i), al.vec3(d.passed_force, i), lever)
    return effort * (1.0 / d.D[6 * i])


@apart(void(MODEL, DATA, boolean))
def respond_to_rows(m, d, everything):
    """R: whitened responses of the rows, the redundant ones only with `everything`.

    Needs write_rows and the articulated inertias of aba.
    """
    for c in range(m.n_constraint):
        first = m.constraint_path[c]
        end = first + m.constraint_paths[c]
        body_a = m.marker_body[m.constraint_from[c]]
        body_b = m.marker_body[m.constraint_to[c]]
        r = markers.position(m, d, m.constraint_to[c])
        noise = 0.0

        # what the wrenches of a row's two sides could do if they, which cancel below a loop, did not
        for step in range(first, end):
            i = m.path_node[step]
            noise += joints.compliance(m, d, i, multipliers.arm_square(d, i, r))

        d.constraint_noise[c] = noise

        for k in range(m.constraint_rows[c]):
            row = m.constraint_row[c] + k
            at = m.constraint_response[c] + k * m.constraint_width[c]

            if multipliers.is_idle(d, row, everything):
                continue

            size = 0.0
            al.set_vec3(d.passed_moment, 0, al.ZERO3)
            al.set_vec3(d.passed_force, 0, al.ZERO3)

            for step in range(first, end):
                al.set_vec3(d.passed_moment, m.path_node[step], al.ZERO3)
                al.set_vec3(d.passed_force, m.path_node[step], al.ZERO3)

            al.add_vec3(d.passed_moment, body_a, al.vec3(d.row_moment_from, row))
            al.add_vec3(d.passed_force, body_a, al.vec3(d.row_force_from, row))
            al.add_vec3(d.passed_moment, body_b, al.vec3(d.row_moment_to, row))
            al.add_vec3(d.passed_force, body_b, al.vec3(d.row_force_to, row))

            for t in range(m.row_term[row] + 1, rows.last_term(m, row)):
                if rows.body_of_term(m, t) == 0:
                    from_t, to_t = rows.bodies_of_term(m, t)
                    al.add_vec3(d.passed_moment, from_t, al.vec3(d.term_moment_from, t))
                    al.add_vec3(d.passed_force, from_t, al.vec3(d.term_force_from, t))
                    al.add_vec3(d.passed_moment, to_t, al.vec3(d.term_moment_to, t))
                    al.add_vec3(d.passed_force, to_t, al.vec3(d.term_force_to, t))

            for step in range(end - 1, first - 1, -1):
                i = m.path_node[step]
                size += size_in_joint(m, d, r, i)
                joints.pass_wrench(m, d, d.response, i, at + m.path_at[step], rows.effort_on(m, row, i))

            d.row_size[row] = size


@kernel
def whiten_wrenches(m, d):
    """Whitened efforts d.white of wrenches on all bodies (passed_moment, passed_force), which are gone then."""
    for i in range(m.n_body - 1, 0, -1):
        joints.pass_wrench(m, d, d.white, i, m.body_v[i], 0.0)


@inlined
def respond(m, d):
    """Changes of v' (or of v, or q) and of the bodies' accelerations by the whitened efforts d.white."""
    al.set_vec3(d.change_alpha, 0, al.ZERO3)
    al.set_vec3(d.change_rdd, 0, al.ZERO3)

    for i in range(1, m.n_body):
        alpha = al.vec3(d.change_alpha, m.body_parent[i])
        rdd = al.add(al.vec3(d.change_rdd, m.body_parent[i]), al.cross(alpha, al.vec3(d.arm, i)))
        alpha, rdd = joints.respond(m, d, i, alpha, rdd)
        al.set_vec3(d.change_alpha, i, alpha)
        al.set_vec3(d.change_rdd, i, rdd)
