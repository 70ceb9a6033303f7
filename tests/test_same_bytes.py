"""The same scene gives the same bytes: exported again, and wherever linear algebra takes other instructions."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy import linalg

from mbdfmi import load
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance
from mbdfmi.scene import read_scene
from mbdfmi.vectors import dot, norm, solve_banded

MODELS = Path(__file__).parents[1] / "models"

# turned frames, inertias in axes of their own, welds, a spline, a table over time, all three formulations
PROGRAM = """
import numpy as np
import mbdfmi
rng = np.random.default_rng(1)
axes = lambda: {"zyx_deg": rng.integers(-80, 80, 3).tolist()}
vector = lambda: (rng.integers(-900, 900, 3) / 1000).tolist()
for formulation in ("recursive", "embedding", "augmented"):
    body, joint = {}, {}
    for k in range(6):
        body[f"b{k}"] = {"mass": 1 + k, "com": vector(), "inertia": [0.3, 0.4, 0.5, 0.01, -0.02, 0.03], "inertia_axes": axes(),
                         "marker": {"e": {"position": vector()} | axes()}}
        kind = [{"revolute": {"axis": vector()}}, {"fixed": {}}, {"spherical": {}}][k % 3]
        joint[f"j{k}"] = kind | {"between": ["ground" if k == 0 else f"b{k - 1}.e", f"b{k}"]}
    body["r"] = {"solid": [{"box": {"size": [0.1, 0.2, 0.3], "mass": 1}, "position": vector()} | axes() for _ in range(3)]}
    time = np.linspace(0, 1, 40)
    table = {"time": time.tolist(), "position": (rng.integers(-900, 900, 40) / 1000).tolist()}
    joint["r"] = {"prismatic": {}, "between": ["ground", "r"], "driver": {"table": table}}
    scene = mbdfmi.Scene(name="s", body=body, joint=joint, solver={"formulation": formulation})
    print(scene.compile().guid)
"""


@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="names of instruction sets as OpenBLAS on Linux takes them"
)
def test_models_do_not_depend_on_the_processor():
    """Kernels of OpenBLAS for processors with and without fused multiply and add."""
    texts = set()

    for processor in ("Prescott", "Nehalem", "Haswell"):
        settings = {
            "OPENBLAS_CORETYPE": processor,
            "MBDFMI_INTERPRETED": "1",
            "PYTHONPATH": os.pathsep.join(sys.path),
        }
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM], env=os.environ | settings, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        texts.add(done.stdout)

    assert len(texts) == 1 and len(texts.pop().split()) == 3


def test_exports_are_the_same(tmp_path, monkeypatch):
    """With SOURCE_DATE_EPOCH; also under another name, from another folder, and by another process."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    (tmp_path / "other").mkdir()
    text = (MODELS / "two_link_arm.toml").read_bytes()
    (tmp_path / "two_link_arm.toml").write_bytes(text)
    paths = [
        load(MODELS / "two_link_arm.toml").export(tmp_path / "a.fmu"),
        load(tmp_path / "two_link_arm.toml").export(tmp_path / "other" / "b.fmu"),
    ]
    program = "import mbdfmi; mbdfmi.load('two_link_arm.toml').export('c.fmu')"
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(sys.path),
        "PYTHONHASHSEED": "7",
        "TZ": "Asia/Tokyo",
    }
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, env=environment, check=True)
    paths.append(tmp_path / "c.fmu")
    assert len({hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}) == 1


def test_the_guid_is_that_of_the_contents():
    one, other = (compile_scene(read_scene(MODELS / f"{name}.toml")) for name in ("pendulum", "two_link_arm"))
    assert one.guid == compile_scene(read_scene(MODELS / "pendulum.toml")).guid != other.guid


@pytest.mark.parametrize("n, band", [(1, 1), (2, 3), (7, 9), (40, 9), (200, 3)])
def test_banded_equations(n, band):
    """As LAPACK's, to rounding, where rows must be exchanged too."""
    rng = np.random.default_rng(n)
    diagonals, right = rng.normal(size=(2 * band + 1, n)), rng.normal(size=n)
    diagonals[band, ::3] = 0.0 if n > 2 else 1.0
    band_of = min(band, n - 1)
    wanted = linalg.solve_banded((band_of, band_of), diagonals[band - band_of : band + band_of + 1], right)
    np.testing.assert_allclose(
        solve_banded(band, diagonals, right), wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max()
    )


def test_products():
    rng = np.random.default_rng(0)
    A, B, v = rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), rng.normal(size=3)
    np.testing.assert_allclose(dot(A, B, A.T), A @ B @ A.T, rtol=1e-13)
    np.testing.assert_allclose(dot(A, B, v), A @ B @ v, rtol=1e-13)
    np.testing.assert_allclose(dot(v, v), norm(v) ** 2, rtol=1e-14)


@pytest.mark.parametrize("name", ["double_pendulum", "four_bar"])
def test_a_parameter_set_to_the_value_that_it_has_changes_nothing(name):
    """In the midst of a run: no stepper begins anew, to the last bit."""
    runs = []

    for times in (0, 1, 2):
        instance = Instance(compile_scene(read_scene(MODELS / f"{name}.toml")))
        instance.step(0.37)

        for _ in range(times):
            instance.reals[:] = instance.reals.copy()
            instance.prepare()

        instance.step(0.41)
        runs.append(instance.d.state_buffer.tobytes())

    assert runs[0] == runs[1] == runs[2]
