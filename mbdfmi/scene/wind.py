"""Wind, and rotors in it."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from ..vocabulary import ROTOR_OUTPUTS
from .ends import End
from .fields import NotNegative, Number, Part, Positive, SomeOf, Vector
from .sea import DataName, csv_columns


class SteadyWind(Part):
    """velocity : (3,) m/s in the inertial frame at the reference height.
    exponent : of the power law (z / reference_height)^exponent by which it grows with height over z = 0; 0: none.
    reference_height : m.
    """

    velocity: Vector = Field(description="velocity [x, y, z] in m/s")
    exponent: NotNegative = 0.0
    reference_height: Positive = 90.0


class Wind(Part):
    """Wind that all rotors are in.

    density : of air, kg/m3.
    steady : as it is where no input tells otherwise; then the input's start.
    input : its velocity (m/s) at the reference height.
    """

    density: Positive = 1.225
    steady: SteadyWind
    input: SomeOf("velocity") = []
    output: ClassVar[tuple] = ()


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
