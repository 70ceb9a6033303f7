"""An irregular sea and its loads on the barge, as an FMU of its own: `pythonfmu build -f sea.py`."""

import numpy as np
from excitation import cylinder_excitation
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

RADIUS = np.sqrt(40.0 * 40.0 / np.pi)  # m, of the barge's waterplane
DRAUGHT, DEPTH = 4.0, 150.0  # m
COMPONENTS = 300


def jonswap(omega, tp, gamma):
    """Shape (n,) of the JONSWAP spectrum at angular frequencies omega (n,), rad/s."""
    peak = 2 * np.pi / tp
    width = np.where(omega <= peak, 0.07, 0.09)
    enhancement = gamma ** np.exp(-(((omega - peak) / (width * peak)) ** 2) / 2)
    return omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4) * enhancement


class Sea(Fmi2Slave):
    """Long-crested waves along +x: a sum of COMPONENTS cosines of random frequency and phase.

    Each frequency is drawn within its own band, so the sea does not repeat. The loads are those on
    the barge held at rest, diffraction included, to first order; radiation belongs to the barge.
    """

    author = "mbdfmi"
    description = "Irregular sea (JONSWAP) with its wave loads on the ITI Energy barge"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)

        self.time = 0.0
        self.hs, self.tp, self.gamma, self.seed = 2.0, 8.0, 3.3, 1.0
        self.drawn = self.seen = None  # the parameters and the time of what is kept

        for name, text in (
            ("hs", "significant wave height, m"),
            ("tp", "peak period, s"),
            ("gamma", "peak enhancement factor"),
            ("seed", "seed of the phases"),
        ):
            self.register_variable(
                Real(
                    name,
                    causality=Fmi2Causality.parameter,
                    description=text,
                    variability=Fmi2Variability.fixed,
                )
            )

        self._output("elevation", "wave elevation at the origin, m", 0)
        for i in (1, 2, 3):
            self._output(f"force[{i}]", "wave force on the barge, N", i)
        for i in (1, 2, 3):
            self._output(f"moment[{i}]", "wave moment about the waterline origin, N m", 3 + i)

    def do_step(self, current_time, step_size):
        """The sea takes no notice of anyone: only time passes."""
        self.time = current_time + step_size
        return True

    def _output(self, name, text, row):
        self.register_variable(
            Real(name, causality=Fmi2Causality.output, description=text, getter=lambda: self._now()[row])
        )

    def _now(self):
        """Elevation, force (3), moment (3) at the present time."""
        parameters = self.hs, self.tp, self.gamma, self.seed
        if self.drawn != parameters:
            self._draw(*parameters)
            self.drawn, self.seen = parameters, None

        if self.seen != self.time:
            self.loads = np.real(self.waves @ np.exp(1j * self.omega * self.time))
            self.seen = self.time
        return self.loads

    def _draw(self, hs, tp, gamma, seed):
        random = np.random.default_rng(int(seed))
        edges = 2 * np.pi / tp * np.linspace(0.5, 4, COMPONENTS + 1)
        self.omega = random.uniform(edges[:-1], edges[1:])
        power = jonswap(self.omega, tp, gamma)
        amplitude = hs / 4 * np.sqrt(2 * power / power.sum())
        phase = random.uniform(0, 2 * np.pi, COMPONENTS)

        table = np.linspace(edges[0], edges[-1], 100)
        loads = np.array([cylinder_excitation(omega, RADIUS, DRAUGHT, DEPTH) for omega in table])
        surge, heave, pitch = (np.interp(self.omega, table, load) for load in loads.T)
        none = np.zeros(COMPONENTS)
        response = np.array([none + 1, surge, none, heave, none, pitch, none])
        self.waves = response * amplitude * np.exp(1j * phase)
