"""Absurd values, files and states: an answer in time, or a refusal, and never a number that is none."""

import math
import os
import struct
import subprocess
import sys
import threading
import time
import zlib
from pathlib import Path
from queue import Empty, Queue

import fmu_host
import numpy as np
import pytest
from fmu_host import ERROR, OK, Instance, Library

from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.export.resource import resource
from mbdfmi.kernels.status import MESSAGES
from mbdfmi.scene import read_scene
from tests.model_files import SCENES

MODELS = Path(__file__).parents[1] / "models"
VALUES = [1e12, 1e30, 1e300, -1e30]
STEPS = [1e-300, 1e300]
ALLOWED = (
    30.0  # s of the processor, that a case may take: 10 are meant, on a machine that is not held up by others
)
HANGS = 120.0  # s, after which a case is given up
HEAD = 24  # bytes of a resource file before what its checksum is of
HEAD_OF_STATE = 8 + 16 + 24 + 64  # bytes of a serialised state before its core


def model_of(name):
    return compile_scene(read_scene(next(MODELS.rglob(f"{name}.toml"))))


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """That of the pendulum: it is the same for every scene, only the resource file is another."""
    folder = tmp_path_factory.mktemp("pendulum")
    return Library(export_fmu(model_of("pendulum"), folder / "pendulum.fmu"), folder / "pendulum")


def instance_of(library, folder, model, data):
    """An instance of another model in the same library."""
    folder.mkdir(exist_ok=True)
    (folder / "model.bin").unlink(missing_ok=True)
    (folder / "model.bin").write_bytes(data)
    return Instance(library, location=folder.as_uri().encode(), guid=model.guid.encode(), logging=False)


# values, in a process of its own for each model


def read(instance, references):
    status, values = instance.get(*references)
    assert status == ERROR or all(map(math.isfinite, values)), "not finite with fmi2OK"


def try_value(instance, when, what, value):
    """A variable set to a value before the start or between two steps."""
    known = [v.valueReference for v in instance.library.variables.values()]
    assert instance.reset() == OK

    if when == "start" and instance.set({what: value}) != OK:
        return
    if instance.setup() != OK or instance.enter() != OK or instance.exit() != OK:
        return
    if when == "later" and (instance.step(0.0, 1e-3) != OK or instance.set({what: value}) != OK):
        return

    t = 1e-3 if when == "later" else 0.0
    read(instance, known)
    stepped = instance.step(t, 1e-3)
    read(instance, known)

    if stepped == fmu_host.DISCARD:
        status, ended = instance.last_successful_time()
        assert status == OK and t <= ended <= t + 1e-3, f"last successful time {ended!r}"
        assert instance.terminated() == (OK, 1), "a failed step that does not ask for the end"


def try_step(instance, H):
    assert instance.reset() == OK
    instance.start()
    instance.step(0.0, 1e-3)
    instance.step(1e-3, H)
    read(instance, instance.library.references("output"))


def cases(library):
    settable = [*library.references("input"), *library.references("parameter")]
    yield from (
        (try_value, when, k, value) for k in settable for when in ("start", "later") for value in VALUES
    )
    yield from ((try_step, H) for H in STEPS)


def run_cases(fmu, folder, first, every):
    """One line when a case begins, and one when it goes wrong."""
    instance = Instance(Library(Path(fmu), Path(folder)), logging=False)

    for n, (function, *arguments) in enumerate(cases(instance.library)):
        if n < first or n % every:
            continue
        instance.log.clear()
        print(f"{n} {function.__name__} {arguments}", flush=True)
        began = time.process_time()
        try:
            function(instance, *arguments)
        except AssertionError as error:
            print(f"WRONG {error}", flush=True)
        if (took := time.process_time() - began) > ALLOWED:
            print(f"WRONG {took:.0f} s", flush=True)

    print("all", flush=True)


