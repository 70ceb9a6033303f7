"""Scene -> Model: the flat arrays that kernels work on, and the variables that people see.

The names and shapes of the arrays are those of the table in `kernels/layout.py`.
"""

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..kernels import layout, outputs
from ..kernels.motion.inputs import N_DERIVATIVE
from ..kernels.views import DataView, ModelView
from ..scene import Problem, SceneData, SceneError
from ..steppers import STEPPERS, needs_jacobian
from .absolute import add_absolute_starts, keeps_start, start_motion
from .bodies import (
    add_bodies,
    add_ground_outputs,
    add_markers,
    add_measures,
    add_scene_outputs,
    add_settings,
    add_work_limit,
    evaluation_cost,
)
from .builder import Builder
from .constraints import add_constraints
from .couplings import add_coupling_outputs
from .drives import add_drives
from .end_frames import add_end_frames
from .forces import add_forces
from .jacobian import find_structure
from .joints import add_joints
from .light_parts import tell_light_parts
from .natural import Swings, shares_water, swings_of
from .partition import MOST_AT_START, parted_tree, predicted_cost
from .planes import planar_starts
from .reactions import add_reactions
from .states import indicator_variables, led_by, list_states, rate_variables, state_variables
from .survey import NONE, Surveys, survey
from .topology import Tree, absolute_tree, spanning_tree
from .variables import Variable, reference_table


@dataclass(frozen=True)
class RestingStart:
    """A start at rest that a run of an FMU may be asked for.

    x : (n_x,) the state there. rates : (n_x,) x' there, at the start values of all parameters and inputs.
    asked : whether runs start there that say nothing else.
    """

    x: np.ndarray
    rates: np.ndarray
    asked: bool


@dataclass(frozen=True)
class Model:
    """A scene made ready for the kernels.

    identifier : C identifier made from the name.
    ints, reals : structure (int64) and default parameters (float64), flat.
    n_state, n_work, n_u, n_y : lengths of an instance's buffers and of its inputs and outputs.
    variables : inputs, outputs, parameters, in that order.
    exchanged : what model exchange adds to them, and an FMU's value references count on: states, their rates, indicators of events;
        nothing where the model is for co-simulation only.
    told_aside : locals of an FMU, behind these: how joints and bodies move and what they bear, evaluated only where they are read.
    surveys : what these, and the indicators of kinks, are evaluated by.
    places : names that a kernel's status can point to: the nodes of the tree, then the constraints, whose starts would help to close
        each of these, and names of other things.
    tree : nodes, and where the bodies are in them.
    coordinates : (joint, which of its coordinates) -> index among those that something refers to.
    notices : what a user should be told of the scene, and of what was made of it.
    formulation : "recursive", "embedding", "augmented", or "apart" (partition.py).
    rest : the start at rest that its FMU offers, if it does.
    """

    scene: SceneData
    name: str
    identifier: str
    title: str
    description: str
    ints: np.ndarray
    reals: np.ndarray
    n_state: int
    n_work: int
    n_u: int
    n_y: int
    variables: list[Variable]
    exchanged: list[Variable]
    places: list[str]
    tree: Tree
    coordinates: dict[tuple[str, int], int]
    notices: list[str]
    formulation: str = "recursive"
    rest: RestingStart | None = None
    told_aside: list[Variable] = field(default_factory=list)
    surveys: Surveys = field(default_factory=Surveys)

    def __getattr__(self, name):
        """Counts of the layout table by name, e.g. `model.n_v`."""
        if name in layout.COUNTS:
            return int(self.ints[layout.COUNTS.index(name)])

        raise AttributeError(name)

    def views(self, reals=None):
        """(m, d) of a run: the kernels' views of new buffers, inputs at their start values; `reals`: parameters (a copy)."""
        state, work, u = (
            np.zeros(self.n_state),
            np.zeros(self.n_work),
            np.zeros(N_DERIVATIVE * max(1, self.n_u)),
        )
        u[: self.n_u] = [v.start for v in self.of_causality("input")]
        m = ModelView(ints=self.ints, reals=self.reals.copy() if reals is None else reals)
        return m, DataView(ints=self.ints, state=state, work=work, u=u)

    @cached_property
    def guid(self) -> str:
        """Hash of all that a simulation depends on, in the form of a GUID; not made before something asks for it."""
        h = hashlib.sha256(b"".join(sealed(self))).hexdigest()
        return f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"

    @property
    def listed(self) -> list[Variable]:
        """All variables of an FMU, by value reference."""
        return self.variables + self.exchanged + self.told_aside

    @property
    def exchanges(self) -> bool:
        """Whether it can be integrated by a solver outside."""
        return bool(self.exchanged)

    def lean(self, whole: bool = False) -> "Model":
        """The same without locals; `whole`: without anything that a survey tells, so without kinks and commanded motions in model
        exchange too."""
        if not whole:
            return replace(self, told_aside=[], surveys=replace(self.surveys, motion=NONE, efforts=NONE))

        first = 2 * self.n_stop
        exchanged = [v for v in self.exchanged if v.causality != "indicator" or v.index < first]
        return replace(self, told_aside=[], surveys=Surveys(), exchanged=[] if self.n_command else exchanged)

    def nominal_of(self, state: Variable) -> float:
        """The size that a state has."""
        return float(self.reals[self.ints[layout.SLOT["x_nominal"]] + state.index])

    def of_causality(self, causality: str) -> list[Variable]:
        """Inputs, outputs, parameters, constants, states, rates, indicators or locals."""
        return [v for v in self.listed if v.causality == causality]


