"""What acts in a joint of one freedom: springs, dampers, friction, stops, drivers."""

from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field, field_validator, model_validator

from .errors import show
from .fields import AllOrSome, Array, Flag, NotNegative, Number, Part, Positive, as_given, in_si
from .tables import (
    AngleOverTime,
    AngularSpeedOverTime,
    EffortOverAngle,
    EffortOverPosition,
    PositionOverTime,
    Some,
    SpeedOverTime,
    ascending,
)

# springs


class AngularSpring(Part):
    """stiffness : N m/rad. rest (rad) or rest_deg : the angle at which it is slack.

    table : effort over angle, instead of them, or None.
    """

    exclusive = (("rest", "rest_deg", "table"),)
    needed = (("stiffness", "table"),)

    stiffness: NotNegative | None = None
    rest: Number | None = None
    rest_deg: Number | None = None
    table: EffortOverAngle | None = None

    def rest_value(self):
        """rad."""
        return in_si(self, "rest")


class LinearSpring(Part):
    """stiffness : N/m. rest : the position at which it is slack, m.

    table : effort over position, instead of them, or None.
    """

    exclusive = (("rest", "table"),)
    needed = (("stiffness", "table"),)

    stiffness: NotNegative | None = None
    rest: Number | None = None
    table: EffortOverPosition | None = None

    def rest_value(self):
        """m."""
        return in_si(self, "rest")


# friction and stops


class Friction(Part):
    """Dry and viscous friction, smoothed about standstill.

    coulomb : effort when sliding, N, N m.
    static : effort that it takes to break loose, at least coulomb.
    stribeck_speed : at which static has faded to coulomb by 1/e, m/s, rad/s.
    viscous : N s/m, N m s/rad.
    smoothing_speed : the effort goes as tanh(speed / smoothing_speed) about standstill, m/s, rad/s: under a load of a part r of
        the static effort a joint creeps at atanh(r) times this speed. With the default that is less than 1e-6 r up to
        r = 0.99. A larger one costs less where a joint sticks or turns back often, most of all with a fixed step.
    """

    coulomb: NotNegative = Field(description="effort when sliding, in N or N m")
    static: NotNegative = Field(default_factory=lambda data: data.get("coulomb", 0.0))
    stribeck_speed: Positive = 0.1
    viscous: NotNegative = 0.0
    smoothing_speed: Positive = 3.7e-7

    @field_validator("static")
    @classmethod
    def _check_static(cls, static, info):
        coulomb = info.data.get("coulomb", 0.0)
        if static < coulomb:
            raise ValueError(f"must be at least coulomb, {show(coulomb)}; found {show(static)}")
        return static


class Stop(Part):
    """A bump stop at one or both ends, elastic."""

    def lower_value(self):
        """m, rad; -inf where there is none."""
        return in_si(self, "lower", -np.inf)

    def upper_value(self):
        """m, rad; inf where there is none."""
        return in_si(self, "upper", np.inf)

    @model_validator(mode="after")
    def _check_ends(self):
        lower, upper = self.lower_value(), self.upper_value()
        if lower == -np.inf and upper == np.inf:
            raise ValueError('needs "lower" or "upper", or both')
        if not lower < upper:
            raise ValueError(
                f"lower must be below upper; found {as_given(self, 'lower')} and {as_given(self, 'upper')}"
            )
        return self


class LinearStop(Stop):
    """lower, upper : one or both, m. stiffness : N/m. damping : while in touch, N s/m."""

    lower: Number | None = None
    upper: Number | None = None
    stiffness: Positive = Field(description="stiffness in N/m")
    damping: NotNegative = 0.0


class AngularStop(Stop):
    """lower, upper (rad) or lower_deg, upper_deg : one or both. stiffness : N m/rad.

    damping : while in touch, N m s/rad.
    """

    exclusive = (("lower", "lower_deg"), ("upper", "upper_deg"))

    lower: Number | None = None
    lower_deg: Number | None = None
    upper: Number | None = None
    upper_deg: Number | None = None
    stiffness: Positive = Field(description="stiffness in N m/rad")
    damping: NotNegative = 0.0


# drivers


