"""A hydraulic cylinder with its valve, another maker's FMU (PythonFMU): oil that is compressed on both sides of a piston.

Inputs are the length of the cylinder and its rate, the output is its force, tension positive.
"""

from math import copysign, sqrt

from numpy import interp
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

AREAS = 7.9e-3, 4.0e-3  # m2, of the piston, of its side with the rod
DEAD = 4e-4  # m3, of oil in the hoses on either side
STROKE = 0.8  # m
SHORTEST = 0.85  # m, length of the cylinder when it is in
MODULUS = 1.0e9  # Pa, of the oil
SUPPLY, TANK = 21e6, 0.0  # Pa
VALVE = 8e-7  # m3/s/sqrt(Pa), at full opening
LEAK = 3e-12  # m3/s/Pa, past the piston
DAMPING = 8e3  # N s/m, of the seals
HOLDING = 4.901e6, 6.0e6  # Pa, at the start
STEP = 2e-4  # s, of the integration


def opening(time):
    """The valve's opening, -1 to 1: it lifts, holds, lowers."""
    knots = (0.0, 0.2, 0.5, 0.9, 1.3, 1.5, 1.8, 2.0, 2.3), (0.0, 0.0, 0.4, 0.4, 0.0, 0.0, -0.3, -0.3, 0.0)
    return float(interp(time, *knots))


def flow(difference, part):
    """Through the valve, m3/s."""
    return VALVE * part * copysign(sqrt(abs(difference)), difference) if part else 0.0


def pressure_rates(time, pressures, length, rate):
    """Pa/s, of the piston's side and of the rod's."""
    p, q = pressures
    u = opening(time)
    into = flow(SUPPLY - p, u) if u > 0 else flow(p - TANK, u)
    out = flow(q - TANK, u) if u > 0 else flow(SUPPLY - q, u)
    past = LEAK * (p - q)
    x = length - SHORTEST
    return (
        MODULUS / (DEAD + AREAS[0] * x) * (into - past - AREAS[0] * rate),
        MODULUS / (DEAD + AREAS[1] * (STROKE - x)) * (past - out + AREAS[1] * rate),
    )


def tension(pressures, rate):
    """N."""
    return AREAS[1] * pressures[1] - AREAS[0] * pressures[0] + DAMPING * rate


class Cylinder(Fmi2Slave):
    """The FMU."""

    author = "models of mbdfmi"
    description = "Hydraulic cylinder with a valve"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.length, self.rate = 1.0, 0.0
        self.piston, self.rod = HOLDING
        self.time = 0.0
        self.register_variable(Real("length", causality=Fmi2Causality.input))
        self.register_variable(Real("rate", causality=Fmi2Causality.input))
        self.register_variable(
            Real(
                "force",
                causality=Fmi2Causality.output,
                getter=lambda: tension((self.piston, self.rod), self.rate),
            )
        )
        for name in ("piston", "rod"):
            self.register_variable(
                Real(name, causality=Fmi2Causality.output, variability=Fmi2Variability.continuous)
            )

    def do_step(self, time, step):
        """Heun's method, the rate held, the length with it."""
        n = max(1, round(step / STEP))
        h = step / n
        p = (self.piston, self.rod)
        length = self.length - self.rate * step / 2

        for k in range(n):
            t = time + k * h
            a = pressure_rates(t, p, length, self.rate)
            length += self.rate * h
            guess = (p[0] + h * a[0], p[1] + h * a[1])
            b = pressure_rates(t + h, guess, length, self.rate)
            p = (p[0] + h / 2 * (a[0] + b[0]), p[1] + h / 2 * (a[1] + b[1]))

        self.piston, self.rod = p
        return True
