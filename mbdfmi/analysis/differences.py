"""Derivatives of smooth functions by central differences of high order, with control of the step."""

import numpy as np

# a step (in the unit of the argument), and how often and by how much it may be made smaller
STEP = 8e-4
SHORTER = 8.0
TRIES = 6

# relative error that is as good as exact; rounding of a function, in parts of its size
GOOD = 2e-12
ROUNDING = 5e-15

# a derivative smaller than that (SI) need not be known better than this one
SMALL = 1e-3

# coefficients of f(kh) - f(-kh), k = 1 ... 4, of orders 8, 6 and 4
EIGHTH = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
SIXTH = np.array([3 / 4, -3 / 20, 1 / 60, 0.0])
FOURTH = np.array([2 / 3, -1 / 12, 0.0, 0.0])


def derivative(function, step=STEP, rows=slice(None), even=False, tries=TRIES):
    """(f'(0), relative error) of a function of a number that returns (n,), by differences of order 8.

    The step is made shorter as long as that helps: the error, estimated by those of lower order, is at
    rounding or no longer falls. rows : those by whose size the error is measured. What raises ArithmeticError
    is not there so far off. even : f may well be even, and its derivative 0, which is asked
    first. tries : how many steps at most.
    """
    if even:
        ahead = function(4.0 * step)
        odd = ahead - function(-4.0 * step)

        if np.abs(odd[rows]).max(initial=0.0) <= GOOD * np.abs(ahead[rows]).max(initial=0.0):
            return np.zeros(len(odd)), GOOD

    best, least, missing = None, np.inf, None

    for _ in range(tries):
        try:
            found, error, done = _differences(function, step, rows)
        except ArithmeticError as raised:
            missing = raised
        else:
            if error < least:
                best, least = found, error
            elif best is not None:
                break

            if done:
                break

        step /= SHORTER

    if best is None:
        raise missing or ArithmeticError("no derivative")

    return best, least


def _differences(function, step, rows):
    """(derivative, relative error, whether that is at rounding) with one step."""
    ahead = np.array([function(k * step) for k in (1, 2, 3, 4)])
    odd = ahead - np.array([function(-k * step) for k in (1, 2, 3, 4)])
    found = EIGHTH @ odd / step
    missed = np.abs(found - SIXTH @ odd / step)[rows].max(initial=0.0)
    missed_more = np.abs(found - FOURTH @ odd / step)[rows].max(initial=0.0)
    # from order to order errors fall alike
    missed *= min(1.0, 2.0 * missed / missed_more) if missed_more > 0.0 else 1.0
    size = np.abs(found[rows]).max(initial=SMALL)
    rounding = ROUNDING * np.abs(ahead[:, rows]).max(initial=0.0) / step
    error = missed / max(size, missed)
    return found, error if missed > rounding else min(error, GOOD), missed <= max(rounding, GOOD * size)
