"""What the parts of a scene are collected into while they become a model."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..kernels import layout, outputs
from ..kernels.joints import KINDS, N_Q, N_V
from ..kernels.math import tables
from ..kernels.motion import coordinates
from ..rotations import Rotation
from ..scene import Problem, SceneData
from .dependencies import Dependencies
from .interpolation import curve
from .joint_kinds import kind_of, led_too
from .start import coupled_angles
from .topology import Tree
from .variables import Variable, subscripts


class Table:
    """Rows of the arrays that share a count, collected one object at a time."""

    def __init__(self):
        self.columns = {}
        self.length = 0

    def add(self, **values):
        """One more object, its values by array name; returns its index."""
        for name, value in values.items():
            self.columns.setdefault(name, []).append(np.array(value, ndmin=1).ravel())

        self.length += 1
        return self.length - 1

    def extend(self, rows: list[dict]):
        """Many more objects, one number each by array name."""
        for name in rows[0] if rows else ():
            self.columns.setdefault(name, []).append(np.array([row[name] for row in rows]))

        self.length += len(rows)


class Source(NamedTuple):
    """Where the numbers of an output come from: its kind in kernels/outputs.py, and what of (see there)."""

    kind: int
    a: int = 0
    b: int = 0


class Place(NamedTuple):
    """Where a parameter stands: from element `offset` of row `row` of an array of `reals` on."""

    array: str
    row: int = 0
    offset: int = 0

    @property
    def at(self) -> int:
        """Index in the array."""
        return self.row * layout.ARRAY[self.array].width + self.offset


class Watched(NamedTuple):
    """A quantity that tables are over, and what is asked to stop where they have kinks.

    tables : of these. edges : how many knots in from either end they go on straight; those knots are kinks too.
    """

    name: str
    unit: str | None
    source: Source
    tables: tuple[int, ...]
    edges: int = 0


class Told(NamedTuple):
    """What is compared to tell whether a given start value was kept: a kind of kernels/notes.py, and what of (see there)."""

    kind: int
    at: int
    to: int = -1
    component: int = 0


class Parameter(NamedTuple):
    """A scalar parameter in the making: its fields as a Variable, the array that it stands in and where in that."""

    name: str
    variability: str
    start: float
    unit: str | None
    description: str
    array: str
    at: int


@dataclass(frozen=True)
class Input:
    """A scalar input in the making: its fields as a Variable, the nodes that it acts on, whether it prescribes a motion."""

    fields: tuple
    nodes: set
    moves: bool


@dataclass(frozen=True)
class Output:
    """A scalar output in the making: its fields as a Variable, the nodes that it is about, its kind in kernels/outputs.py,
    positions in u of inputs that are part of it, the nodes whose motion alone it feels.
    """

    fields: tuple
    nodes: set
    kind: int
    fed_by: tuple
    moved_by: set


@dataclass(frozen=True)
class Constraint:
    """Equations of one joint, drive or coupling, before they stand in the tables.

    markers : of the joint, or of the first coordinate (0 where that is in the tree).
    nodes : that it acts on.
    rows : (kind in kernels/dynamics/rows.py, two indices of what it is about).
    value : m or a cosine, that the rows keep. terms : of a coupling its coordinates and their factors. offset : of it. drive : -1 without.
    at_start : the numbers are those at the start, once all else is closed.
    """

    name: str
    markers: tuple[int, int]
    nodes: list[int]
    rows: list[tuple]
    value: float = 0.0
    terms: tuple[tuple[int, float], ...] = ()
    offset: float = 0.0
    drive: int = -1
    at_start: bool = False


class Builder:
    """Tables, markers, coordinates and variables of a model in the making.

    q, v : first position and velocity coordinate of each node; n_q, n_v : their numbers.
    joint_nodes : joint -> its nodes, in the order of the joint's own coordinates.
    embeds : dynamics by the joint-space mass matrix.
    single : arrays that belong to no table, by name; counts : numbers that are no table's length.
    end_frames : joint that keeps one on a curve or surface -> it.
    drive_of : node -> its drive; driven_cuts : joint outside the tree -> its drive.
    joint_constraints : joint that closes a loop -> its constraint.
    constraint_names, constraint_nodes : joints or couplings, and the nodes they act on, in the order of the constraints.
    force_nodes : nodes between which force elements act.
    shared_nodes : nodes that move each other's water, so that they accelerate together.
    notices : what a user should be told of what was made of the scene.
    names : what messages call other things than nodes and constraints.
    starts : (array, index) of a start value that is a parameter -> its node.
    restricted : nodes whose positions, and whose velocities, follow from others by constraints.
    loop_hints : for each constraint, whose starts would help where it cannot be closed.
    reactions : joints whose reactions go out; torque_inputs : spherical joint -> its row among the wrench inputs.
    radiations : forces with memories of waves, in the order of these.
    watched : what tables that may have kinks are over, but time.
    fitted : force -> the memory of waves that was fitted for it; near : force -> what that is to meet beside, see `natural`.
    wave_places, wet_members : what depends on where bodies start once loops are closed, see `hydrodynamics.meet_waves`.
    coordinates : (joint, which of its coordinates) -> index among those that something refers to.
    starts_elsewhere : joints start as was found on another tree, whatever is given.
    start_angles : the same -> rad at the start, where more is known than the joints' own start values.
    listing : whether anybody will see the model: outputs, parameters and what is told are left out of one that is not seen.
    """

    def __init__(self, scene: SceneData, tree: Tree, embeds: bool, start_angles=None, listing=True):
        self.scene = scene
        self.listing = listing
        self.embeds = embeds
        self.tree = tree
        self.nodes = tree.nodes
        self.tables = {count: Table() for count in layout.COUNTS}
        self.inputs = []
        self.outputs = []
        self.parameters = []
        self.single = {}
        self.counts = {}
        self.constraint_names = []
        self.constraint_nodes = []
        self.force_nodes = []
        self.shared_nodes = []
        self.joint_constraints = {}
        self.drive_of = {}
        self.driven_cuts = {}
        self.end_frames = {}
        self.notices = []
        self.names = []
        self.starts = {}
        self.restricted = set(), set()
        self.loop_hints = []
        self.reactions = []
        self.torque_inputs = {}
        self.radiations = []
        self.watched = []
        self.fitted = {}
        self.near = {}
        self.wave_places = []
        self.wet_members = []
        self._markers = {}
        self.coordinates = {}
        self.starts_elsewhere = start_angles is not None
        self.start_angles = start_angles or coupled_angles(scene)
        self._index_nodes()
        self.marker("inertial")

    def _index_nodes(self):
        """Where each node's coordinates stand, and which nodes each joint has."""
        self.q, self.v, self.joint_nodes = [], [], {}
        self.n_q = self.n_v = 0

        for i, node in enumerate(self.nodes):
            self.q.append(self.n_q)
            self.v.append(self.n_v)

            if i:
                kind = KINDS[node.kind]
                self.joint_nodes.setdefault(node.joint, []).append(i)
                self.n_q += N_Q[kind]
                self.n_v += N_V[kind]

        for nodes in self.joint_nodes.values():
            nodes.sort(key=lambda i: self.nodes[i].coordinate)

    def notice(self, path, text):
        """Something that a user should be told: path of keys into the scene, as of a `Problem`, and what was done there."""
        self.notices.append(Problem(path, text))

    def add_name(self, text):
        """Index of a name in `names`."""
        self.names.append(text)
        return len(self.names) - 1

    def tell(self, told, name, value, unit=1.0):
        """A start value that is told where it cannot be kept: SI, of an orientation E; `unit`: of what the name says, by SI."""
        if not self.listing:
            return

        values = np.zeros(4)
        values[: np.size(value)] = value
        self.tables["n_told"].add(
            told_kind=told.kind, told_at=told.at, told_to=told.to, told_component=told.component,
            told_place=self.add_name(name), told_unit=unit, told_value=values,
        )  # fmt: skip

    # structure

    def add_marker(self, key, node, pose):
        """Index of a marker at a pose in a node, made once for each key."""
        if key not in self._markers:
            row = self.tables["n_marker"].add(marker_body=node, marker_r=pose[0], marker_A=pose[1])
            self._markers[key] = row

        return self._markers[key]

    def marker(self, name):
        """Index of a marker of the scene by name; "inertial" is 0."""
        return self.add_marker(name, *self.tree.marker(self.scene, name))

    def joint_marker(self, joint, side, turn):
        """Index of a joint's first (0) or second (1) marker with its axes turned by `turn` (3, 3)."""
        return self.add_marker(
            (joint, side, turn.tobytes()), *self.tree.joint_side(self.scene, joint, side, turn)
        )

    def coordinate(self, joint, k=0):
        """Index of a joint's scalar coordinate k, one of its simple motions (see joint_kinds.py)."""
        key = (joint, k)

        if key not in self.coordinates:
            self.coordinates[key] = self.tables["n_coordinate"].add(**self._coordinate_row(joint, k))

        return self.coordinates[key]

    def watch(self, name, unit, source, *tables, edges=0):
        """Have solvers outside stop where tables over a quantity have kinks (`Watched`); -1 is no table."""
        if min(tables) >= 0:
            self.watched.append(Watched(name, unit, source, tables, edges))

    def _coordinate_row(self, joint, k):
        """Coordinate k of a joint: that of its node in the tree, or what is seen between its markers."""
        if joint in self.joint_nodes:
            return dict(
                coordinate_kind=coordinates.IN_TREE,
                coordinate_body=self.joint_nodes[joint][k],
                coordinate_from=0,
                coordinate_to=0,
                coordinate_turn=-1,
                coordinate_end_frame=-1,
            )

        if joint in self.end_frames:
            return self._parameter_row(joint)

        spec = self.scene.joint[joint]
        kind = kind_of(spec).motions[k]
        turn, sides = kind_of(spec).frame(spec, k)

        return dict(
            coordinate_kind=coordinates.ANGLE if kind == "revolute" else coordinates.SLIDE,
            coordinate_body=0,
            coordinate_from=self.joint_marker(joint, sides[0], turn),
            coordinate_to=self.joint_marker(joint, sides[1], turn),
            coordinate_turn=self._add_turn(joint, k) if kind == "revolute" else -1,
            coordinate_end_frame=-1,
        )

    def _parameter_row(self, joint):
        """The parameter of a joint's end frame on a curve as a coordinate."""
        spec = self.scene.joint[joint]
        first, second = (
            self.joint_marker(joint, side, turn) for side, turn in enumerate(kind_of(spec).turns(spec))
        )
        return dict(
            coordinate_kind=coordinates.PARAMETER,
            coordinate_body=0,
            coordinate_from=first,
            coordinate_to=second,
            coordinate_turn=-1,
            coordinate_end_frame=self.end_frames[joint],
        )

    def _add_turn(self, joint, k):
        """Index of an angle outside the tree among these; it starts nearest to where the joint's start values say."""
        spec = self.scene.joint[joint]
        angle = self.start_angles.get((joint, k), led_too(spec, spec.start_position())[k])
        return self.tables["n_turn"].add(turn_coordinate=self.tables["n_coordinate"].length, turn_start=angle)

    def table(self, polynomial, beyond):
        """Index of a piecewise polynomial (scipy PPoly of degree at most 5); `beyond`: see kernels/math/tables.py."""
        first = self.tables["n_knot"].length
        coefficients = np.zeros((6, len(polynomial.x)))
        coefficients[: len(polynomial.c), :-1] = polynomial.c[::-1]
        h = np.diff(polynomial.x)
        areas = np.cumsum([0.0, *sum(coefficients[k, :-1] * h ** (k + 1) / (k + 1) for k in range(6))])

        for x, c, area in zip(polynomial.x, coefficients.T, areas):
            self.tables["n_knot"].add(knot_x=x, knot_c=c, knot_area=area)

        return self.tables["n_table"].add(
            table_knot=first, table_knots=len(polynomial.x), table_beyond=beyond
        )

    def tables_over_time(self, interpolation, time, values):
        """Index of the first of the tables over time of one value (n,), or of several (n, k); they keep their end values."""
        columns = np.reshape(values, (len(time), -1)).T
        return [self.table(curve(interpolation, time, column), tables.HOLD) for column in columns][0]

    def reaction(self, joint):
        """Index of a joint's reaction."""
        if joint not in self.reactions:
            self.reactions.append(joint)

        return self.reactions.index(joint)

    def node_of(self, end):
        """Node of a marker of the scene."""
        return self.tree.home[end.partition(".")[0]][0]

    def nodes_of(self, joint):
        """Nodes that a joint connects."""
        return [self.node_of(end) for end in self.scene.joint[joint].between]

    # variables

    def add_inputs(self, name, quantity, description, nodes, moves=False, start=0.0):
        """Inputs of a quantity (its unit and shape) that act on `nodes`; returns the first's position in u.

        moves : they prescribe a motion, so that positions and velocities follow them at once.
        start : one value, or one for each element.
        """
        first = len(self.inputs)
        endings = subscripts(quantity.shape)

        for k, (ending, value) in enumerate(zip(endings, np.broadcast_to(start, len(endings)))):
            fields = (
                name + ending,
                "input",
                "continuous",
                float(value),
                quantity.unit,
                description,
                first + k,
            )
            self.inputs.append(Input(fields, set(nodes) - {0}, moves))

        return first

    def add_outputs(self, name, source, unit, description, nodes, fed_by=(), moved_by=()):
        """A block of outputs that is about `nodes`; `fed_by`: positions in u of inputs that are part of it; `moved_by`: nodes whose
        motion it feels, but not what pulls at them.
        """
        if not self.listing:
            return

        first = len(self.outputs)
        width = outputs.WIDTH.get(source.kind)
        self.tables["n_output"].add(
            output_kind=source.kind, output_a=source.a, output_b=source.b, output_y=first
        )

        for k, ending in enumerate(subscripts((width,) if width else ())):
            fields = (name + ending, "output", "continuous", None, unit, description, first + k)
            self.outputs.append(
                Output(fields, set(nodes) - {0}, source.kind, tuple(fed_by), set(moved_by) - {0})
            )

    def add_parameters(self, name, place, values, unit, description, variability="tunable"):
        """Parameters that stand from a place on; units by element or one for all."""
        if not self.listing:
            return

        values = np.asarray(values, float)
        units = unit if isinstance(unit, list) else [unit] * values.size

        for k, (ending, value) in enumerate(zip(subscripts(values.shape), values.ravel())):
            parameter = Parameter(
                name + ending, variability, float(value), units[k], description, place.array, place.at + k
            )
            self.parameters.append(parameter)

    def add_start(self, name, place, values, unit, description, node):
        """Start values of a node's joint as parameters; `starts` remembers what they are of."""
        self.add_parameters(name, place, values, unit, description, "fixed")

        for k in range(np.size(values)):
            self.starts[place.array, place.at + k] = node

    def add_zyx(self, variable, name, node, E):
        """Yaw, pitch, roll as another way to start an orientation."""
        values = Rotation.from_quat(E).as_zyx()
        about = f"yaw, pitch, roll of {name} at the start; they count instead of the Euler parameters once they are changed"
        columns = self.tables["n_body"].columns
        columns["zyx_start"][node] = columns["zyx_told"][node] = values
        self.add_start(variable, Place("zyx_start", node), values, "rad", about, node)

    def _guess(self, array, k):
        """Whether a start value is but a guess: what it starts follows from others, and the user did not give it."""
        node = self.starts.get((array, k))

        if node is None or node not in self.restricted[array == "v_start"]:
            return False

        given = self.single["v_given"]
        weight = 2 if array == "v_start" else 1

        if array == "v_start":
            return not int(given[k]) & weight

        first = self.v[node]
        component = k - self.q[node] if array == "q_start" else 3
        component = component if self.nodes[node].kind == "free" else 0
        return not int(given[first + min(component, 3)]) & weight

    @property
    def n_listed(self):
        """Number of inputs, outputs and parameters."""
        return len(self.inputs) + len(self.outputs) + len(self.parameters)

    def list_variables(self, offset, led_by=None):
        """Inputs, outputs, parameters with their dependencies; `offset`: array name -> its place in its buffer; led_by: of each
        output, what states it may depend on.
        """
        inputs = [Variable(*given.fields) for given in self.inputs]
        guess = ", a guess: joints in loops and couplings lead it elsewhere"
        parameters = [
            Variable(
                name=parameter.name,
                causality="parameter",
                variability=parameter.variability,
                start=parameter.start,
                unit=parameter.unit,
                description=parameter.description + guess * self._guess(parameter.array, parameter.at),
                index=offset[parameter.array] + parameter.at,
            )
            for parameter in self.parameters
        ]
        dependencies = Dependencies(self)
        results = [
            Variable(*output.fields, depends=dependencies.of(output), led_by=led)
            for output, led in zip(self.outputs, led_by or [()] * len(self.outputs))
        ]
        return [*inputs, *results, *parameters]

    def marker_node(self, k):
        """Node of marker k."""
        return int(self.tables["n_marker"].columns["marker_body"][k][0])
