"""What is told of coupled runs that look fine at communication points and are not: long steps, circles that amplify."""

import numpy as np
import pytest
from coupled_blocks import Blocks, block
from test_masters import two

from mbdfmi.cosim import System


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The FMU of a block."""
    return block().export(tmp_path_factory.mktemp("blocks") / "block.fmu")


@pytest.mark.parametrize("order, step", [(1, 0.5), (1, 0.25), (2, 0.5)])
def test_long_steps_are_told_though_all_links_agree(file, order, step):
    """Periods of 1.5 to 2.3 s: links agree to 1e-6 at all points, results are wrong by a tenth of the swing."""
    blocks = two(file)
    results = blocks.system(order=order).simulate(10.0, step)
    assert max(results.jumps.values()) < 1e-5
    assert blocks.error(results) > 5e-3
    assert any("within a step this input misses" in text for text in results.notices)


@pytest.mark.parametrize("order", [1, 2])
def test_short_steps_are_not_told(file, order):
    results = two(file).system(order=order).simulate(10.0, 0.05)
    assert results.notices == []


def test_a_run_of_one_step_says_so(file):
    assert any("a run of 1 step" in text for text in two(file).system().simulate(0.1, 0.1).notices)


def test_a_constant_does_not_jump(file):
    """Two blocks at rest under a constant force: rounding is no range."""
    zero = np.zeros((2, 2))
    link = np.array([[0.0, 1.0], [1.0, 0.0]])
    start = np.linalg.solve(np.diag([10.0, 10.0]) - link, [1.0, 2.0])
    blocks = Blocks(
        file, np.ones(2), np.full(2, 10.0), np.ones(2), start, link, zero, zero, np.array([1.0, 2.0])
    )
    results = blocks.system().simulate(1.0, 0.05)
    assert np.ptp(results["b0.rail.position"]) < 1e-9
    assert max(results.jumps.values()) < 1e-2
    assert results.notices == []


@pytest.mark.parametrize("factor", [-2.0, -0.5])
def test_circles_that_amplify(file, factor):
    """F = 1 + c a, m = 1 kg: passed on a step late a change comes back c-fold."""
    link = {
        "source": "cart.rail.acceleration",
        "target": "cart.rail.force",
        "factor": factor,
        "offset": 1.0,
        "units": False,
    }
    system = System(fmu={"cart": {"file": file}}, link=[link], master={"method": "gauss-seidel"})
    told = [text for text in system.simulate(0.03, 0.01).notices if "answer to a change by" in text]
    assert (len(told) == 1) == (abs(factor) > 1)
    if told:
        assert "cart.rail.force -> cart.rail.acceleration" in told[0] and "by 2 times" in told[0]
