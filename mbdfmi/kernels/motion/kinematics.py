"""Poses, velocities and accelerations of all bodies from the joints' coordinates, root to leaves.

Every spatial quantity is in inertial axes about the origin of its own body, and accelerations are classical instead of spatial
(so that `alpha` and `rdd` are what an accelerometer at the origin shows). Transforms between bodies are then pure
shifts by `arm` (docs/theory.md 1.4 and 3.1).
"""

from .. import joints
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..signatures import DATA, MODEL, void


@apart(void(MODEL, DATA))
def kinematics(m, d):
    """Poses, velocities and biases of all bodies from d.q and d.v."""
    al.set_vec3(d.r, 0, al.ZERO3)
    al.set_vec3(d.rd, 0, al.ZERO3)
    al.set_vec3(d.w, 0, al.ZERO3)
    al.set_mat3(d.A, 0, al.IDENTITY3)

    for i in range(1, m.n_body):
        joints.move(m, d, i)

        if d.held[i] > 0.0:
            joints.add_given_acceleration(m, d, i)


@inlined
def carried(m, d, i):
    """(alpha, rdd) that body i has by its parent's, with its joint's v' = 0; needs kinematics."""
    parent = m.body_parent[i]
    alpha_parent = al.vec3(d.alpha, parent)
    alpha = al.add(alpha_parent, al.vec3(d.bias_w, i))
    rdd = al.add(al.vec3(d.rdd, parent), al.cross(alpha_parent, al.vec3(d.arm, i)))
    return alpha, al.add(rdd, al.vec3(d.bias_r, i))


@kernel
def accelerations(m, d):
    """alpha and rdd of all bodies from the v' in d.v_rate; needs kinematics."""
    al.set_vec3(d.alpha, 0, al.ZERO3)
    al.set_vec3(d.rdd, 0, al.ZERO3)

    for i in range(1, m.n_body):
        alpha, rdd = carried(m, d, i)

        # a given acceleration is in the bias already
        for k in range(joints.n_v(m.body_joint[i]) if d.held[i] == 0.0 else 0):
            S_w, S_r = joints.subspace(m, d, i, k)
            rate = d.v_rate[m.body_v[i] + k]
            alpha = al.axpy(rate, S_w, alpha)
            rdd = al.axpy(rate, S_r, rdd)

        al.set_vec3(d.alpha, i, alpha)
        al.set_vec3(d.rdd, i, rdd)
