"""Swings the pole of a cart up with the least force, by CasADi and IPOPT on the equations of the scene, and
replays that in its FMU.

    python swing_up.py [swing_up.png]

Needs casadi and fmpy, and matplotlib for the picture. The controls are held over steps, as a digital
controller holds them; so the FMU, which integrates by a method and steps of its own, must come to where the
optimiser's Runge-Kutta steps lead.
"""

import sys
import tempfile
from pathlib import Path

import casadi as ca
import numpy as np

import mbdfmi

HERE = Path(__file__).parent
STEPS = 80
DURATION = 2.0  # s
MOST_FORCE = 25.0  # N
HALF_TRACK = 1.5  # m
INNER = 8  # Runge-Kutta steps in a step of the control


def equations(scene):
    """(function rates(t, x, u, p), names of x) of a scene, every parameter a number."""
    text = scene.equations(parameters=[], outputs=False).text("casadi")
    module: dict = {}
    exec(text, module)
    return module["rates"], module["STATES"]


def swing_up(scene):
    """(times (n + 1,), s, states (n + 1, 4), forces (n,), N) of the swing-up with the least sum of squared
    forces.
    """
    rates, names = equations(scene)
    position, angle = names.index("track.state_position"), names.index("pivot.state_angle")
    h = DURATION / STEPS
    problem = ca.Opti()
    x = problem.variable(len(names), STEPS + 1)
    u = problem.variable(1, STEPS)

    def step(state, force):
        for _ in range(INNER):
            k1 = rates(0.0, state, force, [])
            k2 = rates(0.0, state + 0.5 * h / INNER * k1, force, [])
            k3 = rates(0.0, state + 0.5 * h / INNER * k2, force, [])
            k4 = rates(0.0, state + h / INNER * k3, force, [])
            state = state + h / (6.0 * INNER) * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

        return state

    for k in range(STEPS):
        problem.subject_to(x[:, k + 1] == step(x[:, k], u[k]))

    end = np.zeros(len(names))
    end[angle] = np.pi
    problem.subject_to(x[:, 0] == 0.0)
    problem.subject_to(x[:, STEPS] == end)
    problem.subject_to(problem.bounded(-MOST_FORCE, u, MOST_FORCE))
    problem.subject_to(problem.bounded(-HALF_TRACK, x[position, :], HALF_TRACK))
    problem.set_initial(x[angle, :], np.linspace(0.0, np.pi, STEPS + 1))
    problem.minimize(ca.sumsqr(u) * h)
    problem.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes"})
    found = problem.solve()
    return np.linspace(0.0, DURATION, STEPS + 1), found.value(x).T, found.value(u)


def replay(scene, times, forces):
    """Position (m) and angle (rad) at the times, (n + 1, 2), that the scene's FMU comes to by these forces,
    held over each step.
    """
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    with tempfile.TemporaryDirectory() as folder:
        path = scene.export(Path(folder) / "cart_pole.fmu")
        description = fmpy.read_model_description(path)
        reference = {variable.name: variable.valueReference for variable in description.modelVariables}
        fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(path, folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="cart_pole",
        )
        fmu.instantiate()
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        shown = [reference["track.position"], reference["pivot.angle"]]
        found = [fmu.getReal(shown)]

        for k, force in enumerate(forces):
            fmu.setReal([reference["track.force"]], [force])
            fmu.doStep(times[k], times[k + 1] - times[k])
            found.append(fmu.getReal(shown))

        fmu.terminate()
        fmu.freeInstance()

    return np.array(found)


def draw(path, times, states, forces, seen):
    """The forces, and the motion by the optimiser and in the FMU."""
    import matplotlib.pyplot as plt

    figure, (above, middle, below) = plt.subplots(3, 1, sharex=True, figsize=(7, 6), layout="constrained")
    above.step(times, [*forces, forces[-1]], where="post", color="firebrick")
    above.set_ylabel("force, N")
    middle.plot(times, states[:, 0], label="planned")
    middle.plot(times[::2], seen[::2, 0], "k.", label="in the FMU")
    middle.set_ylabel("cart, m")
    middle.legend()
    below.plot(times, np.degrees(states[:, 1]))
    below.plot(times[::2], np.degrees(seen[::2, 1]), "k.")
    below.axhline(180.0, color="grey", linewidth=0.5)
    below.set_ylabel("pole, deg")
    below.set_xlabel("time, s")
    figure.savefig(path, dpi=110)


def main():
    """Plans, replays, says how far apart the two are."""
    scene = mbdfmi.load(HERE / "cart_pole.toml")
    times, states, forces = swing_up(scene)
    seen = replay(scene, times, forces)
    print(f"largest force {abs(forces).max():.1f} N, pole at the end {np.degrees(seen[-1, 1]):.4f} deg")
    print(f"plan and FMU differ by {abs(seen - states[:, :2]).max():.1e} m, rad at most")

    if len(sys.argv) > 1:
        draw(sys.argv[1], times, states, forces, seen)


if __name__ == "__main__":
    main()
