"""The library of the kernels in process: called right, refused wrong, one for all, and nothing else beside it."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from mbdfmi import load
from mbdfmi.export import link
from mbdfmi.kernels import entry, loops
from mbdfmi.kernels.dynamics import articulated, rates
from mbdfmi.kernels.language import APART, INTERPRETED, JIT
from mbdfmi.native import library
from mbdfmi.native.platforms import host_platform
from mbdfmi.native.sources import source_hash
from mbdfmi.run.instance import Instance

MODELS = Path(__file__).parents[1] / "models"
in_library = pytest.mark.skipif(INTERPRETED or JIT, reason="the library is not used in this process")


@pytest.fixture
def instance():
    """One of a scene with loops, with its inputs set."""
    made = Instance(load(MODELS / "four_bar.toml").compile())
    made.u[: made.model.n_u] = 0.3
    return made


@in_library
@pytest.mark.parametrize(
    "kernel, arguments", [(rates.evaluate, (0.0,)), (articulated.aba, ()), (entry.step, (1e-3,))]
)
def test_kernels_are_what_python_makes_of_them(instance, kernel, arguments):
    """To rounding: results, and all that they write."""
    m, d = instance.m, instance.d
    rates.evaluate(m, d, 0.0)
    before = [d.state_buffer.copy(), d.work_buffer.copy()]
    told = kernel(m, d, *arguments)
    native = [d.state_buffer.copy(), d.work_buffer.copy()]
    d.state_buffer[:], d.work_buffer[:] = before
    assert kernel.__wrapped__(m, d, *arguments) == told

    for found, wanted in zip(native, (d.state_buffer, d.work_buffer)):
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * (1 + np.abs(wanted).max()))


STEPS = """
import sys
from mbdfmi import load
from mbdfmi.kernels import loops
from mbdfmi.kernels.language import APART
from mbdfmi.run.instance import Instance
instance, names, called = Instance(load(sys.argv[1]).compile()), {}, set()
for name, kernel in APART.items():
    names[kernel.__code__] = name
def watch(frame, event, argument):
    if event == "call" and frame.f_code in names:
        called.add(names[frame.f_code])
sys.setprofile(watch)
for _ in range(3):
    instance.step(1e-2)
