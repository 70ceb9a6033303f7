"""Run the coupled systems of this folder beside their monolithic solutions, and draw both in one picture.

python run.py                     all of them, to out/coupled.png
python run.py truck pendulum      some
python run.py crane --step 0.004  another communication step
"""

import argparse
import sys
from pathlib import Path

import cylinder
import numpy as np
from pythonfmu.builder import FmuBuilder
from scipy.integrate import solve_ivp

import mbdfmi
from mbdfmi.cosim import CouplingError, load_system
from mbdfmi.files import replacing
from mbdfmi.run.instance import Instance

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "floating_wind_turbine"))

import at_sea  # noqa: E402
from controller import GEAR, Controller  # noqa: E402

CYLINDER = HERE / "fmus" / "cylinder.fmu"
TIGHT = {"solver.tolerance": 1e-11}


def coupled(name, step=None, **master):
    """The results of a system of this folder; master : keys of [master] to be set."""
    system = load_system(HERE / f"{name}.toml")
    for key, value in master.items():
        setattr(system.master, key, value)
    return system.simulate(step=step)


def whole(name, results):
    """The results of a scene at the communication points of a coupled run."""
    times = results["time"]
    return mbdfmi.load(HERE / f"{name}.toml").simulate(times[-1], times[1] - times[0], parameters=TIGHT)


def truck(step=None, **master):
    """Heights of chassis and wheel: {name: (unit, coupled, monolithic)}, and the times."""
    run = coupled("quarter_truck", step, **master)
    one = whole("quarter_truck_whole", run)
    return run, {
        "chassis": ("m", run["chassis.guide.position"], one["chassis_guide.position"]),
        "wheel": ("m", run["wheel.guide.position"], one["guide.position"]),
    }


def pendulum(step=None, **master):
    """Angles of both rods from the vertical."""
    run = coupled("split_pendulum", step, **master)
    one = whole("pendulum_whole", run)
    return run, {
        "upper rod": ("rad", run["upper.pivot.angle"], one["pivot.angle"]),
        "lower rod": ("rad", run["lower.pivot.angle"], one["pivot.angle"] + one["elbow.angle"]),
    }


def solved(rates, start, times):
    """States [state, row] of x' = rates(t, x), by an implicit method of high accuracy."""
    most = times[-1] / 1000
    found = solve_ivp(rates, (0, times[-1]), start, "Radau", times, rtol=1e-9, atol=1e-9, max_step=most)
    return found.y


def crane_alone(times):
    """States [angle, speed, pressures] of the boom and its cylinder as one system, at times (s)."""
    mass, com, inertia = 450.0, 2.6, 900.0 + 450.0 * 2.6**2
    foot, mount = np.array([0.3, -0.9]), np.array([0.9, -0.1])

    def rates(t, x):
        angle, speed, *pressures = x
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        head = turn @ mount
        along = head - foot
        length = np.hypot(*along)
        lever = along @ [-head[1], head[0]] / length
        force = cylinder.tension(pressures, lever * speed)
        turning = (-mass * 9.81 * com * np.cos(angle) - force * lever) / inertia
        return [speed, turning, *cylinder.pressure_rates(t, pressures, length, lever * speed)]

    return solved(rates, [0, 0, *cylinder.HOLDING], times)


def crane(step=None, **master):
    """Angle of the boom, and the pressure below the piston."""
    build()
    run = coupled("hydraulic_crane", step, **master)
    one = crane_alone(run["time"])
    return run, {
        "boom": ("deg", np.degrees(run["crane.pivot.angle"]), np.degrees(one[0])),
        "pressure below the piston": ("MPa", run["cylinder.piston"] / 1e6, one[2] / 1e6),
    }


def arm(step=None, **master):
    """Angles of the joints, and the shoulder motor's current."""
    run = coupled("motor_arm", step, **master)
    alpha = 0.12 + 2.0 * 0.4**2 + 0.05 + 1.5 * (0.8**2 + 0.3**2)
    beta, delta = 1.5 * 0.8 * 0.3, 0.05 + 1.5 * 0.3**2
    R, L, k, U = np.array([1.0, 1.5]), np.array([2e-3, 1e-3]), np.array([1.2, 0.6]), np.array([24.0, 12.0])

    def rates(t, x):
        q, w, i = x[:2], x[2:4], x[4:]
        c, s = np.cos(q[1]), np.sin(q[1])
        M = np.array([[alpha + 2 * beta * c, delta + beta * c], [delta + beta * c, delta]])
        C = beta * s * np.array([[-w[1], -w[0] - w[1]], [w[0], 0.0]])
        below = 1.5 * 9.81 * 0.3 * np.cos(q[0] + q[1])
        weight = np.array([(2.0 * 0.4 + 1.5 * 0.8) * 9.81 * np.cos(q[0]) + below, below])
        a = np.linalg.solve(M, k * i - C @ w - weight - friction * w)
        return [*w, *a, *((U - R * i - k * w) / L)]

    scene = mbdfmi.load(HERE.parent / "two_link_arm.toml")
    joints = [scene.joint[name] for name in ("shoulder", "elbow")]
    friction = np.array([joint.damper or 0.0 for joint in joints])
    begin = [joint.start.angle or 0.0 for joint in joints] + [joint.start.speed or 0.0 for joint in joints]
    one = solved(rates, [*begin, 0.0, 0.0], run["time"])
    return run, {
        "shoulder": ("rad", run["arm.shoulder.angle"], one[0]),
        "elbow": ("rad", run["arm.elbow.angle"], one[1]),
        "current of the shoulder": ("A", run["shoulder_motor.circuit.speed"], one[4]),
    }


