"""Hard cases as an FMU: how a run that cannot go on is told, and that jumps and steps are those of a run in
process.

A step that fails returns fmi2Discard, with a message in the log and the time reached; a start that cannot be
assembled is refused with a message.
"""

import numpy as np
import pytest
from fmu_host import DISCARD, ERROR, OK, Instance, Library
from hard import bars, solvers, start
from test_jumps import oscillator, random_pieces
from test_stiff import two_bars_as_one
from test_violating_starts import closed, four_bar

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu


@pytest.fixture
def fmu(tmp_path):
    """A function fmu(scene, solver) -> an instance of its FMU; it is freed at the end."""
    made = []

    def make(scene, solver):
        table = scene.get("solver", {}) | solver
        model = compile_scene(Scene.model_validate(scene | {"solver": table}))
        folder = tmp_path / str(len(made))
        made.append(Instance(Library(export_fmu(model, tmp_path / f"{len(made)}.fmu"), folder)))
        return made[-1]

    yield make

    for instance in made:
        instance.free()


def discarded(instance, t, H, words):
    """Steps of H until one is discarded in good order; returns the time reached."""
    while True:
        status = instance.step(t, H)

        if status != OK:
            break

        t += H
        assert np.all(np.isfinite(instance.outputs()))
        assert t < 100, "nothing was discarded"

    assert status == DISCARD
    assert any(word in instance.message for word in words), instance.message
    known, reached = instance.last_successful_time()
    assert known == OK
    assert t - 1e-12 <= reached < t + H
    assert np.all(np.isfinite(instance.outputs()))
    return reached


def test_steps_too_large_for_a_stiff_bushing(fmu):
    instance = fmu(two_bars_as_one("bushing"), {"integrator": "rk4", "step": 1e-3}).start()
    discarded(instance, 0.0, 0.01, ["no longer finite"])


def test_a_drive_beyond_the_reach(fmu):
    b, c = closed(0.5, coupler=2.0, rocker=1.2)
    scene = four_bar("auto", (0.5, b, c), coupler=2.0, rocker=1.2)
    scene["joint"]["crank"] |= {"driver": {"constant_speed": 1.0}, "start": {"angle": 0.5}}
    instance = fmu(scene, {"integrator": "rk54"}).start()
    reached = discarded(instance, 0.0, 0.01, ["cannot be closed", "step became too small"])
    assert reached == pytest.approx(np.arccos(-0.04) - 0.5, abs=0.02)


def test_a_start_that_cannot_be_assembled(fmu):
    instance = fmu(four_bar("auto", (0.3, 0.1, 1.0), coupler=100.0), {"integrator": "rk54"})
    assert instance.setup() == OK
    status = [instance.enter(), instance.exit()]
    assert ERROR in status
    assert "loop cannot be closed at pin" in " ".join(text for _, _, text in instance.log)


@solvers(
    [({"integrator": name, "tolerance": 1e-9}, 0.0, name) for name in ("rk54", "rk853", "radau", "auto")],
    [({"integrator": name, "step": 0.01}, 0.0, name) for name in ("rk4", "gauss", "ros2")],
)
def test_jumps_and_any_steps_are_those_in_process(fmu, solver, allowed):
    """Forces that jump, with derivatives, over steps of 1e-9 s to 1 s: the same numbers to the last bit."""
    pieces = random_pieces(1, 60, smallest=1e-9, derivatives=True)
    scene = oscillator(0.1)
    inside = start(scene, solver)
    outside = fmu(scene, solver).start()
    t = 0.0

    for H, u, first, second in pieces:
        inside.u[:3] = [u, first, second]
        inside.step(H)
        assert outside.set({"hinge.torque": u}) == OK

        for order, value in ((1, first), (2, second)):
            assert outside.set_derivatives("hinge.torque", order, value) == OK

        assert outside.step(t, H) == OK
        t += H
        assert outside.outputs() == inside.outputs().tolist()


def test_a_chaotic_motion_is_that_in_process(fmu):
    """The last bit would be the first digit after 30 s."""
    solver = {"integrator": "rk853", "tolerance": 1e-10}
    scene = bars(2)
    inside, outside = start(scene, solver), fmu(scene, solver).start()

    for k in range(60):
        inside.step(1.0)
        assert outside.step(float(k), 1.0) == OK

    assert outside.outputs() == inside.outputs().tolist()
