"""Guards that are cheaper and enough: wherever they hold, all hold that the kernels ask."""

from pathlib import Path

import numpy as np
import pytest

import mbdfmi
from mbdfmi.kernels import language
from mbdfmi.run.instance import Instance
from mbdfmi.trace.graph import Graph
from mbdfmi.trace.once import Once, still_nodes, stillness
from mbdfmi.trace.places import places
from mbdfmi.trace.record import Guard
from mbdfmi.trace.searches import VALUES
from mbdfmi.trace.specialise import READING, tracer_of
from mbdfmi.trace.sufficient import sufficient

MODELS = Path(__file__).parents[1] / "models"

pytestmark = pytest.mark.skipif(language.INTERPRETED, reason="runs of scenes")


def traced(name):
    """(instance, its graph, guards as the kernels ask them, those that are enough, nodes that are wanted)."""
    instance = Instance(mbdfmi.load(MODELS / f"{name}.toml").compile())
    instance.step(0.01)
    tracer = tracer_of(instance)
    tracer.run("dynamics.rates", "evaluate_now")
    wanted = [tracer.node_at("work", j) for j in places(instance.model, "x_rate")]
    guards = list(tracer.guards.values())
    is_still = stillness(instance.model)
    return instance, tracer.graph, guards, sufficient(tracer.graph, guards, wanted, is_still), wanted


def hold(instance, graph, guards):
    """Whether some guards hold at the state of an instance."""
    m, d = instance.m, instance.d
    buffers = {"reals": m.reals_buffer, "state": d.state_buffer, "work": d.work_buffer, "u": d.u_buffer}
    found = graph.values_at([guard.node for guard in guards], buffers, VALUES)
    return all(bool(found[guard.node]) is guard.holds for guard in guards)


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "three_link_arm", "spinning_top", "bricard"])
def test_where_they_hold_all_hold_that_kernels_ask(name):
    """At states far off, on and off the constraints, and with masses and lengths changed a thousandfold."""
    instance, graph, exact, enough, _ = traced(name)
    random = np.random.default_rng(3)
    x, reals = instance.d.x.copy(), instance.reals.copy()
    m_of_state = instance.d.state_buffer.copy()
    held = 0

    for k in range(120):
        instance.d.state_buffer[:] = m_of_state
        instance.d.x[:] = x + 10.0 ** random.uniform(-3, 1) * random.standard_normal(len(x))

        # what is prepared of parameters stands in the state: sizes alone matter here
        if k % 3 == 0:
            instance.reals[:] = reals * 10.0 ** random.uniform(-3, 3, len(reals))
            own = places(instance.model, "body_I")
            instance.d.state_buffer[own.start : own.stop] *= 10.0 ** random.uniform(-3, 3)
        else:
            instance.reals[:] = reals

        if hold(instance, graph, enough):
            held += 1
            assert hold(instance, graph, exact)

    assert held >= 20


@pytest.mark.parametrize("name", ["four_bar", "spinning_top", "satellite", "three_link_arm"])
def test_they_hold_where_a_mechanism_runs(name):
    """Of the top, with a 32nd of the inertia about its axis, whichever axis of the ground that turns to."""
    instance, graph, _, enough, _ = traced(name)

    for _ in range(60):
        instance.step(0.05)
        assert hold(instance, graph, enough)


def test_what_only_guards_need_is_gone():
    """Of a four-bar a third of all operations."""
    instance, graph, exact, enough, wanted = traced("four_bar")
    still = still_nodes(graph, stillness(instance.model))

    def moving(guards):
        needed = graph.needed([*wanted, *(guard.node for guard in guards)])
        return sum(not still[k] for k in needed)

    assert moving(enough) < 0.75 * moving(exact)
    assert moving(enough) < 1.1 * moving([])


def graph_of(function):
    """(graph, the nodes that a function makes of its leaves: `fixed` of parameters, `moving` ones)."""
    graph = Graph()
    fixed = [graph.leaf(("reals", k), value) for k, value in enumerate((2.0, -3.0, 0.5))]
    moving = [graph.leaf(("state", k), value) for k, value in enumerate((0.3, 100.0))]
    return graph, function(graph, fixed, moving)


def is_still(about):
    return about[0] == "reals"


def test_a_bound_of_sines_is_that_of_what_they_multiply():
    """a sin(q) + b < x by |a| + |b| < x."""

    def made(graph, fixed, moving):
        turned = graph.product(fixed[1], graph.function("sin", moving[0]))
        return graph.comparison("<", graph.sum(turned, fixed[0]), moving[1])

    graph, node = graph_of(made)
    (found,) = sufficient(graph, [Guard(node, True, "joints.one_axis")], [], is_still)
    buffers = {"reals": [2.0, -3.0, 0.5], "state": [0.3, 5.001]}
    assert graph.values_at([found.node], buffers, VALUES)[found.node] is True
    buffers["state"][1] = 4.999
    assert graph.values_at([found.node], buffers, VALUES)[found.node] is False
    assert all(graph.nodes[k].op != "sin" for k in graph.needed([found.node]))


def test_what_is_near_its_bound_is_asked_exactly():
    def made(graph, fixed, moving):
        return graph.comparison("<", graph.product(fixed[0], graph.function("sin", moving[0])), fixed[2])

    def unbounded(graph, fixed, moving):
        return graph.comparison("<", moving[0], moving[1])

    for function, holds in ((made, False), (unbounded, True)):
        graph, node = graph_of(function)
        guards = [Guard(node, holds, "joints.one_axis")]
        assert sufficient(graph, guards, [], is_still) == guards


def test_once_keeps_what_parameters_alone_decide():
    """a b + q: the product is computed once, the guard on a too, and the sum each time."""

    def made(graph, fixed, moving):
        total = graph.sum(graph.product(fixed[0], fixed[1]), moving[0])
        return total, graph.comparison("<", fixed[1], fixed[0])

    graph, (total, guard) = graph_of(made)
    once = Once(graph, [total], [Guard(guard, True, "prepare")], is_still, READING)
    assert once.count == 2 and once.moving == []
    assert [graph.nodes[k].op for k in once.texts] == ["*"]
    assert "run->once[{once} + 1] = t1 * t2;" in once.lines()
    assert not Once(graph, [graph.leaf(("state", 0), 0.3)], [], is_still, READING).count
