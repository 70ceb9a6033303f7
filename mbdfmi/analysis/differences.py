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

# change of slope at a kink, as part of the derivative: smooth functions have far less over such steps
BENT = 1e-2

# part that order 2 may miss of a derivative for order 4 to know it as well as order 8 would
FEW = 3e-7

# coefficients of f(kh) - f(-kh), k = 1 ... 4, of orders 8, 6 and 4
EIGHTH = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
SIXTH = np.array([3 / 4, -3 / 20, 1 / 60, 0.0])
FOURTH = np.array([2 / 3, -1 / 12, 0.0, 0.0])


def derivative(function, step=STEP, rows=slice(None), tries=TRIES, here=None, kinks=None):
    """(f'(0), relative error) of a function of a number that returns (n,), by differences of order 8,
    or 4 where that is as good.

    The step is made shorter as long as that helps: the error, estimated by those of lower order, is at
    rounding or no longer falls. rows : those by whose size the error is measured. What raises ArithmeticError
    is not there so far off. tries : how many steps at most.
    here : f(0), where a kink at 0 is to be seen, which differences on both sides of it are not aware of: its
        change of slope is part of the error then. kinks : (n,) of bool, is set where the function has one,
        in `rows` or not.
    """
    best, least, missing, bent = None, np.inf, None, False

    for _ in range(tries):
        try:
            found, error, done, bends = _differences(function, step, rows, here)
        except ArithmeticError as raised:
            missing = raised
        else:
            if error < least:
                best, least, bent = found, error, bends
            elif best is not None:
                break

            if done:
                break

        step /= SHORTER

    if best is None:
        raise missing or ArithmeticError("no derivative")

    if kinks is not None:
        kinks |= bent

    return best, least


def _differences(function, step, rows, here):
    """(derivative, relative error, whether that is at rounding, (n,) where there are kinks) with one step."""
    values = [(function(k * step), function(-k * step)) for k in (1, 2)]
    bends = _bends(values, step, here)
    found, missed, good = _of_few(values, step, rows)

    if not good:
        values += [(function(k * step), function(-k * step)) for k in (3, 4)]
        found, missed = _of_many(values, step, rows)

    size = np.abs(found[rows]).max(initial=SMALL)
    rounding = ROUNDING * np.abs(values[0][0][rows]).max(initial=0.0) / step
    slopes = np.maximum(np.abs(found) + bends, SMALL)
    kinks = bends > BENT * slopes + 1e3 * ROUNDING * np.abs(values[0][0]) / step

    if kinks[rows].any() and bends[rows].max() > BENT * size:
        missed = max(missed, bends[rows].max())

    error = missed / max(size, missed)
    error = error if missed > rounding else min(error, GOOD)
    return found, error, missed <= max(rounding, GOOD * size), kinks


def _bends(values, step, here):
    """(n,) changes of slope; where f(0) is not known, 0."""
    if here is None:
        return np.zeros(len(values[0][0]))

    # of what is smooth the second is four times the first, at a kink twice
    near, far = (ahead + behind - 2.0 * here for ahead, behind in values)
    return np.abs(far - 4.0 * near) / step


def _of_few(values, step, rows):
    """(derivative by four values, its error, whether that is good enough).

    What order 2 misses tells what order 4 does, as errors fall alike.
    """
    odd = np.array([ahead - behind for ahead, behind in values])
    found = FOURTH[:2] @ odd / step
    off = np.abs(found - 0.5 * odd[0] / step)
    size = np.abs(found[rows]).max(initial=SMALL)
    worst = off[rows].max(initial=0.0)
    # all others too, each by itself
    rounding = 1e2 * ROUNDING * np.abs(values[0][0]) / step
    alike = np.all(off <= FEW * np.maximum(np.abs(found), SMALL) + rounding)
    return found, 10.0 * worst * (worst / size), worst <= FEW * size and alike


def _of_many(values, step, rows):
    """(derivative by eight values, its error)."""
    odd = np.array([ahead - behind for ahead, behind in values])
    found = EIGHTH @ odd / step
    missed = np.abs(found - SIXTH @ odd / step)[rows].max(initial=0.0)
    missed_more = np.abs(found - FOURTH @ odd / step)[rows].max(initial=0.0)
    # from order to order errors fall alike
    return found, missed * (min(1.0, 2.0 * missed / missed_more) if missed_more > 0.0 else 1.0)
