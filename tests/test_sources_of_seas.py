"""Own code and sources of scenes with waves, lines of sections, damping and gusts: without a warning, and what the binary FMU gives.

Five scenes have all keys of these between them; each is compiled by gcc and by clang, one of them in a long test.
"""

import shutil
import subprocess
import zipfile
from functools import cache

import fmpy
import numpy as np
import pytest
from test_composite_lines import BUOYED, ROUGH
from test_gusts import mill
from test_hydrodynamics import OUTPUTS, SEA, afloat, database  # noqa: F401
from test_sources import COMPILERS, HEADERS, STRICT
from test_waves_at_members import DRAWN

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu, sources
from mbdfmi.kernels import language
from mbdfmi.native.platforms import PLATFORMS, host_platform

pytestmark = pytest.mark.skipif(
    language.INTERPRETED or language.JIT, reason="sources stand beside the compiled library"
)

STEPPED = {"integrator": "rk54", "tolerance": 1e-7}
START = {"position": [0, 0, 0.3], "zyx_deg": [3, 2, -4], "velocity": [0.5, 0, 0]}
FULL = np.random.default_rng(4).normal(size=(6, 6))
DAMPED = {"damping": (1e4 * FULL @ FULL.T).tolist(), "quadratic": [1e4, 1e4, 2e4, 3e5, 3e5, 3e5]}
FORCES = ["tension", "anchor_tension", "grounded_length", "power"]


def moored(scene, lines, **more):
    """A scene of a hull with lines of sections: name -> (anchor, line)."""
    data = scene.model_dump(exclude_unset=True)
    anchors = {name: {"position": anchor} for name, (anchor, _) in lines.items()}
    data["ground"] = {"marker": anchors}
    data["force"] |= {
        name: {"catenary": line, "between": [f"ground.{name}", "hull"], "output": FORCES}
        for name, (_, line) in lines.items()
    }
    return Scene.model_validate(data | more)


def where_it_is(file, folder):
    """Waves where the hull is, damping about a point of reference, lines with weight, buoy and friction."""
    lines = {"east": ([440, 60, -60], BUOYED), "west": ([-440, -60, -60], ROUGH)}
    options = {"position": "now", "reference": [3.0, -2.0, 1.0]} | DAMPED
    return moored(afloat(file, START, SEA, STEPPED, outputs=[*OUTPUTS, "damping_force"], **options), lines)


def from_elsewhere(file, folder):
    """A sea that is an input, coefficients enlarged, a gust over time at a rotor, a line of one section on a rough bed."""
    line = {"length": 473.0, "mass": 130.4, "diameter": 0.0809, "stiffness": 589e6, "friction": 1.0}
    scene = afloat(file, START, None, STEPPED, outputs=[], excitation="input", froude=1.5, **DAMPED)
    gust = {"table": {"time": [0.0, 0.4, 1.0], "velocity": [[0, 0, 0], [3, 1, 0], [1, 0, 0]]}}
    mill_of = mill(folder, gust).model_dump(exclude_unset=True)
    rotor = mill_of["force"]["sail"] | {"on": "hull"}
    forces = scene.model_dump(exclude_unset=True)["force"] | {"sail": rotor}
    lines = {"east": ([440, 60, -60], line)}
    return moored(
        scene.model_copy(update={"force": forces}), lines, wind=mill_of["wind"], sea={"depth": 60.0}
    )


def stretched(file, folder):
    """Waves that members feel up to the surface, a hull that waits for them, a smooth step of the wind."""
    sea = {"waves": DRAWN, "depth": 60, "stretching": "wheeler", "output": ["elevation"]}
    data = afloat(file, START, sea, STEPPED, outputs=OUTPUTS).model_dump(exclude_unset=True)
    mill_of = mill(folder, {"step": {"velocity": [1, 2, 3], "start": 0.2, "rise": 0.5}}).model_dump(
        exclude_unset=True
    )
    data["body"]["hull"]["marker"] = {"keel": {"position": [0, 3, -12]}, "deck": {"position": [0, 3, 4]}}
    data["force"] |= {
        "leg": {
            "member": {"diameter": 2.0, "sections": 4, "drag": 1.0},
            "between": ["hull.keel", "hull.deck"],
            "output": ["force", "power"],
        },
        "sail": mill_of["force"]["sail"] | {"on": "hull"},
    }
    return Scene.model_validate(data | {"wind": mill_of["wind"]})