def turbine(step=None, **master):
    """The turbine at sea for 150 s: rotor speed and pitch of the blades; above rated wind, in a steep sea."""
    system = at_sea.voyage(wind=14.0, hs=4.0, tp=9.0, seed=2)
    for key, value in master.items():
        setattr(system.master, key, value)
    run = system.simulate(until=150.0, step=step)
    one = whole_turbine(system, run["time"])
    return run, {
        "rotor speed": ("rpm", run["turbine.shaft.speed"] * 30 / np.pi, one[0] * 30 / np.pi),
        "pitch of the blades": ("deg", np.degrees(run["controller.blade_pitch"]), np.degrees(one[1])),
        "thrust": ("MN", run["turbine.rotor.thrust"] / 1e6, one[2] / 1e6),
    }


def whole_turbine(system, times, parts=8):
    """Rotor speed, pitch and thrust of the scene with the controller in one loop, without a master: it is asked `parts` times
    in each communication step.
    """
    table = system.fmu["turbine"]
    model = table.scene.compile()
    inputs = {v.name: v.index for v in model.of_causality("input")}
    outputs = [v.name for v in model.of_causality("output")]
    seen = [outputs.index(name) for name in ("shaft.speed", "rotor.thrust")]
    parameters = {name: value for name, value in table.parameters.items() if name not in inputs}
    held = {inputs[name]: value for name, value in table.parameters.items() if name in inputs}
    instance = Instance(model, parameters, inputs=held)
    controller = Controller(instance_name="controller", resources=None, visible=False)
    controller.start_pitch = system.fmu["controller"].parameters["start_pitch"]
    rows = []

    for k, time in enumerate(times):
        steps = [(times[k + 1] - time) / parts] * parts if k + 1 < len(times) else []
        speed, thrust = instance.outputs()[seen]

        if k == 0:
            controller.rotor_speed = speed
            controller.exit_initialization_mode()

        rows.append((speed, controller.pitch, thrust))

        for length in steps:
            controller.rotor_speed = instance.outputs()[seen[0]]
            instance.u[inputs["shaft.torque"]] = -GEAR * controller.torque
            instance.u[inputs["rotor.pitch"]] = controller.pitch
            instance.step(length)
            controller.do_step(time, length)

    return np.array(rows).T


EXAMPLES = {"truck": truck, "pendulum": pendulum, "crane": crane, "arm": arm, "turbine": turbine}
TITLES = {
    "truck": "a quarter truck on a step of the road",
    "pendulum": "a double pendulum, split at its joint",
    "crane": "a crane and its hydraulic cylinder",
    "arm": "an arm and its two motors",
    "turbine": "a floating turbine and its controller",
}


def build():
    """The cylinder's FMU, made when it is missing or out of date; it can save its state."""
    source = HERE / "cylinder.py"
    if not CYLINDER.exists() or CYLINDER.stat().st_mtime < source.stat().st_mtime:
        CYLINDER.parent.mkdir(exist_ok=True)
        FmuBuilder.build_FMU(source, dest=CYLINDER, canGetAndSetFMUstate=True)


def picture(found, path):
    """All runs on one page: the values above, how far both are apart below."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.6 * len(found), 5.2), layout="constrained")
    axes = figure.subplots(2, len(found), squeeze=False, sharex="col", height_ratios=[2, 1])

    for column, (name, (run, curves)) in enumerate(found.items()):
        above, below = axes[:, column]
        for k, (label, (unit, ours, theirs)) in enumerate(curves.items()):
            above.plot(run["time"], theirs, color=f"C{k}", linewidth=2.4, alpha=0.35)
            above.plot(run["time"], ours, color=f"C{k}", linewidth=0.9, label=f"{label}, {unit}")
            apart = np.abs(ours - theirs) / max(np.ptp(theirs), 1e-300)
            below.semilogy(run["time"], np.maximum(apart, 1e-9), color=f"C{k}", linewidth=0.9)
        above.set_title(TITLES[name], loc="left", fontsize="small")
        above.legend(fontsize="x-small", loc="best")
        below.set_xlabel("time, s")
        for panel in (above, below):
            panel.grid(alpha=0.3)
            panel.margins(x=0)
    axes[1][0].set_ylabel("apart, of the range")
    figure.suptitle("coupled (thin) and monolithic (broad)", fontsize="medium")

    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=130, format="png")


def main():
    """Run, compare, draw."""
    parser = argparse.ArgumentParser(description="Coupled systems beside their monolithic solutions.")
    parser.add_argument("names", nargs="*", help=f"some of {', '.join(EXAMPLES)} (default: all)")
    parser.add_argument("--step", type=float, metavar="H", help="communication step, s")
    parser.add_argument("--out", type=Path, default=Path("out/coupled.png"), metavar="FILE")
    options = parser.parse_args()
    if wrong := [name for name in options.names if name not in EXAMPLES]:
        parser.error(f"there is no {wrong[0]}; there are {', '.join(EXAMPLES)}")

    found = {}
    for name in options.names or EXAMPLES:
        try:
            found[name] = EXAMPLES[name](options.step)
        except CouplingError as error:
            sys.exit(f"error: {error}")
        run, curves = found[name]
        for label, (unit, ours, theirs) in curves.items():
            print(
                f"{name}: {label} is off by {np.abs(ours - theirs).max():.2g} {unit} of {np.ptp(theirs):.3g}"
            )
        for text in run.notices:
            print(f"note: {text}")

    picture(found, options.out)
    print(options.out)


if __name__ == "__main__":
    main()
