"""Measures: what is seen of one frame from another."""

from pydantic import Field

from ..vocabulary import MEASURES
from .ends import BETWEEN, Between
from .fields import Part, SomeOf


class Measure(Part):
    """The place and motion of the second of two markers in the first, in the first one's axes.

    between : the two ends.
    output : names of MEASURES. "angle" is that between the markers' z axes.
    """

    between: Between = Field(description=BETWEEN)
    output: SomeOf(*MEASURES) = Field(description='what goes out, as in output = ["distance"]')
