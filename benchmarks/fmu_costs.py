"""What an FMU costs: its `fmi2DoStep` against the step in process, its export, its size."""

import ctypes
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from mbdfmi.api import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import entry, loops
from mbdfmi.run.instance import Instance

from .problems import PROBLEMS

STEP = 1e-3  # s, of communication
STEPS = 1000
ROUNDS = 15
DRIVEN = "driven"
TIMED = ("double_pendulum_bars", "chain_bars_N7", "A04_bricard_square")


def driven_scene() -> Scene:
    """A scene whose one joint is driven: with nothing to integrate, a step costs what is around it."""
    return Scene(
        name="driven",
        body={"wheel": {"mass": 1.0, "inertia": [1, 1, 1]}},
        joint={"hub": {"revolute": {}, "between": ["ground", "wheel"], "driver": {"constant_speed": 1.0}}},
    )


def moving_scene(name: str) -> Scene:
    """The scene of a problem, by the default stepper at a tolerance of 1e-6."""
    problem = next(problem for problem in PROBLEMS if problem.name == name)
    return Scene.model_validate(problem.scene_tables({"tolerance": 1e-6}))


def fmu_costs(quick: bool, tell: Callable[[str], None]) -> dict:
    """Seconds of CPU of a step of STEP s: `in_process`, `fmu` (both in compiled loops), `fmpy` (called from
    Python), and `added` = fmu - in_process, by scene; `size` in bytes.
    """
    rows = {}

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        for name in (DRIVEN, *(TIMED[:1] if quick else TIMED)):
            tell(f"FMU of {name}")
            scene = driven_scene() if name == DRIVEN else moving_scene(name)
            path = scene.export(Path(folder) / f"{name}.fmu")
            rows[name] = _step_costs(scene, path, 3 if quick else ROUNDS) | {"size": path.stat().st_size}

    return rows


def _step_costs(scene, path, rounds):
    """Both in turns, from the start again each round; the least counts."""
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    description = read_model_description(str(path))
    unzipped = extract(str(path))
    instance = Instance(compile_scene(scene))
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=unzipped,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="timed",
    )
    fmu.instantiate()
    do_step = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int)(
        ctypes.cast(fmu.dll.fmi2DoStep, ctypes.c_void_p).value
    )
    loop = _fmu_loop(do_step)
    best = {"in_process": np.inf, "fmu": np.inf, "fmpy": np.inf}

    def begin():
        fmu.reset()
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()

    def in_process():
        return loops.steps(instance.m, instance.d, STEP, STEPS)

    def native():
        return loop(fmu.component, STEP, STEPS)

    def from_python():
        for k in range(STEPS):
            fmu.doStep(k * STEP, STEP)

        return 0

    try:
        for _ in range(rounds + 1):
            for name, run in (("in_process", in_process), ("fmu", native), ("fmpy", from_python)):
                entry.initialise(instance.m, instance.d, 0.0)
                begin()
                start = time.process_time()
                failure = run()
                seconds = time.process_time() - start

                if failure:
                    raise RuntimeError(f"{path.name}: a step fails ({name})")

                best[name] = min(best[name], seconds / STEPS)
    finally:
        fmu.freeInstance()
        shutil.rmtree(unzipped, ignore_errors=True)

    return best | {"added": best["fmu"] - best["in_process"]}


def _fmu_loop(do_step):
    """n communication steps of an FMU, without Python in between."""
    import numba

    @numba.njit
    def loop(component, H, n):
        for k in range(n):
            failure = do_step(component, k * H, H, 1)

            if failure != 0:
                return failure

        return 0

    return loop


def export_costs(quick: bool, tell: Callable[[str], None]) -> dict:
    """Seconds of an export: `in_process` (kernels compiled, Python running), and by the command, CPU and wall
    time of a `warm` one and, unless quick, of a `cold` one, whose cache is empty.
    """
    scene = moving_scene(TIMED[0])
    rows = {}

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder) / "exported.fmu"
        file = Path(folder) / "scene.toml"
        file.write_text(scene.to_toml(), encoding="utf-8")
        scene.export(path)
        spans = []

        for _ in range(3):
            start = time.perf_counter()
            scene.export(path)
            spans.append(time.perf_counter() - start)

        rows["in_process"] = {"wall_s": min(spans)}

        if not quick:
            cache = {"MBDFMI_CACHE": str(Path(folder) / "cache")}
            tell("first export, with an empty cache (a minute or two)")
            rows["cold"] = _command_cost(file, path, cache)
            tell("the same again")
            rows["warm"] = _command_cost(file, path, cache)

    return rows


def _command_cost(file, path, variables):
    before, start = os.times(), time.perf_counter()
    command = [sys.executable, "-m", "mbdfmi", "export", str(file), "-o", str(path)]
    done = subprocess.run(command, env=os.environ | variables, capture_output=True, text=True)
    wall, after = time.perf_counter() - start, os.times()

    if done.returncode:
        raise RuntimeError(f"mbdfmi export: {done.stderr.strip()}")

    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return {"wall_s": wall, "cpu_s": cpu}
