"""Scene -> Model: the flat arrays that kernels work on, and the variables that people see.

The names and shapes of the arrays are those of the table in `kernels/layout.py`.
"""

import hashlib
import re
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from .kernels import integrate, joints, layout, outputs
from .scene import Scene
from .topology import compose, spanning_tree
from .variables import Variable, dotted, subscripts

JOINT_OUTPUTS = {
    # name: (kind of a one-dof joint's output, of a pair of markers; what it is called in a description)
    "angle": (outputs.COORDINATE, None, "angle"),
    "position": (outputs.COORDINATE, outputs.POSITION, "position"),
    "speed": (outputs.RATE, None, "speed"),
    "acceleration": (outputs.ACCELERATION, None, "acceleration"),
    "euler_parameters": (None, outputs.EULER_PARAMETERS, "Euler parameters, scalar last,"),
    "zyx": (None, outputs.ZYX, "yaw, pitch, roll"),
    "omega": (None, outputs.OMEGA, "angular velocity"),
    "alpha": (None, outputs.ALPHA, "angular acceleration"),
    "velocity": (None, outputs.VELOCITY, "velocity"),
}
MARKER_OUTPUTS = {
    "position": (outputs.POSITION, "position in the inertial frame"),
    "velocity": (outputs.VELOCITY, "velocity in the inertial frame"),
    "euler_parameters": (outputs.EULER_PARAMETERS, "Euler parameters in the inertial frame, scalar last"),
    "zyx": (outputs.ZYX, "yaw, pitch, roll in the inertial frame"),
    "omega": (outputs.OMEGA, "angular velocity in the inertial frame"),
    "velocity_body": (outputs.VELOCITY_BODY, "velocity in its own axes"),
    "omega_body": (outputs.OMEGA_BODY, "angular velocity in its own axes"),
}
ENERGIES = {
    "kinetic_energy": (outputs.KINETIC_ENERGY, "kinetic energy"),
    "potential_energy": (outputs.POTENTIAL_ENERGY, "potential energy of weight, springs and preloads"),
    "total_energy": (outputs.TOTAL_ENERGY, "kinetic and potential energy"),
}
OUTPUT_UNITS = {
    "angle": "rad",
    "position": "m",
    "euler_parameters": None,
    "zyx": "rad",
    "omega": "rad/s",
    "omega_body": "rad/s",
    "alpha": "rad/s2",
    "velocity": "m/s",
    "velocity_body": "m/s",
}


@dataclass(frozen=True)
class Model:
    """A scene made ready for the kernels.

    identifier : C identifier made from the name.
    ints, reals : structure (int64) and default parameters (float64), flat.
    n_state, n_work, n_u, n_y : lengths of an instance's buffers and of its inputs and outputs.
    variables : inputs, outputs, parameters, in that order.
    places : names that a kernel's status can point to: the nodes of the tree.
    guid : hash of all that a simulation depends on.
    """

    scene: Scene
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
    places: list[str]
    guid: str

    def __getattr__(self, name):
        """Counts and arrays of the layout table by name, e.g. `model.n_v`."""
        if name in layout.COUNTS:
            return int(self.ints[layout.COUNTS.index(name)])

        raise AttributeError(name)

    def of_causality(self, causality: str) -> list[Variable]:
        """Inputs, outputs or parameters."""
        return [v for v in self.variables if v.causality == causality]


def compile_scene(scene: Scene) -> Model:
    """The model of a scene. Raises SceneError where the joints do not form what the kernels can do."""
    return _Compiler(scene).model()


@dataclass
class _Table:
    """Rows of the arrays that share a count, collected one object at a time."""

    columns: dict[str, list] = field(default_factory=dict)
    length: int = 0

    def add(self, **values):
        """One more object; returns its index."""
        for name, value in values.items():
            self.columns.setdefault(name, []).append(np.ravel(value))

        self.length += 1
        return self.length - 1


