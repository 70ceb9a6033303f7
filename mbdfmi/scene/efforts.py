"""What acts in a joint of one freedom: springs, dampers, friction, stops, drivers."""

import numpy as np
from pydantic import Field, field_validator, model_validator

from .errors import show
from .fields import AllOrSome, NotNegative, Number, Part, Positive, as_given, in_si
from .tables import AngleOverTime, EffortOverAngle, EffortOverPosition, PositionOverTime


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
    smoothing_speed : below which friction is made smooth, m/s, rad/s.
    """

    coulomb: NotNegative = Field(description="effort when sliding, in N or N m")
    static: NotNegative = Field(default_factory=lambda data: data.get("coulomb", 0.0))
    stribeck_speed: Positive = 0.1
    viscous: NotNegative = 0.0
    smoothing_speed: Positive = 1e-3

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
            raise ValueError(f"lower must be below upper; found {as_given(self, 'lower')} and {as_given(self, 'upper')}")
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

    def mean_value(self):
        """m, rad."""
        return in_si(self, "mean")


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


COMMANDS = ("position", "speed", "acceleration")


class Driver(Part):
    """The motion of a joint, prescribed.

    input : true, or what inputs tell of the motion: ["position"], ["position", "speed"], or all three, for which true stands.
        What is not told is found from the last commands.
    """

    @property
    def kind(self):
        """One of "constant_speed", "harmonic", "table" and "input"."""
        for kind in ("harmonic", "table", "input"):
            if getattr(self, kind) is not None:
                return kind
        return "constant_speed"

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
    """One of constant_speed : m/s; harmonic; table : position over time; input."""

    needed = (("constant_speed", "harmonic", "table", "input"),)

    constant_speed: Number | None = None
    harmonic: LinearHarmonic | None = None
    table: PositionOverTime | None = None
    input: AllOrSome(*COMMANDS) | None = None


class AngularDriver(Driver):
    """One of constant_speed : rad/s, or _deg, _rpm; harmonic; table; input, with "angle" or "position"."""

    needed = (
        (
            "constant_speed", "constant_speed_deg", "constant_speed_rpm",
            "harmonic", "table", "input",
        ),
    )

    constant_speed: Number | None = None
    constant_speed_deg: Number | None = None
    constant_speed_rpm: Number | None = None
    harmonic: AngularHarmonic | None = None
    table: AngleOverTime | None = None
    input: AllOrSome("angle", *COMMANDS) | None = None
