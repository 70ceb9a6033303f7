"""A master that misbehaves: numbers that are none, steps backwards, settings beyond reason.

Each is refused in words, or what comes of it is finite; and the instance stays where it is.
"""

import math

import numpy as np

from mbdfmi.compiler.variables import dotted
from mbdfmi.run.instance import SimulationError

ABSURD = (math.nan, math.inf, -math.inf, 1e300)
BACKWARDS = (-1e-3, math.nan, -math.inf)
STEP = 1e-3
WORK = 200.0  # evaluations that a step from absurd values may cost
MOST = 4  # inputs that are set to absurd values

# endings of parameters -> values of which one alone must be refused
BEYOND_REASON = {
    "solver.tolerance": (0.5, 1e30, 1e-20, math.nan),
    "solver.absolute_tolerance": (0.5, 1e-20),
    "solver.max_evaluations": (0.0,),
    ".mass": (-1.0, math.inf, math.nan),
    ".com[1]": (1e200, math.nan),
}


def tease(instance):
    """What an instance (`mbdfmi.run.instance.Instance`) takes, tells or becomes that it must not, in words.

    Its inputs and parameters are left as they were; its state has to be restored.
    """
    before = _seen(instance)
    found = [*_steps_back(instance, before), *_settings(instance, before)]
    instance.m.max_evaluations[0], kept = WORK, instance.m.max_evaluations[0]

    for v in instance.model.of_causality("input")[:MOST]:
        found += [text for value in ABSURD for text in _input(instance, before, v, value)]

    instance.m.max_evaluations[0] = kept
    return found


def forget_work(d):
    """As an FMU does when a state is set: what the work array holds from the last call counts no more."""
    d.lu_known[0] = d.stages_here[0] = 0.0


def _seen(instance):
    return [instance.time, *instance.d.x, *instance.outputs()]


def _steps_back(instance, before):
    for H in BACKWARDS:
        if not _refuses(instance.step, H):
            yield f"a step of {H} s is taken"
        elif _seen(instance) != before:
            yield f"a step of {H} s that is refused leaves another state"


def _settings(instance, before):
    """Parameters beyond reason, one at a time."""
    scene = instance.model.scene
    # less the water that it displaces; one of these may be lighter than that
    lines = {
        dotted(name, "mass")
        for name, force in scene.force.items()
        if force.kind == "catenary" and force.catenary.is_composite
    }
    massive = {
        v.name.rpartition(".")[0] for v in _parameters(instance, ".mass") if instance.reals[v.index] > 0.0
    }

    for ending, values in BEYOND_REASON.items():
        for v in _parameters(instance, ending):
            # without a mass its centre may be anywhere
            for value in (
                values if not ending.startswith(".com") or v.name.rpartition(".")[0] in massive else ()
            ):
                if value == -1.0 and v.name in lines:
                    continue

                kept = instance.reals[v.index]
                instance.reals[v.index] = value
                refused = _refuses(instance.prepare)
                instance.reals[v.index] = kept
                instance.prepare()

                if not refused:
                    yield f"{v.name} = {value} is taken"

    if _seen(instance) != before:
        yield "parameters that were refused leave another state"


def _parameters(instance, ending):
    return [v for v in instance.model.of_causality("parameter") if v.name.endswith(ending)]


def _input(instance, before, v, value):
    """What is told with an absurd input, and where a step leads: to what is finite, or it fails."""
    kept = [array.copy() for array in (instance.d.state_buffer, instance.u)]

    for what, act in (
        ("outputs", instance.outputs),
        ("a step", lambda: instance.step(STEP)),
        ("outputs", instance.outputs),
    ):
        instance.u[v.index] = value

        try:
            told = act()
        except SimulationError as error:
            told = None if str(error).strip() else math.nan

        if told is not None and not np.isfinite(told).all():
            yield f"{what} with {v.name} = {value} are not finite, or fail without a word"

    instance.d.state_buffer[:], instance.u[:] = kept
    forget_work(instance.d)

    if _seen(instance) != before:
        yield f"{v.name} = {value} leaves other outputs when it is taken back"


def _refuses(act, *arguments):
    """Whether it is refused, in words."""
    try:
        act(*arguments)
    except SimulationError as error:
        return bool(str(error).strip())

    return False
