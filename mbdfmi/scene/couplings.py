"""Couplings: gears and their like, between joints of one freedom."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from ..vocabulary import COUPLING_OUTPUTS
from .errors import quoted, show
from .fields import NotZero, Number, Part, SomeOf, by_key, in_si, number


def _two_joints(value):
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError(f'needs two joints, as in ["motor", "wheel"]; found {show(value)}')
    return _names(value)


def _joints(value):
    if not isinstance(value, (list, tuple)) or len(value) < 2:
        raise ValueError(f'needs two or more joints, as in ["left", "right", "cage"]; found {show(value)}')
    return _names(value)


def _names(value):
    for name in value:
        if not isinstance(name, str):
            raise ValueError(f"the name of a joint is a text, found {show(name)}")
    return tuple(name.strip() for name in value)


class CouplingBase(Part):
    """The second joint's coordinate follows the first one's: ratio times it, plus an offset. A linear one may be between more joints.

    between : names of the joints.
    output : "efforts", what the coupling exerts on the second markers of its joints along these, in their order, N m or N, as
        a tooth or a rope does; the power of all together is 0.
    kinds : of joints that the first and the others may be.
    """

    kinds: ClassVar[tuple] = (("revolute", "prismatic"), ("revolute", "prismatic"))
    input: ClassVar[tuple] = ()

    between: Annotated[tuple[str, ...], BeforeValidator(_two_joints)] = Field(
        description='names of two joints, as in between = ["motor", "wheel"]'
    )
    output: SomeOf(*COUPLING_OUTPUTS) = ()

    @property
    def ratio(self):
        """The second joint's coordinate by the first one's, SI."""
        return getattr(self, self.kind).ratio

    @property
    def terms(self):
        """((joint, factor, SI), ...): the sum of factor times coordinate, and the offset, are 0."""
        first, second = self.between
        return (first, self.ratio), (second, -1.0)

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


def _coefficients(value):
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"needs a number for each joint, as in [1, 1, -2]; found {show(value)}")
    factors = tuple(number(factor) for factor in value)
    for k, factor in enumerate(factors, 1):
        if factor == 0.0:
            raise ValueError(f"[{k}] is 0: leave its joint out")
    return factors


class LinearOptions(Part):
    """ratio : of the second joint's coordinate to the first one's, SI. offset : SI; left out: as at the start.

    coefficients : of the coordinates of all joints, SI: coefficients times coordinates add up to `constant`, SI; left out: to what
        they add up to at the start. A differential's two shafts and its cage have [1, 1, -2]; the sun, ring and carrier of a
        planetary gear with so many teeth [sun, ring, -(sun + ring)].
    """

    exclusive = (("ratio", "coefficients"),)
    needed = (("ratio", "coefficients"),)

    ratio: NotZero | None = Field(None, description="coordinate of the second joint by that of the first, SI")
    offset: Number | None = None
    coefficients: Annotated[tuple[float, ...], BeforeValidator(_coefficients)] | None = Field(
        None, description="a number for each joint, none of them 0"
    )
    constant: Number | None = None

    @model_validator(mode="after")
    def _check_constants(self):
        for key, of, other in (("offset", "ratio", "constant"), ("constant", "coefficients", "offset")):
            if getattr(self, key) is not None and getattr(self, of) is None:
                raise ValueError(f"{quoted(key)} goes with {quoted(of)}; write {quoted(other)} instead")
        return self


class LinearCoupling(CouplingBase):
    """Between any two joints of one freedom, or with coefficients any number of them."""

    kind: ClassVar[str] = "linear"

    between: Annotated[tuple[str, ...], BeforeValidator(_joints)] = Field(
        description='names of two or more joints, as in between = ["left", "right", "cage"]'
    )
    linear: LinearOptions

    @model_validator(mode="after")
    def _check_count(self):
        joints, factors = len(self.between), self.linear.coefficients
        if factors is None and joints != 2:
            raise ValueError(
                f"a ratio is between two joints, found {joints} of them; write coefficients instead"
            )
        if factors is not None and len(factors) != joints:
            raise ValueError(f"needs a coefficient for each joint, found {len(factors)} for {joints} joints")
        return self

    @property
    def terms(self):
        """((joint, factor, SI), ...): the sum of factor times coordinate, and the offset, are 0."""
        factors = self.linear.coefficients
        return super().terms if factors is None else tuple(zip(self.between, factors))

    @property
    def offset(self):
        """SI; None: as at the start."""
        constant = self.linear.constant
        return super().offset if constant is None else -constant


COUPLINGS = (Gear, Rack, ScrewCoupling, LinearCoupling)
Coupling = by_key("a coupling", *COUPLINGS)
