"""Wind on the rotor, as an FMU of its own: `pythonfmu build -f rotor.py blade_element.py`."""

import numpy as np
from blade_element import RADIUS, rotor_coefficients
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real
from scipy.interpolate import RectBivariateSpline

AIR_DENSITY = 1.225  # kg/m3
TIP_SPEED_RATIO = np.linspace(1.0, 14.0, 53)
PITCH = np.radians(np.linspace(0.0, 30.0, 31))


class Rotor(Fmi2Slave):
    """Thrust and torque of the NREL 5-MW rotor in a steady, uniform wind along the shaft.

    Quasi-steady: the coefficients for the momentary tip speed ratio and pitch, from a table made
    when the FMU is loaded; beyond the table its edge holds. The wind that counts is the one that
    the moving hub feels.
    """

    author = "mbdfmi"
    description = "Quasi-steady aerodynamics of the NREL 5-MW rotor"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)

        ratio, pitch = np.meshgrid(TIP_SPEED_RATIO, PITCH, indexing="ij")
        self.thrust, self.torque = (
            RectBivariateSpline(TIP_SPEED_RATIO, PITCH, table, kx=1, ky=1)
            for table in rotor_coefficients(ratio, pitch)
        )

        self.wind = 12.0
        self.rotor_speed = self.hub_velocity = self.blade_pitch = 0.0

        self.register_variable(
            Real(
                "wind",
                causality=Fmi2Causality.parameter,
                variability=Fmi2Variability.tunable,
                description="wind speed, m/s",
            )
        )
        for name, text in (
            ("rotor_speed", "speed of the shaft, rad/s"),
            ("hub_velocity", "velocity of the hub along the shaft, downwind, m/s"),
            ("blade_pitch", "pitch of all blades, rad"),
        ):
            self.register_variable(Real(name, causality=Fmi2Causality.input, description=text))
        self._output(
            "thrust", "force on the hub along the shaft, downwind, N", lambda: self._load(self.thrust)
        )
        self._output(
            "torque", "torque on the hub about the shaft, N m", lambda: RADIUS * self._load(self.torque)
        )

    def do_step(self, current_time, step_size):
        """No state, nothing to advance: the outputs follow the inputs."""
        return True

    def _output(self, name, text, getter):
        self.register_variable(Real(name, causality=Fmi2Causality.output, description=text, getter=getter))

    def _load(self, coefficient):
        """The coefficient's value times the force of the wind, N; none without wind from ahead."""
        wind = self.wind - self.hub_velocity
        if wind <= 0:
            return 0.0

        force = AIR_DENSITY / 2 * wind**2 * np.pi * RADIUS**2
        return force * coefficient.ev(self.rotor_speed * RADIUS / wind, self.blade_pitch)
