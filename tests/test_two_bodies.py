"""Two bodies of one database, which feel each other's waves and move each other's water."""

import numpy as np
import pytest
from scenes import assert_near
from scipy.integrate import solve_ivp

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.hydro.reading import read_coefficients
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

RHO, G = 1025.0, 9.80665
MASS, INERTIA = [2e6, 1e6], [[1.5e8, 2e8, 3e8], [5e7, 8e7, 9e7]]
PLACES = [[-20.0, 0.0, 0.0], [20.0, 0.0, 0.0]]

INFINITE = np.diag([5e5, 6e5, 3e6, 5e7, 8e7, 4e7, 3e5, 4e5, 1.5e6, 2e7, 4e7, 2e7]).astype(float)
BETWEEN = 1e5 * np.array(
    [[1, 0, 0.2, 0, 5, 0], [0, 1, 0, 4, 0, 3], [0.3, 0, -4, 0, 9, 0], [0, 2, 0, 20, 0, 5], [3, 0, -8, 0, 30, 0], [0, 2, 0, 4, 0, 10]]
)  # fmt: skip
INFINITE[:6, 6:], INFINITE[6:, :6] = BETWEEN, BETWEEN.T

# what each mode of the water does: strength, damping, frequency, direction among the twelve motions
MODES = [
    (8e5, 0.6, 0.9, [0, 0, 1, 0, 3, 0, 0, 0, 0.6, 0, -2, 0]),
    (5e5, 0.5, 1.2, [0, 0, 1, 0, -2, 0, 0, 0, -0.8, 0, -1, 0]),
    (4e5, 0.5, 1.3, [1, 0, 0, 0, -6, 0, 0.7, 0, 0, 0, 3, 0]),
    (5e5, 0.6, 1.1, [0, 1, 0, 5, 0, 2, 0, 0.5, 0, 3, 0, -2]),
]
OUTPUTS = ["radiation_force", "radiation_moment", "radiation_power"]
STIFF = [np.diag([2e5, 2e5, 4e6, 3e8, 3e8, 1e8]), np.diag([1e5, 1e5, 2e6, 1e8, 1e8, 4e7])]


def response(omega):
    """(n, 12, 12): as in test_hydrodynamics.py."""
    s = 1j * np.asarray(omega)[:, None, None]
    return sum(c * s / (s * s + 2 * d * w * s + w * w) * np.outer(r, r) for c, d, w, r in MODES)


def exciting(omega, heading):
    """(12,) of waves, whose phases are those at the bodies' places."""
    size = RHO * G * np.exp(-omega) * np.array([1j, 0.5j, 1.0, 3.0, -5j, 0.2])
    k = omega * omega / G
    return np.concatenate(
        [part * size * np.exp(-1j * k * x * np.cos(heading)) for part, (x, _, _) in zip((400, 200), PLACES)]
    )


def coefficients():
    """(omega, added, damping, headings, excitation)."""
    omega = np.concatenate([np.linspace(0.04, 4.0, 100), np.linspace(4.2, 12.0, 40)])
    H = response(omega)
    headings = np.radians(np.arange(-180, 181, 15))
    waves = np.array([[exciting(w, b) for b in headings] for w in omega])
    return omega, INFINITE + H.imag / omega[:, None, None], H.real, headings, waves


def as_wamit(folder):
    omega, added, damping, headings, waves = coefficients()
    lines = [f"0 {i + 1} {j + 1} {INFINITE[i, j] / RHO:.12g}" for i, j in np.ndindex(12, 12)]

    for w, A, B in zip(omega, added, damping):
        lines += [
            f"{2 * np.pi / w:.15g} {i + 1} {j + 1} {A[i, j] / RHO:.15g} {B[i, j] / RHO / w:.15g}"
            for i, j in np.ndindex(12, 12)
        ]

    (folder / "two.1").write_text("\n".join(lines))
    rows = []

    for w, of_heading in zip(omega, waves):
        for b, force in zip(np.degrees(headings), of_heading / (RHO * G)):
            rows += [
                f"{2 * np.pi / w:.15g} {b:g} {i + 1} 0 0 {x.real:.12g} {x.imag:.12g}"
                for i, x in enumerate(force)
            ]

    (folder / "two.3").write_text("\n".join(rows))
    return folder / "two.1"


