"""A scene: everything a user writes about a multibody system, in one checked structure."""

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field, ValidationError, model_validator

from ..steppers import STEPPERS
from ..vocabulary import SCENE_OUTPUTS, SOLVER_OUTPUTS
from .bodies import Body, Ground
from .checks import (
    clashes,
    cross_references,
    elevations_without_waves,
    rotors_without_wind,
    unfit_shapes,
    unfit_water,
)
from .code import Code
from .errors import SceneError
from .experiment import Experiment
from .fields import Boolean, OneOf, Part, Positive, SomeOf, Tolerance, Vector, given, left_out
from .joints import Joint
from .looks import View
from .messages import problems_of
from .names import Name, Text, Title
from .notices import notices
from .rare import rare
from .writer import toml_text

if TYPE_CHECKING:
    from .couplings import Coupling
    from .forces import Force
    from .measures import Measure
    from .sea import Sea
    from .trimming import Trimming
    from .wind import Wind
else:
    (Coupling,), (Force,), (Measure,) = (
        rare("couplings", "Coupling"),
        rare("forces", "Force"),
        rare("measures", "Measure"),
    )
    (Sea,), (Wind,), (Trimming,) = rare("sea", "Sea"), rare("wind", "Wind"), rare("trimming", "Trimming")


class Solver(Part):
    """How time advances inside a communication step.

    integrator : adaptive: "rk54" and "rk853", explicit, of order 5 and 8; "radau", implicit, of order 5, for stiff
        motions; "auto", whichever of these, and of some of its own, costs least as the motion goes. With
        a fixed step: "rk4", explicit, of order 4; "ros2", linearly implicit, of order 2, for stiff motions in real time;
        "gauss", implicit and symmetric, of order 8, for the long run.
    formulation : "recursive", "embedding", "augmented", or "auto": joint coordinates, or, where many loops stand in a row and
        that is predicted to be much cheaper, bodies apart, whose own poses are the states and have the start values (as
        with "augmented"; position and angle in the plane where all of the mechanism moves in one). `mbdfmi info` shows what was
        chosen.
    step : s, of those with a fixed step.
    tolerance, absolute_tolerance : of the adaptive ones, relative and absolute.
    max_step : s, of the adaptive ones, or None.
    max_evaluations : of the accelerations in one communication step, iterations of the projection counted as such; a step that
        needs more stops with the time reached. Without it, as many as take about 10 s.
    closing_tolerance : m and rad, the largest gap of a closed loop. A loop that repeats itself not quite exactly, as one of
        hinges whose axes are 1e-5 rad off, is closed but for a gap of up to 1e-4, which is told.
    start : "given", as the start values say; or "equilibrium", the static equilibrium that the scene comes to from there
        (`mbdfmi equilibrium`): all at rest, but for what spins without stiffness, which keeps its speed; or "trim", what
        `trim` asks for (`mbdfmi trim`). An FMU starts where the scene's own parameters have it: changed parameters do not move its start.
    trim : what the scene is trimmed to, or None.
    output : names of SOLVER_OUTPUTS: numbers since the start, and the sum of the estimated local errors (relative), those of
        what is read off between inner steps included.
    """

    integrator: OneOf(*STEPPERS) = "auto"
    formulation: OneOf("auto", "recursive", "embedding", "augmented") = "auto"
    step: Positive | None = None
    tolerance: Tolerance = 1e-8
    absolute_tolerance: Tolerance = Field(default_factory=lambda data: data.get("tolerance", 1e-8))
    max_step: Positive | None = None
    max_evaluations: Positive | None = None
    closing_tolerance: Positive = 1e-9
    start: OneOf("given", "equilibrium", "trim") = "given"
    trim: Trimming | None = None
    output: SomeOf(*SOLVER_OUTPUTS) = []

    @model_validator(mode="after")
    def _check_integrator(self):
        fixed = self.fixed_step
        if fixed and self.step is None:
            raise ValueError(f"{self.integrator} needs a step, as in step = 1e-3")
        if not fixed and self.step is not None:
            raise ValueError(
                f'{self.integrator} chooses its step itself; write max_step, or integrator = "rk4"'
            )

        for key in ("tolerance", "absolute_tolerance", "max_step"):
            if fixed and key in self.model_fields_set:
                raise ValueError(f"{self.integrator} has no {key}; leave it out, or take rk54")
        if fixed and "estimated_error" in self.output:
            raise ValueError(f'{self.integrator} estimates no error; leave out the output "estimated_error"')
        return self

    @model_validator(mode="after")
    def _check_start(self):
        if self.start == "trim" and not self.trim:
            raise ValueError(
                'start = "trim" needs a table [solver.trim]: find, names of what is to be found, and keep or steady, for what'
            )
        return self

    @property
    def fixed_step(self):
        """Whether the integrator takes steps of one length."""
        return STEPPERS[self.integrator].fixed


