"""Fixtures of all tests."""

import ctypes
import os
import time
import warnings

import numpy as np
import pytest
from fmpy import fmi2

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance


@pytest.fixture(autouse=True, scope="session")
def home():
    """The folder that tests are run in."""
    return os.getcwd()


@pytest.fixture(autouse=True)
def stays_in_its_folder(home, request):
    """FMPy stays in the folder of a library that does not load: the test is named, and those after it are not lost."""
    yield

    try:
        left = os.getcwd()
    except FileNotFoundError:
        left = "a folder that is gone"

    if left != home:
        os.chdir(home)
        warnings.warn(f"{request.node.nodeid} left the process in {left}", stacklevel=1)


@pytest.fixture
def check(record_property):
    """A function check(error, allowed) that also writes the error down (pytest --junitxml)."""

    def check(error, allowed):
        record_property("error", f"{error:.1e}")
        assert error < allowed

    return check


@pytest.fixture
def run(record_property):
    """A function run(scene, times) -> outputs by name (times, components), arrays as one; scalars (times,)."""

    def run(scene, times, parameters=None):
        instance = Instance(compile_scene(Scene.model_validate(scene)), parameters)
        began = time.process_time()
        rows = []

        for t in times:
            if t > instance.time:
                instance.step(t - instance.time)

            rows.append(instance.outputs().copy())

        record_property("cpu_s", round(time.process_time() - began, 3))
        record_property("steps", int(instance.d.steps[0]))
        names = [v.name.partition("[")[0] for v in instance.model.of_causality("output")]
        rows = np.array(rows)
        columns = {
            name: [k for k, other in enumerate(names) if other == name] for name in dict.fromkeys(names)
        }
        return {name: rows[:, k[0]] if len(k) == 1 else rows[:, k] for name, k in columns.items()}

    return run


@pytest.fixture
def fmpy_log():
    """(texts, a logger for FMPy that appends to them).

    FMPy keeps the last logger for all runs that follow, those without one too, even after it is gone: here it
    gets its own again.
    """
    texts = []
    yield texts, lambda *message: texts.append(message[-1].decode())
    fmi2.defaultCallbacks.logger = fmi2.fmi2CallbackLoggerTYPE(fmi2.printLogMessage)
    fmi2.addLoggerProxy(ctypes.byref(fmi2.defaultCallbacks))
