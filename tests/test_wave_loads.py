"""What acts on a body in potential flow beside what its file says of it: seas from elsewhere, waves that meet it where it is, damping,
points of reference, sizes; each against another way to the same."""

import numpy as np
import pytest
import test_two_bodies as two_bodies
from scenes import assert_near, evaluate
from scipy.integrate import solve_ivp
from test_hydrodynamics import INERTIA, INFINITE, MASS, SEA, STIFF, G, afloat, database, exciting  # noqa: F401

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.hydro import spectra
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

INPUTS = ["water.excitation_force", "water.excitation_moment"]
EXCITED = ["excitation_force", "excitation_moment"]
DAMPING = ["damping_force", "damping_moment", "damping_power"]


def told(scene):
    """Outputs of a scene at its start, by name."""
    instance = Instance(compile_scene(scene))
    values = instance.outputs()
    return {v.name: value for v, value in zip(instance.model.of_causality("output"), values)}


def vector(values, name):
    return np.array([values[f"{name}[{k}]"] for k in (1, 2, 3)])


# a sea from elsewhere


def test_a_sea_from_elsewhere_moves_a_body_as_its_own_does(database):  # noqa: F811
    """Loads that one scene tells, fed into another as functions of time."""
    own = simulate(compile_scene(afloat(database, None, SEA, outputs=EXCITED, radiation=False)), 20.0, 0.25)
    scene = afloat(database, None, None, outputs=[], radiation=False, excitation="input")
    waves = spectra.drawn(2.0, 8.0, 3.3, 40, "energy", 3, np.radians(30))
    X = np.array([exciting(*at) for at in zip(waves.omega, waves.heading)])
    part = X * (waves.amplitude * np.exp(1j * waves.phase))[:, None]
    load = lambda t: (np.exp(1j * t * waves.omega) @ part).real
    inputs = {INPUTS[0]: lambda t: load(t)[:3], INPUTS[1]: lambda t: load(t)[3:]}
    run = simulate(compile_scene(scene), 20.0, 0.25, inputs=inputs)
    assert_near(run["hull.position"], own["hull.position"], 1e-5 * np.abs(own["hull.position"]).max())
    assert_near(run["hull.omega"], own["hull.omega"], 1e-5 * np.abs(own["hull.omega"]).max())