def as_capytaine(folder):
    h5py = pytest.importorskip("h5py")
    omega, added, damping, headings, waves = coefficients()
    names = [
        f"{b}__{m}" for b in ("ship", "barge") for m in ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
    ]

    with h5py.File(folder / "two.nc", "w") as file:
        axes = {"omega": omega, "wave_direction": headings[:-1]}
        axes |= {"radiating_dof": names, "influenced_dof": names, "complex": ["re", "im"]}

        for name, values in axes.items():
            file[name] = values
            file[name].make_scale(name)

        force = np.stack([waves.real, -waves.imag])[:, :, :-1]

        for name, values, along in (
            ("added_mass", added, ("omega", "influenced_dof", "radiating_dof")),
            ("radiation_damping", damping, ("omega", "influenced_dof", "radiating_dof")),
            ("excitation_force", force, ("complex", "omega", "wave_direction", "influenced_dof")),
        ):
            file[name] = values
            for k, axis in enumerate(along):
                file[name].dims[k].attach_scale(file[axis])

    return folder / "two.nc"


def as_bemio(folder):
    h5py = pytest.importorskip("h5py")
    omega, added, damping, headings, waves = coefficients()

    with h5py.File(folder / "two.h5", "w") as file:
        file["simulation_parameters/w"] = omega
        file["simulation_parameters/wave_dir"] = np.degrees(headings[:-1])

        for b in range(2):
            own, at = slice(6 * b, 6 * b + 6), f"body{b + 1}/hydro_coeffs/"
            file[at + "added_mass/all"] = np.moveaxis(added[:, own] / RHO, 0, -1)
            file[at + "added_mass/inf_freq"] = INFINITE[own] / RHO
            file[at + "radiation_damping/all"] = np.moveaxis(
                damping[:, own] / RHO / omega[:, None, None], 0, -1
            )
            force = np.moveaxis(waves[:, :-1, own] / (RHO * G), (0, 1, 2), (2, 1, 0))
            file[at + "excitation/re"], file[at + "excitation/im"] = force.real, force.imag

    return folder / "two.h5"


def as_nemoh(folder):
    omega, added, damping, headings, waves = coefficients()
    lines = ["VARIABLES = w"]

    for i in range(12):
        lines.append(f'Zone t="motion {i + 1}"')
        pairs = np.stack([added[:, i], damping[:, i]], axis=2).reshape(len(omega), -1)
        lines += [" ".join(f"{x:.12e}" for x in (w, *row)) for w, row in zip(omega, pairs)]

    (folder / "RadiationCoefficients.tec").write_text("\n".join(lines))
    lines = ["VARIABLES = w"]

    for b in range(len(headings) - 1):
        lines.append(f'Zone t="beta = {np.degrees(headings[b]):g} deg"')
        force = waves[:, b]
        pairs = np.stack([np.abs(force), -np.angle(force)], axis=2).reshape(len(omega), -1)
        lines += [" ".join(f"{x:.12e}" for x in (w, *row)) for w, row in zip(omega, pairs)]

    (folder / "ExcitationForce.tec").write_text("\n".join(lines))
    return folder / "RadiationCoefficients.tec"


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    return str(as_wamit(tmp_path_factory.mktemp("two")))


