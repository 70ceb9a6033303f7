"""What virtual inertia (virtual.py) made wrong in the accelerations is put right (docs/theory.md 14.2).

With E the inertia lent, the factors are those of M + E. The motion is found as if wrenches E a acted on the bodies that were lent it, a
their accelerations: then the equations are those of M alone. These wrenches are found by conjugate gradients: of the
equations M v' = f + C^T lambda, C v' = b, preconditioned by those of M + E, whose residuals are wrenches on these
bodies alone. Of a part that neither inertia nor anything else determines, the search shows that M has none along it: where something acts
along it, there is no such motion; where nothing does, as about the axis of a rod between two ball joints, it stays as it is.
"""

import math


from .. import joints
from ..joints import virtual
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..status import NOT_FINITE, OK, SINGULAR_INERTIA, status
from ..signatures import DATA, MODEL, int64, void
from . import articulated, embedding, multipliers

MAX_ITERATIONS = 200

# part of its virtual inertia that a motion has in truth, below which it has none
NOTHING = 1e-9

# to what part a motion without inertia, as the search finds it, is a turn
ABOUT = 1e-3

# of the loads at work, squared: what is left where the search ends; and what acts on a motion without inertia
DONE = 1e-36
ACTS = 1e-18


@apart(void(MODEL, DATA))
def respond(m, d):
    """What wrenches on all bodies (passed_moment, passed_force) change in the accelerations, constraints kept, and in the multipliers."""
    if m.embeds == 1:
        embedding.whiten_wrenches(m, d)
    else:
        articulated.whiten_wrenches(m, d)

    for row in range(m.n_row):
        d.row_rhs[row] = -multipliers.row_of_white(m, d, row)

    multipliers.solve_rows(m, d)
    multipliers.add_white(m, d)

    if m.embeds == 1:
        embedding.respond(m, d)
    else:
        articulated.respond(m, d)


@inlined
def pass_on(m, d, moment, force):
    """Wrenches of all bodies to where `respond` takes them from."""
    for k in range(3 * m.n_body):
        d.passed_moment[k] = moment[k]
        d.passed_force[k] = force[k]


@inlined
def power(m, moment, force, alpha, rdd):
    """Of wrenches on all bodies along accelerations."""
    total = 0.0

    for k in range(3 * m.n_body):
        total += moment[k] * alpha[k] + force[k] * rdd[k]

    return total


@inlined
def lent_norm(m, d, alpha, rdd):
    """a . E a."""
    total = 0.0

    for i in range(1, m.n_body):
        w = al.vec3(alpha, i)
        a = al.vec3(rdd, i)
        total += d.lent_inertia[i] * al.dot(w, w) + d.lent_mass[i] * al.dot(a, a)

    return total


@inlined
def loads(m, d):
    """What acts, as the power of its forces on the mass lent: the measure of what is next to nothing. Needs the wrenches left."""
    mass, inertia = virtual.measure(m, d)
    force = 0.0
    moment = 0.0

    for i in range(1, m.n_body):
        w = al.vec3(d.w, i)
        turned = al.dot(w, w) + al.norm(al.vec3(d.alpha, i))
        force += (
            al.norm(al.vec3(d.force, i))
            + d.body_m[i] * al.norm(al.vec3(d.rdd, i))
            + al.norm(al.vec3(d.left_force, i))
        )
        moment += al.norm(al.vec3(d.moment, i)) + al.norm(al.vec3(d.left_moment, i))
        moment += (d.I[6 * i] + d.I[6 * i + 1] + d.I[6 * i + 2]) * turned

    for v in range(m.n_v):
        moment += abs(d.tau[v])

    force += moment * math.sqrt(mass / inertia)
    return force * force / mass


@inlined
def blamed(m, d):
    """The body whose virtual inertia moves most in the direction of the search."""
    worst = 1
    most = 0.0

    for i in range(1, m.n_body):
        w = al.vec3(d.push_alpha, i)
        a = al.vec3(d.push_rdd, i)
        size = d.lent_inertia[i] * al.dot(w, w) + d.lent_mass[i] * al.dot(a, a)

        if size > most:
            worst = i
            most = size

    return worst


@kernel
def push_joint(m, d, i, k):
    """Response to a unit effort along coordinate k of body i's joint. Returns its rate."""
    for j in range(3 * m.n_body):
        d.passed_moment[j] = 0.0
        d.passed_force[j] = 0.0

    S_w, S_r = joints.subspace(m, d, i, k)
    parent = m.body_parent[i]
    al.set_vec3(d.passed_moment, i, S_w)
    al.set_vec3(d.passed_force, i, S_r)
    al.set_vec3(d.passed_moment, parent, al.neg(al.add(S_w, al.cross(al.vec3(d.arm, i), S_r))))
    al.set_vec3(d.passed_force, parent, al.neg(S_r))
    respond(m, d)
    return d.change[m.body_v[i] + k]


