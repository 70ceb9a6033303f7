"""Exudyn's motion of a problem: its explicit and implicit solvers, in the formulation that suits each."""

import time

import numpy as np
from scipy.spatial.transform import Rotation

from mbdfmi.compiler.frames import axes_with_z

from .contests import Cannot, Setting
from .peers import library_of
from .problem_files import pose_of
from .problems import MOTION_SIZE, TOLERANCES, Problem
from .spanning import inertia_matrix, motion_of, spanning_tree, start_of

IMPLICIT = ("TrapezoidalIndex2", "GeneralizedAlpha")

# which displacements and rotations a generic joint holds. Joints that close loops leave out what follows from
# the others; of Bricard's six joints one condition does, which may be this one
HELD = {
    "revolute": [1, 1, 1, 1, 1, 0],
    "prismatic": [1, 1, 0, 1, 1, 1],
    "spherical": [1, 1, 1, 0, 0, 0],
    "planar": [1, 1, 0, 0, 0, 0],
    "spatial": [1, 1, 1, 1, 0, 0],
}


class ExudynMotion:
    """Exudyn: explicit solvers on minimal coordinates or Lie groups, implicit ones on everything else."""

    name = "Exudyn"
    kind = "package"
    preparing = "loading Exudyn"
    how = (
        "without loops, DOPRI5 at every tolerance and RK67 at every step: ObjectKinematicTree for "
        "revolute and prismatic joints, else NodeRigidBodyRotVecLG with Lie-group integration, pivots by "
        "eliminated coordinates; with loops or stiff springs, TrapezoidalIndex2 and GeneralizedAlpha "
        "(spectral radius 0.9) at every step: bodies with Euler parameters, joints by GenericJoint "
        "without what is redundant, Newton's method to 1e-10 relative, EigenDense; the best of all "
        "counting; output off; SolveSteps alone is timed"
    )

    @classmethod
    def version(cls) -> str:
        """Version of the library. Raises Missing."""
        return library_of("exudyn", "exudyn").config.Version()

    def settings(self, problem: Problem) -> list[Setting]:
        """From loose to tight."""
        loops = not problem.scene and spanning_tree(problem.data)[1]
        implicit = IMPLICIT if loops or problem.data["forces"] else ()
        found = []

        for level, (tolerance, step) in enumerate(zip(TOLERANCES, problem.steps)):
            if not loops:
                values = {"solver": "DOPRI5", "tolerance": tolerance}
                found.append(Setting(f"DOPRI5, tolerance {tolerance:.0e}", values, level, "DOPRI5"))

            for solver in (*implicit, *(() if loops else ("RK67",))):
                values = {"solver": solver, "step": step}
                found.append(Setting(f"{solver}, step {step:.3g}", values, level, solver))

        return found

    def prepare(self, problem: Problem, setting: Setting) -> "_Run":
        """A run to be timed. Raises Cannot."""
        if problem.scene:
            raise Cannot("rolling and points on curves are not expressed here for Exudyn")

        if setting.values["solver"] in IMPLICIT:
            return RedundantRun(problem, setting.values)

        tree, _ = spanning_tree(problem.data)

        if {joint.kind for joint in tree} <= {"revolute", "prismatic"}:
            return TreeRun(problem, tree, setting.values)

        if len(tree) == 1:
            return LieGroupRun(problem, tree[0], setting.values)

        raise Cannot("spherical joints are not among those of ObjectKinematicTree")


