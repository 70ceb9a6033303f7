"""The fixed joint, and any joint that is held: its acceleration is known and part of the bias, so that it is rigid."""

from ..language import inlined
from ..math import algebra as al
from ..status import OK
from . import passing


@inlined
def move(m, d, i, F, w_parent, arm):
    """Orientation, angular velocity and bias of body i. Returns (arm, relative velocity, bias) of its origin."""
    d.held[i] = 1.0
    al.set_mat3(d.A, i, F)
    al.set_vec3(d.w, i, w_parent)
    al.set_vec3(d.bias_w, i, al.ZERO3)
    spin = al.cross(w_parent, arm)
    return arm, spin, al.cross(w_parent, spin)


@inlined
def articulate(m, d, i, I, H, M, moment, force):
    """All inertia, and what it takes to accelerate it with the bias, go to the parent. Returns a status."""
    parent = m.body_parent[i]
    bias_w = al.vec3(d.bias_w, i)
    bias_r = al.vec3(d.bias_r, i)
    moment = al.add(moment, al.add(al.sym_vec(I, bias_w), al.mat_vec(H, bias_r)))
    force = al.add(force, al.add(al.matT_vec(H, bias_w), al.sym_vec(M, bias_r)))

    if parent > 0:
        arm = al.vec3(d.arm, i)
        passing.add_inertia(d, parent, arm, I, H, M)
        passing.add_wrench(d, parent, arm, moment, force)

    return OK


@inlined
def pass_wrench(m, d, p, i, at, n):
    """No response, p[at:at+n] = 0. Returns what is left of the wrench: (True: something, moment, force), all of it."""
    for k in range(n):
        p[at + k] = 0.0

    return True, al.vec3(d.passed_moment, i), al.vec3(d.passed_force, i)


@inlined
def respond(m, d, i, n, alpha, rdd):
    """No change of its n coordinates' v'; (alpha, rdd) as they are."""
    for k in range(n):
        d.change[m.body_v[i] + k] = 0.0

    return alpha, rdd
