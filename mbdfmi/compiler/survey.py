"""What a model tells beside its outputs: lists of outputs of their own, that are evaluated when asked for alone.

A survey leaves the model as it is. It has a head of `ints` and the arrays that are longer than the model's, which stand behind
these; evaluated with them over the same state, the kernel of the outputs writes what the survey lists.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..kernels import exchange, layout, outputs
from ..vocabulary import MARKER_OUTPUTS, PARAMETERS, POSE_EFFORTS, coordinate_names
from ..vocabulary import REACTIONS as ALL_REACTIONS
from .bodies import MARKER_KINDS
from .builder import Builder, Source, Table
from .end_frames import add_parameter_effort, add_parameter_outputs
from .joint_kinds import kind_of, scalars, units_along
from .joints import add_coordinate_outputs, add_pose_efforts, add_pose_output, add_reaction
from .reactions import add_reactions
from .variables import Variable, array_of, dotted

MOST_LOCALS = 2_000
"""Numbers that are told beside the outputs, about 0.4 MB of a description. Where there are more efforts and reactions are left out,
where even so there are, all."""

MOTIONS = ("position", "velocity", "euler_parameters", "omega")
"""What is told of bodies, and of joints that have it."""

REACTIONS = ("reaction_force", "reaction_moment")

# what may be longer in a survey than in the model
_COUNTS = ("n_marker", "n_coordinate", "n_reaction", "n_output", "n_turned")


@dataclass(frozen=True)
class Survey:
    """Outputs that are evaluated apart from the model's.

    ints : the head of `ints`, and behind it what stands behind the model's own. reals : what stands behind the model's.
    n_work : length of `work`. n_y : how many numbers it tells.
    """

    ints: np.ndarray
    reals: np.ndarray
    n_work: int
    n_y: int


NONE = Survey(np.zeros(0, np.int64), np.zeros(0), 0, 0)


@dataclass(frozen=True)
class Surveys:
    """All surveys of a model.

    motion, efforts : of joints and bodies, what needs no accelerations and what does. watched : what tables are over, and
    kinks : where these have kinks, ascending, for each number of it. left_out : what is not told for its length.
    """

    motion: Survey = NONE
    efforts: Survey = NONE
    watched: Survey = NONE
    kinks: tuple[tuple[float, ...], ...] = ()
    left_out: str = ""

    def data(self) -> tuple[np.ndarray, np.ndarray]:
        """(ints, reals) as they lie in an FMU; see fmu_src/survey.h."""
        found = (self.motion, self.efforts, self.watched)
        sizes = [np.array([len(s.ints), len(s.reals), s.n_work, s.n_y], np.int64) for s in found]
        counts = np.array([len(k) for k in self.kinks], np.int64)
        ints = np.concatenate([*sizes, *(s.ints for s in found), counts])
        return ints, np.concatenate([np.zeros(0), *(s.reals for s in found), *map(np.asarray, self.kinks)])


def survey(builder: Builder, model) -> tuple[Surveys, list[Variable], list[Variable]]:
    """The surveys of a model, the locals that they tell, and the indicators of kinks, where a solver outside is to stop.

    builder : what the model was made of, of no use afterwards.
    """
    found = _with_kinks(builder, model) if model.exchanges else []
    watched = _survey(builder, model, lambda builder: [_add_watched(builder, w) for w, _ in found])
    first = 2 * model.n_stop
    indicators = [v for k, (w, _) in enumerate(found) for v in _indicators(w, first + 2 * k)]
    surveys = Surveys(watched=watched, kinks=tuple(kinks for _, kinks in found))

    if _size_of_bodies(builder.scene) > MOST_LOCALS:
        return replace(surveys, left_out="local variables"), [], indicators

    efforts = _survey(builder, model, _add_efforts)
    of_efforts = builder.outputs
    motion = _survey(builder, model, _add_motions)
    taken = dict.fromkeys(array_of(v.name) for v in model.listed)
    of_motion, of_efforts = (
        _with_names(_locals(given, first), taken)
        for given, first in ((builder.outputs, 0), (of_efforts, motion.n_y))
    )

    if len(of_motion) > MOST_LOCALS:
        return replace(surveys, left_out="local variables"), [], indicators

    surveys = replace(surveys, motion=motion)

    if len(of_motion) + len(of_efforts) > MOST_LOCALS:
        return replace(surveys, left_out="efforts and reactions of joints"), of_motion, indicators

    return replace(surveys, efforts=efforts), of_motion + of_efforts, indicators


def _size_of_bodies(scene):
    """How many numbers tell how bodies move."""
    return sum(
        MARKER_OUTPUTS[output].width
        for body in scene.body.values()
        for output in MOTIONS
        if output not in body.output
    )


def _with_names(found, taken):
    """Those whose name is not taken; a joint and a body may be called the same, then the joint has it.

    taken : what has the name of an array, by its words before any comma.
    """
    return [v for v in found if taken.setdefault(array_of(v.name), _words(v)) == _words(v)]


def _words(variable):
    return variable.description.partition(",")[0]


def _locals(found, first):
    """Variables of the outputs of a survey; `first`: where its numbers begin among those of all."""
    named = [output.fields for output in found if output.fields[0]]
    return [Variable(name, "local", *rest, first + index) for name, _, *rest, index in named]


def _add_watched(builder, watched):
    builder.add_outputs(watched.name, watched.source, watched.unit, "", ())


# locals


def _add_motions(builder):
    """How joints and bodies move."""
    for name, joint in builder.scene.joint.items():
        for output in _motions_of(builder, name, joint):
            if output not in joint.output:
                _add_motion(builder, name, joint, output)

    for name, body in builder.scene.body.items():
        for output in MOTIONS:
            if output not in body.output:
                quantity = MARKER_OUTPUTS[output]
                source = Source(MARKER_KINDS[output], 0, builder.marker(name))
                about = f"{quantity.text} of {name}"
                builder.add_outputs(dotted(name, output), source, quantity.unit, about, ())


def _motions_of(builder, name, joint):
    """What a joint's motion is told by."""
    if name in builder.end_frames:
        return PARAMETERS

    if joint.kind == "spherical":
        return MOTIONS[2:]

    return MOTIONS if _has_pose(joint) else coordinate_names(joint.coordinates)