sys.setprofile(None)
print(*called)
"""


def test_kernels_of_every_step_are_in_one_half():
    """Their names are those of kernels, a step calls no other, and the halves are all there is, once each."""
    ahead = pytest.importorskip("mbdfmi.kernels.ahead")
    first, second = (ahead.half_of(APART, half) for half in ahead.HALVES)
    assert {name.removeprefix("mbdfmi_kernels_") for name in first} == set(ahead.STEPPING)
    assert sorted(first + second) == sorted(APART)

    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "MBDFMI_INTERPRETED": "1"}
    command = [sys.executable, "-c", STEPS, str(MODELS / "spinning_top.toml")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) and set(done.stdout.split()) <= set(first)


@in_library
def test_an_fmu_carries_the_library_of_this_process(monkeypatch, tmp_path):
    """In a cache where another wrapper has left a library of the same kernels."""
    made = link.library(host_platform())
    monkeypatch.setenv("MBDFMI_CACHE", str(tmp_path))
    (tmp_path / "fmu").mkdir()
    old = tmp_path / "fmu" / f"{source_hash()}-0-{host_platform()}{made.suffix}"
    old.write_bytes(b"of another wrapper")
    os.utime(old, (0, 0))
    (tmp_path / "fmu" / made.name).write_bytes(made.read_bytes())
    assert link.library(host_platform()).read_bytes() == library.ready().read_bytes()
    assert set(library.addresses()) >= set(entry.ENTRIES)


@in_library
def test_wrong_arguments_are_refused(instance):
    m, d, y = instance.m, instance.d, instance.y

    with pytest.raises(AttributeError, match="model_addresses"):
        rates.evaluate(d, m, 0.0)

    for wrong in (y.astype(np.float32), np.zeros(2 * len(y))[::2], y.tolist()):
        with pytest.raises(TypeError, match="float64"):
            entry.compute_outputs(m, d, wrong)

    with pytest.raises(TypeError):
        entry.step(m, d)


@in_library
def test_loops_are_the_calls_that_they_stand_for(instance):
    times, n = np.linspace(0.0, 0.1, 11)[1:], instance.model.n_y
    rows = np.zeros((len(times), n))
    assert loops.follow(instance.m, instance.d, times, len(times), instance.y, rows.reshape(-1)) == 0
    other = Instance(instance.model)
    other.u[: other.model.n_u] = 0.3

    for k, time in enumerate(times):
        other.step(time - other.time)
        np.testing.assert_array_equal(rows[k], other.outputs())


PROGRAM = """
import sys
import mbdfmi
results = mbdfmi.load(sys.argv[1]).simulate(0.1)
assert not any(name.startswith(("scipy.spatial", "scipy.interpolate", "scipy.optimize")) for name in sys.modules)
mbdfmi.load(sys.argv[1]).export(sys.argv[2])
print(*{name.partition(".")[0] for name in sys.modules})
"""


@in_library
def test_a_run_and_an_export_import_little(tmp_path):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", PROGRAM, str(MODELS / "pendulum.toml"), str(tmp_path / "a.fmu")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not {"numba", "llvmlite", "fmpy", "matplotlib", "rich", "scipy"} & set(done.stdout.split())


def test_help_imports_next_to_nothing():
    program = "import sys; from mbdfmi.cli.parser import parser; parser(); print(*sys.modules)"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not {"numpy", "pydantic", "scipy", "rich", "numba"} & set(done.stdout.split())


@pytest.mark.skipif(sys.platform == "win32", reason="PATH of a shell")
def test_a_library_that_cannot_be_made(monkeypatch, tmp_path):
    monkeypatch.setenv("MBDFMI_CACHE", str(tmp_path))
    monkeypatch.setattr(library, "PACKAGED", tmp_path)
    monkeypatch.setattr(library.sys, "executable", "/bin/false")

    with pytest.raises(ImportError, match="must be compiled first.*MBDFMI_INTERPRETED=1"):
        library.ready()


def test_two_that_want_it_at_once_make_it_once(monkeypatch, tmp_path):
    """The library that a process loads; the kernels that an export links."""
    monkeypatch.setenv("MBDFMI_CACHE", str(tmp_path))
    monkeypatch.setattr(library, "PACKAGED", tmp_path)
    made = []
    monkeypatch.setattr(library, "find", lambda: made[0] if made else None)
    monkeypatch.setattr(library, "_make", lambda tell: made.append(Path("made")) or made[0])
    assert _at_once(library.ready) == 2 * [Path("made")]
    assert len(made) == 1

    halves = link.aot.HALVES * ["; a module\n"]
    monkeypatch.setattr(link.aot, "compile_kernels", lambda: made.append("kernels") or halves)
    first, second = _at_once(lambda: link.kernels(lambda text: None))
    assert first == second and [path.read_text() for path in first] == halves
    assert made[1:] == ["kernels"]


def _at_once(want):
    """What two threads get that want something at once."""
    begun, got = threading.Barrier(2), []

    def wait_and_want():
        begun.wait()
        got.append(want())

    threads = [threading.Thread(target=wait_and_want) for _ in range(2)]

    for thread in threads:
        thread.start()

    for thread in threads:
        thread.join()

    return got


def test_kernels_one_by_one_by_numba():
    """With MBDFMI_JIT=1, as for work on them."""
    program = """
from mbdfmi.kernels import language
from mbdfmi.kernels.math import algebra
assert language.JIT
print(algebra.cross((1.0, 2.0, 3.0), (4.0, 5.0, 7.0)), len(algebra.cross.signatures))
"""
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(sys.path),
        "MBDFMI_JIT": "1",
        "MBDFMI_INTERPRETED": "",
    }
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    assert done.stdout == "(-1.0, 5.0, -3.0) 1\n", done.stderr