def afloat(
    file, start=({}, {}), solver=None, sea=None, outputs=OUTPUTS, on=("ship", "barge"), joints=None, **options
):
    """A ship and a barge on springs, in water."""
    names = ("ship", "barge")
    force = {"water": {"hydrodynamics": {"file": file} | options, "on": list(on), "output": list(outputs)}}

    for k, name in enumerate(names):
        force[f"lift_{name}"] = {"load": {"force": [0, 0, MASS[k] * G]}, "on": name}
        if not joints:
            force[f"hold_{name}"] = {
                "linear": {"stiffness": STIFF[k].tolist()}, "between": [f"ground.{name}", name]
            }  # fmt: skip

    bodies = {
        name: {"mass": MASS[k], "inertia": INERTIA[k], "output": ["position", "velocity", "omega"]}
        for k, name in enumerate(names)
    }
    bodies["ship"]["marker"] = {"stern": {"position": [20, 1, 0]}, "beside": {"position": [40, 0, 0]}}
    bodies["barge"]["marker"] = {"bow": {"position": [-20, 0, 1]}}
    free = {
        f"free_{name}": {
            "free": {},
            "between": ["ground", name],
            "start": {"position": (np.array(PLACES[k]) + start[k].get("position", 0)).tolist()}
            | {key: value for key, value in start[k].items() if key != "position"},
        }
        for k, name in enumerate(names)
    }
    return Scene.model_validate(
        {
            "name": "afloat",
            "gravity": [0, 0, -G],
            "solver": {"tolerance": 1e-10} | (solver or {}),
            "output": [
                "total_energy",
                "kinetic_energy",
                "load_power",
                "dissipated_power",
                "linear_momentum",
                "angular_momentum",
            ],
            "ground": {"marker": {name: {"position": PLACES[k]} for k, name in enumerate(names)}},
            "body": bodies,
            "joint": joints or free,
            "force": force,
        }
        | ({"sea": sea} if sea else {})
    )


@pytest.mark.parametrize("write", [as_wamit, as_capytaine, as_bemio, as_nemoh])
def test_two_bodies_are_the_same_from_every_file(tmp_path, write):
    found, notes = read_coefficients(write(tmp_path), RHO, G).checked()
    omega, added, damping, headings, waves = coefficients()
    assert found.bodies == 2 and not notes
    assert_near(found.omega, omega, 1e-9)
    assert_near(found.added / added.max(), added / added.max(), 1e-9)
    assert_near(found.damping / damping.max(), damping / damping.max(), 1e-9)
    assert_near(np.degrees(found.headings), np.degrees(headings[:-1]), 1e-9)
    assert_near(found.excitation / np.abs(waves).max(), waves[:, :-1] / np.abs(waves).max(), 1e-7)


def test_a_decay_is_that_of_another_integrator(database):
    """All twelve motions, small: the same matrices by scipy's DOP853."""
    start = ({"position": [0.02, 0.01, 0.05]}, {})
    model = compile_scene(afloat(database, start))
    assert model.formulation == "embedding"
    m = Instance(model).m
    n = model.n_memory
    A = np.diag(m.memory_pole[::2])
    A[np.arange(n), m.memory_mate] += m.memory_pole[1::2]
    source, sink = (
        p.reshape(2, n, 6).transpose(1, 0, 2).reshape(n, 12) for p in (m.memory_from, m.memory_to)
    )
    own = np.concatenate([np.r_[[mass] * 3, turning] for mass, turning in zip(MASS, INERTIA)])
    inverse = np.linalg.inv(np.diag(own) + INFINITE)
    stiff = np.zeros((12, 12))
    stiff[:6, :6], stiff[6:, 6:] = STIFF

    def rates(t, y):
        x, v, z = y[:12], y[12:24], y[24:]
        return np.concatenate([v, inverse @ (-stiff @ x - sink.T @ z), A @ z + source @ v])

    y = np.zeros(24 + n)
    y[:3] = start[0]["position"]
    run = simulate(model, 20.0, 0.5)
    other = solve_ivp(rates, (0, 20), y, "DOP853", t_eval=run["time"], rtol=1e-11, atol=1e-13).y
    assert_near(run["ship.position"] - PLACES[0], other[:3].T, 2e-7)
    assert_near(run["barge.position"] - PLACES[1], other[6:9].T, 2e-7)
    assert_near(run["barge.omega"], other[21:24].T, 2e-8)
    assert np.abs(other[8]).max() > 0.003


