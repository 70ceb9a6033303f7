"""Dense linear systems of the implicit steppers: LU factors of mu 1 - J, mu real or complex.

Rows are exchanged for the largest pivot in the column; `swaps[k]` is the row that took the place of row k. A complex matrix
is a real plane of n x n numbers, then an imaginary one. What is zero below the diagonal costs nothing.
"""

from ..language import kernel


@kernel
def factor(J, mu, a, swaps, n):
    """LU of mu 1 - J (n x n, by rows) into a. A singular matrix leaves numbers that are not finite."""
    for k in range(n * n):
        a[k] = -J[k]

    for k in range(n):
        a[n * k + k] += mu

    for k in range(n):
        pivot = k

        for i in range(k + 1, n):
            if abs(a[n * i + k]) > abs(a[n * pivot + k]):
                pivot = i

        swaps[k] = pivot

        if pivot != k:
            for j in range(n):
                a[n * k + j], a[n * pivot + j] = a[n * pivot + j], a[n * k + j]

        scale = 1.0 / a[n * k + k]

        for i in range(k + 1, n):
            if a[n * i + k] != 0.0:
                f = a[n * i + k] * scale
                a[n * i + k] = f

                for j in range(k + 1, n):
                    a[n * i + j] -= f * a[n * k + j]


@kernel
def solve(a, swaps, n, b, at):
    """b[at:at + n] = (mu 1 - J)^-1 b."""
    for k in range(n):
        pivot = int(swaps[k])
        b[at + k], b[at + pivot] = b[at + pivot], b[at + k]

    for i in range(n):
        value = b[at + i]

        for j in range(i):
            value -= a[n * i + j] * b[at + j]

        b[at + i] = value

    for i in range(n - 1, -1, -1):
        value = b[at + i]

        for j in range(i + 1, n):
            value -= a[n * i + j] * b[at + j]

        b[at + i] = value / a[n * i + i]


@kernel
def factor_complex(J, mu_re, mu_im, a, swaps, n):
    """LU of (mu_re + i mu_im) 1 - J into the two planes of a."""
    m = n * n

    for k in range(m):
        a[k] = -J[k]
        a[m + k] = 0.0

    for k in range(n):
        a[n * k + k] += mu_re
        a[m + n * k + k] += mu_im

    for k in range(n):
        pivot = k

        for i in range(k + 1, n):
            here = abs(a[n * i + k]) + abs(a[m + n * i + k])

            if here > abs(a[n * pivot + k]) + abs(a[m + n * pivot + k]):
                pivot = i

        swaps[k] = pivot

        if pivot != k:
            for j in range(n):
                a[n * k + j], a[n * pivot + j] = a[n * pivot + j], a[n * k + j]
                a[m + n * k + j], a[m + n * pivot + j] = a[m + n * pivot + j], a[m + n * k + j]

        re = a[n * k + k]
        im = a[m + n * k + k]
        scale = 1.0 / (re * re + im * im)
        re *= scale
        im *= -scale

        for i in range(k + 1, n):
            x = a[n * i + k]
            y = a[m + n * i + k]

            if x != 0.0 or y != 0.0:
                f = x * re - y * im
                g = x * im + y * re
                a[n * i + k] = f
                a[m + n * i + k] = g

                for j in range(k + 1, n):
                    x = a[n * k + j]
                    y = a[m + n * k + j]
                    a[n * i + j] -= f * x - g * y
                    a[m + n * i + j] -= f * y + g * x


@kernel
def solve_complex(a, swaps, n, b, at):
    """(b[at:at + n], b[at + n:at + 2 n]): real and imaginary parts of (mu 1 - J)^-1 b."""
    m = n * n
    to = at + n

    for k in range(n):
        pivot = int(swaps[k])
        b[at + k], b[at + pivot] = b[at + pivot], b[at + k]
        b[to + k], b[to + pivot] = b[to + pivot], b[to + k]

    for i in range(n):
        x = b[at + i]
        y = b[to + i]

        for j in range(i):
            x -= a[n * i + j] * b[at + j] - a[m + n * i + j] * b[to + j]
            y -= a[n * i + j] * b[to + j] + a[m + n * i + j] * b[at + j]

        b[at + i] = x
        b[to + i] = y

    for i in range(n - 1, -1, -1):
        x = b[at + i]
        y = b[to + i]

        for j in range(i + 1, n):
            x -= a[n * i + j] * b[at + j] - a[m + n * i + j] * b[to + j]
            y -= a[n * i + j] * b[to + j] + a[m + n * i + j] * b[at + j]

        re = a[n * i + i]
        im = a[m + n * i + i]
        scale = 1.0 / (re * re + im * im)
        b[at + i] = (x * re + y * im) * scale
        b[to + i] = (y * re - x * im) * scale
