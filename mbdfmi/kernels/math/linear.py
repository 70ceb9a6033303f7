"""Sparse linear systems of the implicit steppers: LU factors of mu 1 - J, mu real or complex, in blocks (docs/theory.md 18.11).

The blocks of a row (elements) stand in the order of elimination, which the compiler has found, with room for what fills in. Within
a diagonal block rows are exchanged for the largest pivot in the column; `swaps[k]` is the row of the block that took the
place of its row k. Between blocks they are not: a shorter step, so a larger mu, makes any system one that does not need it. A complex
matrix is a real plane of n_jacobian numbers, then an imaginary one. What is zero costs little.

Legend: b a row of blocks, k a column block before it, e the element of both, f one of row k beyond its diagonal, t where
their product goes.
"""

from ..language import inlined, kernel


@inlined
def target(m, t, block):
    """The first element from t on that is in column `block`; there is one."""
    while m.element_block[t] != block:
        t += 1

    return t


@kernel
def factor(m, J, mu, a, swaps):
    """LU of mu 1 - J into a. A singular matrix leaves numbers that are not finite."""
    for k in range(m.n_jacobian):
        a[k] = -J[k]

    for b in range(m.n_block):
        size = m.block_size[b]
        own = m.element_value[m.block_own[b]]

        for k in range(size):
            a[own + size * k + k] += mu

        for e in range(m.block_element[b], m.block_own[b]):
            k = m.element_block[e]
            divide(m, a, swaps, k, m.element_value[e], size)
            t = e

            for f in range(m.block_own[k] + 1, m.block_element[k] + m.block_elements[k]):
                t = target(m, t, m.element_block[f])
                subtract_product(m, a, e, f, t, size, m.block_size[k])

        factor_block(a, own, size, swaps, m.block_place[b])


@kernel
def factor_block(a, own, n, swaps, place):
    """LU of a diagonal block (n x n, by rows from `own` on) in its place."""
    for k in range(n):
        pivot = k

        for i in range(k + 1, n):
            if abs(a[own + n * i + k]) > abs(a[own + n * pivot + k]):
                pivot = i

        swaps[place + k] = pivot

        if pivot != k:
            for j in range(n):
                a[own + n * k + j], a[own + n * pivot + j] = a[own + n * pivot + j], a[own + n * k + j]

        scale = 1.0 / a[own + n * k + k]

        for i in range(k + 1, n):
            if a[own + n * i + k] != 0.0:
                f = a[own + n * i + k] * scale
                a[own + n * i + k] = f

                for j in range(k + 1, n):
                    a[own + n * i + j] -= f * a[own + n * k + j]


@inlined
def divide(m, a, swaps, k, at, rows):
    """`rows` rows from `at` on, as wide as block k, times the inverse of its diagonal block."""
    n = m.block_size[k]
    own = m.element_value[m.block_own[k]]
    place = m.block_place[k]

    for i in range(at, at + n * rows, n):
        for j in range(n):
            value = a[i + j] / a[own + n * j + j]
            a[i + j] = value

            if value != 0.0:
                for c in range(j + 1, n):
                    a[i + c] -= value * a[own + n * j + c]

        for j in range(n - 1, 0, -1):
            value = a[i + j]

            if value != 0.0:
                for c in range(j):
                    a[i + c] -= value * a[own + n * j + c]

        for j in range(n - 1, -1, -1):
            pivot = int(swaps[place + j])
            a[i + j], a[i + pivot] = a[i + pivot], a[i + j]


@inlined
def subtract_product(m, a, e, f, t, rows, inner):
    """Element t less element e (rows x inner) times element f."""
    width = m.element_width[f]
    wide = m.element_width[t]
    left = m.element_value[e]
    to = m.element_value[t] + m.element_first[f] - m.element_first[t]

    for i in range(rows):
        for j in range(inner):
            value = a[left + inner * i + j]

            if value != 0.0:
                right = m.element_value[f] + width * j

                for c in range(width):
                    a[to + wide * i + c] -= value * a[right + c]


@inlined
def solve_block(a, own, n, swaps, place, x):
    """x[place:place + n] = the inverse of a diagonal block times that."""
    for k in range(n):
        pivot = place + int(swaps[place + k])
        x[place + k], x[pivot] = x[pivot], x[place + k]

    for i in range(n):
        value = x[place + i]

        for j in range(i):
            value -= a[own + n * i + j] * x[place + j]

        x[place + i] = value

    for i in range(n - 1, -1, -1):
        value = x[place + i]

        for j in range(i + 1, n):
            value -= a[own + n * i + j] * x[place + j]

        x[place + i] = value / a[own + n * i + i]


