"""Vectors, 3x3 matrices and Euler parameters as tuples.

Legend: a, b, v vectors (x, y, z); A a matrix of three rows; S a symmetric matrix
(xx, yy, zz, xy, xz, yz); E Euler parameters (E1, E2, E3, E4), scalar part last (docs/theory.md 2.1).
"""

import math

from ..language import inlined

ZERO3 = (0.0, 0.0, 0.0)
E_IDENTITY = (0.0, 0.0, 0.0, 1.0)
IDENTITY3 = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

# a difference that is this small beside what it is the difference of holds no digit
ROUNDING = 1e-14


@inlined
def add(a, b):
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@inlined
def sub(a, b):
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@inlined
def neg(a):
    """-a."""
    return (-a[0], -a[1], -a[2])


@inlined
def scale(s, a):
    """s a."""
    return (s * a[0], s * a[1], s * a[2])


@inlined
def axpy(s, a, b):
    """s a + b."""
    return (s * a[0] + b[0], s * a[1] + b[1], s * a[2] + b[2])


@inlined
def dot(a, b):
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a, b):
    """a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inlined
def norm(a):
    """|a|."""
    return math.sqrt(dot(a, a))


@inlined
def transpose(A):
    """A^T."""
    return (
        (A[0][0], A[1][0], A[2][0]),
        (A[0][1], A[1][1], A[2][1]),
        (A[0][2], A[1][2], A[2][2]),
    )


@inlined
def mat_vec(A, v):
    """A v."""
    return (dot(A[0], v), dot(A[1], v), dot(A[2], v))


@inlined
def matT_vec(A, v):
    """A^T v."""
    return (
        A[0][0] * v[0] + A[1][0] * v[1] + A[2][0] * v[2],
        A[0][1] * v[0] + A[1][1] * v[1] + A[2][1] * v[2],
        A[0][2] * v[0] + A[1][2] * v[1] + A[2][2] * v[2],
    )


@inlined
def mat_mat(A, B):
    """A B."""
    return (matT_vec(B, A[0]), matT_vec(B, A[1]), matT_vec(B, A[2]))


@inlined
def mat_add(A, B):
    """A + B."""
    return (add(A[0], B[0]), add(A[1], B[1]), add(A[2], B[2]))


@inlined
def mat_sub(A, B):
    """A - B."""
    return (sub(A[0], B[0]), sub(A[1], B[1]), sub(A[2], B[2]))


@inlined
def outer(a, b):
    """a b^T."""
    return (scale(a[0], b), scale(a[1], b), scale(a[2], b))


@inlined
def skew(a):
    """The matrix of a x."""
    return ((0.0, -a[2], a[1]), (a[2], 0.0, -a[0]), (-a[1], a[0], 0.0))


@inlined
def cross_mat(r, A):
    """r~ A: r x every column of A."""
    return (
        sub(scale(r[1], A[2]), scale(r[2], A[1])),
        sub(scale(r[2], A[0]), scale(r[0], A[2])),
        sub(scale(r[0], A[1]), scale(r[1], A[0])),
    )


@inlined
def mat_of_sym(S):
    """Symmetric S as three rows."""
    return ((S[0], S[3], S[4]), (S[3], S[1], S[5]), (S[4], S[5], S[2]))


@inlined
def sym_of_mat(A):
    """The symmetric part of A."""
    return (
        A[0][0],
        A[1][1],
        A[2][2],
        0.5 * (A[0][1] + A[1][0]),
        0.5 * (A[0][2] + A[2][0]),
        0.5 * (A[1][2] + A[2][1]),
    )


@inlined
def sym_vec(S, v):
    """S v."""
    return (
        S[0] * v[0] + S[3] * v[1] + S[4] * v[2],
        S[3] * v[0] + S[1] * v[1] + S[5] * v[2],
        S[4] * v[0] + S[5] * v[1] + S[2] * v[2],
    )


@inlined
def sym_add(S, T):
    """S + T."""
    return (S[0] + T[0], S[1] + T[1], S[2] + T[2], S[3] + T[3], S[4] + T[4], S[5] + T[5])


@inlined
def sym_sub(S, T):
    """S - T."""
    return (S[0] - T[0], S[1] - T[1], S[2] - T[2], S[3] - T[3], S[4] - T[4], S[5] - T[5])


@inlined
def sym_outer(s, a):
    """s a a^T."""
    b = scale(s, a)
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2], a[0] * b[1], a[0] * b[2], a[1] * b[2])


@inlined
def sym_rotate(A, S):
    """A S A^T, the symmetric matrix S seen in rotated axes."""
    p = sym_vec(S, A[0])
    q = sym_vec(S, A[1])
    r = sym_vec(S, A[2])
    return (dot(A[0], p), dot(A[1], q), dot(A[2], r), dot(A[0], q), dot(A[0], r), dot(A[1], r))


@inlined
def sym_point(m, c):
    """m (c.c 1 - c c^T): inertia (kg m2) about the origin of a point mass m (kg) at c (m)."""
    d = scale(m, c)
    xx = d[0] * c[0]
    yy = d[1] * c[1]
    zz = d[2] * c[2]
    return (yy + zz, xx + zz, xx + yy, -d[0] * c[1], -d[0] * c[2], -d[1] * c[2])


@inlined
def sym_factor(S):
    """LDL^T of a symmetric positive definite S: (d1, d2, d3, l21, l31, l32), d the pivots."""
    l21 = S[3] / S[0]
    l31 = S[4] / S[0]
    d2 = S[1] - l21 * S[3]
    e = S[5] - l31 * S[3]
    l32 = e / d2
    return (S[0], d2, S[2] - l31 * S[4] - l32 * e, l21, l31, l32)


@inlined
def sym_solve(F, b):
    """x of S x = b, with F = sym_factor(S)."""
    y = b[1] - F[3] * b[0]
    z = (b[2] - F[4] * b[0] - F[5] * y) / F[2]
    y = y / F[1] - F[5] * z
    return (b[0] / F[0] - F[3] * y - F[4] * z, y, z)


@inlined
def sym_is_positive(F):
    """True when all pivots of F = sym_factor(S) are positive beyond rounding (False for NaN).

    A pivot is what is left of its diagonal element: S_kk = d_k + sum_j l_kj^2 d_j.
    """
    yy = F[1] + F[3] * F[3] * F[0]
    zz = F[2] + F[4] * F[4] * F[0] + F[5] * F[5] * F[1]
    return F[0] > 0.0 and F[1] > ROUNDING * yy and F[2] > ROUNDING * zz


@inlined
def sym_whiten(F, e):
    """D^-1/2 L^-1 e with F = sym_factor(S)."""
    y = e[1] - F[3] * e[0]
    z = e[2] - F[4] * e[0] - F[5] * y
    return (e[0] / math.sqrt(F[0]), y / math.sqrt(F[1]), z / math.sqrt(F[2]))


@inlined
def sym_unwhiten(F, w):
    """L^-T D^-1/2 w: S^-1 e for w = sym_whiten(F, e)."""
    z = w[2] / math.sqrt(F[2])
    y = w[1] / math.sqrt(F[1]) - F[5] * z
    return (w[0] / math.sqrt(F[0]) - F[3] * y - F[4] * z, y, z)


@inlined
def least_pivot(F):
    """The least of the pivots of F = sym_factor(S)."""
    return min(F[0], min(F[1], F[2]))


@inlined
def sym_is_regular(S, F, size):
    """True when S, with F = sym_factor(S), is positive definite beyond the rounding of numbers of `size`.

    In some axes the pivots of a singular S are not near zero, for the rounding of a small one spoils those after it. Its smallest
    eigenvalue is: about the determinant over the sum of the principal minors of order 2.
    """
    minors = S[0] * S[1] - S[3] * S[3] + S[0] * S[2] - S[4] * S[4] + S[1] * S[2] - S[5] * S[5]
    return sym_is_positive(F) and F[0] * F[1] * F[2] > ROUNDING * size * minors


# Euler parameters


@inlined
def E_product(E, F):
    """Euler parameters of the rotation A(E) A(F)."""
    return (
        E[3] * F[0] + E[0] * F[3] + E[1] * F[2] - E[2] * F[1],
        E[3] * F[1] - E[0] * F[2] + E[1] * F[3] + E[2] * F[0],
        E[3] * F[2] + E[0] * F[1] - E[1] * F[0] + E[2] * F[3],
        E[3] * F[3] - E[0] * F[0] - E[1] * F[1] - E[2] * F[2],
    )


@inlined
def E_conjugate(E):
    """Euler parameters of the inverse rotation."""
    return (-E[0], -E[1], -E[2], E[3])


@inlined
def E_dot(E, F):
    """E . F, the four-dimensional scalar product."""
    return E[0] * F[0] + E[1] * F[1] + E[2] * F[2] + E[3] * F[3]


@inlined
def E_scale(s, E):
    """s E."""
    return (s * E[0], s * E[1], s * E[2], s * E[3])


@inlined
def E_matrix(E):
    """Rotation matrix A = B C^T / E.E (docs/theory.md 2.1).

    Orthogonal for E of any length, so the stages of an integration step need no normalisation.
    """
    s = 2.0 / E_dot(E, E)
    x = s * E[0]
    y = s * E[1]
    z = s * E[2]
    return (
        (1.0 - y * E[1] - z * E[2], x * E[1] - z * E[3], x * E[2] + y * E[3]),
        (x * E[1] + z * E[3], 1.0 - x * E[0] - z * E[2], y * E[2] - x * E[3]),
        (x * E[2] - y * E[3], y * E[2] + x * E[3], 1.0 - x * E[0] - y * E[1]),
    )


@inlined
def E_rate(E, w):
    """E' = 1/2 C^T w, with w (rad/s) in the axes that turn (docs/theory.md 2.2)."""
    return (
        0.5 * (E[3] * w[0] - E[2] * w[1] + E[1] * w[2]),
        0.5 * (E[2] * w[0] + E[3] * w[1] - E[0] * w[2]),
        0.5 * (-E[1] * w[0] + E[0] * w[1] + E[3] * w[2]),
        0.5 * (-E[0] * w[0] - E[1] * w[1] - E[2] * w[2]),
    )


