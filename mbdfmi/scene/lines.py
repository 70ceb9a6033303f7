"""Lines that hang in the water or lie on the sea bed."""

from typing import ClassVar

from pydantic import Field

from ..vocabulary import LINE_OUTPUTS
from .ends import Between
from .fields import Boolean, NotNegative, Part, Positive, SomeOf


class CatenaryOptions(Part):
    """An elastic line that hangs as it would at rest, without inertia, drag, bending; the bed is flat and smooth.

    length : m, unstretched.
    mass : kg/m, in air.
    diameter : m, of the round line of the same volume, by which water carries it; 0 in air.
    stiffness : N, EA: tension by strain.
    bed : whether it may lie on a bed, which is as high as the first end; by default where that is on the ground (unless the sea has a
        depth and the end is more than 1 % of that above its bed). Where that end moves up or down, the bed does so with it, and its
        work is in no power or energy.
    """

    length: Positive
    mass: Positive
    diameter: NotNegative = 0.0
    stiffness: Positive
    bed: Boolean | None = None


class Catenary(Part):
    """catenary = { length, mass, diameter, stiffness, bed }, between : an anchor and what it holds, or two bodies.

    Chain or wire that is slow beside its own waves (quasi-static). Forces follow from where the ends are: it works as a spring, and
    keeps energy.

    output : tension at the second end and at the first (N), length on the bed (m), force on the second end in the inertial
        frame (N), the power on the bodies (W).
    """

    kind: ClassVar[str] = "catenary"
    input: ClassVar[tuple] = ()

    catenary: CatenaryOptions
    between: Between = Field(description='the two ends, as in between = ["ground.anchor", "hull.fairlead"]')
    output: SomeOf(*LINE_OUTPUTS) = ()
