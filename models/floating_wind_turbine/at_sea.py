#!/usr/bin/env python3
"""The floating wind turbine at sea and its controller: one scene with sea, moorings and rotor inside, one FMU by PythonFMU.

python at_sea.py                        ten minutes at sea, to out/turbine_at_sea.csv and .png
python at_sea.py --wind 18 --hs 5 --tp 12.4 --seed 3
"""

import argparse
import sys
import time
import tomllib
from math import pi
from pathlib import Path

import numpy as np
from pythonfmu.builder import FmuBuilder
from run import page, start_values

import mbdfmi
from mbdfmi.cosim import CouplingError, System

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

    start = start_values(wind)
    pitch = start["controller.start_pitch"]
    parts = {
        key.removeprefix("turbine."): value for key, value in start.items() if key.startswith("turbine.")
    }
    tables["fmu"]["controller"] |= {"file": str(CONTROLLER), "parameters": {"start_pitch": pitch}}
    tables["fmu"]["turbine"] = {
        "scene": scene,
        "parameters": parts | {"wind.velocity[1]": wind, "rotor.pitch": pitch},
    }
    return System(**tables)


def draw(results, path, title):
    """The voyage on one page."""

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
    page(results["time"], panels, path, title)


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
