"""Kernels translated to C99 for a scene: random scenes, every kind of element, to the bit beside the library of all scenes."""

import subprocess
import sys

import numpy as np
import pytest

import mbdfmi
from mbdfmi.export.core import core
from mbdfmi.export.header import table_of_kernels
from mbdfmi.kernels import language
from mbdfmi.kernels.entry import ENTRIES
from mbdfmi.native.platforms import PLATFORMS, host_platform
from mbdfmi.run.instance import Entries, Instance, SimulationError
from mbdfmi.trace.graph import Untraceable
from mbdfmi.trace.program import shapes
from mbdfmi.trace.program.helpers import HELPERS
from tests.referee import generator

compiled_kernels = pytest.mark.skipif(
    language.INTERPRETED or language.JIT, reason="what is translated is compared with the compiled library"
)


def library_of(model, folder):
    """The entries of a model as the translated kernels, none of them traced, compiled without optimising."""
    (folder / "scene.c").write_text(core(model))
    (folder / "table.c").write_text(table_of_kernels(ENTRIES, model.guid))
    command = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        "-target",
        PLATFORMS[host_platform()].target,
        "-std=c99",
    ]
    command += ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-ffp-contract=off", "-fPIC", "-shared"]
    made = ["scene.c", "table.c", "-lm", "-o", "scene.so"]
    subprocess.run([*command, "-Wno-missing-prototypes", *made], check=True, cwd=folder)
    return Entries.of(folder / "scene.so")


def runs_alike(model, entries, steps=20, step=0.005):
    """Steps until one of two runs fails, as the other then must."""
    runs = [Instance(model), Instance(model, kernels=entries)]
    random = np.random.default_rng(1)

    for _ in range(steps):
        given = random.standard_normal(model.n_u)
        told = []

        for run in runs:
            run.u[: model.n_u] = given if model.n_command == 0 else run.u[: model.n_u]

            try:
                run.step(step)
                told.append(run.outputs().tobytes())
            except SimulationError as error:
                told.append(str(error))

        assert told[0] == told[1]
        assert runs[0].d.state_buffer.tobytes() == runs[1].d.state_buffer.tobytes()


@compiled_kernels
@pytest.mark.parametrize(
    "seed", [14, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(11, 30) if seed != 14)]
)
def test_random_scenes_give_the_same_bits(seed, tmp_path):
    try:
        scene = mbdfmi.Scene(**generator.draw(seed))
        model = scene.compile(as_given=True)
        Instance(model)
    except SimulationError as error:
        pytest.skip(f"no start: {error}")

    runs_alike(model, library_of(model, tmp_path))


def test_whole_numbers_are_divided_as_python_divides_them(tmp_path):
    pairs = [(7, 3), (-7, 3), (7, -3), (-7, -3), (6, 3), (-6, 3), (0, 5)]
    holds = [f"whole_quotient({a}, {b}) == {a // b} && whole_rest({a}, {b}) == {a % b}" for a, b in pairs]
    parts = ["#include <stdint.h>", HELPERS["whole_quotient"], HELPERS["whole_rest"]]
    parts.append(f"int main(void)\n{{\n    return !({' && '.join(holds)});\n}}\n")
    (tmp_path / "one.c").write_text("\n\n".join(parts))
    command = [sys.executable, "-m", "ziglang", "cc", "-w", "one.c", "-o", "one"]
    subprocess.run(command, check=True, cwd=tmp_path)
    subprocess.run([str(tmp_path / "one")], check=True)


def test_what_is_known_of_whole_numbers_is_followed():
    two, three = shapes.number(2), shapes.number(3)
    either = shapes.join(two, three)
    assert either.values == {2, 3} and either.only is None
    assert shapes.computed("bool", lambda a, b: a < b, either, shapes.number(4)).only is True
    assert shapes.computed("bool", lambda a, b: a < b, either, shapes.number(3)).only is None
    assert shapes.join(two, shapes.ANY_REAL) == shapes.ANY_REAL
    many = shapes.number(0)

    for k in range(shapes.MOST_VALUES + 1):
        many = shapes.join(many, shapes.number(k))

    assert many.values is None

    with pytest.raises(Untraceable):
        shapes.join(two, shapes.Array("real"))