class Harmonic(Part):
    """mean + amplitude sin(2 pi frequency time + phase)"""

    def amplitude_value(self):
        """m, rad."""
        return in_si(self, "amplitude")

    def phase_value(self):
        """rad."""
        return in_si(self, "phase")

    def waves(self):
        """Amplitude (m, rad), frequency (Hz) and phase (rad) of each wave (n, 3)."""
        return np.column_stack([self.amplitude_value(), self.frequency, self.phase_value()])

    def mean_value(self):
        """m, rad."""
        return float(in_si(self, "mean"))

    def at(self, time):
        """m, rad, at a time (s)."""
        amplitude, frequency, phase = self.waves().T
        return self.mean_value() + float(amplitude @ np.sin(2 * np.pi * frequency * time + phase))


class LinearHarmonic(Harmonic):
    """position = mean + amplitude sin(2 pi frequency time + phase_deg), m, Hz."""

    amplitude: Number = Field(description="amplitude in m")
    frequency: Positive = Field(description="frequency in Hz")
    phase_deg: Number = 0.0
    mean: Number = 0.0


class AngularHarmonic(Harmonic):
    """angle = mean + amplitude sin(2 pi frequency time + phase_deg), rad or _deg, Hz."""

    exclusive = (("mean", "mean_deg"),)
    needed = (("amplitude", "amplitude_deg"),)

    amplitude: Number | None = None
    amplitude_deg: Number | None = None
    frequency: Positive = Field(description="frequency in Hz")
    phase_deg: Number = 0.0
    mean: Number | None = None
    mean_deg: Number | None = None


class Harmonics(Harmonic):
    """amplitude, frequency, phase_deg : a value for each wave; all phases are 0 when left out."""

    @model_validator(mode="after")
    def _check_waves(self):
        n = len(self.frequency)
        for key in ("amplitude", "amplitude_deg", "phase_deg"):
            values = getattr(self, key, None)
            if values is not None and len(values) != n:
                raise ValueError(
                    f'"frequency" has {n} values and "{key}" {len(values)}; each needs one of the other'
                )
        if min(self.frequency) <= 0:
            raise ValueError(f"frequency must be greater than 0, found {show(min(self.frequency))}")
        return self

    def phase_value(self):
        """rad, of each wave."""
        return in_si(self, "phase", np.zeros(len(self.frequency)))


class LinearHarmonics(Harmonics):
    """position = mean + the sum of amplitude sin(2 pi frequency time + phase_deg), m, Hz."""

    amplitude: Some = Field(description="amplitudes in m")
    frequency: Some = Field(description="frequencies in Hz")
    phase_deg: Some | None = None
    mean: Number = 0.0


class AngularHarmonics(Harmonics):
    """angle = mean + the sum of amplitude sin(2 pi frequency time + phase_deg), rad or _deg, Hz."""

    exclusive = (("mean", "mean_deg"),)
    needed = (("amplitude", "amplitude_deg"),)

    amplitude: Some | None = None
    amplitude_deg: Some | None = None
    frequency: Some = Field(description="frequencies in Hz")
    phase_deg: Some | None = None
    mean: Number | None = None
    mean_deg: Number | None = None


def _few(values):
    if len(values or ()) > 16:
        raise ValueError(f"needs at most 16 numbers, found {len(values)}")
    return values


Coefficients = Annotated[Some, AfterValidator(_few)]


class Polynomial(Part):
    """A sum of coefficients times powers of time, the constant first."""

    def values(self):
        """m, rad, by s, s^2, ..."""
        return np.atleast_1d(in_si(self, "coefficients"))

    def at(self, time):
        """m, rad, at a time (s)."""
        return float(np.polynomial.polynomial.polyval(time, self.values()))


class LinearPolynomial(Polynomial):
    """position = c0 + c1 time + c2 time^2 + ..., m. coefficients : [c0, c1, ...], up to 16."""

    coefficients: Coefficients


class AngularPolynomial(Polynomial):
    """angle = c0 + c1 time + c2 time^2 + .... coefficients (rad) or coefficients_deg : [c0, c1, ...], up to 16."""

    needed = (("coefficients", "coefficients_deg"),)

    coefficients: Coefficients | None = None
    coefficients_deg: Coefficients | None = None


Pair = Array((2,), what="2 numbers [from, to]")


