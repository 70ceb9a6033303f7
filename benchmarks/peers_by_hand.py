"""Motion of some problems by reduced equations written by hand for each: the limit of what can be had."""

import ctypes
import time
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from .contests import Cannot, Setting
from .native import compiled
from .problems import Problem
from .spanning import motion_of, spanning_tree

# name -> number in by_hand.c and number of states
SYSTEMS = {"double_pendulum_bars": (0, 4), "heavy_top_bruls": (1, 7), "four_bar": (2, 2)}


class ByHand:
    """A program for that mechanism alone."""

    name = "by hand"
    kind = "limit"
    preparing = "compiling equations written by hand"
    how = (
        "minimal equations of that mechanism, derived by hand (the loop closed in closed form), in C by "
        "zig's clang, -O3 -march=native -ffast-math, in a loop of our 8(5,3) pair in C: no multibody "
        "program, but the limit of what one could reach"
    )

    @classmethod
    def version(cls) -> str:
        """Of the compiler. Raises Missing."""
        _library()
        return "C99"

    def settings(self, problem: Problem) -> list[Setting]:
        """From loose to tight."""
        return [
            Setting(f"tolerance {tolerance:.0e}", {"tolerance": tolerance}, level)
            for level, tolerance in enumerate(problem.tolerances)
        ]

    def prepare(self, problem: Problem, setting: Setting) -> "ByHandRun":
        """A run to be timed. Raises Cannot."""
        if problem.name not in SYSTEMS:
            raise Cannot("nobody has written its equations")

        return ByHandRun(problem, **setting.values)


class ByHandRun:
    """A problem, its number and its start in by_hand.c."""

    def __init__(self, problem: Problem, tolerance: float):
        self.problem, self.tolerance = problem, tolerance
        self.system, self.n = SYSTEMS[problem.name]
        self.tree, _ = spanning_tree(problem.data)
        self.evaluations = 0

    def run(self) -> tuple[float, np.ndarray]:
        """CPU seconds, and the motion (n_t, n_body, MOTION_SIZE). Raises Cannot."""
        times = self.problem.times
        rows = np.zeros((len(times), self.n))
        start = self._start()
        began = time.process_time()
        self.evaluations = _library().by_hand_run(
            self.system, self.n, start, times, len(times), self.tolerance, rows
        )
        seconds = time.process_time() - began

        if self.evaluations < 0 or not np.all(np.isfinite(rows)):
            raise Cannot("the integrator gives up")

        return seconds, np.array(
            [motion_of(self.problem.data, self.tree, *self._joints(row)) for row in rows]
        )

    @property
    def effort(self) -> dict[str, int]:
        """Evaluations of the last run."""
        return {"evaluations": int(self.evaluations)}

    def _start(self):
        if self.problem.name == "heavy_top_bruls":
            return np.array([0.0, 0.0, 0.0, 1.0, *self.problem.data["bodies"][0]["w0"]])

        return np.array([np.pi / 3, 0.0]) if self.problem.name == "four_bar" else np.zeros(4)

    def _joints(self, x):
        """Coordinates and velocities of the tree's joints, as in `start_of`: angles from the parent."""
        if self.problem.name == "heavy_top_bruls":
            axes = self.tree[0].axes
            turned = axes.T @ Rotation.from_quat(x[:4]).as_matrix() @ axes
            return Rotation.from_matrix(turned).as_quat(), axes.T @ x[4:]

        if self.problem.name == "double_pendulum_bars":
            return np.array([x[0], x[1] - x[0]]), np.array([x[2], x[3] - x[2]])

        crank, coupler, rocker = self._bars(x) - self._bars(self._start())
        _, *rates = self._bars(x, 1)
        return np.array([crank, coupler - crank, rocker]), np.array([x[1], rates[0] - x[1], rates[1]])

    def _bars(self, x, derivative=0):
        """Angles (rad) of crank, coupler and rocker, or their rates."""
        found = np.zeros((2, 3))
        _library().by_hand_four_bar(x, found[0], found[1])
        return found[derivative]


@cache
def _library():
    """The compiled equations. Raises Missing."""
    library = compiled("by_hand.c", "-ffast-math")
    reals = np.ctypeslib.ndpointer(np.float64, flags="C")
    integer, real = ctypes.c_int, ctypes.c_double
    library.by_hand_run.argtypes = [integer, integer, reals, reals, integer, real, reals]
    library.by_hand_run.restype = ctypes.c_long
    library.by_hand_four_bar.argtypes = [reals, reals, reals]
    library.by_hand_four_bar.restype = None
    return library