class _Compiler:
    def __init__(self, scene):
        self.scene = scene
        self.tree = spanning_tree(scene)
        self.nodes = self.tree.nodes
        self.tables = {count: _Table() for count in layout.COUNTS}
        self.inputs = []
        self.outputs = []
        self.parameters = []
        self.markers = {}
        self.index_coordinates()

        self.marker("ground")
        self.add_settings()
        self.add_bodies()
        self.add_joints()
        self.add_forces()
        self.add_markers()
        self.add_energies()

    # structure

    def index_coordinates(self):
        """Position and velocity coordinates in the order of the nodes."""
        q = v = 0
        self.q, self.v, self.node_of_joint = [], [], {}

        for i, node in enumerate(self.nodes):
            self.q.append(q)
            self.v.append(v)

            if i:
                kind = joints.KINDS[node.kind]
                self.node_of_joint[node.joint] = i
                q += joints.N_Q[kind]
                v += joints.N_V[kind]

        self.n_q, self.n_v = q, v

    def marker(self, name):
        """Index of a marker, "ground" being 0."""
        if name not in self.markers:
            node, (r, A) = self.tree.marker(self.scene, name)
            self.markers[name] = self.tables["n_marker"].add(marker_body=node, marker_r=r, marker_A=A)

        return self.markers[name]

    def root(self, i):
        """The node of i's chain that hangs on the ground: motions below different roots do not meet in M."""
        while self.nodes[i].parent > 0:
            i = self.nodes[i].parent

        return i

    # variables

    def add_inputs(self, name, shape, unit, description, nodes):
        """Inputs that act on `nodes`; returns the first's position in u."""
        first = len(self.inputs)

        for k, ending in enumerate(subscripts(shape)):
            variable = (name + ending, "input", "continuous", 0.0, unit, description, first + k)
            self.inputs.append((variable, {self.root(i) for i in nodes if i}))

        return first

    def add_outputs(self, name, kind, unit, description, nodes, a=0, b=0):
        """A block of outputs that is about `nodes`."""
        first = len(self.outputs)
        width = outputs.WIDTH.get(kind)
        self.tables["n_output"].add(output_kind=kind, output_a=a, output_b=b, output_y=first)
        roots = {self.root(i) for i in nodes if i}

        for k, ending in enumerate(subscripts((width,) if width else ())):
            variable = (name + ending, "output", "continuous", None, unit, description, first + k)
            self.outputs.append((variable, roots, kind))

    def add_parameters(self, name, array, row, values, unit, description, variability="tunable"):
        """Parameters that stand from row `row` of an array of `reals` on; units by element or one for all."""
        values = np.asarray(values, float)
        units = unit if isinstance(unit, list) else [unit] * values.size

        for k, (ending, value) in enumerate(zip(subscripts(values.shape), values.ravel())):
            place = (array, row * layout.ROW[array].width + k)
            self.parameters.append((name + ending, variability, float(value), units[k], description, place))

    # content

    def add_settings(self):
        """Gravity and the solver's settings."""
        solver = self.scene.solver
        tolerance = solver.tolerance
        self.single = {
            "gravity": self.scene.gravity,
            "step": solver.step if solver.integrator == "rk4" else 1.0,
            "tolerance": tolerance,
            "absolute_tolerance": solver.absolute_tolerance or tolerance,
            "max_step": solver.max_step or 1e30,
        }
        self.add_parameters("gravity", "gravity", 0, self.scene.gravity, "m/s2", "gravity in the inertial frame")

        if solver.integrator == "rk4":
            self.add_parameters("solver.step", "step", 0, solver.step, "s", "largest inner step")
            return

        about = "adaptive step: largest local error"
        self.add_parameters("solver.tolerance", "tolerance", 0, tolerance, None, f"{about}, relative")
        value = self.single["absolute_tolerance"]
        self.add_parameters("solver.absolute_tolerance", "absolute_tolerance", 0, value, None, f"{about}, absolute")

    def add_bodies(self):
        """Nodes and the solids in them."""
        for i, node in enumerate(self.nodes):
            r, A = node.joint_frame
            self.tables["n_body"].add(
                body_parent=node.parent,
                body_joint=joints.KINDS[node.kind] if i else -1,
                body_q=self.q[i],
                body_v=self.v[i],
                body_reversed=node.reversed,
                body_r=r,
                body_A=A,
            )

        for name, body in self.scene.body.items():
            mass, com, inertia = body.mass_properties()
            inertia = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            node, (r, A) = self.tree.home[name]
            row = self.tables["n_solid"].add(
                solid_body=node, solid_mass=mass, solid_com=com, solid_inertia=inertia, solid_r=r, solid_A=A
            )
            self.add_parameters(dotted(name, "mass"), "solid_mass", row, mass, "kg", f"mass of {name}")
            about = f"centre of mass of {name}, in its own frame"
            self.add_parameters(dotted(name, "com"), "solid_com", row, com, "m", about)
            about = f"inertia of {name} about its centre of mass, in its own axes: xx, yy, zz, xy, xz, yz"
            self.add_parameters(dotted(name, "inertia"), "solid_inertia", row, inertia, "kg.m2", about)

    def add_joints(self):
        """Springs, inputs, outputs and start values of the joints."""
        self.q_start = np.zeros(self.n_q)
        self.v_start = np.zeros(self.n_v)

        for name, joint in self.scene.joint.items():
            if joint.kind == "fixed":
                continue

            i = self.node_of_joint[name]
            self.add_start(name, joint, i)
            rotary = joint.kind == "revolute"

            if joint.spring or joint.damper:
                self.add_joint_spring(name, joint, i, rotary)

            if joint.input and joint.kind == "spherical":
                first, second = map(self.marker, joint.between)
                about = f"torque of {name} on its second marker, in its first marker's axes"
                u = self.add_inputs(dotted(name, "torque"), (3,), "N.m", about, [i])
                self.tables["n_wrench_input"].add(
                    wrench_marker=second,
                    wrench_reaction=first,
                    wrench_axes=first,
                    wrench_force=-1,
                    wrench_moment=u,
                )
            elif joint.input:
                about = f"{joint.input} of {name} on its second marker"
                unit = "N.m" if rotary else "N"
                u = self.add_inputs(dotted(name, joint.input), (), unit, about, [i])
                self.tables["n_effort_input"].add(effort_v=self.v[i], effort_u=u)

            for output in joint.output:
                scalar_kind, pair_kind, about = JOINT_OUTPUTS[output]
                unit = OUTPUT_UNITS.get(output) or ({"speed": "/s", "acceleration": "/s2"}.get(output))

                if output in ("speed", "acceleration"):
                    unit = ("rad" if rotary else "m") + unit

                if joint.kind in ("revolute", "prismatic"):
                    self.add_outputs(dotted(name, output), scalar_kind, unit, f"{about} of {name}", [i], i)
                else:
                    a, b = map(self.marker, joint.between)
                    about = f"{about} of {name}: second marker in the first"
                    self.add_outputs(dotted(name, output), pair_kind, unit, about, [i], a, b)

    def add_start(self, name, joint, i):
        """Start values as parameters."""
        q = joint.start_position()
        v = joint.start_velocity()
        self.q_start[self.q[i] : self.q[i] + len(q)] = q
        self.v_start[self.v[i] : self.v[i] + len(v)] = v
        quantities = {
            "revolute": (("angle", "rad", 1), ("speed", "rad/s", 1)),
            "prismatic": (("position", "m", 1), ("speed", "m/s", 1)),
            "spherical": (("euler_parameters", None, 4), ("omega", "rad/s", 3)),
            "free": (
                ("position", "m", 3),
                ("euler_parameters", None, 4),
                ("velocity", "m/s", 3),
                ("omega", "rad/s", 3),
            ),
        }[joint.kind]
        at = self.q[i]
        values = np.concatenate([q, v])

        for k, (quantity, unit, size) in enumerate(quantities):
            array = "q_start" if k < len(quantities) // 2 else "v_start"

            if k == len(quantities) // 2:
                at = self.v[i]

            value = values[0] if size == 1 else values[:size]
            values = values[size:]
            about = f"{JOINT_OUTPUTS[quantity][2].rstrip(',')} of {name} at the start"
            self.add_parameters(dotted(name, f"{quantity}_start"), array, at, value, unit, about, "fixed")
            at += size

    def add_joint_spring(self, name, joint, i, rotary):
        """Spring and damper in a joint of one degree of freedom."""
        stiffness = joint.spring.stiffness if joint.spring else 0.0
        rest = joint.spring.rest_value() if joint.spring else 0.0
        row = self.tables["n_joint_spring"].add(
            joint_spring_body=i, joint_stiffness=stiffness, joint_rest=rest, joint_damping=joint.damper
        )

        if joint.spring:
            unit = "N.m/rad" if rotary else "N/m"
            self.add_parameters(dotted(name, "stiffness"), "joint_stiffness", row, stiffness, unit, f"of {name}")
            unit = "rad" if rotary else "m"
            about = f"position of {name} at which its spring is slack"
            self.add_parameters(dotted(name, "rest"), "joint_rest", row, rest, unit, about)

        if joint.damper:
            unit = "N.m.s/rad" if rotary else "N.s/m"
            self.add_parameters(dotted(name, "damper"), "joint_damping", row, joint.damper, unit, f"damping of {name}")

    def add_forces(self):
        """Force elements between two markers."""
        for name, force in self.scene.force.items():
            ends = [self.marker(end) for end in force.between]
            nodes = [self.tree.marker(self.scene, end)[0] for end in force.between]

            if force.kind == "linear":
                self.add_linear(name, force.linear, ends)
                continue

            spec = force.spring_damper
            rest = spec.rest_length
            rest = self.start_length(force.between) if rest is None else rest
            row = self.tables["n_strut"].add(
                strut_from=ends[0],
                strut_to=ends[1],
                strut_stiffness=spec.stiffness,
                strut_damping=spec.damping,
                strut_rest=rest,
            )
            about = f"stiffness of {name}"
            self.add_parameters(dotted(name, "stiffness"), "strut_stiffness", row, spec.stiffness, "N/m", about)
            about = f"damping of {name}"
            self.add_parameters(dotted(name, "damping"), "strut_damping", row, spec.damping, "N.s/m", about)
            about = f"length of {name} without force"
            self.add_parameters(dotted(name, "rest_length"), "strut_rest", row, rest, "m", about)

            for output in force.output:
                kind = outputs.STRUT_LENGTH if output == "length" else outputs.STRUT_FORCE
                unit, about = ("m", "length") if output == "length" else ("N", "tension")
                self.add_outputs(dotted(name, output), kind, unit, f"{about} of {name}", nodes, row)

    def add_linear(self, name, spec, ends):
        """A 6x6 force."""
        stiffness = spec.stiffness_matrix()
        damping = spec.damping_matrix()
        added = spec.added_mass_matrix()
        preload = spec.preload_vector()
        row = self.tables["n_linear"].add(
            linear_from=ends[0],
            linear_to=ends[1],
            linear_adds=bool(np.any(added)),
            linear_stiffness=stiffness,
            linear_damping=damping,
            linear_added=added,
            linear_preload=preload,
        )
        blocks = {
            "stiffness": (stiffness, ("N/m", "N/rad", "N", "N.m/rad")),
            "damping": (damping, ("N.s/m", "N.s/rad", "N.s", "N.m.s/rad")),
            "added_mass": (added, ("kg", "kg.m", "kg.m", "kg.m2")),
        }

        for quantity, (matrix, units) in blocks.items():
            if np.any(matrix):
                array = "linear_added" if quantity == "added_mass" else f"linear_{quantity}"
                units = [units[2 * (j > 2) + (k > 2)] for j in range(6) for k in range(6)]
                about = f"{quantity.replace('_', ' ')} of {name} (x, y, z, rx, ry, rz)"
                self.add_parameters(dotted(name, quantity), array, row, matrix, units, about)

        if np.any(preload):
            about = f"constant force and moment of {name}"
            units = ["N"] * 3 + ["N.m"] * 3
            self.add_parameters(dotted(name, "preload"), "linear_preload", row, preload, units, about)

    def start_length(self, between):
        """Distance (m) of two markers at the start."""
        poses = [compose((np.zeros(3), np.eye(3)), node.joint_frame) for node in self.nodes[:1]]

        for i, node in enumerate(self.nodes[1:], 1):
            joint = self.scene.joint[node.joint]
            motion = _joint_pose(joint.kind, joint.start_position())

            if node.reversed and joint.kind in ("spherical", "free"):
                motion = (-motion[1].T @ motion[0], motion[1].T)

            poses.append(compose(compose(poses[node.parent], node.joint_frame), motion))

        ends = [self.tree.marker(self.scene, end) for end in between]
        first, second = (compose(poses[node], pose)[0] for node, pose in ends)
        return float(np.linalg.norm(second - first))

    def add_markers(self):
        """Inputs and outputs of bodies and their markers."""
        for body_name, body in self.scene.body.items():
            self.add_marker(body_name, (body_name,), body)

            for marker_name, marker in body.marker.items():
                self.add_marker(f"{body_name}.{marker_name}", (body_name, marker_name), marker)

    def add_marker(self, name, path, spec):
        """Inputs and outputs of one marker; a body's own frame is one too."""
        if not (spec.input or spec.output):
            return

        index = self.marker(name)
        node = self.tree.marker(self.scene, name)[0]
        first = {"force": -1, "moment": -1}

        for quantity in spec.input:
            unit = "N" if quantity == "force" else "N.m"
            axes = "its own" if spec.input_axes == "body" else "inertial"
            about = f"{quantity} on {name}, in {axes} axes"
            first[quantity] = self.add_inputs(dotted(*path, quantity), (3,), unit, about, [node])

        if spec.input:
            self.tables["n_wrench_input"].add(
                wrench_marker=index,
                wrench_reaction=-1,
                wrench_axes=index if spec.input_axes == "body" else -1,
                wrench_force=first["force"],
                wrench_moment=first["moment"],
            )

        for output in spec.output:
            kind, about = MARKER_OUTPUTS[output]
            self.add_outputs(
                dotted(*path, output), kind, OUTPUT_UNITS[output], f"{about} of {name}", [node], 0, index
            )

    def add_energies(self):
        """Energies of the whole scene."""
        for output in self.scene.output:
            kind, about = ENERGIES[output]
            self.add_outputs(output, kind, "J", about, range(len(self.nodes)))

    # result

    def model(self):
        """All collected rows as flat arrays."""
        counts = {name: table.length for name, table in self.tables.items()}
        counts |= {
            "n_q": self.n_q,
            "n_v": self.n_v,
            "n_x": self.n_q + self.n_v,
            "n_u": len(self.inputs),
            "n_y": len(self.outputs),
            "output_needs": int(any(kind in outputs.ACCELERATES for _, _, kind in self.outputs)),
            "integrator": integrate.INTEGRATORS[self.scene.solver.integrator],
        }
        header, length = layout.arrange(counts)
        buffers = {"ints": np.zeros(length["ints"], np.int64), "reals": np.zeros(length["reals"])}
        buffers["ints"][: len(header)] = header
        values = dict(self.single, q_start=self.q_start, v_start=self.v_start)
        values["body_added"] = np.zeros(len(self.nodes))

        for table in self.tables.values():
            values |= {name: np.concatenate(column) for name, column in table.columns.items()}

        for adds, to in zip(values.get("linear_adds", []), values.get("linear_to", [])):
            if adds:
                values["body_added"][int(values["marker_body"][int(to)])] = 1

        offset = {}

        for row in layout.ARRAYS:
            offset[row.name] = header[layout.SLOT[row.name]]
            size = layout.row_length(row, counts)

            if row.buffer in buffers and size:
                buffers[row.buffer][offset[row.name] : offset[row.name] + size] = np.ravel(values[row.name])

        places = [node.name for node in self.nodes]
        variables = self.variables(offset)
        scene = self.scene
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
            variables=variables,
            places=places,
            guid=_guid(buffers, variables, places),
        )

    def variables(self, offset):
        """Inputs, outputs, parameters with their dependencies."""
        inputs = [Variable(*fields) for fields, _ in self.inputs]
        first = len(inputs) + len(self.outputs)
        parameters = [
            Variable(name, "parameter", variability, start, unit, about, offset[array] + k)
            for name, variability, start, unit, about, (array, k) in self.parameters
        ]
        known = (*range(len(inputs)), *range(first, first + len(parameters)))
        results = []

        for fields, roots, kind in self.outputs:
            depends = ()

            # only accelerations feel inputs at once, and only those that act on the same branch of the ground
            if kind in outputs.ACCELERATES:
                depends = tuple(k for k, (_, acts) in enumerate(self.inputs) if acts & roots)

            initial = tuple(k for k in known if k >= first or k in depends)
            results.append(Variable(*fields, depends=depends, initial_depends=initial))

        return [*inputs, *results, *parameters]


def _joint_pose(kind, q):
    """Pose that a joint's coordinates stand for, z along its axis."""
    if kind == "revolute":
        return np.zeros(3), Rotation.from_rotvec([0, 0, q[0]]).as_matrix()

    if kind == "prismatic":
        return np.array([0, 0, q[0]]), np.eye(3)

    r = q[:-4] if kind == "free" else np.zeros(3)
    return r, Rotation.from_quat(q[-4:]).as_matrix()


def c_identifier(name: str) -> str:
    """A C identifier that reads like `name`."""
    text = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    return text if re.match(r"[A-Za-z]", text) else f"m_{text}"


def _guid(buffers, variables, places):
    """Hash of all that a simulation depends on, in the form of a GUID."""
    digest = hashlib.sha256()

    for array in buffers.values():
        digest.update(array.tobytes())

    digest.update(repr((variables, places)).encode())
    h = digest.hexdigest()
    return f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"
