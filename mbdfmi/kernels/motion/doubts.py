"""Commands that contradict each other: speeds that do not lead from position to position (docs/theory.md 15.4)."""

import math

from ..language import inlined
from ..math import algebra as al
from ..status import CONTRADICTION, status, tell
from . import courses, rotations
from .inputs import highest, told

# part of the largest of the speeds by which the motion may differ from them, and for how many steps it may not
DOUBT = 0.1
DOUBTFUL_STEPS = 3.0


@inlined
def doubt(m, d, k):
    """Says so when speeds (accelerations) that are told do not lead from command to command of the position (speed).

    The change over a step lies between its ends' speeds, or hardly beyond; a command may jump, but not again and again.
    """
    c = m.drive_command[k]
    groups = 2 if m.drive_commands[k] > 3 and courses.has_omega(m, k) else 1
    h = d.command_steps[0]
    wrong = False

    for group in range(groups):
        first = c + 3 * group
        n = min(3, m.drive_commands[k] - 3 * group)
        turn = al.ZERO3

        if group == 1:
            last = al.E_conjugate(al.E_at(d.attitude_past, 0))
            turn = rotations.rotation_vector(al.E_product(al.E_at(d.attitude_base, 0), last))

        for level in range(1, highest(m, first) + 1):
            missed = 0.0
            size = 0.0
            rounding = 0.0

            for i in range(n):
                x = told(m, d, first + i, level)
                x_before = (
                    d.command_past[4 * (first + i)]
                    if level == highest(m, first)
                    else d.command_before[2 * (first + i) + 1]
                )
                below = told(m, d, first + i, level - 1)
                change = below - d.command_before[2 * (first + i) + level - 1]

                if group == 1 and level == 1:
                    change = turn[i]
                    below = 1.0

                beyond = max(0.0, abs(change / h - 0.5 * (x + x_before)) - 0.5 * abs(x - x_before))
                missed += beyond * beyond
                size = max(size, max(x * x, x_before * x_before))
                rounding = max(rounding, 1e-9 * abs(below) / h)

            wrong = wrong or math.sqrt(missed) > DOUBT * math.sqrt(size) + rounding

    if d.drive_doubt[2 * k + 1] != 0.0:
        return

    d.drive_doubt[2 * k] = d.drive_doubt[2 * k] + 1.0 if wrong else 0.0

    if d.drive_doubt[2 * k] >= DOUBTFUL_STEPS:
        d.drive_doubt[2 * k + 1] = 1.0
        tell(d, status(CONTRADICTION, place_of(m, k)), 0.0, 0.0)


@inlined
def place_of(m, k):
    """Whom a status of drive k is about: the joint's node, or the constraint of a joint that closes a loop."""
    place = m.drive_body[k]

    for row in range(m.n_row if place < 0 else 0):
        if m.row_drive[row] == k:
            place = m.n_body + m.row_constraint[row]

    return place
