"""Random numbers as numpy's `default_rng(seed)` draws them: SeedSequence, then PCG64 (O'Neill 2014), for seeds below 2^32.

Numbers of 128 bits stand in p as 8 parts of 16 bits, the lowest first: the state at 0, the increment at 8.
"""

import math

from ..language import inlined, kernel

PART = 65536.0
WORD = 0xFFFFFFFF

# of the linear congruential generator, by parts
FACTOR = (0xF645, 0x9FCC, 0xDF64, 0x4385, 0x5DA4, 0x1FC6, 0xED05, 0x2360)


@inlined
def product(a, b):
    """a b modulo 2^32, in which nothing grows beyond 63 bits."""
    return (a * (b & 0xFFFF) + (((a * (b >> 16)) & 0xFFFF) << 16)) & WORD


@inlined
def folded(a):
    """Its upper half onto its lower one."""
    return a ^ (a >> 16)


@inlined
def mix_seed(p, seed):
    """The pool of a seed, four words of 32 bits, into p[8:12]."""
    hashed = 0x43B0D7E5

    for k in range(4):
        word = (seed if k == 0 else 0) ^ hashed
        hashed = product(hashed, 0x931E8875)
        p[8 + k] = float(folded(product(word, hashed)))

    for source in range(4):
        for k in range(4):
            if k != source:
                word = int(p[8 + source]) ^ hashed
                hashed = product(hashed, 0x931E8875)
                word = folded(product(word, hashed))
                mixed = product(0xCA01F9DD, int(p[8 + k])) - product(0x4973F715, word)
                p[8 + k] = float(folded(mixed & WORD))


@inlined
def set_word(p, at, word):
    """A word of 32 bits as two parts."""
    p[at] = float(word & 0xFFFF)
    p[at + 1] = float(word >> 16)


@inlined
def add_number(p, at, to):
    """The number at `at` onto that at `to`."""
    carry = 0.0

    for k in range(8):
        value = p[to + k] + p[at + k] + carry
        carry = math.floor(value / PART)
        p[to + k] = value - PART * carry


@inlined
def turn(p):
    """The state one on: times the factor, plus the increment."""
    for k in range(7, -1, -1):
        value = 0.0

        # the lowest parts are needed until the last
        for j in range(k + 1):
            value += p[j] * FACTOR[k - j]

        p[k] = value

    carry = 0.0

    for k in range(8):
        value = p[k] + carry
        carry = math.floor(value / PART)
        p[k] = value - PART * carry

    add_number(p, 8, 0)


@kernel
def begin(p, seed):
    """The generator of a seed into p[:16]."""
    mix_seed(p, seed)
    hashed = 0x8B51F9DD

    # increment and state, each of two numbers of 64 bits, the higher one first; the pool lies where the increment will
    pool = (int(p[8]), int(p[9]), int(p[10]), int(p[11]))

    for k in range(8):
        word = pool[k % 4] ^ hashed
        hashed = product(hashed, 0x58F38DED)
        word = folded(product(word, hashed))
        half = 4 if k % 4 < 2 else 0
        set_word(p, (0 if k < 4 else 8) + half + 2 * (k % 2), word)

    # twice the increment and one
    carry = 1.0

    for k in range(8):
        value = 2.0 * p[8 + k] + carry
        carry = 1.0 if value >= PART else 0.0
        p[8 + k] = value - PART * carry

    # from zero: one step makes the increment, to which what was drawn is added
    add_number(p, 8, 0)
    turn(p)


@kernel
def draw(p):
    """The next number from 0 to 1."""
    turn(p)
    distance = int(p[7]) >> 10
    whole = distance // 16
    bits = distance % 16
    value = 0.0

    for k in range(3, -1, -1):
        low = int(p[(k + whole) % 4]) ^ int(p[4 + (k + whole) % 4])
        high = int(p[(k + whole + 1) % 4]) ^ int(p[4 + (k + whole + 1) % 4])
        part = ((low >> bits) | (high << (16 - bits))) & 0xFFFF

        # of 64 bits the upper 53
        value = PART * value + part if k > 0 else 32.0 * value + (part >> 11)

    return value / 9007199254740992.0
