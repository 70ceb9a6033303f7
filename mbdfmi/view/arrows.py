"""Arrows of forces and moments over a run: what joints pass on, springs, loads, inputs at markers.

They are outputs of the same scene with more outputs, asked at the states of the run: the numbers of a run
itself.
"""

import numpy as np

from ..compiler.model import compile_scene
from ..run.instance import Instance, SimulationError
from ..run.states import States
from ..scene import SceneError, fmi_name
from .motion import picked
from .numbers import exact, packed

# rows of all arrows together, and of one
MOST, ROWS = 12_000, 200

# of the largest
NOTHING = 1e-9

REACTIONS = {"reaction_force": "force", "reaction_moment": "moment"}


def arrows(picture):
    """The page's data of all arrows of a picture, or None: times, and where each arrow stands and its vector.

    A picture whose states have no velocities has none.
    """
    states = picture.states

    if not states.has_velocities or len(states) < 2:
        return None

    scene, asked = _asking(states.model.scene)

    try:
        probe = _Probe(states, scene)
    except (SceneError, SimulationError):
        return None

    sources = [*_reactions(scene, asked), *_springs(scene), *_inputs(scene), *_loads(scene)]
    rows = picked(len(states), max(20, min(ROWS, MOST // max(1, len(sources)))))

    if not sources or not probe.fits:
        return None

    values = probe.outputs(rows)
    shown = picture.thinned_to(rows)
    items, largest = [], {"force": 0.0, "moment": 0.0}

    for _, _, what, _, vector in sources:
        largest[what] = max(largest[what], float(np.abs(vector(values)).max()))

    for name, source, what, end, vector in sources:
        value = shown.turned(vector(values))

        # what is only rounding points anywhere
        if np.abs(value).max() > NOTHING * largest[what]:
            items.append(
                {
                    "name": name,
                    "source": source,
                    "what": what,
                    "at": packed(shown.ends(end).ravel()),
                    "values": packed(value.ravel()),
                }
            )

    return {"times": exact(states.time[rows]), "items": items} if items else None


def _asking(scene):
    """(the scene with reactions and forces of springs among its outputs, names of joints whose reactions
    are asked for).
    """
    asking, asked = scene.model_copy(deep=True), []

    for name, joint in asking.joint.items():
        # a fixed joint whose reactions are asked for is a joint; else it is none
        if joint.kind == "fixed" and not set(REACTIONS) & set(joint.output):
            continue

        try:
            joint.output = list(dict.fromkeys([*joint.output, *REACTIONS]))
            asked.append(name)
        except SceneError:
            # a free joint has none
            pass

    for force in asking.force.values():
        if force.kind == "spring_damper":
            force.output = list(dict.fromkeys([*force.output, "force"]))

    return asking, asked


class _Probe:
    """The model that has these outputs, put into the states of a run.

    fits : whether its states are those of the run's model.
    """

    def __init__(self, states, scene):
        own, time = states.model, states.time[0]
        tree = own.tree
        joints = {node.joint for node in tree.nodes if node.joint}
        self.states = states
        self.model = compile_scene(scene, tuple(joints), for_fmu=False)
        self.fits = [node.name for node in self.model.tree.nodes] == [node.name for node in tree.nodes]
        self.fits = self.fits and (self.model.n_q, self.model.n_v, self.model.n_x) == (
            own.n_q,
            own.n_v,
            own.n_x,
        )

        if self.fits:
            reals = {v.name: states.parameters[v.index] for v in own.of_causality("parameter")}
            instance = Instance(self.model, reals, time, dict(enumerate(states.inputs[0])))
            self.copy = States(self.model, len(states))
            self.copy.take(states, instance)

    def outputs(self, rows):
        """Columns of the outputs and inputs at some rows, by name, and "rows", "states", "model"."""
        names = [v.name for v in self.model.of_causality("output")]
        values = np.empty((len(rows), len(names)))

        for i, k in enumerate(rows):
            self.copy.at(k)
            values[i] = self.copy.y

        inputs = {v.name: self.states.inputs[rows, v.index] for v in self.model.of_causality("input")}
        run = {"rows": rows, "states": self.states, "m": self.copy.at(0)[0]}
        return dict(zip(names, values.T)) | inputs | run


def _vector(values, name):
    return np.column_stack([values[f"{name}[{k}]"] for k in (1, 2, 3)])


def _turned_by(end, vector):
    """A function of the values: a vector in the axes of an end, in inertial axes."""

    def turned(values):
        _, A = values["states"].poses([end], values["rows"])
        return np.einsum("nij,nj->ni", A[:, 0], vector(values))

    return turned


def _reactions(scene, asked):
    for name in asked:
        first, second = scene.joint[name].between

        for output, what in REACTIONS.items():
            column = f"{fmi_name(name)}.{output}"
            vector = _turned_by(first, lambda values, column=column: _vector(values, column))
            yield name, "reaction", what, second, vector


def _springs(scene):
    for name, force in scene.force.items():
        if force.kind == "spring_damper":
            for end, other in (force.between, force.between[::-1]):
                yield name, "spring", "force", end, _pull(fmi_name(name), end, other)


def _pull(name, end, other):
    """A function of the values: what a spring pulls an end with."""

    def pull(values):
        r, _ = values["states"].poses([end, other], values["rows"])
        along = r[:, 1] - r[:, 0]
        length = np.maximum(np.linalg.norm(along, axis=1), 1e-30)
        return values[f"{name}.force"][:, None] * along / length[:, None]

    return pull


def _inputs(scene):
    for owner, body in scene.body.items():
        for end, frame in [(owner, body), *((f"{owner}.{name}", m) for name, m in body.marker.items())]:
            for what in frame.input:
                column = ".".join([*map(fmi_name, end.split(".")), what])
                vector = lambda values, column=column: _vector(values, column)  # noqa: E731
                yield (
                    end,
                    "input",
                    what,
                    end,
                    _turned_by(end, vector) if frame.input_axes == "body" else vector,
                )


def _loads(scene):
    found = [(name, force) for name, force in scene.force.items() if force.kind == "load"]

    for k, (name, force) in enumerate(found):
        for what in ("force", "moment"):
            vector = _load(k, what)
            yield (
                name,
                "load",
                what,
                force.on,
                _turned_by(force.on, vector) if force.load.axes == "body" else vector,
            )


def _load(k, what):
    """A function of the values: load k, in its own axes."""

    def load(values):
        m, time = values["m"], values["states"].time[values["rows"]]
        table = int(getattr(m, f"load_{what}_table")[k])
        constant = getattr(m, f"load_{what}")[3 * k : 3 * k + 3]
        held = np.broadcast_to(constant, (len(time), 3))
        return held if table < 0 else np.column_stack([_over_time(m, table + i, time) for i in range(3)])

    return load


def _over_time(m, table, time):
    """Values of a table at times; before its first and after its last they are held
    (kernels/math/tables.py).
    """
    first, count = int(m.table_knot[table]), int(m.table_knots[table])
    knots = m.knot_x[first : first + count]
    time = np.clip(time, knots[0], knots[-1])
    piece = first + np.clip(np.searchsorted(knots, time, "right") - 1, 0, count - 2)
    coefficients = m.knot_c.reshape(-1, 6)[piece]
    return (coefficients * (time - m.knot_x[piece])[:, None] ** np.arange(6)).sum(axis=1)
