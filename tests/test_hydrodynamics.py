"""Cummins' equation in a scene: memory of waves made, waves of the sea, against other integrators and direct sums."""

import numpy as np
import pytest
from scenes import assert_near
from scipy.integrate import solve_ivp

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

RHO, G = 1025.0, 9.80665
MASS, INERTIA = 2e6, [1.5e8, 2e8, 3e8]
INFINITE = np.diag([5e5, 6e5, 3e6, 5e7, 8e7, 4e7])
INFINITE[0, 4] = INFINITE[4, 0] = -2e6

# what each mode of the water does: strength, damping, frequency, direction among the six motions
MODES = [
    (1.1e6, 0.7, 0.9, [0, 0, 1, 0, 0, 0]),
    (4e5, 0.5, 1.3, [1, 0, 0, 0, -6, 0]),
    (6e5, 0.9, 0.8, [0.4, 0, 0, 0, 9, 0]),
    (5e5, 0.6, 1.1, [0, 1, 0, 5, 0, 0]),
]
OUTPUTS = [
    "radiation_force", "radiation_moment", "radiation_power", "excitation_force", "excitation_moment", "excitation_power",
]  # fmt: skip


def response(omega):
    """(n, 6, 6): H(i omega) = sum c s / (s^2 + 2 d w s + w^2) r r^T: passive, without damping at 0."""
    s = 1j * np.asarray(omega)[:, None, None]
    return sum(c * s / (s * s + 2 * d * w * s + w * w) * np.outer(r, r) for c, d, w, r in MODES)


def exciting(omega, heading):
    """(6,) of waves: smooth in both."""
    c, s = np.cos(heading), np.sin(heading)
    size = RHO * G * 400 * np.exp(-omega)
    return size * np.array([1j * c, 1j * s, 1.0, 3j * s, -5j * c, 0.2 * s * c])


def files(folder, waves=True):
    """A database as WAMIT writes it; returns the name of its .1."""
    omega = np.concatenate([np.linspace(0.04, 4.0, 100), np.linspace(4.2, 12.0, 40)])
    H = response(omega)
    lines = []

    for w, h in [(np.inf, None), *zip(omega, H)]:
        A = INFINITE if h is None else INFINITE + h.imag / w
        period = 0.0 if h is None else 2 * np.pi / w
        for i in range(6):
            for j in range(6):
                rest = "" if h is None else f" {h.real[i, j] / (RHO * w)!r}"
                lines.append(
                    f"{float(period)!r} {i + 1} {j + 1} {float(A[i, j]) / RHO!r}{rest}".replace(
                        "np.float64", ""
                    )
                )

    text = "\n".join(lines).replace("(", "").replace(")", "")
    (folder / "body.1").write_text(text)

    if waves:
        rows = []
        for w in omega:
            for degrees in range(-180, 181, 30):
                for i, x in enumerate(exciting(w, np.radians(degrees)) / (RHO * G)):
                    rows.append(
                        f"{2 * np.pi / w:.17g} {degrees} {i + 1} {abs(x):.9g} 0 {x.real:.17g} {x.imag:.17g}"
                    )
        (folder / "body.3").write_text("\n".join(rows))

    return str(folder / "body.1")


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    return files(tmp_path_factory.mktemp("database"))


STIFF = np.diag([2e5, 2e5, 4e6, 3e8, 3e8, 1e8])


def afloat(file, start=None, sea=None, solver=None, outputs=OUTPUTS, **options):
    """A body on springs, in water."""
    force = {
        "water": {"hydrodynamics": {"file": file} | options, "on": "hull", "output": outputs},
        "hold": {"linear": {"stiffness": STIFF.tolist()}, "between": ["inertial", "hull"]},
        "lift": {"load": {"force": [0, 0, MASS * G]}, "on": "hull"},
    }
    return Scene.model_validate(
        {
            "name": "afloat",
            "gravity": [0, 0, -G],
            "solver": {"tolerance": 1e-10} | (solver or {}),
            "output": ["total_energy", "load_power", "dissipated_power"],
            "body": {"hull": {"mass": MASS, "inertia": INERTIA, "output": ["position", "velocity", "omega"]}},
            "joint": {"free": {"free": {}, "between": ["ground", "hull"], "start": start or {}}},
            "force": force,
        }
        | ({"sea": sea} if sea else {})
    )


QUIET = ["radiation_force", "radiation_moment", "radiation_power"]


