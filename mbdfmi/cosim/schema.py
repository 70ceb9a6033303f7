"""A coupled system as its author writes it: FMUs and scenes, links, what a run is to do."""

import os
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, ValidationError, ValidationInfo, model_validator

from ..scene.errors import SceneError, show
from ..scene.fields import Boolean, Number, OneOf, Part, Positive, given, left_out
from ..scene.messages import problems_of
from ..scene.names import Name, Title
from .conversions import CONVERSION, WORDS

METHODS = ("auto", "jacobi", "gauss-seidel", "iterate", "newton")
"""How FMUs wait for each other (docs/coupling.md)."""

HOLDS = ("start", "mean", "end")
"""What an FMU that takes no derivatives sees of an input over a step."""


def _file(value, info: ValidationInfo):
    """A path that starts at the system's own folder."""
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"needs the name of a file in quotes, found {show(value)}")
    return os.path.join((info.context or {}).get("folder", ""), value)


def _value(value):
    """A value of a parameter: a number, true or false, a text, or a list of these."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_value(item) for item in value]
    if not isinstance(value, (bool, int, float, str)):
        raise ValueError(f"needs a number, true or false, a text, or a list of these; found {show(value)}")
    return value


def _flat(value):
    """Parameters by whole names: `a.b = 1` in TOML is a table within a table."""
    if not isinstance(value, dict):
        raise ValueError(f"needs a table of values by variable name, found {show(value)}")

    found = {}
    for name, item in value.items():
        if isinstance(item, dict):
            found |= {f"{name}.{below}": each for below, each in _flat(item).items()}
        else:
            found[str(name)] = _value(item)
    return found


def _texts(value):
    """One text, or a list of texts."""
    texts = [value] if isinstance(value, str) else value
    if not isinstance(texts, (list, tuple)) or not texts or not all(isinstance(t, str) for t in texts):
        raise ValueError(f'needs "fmu.variable" or a list of these, found {show(value)}')
    return list(texts)


def _numbers(value):
    """One number, or a list of numbers."""
    from ..scene.fields import number

    return [number(item) for item in value] if isinstance(value, (list, tuple)) else number(value)


File = Annotated[str, BeforeValidator(_file)]
Parameters = Annotated[dict[str, Any], BeforeValidator(_flat)]
Texts = Annotated[list[str], BeforeValidator(_texts)]
Numbers = Annotated[Any, BeforeValidator(_numbers)]


def _scene(value, info: ValidationInfo):
    """A scene's file, or a scene."""
    return value if hasattr(value, "compile") else _file(value, info)


class Fmu(Part):
    """One of the FMUs, or a scene in its place.

    file : of an FMU for co-simulation, FMI 2.0 or 3.0, of any maker; or
    scene : a scene file (TOML), which takes part without an FMU being written. In Python also a scene.
    parameters : start values of parameters, inputs and other variables, by name; arrays as lists.
    stop_time : whether it is told when the run ends. Some FMUs run to the end in their first step then.
    derivatives : whether its inputs are given as polynomials where it says that it can take them.
    rollback : whether its state is saved and restored where it says that it can be.
    hold : what inputs that are not polynomials are over a step: "start", "mean" or "end"; without it the mean, and the
        end where outputs depend on the input at once.
    log : whether its debug logging is on.
    """

    exclusive = ()
    needed = (("file", "scene"),)

    file: File | None = None
    scene: Annotated[Any, BeforeValidator(_scene)] = None
    parameters: Parameters = {}
    stop_time: Boolean = False
    derivatives: Boolean = True
    rollback: Boolean = True
    hold: OneOf(*HOLDS) | None = None
    log: Boolean = False


class Link(Part):
    """What an input is fed with: factor times the source, plus offset; several sources are added up.

    source : "fmu.variable" of an output or a local variable, or a list of these. An array without index stands for all
        its elements.
    target : "fmu.variable" of an input.
    factor : one number, or one for each source.
    offset : in the unit of the target.
    units : whether units are compared and converted; false where a factor has a unit.
    hold : as of an FMU, for this input.
    convert : angles of the source into Euler parameters or an angular velocity: "euler_zyx", of angles about z,
        then the new y, then the newest x, and so for each order of axes; "rotation_vector"; with "_rates" an
        angular velocity of three angles and their rates, in the axes that the angles begin with. Factors act
        before it.
    """

    source: Texts
    target: Annotated[str, BeforeValidator(lambda value: _texts(value)[0])]
    factor: Numbers = 1.0
    offset: Numbers = 0.0
    units: Boolean = True
    hold: OneOf(*HOLDS) | None = None
    convert: Annotated[str, BeforeValidator(lambda value: _conversion(value))] | None = None

    @model_validator(mode="after")
    def _check_factors(self):
        if self.convert and np.any(self.offset):
            raise ValueError("a link with convert takes no offset")
        if isinstance(self.factor, list) and len(self.factor) != len(self.source):
            raise ValueError(f"factor has {len(self.factor)} numbers for {len(self.source)} sources")
        return self

    @property
    def factors(self):
        """One for each source."""
        return self.factor if isinstance(self.factor, list) else [self.factor] * len(self.source)


