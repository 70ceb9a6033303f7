"""Random scenes before the referee, and each verdict shown to be able to fail."""

import numpy as np
import pytest

from . import compare, laws, starts
from . import plan as plans
from .findings import Count
from .generator import draw
from .interpreter import Interpreter
from .verdicts import judge
from .ways import ARRIVING, LEAVING, Libraries, Way, run

PENDULUM = {
    "name": "p",
    "body": {"b": {"mass": 2.0, "com": [0, 0, -0.5], "inertia": [0.1, 0.1, 0.01]}},
    "joint": {"h": {"revolute": {"axis": "y"}, "between": ["ground", "b"], "start": {"angle": 0.4}, "damper": 0.2, "input": "torque"}},
}


@pytest.fixture(scope="module")
def interpreter():
    with Interpreter() as it:
        yield it


@pytest.mark.parametrize("seed", range(3))
def test_a_scene_stands(seed, interpreter):
    data = draw(seed, size=1 + seed % 4)
    verdict = judge(data, seed, interpreter if seed % 4 == 0 else None, fmu=seed % 2 == 0, n=2)
    assert verdict.findings == []
