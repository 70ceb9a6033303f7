"""Scenes as equations: what is written in C, numpy, sympy and casadi computes x' and y of the kernels."""

import ctypes
import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mbdfmi
from mbdfmi.cli import main
from mbdfmi.kernels.dynamics import rates
from mbdfmi.native.platforms import PLATFORMS, host_platform
from mbdfmi.run.instance import Instance
from mbdfmi.trace import forms
from mbdfmi.trace.functions import derivatives
from mbdfmi.trace.graph import Untraceable

MODELS = Path(__file__).parents[1] / "models"
SOME = ["two_link_arm", "four_bar", "cam_follower", "rattleback", "satellite"]


def instance_of(name):
    return Instance(mbdfmi.load(MODELS / f"{name}.toml").compile())


def module(text, path):
    """A text as a module."""
    path.write_text(text, encoding="utf-8")
    return imported(path)


def imported(path):
    """The module of a file."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def there(instance, x, u):
    """(x', y) of the kernels."""
    instance.d.x[:], instance.u[: len(u)] = x, u
    assert rates.evaluate(instance.m, instance.d, 0.0) == 0
    found = instance.d.x_rate.copy()
    instance.d.x[:] = x
    return found, instance.outputs().copy()


def places(instance, n=5):
    """(x, u) near the start."""
    random = np.random.default_rng(3)
    x = instance.d.x.copy()

    for _ in range(n):
        yield x + 0.02 * random.standard_normal(len(x)), random.standard_normal(instance.model.n_u)


@pytest.mark.parametrize("name", SOME)
def test_functions_in_numpy_are_the_kernels(name, tmp_path, check):
    scene = mbdfmi.load(MODELS / f"{name}.toml")
    found = module(scene.equations().text("numpy"), tmp_path / "found.py")
    instance = instance_of(name)

    for x, u in places(instance):
        x_rate, y = there(instance, x, u)
        check(np.abs(found.rates(0.0, x, u) - x_rate).max() / np.abs(x_rate).max(), 1e-12)
        check(np.abs(found.outputs(0.0, x, u) - y).max() / np.abs(y).max(), 1e-12)

    # numbers along a further axis
    many = np.stack([x for x, _ in places(instance)], axis=1)
    assert found.rates(0.0, many, np.zeros(instance.model.n_u)).shape == many.shape


@pytest.mark.parametrize("name", SOME)
def test_functions_in_C_are_the_kernels(name, tmp_path, check):
    equations = mbdfmi.load(MODELS / f"{name}.toml").equations(derivatives=True)
    source, library = tmp_path / "found.c", tmp_path / "found.so"
    source.write_text(equations.text("c"), encoding="utf-8")
    target = PLATFORMS[host_platform()].target
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wmissing-prototypes", "-Werror"]
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target, "-std=c99", "-O1", *warnings]
    subprocess.run([*command, "-fPIC", "-shared", str(source), "-lm", "-o", str(library)], check=True)
    native = ctypes.CDLL(str(library))
    p = np.array(equations.p)
    instance = instance_of(name)

    def call(function, t, x, u, n):
        result = np.zeros(n)
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in (x, u, p, result)]
        getattr(native, function)(ctypes.c_double(t), *pointers)
        return result

    for x, u in places(instance, 2):
        x_rate, y = there(instance, x, u)
        check(np.abs(call("rates", 0.0, x, u, len(x)) - x_rate).max() / np.abs(x_rate).max(), 1e-12)
        check(np.abs(call("outputs", 0.0, x, u, len(y)) - y).max() / np.abs(y).max(), 1e-12)
        instance.d.x[:] = x
        exact = derivatives(instance).A
        A = call("rates_by_states", 0.0, x, u, exact.size).reshape(exact.shape)
        check(np.abs(A - exact).max() / np.abs(exact).max(), 1e-11)