def compile_scene(scene: SceneData, first=(), for_fmu=True) -> Model:
    """The model of a scene; `first`: joints that are in its tree before all others; `for_fmu`: whether it has what an FMU alone
    tells, states, their rates, indicators of events and locals.

    Raises SceneError where its parts do not form what the kernels can do.
    """
    formulation = _formulation(scene)

    if formulation == "augmented":
        swings = Swings()
        relative = _compile(scene, spanning_tree(scene), "recursive", for_fmu=False, swings=swings)
        motion, angles = start_motion(relative)
        model = _compile(
            scene, absolute_tree(relative.tree, scene), "recursive", motion, angles, for_fmu, swings
        )
        return replace(model, formulation=formulation)

    tree = spanning_tree(scene, first)

    # but for loops in a row articulated bodies were the cheapest of the three at every size and shape measured
    # (`python -m benchmarks`)
    parted = parted_tree(scene, tree) if formulation == "auto" and not first else None
    model = _compile_parted(scene, tree, parted, for_fmu) if parted else None

    if model:
        return replace(model, formulation="apart")

    formulation = "recursive" if formulation == "auto" else formulation
    return replace(_compile(scene, tree, formulation, for_fmu=for_fmu), formulation=formulation)


def _formulation(scene):
    """That of the scene; of one whose bodies move each other's water "embedding". Raises SceneError for another."""
    asked = scene.solver.formulation

    if not shares_water(scene):
        return asked
    if asked not in ("auto", "embedding"):
        text = f'bodies that move each other\'s water need "embedding", or "auto"; found "{asked}"'
        raise SceneError([Problem(("solver", "formulation"), text)])
    return "embedding"


def _compile_parted(scene, tree, parted, for_fmu):
    """The model with bodies apart, which starts as that on the whole tree would; None where it cannot hold that start.

    Where the given start closes the loops, that needs no loop of the whole tree; very many loops are closed apart.
    """

    swings = swings_of(scene, lambda swings: _compile(scene, tree, "recursive", for_fmu=False, swings=swings))

    def compiled(by_joints):
        """The model that starts as one by joint coordinates."""
        motion, angles = start_motion(by_joints)
        start = planar_starts(parted, tree, motion)
        return _compile(scene, parted, "recursive", start, angles, for_fmu, swings)

    model = compiled(_open_model(scene, tree))

    if predicted_cost(scene, tree) < MOST_AT_START and not keeps_start(model):
        model = compiled(_compile(scene, tree, "recursive", for_fmu=False))
        return model if keeps_start(model) else None

    return model


def _open_model(scene, tree):
    """The model of a tree alone, to be asked how it starts: without what closes loops, forces, variables and notices."""
    builder = Builder(scene, tree, False, listing=False)
    add_settings(builder)
    add_drives(builder)
    add_bodies(builder)
    add_end_frames(builder)
    add_joints(builder)
    return _assemble(builder, NO_STEPS)


def _compile(scene, tree, formulation, motion=None, angles=None, for_fmu=True, swings=None):
    """The model on a tree; `motion`: start values of absolute coordinates; `angles`: of joints at the start; `for_fmu`: as above;
    `swings`: what memories of waves are to meet, if that is known.
    """
    swings = swings or Swings()
    builder = Builder(scene, tree, formulation == "embedding", angles)
    builder.near = swings.near or {}
    add_settings(builder)
    add_drives(builder)
    add_bodies(builder)
    add_end_frames(builder)
    add_joints(builder)

    if motion:
        add_absolute_starts(builder, motion)

    add_forces(builder)
    _add_sea(builder)
    add_constraints(builder)
    tell_light_parts(builder)
    add_reactions(builder)
    add_coupling_outputs(builder)
    add_markers(builder)
    add_measures(builder)
    add_ground_outputs(builder)
    add_scene_outputs(builder)
    states = list_states(builder, _scene_length(scene)) if for_fmu else ()
    model = _assemble(builder, STEPPERS[scene.solver.integrator], states)

    if builder.wave_places or builder.wet_members:
        from .hydrodynamics import meet_waves

        meet_waves(builder, model)

    if swings.near is None and swings.find(builder, model):
        return _compile(scene, tree, formulation, motion, angles, for_fmu, swings)

    swings.tell(builder, model)
    notices = scene.notices + [str(notice) for notice in builder.notices]

    if not for_fmu:
        return replace(model, notices=notices)

    surveys, told, indicators = survey(builder, model)
    return replace(
        model, notices=notices, surveys=surveys, told_aside=told, exchanged=model.exchanged + indicators
    )