def faults(fmu, folder, every):
    """What went wrong in a run of the cases; one that hangs or crashes ends its process, and the next goes on."""
    found, first, case = [], 0, None

    while True:
        command = [sys.executable, __file__, str(fmu), str(folder), str(first), str(every)]
        child = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        )
        lines = Queue()
        threading.Thread(
            target=lambda: [lines.put(line.strip()) for line in child.stdout] + [lines.put(None)], daemon=True
        ).start()
        before = case

        while True:
            try:
                line = lines.get(timeout=HANGS)
            except Empty:
                child.kill()
                found.append(f"{case}: no answer within {HANGS:g} s")
                break
            if line is None:
                found.append(f"{case}: the process ended")
                break
            if line == "all":
                child.wait()
                return found
            if line.startswith("WRONG"):
                found.append(f"{case}: {line}")
            else:
                case = line

        child.wait()
        if case == before:
            return found
        first = int(case.split()[0]) + 1


@pytest.mark.parametrize(
    "name, every", [("two_link_arm", 7), ("cam_follower", 29), ("pendulum", 11), ("satellite", 17)]
)
def test_absurd_values(tmp_path, name, every):
    assert not faults(export_fmu(model_of(name), tmp_path / "x.fmu"), tmp_path / "x", every)


@pytest.mark.long
@pytest.mark.parametrize("name", [path.stem for path in SCENES])
def test_absurd_values_of_every_variable(tmp_path, name):
    assert not faults(export_fmu(model_of(name), tmp_path / "x.fmu"), tmp_path / "x", 1)


# resource files and states with a mended checksum


def mended(data, at, value):
    """A resource file with another number in its body, and the checksum that goes with it."""
    body = bytearray(data[HEAD:])
    struct.pack_into("<q", body, at, value)
    return data[:12] + struct.pack("<I", zlib.crc32(body)) + data[16:HEAD] + bytes(body)


@pytest.mark.parametrize("name", ["two_link_arm", "four_bar", "cam_follower", "floating_wind_turbine"])
def test_wrong_numbers_in_a_resource_are_refused(library, tmp_path, name):
    """Whatever number of a model is changed, its size, structure or parameters: nothing of it reaches the kernels."""
    model = model_of(name)
    data = resource(model, MESSAGES)
    rng = np.random.default_rng(1)
    instance = instance_of(library, tmp_path / name, model, data)
    assert instance.component
    instance.free()
    places = [8 * k for k in range(7)] + [
        144 + 8 * int(k) for k in rng.integers(len(model.ints) + len(model.reals), size=60)
    ]

    for at in places:
        old = struct.unpack_from("<q", data, HEAD + at)[0]
        for value in {old ^ 1, old + 1, -1, 2**40, int(rng.integers(1000))} - {old}:
            instance = instance_of(library, tmp_path / name, model, mended(data, at, value))
            assert instance.component is None, (at, value)
            assert "is refused: " in instance.message


@pytest.mark.parametrize("name", ["two_link_arm", "four_bar", "bricard"])
@pytest.mark.parametrize(
    "values", [[math.nan, math.inf, 0.5, -1.0], pytest.param([-1e300, 1e18], marks=pytest.mark.long)]
)
def test_absurd_states_are_refused_or_harmless(library, tmp_path, name, values):
    """A state with a mended checksum and an absurd number in it: refused, or what follows is finite or fails."""
    model = model_of(name)
    instance = instance_of(library, tmp_path / name, model, resource(model, MESSAGES)).start()
    outputs = [model.n_u + k for k in range(model.n_y)]
    assert instance.step(0.0, 0.01) == OK
    data = instance.serialise(instance.save())
    n = (len(data) - HEAD_OF_STATE) // 8
    rng = np.random.default_rng(2)

    for k in {*range(60), *map(int, rng.integers(n, size=150))} & set(range(n)):
        for value in values:
            body = bytearray(data[HEAD_OF_STATE:])
            struct.pack_into("<d", body, 8 * k, value)
            head = data[:20] + struct.pack("<I", zlib.crc32(body)) + data[24:HEAD_OF_STATE]
            status, snapshot = instance.deserialise(head + bytes(body))
            if status != OK:
                assert "the serialised state is refused" in instance.message
                continue

            assert instance.restore(snapshot) == OK
            read(instance, outputs)
            instance.step(0.01, 0.01)
            read(instance, outputs)
            instance.forget(snapshot)


if __name__ == "__main__":
    run_cases(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
