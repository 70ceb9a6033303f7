"""Springs and dampers, linear or by a table, for whatever they act along."""

from ..language import inlined
from ..math import tables


@inlined
def spring_effort(m, table, stiffness, rest, x):
    """What a spring bears at x."""
    if table >= 0:
        return tables.evaluate(m, table, x)[0]

    return stiffness * (x - rest)


@inlined
def stored_energy(m, table, stiffness, rest, x):
    """Energy (J) of a spring at x, zero at `rest`."""
    if table >= 0:
        return tables.integral(m, table, x) - tables.integral(m, table, rest)

    return 0.5 * stiffness * (x - rest) * (x - rest)


@inlined
def damper_effort(m, table, damping, rate):
    """What a damper bears at a rate."""
    if table >= 0:
        return tables.evaluate(m, table, rate)[0]

    return damping * rate