def _has_pose(joint):
    return kind_of(joint).is_pose or joint.kind == "prescribed"


def _add_motion(builder, name, joint, output):
    if name in builder.end_frames:
        add_parameter_outputs(builder, name, joint, output)
    elif _has_pose(joint):
        add_pose_output(builder, name, joint, output)
    elif name in builder.joint_nodes:
        add_coordinate_outputs(builder, name, joint, output)
    else:
        _add_between_markers(builder, name, joint, output)


def _add_between_markers(builder, name, joint, output):
    """A coordinate of a joint that closes a loop, or its rate; an angle that nothing else asks for is told without its turns."""
    for k, ((position, rate, _), ending) in enumerate(scalars(joint)):
        if output not in (position.name, rate.name):
            continue

        turn, sides = kind_of(joint).frame(joint, k)
        a, b = (builder.joint_marker(name, side, turn) for side in sides)
        turns, is_rate = kind_of(joint).motions[k] == "revolute", output == rate.name
        about = f"{output.replace('_', ' ')} of {name}"

        if (name, k) in builder.coordinates and not is_rate:
            source, component = Source(outputs.COORDINATE, builder.coordinates[name, k]), 0
        elif turns:
            source, component = (
                Source(outputs.OMEGA, a, b) if is_rate else Source(outputs.ZYX, a, b),
                2 * is_rate,
            )
            about += "" if is_rate else ", from -180 to 180 deg"
        else:
            source, component = Source(outputs.VELOCITY if is_rate else outputs.POSITION, a, b), 2

        unit = (rate if is_rate else position).unit
        _add_component(builder, dotted(name, output) + ending, source, component, unit, about)


def _add_component(builder, name, source, component, unit, about):
    """One number of an output that has several: the others get no name."""
    first = len(builder.outputs)
    builder.add_outputs("", source, unit, about, ())
    listed = builder.outputs[first + component]
    builder.outputs[first:] = [
        replace(output, fields=(name if output is listed else "", *output.fields[1:]))
        for output in builder.outputs[first:]
    ]


def _add_efforts(builder):
    """What acts along joints, and what they bear."""
    for name, joint in builder.scene.joint.items():
        if "effort" not in joint.output:
            _add_effort(builder, name, joint)

        known = name in builder.joint_nodes or name in builder.joint_constraints

        # out of the plane nobody knows them
        if known and not builder.tree.in_plane and joint.kind != "free":
            for reaction in REACTIONS:
                if reaction not in joint.output:
                    add_reaction(builder, name, ALL_REACTIONS[reaction])

    builder.tables["n_reaction"] = Table()
    add_reactions(builder)