@inlined
def leave(m, d, alpha, rdd):
    """The wrenches E a to those left."""
    for i in range(m.n_body):
        al.set_vec3(d.left_moment, i, al.scale(d.lent_inertia[i], al.vec3(alpha, i)))
        al.set_vec3(d.left_force, i, al.scale(d.lent_mass[i], al.vec3(rdd, i)))
        al.set_vec3(d.given_moment, i, al.ZERO3)
        al.set_vec3(d.given_force, i, al.ZERO3)


@inlined
def turns_about_a_point(m, d, i):
    """Whether the direction of the search turns body i about a point of its own: it neither slides nor screws."""
    mass, inertia = virtual.measure(m, d)
    length = math.sqrt(inertia / mass)
    w = al.vec3(d.push_alpha, i)
    v = al.vec3(d.push_rdd, i)
    size = al.norm(w) * length + al.norm(v)
    return al.norm(w) * length > ABOUT * size and abs(al.dot(w, v)) <= ABOUT * al.norm(w) * size


@kernel
def is_determined(m, d, i):
    """Whether inertia, constraints or what else there is determine the motion in the joint of body i, which was lent inertia.

    Turns of which nothing is felt are allowed to parts on spherical or free joints, unless these have no mass and may turn as they like.
    """
    kind = m.body_joint[i]
    idle = 0

    for k in range(joints.n_v(kind)):
        rate = push_joint(m, d, i, k)
        turns = joints.turns(kind, k)
        lent = max(d.lent_inertia[i], d.lent_mass[i])

        # held by constraints
        if not rate * lent > NOTHING:
            continue

        if turns:
            idle += 1 if lent_norm(m, d, d.change_alpha, d.change_rdd) >= (1.0 - NOTHING) * rate else 0
            continue

        leave(m, d, d.change_alpha, d.change_rdd)

        if search(m, d, rate) != OK and not (kind == joints.FREE and turns_about_a_point(m, d, i)):
            return False

    return idle < 3 or d.body_m[i] > 0.0


@apart(int64(MODEL, DATA))
def give_back(m, d):
    """Accelerations and multipliers of M + E to those of M. Returns a status."""
    for row in range(m.n_row):
        d.multiplier_kept[row] = d.multiplier[row]

    for i in range(m.n_body - 1, 0, -1):
        if d.lent_known[i] == 0.0 and d.lent_mass[i] + d.lent_inertia[i] > 0.0 and d.held[i] == 0.0:
            if not is_determined(m, d, i):
                return status(SINGULAR_INERTIA, i)

            d.lent_known[i] = 1.0

    leave(m, d, d.alpha, d.rdd)
    failure = search(m, d, loads(m, d))

    if failure == OK:
        # what is left moves nothing, but constraints bear it
        for k in range(3 * m.n_body):
            d.given_moment[k] += d.left_moment[k]
            d.given_force[k] += d.left_force[k]

        pass_on(m, d, d.given_moment, d.given_force)
        respond(m, d)
        multipliers.add_changes(m, d)

        for row in range(m.n_row):
            d.multiplier[row] += d.multiplier_kept[row]

    return failure


@kernel
def search(m, d, size):
    """The wrenches that the lent inertia must not take, into given_moment and given_force, from those left. Returns a status.

    size : of what is next to nothing.
    """
    n = 3 * m.n_body
    before = 0.0
    left = 0.0

    for iteration in range(MAX_ITERATIONS):
        pass_on(m, d, d.left_moment, d.left_force)
        respond(m, d)
        left = power(m, d.left_moment, d.left_force, d.change_alpha, d.change_rdd)

        if not left < math.inf:
            return status(NOT_FINITE, 0)

        if left <= DONE * size:
            return OK

        turn = left / before if iteration > 0 else 0.0
        before = left

        for k in range(n):
            d.push_moment[k] = d.left_moment[k] + (turn * d.push_moment[k] if iteration > 0 else 0.0)
            d.push_force[k] = d.left_force[k] + (turn * d.push_force[k] if iteration > 0 else 0.0)
            d.push_alpha[k] = d.change_alpha[k] + (turn * d.push_alpha[k] if iteration > 0 else 0.0)
            d.push_rdd[k] = d.change_rdd[k] + (turn * d.push_rdd[k] if iteration > 0 else 0.0)

        work = power(m, d.push_moment, d.push_force, d.push_alpha, d.push_rdd)
        true = work - lent_norm(m, d, d.push_alpha, d.push_rdd)

        if true <= NOTHING * work:
            return OK if left <= ACTS * size else status(SINGULAR_INERTIA, blamed(m, d))

        step = left / true

        for i in range(1, m.n_body):
            taken = al.scale(-d.lent_inertia[i], al.vec3(d.push_alpha, i))
            al.add_vec3(d.given_moment, i, al.scale(step, al.vec3(d.push_moment, i)))
            al.add_vec3(d.left_moment, i, al.scale(-step, al.add(al.vec3(d.push_moment, i), taken)))
            taken = al.scale(-d.lent_mass[i], al.vec3(d.push_rdd, i))
            al.add_vec3(d.given_force, i, al.scale(step, al.vec3(d.push_force, i)))
            al.add_vec3(d.left_force, i, al.scale(-step, al.add(al.vec3(d.push_force, i), taken)))

    return OK if left <= ACTS * size else status(SINGULAR_INERTIA, blamed(m, d))
