"""The states of a run at its communication points: little to keep, and enough to find every body again."""

import numpy as np

from ..compiler.model import Model
from ..kernels import entry, layout

# bytes that the states of a run may take before digits, and then velocities, are given up
MOST = 200e6

# what commands of motion keep from step to step
COMMANDS = tuple(
    array.name
    for array in layout.ARRAYS
    if array.buffer == "state" and array.name.startswith(("command_", "attitude_", "drive_doubt"))
)


class States:
    """States at n communication points of a run.

    Kept are x = q, v, z and the time, and what commands of motion need: a hundredth of the poses of all
    bodies, which are found
    from them when asked for. Of runs so long that this takes more than `MOST` bytes, in single precision (7
    digits), then without velocities.

    has_velocities : whether v is kept.
    """

    def __init__(self, model: Model, n: int):
        self.model = model
        self.time = np.zeros(n)
        self.inputs = np.zeros((n, model.n_u))
        size = 8 * n * model.n_x
        kind = np.float64 if size <= MOST else np.float32
        self.has_velocities = size <= 2 * MOST
        # x without v : q | z
        self._columns = np.arange(model.n_x)

        if not self.has_velocities:
            self._columns = np.delete(self._columns, np.s_[model.n_q : model.n_q + model.n_v])

        self._x = np.empty((n, len(self._columns)), kind)
        self._commands = COMMANDS if model.n_command else ()
        self._more: list = [None] * n
        self._start: tuple = ()
        self._views: tuple = ()
        self._found: tuple | None = None

    def __len__(self):
        return len(self.time)

    def keep(self, k, instance):
        """Keeps the state of the instance as that of communication point k."""
        d = instance.d

        if not self._start:
            self._start = instance.reals.copy(), d.state_buffer.copy(), d.work_buffer.copy()

        self.time[k] = instance.time
        self.inputs[k] = instance.u[: self.model.n_u]
        self._x[k] = d.x[self._columns]

        if self._commands:
            self._more[k] = instance.u.copy(), [getattr(d, name).copy() for name in self._commands]

    @property
    def parameters(self):
        """The model's real parameters of the run."""
        return self._start[0]

    def given(self, prefix) -> dict[str, float]:
        """Parameters of the run by name, of those whose names begin so."""
        named = (v for v in self.model.of_causality("parameter") if v.name.startswith(prefix))
        return {v.name: float(self.parameters[v.index]) for v in named}

    @property
    def y(self):
        """Outputs, after `at`."""
        return self._views[2]

    def take(self, other, instance):
        """The states of another run of a model with the same states; instance: one of this model at its
        start.
        """
        self.keep(0, instance)
        self._found = None
        self.time, self.inputs, self._x, self._more = other.time, other.inputs, other._x, other._more

    def at(self, k):
        """(m, d) of the model, kinematics and outputs done, at communication point k; the next call
        overwrites it.
        """
        if not self._views:
            reals, state, work = self._start
            m, d = self.model.views(reals.copy())
            d.state_buffer[:] = state
            d.work_buffer[:] = work
            self._views = m, d, np.zeros(self.model.n_y)

        m, d, y = self._views
        d.time[0], d.time[1] = self.time[k], 0.0
        d.x[:] = 0.0
        d.x[self._columns] = self._x[k]
        d.u_buffer[: self.model.n_u] = self.inputs[k]

        if self._commands:
            d.u_buffer[:], values = self._more[k]

            for name, value in zip(self._commands, values):
                getattr(d, name)[:] = value

        # a run that went here once had finite outputs; poses are found in any case
        entry.compute_outputs(m, d, y)
        return m, d

    def poses(self, ends, rows=None):
        """Positions (n, len(ends), 3) in m and axes A (n, len(ends), 3, 3) of bodies or markers, inertial.

        ends : "body", "body.marker", "ground", "ground.marker", "inertial". rows : communication points, by
        default all. Raises KeyError for one that is not there.
        """
        places = [self.model.tree.marker(self.model.scene, end) for end in ends]
        nodes = np.array([node for node, _ in places], int)
        r_in = np.array([pose[0] for _, pose in places]).reshape(-1, 3)
        A_in = np.array([pose[1] for _, pose in places]).reshape(-1, 3, 3)
        r, A = self._nodes(range(len(self)) if rows is None else rows)
        turned = A[:, nodes]
        return r[:, nodes] + np.einsum("knij,nj->kni", turned, r_in), turned @ A_in

    def _nodes(self, rows):
        """Positions (n, n_body, 3) and axes (n, n_body, 3, 3) of all nodes; the last ones asked for are
        kept.
        """
        rows = tuple(int(k) for k in rows)

        if self._found is None or self._found[0] != rows:
            r, A = [], []

            for k in rows:
                _, d = self.at(k)
                r.append(d.r.copy())
                A.append(d.A.copy())

            n = len(rows)
            self._found = rows, np.array(r).reshape(n, -1, 3), np.array(A).reshape(n, -1, 3, 3)

        return self._found[1:]
