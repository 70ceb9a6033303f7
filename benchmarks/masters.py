"""Error against macro step of every master, on coupled systems of models/coupled whose solutions are known.

python -m benchmarks.masters          draws docs/masters.png, prints the figures
"""

import importlib.util
import sys
from functools import cache
from pathlib import Path

import numpy as np
from scipy.linalg import expm

import mbdfmi
from mbdfmi.cosim import CouplingError, load_system
from mbdfmi.files import replacing

ROOT = Path(__file__).resolve().parents[1]
MODELS = ROOT / "models" / "coupled"

MASTERS = {
    "Jacobi": {"method": "jacobi"},
    "Jacobi, order 1": {"method": "jacobi", "order": 1},
    "Jacobi, order 2": {"method": "jacobi", "order": 2},
    "Gauss-Seidel": {"method": "gauss-seidel"},
    "Gauss-Seidel, order 1": {"method": "gauss-seidel", "order": 1},
    "repeated (Aitken)": {"method": "iterate"},
    "interface Jacobian": {"method": "newton"},
    "interface Jacobian, order 2": {"method": "newton", "order": 2},
}


def linear(A, start, times):
    """States [row, state] of x' = A x at equidistant times."""
    one, rows = expm(A * (times[1] - times[0])), [np.array(start)]
    for _ in times[1:]:
        rows.append(one @ rows[-1])
    return np.array(rows)


def motor(run):
    """The rotor's speed, relative to 40 rad/s."""
    A = np.array([[-1e3, -300.0, 12e3], [1500.0, 0, 0], [0, 0, 0]])
    return (run["rotor.shaft.speed"] - linear(A, [0, 0, 1.0], run["time"])[:, 1]) / 40


def masses(run):
    """The left mass's position, relative to where it starts."""
    K, D = np.array([[18.0, -8.0], [-8.0, 23.0]]), np.array([[0.9, -0.4], [-0.4, 0.6]])
    M = np.array([[1.0], [2.0]])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-K / M, -D / M]])
    return (run["left.rail.position"] - linear(A, [0.1, -0.05, 0, 0], run["time"])[:, 0]) / 0.1


def of_one_scene(name, columns):
    """The difference from a scene that holds all of it, as a function of a run."""
    scene = mbdfmi.load(MODELS / f"{name}.toml")

    def apart(run):
        times = run["time"]
        one = scene.simulate(times[-1], times[1] - times[0], parameters={"solver.tolerance": 1e-11})
        return columns(run, one)

    return apart


def crane(run):
    """The boom's angle (rad)."""
    return run["crane.pivot.angle"] - examples().crane_alone(run["time"])[0]


@cache
def examples():
    """The module models/coupled/run.py, which is not the only one of that name."""
    sys.path.insert(0, str(MODELS))
    spec = importlib.util.spec_from_file_location("coupled_run", MODELS / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def problems():
    """{title: (system, steps in s, difference of a run from the solution)}."""
    return {
        "direct-current motor": ("dc_motor", (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2.5e-4), motor),
        "quarter truck": (
            "quarter_truck",
            (2e-2, 1e-2, 5e-3, 2.5e-3, 1.25e-3),
            of_one_scene(
                "quarter_truck_whole",
                lambda run, one: (run["chassis.guide.position"] - one["chassis_guide.position"]) / 0.1,
            ),
        ),
        "two masses on springs": ("two_masses", (0.1, 0.05, 0.025, 0.0125, 0.00625), masses),
        "split pendulum": (
            "split_pendulum",
            (2e-2, 1e-2, 5e-3, 2.5e-3),
            of_one_scene("pendulum_whole", lambda run, one: run["upper.pivot.angle"] - one["pivot.angle"]),
        ),
        "hydraulic crane": ("hydraulic_crane", (2e-2, 1e-2, 5e-3, 2.5e-3), crane),
    }


def measured(system, step, options, apart):
    """(largest difference, calls of doStep) of a run, or None where it diverges."""
    loaded = load_system(MODELS / f"{system}.toml")
    for key, value in {"tolerance": 1e-9, **options}.items():
        setattr(loaded.master, key, value)
    try:
        run = loaded.simulate(step=step)
    except CouplingError:
        return None
    return float(np.abs(apart(run)).max()), sum(run.work.values())


def table():
    """{title: {master: {step: (error, calls) or None}}}."""
    found = {}
    examples().build()
    for title, (system, steps, apart) in problems().items():
        found[title] = {
            name: {step: measured(system, step, options, apart) for step in steps}
            for name, options in MASTERS.items()
        }
        for name, row in found[title].items():
            cells = (
                f"{step:g} s: {cell[0]:.2e} ({cell[1]})" if cell else f"{step:g} s: -"
                for step, cell in row.items()
            )
            print(f"{title}, {name}: {', '.join(cells)}", flush=True)
    return found


def picture(found, path):
    """A panel for each problem."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    figure = Figure(figsize=(3.7 * len(found), 4.6), layout="constrained")
    axes = figure.subplots(1, len(found), squeeze=False)[0]

    for panel, (title, masters) in zip(axes, found.items()):
        for k, (name, row) in enumerate(masters.items()):
            points = [(step, cell[0]) for step, cell in row.items() if cell and cell[0] < 1]
            if points:
                # what passes find, and what Newton's method does, is the same: one around the other
                around = name.startswith("repeated")
                look = {"markersize": 8, "markerfacecolor": "none"} if around else {"markersize": 4}
                panel.loglog(
                    *zip(*points), marker="osv^DoPx"[k], color=f"C{k}", linewidth=1, label=name, **look
                )
        panel.set_title(title, loc="left", fontsize="medium")
        panel.set_xlabel("communication step, s")
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.grid(alpha=0.3)
    axes[0].set_ylabel("largest error, relative, of angles in rad")
    handles = {label: line for panel in axes for line, label in zip(*panel.get_legend_handles_labels())}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, fontsize="small")

    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=130, format="png")


if __name__ == "__main__":
    picture(table(), sys.argv[1] if len(sys.argv) > 1 else ROOT / "docs" / "masters.png")