class _Run:
    """A system of Exudyn and a way to solve it from one reference time to the next.

    values : `solver`, and `tolerance` or `step` (s).
    """

    def __init__(self, problem: Problem, values: dict):
        self.exu = library_of("exudyn", "exudyn")
        self.exu.config.suppressWarnings = True
        self.exu.config.printToConsole = False
        self.items = library_of("exudyn.itemInterface", "exudyn")
        self.problem, self.values = problem, values
        self.container = self.exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.build()
        self.mbs.Assemble()
        self.start = self.mbs.systemData.GetSystemState(configuration=self.exu.ConfigurationType.Initial)
        self.accelerations_at_start = self.mbs.systemData.GetODE2Coordinates_tt()
        self.settings = self._settings()
        self.steps = 0

    @property
    def effort(self) -> dict[str, int]:
        """Steps of the last run."""
        return {"steps": self.steps}

    def run(self) -> tuple[float, np.ndarray]:
        """CPU seconds of the steps, and the motion (n_t, n_body, MOTION_SIZE). Raises Cannot."""
        exu, mbs, scheme = self.exu, self.mbs, self.settings.timeIntegration
        initial = exu.ConfigurationType.Initial
        mbs.systemData.SetSystemState(self.start, configuration=initial)
        mbs.systemData.SetODE2Coordinates_tt(self.accelerations_at_start, configuration=initial)
        t, seconds, rows, self.steps = 0.0, 0.0, [], 0
        scheme.initialStepSize = self.problem.steps[-1] if "tolerance" in self.values else 0.0

        for until in self.problem.times:
            scheme.startTime, scheme.endTime = t, until

            if "step" in self.values:
                scheme.numberOfSteps = int(np.ceil((until - t) / self.values["step"] * (1 - 1e-9)))
            else:
                scheme.numberOfSteps = 1

            solver = exu.MainSolverImplicitSecondOrder() if self.implicit else exu.MainSolverExplicit()

            try:
                if not solver.InitializeSolver(mbs, self.settings):
                    raise Cannot("its solver does not begin")

                start = time.process_time()
                done = solver.SolveSteps(mbs, self.settings)
                seconds += time.process_time() - start
                self.steps += solver.it.currentStepIndex
                last = solver.it.currentStepSize
                solver.FinalizeSolver(mbs, self.settings)
            except (RuntimeError, ValueError) as error:
                raise Cannot(
                    f"its solver stops at {t:.4g} s: {str(error).strip().splitlines()[-1]}"
                ) from None

            if not (done and np.all(np.isfinite(mbs.systemData.GetODE2Coordinates()))):
                raise Cannot(f"its solver stops after {t:.4g} s")

            mbs.systemData.SetSystemState(mbs.systemData.GetSystemState(), configuration=initial)
            mbs.systemData.SetODE2Coordinates_tt(
                mbs.systemData.GetODE2Coordinates_tt(), configuration=initial
            )
            scheme.initialStepSize = last if "tolerance" in self.values else 0.0
            rows.append(self.observe())
            t = until

        return seconds, np.array(rows)

    @property
    def implicit(self) -> bool:
        """Whether its solver is."""
        return self.values["solver"] in IMPLICIT

    def _settings(self):
        exu = self.exu
        settings = exu.SimulationSettings()
        settings.solution.file.write = False
        settings.solution.sensors.writeHeader = False
        settings.show.computationTime = False
        settings.show.statistics = False
        scheme = settings.timeIntegration
        scheme.verboseMode = 0
        scheme.stepInformation = 0
        scheme.solverType = getattr(exu.DynamicSolverType, self.values["solver"])

        if "tolerance" in self.values:
            scheme.absoluteTolerance = scheme.relativeTolerance = self.values["tolerance"]
            scheme.minimumStepSize = 1e-4 * self.problem.steps[-1]
            scheme.automaticStepSize = True
            scheme.stepSizeMaxIncrease = 5
        else:
            scheme.automaticStepSize = False
            scheme.adaptiveStep = False

        if self.implicit:
            settings.linearSolver.solverType = exu.LinearSolverType.EigenDense

        scheme.newton.relativeTolerance = 1e-10
        scheme.newton.absoluteTolerance = 1e-12
        trapezoidal = self.values["solver"] == IMPLICIT[0]
        scheme.generalizedAlpha.useNewmark = trapezoidal
        scheme.generalizedAlpha.useIndex2Constraints = trapezoidal
        return settings


