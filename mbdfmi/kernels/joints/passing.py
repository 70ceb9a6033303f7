"""What a body passes on to its parent over the arm between their origins: inertia and wrenches."""

from ..language import inlined
from ..math import algebra as al
from ..status import NOT_FINITE, SINGULAR_INERTIA, status


@inlined
def add_inertia(d, parent, r, I, H, M):
    """Add the inertia (I, H, M) of a child at arm r to the parent's I_a, H_a, M_a.

    [I H; H^T M] seen from the parent (docs/theory.md 5.2): K = H + r~ M, I' = I + r~ H^T - K r~
    (entry ij: I_ij + (r x H_j)_i + (r x K_i)_j).
    """
    K = al.mat_add(H, al.cross_mat(r, al.mat_of_sym(M)))
    rH_0 = al.cross(r, H[0])
    rH_1 = al.cross(r, H[1])
    rH_2 = al.cross(r, H[2])
    rK_0 = al.cross(r, K[0])
    rK_1 = al.cross(r, K[1])
    rK_2 = al.cross(r, K[2])
    shifted = (
        I[0] + rH_0[0] + rK_0[0],
        I[1] + rH_1[1] + rK_1[1],
        I[2] + rH_2[2] + rK_2[2],
        I[3] + rH_1[0] + rK_0[1],
        I[4] + rH_2[0] + rK_0[2],
        I[5] + rH_2[1] + rK_1[2],
    )
    al.set_sym3(d.I_a, parent, al.sym_add(al.sym3(d.I_a, parent), shifted))
    al.set_mat3(d.H_a, parent, al.mat_add(al.mat3(d.H_a, parent), K))
    al.set_sym3(d.M_a, parent, al.sym_add(al.sym3(d.M_a, parent), M))


@inlined
def add_wrench(d, parent, r, moment, force):
    """Add a child's bias wrench at arm r to the parent's."""
    al.add_vec3(d.bias_moment, parent, al.add(moment, al.cross(r, force)))
    al.add_vec3(d.bias_force, parent, force)


@inlined
def no_inertia(D, i):
    """Status where the inertia D about body i's joint is not positive: a NaN comes from elsewhere."""
    return status(SINGULAR_INERTIA, i) if D == D else status(NOT_FINITE, 0)
