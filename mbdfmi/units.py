"""Units of the variables: SI base-unit exponents and the display units that a tool may offer.

Names follow Modelica: `.` multiplies, `/` divides once by all that follows, a number after a name
is its power.
"""

from typing import NamedTuple


class Unit(NamedTuple):
    """A unit as FMI defines it: exponents of the base units, and display units (name, factor).

    A value in a display unit is factor times the value in this unit.

    quantity : what is measured in it, in Modelica's words; "" where that may be several.
    """

    kg: int = 0
    m: int = 0
    s: int = 0
    rad: int = 0
    display: tuple[tuple[str, float], ...] = ()
    quantity: str = ""


_DEG = 57.29577951308232  # per rad
_RPM = 9.549296585513721  # 1/min per rad/s

UNITS: dict[str, Unit] = {
    "1": Unit(),
    "s": Unit(s=1, quantity="Time"),
    "1/s": Unit(s=-1),
    "Hz": Unit(s=-1, quantity="Frequency"),
    "kg": Unit(kg=1, quantity="Mass"),
    "kg.m": Unit(kg=1, m=1),
    "kg.m2": Unit(kg=1, m=2, quantity="MomentOfInertia"),
    "kg/m": Unit(kg=1, m=-1),
    "kg/m3": Unit(kg=1, m=-3, quantity="Density"),
    "kg.m/s": Unit(kg=1, m=1, s=-1, quantity="Momentum"),
    "kg.m2/s": Unit(kg=1, m=2, s=-1, quantity="AngularMomentum"),
    "m": Unit(m=1, display=(("mm", 1e3),), quantity="Length"),
    "m2": Unit(m=2, quantity="Area"),
    "m3": Unit(m=3, quantity="Volume"),
    "m4": Unit(m=4),
    "m/s": Unit(m=1, s=-1, display=(("km/h", 3.6),), quantity="Velocity"),
    "m/s2": Unit(m=1, s=-2, quantity="Acceleration"),
    "m/s3": Unit(m=1, s=-3),
    "m3/s2": Unit(m=3, s=-2),
    "rad": Unit(rad=1, display=(("deg", _DEG),), quantity="Angle"),
    "rad/m": Unit(rad=1, m=-1),
    "rad/s": Unit(rad=1, s=-1, display=(("deg/s", _DEG), ("rpm", _RPM)), quantity="AngularVelocity"),
    "rad/s2": Unit(rad=1, s=-2, display=(("deg/s2", _DEG),), quantity="AngularAcceleration"),
    "N": Unit(kg=1, m=1, s=-2, display=(("kN", 1e-3), ("MN", 1e-6)), quantity="Force"),
    "N.m": Unit(kg=1, m=2, s=-2, display=(("kN.m", 1e-3), ("MN.m", 1e-6)), quantity="Torque"),
    "N/m": Unit(kg=1, s=-2, quantity="TranslationalSpringConstant"),
    "N.s/m": Unit(kg=1, s=-1, quantity="TranslationalDampingConstant"),
    "N/rad": Unit(kg=1, m=1, s=-2, rad=-1),
    "N.s/rad": Unit(kg=1, m=1, s=-1, rad=-1),
    "N.s": Unit(kg=1, m=1, s=-1),
    "N.s2/m2": Unit(kg=1, m=-1),
    "N.s2/rad2": Unit(kg=1, m=1, rad=-2),
    "N.s2/m": Unit(kg=1),
    "N.m.s2/rad2": Unit(kg=1, m=2, rad=-2),
    "N.m/rad": Unit(kg=1, m=2, s=-2, rad=-1, quantity="RotationalSpringConstant"),
    "N.m.s/rad": Unit(kg=1, m=2, s=-1, rad=-1, quantity="RotationalDampingConstant"),
    "J": Unit(kg=1, m=2, s=-2, display=(("kJ", 1e-3), ("MJ", 1e-6)), quantity="Energy"),
    "W": Unit(kg=1, m=2, s=-3, display=(("kW", 1e-3), ("MW", 1e-6)), quantity="Power"),
}