def test_a_decay_is_that_of_direct_convolution(database):
    """(M + A) x'' + K x + int k(t - s) x'(s) ds = 0 by the trapezoid rule, with the true k of the modes: the barge is moved by the ship."""
    H, n = 0.02, 1000
    time = H * np.arange(n + 1)
    kernel = np.zeros((n + 1, 12, 12))

    for c, d, w, r in MODES:
        damped = w * np.sqrt(1 - d * d)
        k = c * np.exp(-d * w * time) * (np.cos(damped * time) - d * w / damped * np.sin(damped * time))
        kernel += k[:, None, None] * np.outer(r, r)

    own = np.concatenate([np.r_[[mass] * 3, turning] for mass, turning in zip(MASS, INERTIA)])
    inverse = np.linalg.inv(np.diag(own) + INFINITE)
    stiff = np.zeros((12, 12))
    stiff[:6, :6], stiff[6:, 6:] = STIFF
    x, v = np.zeros((n + 1, 12)), np.zeros((n + 1, 12))
    x[0, 2] = 0.05
    a = inverse @ -stiff @ x[0]

    for i in range(n):
        past = H * np.einsum("kij,kj->i", kernel[1 : i + 2], v[i::-1]) - H * kernel[i + 1] @ v[0] / 2
        v[i + 1], a1 = v[i] + H * a, a
        for _ in range(4):
            v[i + 1] = v[i] + H * (a + a1) / 2
            x[i + 1] = x[i] + H * (v[i] + v[i + 1]) / 2
            a1 = inverse @ -(stiff @ x[i + 1] + past + H * kernel[0] @ v[i + 1] / 2)
        a = a1

    run = simulate(compile_scene(afloat(database, ({"position": [0, 0, 0.05]}, {}))), 20.0, 0.5)
    assert_near(run["ship.position"][:, 2], x[:: int(0.5 / H), 2], 1.5e-4)
    assert_near(run["barge.position"][:, 2], x[:: int(0.5 / H), 8], 1.5e-4)


FLYING = (
    {"velocity": [1, 0.3, -0.5], "omega": [0.4, -0.3, 0.6]},
    {"velocity": [-0.2, 0.7, 0.4], "omega": [-0.3, 0.5, 0.2]},
)


def test_water_between_bodies_keeps_energy_and_momentum(database):
    """Free of all else, turning far: the energy V^T A V / 2 and the momenta of bodies and water stay."""
    scene = afloat(database, FLYING, radiation=False, outputs=[]).model_dump(exclude_unset=True)
    for name in ("ship", "barge"):
        del scene["force"][f"hold_{name}"]
    run = simulate(compile_scene(Scene.model_validate(scene)), 6.0, 0.2)
    energy = run["kinetic_energy"]
    assert_near(energy / energy[0], 1.0, 1e-9)
    p = run["linear_momentum"]
    assert_near(p / np.abs(p[0]).max(), np.tile(p[0] / np.abs(p[0]).max(), (len(p), 1)), 1e-8)
    assert np.ptp(run["ship.omega"], axis=0).min() > 0.05


def test_water_of_bodies_on_a_hinge_keeps_energy(database):
    """The one hinged to the other, which hangs on a pin: coordinates that both depend on; and the loop of a rod closed."""
    joints = {
        "pin": {"revolute": {"axis": "y"}, "between": ["ground.ship", "ship"], "start": {"speed": 0.3}},
        "hinge": {
            "spherical": {},
            "between": ["ship.stern", "barge.bow"],
            "start": {"omega": [0.2, 0.3, -0.4]},
        },
    }
    scene = afloat(database, joints=joints, radiation=False, outputs=[]).model_dump(exclude_unset=True)
    for name in ("ship", "barge"):
        del scene["force"][f"lift_{name}"]
    run = simulate(compile_scene(Scene.model_validate(scene)), 5.0, 0.25)
    energy = run["total_energy"]
    assert_near(energy - energy[0], 0.0, 1e-8 * MASS[0] * G)
    assert np.ptp(run["barge.position"], axis=0).min() > 0.1


