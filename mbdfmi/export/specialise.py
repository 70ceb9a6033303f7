"""A library of one scene: compiled from the scene's own code (`core`), x' = f traced where that pays (docs/specialise.md).

It knows no other scene: its wrapper refuses a model of another GUID.
"""

import hashlib
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..files import replacing
from ..kernels.dynamics import projection, rates
from ..kernels.entry import ENTRIES
from ..kernels.steppers import jacobian
from ..native.platforms import PLATFORMS, host_platform
from ..native.sources import cache_directory
from ..run.instance import Instance, SimulationError
from ..steppers import STEPPERS
from ..trace.graph import Untraceable
from ..trace.plain import plain_function
from ..trace.projecting import trace_projection
from ..trace.specialise import Traced, trace_jacobian, trace_outputs, trace_rates
from . import header, link
from .core import core

MOST_OPERATIONS = 3000
"""Operations of a trace at most: about 32 kB of code, the instruction cache. Beyond it loops are faster."""

MOST_AT_SEA = 4000
"""Likewise of scenes with waves and lines, whose kernels take more than loops over bodies do: the offshore crane's
3,700 operations run twice as fast by `rk4`, the turbine's at sea, 3,100, 1.3 times."""

MOST_OF_JACOBIAN = 10_000
"""Likewise of the Jacobian, which is found once in many evaluations: what grows is the library. A longer one does not
pay: the floating turbine's 13,500 operations change nothing in a run by `radau`."""

MOST_IN_EACH_STEP = 20_000
"""Likewise where each step finds it (`ros2`): there they make that run 1.8 times faster."""

STATES = 16
"""States of a run at the start of the scene in which the guards of its trace are looked at."""

SPAN = 1.0
"""s, of that run, at most."""

BESIDE = 1e-8
"""Of the states' sizes, how far beside the constraints a step may lead."""

PROJECTION, JACOBIAN = plain_function(projection.project), plain_function(jacobian.find_jacobian)

MOST_FAILING = 0.25
"""Part of these states in which a guard may fail."""

_SECTIONS = ("-ffunction-sections", "-fdata-sections")
_NO_UNWINDING = ("-fno-asynchronous-unwind-tables", "-fno-unwind-tables")

FLAGS = ("-O3", "-fno-math-errno", "-fomit-frame-pointer", *_SECTIONS)
"""Of the compiler: square roots without a look at `errno`, each function by itself."""

SCALARS = ("-fno-slp-vectorize",)
"""Besides, where all that takes time is traced: a compiler that packs two numbers of straight-line code into one
register shuffles more than it gains (four-bar a fifth, pendulum a half of a run's time), but for loops over vectors.
"""

MOST_OF_SCALARS = 2000
"""Operations of x' = f up to which that holds: packed, longer code is shorter, and fits the instruction cache."""

WRAPPER_FLAGS = ("-Os", "-Xclang", "-Oz", "-fomit-frame-pointer", *_SECTIONS)
"""Of the compiler, for the wrapper, whose time does not count (zig takes -Oz for -Os)."""

UNCALLED = {".so": ("-Wl,--gc-sections", "-Wl,--hash-style=gnu"), ".dylib": ("-Wl,-dead_strip",)}
"""Of the linker, by the ending of a library: nothing that nobody calls, one table of names, not two."""


@dataclass(frozen=True)
class Own:
    """What is a scene's own. traced : its kernels, x' = f first; none where the generic ones are better. told : in
    words. is_straight : whether `SCALARS` are for it.
    """

    traced: tuple[Traced, ...]
    told: str
    is_straight: bool = False


def own(model) -> Own:
    """The kernels of a model traced where that pays, and what is to be said of them."""
    chosen, told = [], []

    try:
        run = _run(model)
        instance = next(run)
        found = {what: _traced(trace, instance) for what, trace in _worth(instance).items()}
        failing: dict[str, list] = {what: [] for what in found}

        for _ in run:
            for what, each in found.items():
                failing[what] += [_failing(instance, each)] if isinstance(each, Traced) else []
    except SimulationError as error:
        return Own((), f"nothing is traced: {error}")

    for what, each in found.items():
        why_not = each if isinstance(each, str) else _why_not(instance, each, chosen, failing[what])
        told.append(f"not {what}: {why_not}" if why_not else f"{what} ({each.operations} operations)")

        if not why_not:
            chosen.append(each)

        # without x' = f the rest would not tell
        if why_not and not chosen:
            return Own((), f"{what} is not traced: {why_not}")

    projects = not instance.m.n_row or any(each.kernel is PROJECTION for each in chosen)
    is_straight = projects and chosen[0].operations <= MOST_OF_SCALARS
    return Own(tuple(chosen), f"traced are {', '.join(told)}", is_straight)