class TreeRun(_Run):
    """Revolute and prismatic joints: minimal coordinates."""

    def __init__(self, problem: Problem, tree: list, values: dict):
        self.tree = tree
        super().__init__(problem, values)

    def build(self):
        """The tree as one object, its link frames at the joints."""
        exu, items, data = self.exu, self.items, self.problem.data
        given = {body["name"]: body for body in data["bodies"]}
        frames, index = {"ground": (np.zeros(3), np.eye(3))}, {"ground": -1}
        parents, turned, offsets, inertias, coms = [], [], [], [], []

        for k, joint in enumerate(self.tree):
            r0, A0 = frames[joint.parent]
            r, A = pose_of(given[joint.child])
            J = joint.axes.T @ A
            parents.append(index[joint.parent])
            turned.append(A0.T @ joint.axes)
            offsets.append(A0.T @ (joint.point - r0))
            coms.append(joint.axes.T @ (r - joint.point))
            inertias.append(J @ inertia_matrix(given[joint.child]) @ J.T)
            frames[joint.child], index[joint.child] = (joint.point, joint.axes), k

        q, v = start_of(data, self.tree)
        n = len(q)
        node = self.mbs.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=[0.0] * n,
                initialCoordinates=q,
                initialCoordinates_t=v,
                numberOfODE2Coordinates=n,
            )
        )
        kinds = {"revolute": exu.JointType.RevoluteZ, "prismatic": exu.JointType.PrismaticZ}
        self.body = self.mbs.AddObject(
            items.ObjectKinematicTree(
                nodeNumber=node,
                gravity=data["gravity"],
                jointTypes=[kinds[joint.kind] for joint in self.tree],
                linkParents=parents,
                jointTransformations=exu.Matrix3DList(turned),
                jointOffsets=exu.Vector3DList(offsets),
                linkInertiasCOM=exu.Matrix3DList(inertias),
                linkCOMs=exu.Vector3DList(coms),
                linkMasses=[given[joint.child]["mass"] for joint in self.tree],
            )
        )
        ground = None

        for force in data["forces"]:
            if force["type"] != "spring_damper":
                raise Cannot("loads other than spring-dampers are not expressed here")

            ends = []

            for side in "ij":
                name = force[f"body_{side}"]

                if name == "ground":
                    ground = ground or self.mbs.AddObject(items.ObjectGround())
                    marker = items.MarkerBodyPosition(bodyNumber=ground, localPosition=force[f"point_{side}"])
                else:
                    r, A = frames[name]
                    local = A.T @ (np.array(force[f"point_{side}"], float) - r)
                    marker = items.MarkerKinematicTreeRigid(
                        objectNumber=self.body, linkNumber=index[name], localPosition=local
                    )

                ends.append(self.mbs.AddMarker(marker))

            self.mbs.AddObject(
                items.ObjectConnectorSpringDamper(
                    markerNumbers=ends, referenceLength=force["l0"], stiffness=force["k"], damping=force["c"]
                )
            )

    def observe(self) -> np.ndarray:
        """Motion (n_body, MOTION_SIZE) now."""
        states = self.mbs.systemData
        return motion_of(
            self.problem.data, self.tree, states.GetODE2Coordinates(), states.GetODE2Coordinates_t()
        )