def _conversion(value):
    if not isinstance(value, str) or not CONVERSION.fullmatch(value):
        raise ValueError(f"needs {WORDS}; found {show(value)}")
    return value


class Bond(Part):
    """Two links that carry power: a force one way, a velocity the other.

    effort : "fmu.variable", source of the force, moment, voltage, pressure.
    flow : "fmu.variable", source of the velocity, rate, current, volume flow, at the other FMU.
    """

    effort: str
    flow: str


class Master(Part):
    """How the run is done.

    method : "jacobi", all FMUs at once; "gauss-seidel", one after another; "iterate", steps repeated until all agree;
        "newton", the same by the interface Jacobian; "auto", the best that the FMUs allow.
    order : of the polynomials that inputs are over a step, 0, 1 or 2; by default 1 where steps are repeated, else 0.
    sequence : of the FMUs in "gauss-seidel", all or the first of them; by default what dependencies advise.
    tolerance : of repeated steps, relative to the largest value that a link had.
    max_iterations : of a step.
    error : relative; with it macro steps are chosen so that what inputs miss of the truth stays below it.
    min_step, max_step : s, of macro steps so chosen.
    start_in_parts : whether the first step is done in parts of 1/8, 1/8, 1/4, 1/2 where all steps are repeated and FMUs
        can take them: what is switched on at the start is quick.
    limit : magnitude of a linked value beyond which the run has diverged, in the input's unit.
    """

    method: OneOf(*METHODS) = "auto"
    order: Annotated[int | None, BeforeValidator(lambda value: _order(value))] = None
    sequence: list[str] = []
    tolerance: Positive = 1e-6
    max_iterations: Annotated[int, BeforeValidator(lambda value: _count(value))] = 20
    error: Positive | None = None
    min_step: Positive | None = None
    max_step: Positive | None = None
    start_in_parts: Boolean = True
    limit: Positive = 1e12

    @model_validator(mode="after")
    def _check_order(self):
        if self.order == 0 and self.method in ("iterate", "newton"):
            raise ValueError(
                f'method "{self.method}" needs order = 1 or 2: its inputs are polynomials over a step'
            )
        return self


def _order(value):
    if isinstance(value, bool) or value not in (0, 1, 2):
        raise ValueError(f"needs 0, 1 or 2, found {show(value)}")
    return value


def _count(value):
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 10_000:
        raise ValueError(f"needs a whole number from 1 to 10000, found {show(value)}")
    return value


class Run(Part):
    """What a run takes when nothing else is said.

    start, stop : s. step : s, from one communication point to the next.
    """

    start: Number = 0.0
    stop: Number = 10.0
    step: Positive = 0.01

    @model_validator(mode="after")
    def _check_span(self):
        if not self.stop > self.start:
            raise ValueError(f"stop must be after start ({self.start:g}), found {self.stop:g}")
        return self


def _links(value):
    """Links, each a table or a pair [source, target]."""
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"needs a list of links, [[link]], found {show(value)}")

    return [
        {"source": item[0], "target": item[1]} if isinstance(item, (list, tuple)) and len(item) == 2 else item
        for item in value
    ]


class SystemData(Part):
    """FMUs and scenes that run together.

    name : of the system.
    fmu : [fmu.NAME], one for each FMU or scene.
    link : [[link]], one for each input that is fed; or pairs [source, target].
    record : names of what results hold, "fmu.variable", "fmu" for all its outputs; without it all outputs of all.
    bond : [bond.NAME], pairs of links whose power is watched, beside those that units tell.
    master : how the run is done.
    run : how long it is, and its step.
    """

    name: Title = "system"
    fmu: dict[Name, Fmu] = Field(default={}, description="one table [fmu.NAME] for each FMU or scene")
    link: Annotated[list[Link], BeforeValidator(_links)] = []
    record: list[str] | None = None
    bond: dict[Name, Bond] = {}
    master: Master = left_out(Master)
    run: Run = left_out(Run)

    @model_validator(mode="after")
    def _check_fmus(self):
        if not self.fmu:
            raise ValueError("needs at least one FMU, [fmu.NAME]")
        return self

    @model_validator(mode="wrap")
    @classmethod
    def _check_whole(cls, data, handler):
        if isinstance(data, cls):
            return data
        try:
            return handler(data)
        except ValidationError as error:
            raise SceneError(problems_of(error, cls, data)) from None

    def tables(self):
        """What was given, as plain tables."""
        return given(self)