def _order(path, data):
    """Where a path is in the data, to sort by: the position of each of its keys among its kin."""
    order = []
    for key in path:
        if not isinstance(data, dict) or key not in data:
            break
        order.append(list(data).index(key))
        data = data[key]
    return order


class CentralGravity(Part):
    """Weight -mu r / |r|^3 per mass, r from the inertial origin.

    mu : m3/s2.
    gradient : whether bodies feel that their near side is drawn more than their far side, to the second order of their size: the
        moment 3 mu r x I r / |r|^5 about the centre of mass, I the inertia about it, and what that means for the weight. False: all
        weight acts at the centre of mass. For satellites; bodies must be small beside their distance from the origin.
    """

    mu: Positive = Field(description="mu in m3/s2, of the earth 3.986e14")
    gradient: Boolean = False


def _gravity(data):
    """Of a scene that says nothing of it."""
    return (0.0, 0.0, 0.0) if data.get("central_gravity") else (0.0, 0.0, -9.81)


class SceneData(Part):
    """A multibody scene.

    name : free text.
    title, description : free text, or None.
    central_gravity : or None.
    sea, wind : or None.
    gravity : (3,) in m/s2 in the inertial frame; [0, 0, -9.81] when left out, 0 with central_gravity.
    output : names of SCENE_OUTPUTS: energies (J); powers (W) of inputs, loads and drivers, and what dampers, friction, stops and
        damping take: the rate of the total energy is the sum of the three less the last; momenta, the angular one
        about the inertial origin, and the centre of mass (3,); the largest error of the constraints in position and in
        velocity; the multipliers.
    solver, experiment, code, ground, view : as above.
    body, joint, coupling, force, measure : by name, in the order written.

    Scene(...) takes these as keywords, Scene.model_validate a dict of them; both raise SceneError
    with all that is wrong.
    """

    name: Title = Field(description='name of the scene, as in name = "pendulum"')
    title: Title | None = None
    description: Text | None = None
    central_gravity: CentralGravity | None = None
    sea: Sea | None = None
    wind: Wind | None = None
    gravity: Vector = Field(default_factory=_gravity)
    output: SomeOf(*SCENE_OUTPUTS) = []
    solver: Solver = left_out(Solver)
    experiment: Experiment = left_out(Experiment)
    code: Code = left_out(Code)
    ground: Ground = left_out(Ground)
    view: View = left_out(View)
    body: dict[Name, Body] = {}
    joint: dict[Name, Joint] = {}
    coupling: dict[Name, Coupling] = {}
    force: dict[Name, Force] = {}
    measure: dict[Name, Measure] = {}

    @model_validator(mode="after")
    def _check_gravity(self):
        if self.central_gravity and "gravity" in self.model_fields_set:
            raise ValueError('"gravity" and "central_gravity" exclude each other; keep one of them')
        return self

    @model_validator(mode="wrap")
    @classmethod
    def _check_whole(cls, data, handler):
        if isinstance(data, cls):
            return data

        # the references are checked even where other things are wrong, so that all is said at once
        try:
            scene, problems = handler(data), []
        except ValidationError as error:
            scene, problems = None, problems_of(error, cls, data)

        problems += cross_references(data)
        if not problems:
            problems += unfit_shapes(scene)
        if scene:
            problems += clashes(scene) + unfit_water(scene) + rotors_without_wind(scene)
            problems += elevations_without_waves(scene)
        if problems:
            raise SceneError(sorted(problems, key=lambda problem: _order(problem.path, data)))
        return scene

    def __eq__(self, other):
        """Whether the same was given: where it came from does not count."""
        return isinstance(other, SceneData) and given(self) == given(other)

    __hash__ = None

    @property
    def notices(self):
        """What is odd in the scene but may be meant (list of str): see scene/notices.py."""
        return [str(notice) for notice in notices(self)]

    def marker_pose(self, end):
        """Where an end ("body", "body.marker", "ground", "ground.marker", "inertial") is.

        Returns (name of the body, "ground" or "inertial", position (3,) in m, A (3, 3)) in the
        frame of that.
        Raises KeyError for an end that is not there.
        """
        owner, _, name = end.partition(".")
        if not name:
            return owner, np.zeros(3), np.eye(3)
        return owner, *self.marker(end).pose()

    def marker(self, end):
        """The marker that an end ("body.marker", "ground.marker") names. Raises KeyError."""
        owner, _, name = end.partition(".")
        holder = self.ground if owner == "ground" else self.body[owner]
        return holder.marker[name]

    def to_toml(self):
        """The scene as the text of a TOML file; names of mesh files as they are, from the folder it was in."""
        return toml_text(self)