@inlined
def B_times(E, F):
    """B(E) F, with B of docs/theory.md 2.1; the angular velocity of E is 2 B E'."""
    return (
        E[3] * F[0] - E[2] * F[1] + E[1] * F[2] - E[0] * F[3],
        E[2] * F[0] + E[3] * F[1] - E[0] * F[2] - E[1] * F[3],
        -E[1] * F[0] + E[0] * F[1] + E[3] * F[2] - E[2] * F[3],
    )


@inlined
def matrix_E(A):
    """Euler parameters (unit length, E4 >= 0 where it is not the smallest) of a rotation matrix.

    Shepperd's method: divide by the largest of the four, so it is accurate everywhere (docs/theory.md 2.3).
    """
    trace = A[0][0] + A[1][1] + A[2][2]

    if trace >= A[0][0] and trace >= A[1][1] and trace >= A[2][2]:
        E = (A[2][1] - A[1][2], A[0][2] - A[2][0], A[1][0] - A[0][1], 1.0 + trace)
    elif A[0][0] >= A[1][1] and A[0][0] >= A[2][2]:
        E = (1.0 - trace + 2.0 * A[0][0], A[1][0] + A[0][1], A[2][0] + A[0][2], A[2][1] - A[1][2])
    elif A[1][1] >= A[2][2]:
        E = (A[1][0] + A[0][1], 1.0 - trace + 2.0 * A[1][1], A[2][1] + A[1][2], A[0][2] - A[2][0])
    else:
        E = (A[2][0] + A[0][2], A[2][1] + A[1][2], 1.0 - trace + 2.0 * A[2][2], A[1][0] - A[0][1])

    return E_scale(1.0 / math.sqrt(E_dot(E, E)), E)


