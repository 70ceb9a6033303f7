"""Wind, and rotors in it."""

from typing import ClassVar

import numpy as np
from pydantic import Field, model_validator

from ..vectors import norm
from ..vocabulary import ROTOR_OUTPUTS
from .ends import End
from .fields import NotNegative, Number, OneOf, Part, Positive, SomeOf, Vector
from .sea import DataName, csv_columns
from .tables import Ascending, LoadReading, Table, Vectors


class SteadyWind(Part):
    """velocity : (3,) m/s in the inertial frame at the reference height.
    exponent : of the power law (z / reference_height)^exponent by which it grows with height over z = 0; 0: none.
    reference_height : m.
    """

    velocity: Vector = Field(description="velocity [x, y, z] in m/s")
    exponent: NotNegative = 0.0
    reference_height: Positive = 90.0


# of IEC 61400-1, table 1: m/s over ten minutes by class, turbulence at 15 m/s by category
REFERENCE_SPEEDS = {"I": 50.0, "II": 42.5, "III": 37.5}
REFERENCE_INTENSITIES = {"A+": 0.18, "A": 0.16, "B": 0.14, "C": 0.12}


class GustOverTime(Table):
    """time : s. velocity : (n, 3) m/s in the inertial frame, added to the wind.

    interpolation : between the points, as told above under Tables; before the first and after the last the velocity is theirs.
    """

    time: Ascending
    velocity: Vectors
    interpolation: LoadReading = "linear"


class StepGust(Part):
    """A change of the wind that stays.

    velocity : (3,) m/s in the inertial frame, added to the wind in the end.
    start : s. rise : s, over which it comes, as (1 - cos) / 2; 0: at once.
    """

    velocity: Vector = Field(description="velocity [x, y, z] in m/s")
    start: NotNegative
    rise: NotNegative = 0.0


class OperatingGust(Part):
    """The extreme operating gust of IEC 61400-1 (6.3.2.2), along the steady wind: -0.37 amplitude sin(3 pi t / period) (1 - cos(2 pi t /
    period)) from the start on, for one period.

    start : s. period : s.
    amplitude : m/s; or, by the standard, of the turbine's class and turbulence, the diameter of its rotor (m), the steady wind's speed, and
        reference_height as that of the hub.
    """

    needed: ClassVar[tuple] = (("amplitude", "turbine_class"),)

    start: NotNegative
    period: Positive = 10.5
    amplitude: Positive | None = None
    turbine_class: OneOf(*REFERENCE_SPEEDS) | None = None
    turbulence: OneOf(*REFERENCE_INTENSITIES) = "B"
    diameter: Positive | None = None

    @model_validator(mode="after")
    def _check_class(self):
        if self.turbine_class and self.diameter is None:
            raise ValueError("turbine_class needs the diameter of the rotor beside it, in m")
        if self.amplitude and {"turbulence", "diameter"} & self.model_fields_set:
            raise ValueError(
                "amplitude says it all: leave out turbulence and diameter, or give turbine_class in its place"
            )
        return self

    def size(self, speed, height):
        """The amplitude (m/s) in a steady wind (m/s) at the height (m) of the hub: (11) and (12) of 6.3.1.3, (17) there."""
        if self.amplitude:
            return self.amplitude

        of_a_year = 0.8 * 1.4 * REFERENCE_SPEEDS[self.turbine_class]
        deviation = REFERENCE_INTENSITIES[self.turbulence] * (0.75 * speed + 5.6)
        length = 0.7 * min(height, 60.0)
        return min(1.35 * (of_a_year - speed), 3.3 * deviation / (1.0 + 0.1 * self.diameter / length))


class Gust(Part):
    """What is added to the wind over time, the same at all heights; also to a wind that an input tells."""

    needed: ClassVar[tuple] = (("eog", "step", "table"),)

    eog: OperatingGust | None = None
    step: StepGust | None = None
    table: GustOverTime | None = None


class Wind(Part):
    """Wind that all rotors are in.

    density : of air, kg/m3.
    steady : as it is where no input tells otherwise; then the input's start.
    gust : added to it over time; none when left out.
    input : its velocity (m/s) at the reference height.
    """

    density: Positive = 1.225
    steady: SteadyWind
    gust: Gust | None = None
    input: SomeOf("velocity") = []
    output: ClassVar[tuple] = ()

    @model_validator(mode="after")
    def _check_gust(self):
        eog = self.gust.eog if self.gust else None
        speed = norm(np.array(self.steady.velocity))

        if eog and not speed > 0.0:
            raise ValueError(
                "gust.eog blows along the steady wind, which has no direction at velocity = [0, 0, 0]"
            )
        if eog and not eog.size(speed, self.steady.reference_height) > 0.0:
            text = f"gust.eog: class {eog.turbine_class} has no operating gust in {speed:g} m/s, above its extreme wind of a year"
            raise ValueError(text)
        return self


class RotorOptions(Part):
    """radius : m.
    table : CSV with a line of names, then tip speed ratio, blade pitch (rad), C_T, C_Q; a full grid in any order. C_Q is C_P by the
        tip speed ratio. Splined between its points; beyond its edges they hold.
    pitch : rad, of all blades, where no input tells it; then the input's start.
    """

    radius: Positive
    table: DataName = Field(description='as in table = "rotor.csv"')
    pitch: Number = 0.0

    def grid(self):
        """(tip speed ratios (n,), pitches (k,) rad, C_T (n, k), C_Q (n, k)). Raises ValueError that names the file."""
        columns = csv_columns(self.table, 4)
        ratio, pitch = (np.unique(columns[:, k]) for k in (0, 1))

        if len(columns) != len(ratio) * len(pitch) or len(ratio) < 4 or len(pitch) < 4:
            raise ValueError(
                f"{self.table.path}: needs each tip speed ratio with each pitch, at least 4 of both; found {len(columns)} rows with "
                f"{len(ratio)} ratios and {len(pitch)} pitches"
            )

        order = np.lexsort((columns[:, 1], columns[:, 0]))
        return ratio, pitch, *(columns[order, k].reshape(len(ratio), len(pitch)) for k in (2, 3))


class WindRotor(Part):
    """rotor = { radius, table, pitch }, on : the hub, turning with the blades; its x axis is the rotor's, downwind.

    Thrust along that axis, torque about it, by tables of a whole rotor in steady wind along it: of wind at an angle to the axis its
    component along that counts, moments of yaw and tilt are left out. Where the wind comes from the other side there is nothing.

    input : pitch of all blades, rad.
    output : thrust (N), torque (N m), the wind along the axis as the moving hub feels it (m/s), the power on the body (W).
    """

    kind: ClassVar[str] = "rotor"

    rotor: RotorOptions
    on: End = Field(description='the hub, as in on = "hub"')
    input: SomeOf("pitch") = []
    output: SomeOf(*ROTOR_OUTPUTS) = ()

    @property
    def between(self):
        """The one end."""
        return (self.on,)
