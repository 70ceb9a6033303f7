"""State events in model exchange: kinks of tables over coordinates, lengths, speeds and curves."""

from ctypes import c_double, c_size_t

import fmpy
import numpy as np
from fmu_host import Library
from test_model_exchange import Solver, compare, tight

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu

KINKS = (-0.05, 0.0, 0.1)
EFFORTS = (-20.0, 0.0, 1.0, 30.0)


def slider(spring=None, damper=None, **joint):
    """A mass of 2 kg on a rail."""
    rail = {"prismatic": {"axis": "x"}, "between": ["ground", "b"], "output": ["position", "speed"], **joint}
    rail |= {"spring": spring} if spring else {}
    rail |= {"damper": damper} if damper else {}
    return Scene(
        name="slider",
        gravity=[0, 0, 0],
        body={"b": {"mass": 2.0, "inertia": [1, 1, 1]}},
        joint={"rail": rail},
    )


def kinked(x=(-0.3, *KINKS, 0.3), y=(-50.0, -2.0, 0.0, 1.0, 40.0), interpolation="linear"):
    return {"table": {"position": list(x), "effort": list(y), "interpolation": interpolation}}


def library_of(scene, folder):
    model = compile_scene(scene)
    return model, Library(export_fmu(model, folder / "it.fmu"), folder / "it")


def indicators(solver, n):
    z = (c_double * n)()
    solver.call("fmi2GetEventIndicators", z, c_size_t(n))
    return np.array(z)


class Stopping(Solver):
    """Runge-Kutta that halves its step to where an indicator changes its sign, as solvers outside do."""

    def run(self, until, h):
        n = len([v for v in self.fmu.library.variables if "to_kink" in v])
        self.n_events = 0
        while self.t < until - 1e-12:
            t, x, low = self.t, self.x, indicators(self, n) < 0
            step = min(h, until - t)
            self.step(step)
            if ((indicators(self, n) < 0) != low).any():
                a, b = 0.0, step
                while b - a > 1e-13:
                    middle = 0.5 * (a + b)
                    self.t = t
                    self.go(t, x)
                    self.step(middle)
                    a, b = (a, middle) if ((indicators(self, n) < 0) != low).any() else (middle, b)
                self.t = t
                self.go(t, x)
                self.step(b)
                self.call("fmi2EnterEventMode")
                self.update()
                self.n_events += 1
        return self.fmu.outputs()


def test_runge_kutta_is_of_its_order_through_kinks(tmp_path):
    """With events at the kinks the error falls as h^4; the energy is kept where each piece is a spring."""
    model, library = library_of(slider(kinked(), start={"position": 0.25, "speed": 0.0}), tmp_path)
    table_x, table_y = np.array([-0.3, *KINKS, 0.3]), np.array([-50.0, -2.0, 0.0, 1.0, 40.0])
    # potential at the table's points, and by its pieces
    areas = np.concatenate([[0], np.cumsum(np.diff(table_x) * (table_y[1:] + table_y[:-1]) / 2)])

    def energy(x, v):
        i = np.clip(np.searchsorted(table_x, x) - 1, 0, 3)
        y = np.interp(x, table_x, table_y)
        return v * v + areas[i] + (x - table_x[i]) * (table_y[i] + y) / 2

    errors = []
    for h in (0.02, 0.01):
        solver = Stopping(library)
        position, speed = solver.run(1.5, h)
        errors.append(abs(energy(position, speed) - energy(0.25, 0.0)))
        assert solver.n_events >= 6
        solver.fmu.free()
    assert errors[1] < errors[0] / 12 and errors[1] < 1e-5