def test_bodies_welded_are_one(database):
    """Two on a fixed joint, small motions: one body with the sum of all blocks, moved to its origin."""
    scene = afloat(
        database,
        joints={
            "free": {"free": {}, "between": ["ground.ship", "ship"], "start": {"position": [0, 0, 0.005], "zyx_deg": [0, 0.01, 0]}},
            "weld": {"fixed": {}, "between": ["ship.beside", "barge"]},
        },
    ).model_dump(exclude_unset=True)  # fmt: skip
    scene["force"]["hold"] = {
        "linear": {"stiffness": STIFF[0].tolist()}, "between": ["ground.ship", "ship"]
    }  # fmt: skip
    model = compile_scene(Scene.model_validate(scene))
    run = simulate(model, 15.0, 0.5)
    m, n = Instance(model).m, model.n_memory
    A = np.diag(m.memory_pole[::2])
    A[np.arange(n), m.memory_mate] += m.memory_pole[1::2]
    source, sink = (
        p.reshape(2, n, 6).transpose(1, 0, 2).reshape(n, 12) for p in (m.memory_from, m.memory_to)
    )
    turned = np.array([[0, 0, 0], [0, 0, 40], [0, -40, 0]])  # v_Q = v_P + omega x [40, 0, 0]
    T = np.vstack([np.eye(6), np.block([[np.eye(3), turned], [np.zeros((3, 3)), np.eye(3)]])])
    own = np.concatenate([np.r_[[mass] * 3, turning] for mass, turning in zip(MASS, INERTIA)])
    inverse = np.linalg.inv(T.T @ (np.diag(own) + INFINITE) @ T)

    def rates(t, y):
        x, v, z = y[:6], y[6:12], y[12:]
        return np.concatenate([v, inverse @ (-STIFF[0] @ x - T.T @ sink.T @ z), A @ z + source @ T @ v])

    y = np.zeros(12 + n)
    y[[2, 4]] = 0.005, np.radians(0.01)
    other = solve_ivp(rates, (0, 15), y, "DOP853", t_eval=run["time"], rtol=1e-11, atol=1e-13).y
    assert_near(run["ship.position"] - PLACES[0], other[:3].T, 4e-7)


SEA = {"waves": {"jonswap": {"hs": 2.0, "tp": 8.0, "components": 30, "seed": 3}, "direction_deg": 30}}


def test_each_feels_the_waves_at_its_place(database):
    """The sum of components with the file's phases, whose origin is the inertial frame's, whatever the start."""
    from mbdfmi.compiler.seas import sea_components

    scene = afloat(database, sea=SEA, outputs=["excitation_force", "excitation_moment", *OUTPUTS])
    run = simulate(compile_scene(scene), 10.0, 0.5)
    waves = sea_components(scene)

    for k, name in enumerate(("ship", "barge")):
        felt = np.hstack([run[f"water.{name}.excitation_force"], run[f"water.{name}.excitation_moment"]])
        # the true loads; the file knows them at its frequencies and headings, and cubics lead between
        true = sum(
            np.real(a * exciting(w, b)[6 * k : 6 * k + 6] * np.exp(1j * (w * run["time"][:, None] + phase)))
            for w, a, phase, b in zip(*waves)
        )
        assert_near(felt / np.abs(true).max(axis=0), true / np.abs(true).max(axis=0), 2e-3)

    # energy: what goes in by the sea and out by waves
    energy, time = run["total_energy"], run["time"]
    assert np.isfinite(energy).all() and len(time) == 21


def test_energy_goes_in_by_the_sea_and_out_by_waves(database):
    run = simulate(compile_scene(afloat(database, sea=SEA)), 10.0, 0.02)
    flow = run["load_power"] - run["dissipated_power"]
    gained = np.concatenate([[0.0], np.cumsum((flow[1:] + flow[:-1]) / 2 * np.diff(run["time"]))])
    stored = run["total_energy"] - run["total_energy"][0]
    assert_near(stored / np.abs(gained).max(), gained / np.abs(gained).max(), 2e-4)
    made = run["water.ship.radiation_power"] + run["water.barge.radiation_power"]
    assert_near(made, -run["dissipated_power"], 1e-6 * np.abs(made).max())


