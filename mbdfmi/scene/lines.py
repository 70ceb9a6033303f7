"""Lines that hang in the water or lie on the sea bed."""

from typing import Annotated, ClassVar

from pydantic import BeforeValidator, Field, model_validator

from ..vocabulary import LINE_OUTPUTS
from .ends import Between
from .errors import listed, show
from .fields import Boolean, NotNegative, Part, Positive, SomeOf


class Clump(Part):
    """A weight or a buoy at the place where two sections of a line meet.

    mass : kg, in air.
    volume : m3, of water that it displaces; one lighter than that is a buoy, at any height: it does not stop at the surface
        (`mbdfmi moorings` tells where it would be out of the water).
    """

    mass: NotNegative = 0.0
    volume: NotNegative = 0.0

    @model_validator(mode="after")
    def _check_given(self):
        if not self.model_fields_set:
            raise ValueError("needs a mass (kg), a volume (m3), or both")
        return self


class LineSection(Part):
    """A part of a line, of one kind.

    length, mass, diameter, stiffness : as of a line of one section; one that is lighter than the water floats up.
    clump : what hangs at its end towards the line's second end, where the next section begins.
    """

    length: Positive
    mass: Positive
    diameter: NotNegative = 0.0
    stiffness: Positive
    clump: Clump | None = None


def _sections(value):
    if isinstance(value, (dict, LineSection)):
        return [value]
    if not isinstance(value, (list, tuple)) or not value:
        raise ValueError(f"needs a list of tables, as in {SECTIONS}; found {show(value)}")
    return value


SECTIONS = "[{ length = 100, mass = 80, stiffness = 5e8 }, ...]"
Sections = Annotated[list[LineSection], BeforeValidator(_sections)]
OF_ONE = ("length", "mass", "diameter", "stiffness")


class CatenaryOptions(Part):
    """An elastic line that hangs as it would at rest, without inertia, drag, bending; the bed is flat.

    length : m, unstretched.
    mass : kg/m, in air.
    diameter : m, of the round line of the same volume, by which water carries it; 0 in air.
    stiffness : N, EA: tension by strain.
    bed : whether it may lie on a bed, which is as high as the first end; by default where that is on the ground (unless the second end
        starts lower, or the sea has a depth and the first is more than 1 % of that above its bed). Where that end moves up or down, the
        bed does so with it, and its work is in no power or energy. A second end below the bed is pulled along it alone.
    friction : of the bed along the line, by the weight that lies on it (chain on sand: about 1): the pull falls towards the first
        end, to 0 at most. It has no memory, and leaves the line free to move sideways. Nothing in the line may float then.
    sections : instead of length, mass, diameter, stiffness: chain, rope, chain, from the first end to the second, and what hangs
        between them.
    """

    length: Positive | None = None
    mass: Positive | None = None
    diameter: NotNegative = 0.0
    stiffness: Positive | None = None
    bed: Boolean | None = None
    friction: NotNegative = 0.0
    sections: Sections | None = None

    @model_validator(mode="after")
    def _check_sections(self):
        given = [key for key in OF_ONE if key in self.model_fields_set]

        if self.sections is None:
            if missing := [key for key in OF_ONE if key != "diameter" and key not in given]:
                raise ValueError(f"needs {listed(missing)}, or sections = {SECTIONS}")
        elif given:
            raise ValueError(f"with sections, each of them has its {listed(given)}, and the line has none")
        elif self.sections[-1].clump is not None:
            raise ValueError(
                "the last section ends at the second end of the line: a clump there is a matter of the body"
            )

        if self.friction > 0.0 and self.bed is False:
            raise ValueError("friction is that of a bed, and bed = false goes without")
        return self

    @property
    def is_composite(self) -> bool:
        """Whether it is one of several sections, or with friction: those are kept apart from the others."""
        return self.sections is not None or self.friction > 0.0

    @property
    def total_length(self) -> float:
        """m, of all sections."""
        return sum(section.length for section in self.parts)

    @property
    def parts(self) -> list[LineSection]:
        """The sections, one of a line without."""
        if self.sections is not None:
            return self.sections

        return [
            LineSection(length=self.length, mass=self.mass, diameter=self.diameter, stiffness=self.stiffness)
        ]


class Catenary(Part):
    """catenary = { length, mass, diameter, stiffness, bed, friction, sections }, between : an anchor and what it holds, or two bodies.

    Chain, wire or rope that is slow beside its own waves (quasi-static). Forces follow from where the ends are: it works as a spring,
    and keeps energy but for friction of the bed.

    output : tension at the second end and at the first (N), length on the bed (m), force on the second end in the inertial
        frame (N), the power on the bodies (W).
    """

    kind: ClassVar[str] = "catenary"
    input: ClassVar[tuple] = ()

    catenary: CatenaryOptions
    between: Between = Field(description='the two ends, as in between = ["ground.anchor", "hull.fairlead"]')
    output: SomeOf(*LINE_OUTPUTS) = ()