class _Bodies(_Run):
    """Bodies as rigid-body objects: what is read from them."""

    def observe(self) -> np.ndarray:
        """Motion (n_body, MOTION_SIZE) now."""
        kinds = self.exu.OutputVariableType
        table = np.zeros((len(self.bodies), MOTION_SIZE))

        for k, (number, com) in enumerate(self.bodies):
            r, A, v, w = (
                np.array(self.mbs.GetObjectOutputBody(number, kind, localPosition=com))
                for kind in (kinds.Position, kinds.RotationMatrix, kinds.Velocity, kinds.AngularVelocity)
            )
            E = (
                Rotation.from_matrix(A.reshape(3, 3)).as_quat()
                if np.all(np.isfinite(A))
                else np.full(4, np.nan)
            )
            table[k] = [*r, *E, *v, *w]

        return table

    def add_body(self, body: dict, node_type) -> dict:
        """A body, its node at the centre of mass. Returns its `nodeNumber` and `bodyNumber`."""
        r, A = pose_of(body)
        found = self._create(
            body, node_type, inertia_matrix(body), referencePosition=r, referenceRotationMatrix=A,
            initialVelocity=body.get("v0", [0, 0, 0]), gravity=self.problem.data["gravity"],
        )  # fmt: skip
        self.bodies.append((found["bodyNumber"], np.zeros(3)))
        return found

    def add_pivoted_body(self, body: dict, node_type, pivot: np.ndarray) -> dict:
        """A body whose node stands at a fixed point (m, inertial).

        As if its centre of mass were there, with the inertia about there, and its weight where the centre of
        mass is.
        """
        r, A = pose_of(body)
        com = A.T @ (r - pivot)
        inertia = inertia_matrix(body) + body["mass"] * (com @ com * np.eye(3) - np.outer(com, com))
        found = self._create(body, node_type, inertia, referencePosition=pivot, referenceRotationMatrix=A)
        weight = body["mass"] * np.array(self.problem.data["gravity"], float)
        self.mbs.CreateForce(itemNumber=found["bodyNumber"], loadVector=weight, localPosition=com, show=False)
        self.bodies.append((found["bodyNumber"], com))
        return found

    def _create(self, body, node_type, inertia, **more):
        utilities = library_of("exudyn.utilities", "exudyn")
        return self.mbs.CreateRigidBody(
            inertia=utilities.RigidBodyInertia(mass=body["mass"], inertiaTensor=inertia),
            nodeType=node_type,
            initialAngularVelocity=body.get("w0", [0, 0, 0]),
            returnDict=True,
            show=False,
            **more,
        )


class LieGroupRun(_Bodies):
    """One body, free or on a spherical joint: its node stands at the joint and cannot move."""

    def __init__(self, problem: Problem, joint, values: dict):
        self.joint = joint
        super().__init__(problem, values)

    def build(self):
        """The body, and the pivot as coordinates that the solver eliminates."""
        items, self.bodies = self.items, []
        body = self.problem.data["bodies"][0]
        kind = self.exu.NodeType.RotationRotationVector

        if self.joint.kind == "free":
            self.add_body(body, kind)
        else:
            node = self.add_pivoted_body(body, kind, self.joint.point)["nodeNumber"]
            ground = self.mbs.AddNode(items.NodePointGround())
            fixed = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))

            for k in range(3):
                marker = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
                self.mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[fixed, marker]))


class RedundantRun(_Bodies):
    """All bodies, and every joint a constraint."""

    def build(self):
        """Bodies with Euler parameters, generic joints, springs and torques."""
        self.bodies, data = [], self.problem.data
        numbers = {"ground": self.mbs.CreateGround()}

        for body in data["bodies"]:
            kind = self.exu.NodeType.RotationEulerParameters
            numbers[body["name"]] = self.add_body(body, kind)["bodyNumber"]

        given = {body["name"]: body for body in data["bodies"]}
        _, loops = spanning_tree(data)
        planar = len({tuple(joint.get("axis", ())) for joint in data["joints"]}) == 1
        closing = "planar" if planar else "spatial"

        for joint in data["joints"]:
            axis = np.array(joint.get("axis", [0, 0, 1]), float)
            self.mbs.CreateGenericJoint(
                itemNumbers=[numbers[joint["body_i"]], numbers[joint["body_j"]]],
                position=joint["point"],
                rotationMatrixAxes=axes_with_z(axis / np.linalg.norm(axis)),
                constrainedAxes=HELD[closing if joint in loops else joint["type"]],
                useGlobalFrame=True,
                show=False,
            )

        for force in data["forces"]:
            if force["type"] == "torque":
                self.mbs.CreateTorque(
                    itemNumber=numbers[force["body"]], loadVector=force["vector"], show=False
                )
                continue

            points = []

            for side in "ij":
                name = force[f"body_{side}"]
                r, A = pose_of(given[name]) if name != "ground" else (np.zeros(3), np.eye(3))
                points.append(A.T @ (np.array(force[f"point_{side}"], float) - r))

            self.mbs.CreateSpringDamper(
                itemNumbers=[numbers[force["body_i"]], numbers[force["body_j"]]],
                localPosition0=points[0], localPosition1=points[1],
                referenceLength=force["l0"], stiffness=force["k"], damping=force["c"], show=False,
            )  # fmt: skip