@kernel
def solve(m, a, swaps, right, at, x):
    """right[at:at + n_x] = (mu 1 - J)^-1 right; x: room for n_x numbers, in the order of elimination."""
    n = m.n_x

    for p in range(n):
        x[p] = right[at + m.place_x[p]]

    for b in range(m.n_block):
        for e in range(m.block_element[b], m.block_own[b]):
            take_away(m, a, b, e, x)

    for b in range(m.n_block - 1, -1, -1):
        for e in range(m.block_own[b] + 1, m.block_element[b] + m.block_elements[b]):
            take_away(m, a, b, e, x)

        solve_block(a, m.element_value[m.block_own[b]], m.block_size[b], swaps, m.block_place[b], x)

    for p in range(n):
        right[at + m.place_x[p]] = x[p]


@inlined
def take_away(m, a, b, e, x):
    """Unknowns of row b less element e times those of its column block."""
    width = m.element_width[e]
    at = m.block_place[m.element_block[e]] + m.element_first[e]

    for i in range(m.block_size[b]):
        value = x[m.block_place[b] + i]
        row = m.element_value[e] + width * i

        for c in range(width):
            value -= a[row + c] * x[at + c]

        x[m.block_place[b] + i] = value


@kernel
def factor_complex(m, J, mu_re, mu_im, a, swaps):
    """LU of (mu_re + i mu_im) 1 - J into the two planes of a."""
    plane = m.n_jacobian

    for k in range(plane):
        a[k] = -J[k]
        a[plane + k] = 0.0

    for b in range(m.n_block):
        size = m.block_size[b]
        own = m.element_value[m.block_own[b]]

        for k in range(size):
            a[own + size * k + k] += mu_re
            a[plane + own + size * k + k] += mu_im

        for e in range(m.block_element[b], m.block_own[b]):
            k = m.element_block[e]
            divide_complex(m, a, swaps, k, m.element_value[e], size)
            t = e

            for f in range(m.block_own[k] + 1, m.block_element[k] + m.block_elements[k]):
                t = target(m, t, m.element_block[f])
                subtract_product_complex(m, a, e, f, t, size, m.block_size[k])

        factor_block_complex(a, plane, own, size, swaps, m.block_place[b])


@kernel
def factor_block_complex(a, m, own, n, swaps, place):
    """LU of a diagonal block in its place; m: from the real plane to the imaginary one."""
    for k in range(n):
        pivot = k
        diagonal = own + n * k

        for i in range(k + 1, n):
            at = own + n * i + k
            best = own + n * pivot + k

            if abs(a[at]) + abs(a[m + at]) > abs(a[best]) + abs(a[m + best]):
                pivot = i

        swaps[place + k] = pivot

        if pivot != k:
            other = own + n * pivot

            for j in range(n):
                a[diagonal + j], a[other + j] = a[other + j], a[diagonal + j]
                a[m + diagonal + j], a[m + other + j] = a[m + other + j], a[m + diagonal + j]

        re = a[diagonal + k]
        im = a[m + diagonal + k]
        scale = 1.0 / (re * re + im * im)
        re *= scale
        im *= -scale

        for i in range(k + 1, n):
            row = own + n * i
            x = a[row + k]
            y = a[m + row + k]

            if x != 0.0 or y != 0.0:
                f = x * re - y * im
                g = x * im + y * re
                a[row + k] = f
                a[m + row + k] = g

                for j in range(k + 1, n):
                    x = a[diagonal + j]
                    y = a[m + diagonal + j]
                    a[row + j] -= f * x - g * y
                    a[m + row + j] -= f * y + g * x


@inlined
def subtract_row_complex(a, m, to, row, x, y, first, end):
    """a[to + c] less (x + i y) a[row + c], c from `first` to before `end`."""
    for c in range(first, end):
        u = a[row + c]
        v = a[m + row + c]
        a[to + c] -= x * u - y * v
        a[m + to + c] -= x * v + y * u


