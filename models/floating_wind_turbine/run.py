"""Sail the floating wind turbine: four FMUs coupled for ten minutes, to a CSV file and a plot.

python run.py
python run.py --hs 4 --tp 10 --wind 16 --until 300 --out storm
"""

import argparse
import sys
from math import cos, pi, sin
from pathlib import Path

import numpy as np
from blade_element import RADIUS, rotor_coefficients
from controller import GEAR, OPTIMAL_FROM, REFERENCE, generator_torque
from derive import rest
from pythonfmu.builder import FmuBuilder
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rotor import AIR_DENSITY
from scipy.optimize import brentq

import mbdfmi
from mbdfmi.cosim import CouplingError, couple
from mbdfmi.files import replacing

HERE = Path(__file__).resolve().parent
SCENE = HERE / "floating_wind_turbine.toml"
FOREIGN = {  # built with PythonFMU: another maker's FMUs
    "sea": ("sea.py", "excitation.py"),
    "rotor": ("rotor.py", "blade_element.py"),
    "controller": ("controller.py",),
}

# Within a step each FMU knows what those before it have reached at the step's end.
ORDER = "sea", "rotor", "controller", "turbine"

CONNECTIONS = [
    ("sea.force", "turbine.platform.force"),
    ("sea.moment", "turbine.platform.moment"),
    ("turbine.shaft.speed", "rotor.rotor_speed"),
    ("turbine.hub.velocity_body[1]", "rotor.hub_velocity"),
    ("controller.blade_pitch", "rotor.blade_pitch"),
    ("rotor.thrust", "turbine.hub.force[1]"),
    ("rotor.torque", "turbine.hub.moment[1]"),
    ("turbine.shaft.speed", "controller.rotor_speed"),
    ("controller.shaft_torque", "turbine.shaft.torque"),
]


def build(folder):
    """The paths of the four FMUs by name; foreign ones are built when missing or out of date."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = {name: folder / f"{name}.fmu" for name in ORDER}
    mbdfmi.load(SCENE).export(paths["turbine"])

    for name, files in FOREIGN.items():
        sources = [HERE / file for file in files]
        newest = max(source.stat().st_mtime for source in sources)
        if not paths[name].exists() or paths[name].stat().st_mtime < newest:
            FmuBuilder.build_FMU(sources[0], dest=paths[name], project_files=sources[1:])
    return paths


def operating_point(wind):
    """Rotor speed (rad/s), blade pitch (rad) and thrust (N) of the steady state in a wind, m/s."""

    def load(speed, pitch):
        thrust, torque = rotor_coefficients(np.array(speed * RADIUS / wind), np.array(pitch))
        force = AIR_DENSITY / 2 * wind**2 * pi * RADIUS**2
        return force * thrust, force * RADIUS * torque

    def excess(speed, pitch):
        return load(speed, pitch)[1] - GEAR * generator_torque(GEAR * speed, pitch)

    rated, slow = REFERENCE / GEAR, OPTIMAL_FROM / GEAR
    if excess(rated, 0.0) > 0:
        speed, pitch = rated, brentq(lambda pitch: excess(rated, pitch), 0.0, 0.5)
    else:
        speed, pitch = brentq(lambda speed: excess(speed, 0.0), slow, rated), 0.0
    return speed, pitch, float(load(speed, pitch)[0])


def start_values(wind):
    """Start values that spare the run the long settling of the moorings, 131 s a swing."""
    speed, pitch, thrust = operating_point(wind)
    surge, heave, tilt = rest(thrust)
    return {
        "rotor.wind": wind,
        "controller.start_pitch": pitch,
        "turbine.shaft.speed_start": speed,
        "turbine.float.position_start[1]": surge,
        "turbine.float.position_start[3]": heave,
        "turbine.float.euler_parameters_start[2]": sin(tilt / 2),
        "turbine.float.euler_parameters_start[4]": cos(tilt / 2),
    }


def plot(results, path, title):
    """The voyage on one page."""
    platform, turn = results["turbine.platform.position"], np.degrees(results["turbine.platform.zyx"])
    panels = [
        ("wave elevation, m", {"": results["sea.elevation"]}),
        ("surge, m", {"": platform[:, 0]}),
        ("heave, m", {"": platform[:, 2]}),
        ("platform angles, deg", {"pitch": turn[:, 1], "roll": turn[:, 2], "yaw": turn[:, 0]}),
        ("rotor speed, rpm", {"": results["turbine.shaft.speed"] * 30 / pi}),
        ("blade pitch, deg", {"": np.degrees(results["controller.blade_pitch"])}),
        ("thrust, kN", {"": results["rotor.thrust"] / 1e3}),
        ("electric power, MW", {"": results["controller.power"] / 1e6}),
    ]
    page(results["time"], panels, path, title)


def page(time, panels, path, title):
    """A page of panels (title, curves by label) over time (s), down the left column, then the right."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 2 + len(panels)), layout="constrained")
    axes = figure.subplots(len(panels) // 2, 2, sharex=True)
    for axis, (name, curves) in zip(axes.T.flat, panels):
        for label, curve in curves.items():
            axis.plot(time, curve, linewidth=0.9, label=label)
        if len(curves) > 1:
            axis.legend(loc="upper right", ncols=3, fontsize="small")
        axis.set_title(name, loc="left", fontsize="medium")
        axis.grid(alpha=0.3)
        axis.margins(x=0)
    for axis in axes[-1]:
        axis.set_xlabel("time, s")
    figure.suptitle(title)

    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=130, format="png")


