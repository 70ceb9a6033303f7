"""Units of the variables: SI base-unit exponents and the display units that a tool may offer.

Names follow Modelica: `.` multiplies, `/` divides once by all that follows, a number after a name
is its power.
"""

from typing import NamedTuple


class Unit(NamedTuple):
    """A unit as FMI defines it: exponents of the base units, and display units (name, factor).

    A value in a display unit is factor times the value in this unit.
    """

    kg: int = 0
    m: int = 0
    s: int = 0
    rad: int = 0
    display: tuple[tuple[str, float], ...] = ()


_DEG = 57.29577951308232  # per rad
_RPM = 9.549296585513721  # 1/min per rad/s

UNITS: dict[str, Unit] = {
    "1": Unit(),
    "s": Unit(s=1),
    "1/s": Unit(s=-1),
    "Hz": Unit(s=-1),
    "kg": Unit(kg=1),
    "kg.m": Unit(kg=1, m=1),
    "kg.m2": Unit(kg=1, m=2),
    "kg/m3": Unit(kg=1, m=-3),
    "kg.m/s": Unit(kg=1, m=1, s=-1),
    "kg.m2/s": Unit(kg=1, m=2, s=-1),
    "m": Unit(m=1, display=(("mm", 1e3),)),
    "m2": Unit(m=2),
    "m3": Unit(m=3),
    "m4": Unit(m=4),
    "m/s": Unit(m=1, s=-1, display=(("km/h", 3.6),)),
    "m/s2": Unit(m=1, s=-2),
    "m3/s2": Unit(m=3, s=-2),
    "rad": Unit(rad=1, display=(("deg", _DEG),)),
    "rad/m": Unit(rad=1, m=-1),
    "rad/s": Unit(rad=1, s=-1, display=(("deg/s", _DEG), ("rpm", _RPM))),
    "rad/s2": Unit(rad=1, s=-2, display=(("deg/s2", _DEG),)),
    "N": Unit(kg=1, m=1, s=-2, display=(("kN", 1e-3), ("MN", 1e-6))),
    "N.m": Unit(kg=1, m=2, s=-2, display=(("kN.m", 1e-3), ("MN.m", 1e-6))),
    "N/m": Unit(kg=1, s=-2),
    "N.s/m": Unit(kg=1, s=-1),
    "N/rad": Unit(kg=1, m=1, s=-2, rad=-1),
    "N.s/rad": Unit(kg=1, m=1, s=-1, rad=-1),
    "N.s": Unit(kg=1, m=1, s=-1),
    "N.m/rad": Unit(kg=1, m=2, s=-2, rad=-1),
    "N.m.s/rad": Unit(kg=1, m=2, s=-1, rad=-1),
    "J": Unit(kg=1, m=2, s=-2, display=(("kJ", 1e-3), ("MJ", 1e-6))),
    "W": Unit(kg=1, m=2, s=-3, display=(("kW", 1e-3), ("MW", 1e-6))),
}
