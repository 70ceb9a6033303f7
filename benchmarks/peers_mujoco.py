"""MuJoCo's motion of a problem: its own time stepping, called for many steps at once."""

import time

import numpy as np
from scipy.spatial.transform import Rotation

from .contests import Cannot, Setting
from .peers import library_of
from .problem_files import pose_of
from .problems import MOTION_SIZE, Problem
from .spanning import inertia_matrix, spanning_tree

# a loop is closed by springs and dampers: the time constant, in steps, and the impedance. Which time constant
# is the best differs from problem to problem; among 1 to 20, and damping ratios 1 to 2, it was one of these
SOFT = (1.2, 4.0, 8.0)
SOLIMP = [0.9999, 0.9999, 0.001, 0.5, 2.0]


class MuJoCoMotion:
    """MuJoCo's classical Runge-Kutta method: of its integrators the one of highest order."""

    name = "MuJoCo"
    kind = "package"
    preparing = "loading MuJoCo"
    how = (
        "RK4, mj_step for all steps between two reference times in one call; contacts and all else that "
        "the problem does not need off; loops by equality constraints (solref of 1.2, 4 and 8 steps, the "
        "best of them counting; solimp 0.9999), Newton's method to 1e-15; spring-dampers by tendons"
    )

    @classmethod
    def version(cls) -> str:
        """Version of the library. Raises Missing."""
        return library_of("mujoco", "mujoco").__version__

    def settings(self, problem: Problem) -> list[Setting]:
        """From loose to tight; where loops close, each step with every stiffness of the constraints."""
        loops = not problem.scene and spanning_tree(problem.data)[1]
        return [
            Setting(
                f"step {h:.3g}" + f", solref {soft:g} steps" * bool(loops),
                {"step": h, "soft": soft},
                level,
                f"{soft:g}",
            )
            for level, h in enumerate(problem.steps)
            for soft in (SOFT if loops else SOFT[:1])
        ]

    def prepare(self, problem: Problem, setting: Setting) -> "MuJoCoRun":
        """A run to be timed. Raises Cannot."""
        if problem.scene:
            raise Cannot("rolling and points on curves are not among its joints and constraints")

        return MuJoCoRun(problem, **setting.values)


