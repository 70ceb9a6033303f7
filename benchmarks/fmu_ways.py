"""One scene as an FMU four ways: FMI 2.0 and 3.0, co-simulation and model exchange; error against CPU time.

The solver of model exchange is CVODE of fmpy.

python -m benchmarks.fmu_ways [-o PICTURE.png]
"""

import argparse
import tempfile
import time
from pathlib import Path

import fmpy
import numpy as np

from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.files import replacing
from mbdfmi.scene import read_scene

MODELS = Path(__file__).parents[1] / "models"
SCENES = {
    "double_pendulum": ("double pendulum", 2.0),
    "four_bar": ("four-bar", 2.0),
    "floating_wind_turbine": ("floating wind turbine", 20.0),
}
"""Scene -> its title and how long it runs (s), in STEPS steps, inputs as they start."""

PUSHED = {
    "floating_wind_turbine": {"float.velocity_start": (1.0, 0.5, 0.5), "float.omega_start": (0.0, 0.05, 0.0)}
}
"""Scene -> starts (m/s, rad/s) of what would be at rest."""

STEPS = 50
TOLERANCES = [10.0**-k for k in range(3, 12)]
ROUNDS = 7
KINDS = {"CoSimulation": "co-simulation", "ModelExchange": "model exchange, CVODE"}


class Fmu:
    """An unpacked FMU of a scene."""

    def __init__(self, model, fmi, folder):
        self.folder = str(folder / f"fmi{fmi}")
        fmpy.extract(str(export_fmu(model, folder / f"{fmi}.fmu", fmi=fmi)), self.folder)
        self.description = fmpy.read_model_description(self.folder)

    def starts(self, name):
        """Start values of a scene that is pushed, as fmpy takes them."""
        pushed = PUSHED.get(name, {})
        if self.description.fmiVersion == "3.0":
            return {key: list(values) for key, values in pushed.items()}
        return {f"{key}[{k}]": x for key, values in pushed.items() for k, x in enumerate(values, 1)}

    def run(self, kind, until, tolerance, starts):
        """Outputs by time (STEPS + 1, n), arrays by elements, and seconds of CPU (without an instance's)."""
        instance = fmpy.instantiate_fmu(self.folder, self.description, kind)
        given = {"solver.tolerance": tolerance, "solver.absolute_tolerance": tolerance}
        own = starts | (given if kind == "CoSimulation" else {})
        began = time.process_time()
        rows = fmpy.simulate_fmu(
            self.folder,
            validate=False,
            stop_time=until,
            output_interval=until / STEPS,
            relative_tolerance=tolerance,
            start_values=own,
            record_events=False,
            fmi_type=kind,
            model_description=self.description,
            fmu_instance=instance,
        )
        seconds = time.process_time() - began
        instance.freeInstance()
        values = [rows[name].reshape(len(rows), -1) for name in rows.dtype.names if name != "time"]
        return np.hstack(values), seconds


def measure(name, folder, tell):
    """{(fmi, kind): (CPU seconds, errors)} of a scene.

    An error is the largest of any output at any point, as a part of the largest output of its unit.
    """
    (path,) = MODELS.rglob(f"{name}.toml")
    model = compile_scene(read_scene(path))
    until = SCENES[name][1]
    fmus = {fmi: Fmu(model, fmi, folder / name) for fmi in (2, 3)}
    exact, _ = fmus[2].run("CoSimulation", until, 1e-13, fmus[2].starts(name))
    largest = {}
    units = [v.unit for v in model.of_causality("output")]
    for unit, value in zip(units, np.abs(exact).max(0), strict=True):
        largest[unit] = max(largest.get(unit, 0.0), value)
    size = np.array([largest[unit] for unit in units])
    shown = size > 1e-9  # gaps of loops are rounding alone
    found = {}

    for fmi, fmu in fmus.items():
        for kind in KINDS:
            tell(f"{name}: FMI {fmi}.0, {KINDS[kind]}")
            points = []
            for tolerance in TOLERANCES:
                runs = [fmu.run(kind, until, tolerance, fmu.starts(name)) for _ in range(ROUNDS)]
                error = np.max(np.abs(runs[0][0] - exact)[:, shown] / size[shown])
                points.append((min(seconds for _, seconds in runs), error))
            found[fmi, kind] = np.array(points).T

    return found


def draw(measured):
    """The figure: a panel for each scene."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    figure = Figure(figsize=(4.2 * len(measured), 4.1), layout="constrained")
    styles = {
        (2, "CoSimulation"): ("#08519c", "o", "-"),
        (3, "CoSimulation"): ("#6baed6", "s", "--"),
        (2, "ModelExchange"): ("#a63603", "D", "-"),
        (3, "ModelExchange"): ("#fd8d3c", "^", "--"),
    }

    for ax, (name, found) in zip(figure.subplots(1, len(measured), squeeze=False).flat, measured.items()):
        for (fmi, kind), (seconds, errors) in found.items():
            color, mark, line = styles[fmi, kind]
            label = f"FMI {fmi}.0, {KINDS[kind]}"
            ax.loglog(1e3 * seconds, errors, line, color=color, marker=mark, markersize=4.5, label=label)
        title, until = SCENES[name]
        ax.set_title(f"{title}, {until:g} s")
        ax.set_xlabel("CPU time of the run, ms")
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        ax.xaxis.set_major_formatter(FuncFormatter(lambda ms, _: f"{ms:g}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.grid(True, which="major", alpha=0.3)

    figure.axes[0].set_ylabel("largest error, of the largest output of its unit")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    return figure


def main():
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fmu_ways", description=__doc__.splitlines()[0]
    )
    parser.add_argument("-o", metavar="PICTURE", default="fmu_ways.png", help="PNG to write (%(default)s)")
    options = parser.parse_args()

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        measured = {
            name: measure(name, Path(folder), lambda text: print(text, flush=True)) for name in SCENES
        }

    for name, found in measured.items():
        for (fmi, kind), (seconds, errors) in found.items():
            print(name, fmi, kind, *(f"{1e3 * s:.0f} ms {e:.1e}," for s, e in zip(seconds, errors)))

    with replacing(Path(options.o)) as file:
        draw(measured).savefig(file, format="png", dpi=150)


if __name__ == "__main__":
    main()
