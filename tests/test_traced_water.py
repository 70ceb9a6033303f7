"""Damping, points of reference, seas from elsewhere and gusts on symbols: exact derivatives, and a library of the scene alone."""

import numpy as np
import pytest
from scenes import evaluate
from test_gusts import mill
from test_hydrodynamics import SEA, afloat, database  # noqa: F401
from test_wave_loads import FULL

from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import specialise
from mbdfmi.kernels import language
from mbdfmi.run.instance import Entries, Instance
from mbdfmi.trace.functions import derivatives

pytestmark = pytest.mark.skipif(
    language.INTERPRETED or language.JIT, reason="libraries of one scene stand beside the compiled one"
)

DAMPED = {
    "damping": (1e4 * FULL).tolist(),
    "quadratic": (3e4 * FULL).tolist(),
    "reference": [3.0, -2.0, 1.0],
    "radiation": {"error": 0.05},
}
START = {
    "position": [0.5, -0.3, 0.4],
    "velocity": [0.8, -0.6, 0.7],
    "omega": [0.02, -0.03, 0.01],
    "zyx_deg": [3, 2, -4],
}


def differences(instance):
    """(n_x, n_x) of x' by x, central."""
    x = instance.d.x.copy()
    columns = []

    for k in range(len(x)):
        sides = []
        for side in (1e-5, -1e-5):
            instance.d.x[:] = x
            instance.d.x[k] += side
            sides.append(evaluate(instance))
        columns.append((sides[0] - sides[1]) / 2e-5)

    instance.d.x[:] = x
    return np.array(columns).T


def near(found, wanted, most):
    assert np.abs(found - wanted).max() <= most * np.abs(wanted).max()


def test_derivatives_of_damping_are_exact(database):  # noqa: F811
    instance = Instance(
        compile_scene(afloat(database, START, outputs=["damping_force"], excitation="input", **DAMPED))
    )
    found = derivatives(instance, outputs=False)
    near(found.A, differences(instance), 1e-7)

    # by a load at its point: columns of the inverse inertia
    assert found.B.shape[1] == 6 and np.abs(found.B).max() > 0.0


@pytest.mark.parametrize(
    "gust",
    [{"eog": {"start": 0.0, "amplitude": 3.0}}, {"step": {"velocity": [1, 2, 3], "start": 0.5, "rise": 2.0}}],
)
def test_derivatives_in_a_gust_are_exact(tmp_path, gust):
    instance = Instance(compile_scene(mill(tmp_path, gust)))
    instance.step(1.3)
    found = derivatives(instance, outputs=False)
    near(found.A, differences(instance), 1e-7)


def alike(model, step=0.05):
    runs = [Instance(model), Instance(model, kernels=Entries.of(specialise.scene_library(model)))]
    for k in range(30):
        for run in runs:
            run.u[: model.n_u] = 1e4 * (k // 10)
            run.step(step)
        assert runs[0].outputs().tobytes() == runs[1].outputs().tobytes()


@pytest.mark.parametrize("options", [{"position": "now"}, {"excitation": "input"}])
def test_a_library_of_the_scene_gives_the_same_bits(database, options):  # noqa: F811
    outputs = ["damping_moment"] + ["excitation_force"] * ("position" in options)
    alike(compile_scene(afloat(database, START, SEA, outputs=outputs, **DAMPED, **options)))


def test_a_library_of_a_scene_in_a_gust_gives_the_same_bits(tmp_path):
    alike(compile_scene(mill(tmp_path, {"eog": {"start": 0.2, "amplitude": 3.0, "period": 1.0}})))
