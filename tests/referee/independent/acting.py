"""The element of a force's table."""

from .elements import Load, Six, Strut, Torsion
from .hulls import Hull
from .lines import Line, Member
from .wind import Blades, WaveMaker

ACTING = ("hydrostatics", "catenary", "member", "rotor")
"""Kinds that say of themselves what they do at an instant, and hold what they tell, and their energy."""


def element(given, name, force, data, end):
    """data : of the scene. end : (owner, position, axes) of an end by name."""
    sea, wind = data.get("sea") or {}, data.get("wind")

    if "load" in force:
        return Load(given, name, force)
    if "catenary" in force:
        return Line(given, name, force, sea, end(force["between"][0]))
    if "rotor" in force:
        return Blades(given, name, force, wind)
    for key, cls in (("hydrostatics", Hull), ("member", Member), ("hydrodynamics", WaveMaker)):
        if key in force:
            return cls(given, name, force, sea)

    kinds = {"spring_damper": Strut, "torsion": Torsion}
    return next((kinds[kind] for kind in kinds if kind in force), Six)(given, name, force)