def test_fmpy_stops_at_kinks(tmp_path):
    model, library = library_of(slider(kinked(), start={"position": 0.25, "speed": 0.0}), tmp_path)
    run = {"stop_time": 1.0, "output_interval": 0.02}
    path = str(tmp_path / "it.fmu")
    expected = fmpy.simulate_fmu(path, start_values=tight(model), **run)
    exchange = {"fmi_type": "ModelExchange", "relative_tolerance": 1e-9, **run}
    found = fmpy.simulate_fmu(path, record_events=False, **exchange)
    compare(model, found, expected, 1e-6)
    events = fmpy.simulate_fmu(path, **exchange)
    rows = np.flatnonzero(np.diff(events["time"]) == 0)
    at = events["rail.position"][rows]
    assert 3 <= len(rows) <= 12
    assert np.abs(at[:, None] - np.array([-0.3, *KINKS, 0.3])).min(axis=1).max() < 1e-6


def test_indicators_do_not_chatter(tmp_path):
    """A coordinate that trembles at a kink by less than a thousand-millionth of it meets no event, one that goes through, one."""
    model, library = library_of(slider(kinked(), start={"position": 0.1 - 1e-3, "speed": 0.0}), tmp_path)
    solver = Solver(library)
    assert [v.name for v in model.of_causality("indicator")] == [
        "rail.spring.to_kink_above",
        "rail.spring.to_kink_below",
    ]
    np.testing.assert_allclose(indicators(solver, 2), [1e-3, 0.1 - 1e-3], atol=1e-8)
    changes, low = 0, np.array([False, False])
    for k in range(200):
        solver.go(0.0, [0.1 + 1e-11 * np.sin(k), 0.0])
        now = indicators(solver, 2) < 0
        changes += (now != low).any()
        low = now
    assert changes == 0

    solver.go(0.0, [0.1 + 1e-3, 0.0])
    assert list(indicators(solver, 2) < 0) == [True, False]
    solver.call("fmi2EnterEventMode")
    solver.update()
    np.testing.assert_allclose(indicators(solver, 2), [1e30, 1e-3], atol=1e-8)
    snapshot = solver.fmu.save()
    solver.go(0.0, [0.0 - 1e-3, 0.0])
    assert list(indicators(solver, 2) < 0) == [False, True]
    solver.call("fmi2EnterEventMode")
    solver.update()
    assert (indicators(solver, 2) > 0).all()
    assert solver.fmu.restore(snapshot) == 0
    np.testing.assert_allclose(indicators(solver, 2), [1e30, 1e-3], atol=1e-8)
    solver.fmu.free()


def test_smooth_tables_have_none_but_at_their_ends(tmp_path):
    x = np.linspace(-0.3, 0.3, 9)
    model = compile_scene(slider(kinked(x.tolist(), (100 * x**3 + x).tolist(), "cubic")))
    assert list(model.surveys.kinks) == [(-0.3, 0.3)]
    model = compile_scene(slider(kinked([-1.0, 0.0, 2.0], [-3.0, 0.0, 6.0])))
    assert model.surveys.kinks == () and not model.of_causality("indicator")


def test_dampers_struts_and_torsion_springs_have_them(tmp_path):
    damper = {
        "table": {"speed": [-1.0, 0.0, 0.5, 1.0], "effort": [-8.0, 0.0, 2.0, 3.0], "interpolation": "linear"}
    }
    scene = slider(damper=damper).model_dump(exclude_unset=True, by_alias=True)
    length = {
        "table": {"length": [0.5, 1.0, 1.5], "force": [-30.0, 0.0, 10.0], "interpolation": "linear"},
        "damping": 1.0,
    }
    scene["force"] = {"strut": {"spring_damper": length, "between": ["ground", "b"]}}
    scene["joint"]["rail"]["start"] = {"position": 0.9, "speed": 0.4}
    model, library = library_of(Scene.model_validate(scene), tmp_path)
    names = [v.name for v in model.of_causality("indicator")]
    assert names == [
        f"{of}.to_kink_{end}" for of in ("rail.damper", "strut.spring") for end in ("above", "below")
    ]
    assert [v.unit for v in model.of_causality("indicator")] == ["m/s", "m/s", "m", "m"]
    solver = Solver(library)
    np.testing.assert_allclose(indicators(solver, 4), [0.1, 0.4, 0.1, 1e30], atol=1e-8)
    solver.fmu.free()
