"""The steppers by name, a record each: for scenes, for the compiler, for the kernels, for people.

The step itself is the file of kernels/steppers of that name; of the explicit pairs pairs.py, with
coefficients in tableaux.py.
"""

from typing import NamedTuple


class Stepper(NamedTuple):
    """What there is to know of a stepper without taking a step.

    number : what kernels call it, at m.integrator and d.method; of explicit pairs their place in tableaux.py.
    order : of the error after a given time in the step size; of `auto`, of the method that it begins with.
    fixed : takes equal steps of at most `solver.step`; else it is adaptive, by `solver.tolerance`.
    stage_rows : values of each state within a step: rates of its stages, right-hand sides.
    dense_rows : values of each state from one step to the next: continuous extension, or stages.
    implicit : needs the Jacobian dx'/dx.
    words : what it is, as the start of a sentence.
    """

    name: str
    number: int
    order: int
    fixed: bool
    stage_rows: int
    dense_rows: int
    implicit: bool
    words: str


AUTO = (
    "embedded Runge-Kutta pair of order 8(5,3), or 5(4) or 3(2) where that costs less; while the motion is "
    "stiff, the implicit Radau IIA method of order 5, or a stabilised method of order 2 where that costs less"
)

STEPPERS = {
    record.name: record
    for record in (
        Stepper("auto", 8, 8, False, 16, 7, True, AUTO),
        Stepper("rk54", 0, 5, False, 7, 4, False, "embedded Runge-Kutta pair of order 5(4)"),
        Stepper("rk853", 1, 8, False, 16, 7, False, "embedded Runge-Kutta pair of order 8(5,3)"),
        Stepper("radau", 3, 5, False, 10, 3, True, "implicit Radau IIA method of order 5"),
        Stepper("rk4", 5, 4, True, 4, 0, False, "classical Runge-Kutta method of order 4"),
        Stepper("ros2", 6, 2, True, 2, 0, True, "linearly implicit method of order 2"),
        Stepper("gauss", 7, 8, True, 4, 4, False, "implicit and symmetric Gauss method of order 8"),
    )
}

RK32 = Stepper("rk32", 2, 3, False, 4, 3, False, "embedded Runge-Kutta pair of order 3(2)")
"""Of `auto` alone: where inputs jump so often that steps are short for that reason."""

RKC = Stepper("rkc", 4, 2, False, 4, 0, False, "stabilised Runge-Kutta-Chebyshev method of order 2")
"""Of `auto` alone: where much decays fast and a Jacobian would cost too much."""

ADAPTIVE = tuple(name for name, record in STEPPERS.items() if not record.fixed)
FIXED_STEP = tuple(name for name, record in STEPPERS.items() if record.fixed)

MOST_VALUES = 1_000_000
"""Values of a Newton matrix, fill included, up to which `auto` may turn to its implicit method."""


def needs_jacobian(stepper: Stepper, n_value: int) -> bool:
    """Whether a model keeps a Jacobian of n_value values for a stepper."""
    return stepper.implicit and (stepper.name != "auto" or n_value <= MOST_VALUES)
