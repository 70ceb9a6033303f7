"""What a user says to the reader of a URDF file."""

from dataclasses import dataclass, field
from math import isfinite

BASES = ("fixed", "free")


@dataclass(frozen=True)
class UrdfOptions:
    """How a URDF file is read.

    base : "fixed", its root link is held by the ground, or "free".
    stop_stiffness : makes stops of the position limits: N m/rad of revolute joints and N/m of prismatic ones, one number or one for
        each; None: no stops, a URDF file does not say how stiff they are.
    stop_damping : of these stops, N m s/rad and N s/m, one number or one for each.
    packages : folders of the packages that `package://NAME/...` names.
    looks : whether forms and meshes of links are taken over as looks.

    Raises ValueError for what makes no sense.
    """

    base: str = "fixed"
    stop_stiffness: float | tuple[float, float] | None = None
    stop_damping: float | tuple[float, float] = 0.0
    packages: dict[str, str] = field(default_factory=dict)
    looks: bool = True

    def __post_init__(self):
        if self.base not in BASES:
            raise ValueError(f'base: is "fixed" or "free", found {self.base!r}')
        if self.stop_stiffness is not None and not all(k > 0 for k in self._pair("stop_stiffness")):
            raise ValueError(f"stop_stiffness: must be greater than 0, found {self.stop_stiffness!r}")
        if not all(d >= 0 for d in self._pair("stop_damping")):
            raise ValueError(f"stop_damping: must not be negative, found {self.stop_damping!r}")
        if self.stop_stiffness is None and any(self._pair("stop_damping")):
            raise ValueError("stop_damping: goes with a stop_stiffness")

    def stop(self, kind):
        """(stiffness or None, damping) of the stops of a joint's kind, "revolute" or "prismatic"."""
        k = ("revolute", "prismatic").index(kind)
        stiffness = None if self.stop_stiffness is None else self._pair("stop_stiffness")[k]
        return stiffness, self._pair("stop_damping")[k]

    def _pair(self, key):
        """The two numbers of an option."""
        given = getattr(self, key)
        pair = given if isinstance(given, (tuple, list)) else (given, given)

        if len(pair) != 2 or not all(
            isinstance(x, (int, float)) and not isinstance(x, bool) and isfinite(x) for x in pair
        ):
            raise ValueError(
                f"{key}: needs a number, or one of revolute and one of prismatic joints; found {given!r}"
            )

        return tuple(map(float, pair))