def test_stiff_and_explicit_steppers_agree(database):
    ways = [
        simulate(compile_scene(afloat(database, FLYING, {"integrator": name, "tolerance": 1e-9})), 2.0, 0.5)
        for name in ("rk54", "radau")
    ]
    assert_near(ways[0]["barge.position"], ways[1]["barge.position"], 1e-6)


def test_one_of_two_bodies_is_taken_out(database):
    """The others held still: its own blocks alone, and a notice."""
    scene = afloat(database, on=["barge"], bodies=[2], radiation=False, outputs=[])
    model = compile_scene(scene)
    assert model.n_shared_water == 0 and model.formulation == "recursive"
    assert_near(model.views()[0].six_by_six_added[:36].reshape(6, 6) / 1e6, INFINITE[6:, 6:] / 1e6, 1e-9)
    assert any(
        "holds 2 bodies; those that are not in `bodies` are as if held still" in text
        for text in model.notices
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"on": ["ship"]}, 'two.1: holds 2 bodies, `on` names 1; needs an end for each, as in on = ["body_1", "body_2"]'),
        ({"bodies": [1, 3]}, "two.1: holds 2 bodies; there is no 3"),
        ({"bodies": [1]}, "two.1: `on` names 2 ends, `bodies` 1; one for each"),
        ({"bodies": [1, 1]}, "body 1 is listed twice"),
        ({"bodies": [0]}, "numbers of bodies are whole, from 1; found 0"),
        ({"on": ["ship", "ship"]}, 'two of them are on "ship"; each is a body of its own'),
        ({"on": ["ship", "ground"]}, '"ground" does not move by a load; name a body'),
        ({"on": ["ship", "barg"]}, 'no body "barg"'),
        ({"solver": {"formulation": "recursive"}}, 'need "embedding", or "auto"; found "recursive"'),
        ({"solver": {"formulation": "augmented"}}, 'need "embedding", or "auto"; found "augmented"'),
    ],
)  # fmt: skip
def test_mistakes_are_told(database, change, words):
    with pytest.raises((SceneError, ValueError)) as error:
        compile_scene(afloat(database, **change))
    assert words in str(error.value)


def test_boxes_by_capytaine_are_read(tmp_path):
    """Two boxes side by side: beside waves they feel the same, and the file's places are known."""
    cpt = pytest.importorskip("capytaine")
    cpt.set_logging("ERROR")
    xarray = pytest.importorskip("xarray")

    def box(x, name):
        mesh = cpt.mesh_parallelepiped(size=(4, 4, 2), center=(x, 0, 0), resolution=(4, 4, 2), name=name)
        dofs = cpt.rigid_body_dofs(rotation_center=(x, 0, 0))
        return cpt.FloatingBody(mesh=mesh.immersed_part(), dofs=dofs, name=name)

    both = box(-4, "a") + box(4, "b")
    asked = {
        "omega": [0.5, 1.0, 1.5, 2.0],
        "wave_direction": [0.0, np.pi / 2],
        "radiating_dof": list(both.dofs),
    }
    cpt.export_dataset(tmp_path / "two.nc", cpt.BEMSolver().fill_dataset(xarray.Dataset(coords=asked), both))
    found = read_coefficients(tmp_path / "two.nc", 1000.0, 9.81)
    assert found.bodies == 2
    assert_near(found.excitation[:, 1, 2] / found.excitation[:, 1, 8], 1.0, 0.01)

    # the lee is half a wave and more behind
    behind = np.angle(found.excitation[:, 0, 8] / found.excitation[:, 0, 2])
    assert_near(behind[0], -(0.5**2) / 9.81 * 8, 0.02)
    assert_near(found.added[:, 2, 8] / found.added[:, 8, 2], 1.0, 0.02)
    assert np.abs(found.added[0, 2, 8]) > 0.05 * found.added[0, 2, 2]
