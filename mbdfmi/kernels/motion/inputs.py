"""Inputs over a communication step, by values and derivatives at its start, and what they command (docs/theory.md 15.4)."""

from ..language import inlined

N_DERIVATIVE = 6


@inlined
def polynomial(m, d, k, s):
    """Input k at s (s) of the communication step, by its value and derivatives at the start."""
    n = m.n_u
    value = d.u_buffer[4 * n + k] + 0.2 * s * d.u_buffer[5 * n + k]
    value = d.u_buffer[3 * n + k] + 0.25 * s * value
    value = d.u_buffer[2 * n + k] + s / 3.0 * value
    return d.u_buffer[k] + s * (d.u_buffer[n + k] + 0.5 * s * value)


@inlined
def derivative(m, d, k, row, s):
    """Derivative `row` of input k at s (s) of the communication step."""
    value = 0.0
    for i in range(N_DERIVATIVE - 1, row - 1, -1):
        value = d.u_buffer[i * m.n_u + k] + value * s / (i - row + 1)
    return value


@inlined
def told(m, d, c, what):
    """What inputs command of a channel: its position (0), speed (1) or acceleration (2); 0 where they do not."""
    k = m.command_u[3 * c + what]
    return d.u_buffer[k] if k >= 0 else 0.0


@inlined
def highest(m, c):
    """The highest derivative of a channel that inputs tell."""
    return 2 if m.command_u[3 * c + 2] >= 0 else (1 if m.command_u[3 * c + 1] >= 0 else 0)