def test_the_memory_meets_its_error_and_the_true_response(database):
    """At frequencies of the file and between them; nothing at 0; H + H^* nowhere negative."""
    from mbdfmi.hydro.memory import fit
    from mbdfmi.hydro.wamit import read_wamit

    coefficients, notes = read_wamit(database, RHO, G).checked()
    assert notes == []
    memory = fit(coefficients, 0.005)
    omega = np.linspace(0.02, 8, 300)
    scale = np.sqrt(np.abs(response(omega).real).max(axis=0).diagonal().clip(1e-9))
    found, wanted = memory.response(omega), response(omega)
    known = scale > 1e-3
    pick = np.ix_(range(len(omega)), known, known)
    assert memory.error < 0.005
    assert (np.abs(found - wanted)[pick] / np.outer(scale[known], scale[known])).max() < 0.01
    # it is kept with nine digits
    assert np.abs(memory.response([0.0])).max() < 1e-8 * np.abs(wanted).max()
    H = memory.response(np.geomspace(1e-3, 1e3, 400))
    lowest = np.linalg.eigvalsh((H + H.conj().transpose(0, 2, 1)) / np.outer(scale, scale).clip(1e-9)).min()
    assert lowest > -1e-5


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_a_decay_is_that_of_another_integrator(database, formulation):
    """Heave, surge and pitch, small: the same matrices by scipy's DOP853."""
    start = {"position": [0.2, 0.1, 0.5], "zyx_deg": [0, 0.01, 0]}
    scene = afloat(
        database, start, solver={"formulation": formulation}, outputs=QUIET, radiation={"error": 0.02}
    )
    model = compile_scene(scene)
    m = Instance(model).m
    n = model.n_memory
    A = np.diag(m.memory_pole[::2])
    A[np.arange(n), m.memory_mate] += m.memory_pole[1::2]
    source, sink = m.memory_from.reshape(n, 6), m.memory_to.reshape(n, 6)
    inertia = np.diag([MASS] * 3 + INERTIA) + INFINITE
    inverse = np.linalg.inv(inertia)

    def rates(t, y):
        x, v, z = y[:6], y[6:12], y[12:]
        return np.concatenate([v, inverse @ (-STIFF @ x - sink.T @ z), A @ z + source @ v])

    y = np.zeros(12 + n)
    y[[0, 1, 2, 4]] = 0.2, 0.1, 0.5, np.radians(0.01)
    run = simulate(model, 20.0, 0.5)
    other = solve_ivp(rates, (0, 20), y, "DOP853", t_eval=run["time"], rtol=1e-11, atol=1e-12).y
    assert_near(run["hull.position"], other[:3].T, 1e-6)
    assert_near(run["hull.omega"][:, 1], other[10], 1e-9)


def test_a_decay_is_that_of_direct_convolution(database):
    """M x'' + K x + int k(t - s) x'(s) ds = 0 by the trapezoid rule, with the true k of the modes: heave."""
    c, d, w, _ = MODES[0]
    damped = w * np.sqrt(1 - d * d)
    k = lambda t: c * np.exp(-d * w * t) * (np.cos(damped * t) - d * w / damped * np.sin(damped * t))
    H, n = 0.01, 3000
    time = H * np.arange(n + 1)
    x, v = np.zeros(n + 1), np.zeros(n + 1)
    x[0] = 1.0
    mass, kernel = MASS + INFINITE[2, 2], k(time)
    a = -(STIFF[2, 2] * x[0]) / mass

    for i in range(n):
        v[i + 1] = v[i] + H * a
        for _ in range(4):
            x[i + 1] = x[i] + H * (v[i] + v[i + 1]) / 2
            past = H * (kernel[1 : i + 2] @ v[i::-1]) - H * kernel[i + 1] * v[0] / 2
            a1 = -(STIFF[2, 2] * x[i + 1] + past + H * kernel[0] * v[i + 1] / 2) / mass
            v[i + 1] = v[i] + H * (a + a1) / 2
        a = a1

    run = simulate(compile_scene(afloat(database, {"position": [0, 0, 1]}, outputs=QUIET)), 30.0, 0.5)
    assert_near(run["hull.position"][:, 2], x[:: int(0.5 / H)], 3e-3)


SEA = {
    "waves": {"jonswap": {"hs": 2.0, "tp": 8.0, "components": 40, "seed": 3}, "direction_deg": 30},
    "depth": 60,
    "output": ["elevation"],
}


