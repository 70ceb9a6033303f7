"""Motion of a problem by Pinocchio's forward dynamics, integrated in C++."""

import ctypes
import time
from functools import cache

import numpy as np

from .contests import Cannot, Setting
from .peers import Pinocchio, compiled_with_pinocchio
from .problem_files import pose_of
from .problems import Problem
from .spanning import SIZES, inertia_matrix, motion_of, spanning_tree, start_of

METHODS = ("8(5,3)", "Bulirsch-Stoer", "Fehlberg 7(8)", "Dormand-Prince 5(4)")
KINDS = tuple(SIZES)

# tensors of n^3 numbers, second derivatives of torques, in every pinocchio::Data; most bytes for them
TENSORS = 4
MOST = 1e9


class PinocchioMotion:
    """Its articulated-body algorithm in adaptive integrators, ours and Boost's."""

    name = "Pinocchio"
    kind = "loop"  # it integrates nothing: the loop around it is ours
    preparing = "compiling Pinocchio's headers (minutes, once)"
    how = (
        "aba in a loop in C++, all compiled for this processor (zig's clang, -O3 -march=native); a pair of "
        f"order {METHODS[0]} with our tableau, and Boost's adaptive integrators {', '.join(METHODS[1:])}, "
        "each at every tolerance, the best of them counting; "
        "quaternions as coordinates; spring-dampers by external forces. It has no integrators of its own"
    )

    @classmethod
    def version(cls) -> str:
        """Version of the library. Raises Missing."""
        _library()
        return Pinocchio.version()

    def settings(self, problem: Problem) -> list[Setting]:
        """From loose to tight."""
        return [
            Setting(f"{name}, tolerance {tolerance:.0e}", {"method": k, "tolerance": tolerance}, level, name)
            for level, tolerance in enumerate(problem.tolerances)
            for k, name in enumerate(METHODS)
        ]

    def prepare(self, problem: Problem, setting: Setting) -> "PinocchioRun":
        """A run to be timed. Raises Cannot."""
        if problem.scene:
            raise Cannot("rolling and points on curves are not among its joints")

        return PinocchioRun(problem, **setting.values)


class PinocchioRun:
    """A problem as a model of Pinocchio, body frames at the joints, and one way to integrate it."""

    def __init__(self, problem: Problem, method: int, tolerance: float):
        self.library, self.problem = _library(), problem
        self.method, self.tolerance = method, tolerance
        self.tree, loops = spanning_tree(problem.data)

        if loops:
            raise Cannot(
                "loops: aba knows none, and its constraintDynamics leaves to the user what a step drifts "
                "from the constraints"
            )

        if any(force["type"] != "spring_damper" for force in problem.data["forces"]):
            raise Cannot("loads other than spring-dampers are not in this loop")

        n_v = sum(SIZES[joint.kind][1] for joint in self.tree)

        if 8 * TENSORS * n_v**3 > MOST:
            raise Cannot(
                f"its Data holds {TENSORS} tensors of {n_v}^3 numbers, asked for or not: "
                f"{8e-9 * TENSORS * n_v**3:.0f} GB"
            )

        self.handle = self.library.motion_new(np.array(problem.data["gravity"], float))
        self._add_bodies()
        nq, nv = ctypes.c_int(), ctypes.c_int()
        self.library.motion_ready(self.handle, nq, nv)
        self.x0 = np.concatenate(start_of(problem.data, self.tree))
        self.nq = nq.value
        assert len(self.x0) == nq.value + nv.value
        self.evaluations = 0

    def __del__(self):
        if hasattr(self, "handle"):
            self.library.motion_delete(self.handle)

    def run(self) -> tuple[float, np.ndarray]:
        """CPU seconds, and the motion (n_t, n_body, MOTION_SIZE). Raises Cannot."""
        times = self.problem.times
        rows = np.zeros((len(times), len(self.x0)))
        start = time.process_time()
        self.evaluations = self.library.motion_run(
            self.handle, self.x0, times, len(times), self.method, self.tolerance, rows
        )
        seconds = time.process_time() - start

        if self.evaluations < 0 or not np.all(np.isfinite(rows)):
            raise Cannot("the integrator gives up")

        return seconds, np.array(
            [motion_of(self.problem.data, self.tree, row[: self.nq], row[self.nq :]) for row in rows]
        )

    @property
    def effort(self) -> dict[str, int]:
        """Evaluations of the last run."""
        return {"evaluations": int(self.evaluations)}

    def _add_bodies(self):
        data = self.problem.data
        given = {body["name"]: body for body in data["bodies"]}
        frames = {"ground": (0, np.zeros(3), np.eye(3))}

        for k, joint in enumerate(self.tree):
            parent, r0, A0 = frames[joint.parent]

            # a free joint's own coordinates say where the body is; all others begin at zero
            r, A = (np.zeros(3), np.eye(3)) if joint.kind == "free" else (joint.point, joint.axes)
            body_r, body_A = pose_of(given[joint.child])
            at, turned = (body_r, body_A) if joint.kind == "free" else (joint.point, joint.axes)
            I = inertia_matrix(given[joint.child])
            J = turned.T @ body_A
            self.library.motion_add(
                self.handle, parent, KINDS.index(joint.kind), A0.T @ (r - r0),
                np.ascontiguousarray((A0.T @ A).T), given[joint.child]["mass"], turned.T @ (body_r - at),
                J @ I @ J.T,
            )  # fmt: skip
            frames[joint.child] = (k + 1, at, turned)

        for force in data["forces"]:
            ends = []

            for side in "ij":
                index, r, A = frames[force[f"body_{side}"]]
                ends += [index, A.T @ (np.array(force[f"point_{side}"], float) - r)]

            self.library.motion_spring(self.handle, *ends, force["k"], force["c"], force["l0"])


@cache
def _library():
    """The compiled loop. Raises Missing."""
    Pinocchio.version()
    library = compiled_with_pinocchio("pinocchio_motion.cpp")
    reals = np.ctypeslib.ndpointer(np.float64, flags="C")
    handle, integer, real = ctypes.c_void_p, ctypes.c_int, ctypes.c_double
    library.motion_new.argtypes, library.motion_new.restype = [reals], handle
    library.motion_delete.argtypes = [handle]
    library.motion_add.argtypes = [handle, integer, integer, reals, reals, real, reals, reals]
    library.motion_spring.argtypes = [handle, integer, reals, integer, reals, real, real, real]
    library.motion_ready.argtypes = [handle, ctypes.POINTER(integer), ctypes.POINTER(integer)]
    library.motion_run.argtypes = [handle, reals, reals, integer, integer, real, reals]
    library.motion_run.restype = ctypes.c_long
    return library
