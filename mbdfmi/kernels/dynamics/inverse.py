"""Inverse dynamics: what passes through the joints, and their efforts (RNEA; docs/theory.md 6.1)."""

from .. import joints
from ..forces import added_mass, shared_water
from ..joints import passing, rotors
from ..language import apart, kernel
from ..math import algebra as al
from ..motion import kinematics
from ..signatures import DATA, MODEL, void
from . import inertia


@apart(void(MODEL, DATA))
def joint_wrenches(m, d):
    """Wrench on every body through the joint to its parent, about the body's origin, into bias_moment and bias_force.

    What the accelerations alpha and rdd of all bodies need beside the applied wrenches; needs inertias.
    """
    added_mass.add_reactions(m, d)

    if m.n_shared_water > 0:
        shared_water.add_needs(m, d)

    for i in range(1, m.n_body):
        alpha = al.vec3(d.alpha, i)
        rdd = al.vec3(d.rdd, i)
        I, H, M = inertia.inertia_blocks(m, d, i)
        moment = al.add(al.sym_vec(I, alpha), al.mat_vec(H, rdd))
        force = al.add(al.matT_vec(H, alpha), al.sym_vec(M, rdd))
        al.add_vec3(d.bias_moment, i, al.sub(moment, al.vec3(d.moment, i)))
        al.add_vec3(d.bias_force, i, al.sub(force, al.vec3(d.force, i)))

    for k in range(m.n_rotor):
        al.add_vec3(d.bias_moment, rotors.host(m, m.rotor_body[k]), rotors.reaction(m, d, m.rotor_body[k]))

    for i in range(m.n_body - 1, 0, -1):
        if m.body_parent[i] > 0:
            moment = al.vec3(d.bias_moment, i)
            passing.add_wrench(d, m.body_parent[i], al.vec3(d.arm, i), moment, al.vec3(d.bias_force, i))


@kernel
def rnea(m, d, tau):
    """Inverse dynamics: the joint efforts tau[n_v] that give the v' in d.v_rate, beside the applied wrenches.

    Needs kinematics, inertias, applied wrenches (docs/theory.md 6.1; Featherstone 2008, table 5.1).
    """
    kinematics.accelerations(m, d)
    joint_wrenches(m, d)

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i])):
            S_w, S_r = joints.subspace(m, d, i, k)
            power = al.dot(S_w, al.vec3(d.bias_moment, i)) + al.dot(S_r, al.vec3(d.bias_force, i))
            tau[m.body_v[i] + k] = power

        if rotors.has(m, i):
            tau[m.body_v[i]] += rotors.effort(m, d, i)