def test_waves_act_as_the_sum_of_their_components(database):
    """F = Re sum a X e^(i (omega t + phase - k . p)) at the start's place, 1e-7 of its size; the elevation likewise."""
    from mbdfmi.hydro import spectra

    start = {"position": [30.0, -12.0, 0.0]}
    run = simulate(compile_scene(afloat(database, start, SEA)), 30.0, 0.37)
    waves = spectra.drawn(2.0, 8.0, 3.3, 40, "energy", 3, np.radians(30))
    k = spectra.wave_number(waves.omega, 60, G)
    assert_near(G * k * np.tanh(60 * k), waves.omega**2, 1e-13)
    p = start["position"]
    way = k * (np.cos(waves.heading) * p[0] + np.sin(waves.heading) * p[1])
    X = np.array([exciting(*at) for at in zip(waves.omega, waves.heading)])
    turning = np.exp(1j * np.outer(run["time"], waves.omega))
    F = (turning @ (X * (waves.amplitude * np.exp(1j * (waves.phase - way)))[:, None])).real
    found = np.hstack([run["water.excitation_force"], run["water.excitation_moment"]])
    assert np.all(np.abs(found - F) < 1e-7 * np.abs(F).max(axis=0))
    assert_near(run["sea.elevation"], (turning @ (waves.amplitude * np.exp(1j * waves.phase))).real, 1e-12)
    assert_near((waves.amplitude**2).sum() / 2, 2.0**2 / 16, 1e-13)


def test_energy_goes_in_by_the_sea_and_out_by_waves_made(database):
    """The rate of the total energy is the power of loads, waves among them, less that of radiation."""
    start = {"position": [0.5, 0, 0.4], "velocity": [0.3, 0.2, 0.1], "omega": [0.01, 0.02, 0.01]}
    run = simulate(compile_scene(afloat(database, start, SEA)), 20.0, 0.02)
    power = run["load_power"] - run["dissipated_power"]
    weights = np.ones(len(power))
    weights[1:-1:2], weights[2:-1:2] = 4, 2
    change = run["total_energy"][-1] - run["total_energy"][0]
    assert_near(weights @ power * 0.02 / 3, change, 1e-5 * np.abs(power).max())
    assert_near(run["dissipated_power"], -run["water.radiation_power"], 1e-6)


def test_stiff_and_explicit_steppers_agree(database):
    """The Jacobian knows of the memory."""
    runs = [
        simulate(
            compile_scene(
                afloat(database, {"position": [0, 0, 1]}, SEA, {"integrator": name, "tolerance": 1e-9})
            ),
            5.0,
            0.5,
        )
        for name in ("rk853", "radau")
    ]
    assert_near(runs[0]["hull.position"], runs[1]["hull.position"], 1e-6)


def test_a_regular_wave_moves_a_body_as_its_response_says(database):
    """In the long run, small: x = (C - omega^2 (M + A) + i omega B)^-1 X."""
    omega = 0.9
    sea = {"waves": {"regular": {"height": 0.02, "period": 2 * np.pi / omega}}, "output": ["elevation"]}
    run = simulate(compile_scene(afloat(database, None, sea, radiation={"error": 0.002})), 80.0, 0.25)
    H = response([omega])[0]
    inertia = np.diag([MASS] * 3 + INERTIA) + INFINITE
    z = np.linalg.solve(STIFF - omega**2 * inertia + 1j * omega * H, exciting(omega, 0.0) * 0.01)[2]
    late = run["time"] > 60
    wanted = (z * np.exp(1j * omega * run["time"])).real[late]
    assert_near(run["hull.position"][late, 2], wanted, 0.01 * abs(z))


def test_what_a_file_does_not_have_is_told(database, tmp_path):
    with pytest.raises(
        SceneError, match=r'\[force.water\] output: no "excitation_force": there are no waves'
    ):
        compile_scene(afloat(database))

    (tmp_path / "odd.1").write_text("1.0 1 1 2.0 3.0\n2.0 1 seven 3.0 4.0\n")
    with pytest.raises(SceneError, match=r"odd.1: line 2 is no row of numbers"):
        compile_scene(afloat(str(tmp_path / "odd.1"), outputs=QUIET))

    with pytest.raises(SceneError, match="No such file"):
        compile_scene(afloat(str(tmp_path / "none.1"), outputs=QUIET))