def _add_effort(builder, name, joint):
    """The driver's effort along a joint of one coordinate; of one without a driver all that acts in it."""
    if joint.kind == "prescribed":
        for output in POSE_EFFORTS:
            if output not in joint.output:
                add_pose_efforts(builder, name, output)
    elif name in builder.end_frames:
        if joint.driver:
            add_parameter_effort(builder, name, joint, "effort")
    elif (name, 0) in builder.coordinates and kind_of(joint).is_one_axis:
        _, unit = units_along(joint)
        kind = outputs.DRIVE_EFFORT if joint.driver else outputs.EFFORT
        about = f"effort of the driver of {name}" if joint.driver else f"effort of all that acts in {name}"
        source = Source(kind, builder.coordinate(name))
        builder.add_outputs(dotted(name, "effort"), source, unit, f"{about}, on its second marker", ())


# surveys


def _survey(builder, model, add) -> Survey:
    """What `add` puts among the outputs of the builder; without any there is no survey but where commands are read by it."""
    builder.outputs, builder.tables["n_output"] = [], Table()
    add(builder)
    kinds = [output.kind for output in builder.outputs]

    if not kinds and not model.n_command:
        return NONE

    counts = {name: getattr(model, name) for name in layout.COUNTS}
    own = {name: builder.tables[name].length for name in _COUNTS if name != "n_turned"}
    own["n_turned"] = counts["n_body"] if outputs.EULER_PARAMETERS in kinds else 0
    longer = {name for name in own if own[name] != counts[name]} | {"n_output"}
    counts |= own | {"n_y": len(kinds), "output_needs": outputs.needs(kinds)}
    return _arranged(builder, model, counts, longer)


def _arranged(builder, model, counts, longer):
    """A survey of these counts: arrays of what is longer than in the model stand behind all of its own."""
    head = [counts[name] for name in layout.COUNTS] + model.ints[
        len(layout.COUNTS) : layout.HEADER_LENGTH
    ].tolist()
    length = {"ints": len(model.ints), "reals": len(model.reals), "work": model.n_work}
    behind: dict[str, list[np.ndarray]] = {"ints": [], "reals": []}

    for row in layout.ARRAYS:
        if row.count not in longer:
            continue

        size = layout.array_length(row, counts)
        head[layout.SLOT[row.name]] = length[row.buffer]
        length[row.buffer] += size

        if row.buffer != "work" and size:
            values = np.concatenate(builder.tables[row.count].columns[row.name])
            behind[row.buffer].append(values)

    ints = np.concatenate([np.array(head, np.int64), *behind["ints"]]).astype(np.int64)
    return Survey(ints, np.concatenate([np.zeros(0), *behind["reals"]]), length["work"], counts["n_y"])


# kinks


def _with_kinks(builder, model):
    """What is watched whose tables have kinks, each with these."""
    if not builder.watched:
        return []

    m, _ = model.views()
    return [(w, kinks) for w in builder.watched if (kinks := _kinks(m, w))]


# a jump that is smaller than this part of the largest number of the table is none
_JUMP = 1e-9


def _kinks(m, watched):
    """Where tables over a quantity have kinks, ascending: value, slope or second slope jump by more than rounding."""
    found = set()

    for k in watched.tables:
        first, n = int(m.table_knot[k]), int(m.table_knots[k])
        knots = np.asarray(m.knot_x[first : first + n])

        if watched.edges:
            found |= {float(knots[watched.edges]), float(knots[-1 - watched.edges])}
            continue

        before, after = (
            np.array([side(m, k, first + i) for i in range(n)])
            for side in (exchange.before_knot, exchange.after_knot)
        )
        # beyond its ends a table goes on straight, from another value of x: the slopes tell
        before[[0, -1], 0] = after[[0, -1], 0]
        size = np.abs([before, after]).max(axis=(0, 1))
        jumps = (np.abs(after - before) > _JUMP * size).any(axis=1)
        found |= set(knots[jumps].tolist())

    return tuple(sorted(found))


def _indicators(watched, first):
    """The indicators of the next kinks above and below."""
    ends = (("above", "below the next kink"), ("below", "above the last kink"))
    return [
        Variable(
            f"{watched.name}.to_kink_{end}", "indicator", "continuous", None, watched.unit,
            f"how far {watched.name} is {about} of its tables", first + k,
        )
        for k, (end, about) in enumerate(ends)
    ]  # fmt: skip