def _add_sea(builder):
    """Outputs and notices of the sea. What knows of it is imported where there is one."""
    if builder.scene.sea:
        from .sea_limits import tell_steep_waves
        from .seas import add_sea

        add_sea(builder)
        tell_steep_waves(builder)


# the stepper of models that are asked for their start alone: it keeps the least
NO_STEPS = STEPPERS["rk4"]


def _assemble(builder, stepper, states=()):
    """The model of all that was collected; states: what model exchange is told of x, none where nobody asks."""
    scene = builder.scene
    counts = _counts(builder, stepper)
    add_work_limit(builder, counts)
    header, length = layout.arrange(counts)
    offset = {row.name: header[layout.SLOT[row.name]] for row in layout.ARRAYS}
    places = [node.name for node in builder.nodes] + builder.constraint_names + builder.loop_hints
    values = _values(builder, len(places))
    values["x_nominal"] = [state.nominal for state in states] or np.ones(counts["n_x"])
    places += builder.names
    buffers = {"ints": np.zeros(length["ints"], np.int64), "reals": np.zeros(length["reals"])}
    buffers["ints"][: len(header)] = header

    for row in layout.ARRAYS:
        if row.buffer in buffers and (size := layout.array_length(row, counts)):
            buffers[row.buffer][offset[row.name] : offset[row.name] + size] = np.ravel(values[row.name])

    return Model(
        scene=scene,
        name=scene.name,
        identifier=c_identifier(scene.name),
        title=scene.title or scene.name,
        description=scene.description or "",
        **buffers,
        n_state=length["state"],
        n_work=length["work"],
        n_u=counts["n_u"],
        n_y=counts["n_y"],
        **_list_variables(builder, states, offset),
        places=places,
        tree=builder.tree,
        coordinates=dict(builder.coordinates),
        notices=[],
    )


def _list_variables(builder, states, offset):
    """All variables, and those of model exchange, as fields of a Model.

    Where inputs command motions without their accelerations, what is not told is found from one communication step to the next:
    there is no such step for a solver outside.
    """
    told = builder.tables["n_command"].columns.get("command_u", [])
    led = led_by(builder, states) if all(u[2] >= 0 for u in told) else None

    if led is None or not states:
        return {"variables": builder.list_variables(offset), "exchanged": []}

    listed = state_variables(states)
    reference = {v.index: builder.n_listed + k for k, v in enumerate(listed)}
    of = {known: tuple(sorted(reference[k] for k in known)) for known in set(led)}
    return {
        "variables": builder.list_variables(offset, [of[known] for known in led]),
        "exchanged": [*listed, *rate_variables(listed), *indicator_variables(builder)],
    }


def _counts(builder, stepper):
    """All counts of the layout: lengths of tables and what else is counted, by name."""
    counts = {name: table.length for name, table in builder.tables.items()}
    counts |= builder.counts
    n_s = len(builder.single["s_start"])
    kinds = [output.kind for output in builder.outputs]
    counts |= {
        "n_q": builder.n_q,
        "n_v": builder.n_v,
        "n_s": n_s,
        "n_z": n_s + counts["n_turn"] + counts["n_memory"],
        "n_x": builder.n_q + builder.n_v + n_s + counts["n_turn"] + counts["n_memory"],
        "n_u": len(builder.inputs),
        "n_y": len(builder.outputs),
        "output_needs": outputs.needs(kinds),
        "n_turned": counts["n_body"] if outputs.EULER_PARAMETERS in kinds else 0,
        "embeds": int(builder.embeds),
        "n_mass": builder.n_v**2 if builder.embeds else 0,
        "integrator": stepper.number,
    }
    structure = _jacobian(builder, stepper, counts)
    return (
        counts
        | {
            "n_stage": stepper.stage_rows * counts["n_x"],
            "n_dense": stepper.dense_rows * counts["n_x"],
            "n_jacobian": structure.n_value if structure else 0,
            "n_swap": counts["n_x"] if structure else 0,
        }
        | ({name: len(rows) for name, rows in structure.tables.items()} if structure else {})
    )


# s, about what a product of two numbers costs in a factor
PRODUCT = 4e-10