@inlined
def divide_complex(m, a, swaps, k, at, rows):
    """`rows` rows from `at` on, as wide as block k, times the inverse of its diagonal block."""
    n = m.block_size[k]
    plane = m.n_jacobian
    own = m.element_value[m.block_own[k]]
    place = m.block_place[k]

    for i in range(at, at + n * rows, n):
        for j in range(n):
            x = a[i + j]
            y = a[plane + i + j]

            if x != 0.0 or y != 0.0:
                re = a[own + n * j + j]
                im = a[plane + own + n * j + j]
                scale = 1.0 / (re * re + im * im)
                f = (x * re + y * im) * scale
                g = (y * re - x * im) * scale
                a[i + j] = f
                a[plane + i + j] = g
                subtract_row_complex(a, plane, i, own + n * j, f, g, j + 1, n)

        for j in range(n - 1, 0, -1):
            x = a[i + j]
            y = a[plane + i + j]

            if x != 0.0 or y != 0.0:
                subtract_row_complex(a, plane, i, own + n * j, x, y, 0, j)

        for j in range(n - 1, -1, -1):
            pivot = int(swaps[place + j])
            a[i + j], a[i + pivot] = a[i + pivot], a[i + j]
            a[plane + i + j], a[plane + i + pivot] = a[plane + i + pivot], a[plane + i + j]


@inlined
def subtract_product_complex(m, a, e, f, t, rows, inner):
    """Element t less element e (rows x inner) times element f."""
    width = m.element_width[f]
    left = m.element_value[e]
    to = m.element_value[t] + m.element_first[f] - m.element_first[t]

    for i in range(rows):
        for j in range(inner):
            x = a[left + inner * i + j]
            y = a[m.n_jacobian + left + inner * i + j]

            if x != 0.0 or y != 0.0:
                right = m.element_value[f] + width * j
                subtract_row_complex(a, m.n_jacobian, to + m.element_width[t] * i, right, x, y, 0, width)


@kernel
def solve_complex(m, a, swaps, right, at, x):
    """right[at:at + 2 n_x], real parts and then imaginary ones: (mu 1 - J)^-1 times that; x: room for as many."""
    n = m.n_x

    for p in range(n):
        x[p] = right[at + m.place_x[p]]
        x[n + p] = right[at + n + m.place_x[p]]

    for b in range(m.n_block):
        for e in range(m.block_element[b], m.block_own[b]):
            take_away_complex(m, a, b, e, x)

    for b in range(m.n_block - 1, -1, -1):
        for e in range(m.block_own[b] + 1, m.block_element[b] + m.block_elements[b]):
            take_away_complex(m, a, b, e, x)

        solve_block_complex(m, a, b, swaps, x)

    for p in range(n):
        right[at + m.place_x[p]] = x[p]
        right[at + n + m.place_x[p]] = x[n + p]


@inlined
def product_complex(a, plane, row, x, n, at, count):
    """Sum of a[row + c] x[at + c] over `count` numbers: (real part, imaginary part)."""
    re = 0.0
    im = 0.0

    for c in range(count):
        u = a[row + c]
        v = a[plane + row + c]
        re += u * x[at + c] - v * x[n + at + c]
        im += u * x[n + at + c] + v * x[at + c]

    return re, im


@inlined
def take_away_complex(m, a, b, e, x):
    """Unknowns of row b less element e times those of its column block."""
    width = m.element_width[e]
    at = m.block_place[m.element_block[e]] + m.element_first[e]

    for i in range(m.block_size[b]):
        row = m.element_value[e] + width * i
        re, im = product_complex(a, m.n_jacobian, row, x, m.n_x, at, width)
        x[m.block_place[b] + i] -= re
        x[m.n_x + m.block_place[b] + i] -= im


@inlined
def solve_block_complex(m, a, b, swaps, x):
    """Unknowns of block b: the inverse of its diagonal block times them."""
    size = m.block_size[b]
    own = m.element_value[m.block_own[b]]
    place = m.block_place[b]
    n = m.n_x

    for k in range(size):
        pivot = place + int(swaps[place + k])
        x[place + k], x[pivot] = x[pivot], x[place + k]
        x[n + place + k], x[n + pivot] = x[n + pivot], x[n + place + k]

    for i in range(size):
        re, im = product_complex(a, m.n_jacobian, own + size * i, x, n, place, i)
        x[place + i] -= re
        x[n + place + i] -= im

    for i in range(size - 1, -1, -1):
        row = own + size * i
        u, v = product_complex(a, m.n_jacobian, row + i + 1, x, n, place + i + 1, size - i - 1)
        u = x[place + i] - u
        v = x[n + place + i] - v
        re = a[row + i]
        im = a[m.n_jacobian + row + i]
        scale = 1.0 / (re * re + im * im)
        x[place + i] = (u * re + v * im) * scale
        x[n + place + i] = (v * re - u * im) * scale
