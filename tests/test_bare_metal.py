"""A scene's own code on a Cortex-M7 without an operating system, emulated: what it computes, and what it costs."""

import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

import mbdfmi
from mbdfmi.export import sources, specialise
from mbdfmi.run.instance import Instance

HERE = Path(__file__).parent
MODELS = HERE.parent / "models"
COMPILER, SIZE, EMULATOR = "arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm"
PROCESSOR = ["-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16"]
FLAGS = [*PROCESSOR, "-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off"]
FLAGS += ["-fno-math-errno", "-ffunction-sections", "-fdata-sections"]
STEPS, H = 500, 1e-3
PER_TICK = 40  # instructions: the emulator counts one a ns, and the clock ticks at 25 MHz

pytestmark = pytest.mark.long


def run_on_it(name, folder):
    """(run in process, words that the program tells, bytes of flash) of a scene by rk4."""
    missing = [tool for tool in (COMPILER, SIZE, EMULATOR) if not shutil.which(tool)]

    if missing:
        pytest.skip(f"{', '.join(missing)} not installed: apt-get install gcc-arm-none-eabi qemu-system-arm")

    scene = mbdfmi.load(MODELS / f"{name}.toml")
    scene.solver = {"integrator": "rk4", "step": H}
    model = scene.compile()
    of_the_fmu = sources.sources(model, 2, specialise.own(model).traced)

    for file in ("scene.c", "scene.h"):
        (folder / file).write_bytes(of_the_fmu[f"{sources.FOLDER}/{file}"])

    files = [str(HERE / "bare_metal.c"), "scene.c"]
    defined = [f"-DSTEPS={STEPS}", f"-DSTEP_SIZE={H}", f"-I{folder}", "-Wno-array-bounds"]
    linked = ["-nostartfiles", "-T", str(HERE / "bare_metal.ld"), "-Wl,--gc-sections", "-lm", "-lc"]
    subprocess.run([COMPILER, *FLAGS, *defined, *files, *linked, "-o", "scene.elf"], check=True, cwd=folder)
    machine = ["-machine", "mps2-an500", "-nographic", "-semihosting", "-icount", "shift=0"]
    found = subprocess.run(
        [EMULATOR, *machine, "-kernel", "scene.elf"], cwd=folder, capture_output=True, text=True, timeout=300
    )
    words: dict[str, list[int]] = {}

    for line in (found.stdout + found.stderr).splitlines():
        word, _, value = line.partition(" ")
        words.setdefault(word, []).append(int(value, 16))

    sizes = subprocess.run([SIZE, "scene.elf"], check=True, cwd=folder, capture_output=True, text=True).stdout
    text, data, *_ = map(int, sizes.splitlines()[1].split()[:3])
    instance = Instance(model)

    for _ in range(STEPS):
        instance.step(H)

    return instance, words, text + data


# kB of flash with the mathematics library, of RAM, of stack, thousands of instructions a step, at most
COSTS = {"pendulum": (24, 6, 1, 1.5), "double_pendulum": (32, 8, 1, 4), "four_bar": (60, 13, 3, 12)}


@pytest.mark.parametrize("name", COSTS)
def test_a_cortex_m7_computes_the_same_in_little_room(name, tmp_path):
    instance, words, flash = run_on_it(name, tmp_path)
    y = np.array([struct.unpack("<d", struct.pack("<Q", bits))[0] for bits in words["y"]])
    each = PER_TICK * words["ticks"][0] / STEPS / 1000
    most = PER_TICK * words["most"][0] / 1000
    ram, stack = words["ram"][0], words["stack"][0]
    print(
        f"\n{name}: flash {flash / 1024:.1f} kB, RAM {ram / 1024:.1f} kB, stack {stack / 1024:.2f} kB, "
        f"{each:.2f} thousand instructions a step of rk4, at most {most:.2f}"
    )
    assert words["status"] == [0]
    np.testing.assert_allclose(y, instance.outputs(), rtol=1e-9, atol=1e-12)
    assert all(
        found <= bound
        for found, bound in zip((flash / 1024, ram / 1024, stack / 1024, each), COSTS[name], strict=True)
    )