@pytest.mark.parametrize("integrator", ["rk54", "radau"])
def test_a_body_that_is_moved_makes_waves(database, integrator):
    """Heaved by a driver: in the long run the force is that of H at its frequency."""
    omega = 0.9
    data = afloat(database, None, None, {"integrator": integrator, "tolerance": 1e-9}, QUIET).model_dump(
        exclude_unset=True
    )
    data["joint"]["free"] = {
        "prismatic": {"axis": "z"},
        "between": ["ground", "hull"],
        "driver": {"harmonic": {"amplitude": 0.1, "frequency": omega / (2 * np.pi)}},
    }
    run = simulate(compile_scene(Scene.model_validate(data)), 60.0, 0.1)
    late = run["time"] > 40
    time = run["time"][late]
    wanted = -(response([omega])[0, 2, 2] * 0.1 * omega * np.exp(1j * omega * time)).real
    found = run["water.radiation_force"][late, 2]
    assert_near(found, wanted, 0.01 * np.abs(wanted).max())


def test_what_cannot_be_is_told(database):
    for radiation, words in (
        (False, None),
        ({"states": 500}, "whole number from 2 to 60"),
        ("no", "true or false"),
    ):
        if words:
            with pytest.raises(SceneError, match=words):
                afloat(database, outputs=(), radiation=radiation)
        else:
            assert compile_scene(afloat(database, outputs=(), radiation=radiation)).n_memory == 0


def test_a_body_upside_down_moves_as_one_that_is_not(database):
    """Turned by 180 degrees about x in potential flow, whose axes stay: no angle of the element is known there, and none is asked for."""
    found = []

    for E in ([0, 0, 0, 1], [1, 0, 0, 0]):
        scene = afloat(
            database,
            {"euler_parameters": E},
            radiation=False,
            outputs=["excitation_power"],
            sea={"waves": {"regular": {"height": 1.0, "period": 8.0}}},
        )
        scene.force.pop("hold")
        found.append(simulate(compile_scene(scene), 2.0, 0.5))

    for name in ("hull.position[1]", "hull.position[3]", "hull.velocity[3]", "dissipated_power"):
        assert_near(found[1][name], found[0][name], 1e-9)


@pytest.mark.parametrize("formulation", ["recursive", "augmented"])
def test_waves_are_those_where_the_body_starts_once_loops_are_closed(database, formulation):
    """A hull between rails: the one that closes the loop is 40 m further on, and takes it there."""
    sea = {"waves": {"regular": {"height": 1.0, "period": 8.0}}}
    free = afloat(
        database, {"position": [40.0, 0, 0]}, sea=sea, radiation=False, outputs=["excitation_force"]
    )
    scene = free.model_dump(exclude_unset=True)
    slide = {"prismatic": {"axis": "x"}, "between": ["ground", "cart"], "start": {"position": 40.0}}
    cart = {"mass": 1.0, "inertia": [1, 1, 1]}
    scene |= {"body": scene["body"] | {"cart": cart}, "joint": {
        "rail": {"prismatic": {"axis": "x"}, "between": ["ground", "hull"]},
        "slide": slide, "tow": {"prismatic": {"axis": "y"}, "between": ["cart", "hull"]},
    }}  # fmt: skip
    found = Instance(compile_scene(Scene.model_validate(scene | {"solver": {"formulation": formulation}})))
    wanted = Instance(compile_scene(free))
    names = [v.name for v in wanted.model.of_causality("output")]
    told = dict(zip([v.name for v in found.model.of_causality("output")], found.outputs()))

    for name, value in zip(names, wanted.outputs()):
        if "excitation" in name or "position" in name:
            assert_near(told[name], value, 1e-6 * (1.0 + abs(value)))


def test_radiation_that_does_not_reach_the_waves_is_told(tmp_path):
    """A database cut at 0.48 rad/s, waves of 0.785 rad/s: told of both files, of neither where they reach."""
    file = files(tmp_path)
    sea = {"waves": {"regular": {"height": 1.0, "period": 8.0}}}
    told = " ".join(compile_scene(afloat(file, sea=sea)).notices)
    assert "energy is outside" not in told

    lines = (tmp_path / "body.1").read_text().splitlines()
    kept = [line for line in lines if not 0 < float(line.split()[0]) < 2 * np.pi / 0.5]
    (tmp_path / "body.1").write_text("\n".join(kept))
    told = " ".join(compile_scene(afloat(file, sea=sea)).notices)
    assert "radiation reaches from 0.04 to 0.48 rad/s; 100 % of the sea's energy is outside" in told
    assert "excitation reaches" not in told
    quiet = " ".join(compile_scene(afloat(file, outputs=QUIET)).notices)
    assert "energy is outside" not in quiet and "of its peak at the last frequency" in quiet