class MuJoCoRun:
    """A problem as a model of MuJoCo, body frames at the centres of mass.

    step : s, the longest; the steps between two reference times are equal.
    soft : time constant of the constraints, steps.
    """

    def __init__(self, problem: Problem, step: float, soft: float = SOFT[0]):
        self.mujoco = library_of("mujoco", "mujoco")

        # its warnings would go to a file in the working folder; `run` looks at their numbers
        self.mujoco.set_mju_user_warning(lambda text: None)
        self.problem, self.step, self.soft = problem, step, soft
        self.model, self.joints = self._model()
        self.data = self.mujoco.MjData(self.model)
        self.qpos0, self.qvel0 = self._start()
        self.steps = 0

    def run(self) -> tuple[float, np.ndarray]:
        """CPU seconds of the steps, and the motion (n_t, n_body, MOTION_SIZE)."""
        mj_step, model, data = self.mujoco.mj_step, self.model, self.data
        times = self.problem.times
        counts = [int(np.ceil(span / self.step * (1 - 1e-9))) for span in np.diff(times, prepend=0.0)]
        qpos, qvel = np.zeros((len(times), model.nq)), np.zeros((len(times), model.nv))
        self.mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = self.qpos0, self.qvel0
        self._apply_torques()
        start = time.process_time()

        for k, (span, n) in enumerate(zip(np.diff(times, prepend=0.0), counts)):
            model.opt.timestep = span / n
            mj_step(model, data, n)
            qpos[k], qvel[k] = data.qpos, data.qvel

        seconds = time.process_time() - start
        self.steps = sum(counts)

        if np.any(data.warning.number[4:]) or not np.all(np.isfinite(qpos)):
            raise Cannot("the motion grows out of bounds")

        return seconds, np.array([self._observe(*row) for row in zip(qpos, qvel)])

    @property
    def effort(self) -> dict[str, int]:
        """Steps of the last run."""
        return {"steps": self.steps}

    def accelerations(self) -> np.ndarray:
        """(n_v,) of the joint coordinates at the start."""
        self.data.qpos[:], self.data.qvel[:] = self.qpos0, self.qvel0
        self._apply_torques()
        self.mujoco.mj_forward(self.model, self.data)
        return self.data.qacc.copy()

    def _model(self):
        mujoco, data = self.mujoco, self.problem.data
        spec = mujoco.MjSpec()
        spec.compiler.degree = False
        option = spec.option
        option.gravity = data["gravity"]
        option.integrator = mujoco.mjtIntegrator.mjINT_RK4
        option.solver = mujoco.mjtSolver.mjSOL_NEWTON
        option.tolerance, option.iterations, option.ls_iterations = 1e-15, 100, 100
        disable = mujoco.mjtDisableBit
        option.disableflags |= int(disable.mjDSBL_CONTACT | disable.mjDSBL_REFSAFE | disable.mjDSBL_AUTORESET)
        option.disableflags |= int(disable.mjDSBL_SENSOR | disable.mjDSBL_ACTUATION | disable.mjDSBL_LIMIT)
        tree, loops = spanning_tree(data)
        given = {body["name"]: body for body in data["bodies"]}
        made, poses = {"ground": spec.worldbody}, {"ground": (np.zeros(3), np.eye(3))}
        kinds = {
            "revolute": mujoco.mjtJoint.mjJNT_HINGE,
            "prismatic": mujoco.mjtJoint.mjJNT_SLIDE,
            "spherical": mujoco.mjtJoint.mjJNT_BALL,
            "free": mujoco.mjtJoint.mjJNT_FREE,
        }

        for joint in tree:
            r, A = poses[joint.child] = pose_of(given[joint.child])
            r0, A0 = poses[joint.parent]
            I = inertia_matrix(given[joint.child])
            body = made[joint.child] = made[joint.parent].add_body(
                name=joint.child,
                pos=A0.T @ (r - r0),
                quat=np.roll(Rotation.from_matrix(A0.T @ A).as_quat(), 1),
                mass=given[joint.child]["mass"],
                ipos=np.zeros(3),  # without it, the axes of the inertia are lost
                fullinertia=[I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]],
                explicitinertial=True,
            )
            made_joint = body.add_joint(type=kinds[joint.kind], name=joint.child)

            if joint.kind != "free":
                made_joint.pos, made_joint.axis = A.T @ (joint.point - r), A.T @ joint.axes[:, 2]

        self._close(spec, loops, poses)
        self._add_springs(spec, made, poses)
        return spec.compile(), tree

    def _close(self, spec, loops, poses):
        """One point for a planar loop, else two on the axis."""
        mujoco = self.mujoco
        axes = [joint.get("axis", [0, 0, 1]) for joint in self.problem.data["joints"]]
        planar = all(np.allclose(axis, axes[0]) for axis in axes)

        for joint in loops:
            for along in (0.0,) if planar else (-0.5, 0.5):
                r, A = poses[joint["body_i"]]
                equality = spec.add_equality(
                    type=mujoco.mjtEq.mjEQ_CONNECT,
                    objtype=mujoco.mjtObj.mjOBJ_BODY,
                    name1=_world(joint["body_i"]),
                    name2=_world(joint["body_j"]),
                )
                anchor = np.array(joint["point"], float) + along * np.array(joint["axis"], float)
                equality.data[:3] = A.T @ (anchor - r)
                equality.solref = [self.soft * self.step, 1.0]
                equality.solimp = SOLIMP

    def _add_springs(self, spec, made, poses):
        for k, force in enumerate(self.problem.data["forces"]):
            if force["type"] != "spring_damper":
                continue

            tendon = spec.add_tendon(name=f"spring {k}", springlength=[force["l0"]] * 2)
            tendon.stiffness = _linear(tendon.stiffness, force["k"])
            tendon.damping = _linear(tendon.damping, force["c"])

            for side in "ij":
                name = force[f"body_{side}"]
                r, A = poses[name]
                made[name].add_site(
                    name=f"spring {k} {side}", pos=A.T @ (np.array(force[f"point_{side}"]) - r)
                )
                tendon.wrap_site(f"spring {k} {side}")

    def _start(self):
        qpos, qvel = self.data.qpos.copy(), self.data.qvel.copy()
        given = {body["name"]: body for body in self.problem.data["bodies"]}

        for joint in self.joints:
            at = self.model.joint(joint.child).dofadr[0]
            _, A = pose_of(given[joint.child])

            if joint.kind == "revolute":
                qvel[at] = joint.axes[:, 2] @ joint.omega
            elif joint.kind == "spherical":
                qvel[at : at + 3] = A.T @ joint.omega
            elif joint.kind == "free":
                qvel[at : at + 3], qvel[at + 3 : at + 6] = joint.velocity, A.T @ joint.omega

        return qpos, qvel

    def _apply_torques(self):
        for force in self.problem.data["forces"]:
            if force["type"] == "torque":
                self.data.xfrc_applied[self.model.body(force["body"]).id, 3:] = force["vector"]

    def _observe(self, qpos, qvel):
        mujoco, model, data = self.mujoco, self.model, self.data
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        table = np.zeros((len(self.problem.data["bodies"]), MOTION_SIZE))
        velocity = np.zeros(6)

        for k, body in enumerate(self.problem.data["bodies"]):
            i = model.body(body["name"]).id
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, i, velocity, 0)
            table[k] = [*data.xipos[i], *np.roll(data.xquat[i], -1), *velocity[3:], *velocity[:3]]

        return table


def _linear(before, value):
    """As a polynomial where this version has these."""
    return np.array([value, *np.zeros(np.size(before) - 1)]) if np.ndim(before) else value


def _world(body):
    return "world" if body == "ground" else body