def test_its_loads_act_about_the_point_of_reference(database):  # noqa: F811
    """Accelerations are (M + A)^-1 times the load, both moved to the centre of mass by hand."""
    place = np.array([3.0, -2.0, 5.0])
    scene = afloat(
        database, None, None, outputs=[], radiation=False, excitation="input", reference=place.tolist()
    )
    scene.force.pop("hold")
    instance = Instance(compile_scene(scene))
    load = np.array([1e5, -2e5, 3e5, 4e6, 5e6, -6e6])
    at = {v.name: v.index for v in instance.model.of_causality("input")}

    for name, part in zip(INPUTS, (load[:3], load[3:])):
        for k in range(3):
            instance.u[at[f"{name}[{k + 1}]"]] = part[k]

    x, y, z = place
    moves = np.eye(6)
    moves[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    inertia = np.diag([MASS] * 3 + INERTIA) + moves.T @ INFINITE @ moves
    evaluate(instance)
    instance.outputs()
    found = np.concatenate([instance.d.rdd[3:6], instance.d.alpha[3:6]])
    assert_near(found, np.linalg.solve(inertia, moves.T @ load), 1e-12)


def test_two_bodies_have_a_sea_each(tmp_path):
    file = str(two_bodies.as_wamit(tmp_path))
    model = compile_scene(two_bodies.afloat(file, outputs=[], radiation=False, excitation="input"))
    names = {v.name for v in model.of_causality("input")}
    assert names == {
        f"water.{body}.excitation_{what}[{k}]"
        for body in ("ship", "barge")
        for what in ("force", "moment")
        for k in (1, 2, 3)
    }


# waves that meet a body where it is


@pytest.mark.parametrize("formulation", ["recursive", "augmented"])
def test_waves_meet_a_body_where_it_is(database, formulation):  # noqa: F811
    """F = Re sum a X e^(i (omega t + phase - k . p(t))) at the place of the run, by numpy."""
    start = {"position": [30.0, -12.0, 0.0], "velocity": [3.0, -2.0, 0.0]}
    scene = afloat(
        database, start, SEA, {"formulation": formulation}, radiation=False, outputs=EXCITED, position="now"
    )
    scene.force.pop("hold")
    run = simulate(compile_scene(scene), 20.0, 0.37)
    waves = spectra.drawn(2.0, 8.0, 3.3, 40, "energy", 3, np.radians(30))
    k = spectra.wave_number(waves.omega, 60, G)
    p = run["hull.position"]
    assert np.ptp(p[:, 0]) > 40.0
    way = np.outer(p[:, 0], k * np.cos(waves.heading)) + np.outer(p[:, 1], k * np.sin(waves.heading))
    X = np.array([exciting(*at) for at in zip(waves.omega, waves.heading)])
    turning = np.exp(1j * (np.outer(run["time"], waves.omega) - way))
    F = (turning @ (X * (waves.amplitude * np.exp(1j * waves.phase))[:, None])).real
    found = np.hstack([run["water.excitation_force"], run["water.excitation_moment"]])
    assert np.all(np.abs(found - F) < 1e-7 * np.abs(F).max(axis=0))


def test_a_body_towed_against_waves_meets_them_more_often(database):  # noqa: F811
    """At omega_e = omega + k U: the loads repeat after 2 pi / omega_e, which is closed form in deep water; and its energy balances."""
    omega, speed = 0.9, 3.0
    sea = {"waves": {"regular": {"height": 0.5, "period": 2 * np.pi / omega}}}
    data = afloat(database, None, sea, radiation=False, outputs=EXCITED, position="now").model_dump(
        exclude_unset=True
    )
    del data["force"]["hold"], data["force"]["lift"]
    data["joint"]["free"] = {
        "prismatic": {"axis": "x"}, "between": ["ground", "hull"],
        "driver": {"constant_speed": -speed},
    }  # fmt: skip
    meets = omega + omega**2 / G * speed
    run = simulate(compile_scene(Scene.model_validate(data)), 4 * 2 * np.pi / meets, 2 * np.pi / meets / 16)
    lift = run["water.excitation_force"][:, 2]
    wanted = (exciting(omega, 0.0)[2] * 0.25 * np.exp(1j * meets * run["time"])).real
    assert_near(lift, wanted, 1e-6 * np.abs(wanted).max())
    still = data["force"]["water"]["hydrodynamics"] | {"position": "mean"}
    data["force"]["water"]["hydrodynamics"] = still
    other = simulate(compile_scene(Scene.model_validate(data)), 4 * 2 * np.pi / meets, 2 * np.pi / meets / 16)
    assert np.abs(other["water.excitation_force"][:, 2] - wanted).max() > 0.5 * np.abs(wanted).max()


def test_one_of_two_bodies_may_follow(database):  # noqa: F811
    """Whether waves meet it where it is, is told of each: the first body of the scene does not follow, the second does."""
    sea = {"waves": {"regular": {"height": 1.0, "period": 8.0}}}
    single = afloat(
        database, {"position": [5.0, 0, 0], "velocity": [4.0, 0, 0]}, sea, outputs=[], radiation=False
    )
    single.force.pop("hold")
    data = single.model_dump(exclude_unset=True)
    water = data["force"]["water"]
    data["body"]["other"] = data["body"]["hull"]
    data["joint"]["other free"] = data["joint"]["free"] | {"between": ["ground", "other"]}
    data["force"]["other lift"] = data["force"]["lift"] | {"on": "other"}
    data["force"]["other water"] = water | {
        "on": "other", "hydrodynamics": water["hydrodynamics"] | {"position": "now"},
    }  # fmt: skip
    both = simulate(compile_scene(Scene.model_validate(data)), 6.0, 0.5)
    alone = [
        simulate(
            compile_scene(
                Scene.model_validate(
                    single.model_dump(exclude_unset=True)
                    | {"force": single.model_dump(exclude_unset=True)["force"] | {
                        "water": water | {"hydrodynamics": water["hydrodynamics"] | {"position": position}}
                    }}
                )
            ), 6.0, 0.5,
        )
        for position in ("mean", "now")
    ]  # fmt: skip
    assert_near(both["hull.position"], alone[0]["hull.position"], 1e-7)
    assert_near(both["other.position"], alone[1]["hull.position"], 1e-7)
    assert np.abs(alone[0]["hull.position"] - alone[1]["hull.position"]).max() > 1e-2


# damping beside waves


def test_quadratic_damping_slows_a_body_as_its_closed_form_says(database):  # noqa: F811
    """M v' = -q |v| v: v = v0 / (1 + q v0 t / M) ahead and back; what is lost is what the energy loses."""
    q = 8e4
    for v0 in (2.0, -2.0):
        scene = afloat(
            database, {"velocity": [v0, 0, 0]}, outputs=DAMPING, radiation=False, quadratic=[q, 0, 0, 0, 0, 0]
        )
        scene.force.pop("hold")
        data = scene.model_dump(exclude_unset=True)
        data["joint"]["free"] = {
            "prismatic": {"axis": "x"},
            "between": ["ground", "hull"],
            "start": {"speed": v0},
        }
        run = simulate(compile_scene(Scene.model_validate(data)), 40.0, 0.5)
        mass = MASS + INFINITE[0, 0]
        v = v0 / (1 + q * abs(v0) * run["time"] / mass)
        assert_near(run["hull.velocity"][:, 0], v, 1e-8)
        assert_near(run["water.damping_force"][:, 0], -q * np.abs(v) * v, 1e-2)
        assert_near(run["dissipated_power"], q * np.abs(v) ** 3, 1e-2)
        assert_near(run["water.damping_power"], -q * np.abs(v) ** 3, 1e-2)


FULL = np.random.default_rng(4).normal(size=(6, 6))
FULL = FULL @ FULL.T


def test_full_matrices_damp_as_by_another_integrator(database):  # noqa: F811
    """Linear and quadratic, small turns: the same by scipy; and at a state the wrench by numpy, and the rate of the energy."""
    size = np.array([1.0, 1, 1, 20, 20, 20])
    linear, quadratic = (factor * FULL * np.outer(size, size) for factor in (2e4, 1e6))
    start = {
        "position": [0.02, -0.012, 0.016],
        "velocity": [0.032, -0.024, 0.028],
        "omega": [8e-6, -12e-6, 4e-6],
    }
    options = {"radiation": False, "damping": linear.tolist(), "quadratic": quadratic.tolist()}
    scene = afloat(database, start, outputs=DAMPING, **options)
    values = told(scene)
    V = np.array(start["velocity"] + start["omega"])
    wrench = -(linear @ V + quadratic @ (np.abs(V) * V))
    assert_near(vector(values, "water.damping_force"), wrench[:3], 1e-8)
    assert_near(vector(values, "water.damping_moment"), wrench[3:], 1e-7)
    assert_near(values["dissipated_power"], -wrench @ V, 1e-7)

    inverse = np.linalg.inv(np.diag([MASS] * 3 + INERTIA) + INFINITE)

    def rates(t, y):
        x, v = y[:6], y[6:]
        return np.concatenate([v, inverse @ (-STIFF @ x - linear @ v - quadratic @ (np.abs(v) * v))])

    y = np.concatenate([start["position"], np.zeros(3), V])
    run = simulate(compile_scene(scene), 20.0, 0.5)
    other = solve_ivp(rates, (0, 20), y, "DOP853", t_eval=run["time"], rtol=1e-11, atol=1e-13).y
    assert_near(run["hull.position"], other[:3].T, 1e-5)
    assert_near(run["hull.omega"], other[9:].T, 3e-6)


@pytest.mark.parametrize("integrator", ["radau", "rk54"])
def test_all_steppers_take_it(database, integrator):  # noqa: F811
    options = {"radiation": False, "quadratic": (3e4 * FULL).tolist(), "damping": [1e4] * 6}
    start = {"velocity": [1.0, 2.0, -1.0]}
    runs = [
        simulate(
            compile_scene(afloat(database, start, solver={"integrator": name, "tolerance": 1e-9}, outputs=[], **options)),
            5.0, 1.0,
        )["hull.position"]
        for name in (integrator, "rk853")
    ]  # fmt: skip
    assert_near(runs[0], runs[1], 1e-6)


def test_matrices_may_be_changed_as_parameters(database):  # noqa: F811
    scene = afloat(
        database,
        {"velocity": [1.0, 0, 0]},
        outputs=DAMPING,
        radiation=False,
        quadratic=[1e4] * 6,
        damping=[2e4] * 6,
    )
    model = compile_scene(scene)
    names = {v.name: v.unit for v in model.of_causality("parameter") if v.name.startswith("water.")}
    assert names["water.quadratic[1,1]"] == "N.s2/m2" and names["water.damping[4,1]"] == "N.s"
    assert len(names) == 72
    instance = Instance(model, {"water.quadratic[1,1]": 5e4})
    force = dict(zip([v.name for v in model.of_causality("output")], instance.outputs()))[
        "water.damping_force[1]"
    ]
    assert_near(force, -7e4, 1e-9)


# points of reference


def test_a_point_of_reference_is_as_a_marker_there(database):  # noqa: F811
    """To the bit, waves and memory and all."""
    place = [4.0, -3.0, 2.0]
    start = {
        "position": [3.0, 1, 0.2],
        "velocity": [0.2, 0.1, 0.3],
        "omega": [0.01, 0.02, 0.03],
        "zyx_deg": [20, 2, 3],
    }
    options = {"radiation": {"error": 0.05}, "quadratic": [1e4] * 6, "position": "now"}
    data = afloat(database, start, SEA, outputs=[], **options).model_dump(exclude_unset=True)
    by_marker = Scene.model_validate(data).model_dump(exclude_unset=True)
    by_marker["body"]["hull"]["marker"] = {"ref": {"position": place}}
    by_marker["force"]["water"]["on"] = "hull.ref"
    data["force"]["water"]["hydrodynamics"]["reference"] = place
    runs = [simulate(compile_scene(Scene.model_validate(d)), 5.0, 0.5) for d in (data, by_marker)]
    assert np.array_equal(runs[0]["hull.position"], runs[1]["hull.position"])
    assert np.array_equal(runs[0]["hull.omega"], runs[1]["hull.omega"])
    assert np.abs(runs[0]["hull.position"][-1] - runs[0]["hull.position"][0]).max() > 0.1


# sizes


def test_a_model_is_enlarged_by_froudes_law(database):  # noqa: F811
    """A body 20 times as large: lengths 20, times sqrt(20), masses and forces 20^3, moments 20^4, in waves and damping likewise."""
    n = 20.0
    root, wave = np.sqrt(n), {"height": 1.0, "period": 8.0}
    small = afloat(
        database,
        {"position": [0, 0, 0.3]},
        {"waves": {"regular": wave}},
        outputs=["excitation_moment"],
        radiation={"error": 0.05},
    )
    data = small.model_dump(exclude_unset=True)
    large = Scene.model_validate(data).model_dump(exclude_unset=True)
    large["sea"] = {"waves": {"regular": {"height": n * wave["height"], "period": root * wave["period"]}}}
    large["body"]["hull"] |= {"mass": MASS * n**3, "inertia": (np.array(INERTIA) * n**5).tolist()}
    size = np.array([1.0] * 3 + [n] * 3)
    large["force"]["hold"]["linear"] = {"stiffness": (STIFF * n**2 * np.outer(size, size)).tolist()}
    large["force"]["lift"]["load"] = {"force": [0, 0, MASS * G * n**3]}
    large["joint"]["free"]["start"] = {"position": [0, 0, 0.3 * n]}
    large["force"]["water"]["hydrodynamics"]["froude"] = n
    runs = [
        simulate(compile_scene(Scene.model_validate(d)), 20.0 * t, 0.5 * t)
        for d, t in ((data, 1.0), (large, root))
    ]
    assert_near(runs[1]["hull.position"], n * runs[0]["hull.position"], 1e-5)
    assert_near(
        runs[1]["water.excitation_moment"], n**4 * runs[0]["water.excitation_moment"], 1e-7 * n**4 * 1e6
    )


@pytest.mark.parametrize(
    "options, words",
    [
        ({"excitation": "inputs"}, 'needs true, false or "input", found "inputs"'),
        (
            {"excitation": False, "position": "now"},
            "position is about waves of the sea, and excitation is false",
        ),
        ({"excitation": "input", "position": "mean"}, 'excitation is "input"; leave it out'),
        ({"position": "then"}, '"mean" and "now"'),
        ({"reference": [1, 2]}, "3 numbers [x, y, z]"),
        ({"reference": [[1, 2, 3], [4, 5, 6]]}, "reference is of 2 bodies, `on` names one end"),
        ({"damping": [1, 2, 3]}, "a 6x6 matrix, 6 rows of 6 numbers, or its diagonal"),
        ({"quadratic": [1, 1, -2, 1, 1, 1]}, "quadratic gives energy: [3][3] is -2"),
        ({"damping": [[1] * 6, [1] * 6]}, "damping is of 2 bodies, `on` names one end"),
        ({"froude": 0}, "froude"),
        ({"froude": 2.0, "radiation": {"file": "a.ss"}}, "a ready model of one size"),
    ],
)
def test_what_cannot_be_is_told(database, options, words):  # noqa: F811
    with pytest.raises(SceneError, match=r"force.water") as found:
        afloat(database, outputs=[], **options)
    assert words in str(found.value)


def test_outputs_that_are_inputs_are_told(database):  # noqa: F811
    with pytest.raises(SceneError, match='no "excitation_power": it is an input: excitation = "input"'):
        compile_scene(afloat(database, outputs=["excitation_power"], radiation=False, excitation="input"))
    with pytest.raises(SceneError, match='no "damping_force": there is neither damping nor quadratic'):
        compile_scene(afloat(database, outputs=["damping_force"], radiation=False))
