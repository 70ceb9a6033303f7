"""Draws docs/turbine_at_sea.png: free decays and answers to regular waves of turbine_at_sea.toml beside OpenFAST's figures."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import mbdfmi

HERE = Path(__file__).parent
PEAKS = {"pitch": [4.813, 4.624, 4.442], "heave": [0.743, 0.182, 0.048]}  # of the reference, deg and m
PERIODS = {"pitch": 11.5166, "heave": 7.345}  # s
ANSWERS = {"surge": 0.190, "heave": 0.979, "pitch": 3.736}  # of the reference, per metre at 10 s; m and deg
WAVES = np.array([5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 14.0, 17.0, 20.0])  # s


def turbine(start, waves=None, moored=True):
    """The scene with its rotor parked, as tests/test_turbine_at_sea.py has it."""
    data = mbdfmi.load(HERE / "turbine_at_sea.toml").model_dump(exclude_unset=True)
    data["sea"] = {"density": 1025} | ({"waves": waves} if waves else {})
    data["joint"]["float"]["start"] = start
    data["force"]["water"]["output"] = []
    data["joint"]["shaft"].pop("input")
    data["joint"]["shaft"] = {key: data["joint"]["shaft"][key] for key in ("revolute", "between")}
    data["joint"]["shaft"]["driver"] = {"constant_speed": 0.0}
    dropped = ["rotor", "drag"] + ([] if moored else [f"line_{k}" for k in range(1, 9)])

    for name in dropped:
        del data["force"][name]

    del data["wind"]
    return mbdfmi.Scene.model_validate(data)


def answers(period):
    """{motion: (amplitude per metre, phase in deg)} in a wave of 1 m amplitude."""
    scene = turbine({"position": [0, 0, -0.1274]}, {"regular": {"height": 2.0, "period": float(period)}})
    run = scene.simulate(1200, 0.25)
    late = run["time"] > 300
    time = run["time"][late]
    window = np.blackman(len(time)) / np.blackman(len(time)).sum()
    place, angle = run["platform.position"][late], np.degrees(run["platform.zyx"][late, 1])
    found = {}

    for name, x in (("surge", place[:, 0]), ("heave", place[:, 2]), ("pitch", angle)):
        value = 2 * (window * (x - x.mean())) @ np.exp(-2j * np.pi * time / period)
        found[name] = abs(value), np.degrees(np.angle(value))

    return found


def main():
    """The picture."""
    figure = Figure(figsize=(11, 7), layout="constrained")
    axes = figure.subplots(2, 3)
    decays = {
        "pitch": (turbine({"zyx_deg": [0, 5, 0]}, moored=False), 60, "deg"),
        "heave": (turbine({"position": [0, 0, 2]}, moored=False), 30, "m"),
    }

    for axis, (name, (scene, until, unit)) in zip(axes[:, 0], decays.items()):
        run = scene.simulate(until, 0.05)
        curve = np.degrees(run["platform.zyx"][:, 1]) if name == "pitch" else run["platform.position"][:, 2]
        axis.plot(run["time"], curve, linewidth=1, label="here")
        axis.plot(PERIODS[name] * np.arange(1, 4), PEAKS[name], "r+", markersize=10, label="OpenFAST")
        axis.set_title(f"free decay in {name}, {unit}", loc="left", fontsize="medium")
        axis.set_xlabel("time, s")
        axis.legend()

    found = [answers(period) for period in WAVES]

    for axis, (name, reference) in zip(axes.flat[[1, 2, 4]], ANSWERS.items()):
        axis.plot(WAVES, [one[name][0] for one in found], "o-", markersize=3, label="here")
        axis.plot([10.0], [reference], "r+", markersize=10, label="OpenFAST")
        axis.set_title(f"{name}, {'deg' if name == 'pitch' else 'm'} per m", loc="left", fontsize="medium")
        axis.set_xlabel("period of the waves, s")
        axis.legend()

    for name in ANSWERS:
        phases = np.unwrap([one[name][1] for one in found], period=360)
        axes[1, 2].plot(WAVES, phases, "o-", markersize=3, label=name)

    axes[1, 2].set_title("phase before the crest, deg", loc="left", fontsize="medium")
    axes[1, 2].set_xlabel("period of the waves, s")
    axes[1, 2].legend()

    for axis in axes.flat:
        axis.grid(alpha=0.3)

    figure.savefig(HERE.parents[1] / "docs" / "turbine_at_sea.png", dpi=110)


if __name__ == "__main__":
    main()