@pytest.mark.parametrize(
    ("name", "form"), [("two_link_arm", "sympy"), ("two_link_arm", "casadi"), ("four_bar", "casadi")]
)
def test_expressions_are_the_kernels(name, form, tmp_path, check):
    package = pytest.importorskip(form)
    found = module(mbdfmi.load(MODELS / f"{name}.toml").equations().text(form), tmp_path / f"{form}_found.py")
    instance = instance_of(name)

    if form == "sympy":
        listed = [found.t, *found.x, *found.u, *found.p]
        function = package.lambdify(listed, [*found.rates])

        def call(x, u):
            return np.array(function(0.0, *x, *u, *found.P), float)
    else:

        def call(x, u):
            return np.array(found.rates(0.0, x, u, found.P)).ravel()

    for x, u in places(instance, 2):
        x_rate, _ = there(instance, x, u)
        check(np.abs(call(x, u) - x_rate).max() / np.abs(x_rate).max(), 1e-12)


def test_parameters_are_free_as_asked(tmp_path, check):
    scene = mbdfmi.load(MODELS / "two_link_arm.toml")
    assert scene.equations([]).parameters == []
    assert scene.equations(["lower.inertia"]).parameters == [f"lower.inertia[{k}]" for k in range(1, 7)]

    found = module(scene.equations(["lower.mass"]).text("numpy"), tmp_path / "found.py")
    heavy = Instance(scene.compile(), {"lower.mass": 2.5})
    x, u = heavy.d.x.copy(), heavy.u[:2].copy()
    check(np.abs(found.rates(0.0, x, u, [2.5]) - there(heavy, x, u)[0]).max(), 1e-11)

    with pytest.raises(KeyError, match=r"did you mean 'lower\.mass'"):
        scene.equations(["lower.mas"])


def test_names_are_identifiers_and_differ():
    taken = {"x"}
    names = ["elbow.state_angle", "elbow.angle", "state_q", "x", "lambda", "größe", "t1", "2nd"]
    found = forms.identifiers(names, taken)
    assert all(name.isascii() and name.isidentifier() for name in found)
    assert len({*found, "x"}) == len(names) + 1
    assert found[0] == "elbow_angle"


def test_what_a_language_cannot_say_is_told():
    with pytest.raises(Untraceable, match="tables.*--numpy"):
        mbdfmi.load(MODELS / "cam_follower.toml").equations().text("sympy")


def test_the_command_writes_them(tmp_path, capsys):
    scene, target = str(MODELS / "two_link_arm.toml"), tmp_path / "arm.c"
    assert main(["equations", scene, "--c", "--derivatives", "-o", str(target)]) == 0
    assert "void rates_by_states(" in target.read_text(encoding="utf-8")
    capsys.readouterr()
    assert main(["equations", scene, "--numpy", "--bind", "--no-outputs"]) == 0
    text = capsys.readouterr().out
    assert "def rates(" in text and "def outputs(" not in text and "PARAMETERS = ()" in text
    assert main(["equations", scene, "--sympy", "--derivatives"]) == 1
    assert "sympy differentiates by itself" in capsys.readouterr().err


@pytest.mark.long
def test_a_swing_up_planned_on_equations_is_what_the_FMU_does(check):
    pytest.importorskip("casadi")
    folder = MODELS / "cart_pole"
    plan = imported(folder / "swing_up.py")
    scene = mbdfmi.load(folder / "cart_pole.toml")
    times, states, forces = plan.swing_up(scene)
    seen = plan.replay(scene, times, forces)
    check(np.abs(seen - states[:, :2]).max(), 1e-7)
    check(abs(seen[-1, 1] - np.pi), 1e-7)


def test_what_ends_as_the_scene_moves_is_said_in_words(tmp_path, capsys):
    hull = tmp_path / "hull.c"
    assert (
        main(["equations", str(MODELS / "floating_crane.toml"), "--c", "--no-outputs", "-o", str(hull)]) == 0
    )
    told = capsys.readouterr()
    head = hull.read_text(encoding="utf-8").partition("*/")[0]
    assert "hold only as long as" in told.err and "panels of hulls" in told.err
    assert "panels of hulls" in head and not re.search(r"line \d|\w\.\w+\.\w+", head)

    other = tmp_path / "pendulum.c"
    assert main(["equations", str(MODELS / "pendulum.toml"), "--c", "-o", str(other)]) == 0
    assert "hold only" not in capsys.readouterr().err
