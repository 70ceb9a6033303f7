"""A scene: everything a user writes about a multibody system, in one checked structure."""

import numpy as np
from pydantic import Field, ValidationError, model_validator

from .bodies import Body, Ground
from .checks import clashes, cross_references, unfit_shapes
from .couplings import Coupling
from .errors import SceneError
from .fields import OneOf, Part, Positive, SomeOf, Vector
from .forces import Force
from .joints import Joint
from .measures import Measure
from .messages import problems_of
from .names import Name, Text, Title
from .writer import toml_text


OUTPUTS = (
    "kinetic_energy", "potential_energy", "total_energy", "gravity_energy", "spring_energy",
    "linear_momentum", "angular_momentum", "center_of_mass",
    "constraint_gap", "constraint_rate", "multipliers",
)


class Solver(Part):
    """How time advances inside a communication step.

    integrator : "rk4", of fixed step, or adaptive: "rk54", of order 5, "rk853", of order 8.
    formulation : "recursive", "embedding", "augmented", or "auto", the cheapest of them.
    step : s, of rk4.
    tolerance, absolute_tolerance : of the adaptive ones, relative and absolute.
    max_step : s, of the adaptive ones, or None.
    """

    integrator: OneOf("rk4", "rk54", "rk853") = "rk54"
    formulation: OneOf("auto", "recursive", "embedding", "augmented") = "auto"
    step: Positive | None = None
    tolerance: Positive = 1e-8
    absolute_tolerance: Positive = Field(default_factory=lambda data: data.get("tolerance", 1e-8))
    max_step: Positive | None = None

    @model_validator(mode="after")
    def _check_integrator(self):
        if self.integrator == "rk4" and self.step is None:
            raise ValueError("rk4 needs a step, as in step = 1e-3")
        if self.integrator != "rk4" and self.step is not None:
            raise ValueError(
                f"{self.integrator} chooses its step itself; write max_step, or "
                'integrator = "rk4"'
            )

        for key in ("tolerance", "absolute_tolerance", "max_step"):
            if self.integrator == "rk4" and key in self.model_fields_set:
                raise ValueError(f"rk4 has no {key}; leave it out, or take rk54")
        return self


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
    """Weight -mu r / |r|^3 per mass, r from the inertial origin. mu : m3/s2."""

    mu: Positive = Field(description="mu in m3/s2, of the earth 3.986e14")


def _gravity(data):
    """Of a scene that says nothing of it."""
    return (0.0, 0.0, 0.0) if data.get("central_gravity") else (0.0, 0.0, -9.81)


class Scene(Part):
    """A multibody scene.

    name : free text.
    title, description : free text, or None.
    central_gravity : or None.
    gravity : (3,) in m/s2 in the inertial frame; 0 with central_gravity.
    output : names of OUTPUTS: energies (J); momenta, the angular one about the inertial origin,
        and the centre of mass (3,); the largest error of the constraints in position and in
        velocity; the multipliers.
    solver, ground : as above.
    body, joint, coupling, force, measure : by name, in the order written.

    Scene(...) takes these as keywords, Scene.model_validate a dict of them; both raise SceneError
    with all that is wrong.
    """

    name: Title = Field(description='name of the scene, as in name = "pendulum"')
    title: Title | None = None
    description: Text | None = None
    central_gravity: CentralGravity | None = None
    gravity: Vector = Field(default_factory=_gravity)
    output: SomeOf(*OUTPUTS) = []
    solver: Solver = Solver()
    ground: Ground = Ground()
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
            problems += clashes(scene)
        if problems:
            raise SceneError(sorted(problems, key=lambda problem: _order(problem.path, data)))
        return scene

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
        """The scene as the text of a TOML file."""
        return toml_text(self)