@inlined
def column(A, k):
    """Column k of a matrix."""
    if k == 0:
        return (A[0][0], A[1][0], A[2][0])

    if k == 1:
        return (A[0][1], A[1][1], A[2][1])

    return (A[0][2], A[1][2], A[2][2])


@inlined
def zyx_E(angles):
    """Euler parameters of Rz(yaw) Ry(pitch) Rx(roll), angles (yaw, pitch, roll) in rad."""
    z = (0.0, 0.0, math.sin(0.5 * angles[0]), math.cos(0.5 * angles[0]))
    y = (0.0, math.sin(0.5 * angles[1]), 0.0, math.cos(0.5 * angles[1]))
    x = (math.sin(0.5 * angles[2]), 0.0, 0.0, math.cos(0.5 * angles[2]))
    return E_product(E_product(z, y), x)


@inlined
def matrix_zyx(A):
    """(yaw, pitch, roll) in rad of A = Rz(yaw) Ry(pitch) Rx(roll); finite at pitch = +-90 degrees.

    There only yaw -+ roll is determined; roll is then zero.
    """
    cos_pitch = math.sqrt(A[0][0] * A[0][0] + A[1][0] * A[1][0])
    pitch = math.atan2(-A[2][0], cos_pitch)

    if cos_pitch > 1e-12:
        # roll after that very yaw, so that rounding near lock spoils neither their sum nor the orientation
        c = A[0][0] / cos_pitch
        s = A[1][0] / cos_pitch
        roll = math.atan2(s * A[0][2] - c * A[1][2], c * A[1][1] - s * A[0][1])
        return (math.atan2(s, c), pitch, roll)

    return (math.atan2(-A[0][1], A[1][1]), pitch, 0.0)


