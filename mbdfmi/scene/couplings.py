"""Couplings: gears and their like, between two joints of one freedom."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field

from ..vocabulary import COUPLING_OUTPUTS
from .errors import show
from .fields import NotZero, Number, Part, SomeOf, by_key, in_si


def _joints(value):
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError(f'needs two joints, as in ["motor", "wheel"]; found {show(value)}')
    for name in value:
        if not isinstance(name, str):
            raise ValueError(f"the name of a joint is a text, found {show(name)}")
    return tuple(name.strip() for name in value)


class CouplingBase(Part):
    """The second joint's coordinate follows the first one's: ratio times it, plus an offset.

    between : names of the joints.
    output : "efforts", what the coupling exerts on the second markers of the first and the second joint along these, N m or
        N, as a tooth or a rope does; the power of the two together is 0.
    kinds : of joints that it can be between, the first's and the second's.
    """

    kinds: ClassVar[tuple] = (("revolute", "prismatic"), ("revolute", "prismatic"))
    input: ClassVar[tuple] = ()

    between: Annotated[tuple[str, str], BeforeValidator(_joints)] = Field(
        description='names of two joints, as in between = ["motor", "wheel"]'
    )
    output: SomeOf(*COUPLING_OUTPUTS) = ()

    @property
    def ratio(self):
        """The second joint's coordinate by the first one's, SI."""
        return getattr(self, self.kind).ratio

    @property
    def offset(self):
        """The second joint's coordinate where the first one's is 0, SI; None: as at the start."""
        return in_si(getattr(self, self.kind), "offset", None)


class GearOptions(Part):
    """ratio : angle of the second joint by that of the first, negative where they turn contrarily.

    offset (rad) or offset_deg : angle of the second where the first one's is 0; left out: as at the start.
    """

    exclusive = (("offset", "offset_deg"),)

    ratio: NotZero = Field(description="angle of the second joint by that of the first")
    offset: Number | None = None
    offset_deg: Number | None = None


class Gear(CouplingBase):
    """Between two revolute joints."""

    kind: ClassVar[str] = "gear"
    kinds: ClassVar[tuple] = (("revolute",), ("revolute",))

    gear: GearOptions


class RackOptions(Part):
    """radius : of the pinion, m. offset : position where the angle is 0, m; left out: as at the start."""

    radius: NotZero = Field(description="radius of the pinion in m")
    offset: Number | None = None

    @property
    def ratio(self):
        """m/rad."""
        return self.radius


class Rack(CouplingBase):
    """From a revolute joint, the pinion's, to a prismatic one, the rack's."""

    kind: ClassVar[str] = "rack"
    kinds: ClassVar[tuple] = (("revolute",), ("prismatic",))

    rack: RackOptions


class SpindleOptions(Part):
    """pitch : m per turn. offset : position where the angle is 0, m; left out: as at the start."""

    pitch: NotZero = Field(description="advance in m per turn")
    offset: Number | None = None

    @property
    def ratio(self):
        """m/rad."""
        return self.pitch / (2 * np.pi)


class ScrewCoupling(CouplingBase):
    """From a revolute joint, the screw's, to a prismatic one, the nut's."""

    kind: ClassVar[str] = "screw"
    kinds: ClassVar[tuple] = (("revolute",), ("prismatic",))

    screw: SpindleOptions


class RatioOptions(Part):
    """ratio : of the second joint's coordinate to the first one's, SI. offset : SI; left out: as at the start."""

    ratio: NotZero = Field(description="coordinate of the second joint by that of the first, SI")
    offset: Number | None = None


class LinearCoupling(CouplingBase):
    """Between any two joints of one freedom."""

    kind: ClassVar[str] = "linear"

    linear: RatioOptions


COUPLINGS = (Gear, Rack, ScrewCoupling, LinearCoupling)
Coupling = by_key("a coupling", *COUPLINGS)