def arguments():
    """The command line."""
    parser = argparse.ArgumentParser(
        description="Couple four FMUs: the floating wind turbine (mbdfmi), and the sea, the wind on "
        "the rotor and the controller (PythonFMU). The FMUs are built first.",
        epilog="Try: --hs 5 --tp 12.4 brings the barge near its pitch resonance at 11.4 s; "
        "--wind 8 runs below rated power, where the torque law alone is at work; "
        "--hs 0.001 leaves a flat sea.",
    )
    parser.add_argument(
        "--until", type=float, default=600.0, metavar="S", help="length of the run, s (default %(default)s)"
    )
    parser.add_argument(
        "--step",
        type=float,
        default=0.05,
        metavar="S",
        help="communication step, s: the FMUs know nothing of each other in "
        "between, so it must resolve waves and controller (default %(default)s)",
    )
    parser.add_argument(
        "--hs",
        type=float,
        default=2.0,
        metavar="M",
        help="significant wave height, m: mean of the highest third (default %(default)s)",
    )
    parser.add_argument(
        "--tp", type=float, default=8.0, metavar="S", help="peak period of the waves, s (default %(default)s)"
    )
    parser.add_argument(
        "--gamma",
        type=float,
        default=3.3,
        metavar="X",
        help="peakedness of the JONSWAP spectrum, 1 to 7 (default %(default)s)",
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=1,
        metavar="N",
        help="another number, another sea of the same kind (default %(default)s)",
    )
    parser.add_argument(
        "--wind",
        type=float,
        default=12.0,
        metavar="M/S",
        help="steady wind, m/s, 5 to 25; rated is 11.4 (default %(default)s)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/floating_wind_turbine"),
        metavar="PATH",
        help="results go to PATH.csv and PATH.png, FMUs to fmus/ beside them (default %(default)s)",
    )
    options = parser.parse_args()

    for name in ("until", "step", "hs", "tp"):
        if not 0 < getattr(options, name) < float("inf"):
            parser.error(f"--{name} must be positive; found {getattr(options, name)}")
    if not 1 <= options.gamma <= 7:
        parser.error(f"--gamma must be from 1 to 7; found {options.gamma}")
    if options.seed < 0:
        parser.error(f"--seed must not be negative; found {options.seed}")
    if not 5 <= options.wind <= 25:
        parser.error(f"--wind must be from 5 to 25 m/s; found {options.wind}")
    return options


def main():
    """Build, couple, write."""
    options, console = arguments(), Console()

    with console.status("building the FMUs; the first time takes a minute or two"):
        paths = build(options.out.parent / "fmus")

    parameters = start_values(options.wind)
    parameters |= {f"sea.{name}": getattr(options, name) for name in ("hs", "tp", "gamma", "seed")}

    bar = Progress(
        TextColumn("sailing"),
        BarColumn(),
        TextColumn("{task.completed:.0f} s"),
        TimeRemainingColumn(),
        console=console,
    )
    try:
        with bar:
            task = bar.add_task("", total=options.until)
            results = couple(
                paths,
                CONNECTIONS,
                options.until,
                options.step,
                parameters,
                progress=lambda time: bar.update(task, completed=time),
            )
    except CouplingError as error:
        sys.exit(f"error: {error}")

    csv, png = options.out.with_suffix(".csv"), options.out.with_suffix(".png")
    results.to_csv(csv)
    plot(
        results,
        png,
        f"NREL 5-MW on the ITI Energy barge: Hs {options.hs:g} m, Tp {options.tp:g} s, "
        f"wind {options.wind:g} m/s",
    )

    pitch = np.degrees(results["turbine.platform.zyx"][:, 1])
    console.print(
        f"platform pitch {pitch.min():.2f} to {pitch.max():.2f} deg, mean electric power "
        f"{results['controller.power'].mean() / 1e6:.2f} MW\n{csv}\n{png}"
    )


if __name__ == "__main__":
    main()
