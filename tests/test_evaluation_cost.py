"""The cost of an evaluation, with and without peers, all of the same physics. No time is judged."""

import io
import sys

import numpy as np
import pytest
from rich.console import Console

from benchmarks import evaluation
from benchmarks.mechanisms import chain_parents, links_of, tree_parents
from benchmarks.peers import MuJoCo, Pinocchio


def printed(report):
    console = Console(file=io.StringIO(), width=200)
    console.print(report)
    return console.file.getvalue()


def without(monkeypatch, *modules):
    """As if these were not installed."""
    for module in modules:
        monkeypatch.setitem(sys.modules, module, None)


def test_all_figures_are_there():
    seen = []
    costs = evaluation.evaluation_costs(True, progress=lambda done, text: seen.append(done))
    figures = costs.as_dict()

    assert seen == sorted(seen) and seen[-1] == 1.0
    assert {"processor", "cores", "system", "date"} <= set(figures["machine"])
    assert {"numba", "llvmlite", "numpy", "python", "kernels"} <= set(figures["versions"])
    assert set(figures["exponents"]) == set(evaluation.MECHANISMS)
    assert len(figures["rows"]) == len(evaluation.MECHANISMS) * len(evaluation.QUICK_SIZES)

    for row in figures["rows"]:
        assert set(row["seconds"]) == set(figures["contestants"])
        assert 0.0 < row["seconds"]["mbdfmi"] < 1.0

    text = printed(costs)
    assert "chain" in text and "tree" in text and "growth" in text


def test_a_run_without_peers_says_what_is_missing(monkeypatch):
    without(monkeypatch, "pinocchio", "mujoco")
    monkeypatch.setattr(evaluation, "QUICK_SIZES", (8, 16))
    costs = evaluation.evaluation_costs(quick=True)

    assert set(costs.contestants) == {"mbdfmi", "embedding", "augmented"}
    assert set(costs.missing) == {"Pinocchio", "MuJoCo"}
    assert costs.largest_difference < 1e-9
    text = printed(costs)
    assert "pip install pin" in text and "pip install mujoco" in text


def test_a_peer_of_other_physics_is_refused(monkeypatch):
    class Wrong(evaluation.Ours):
        name, how, preparing = "Wrong", "", ""

        @classmethod
        def version(cls):
            return "0"

        def accelerations(self):
            return 1.01 * super().accelerations()

    monkeypatch.setattr(evaluation, "QUICK_PEERS", (Wrong,))

    with pytest.raises(RuntimeError, match="Wrong.*not the same physics"):
        evaluation.evaluation_costs(quick=True)


@pytest.mark.parametrize("parents", [chain_parents, tree_parents])
@pytest.mark.parametrize("module, peer", [("pinocchio", Pinocchio), ("mujoco", MuJoCo)])
@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_peers_find_the_same_accelerations(parents, module, peer, n):
    pytest.importorskip(module)
    links = links_of(parents(n), seed=n)
    expected = evaluation.Ours(links).accelerations()

    error = np.max(np.abs(peer(links).accelerations() - expected)) / np.max(np.abs(expected))
    assert error < 1e-9


def test_trees_name_parents_before_children():
    for n in range(1, 40):
        parents = tree_parents(n)
        assert len(parents) == n
        assert all(parent < i for i, parent in enumerate(parents))
        assert max(np.bincount(np.array(parents) + 1)[1:], default=0) <= 2