class Ramp(Part):
    """A smooth way from one position to another, and rest before and after it.

    With s the part of the time gone, 10 s^3 - 15 s^4 + 6 s^5 of the way: position, speed and acceleration are continuous, the
    greatest speed is 1.875 times the mean one, the greatest acceleration 5.77 times the way by the time squared.
    """

    def values(self):
        """Time and position at the beginning, time and position at the end: s, m, rad."""
        return [*np.column_stack([self.time, in_si(self, "position")]).ravel()]

    def at(self, time):
        """m, rad, at a time (s)."""
        t0, x0, t1, x1 = self.values()
        s = np.clip((time - t0) / (t1 - t0), 0.0, 1.0)
        return float(x0 + (x1 - x0) * s**3 * (10 - 15 * s + 6 * s * s))


class LinearRamp(Ramp):
    """time : [begin, end], s. position : [from, to], m."""

    time: Annotated[Pair, AfterValidator(ascending)]
    position: Pair


class AngularRamp(Ramp):
    """time : [begin, end], s. position (rad) or position_deg : [from, to]."""

    needed = (("position", "position_deg"),)

    time: Annotated[Pair, AfterValidator(ascending)]
    position: Pair | None = None
    position_deg: Pair | None = None


COMMANDS = ("position", "speed", "acceleration")

# how a driver may prescribe a motion, beside constant_speed
WAYS = ("hold", "harmonic", "harmonics", "polynomial", "ramp", "table", "speed_table", "input")


class Driver(Part):
    """The motion of a joint, prescribed.

    constant_speed, speed_table, hold : the joint goes on from its start position, or keeps it. The other ways tell the
        position itself, over the time of the simulation.
    input : true, or what inputs tell of the motion: ["position"], ["position", "speed"], or all three, for which true stands.
        What is not told is found from the last commands.
    """

    @property
    def kind(self):
        """One of "constant_speed" and WAYS."""
        return next((kind for kind in WAYS if getattr(self, kind) is not None), "constant_speed")

    def speed(self):
        """The constant speed, m/s, rad/s."""
        return in_si(self, "constant_speed")

    def commands(self):
        """What inputs tell of the motion: the first one, two or all of "position", "speed" and "acceleration"."""
        if self.input is True:
            return COMMANDS
        return tuple("position" if what == "angle" else what for what in self.input)

    @field_validator("input", check_fields=False)
    @classmethod
    def _check_commands(cls, told):
        if not told or told is True:
            return told
        what = ["position" if item == "angle" else item for item in told]
        first = COMMANDS[: len(what)]
        if sorted(what) != sorted(first):
            raise ValueError(
                'tells the position, or position and speed, or these and the acceleration: true, ["position", "speed"] '
                f'or ["position"]; found {show(told)}'
            )
        return sorted(told, key=lambda item: COMMANDS.index("position" if item == "angle" else item))


class LinearDriver(Driver):
    """One of constant_speed : m/s; hold; harmonic; harmonics; polynomial; ramp; table : position over time;
    speed_table; input.
    """

    needed = (("constant_speed", *WAYS),)

    constant_speed: Number | None = None
    hold: Flag | None = None
    harmonic: LinearHarmonic | None = None
    harmonics: LinearHarmonics | None = None
    polynomial: LinearPolynomial | None = None
    ramp: LinearRamp | None = None
    table: PositionOverTime | None = None
    speed_table: SpeedOverTime | None = None
    input: AllOrSome(*COMMANDS) | None = None


class ParameterDriver(LinearDriver):
    """One of constant_speed; hold; harmonic; harmonics; polynomial; ramp; table : parameter s over time; speed_table; input. What
    stands there as m is in the unit of the curve's parameter; "position" is s, "speed" its rate.
    """


class AngularDriver(Driver):
    """One of constant_speed : rad/s, or _deg, _rpm; hold; harmonic; harmonics; polynomial; ramp; table : angle over time;
    speed_table; input, with "angle" or "position".
    """

    needed = (("constant_speed", "constant_speed_deg", "constant_speed_rpm", *WAYS),)

    constant_speed: Number | None = None
    constant_speed_deg: Number | None = None
    constant_speed_rpm: Number | None = None
    hold: Flag | None = None
    harmonic: AngularHarmonic | None = None
    harmonics: AngularHarmonics | None = None
    polynomial: AngularPolynomial | None = None
    ramp: AngularRamp | None = None
    table: AngleOverTime | None = None
    speed_table: AngularSpeedOverTime | None = None
    input: AllOrSome("angle", *COMMANDS) | None = None