def _worth(instance):
    """What is traced for a scene, in words, and by what."""
    found = {"x' = f": trace_rates}
    found |= {"the projection": _trace_projection} if instance.m.n_row else {}
    found |= {"outputs": trace_outputs} if instance.model.n_y else {}
    return found | ({"the Jacobian": trace_jacobian} if instance.m.n_jacobian else {})


def _trace_projection(instance):
    return trace_projection(instance, MOST_OPERATIONS)


def _traced(trace, instance):
    """A kernel traced, or why it is not."""
    try:
        return trace(instance)
    except Untraceable as error:
        return str(error)


def _why_not(instance, traced, chosen, failing):
    """Why a trace does not pay, if so."""
    size = f"{traced.operations} operations"
    most = MOST_AT_SEA if any(node.op == "solve" for node in traced.graph.nodes) else MOST_OPERATIONS

    if traced.kernel is JACOBIAN:
        by_differences = traced.spent * chosen[0].operations
        in_each_step = instance.m.integrator == STEPPERS["ros2"].number
        most = min(MOST_IN_EACH_STEP if in_each_step else MOST_OF_JACOBIAN, by_differences)

        if traced.operations > by_differences:
            return f"{size} are more than differences take"

        if traced.operations > most:
            return f"{size} would make the library larger than they gain"

    if traced.operations > most:
        return f"{size} would outgrow the instruction cache, loops are faster"

    if sum(map(bool, failing)) > MOST_FAILING * STATES:
        return f"branches change as the scene moves, in {', '.join(sorted(set().union(*failing)))}"

    return ""


def _run(model):
    """An instance at some states of a run that begins at its start."""
    instance = Instance(model)
    span = min(SPAN, model.scene.experiment.stop or SPAN) if model.scene.experiment else SPAN

    for _ in range(STATES):
        instance.step(span / STATES)
        rates.set_time(instance.m, instance.d, 0.0)
        yield instance


def _failing(instance, traced):
    """Where guards fail at the state of a run; of the projection beside it, where a step would lead."""
    m, d = instance.m, instance.d

    if traced.kernel is not PROJECTION:
        return traced.failing(m, d)

    x = d.x.copy()
    d.x[:] += BESIDE * m.x_nominal * np.random.default_rng(1).standard_normal(len(x))
    found = traced.failing(m, d)
    d.x[:] = x
    return found


def scene_library(
    model,
    platform: str | None = None,
    progress: Callable[[str], None] = lambda text: None,
    found: Own | None = None,
    fmi: int = 2,
) -> Path:
    """The library of a model for a platform (by default this machine's), made and kept.

    found : what `own` has found, if that is known already. fmi : the version of FMI that it knows. Raises
    link.LinkError.
    """
    platform = platform or host_platform()
    found = found or own(model)
    text = core(model, found.traced)
    table = header.table_of_kernels(ENTRIES, model.guid)
    suffix = PLATFORMS[platform].suffix
    # tables for exceptions, which C has none of: on Windows its own library has
    less = _NO_UNWINDING if suffix in UNCALLED else ()
    own_flags = (*FLAGS, *(SCALARS if found.is_straight else ()))
    # fmu_src/resource.c
    flags = (*WRAPPER_FLAGS, "-DMBDFMI_ONE_SCENE", *less, *UNCALLED.get(suffix, ()))
    # fmu_src/rest.c
    flags += () if model.rest else ("-DMBDFMI_WITHOUT_REST",)
    made_of = (link.wrapper_hash(), model.guid, text, str(fmi), *own_flags, *flags)
    digest = hashlib.sha256("\0".join(made_of).encode()).hexdigest()[:20]
    path = cache_directory() / "scenes" / f"{digest}-{platform}{suffix}"

    if not path.exists():
        progress(f"compiling for this scene and {platform}")

        with tempfile.TemporaryDirectory() as name, replacing(path) as file:
            source = Path(name) / "scene.c"
            source.write_text(text, encoding="utf-8")
            link.link(PLATFORMS[platform], [source], file, table, (*own_flags, *less), flags, fmi)

    return path
