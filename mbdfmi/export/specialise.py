"""A library of one scene: compiled from the scene's own code (`core`), x' = f traced where that pays (docs/specialise.md).

It knows no other scene: its wrapper refuses a model of another GUID.
"""

import hashlib
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..files import replacing
from ..kernels.dynamics import rates
from ..kernels.entry import ENTRIES
from ..native.platforms import PLATFORMS, host_platform
from ..native.sources import cache_directory
from ..run.instance import Instance, SimulationError
from ..trace.graph import Untraceable
from ..trace.specialise import Traced, trace_rates
from . import header, link
from .core import core

MOST_OPERATIONS = 3000
"""Operations of a trace at most: about 32 kB of code, the instruction cache. Beyond it loops are faster."""

STATES = 16
"""States of a run at the start of the scene in which the guards of its trace are looked at."""

SPAN = 1.0
"""s, of that run, at most."""

MOST_FAILING = 0.25
"""Part of these states in which a guard may fail."""

_NO_UNWINDING = ("-fno-asynchronous-unwind-tables", "-fno-unwind-tables")

FLAGS = ("-O3", "-fno-math-errno", *_NO_UNWINDING)
"""Of the compiler: square roots without a look at `errno`, no tables for exceptions, which C has none of."""

WRAPPER_FLAGS = ("-Os", *_NO_UNWINDING)
"""Of the compiler, for the wrapper, whose time does not count."""


@dataclass(frozen=True)
class Own:
    """What is a scene's own. traced : x' = f, or None where the generic kernel is better. told : in words."""

    traced: Traced | None
    told: str


def own(model) -> Own:
    """x' = f of a model traced where that pays, and what is to be said of it."""
    try:
        instance = Instance(model)
        run = _run(model, instance)
        next(run)
        traced = trace_rates(instance)
        failing = [places for places in (traced.failing(one.m, one.d) for one in run) if places]
    except (Untraceable, SimulationError) as error:
        return Own(None, f"x' = f is not traced: {error}")

    size = f"{traced.operations} operations"

    if traced.operations > MOST_OPERATIONS:
        return Own(
            None, f"x' = f is not traced: {size} would outgrow the instruction cache, loops are faster"
        )

    if len(failing) > MOST_FAILING * STATES:
        places = ", ".join(sorted(set().union(*failing)))
        return Own(None, f"x' = f is not traced: branches change as the scene moves, in {places}")

    return Own(traced, f"x' = f is traced, {size}")


def _run(model, instance):
    """The instance at some states of a run that begins at its start."""
    span = min(SPAN, model.scene.experiment.stop or SPAN) if model.scene.experiment else SPAN

    for _ in range(STATES):
        instance.step(span / STATES)
        rates.set_time(instance.m, instance.d, 0.0)
        yield instance


def scene_library(
    model,
    platform: str | None = None,
    progress: Callable[[str], None] = lambda text: None,
    found: Own | None = None,
) -> Path:
    """The library of a model for a platform (by default this machine's), made and kept.

    found : what `own` has found, if that is known already. Raises link.LinkError.
    """
    platform = platform or host_platform()
    found = found or own(model)
    text = core(model, found.traced)
    table = header.table_of_kernels(ENTRIES, model.guid)
    digest = hashlib.sha256("\0".join([link.wrapper_hash(), model.guid, text, *FLAGS]).encode()).hexdigest()[
        :20
    ]
    path = cache_directory() / "scenes" / f"{digest}-{platform}{PLATFORMS[platform].suffix}"

    if not path.exists():
        progress(f"compiling for this scene and {platform}")

        with tempfile.TemporaryDirectory() as name, replacing(path) as file:
            source = Path(name) / "scene.c"
            source.write_text(text, encoding="utf-8")
            link.link(PLATFORMS[platform], [source], file, table, FLAGS, WRAPPER_FLAGS)

    return path
