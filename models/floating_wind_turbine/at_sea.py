#!/usr/bin/env python3
"""The floating wind turbine at sea and its controller: one scene with sea, moorings and rotor inside, one FMU by PythonFMU.

python at_sea.py                        ten minutes at sea, to out/turbine_at_sea.csv and .png
python at_sea.py --wind 18 --hs 5 --tp 12.4 --seed 3
"""

import argparse
import sys
import time
import tomllib
from math import cos, pi, sin
from pathlib import Path

import numpy as np
from pythonfmu.builder import FmuBuilder
from run import operating_point, rest

import mbdfmi
from mbdfmi.cosim import CouplingError, System
from mbdfmi.files import replacing

HERE = Path(__file__).resolve().parent
COUPLED = HERE.parent / "coupled"
CONTROLLER = COUPLED / "fmus" / "controller.fmu"


def build():
    """The controller's FMU, made when it is missing or out of date."""
    source = HERE / "controller.py"

    if not CONTROLLER.exists() or CONTROLLER.stat().st_mtime < source.stat().st_mtime:
        CONTROLLER.parent.mkdir(exist_ok=True)
        FmuBuilder.build_FMU(source, dest=CONTROLLER)


def voyage(wind=12.0, **sea):
    """The system of models/coupled in a wind (m/s) and a sea (hs in m, tp in s, seed), started as it would rest in that wind."""
    build()
    tables = tomllib.loads((COUPLED / "turbine_at_sea.toml").read_text(encoding="utf-8"))
    scene = mbdfmi.load(HERE / "turbine_at_sea.toml")

    for key, value in sea.items():
        setattr(scene.sea.waves.jonswap, key, value)

    speed, pitch, thrust = operating_point(wind)
    surge, heave, tilt = rest(thrust)
    tables["fmu"]["controller"] |= {"file": str(CONTROLLER), "parameters": {"start_pitch": pitch}}
    tables["fmu"]["turbine"] = {
        "scene": scene,
        "parameters": {
            "wind.velocity[1]": wind,
            "shaft.speed_start": speed,
            "rotor.pitch": pitch,
            "float.position_start[1]": surge,
            "float.position_start[3]": heave,
            "float.euler_parameters_start[2]": sin(tilt / 2),
            "float.euler_parameters_start[4]": cos(tilt / 2),
        },
    }
    return System(**tables)


def draw(results, path, title):
    """The voyage on one page."""
    from matplotlib.figure import Figure

    def get(name):
        return results[f"turbine.{name}"]

    turn, place = np.degrees(get("platform.zyx")), get("platform.position")
    lines = {f"line {k}": get(f"line_{k}.tension") / 1e3 for k in (1, 4, 7)}
    panels = [
        ("wave elevation, m", {"": get("sea.elevation")}),
        ("surge, m", {"": place[:, 0]}),
        ("heave, m", {"": place[:, 2]}),
        ("platform angles, deg", {"pitch": turn[:, 1], "roll": turn[:, 2], "yaw": turn[:, 0]}),
        ("tension, kN", lines),
        ("rotor speed, rpm", {"": get("shaft.speed") * 30 / pi}),
        ("blade pitch, deg", {"": np.degrees(results["controller.blade_pitch"])}),
        ("thrust, kN", {"": get("rotor.thrust") / 1e3}),
        ("torque of the wind, MN m", {"": get("rotor.torque") / 1e6}),
        ("electric power, MW", {"": results["controller.power"] / 1e6}),
    ]
    figure = Figure(figsize=(11, 12), layout="constrained")
    axes = figure.subplots(len(panels) // 2, 2, sharex=True)

    for axis, (name, curves) in zip(axes.T.flat, panels):
        for label, curve in curves.items():
            axis.plot(results["time"], curve, linewidth=0.9, label=label)
        if len(curves) > 1:
            axis.legend(loc="upper right", ncols=3, fontsize="small")
        axis.set_title(name, loc="left", fontsize="medium")
        axis.grid(alpha=0.3)
        axis.margins(x=0)

    for axis in axes[-1]:
        axis.set_xlabel("time, s")

    figure.suptitle(title)

    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=120, format="png")


def main():
    """Build, couple, write, draw."""
    parser = argparse.ArgumentParser(description="The floating wind turbine at sea and its controller.")
    parser.add_argument("--until", type=float, default=600.0, metavar="S", help="(default: 600)")
    parser.add_argument("--wind", type=float, default=12.0, metavar="M/S", help="(default: 12)")
    parser.add_argument("--hs", type=float, default=2.0, metavar="M", help="significant height (default: 2)")
    parser.add_argument("--tp", type=float, default=8.0, metavar="S", help="period of the peak (default: 8)")
    parser.add_argument("--seed", type=int, default=1, help="of the phases (default: 1)")
    parser.add_argument(
        "-o", dest="out", type=Path, default=Path("out"), metavar="DIR", help="(default: out)"
    )
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)

    try:
        system = voyage(options.wind, hs=options.hs, tp=options.tp, seed=options.seed)
        begun = time.perf_counter()
        results = system.simulate(until=options.until)
    except CouplingError as error:
        sys.exit(f"error: {error}")

    spent = time.perf_counter() - begun
    print(f"{options.until:g} s in {spent:.1f} s, {options.until / spent:.0f} times real time")
    print(results.to_csv(options.out / "turbine_at_sea.csv"))
    picture = options.out / "turbine_at_sea.png"
    title = f"Hs {options.hs:g} m, Tp {options.tp:g} s, seed {options.seed}, wind {options.wind:g} m/s"
    draw(results, picture, title)
    print(picture)


if __name__ == "__main__":
    main()