def turning(file, folder):
    """A ship that turns, and a member that waves meet where it is."""
    scene = afloat(file, START, SEA, STEPPED, outputs=OUTPUTS, axes="heading", **DAMPED)
    data = scene.model_dump(exclude_unset=True)
    data["body"]["hull"]["marker"] = {"keel": {"position": [0, 3, -12]}, "deck": {"position": [0, 3, 4]}}
    leg = {"member": {"diameter": 2.0, "sections": 4, "drag": 1.0, "position": "now"}}
    data["force"] |= {"leg": leg | {"between": ["hull.keel", "hull.deck"], "output": ["force"]}}
    return Scene.model_validate(data)


def operating(file, folder):
    """An extreme operating gust."""
    return mill(folder, {"eog": {"start": 0.1, "amplitude": 3.0, "period": 0.8}})


SCENES = {made.__name__: made for made in (where_it_is, from_elsewhere, stretched, turning, operating)}


@pytest.fixture(scope="module")
def exported(database, tmp_path_factory):  # noqa: F811
    """(FMU with the library of all scenes, one with that of the scene alone and its sources), by the name of a scene."""

    @cache
    def made(name):
        folder = tmp_path_factory.mktemp(name)
        model = compile_scene(SCENES[name](database, folder))
        plain = export_fmu(model, folder / "plain.fmu")
        return plain, export_fmu(model, folder / "own.fmu", specialise=True, with_sources=True)

    return made


def run_of(path):
    """Outputs over time, inputs, if there are any, growing."""
    described = fmpy.read_model_description(str(path))
    given = [v.name for v in described.modelVariables if v.causality == "input"]
    kinds = [("time", float), *((name, float) for name in given)]
    inputs = np.array([(t, *[1e4 * (1 + t)] * len(given)) for t in (0.0, 2.0)], dtype=kinds)
    return fmpy.simulate_fmu(
        str(path),
        stop_time=1.0,
        output_interval=0.1,
        fmi_type="CoSimulation",
        input=inputs if given else None,
    )


def assert_same(found, wanted):
    for name in wanted.dtype.names:
        size = max(1.0, np.abs(wanted[name]).max())
        np.testing.assert_allclose(found[name] / size, wanted[name] / size, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", SCENES)
def test_a_library_of_the_scene_gives_what_that_of_all_gives(name, exported):
    plain, own = exported(name)
    assert_same(run_of(own), run_of(plain))


OFTEN = [
    ("where_it_is", "gcc"),
    ("from_elsewhere", "clang"),
    ("stretched", "gcc"),
    ("turning", "clang"),
    ("operating", "clang"),
]
SELDOM = [(name, {"gcc": "clang", "clang": "gcc"}[compiler]) for name, compiler in OFTEN]


@pytest.mark.parametrize(
    ("name", "compiler"), [*OFTEN, *(pytest.param(*each, marks=pytest.mark.long) for each in SELDOM)]
)
def test_sources_compile_without_a_warning_and_give_it_too(name, compiler, exported, tmp_path):
    if not shutil.which(compiler):
        pytest.skip(f"{compiler} is not installed")

    plain, own = exported(name)

    with zipfile.ZipFile(own) as archive:
        archive.extractall(tmp_path)

    files = [str(tmp_path / "sources" / each) for each in sources.compiled(2)]
    platform = PLATFORMS[host_platform()]
    (library,) = tmp_path.glob(f"binaries/*/*{platform.suffix}")
    includes = [f"-I{tmp_path / 'sources'}", "-isystem", str(HEADERS), "-ffp-contract=off", "-O1"]
    shared = ["-fPIC", "-shared", *files, "-lm", "-o", str(library)]
    command = [COMPILERS[compiler][0], *STRICT, *includes, *shared]
    told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stderr
    assert_same(run_of(tmp_path), run_of(plain))