# storage: element i of an array of vectors, matrices, ...


@inlined
def vec3(p, i):
    """Vector i of p."""
    k = 3 * i
    return (p[k], p[k + 1], p[k + 2])


@inlined
def set_vec3(p, i, v):
    """p[i] = v."""
    k = 3 * i
    p[k] = v[0]
    p[k + 1] = v[1]
    p[k + 2] = v[2]


@inlined
def add_vec3(p, i, v):
    """p[i] += v."""
    k = 3 * i
    p[k] += v[0]
    p[k + 1] += v[1]
    p[k + 2] += v[2]


@inlined
def mat3(p, i):
    """Matrix i of p, stored by rows."""
    k = 9 * i
    return (
        (p[k], p[k + 1], p[k + 2]),
        (p[k + 3], p[k + 4], p[k + 5]),
        (p[k + 6], p[k + 7], p[k + 8]),
    )


@inlined
def set_mat3(p, i, A):
    """p[i] = A."""
    set_vec3(p, 3 * i, A[0])
    set_vec3(p, 3 * i + 1, A[1])
    set_vec3(p, 3 * i + 2, A[2])


@inlined
def sym3(p, i):
    """Symmetric matrix i of p."""
    k = 6 * i
    return (p[k], p[k + 1], p[k + 2], p[k + 3], p[k + 4], p[k + 5])


@inlined
def set_sym3(p, i, S):
    """p[i] = S."""
    k = 6 * i
    p[k] = S[0]
    p[k + 1] = S[1]
    p[k + 2] = S[2]
    p[k + 3] = S[3]
    p[k + 4] = S[4]
    p[k + 5] = S[5]


@inlined
def add_to_diagonal(p, i, x):
    """Symmetric matrix i of p plus x times the unit matrix."""
    for k in range(6 * i, 6 * i + 3):
        p[k] += x


@inlined
def vec_at(p, k):
    """The vector that starts at element k of p."""
    return (p[k], p[k + 1], p[k + 2])


@inlined
def set_vec_at(p, k, v):
    """Store v from element k of p on."""
    p[k] = v[0]
    p[k + 1] = v[1]
    p[k + 2] = v[2]


@inlined
def E_at(p, k):
    """The Euler parameters that start at element k of p."""
    return (p[k], p[k + 1], p[k + 2], p[k + 3])


@inlined
def set_E_at(p, k, E):
    """Store E from element k of p on."""
    p[k] = E[0]
    p[k + 1] = E[1]
    p[k + 2] = E[2]
    p[k + 3] = E[3]


@inlined
def largest(p, n):
    """Largest magnitude among p[:n]; NaN where one is."""
    size = 0.0

    for k in range(n):
        a = abs(p[k])

        if a > size or a != a:
            size = a

    return size