# s, about what a force between two markers costs in an evaluation
FORCE = 2e-7


def _jacobian(builder, stepper, counts):
    """The structure of the Jacobian, its arrays into the builder; None where the stepper needs none."""
    builder.single |= {"jacobian_work": 0.0, "lu_work": 0.0, "solve_work": 0.0}

    if not stepper.implicit or not counts["n_x"]:
        return None

    structure = find_structure(
        _arrays(builder), *(counts[n] for n in ("n_body", "n_q", "n_v", "n_s", "n_turn"))
    )

    if not needs_jacobian(stepper, structure.n_value):
        return None

    # a complex product is four real ones; what bodies and rows cost was told generously, without forces
    n_force = counts.get("n_strut", 0) + 2 * counts.get("n_six_by_six", 0)
    n_force += 2 * counts["n_line"] + counts["n_corner"] // 10
    cost = 0.5 * evaluation_cost(builder, counts) + FORCE * n_force
    builder.single |= structure.single | {
        "jacobian_work": structure.n_evaluation,
        "lu_work": 5 * PRODUCT * structure.products / cost,
        "solve_work": 5 * PRODUCT * structure.n_value / cost,
    }

    for name, rows in structure.tables.items():
        builder.tables[name].extend(rows)

    return structure


def _arrays(builder):
    """What was collected so far, arrays by name."""
    tables = [table.columns for table in builder.tables.values()]
    return builder.single | {
        name: np.concatenate(column) for columns in tables for name, column in columns.items()
    }


def _values(builder, first_name):
    """What stands in the arrays, by name; first_name : place of the builder's first name among those that messages point to."""
    values = _arrays(builder)

    for name in ("told_place", "stop_place", "low_place"):
        values[name] = np.asarray(values.get(name, ())) + first_name

    values["scene_length"] = _scene_length(builder.scene)
    values["body_added"] = _bodies_with_added_mass(values, len(builder.nodes))
    return values


def _scene_length(scene):
    """m, size of the parts: mean distance of the joints' markers from the origins of their bodies, whatever else is asked for."""
    ends = [end for joint in scene.joint.values() for end in joint.between]
    places = [scene.marker(end).position for end in ends if "." in end]
    lengths = np.linalg.norm(places, axis=1) if places else np.zeros(0)
    lengths = lengths[lengths > 0.0]
    return lengths.mean() if lengths.size else 1.0


def _bodies_with_added_mass(values, n_body):
    """1 for each node that a force with added mass acts on."""
    added = np.zeros(n_body)

    for adds, marker in zip(values.get("six_by_six_adds", ()), values.get("six_by_six_to", ())):
        if adds:
            added[int(values["marker_body"][int(marker)])] = 1

    return added


def c_identifier(name: str) -> str:
    """A C identifier that reads like `name`."""
    text = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    return text if re.match(r"[A-Za-z]", text) else f"m_{text}"


def with_values(model: Model, values: Mapping[str, float], notices: Sequence[str] = ()) -> Model:
    """The model with other start values of inputs and values of parameters, by name, and more notices of it."""
    notices = [text for text in notices if text not in model.notices]

    if not values:
        return replace(model, notices=model.notices + notices) if notices else model

    reals, variables = model.reals.copy(), list(model.variables)

    for k, v in enumerate(variables):
        if v.name in values:
            variables[k] = replace(v, start=values[v.name])

            if v.causality == "parameter":
                reals[v.index] = values[v.name]

    return replace(model, reals=reals, variables=variables, notices=model.notices + notices)


SEALED_SIZES = ("ints", "reals", "state", "work", "u", "y", "variables", "survey_ints", "survey_reals")
"""Sizes that the GUID is made of, in their order."""


def sealed(model: Model) -> tuple[bytes, bytes]:
    """What the GUID is made of, little endian, as it lies in an FMU: (SEALED_SIZES, the numbers and a digest of
    what is told of the variables); see fmu_src/resource.h."""
    survey_ints, survey_reals = model.surveys.data()
    sizes = (
        len(model.ints),
        len(model.reals),
        model.n_state,
        model.n_work,
        model.n_u,
        model.n_y,
        len(model.listed),
        len(survey_ints),
        len(survey_reals),
    )
    u_start = np.zeros(model.n_u, "<f8")

    for v in model.of_causality("input"):
        u_start[v.index] = v.start

    numbers = (
        model.ints.astype("<i8"),
        model.reals.astype("<f8"),
        u_start,
        reference_table(model.listed),
        survey_ints.astype("<i8"),
        survey_reals.astype("<f8"),
    )
    told = hashlib.sha256(repr((model.listed, model.places)).encode()).digest()
    return np.array(sizes, "<i8").tobytes(), b"".join(array.tobytes() for array in numbers) + told
