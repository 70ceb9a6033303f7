"""The NREL 5-MW baseline controller, as an FMU of its own: `pythonfmu build -f controller.py`.

J. Jonkman et al., NREL/TP-500-38060 (2009), chapter 7: the region table of the generator torque
and the collective blade pitch, its gains detuned for the barge (NREL/TP-500-41958, 2007).
"""

from math import exp, pi

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

GEAR = 97.0
CORNER = 0.25  # Hz, of the low-pass filter on the speed

# the fast shaft: speeds in rad/s, torques in N m
CUT_IN, OPTIMAL_FROM, RATED = 70.16224, 91.21091, 121.6805
OPTIMAL = 2.332287  # N m / (rad/s)^2
POWER = 5_296_610.0  # W, mechanical
SLIP = 0.10
TORQUE_MAX, TORQUE_RATE = 47_402.91, 15_000.0  # N m, N m/s
EFFICIENCY = 0.944

REFERENCE = 122.9096  # rad/s, which the pitch holds
KP, KI = 0.01255121, 0.003586059  # s, 1
GAIN_HALVED = 0.1099965  # rad, pitch at which the gains are halved
PITCH_MAX, PITCH_RATE = pi / 2, 0.1396263  # rad, rad/s
CONSTANT_POWER_PITCH = 0.01745329  # rad


def generator_torque(speed, pitch):
    """Torque, N m, wanted at a speed of the fast shaft, rad/s, and a blade pitch, rad."""
    if speed >= RATED or pitch >= CONSTANT_POWER_PITCH:  # region 3: constant power
        return min(POWER / max(speed, CUT_IN), TORQUE_MAX)
    if speed <= CUT_IN:  # 1: run up freely
        return 0.0
    if speed < OPTIMAL_FROM:  # 1.5: from nothing to region 2
        return OPTIMAL * OPTIMAL_FROM**2 * (speed - CUT_IN) / (OPTIMAL_FROM - CUT_IN)

    synchronous = RATED / (1 + SLIP)
    slip_line = POWER / RATED * (speed - synchronous) / (RATED - synchronous)
    return max(OPTIMAL * speed**2, slip_line)  # 2: best tip speed ratio, then 2.5


def towards(value, target, most):
    """`value` moved towards `target`, by `most` at the most."""
    return min(max(target, value - most), value + most)


class Controller(Fmi2Slave):
    """Sampled at the communication points: each step takes the speed at its start."""

    author = "mbdfmi"
    description = "Torque and pitch controller of the NREL 5-MW turbine on the ITI Energy barge"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)

        self.rotor_speed = 0.0
        self.start_pitch = 0.0
        self.filtered = self.integral = self.torque = self.pitch = None  # until it starts

        self.register_variable(
            Real(
                "start_pitch",
                causality=Fmi2Causality.parameter,
                variability=Fmi2Variability.fixed,
                description="blade pitch at the start, rad",
            )
        )
        self.register_variable(
            Real("rotor_speed", causality=Fmi2Causality.input, description="speed of the slow shaft, rad/s")
        )
        for name, text, getter in (
            (
                "shaft_torque",
                "generator torque on the slow shaft, negative brakes, N m",
                lambda: -GEAR * self._state()[2],
            ),
            ("blade_pitch", "pitch of all blades, rad", lambda: self._state()[3]),
            ("power", "electric power, W", lambda: EFFICIENCY * self._state()[2] * GEAR * self.rotor_speed),
        ):
            self.register_variable(
                Real(name, causality=Fmi2Causality.output, description=text, getter=getter)
            )

    def exit_initialization_mode(self):
        """Start as if the speed had been steady."""
        self.filtered, self.integral, self.torque, self.pitch = self._state()

    def do_step(self, current_time, step_size):
        """Filter the speed, then set the pitch and the torque for it."""
        memory = exp(-2 * pi * CORNER * step_size)
        self.filtered += (1 - memory) * (GEAR * self.rotor_speed - self.filtered)

        gain = 1 / (1 + self.pitch / GAIN_HALVED)
        error = self.filtered - REFERENCE
        most = PITCH_MAX / (gain * KI)
        self.integral = min(max(self.integral + error * step_size, 0.0), most)
        pitch = min(max(gain * (KP * error + KI * self.integral), 0.0), PITCH_MAX)

        wanted = generator_torque(self.filtered, self.pitch)
        self.torque = towards(self.torque, wanted, TORQUE_RATE * step_size)
        self.pitch = towards(self.pitch, pitch, PITCH_RATE * step_size)
        return True

    def _state(self):
        """Filtered speed, integral of its error, torque, pitch: at the start, the steady ones."""
        if self.filtered is not None:
            return self.filtered, self.integral, self.torque, self.pitch

        speed, pitch = GEAR * self.rotor_speed, self.start_pitch
        integral = pitch * (1 + pitch / GAIN_HALVED) / KI
        return speed, integral, generator_torque(speed, pitch), pitch
