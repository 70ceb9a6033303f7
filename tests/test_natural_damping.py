"""Memories of waves at the periods at which a scene swings by itself: damping there within 3 % of its own value, and free decays beside
direct convolution of the same K, which leaves nothing to a fit.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy
from scenes import mass_matrix
from test_turbine_at_sea import turbine

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.hydro.memory import Kernel, fit
from mbdfmi.hydro.reading import read_coefficients
from mbdfmi.run.instance import Instance

BARGE = Path(__file__).parents[1] / "models" / "floating_wind_turbine" / "barge.1"
STIFF = np.diag([0.0, 0.0, 16.08e6, 1.5973e9, 1.5973e9, 0.0])
H, STEPS = 0.04, 2500
STARTS = {"heave": 2, "roll": 3, "pitch": 4}


@cache
def coefficients():
    return read_coefficients(BARGE, 1025.0, 9.80665).checked()[0]


def scene(error, **solver):
    data = turbine({"position": [0.01147, 0, -0.12741]}, moored=False).model_dump(exclude_unset=True)
    data["force"]["water"]["hydrodynamics"]["radiation"] = {"error": error}
    data["solver"] |= solver
    return Scene.model_validate(data)


@cache
def inertia():
    """(6, 6) of the turbine, its added mass at infinite frequency in it."""
    return mass_matrix(Instance(compile_scene(scene(0.5, formulation="embedding"))))[:6, :6]


def decay(K, start):
    """The motion (n,) of M x'' + K * x' + C x = 0 from 1 in one of six, by the trapezoid rule."""
    x, v = np.zeros((STEPS + 1, 6)), np.zeros((STEPS + 1, 6))
    x[0, start] = 1.0
    M = inertia()
    inverse = np.linalg.inv(M + H * H / 4 * STIFF + H * H / 4 * K[0])
    a = -np.linalg.solve(M, STIFF @ x[0])

    for i in range(STEPS):
        past = H * np.einsum("tij,tj->i", K[1 : i + 1], v[i:0:-1]) + H / 2 * K[i + 1] @ v[0]
        half = v[i] + H / 2 * a
        there = x[i] + H / 2 * (v[i] + half)
        a = inverse @ (-(STIFF @ there) - past - H / 2 * K[0] @ half)
        v[i + 1], x[i + 1] = half + H / 2 * a, there + H * H / 4 * a

    return x[:, start]


@cache
def convolved(start):
    return decay(Kernel(coefficients()).at(H * np.arange(STEPS + 1)), start)


def impulses(pole, mate, source, sink):
    """K of a memory's states, at the same times."""
    A = np.diag(pole[:, 0])
    A[np.arange(len(A)), mate] += pole[:, 1]
    onward, x, found = scipy.linalg.expm(A * H), source, []

    for _ in range(STEPS + 1):
        found.append(sink.T @ x)
        x = onward @ x

    return np.array(found)


def of_model(model):
    """The same of a scene's memory."""
    m = Instance(model).m
    n = m.n_memory
    arrays = (
        m.memory_pole.reshape(n, 2),
        m.memory_mate[:n],
        m.memory_from.reshape(n, 6),
        m.memory_to.reshape(n, 6),
    )
    return impulses(*(np.array(array) for array in arrays))


@pytest.mark.parametrize("motion, most", [("heave", 0.003), ("roll", 0.008), ("pitch", 0.008)])
def test_free_decays_are_those_of_direct_convolution(motion, most):
    """100 s, of the start: gates of 0.3 % in heave, 1.5 % in pitch, which aims at 0.8 %."""
    K = of_model(compile_scene(scene(0.01)))
    assert np.abs(decay(K, STARTS[motion]) - convolved(STARTS[motion])).max() < most


def test_a_coarse_fit_meets_the_damping_where_the_scene_swings():
    """With 10 % of each peak allowed pitch would decay 3 % of the start off; its damping there, in the tail, asks for more states."""
    alone = fit(coefficients(), 0.1)
    model = compile_scene(scene(0.1))
    assert not [notice for notice in model.notices if "of the damping at" in notice]
    assert model.n_memory > len(alone.pole)
    off = [
        np.abs(decay(K, STARTS["pitch"]) - convolved(STARTS["pitch"])).max()
        for K in (of_model(model), impulses(alone.pole, alone.mate, alone.source, alone.sink))
    ]
    assert off[0] < 0.015 and off[1] > 0.03


def test_all_formulations_have_the_same_memory():
    counts = {
        compile_scene(scene(0.1, formulation=name)).n_memory
        for name in ("recursive", "embedding", "augmented")
    }
    assert len(counts) == 1


def test_damping_at_single_frequencies_is_met_where_it_is_asked_for():
    """By Re H itself, of a motion that has parts in two groups; one that makes no waves asks for nothing."""
    at = 0.55, [0.0, 1.0, 0.0, 0.15, 0.0, 0.0]
    still = 0.55, [0.0] * 6
    wanted = Kernel(coefficients()).response(np.array([at[0]]))[0].real
    off = []

    for near in ((), (at,), (at, still)):
        found = fit(coefficients(), 0.2, near=near).response([at[0]])[0].real
        off.append(abs(at[1] @ found @ at[1] / (at[1] @ wanted @ at[1]) - 1.0))

    assert off[1] < 0.03 < off[0] and off[2] == off[1]
