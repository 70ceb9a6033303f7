"""Added mass of linear theory, in each of its systems of axes: closed forms, what is conserved, independent routes.

The random trees of `test_kernels_dynamics` compare accelerations and powers with a second route in every system of axes.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import AXES, evaluate, random_scene, velocities
from scipy.spatial.transform import Rotation

import mbdfmi
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance

FORMULATIONS = ("recursive", "embedding", "augmented")
STILL = [0.0, 0.0, 0.0]

every_axes = pytest.mark.parametrize("axes", AXES)
every_formulation = pytest.mark.parametrize("formulation", FORMULATIONS)
every_seed = pytest.mark.parametrize("seed", range(3))


def positive(seed, n=6):
    """A random symmetric positive definite matrix."""
    L = np.random.default_rng(seed).normal(size=(n, n))
    return L @ L.T + 0.3 * np.eye(n)


def water(A, axes=None, between=("ground", "hull"), **more):
    """A linear force with added mass."""
    linear = {"added_mass": np.asarray(A).tolist()} | {
        key: np.asarray(value).tolist() for key, value in more.items()
    }
    return {"linear": linear | ({"axes": axes} if axes else {}), "between": list(between)}


def hull_scene(
    forces, start=None, gravity=STILL, formulation="auto", tolerance=1e-11, marker=None, body=None, **more
):
    """A body of 2 kg, its centre of mass off its origin, afloat; "first" marker "sea" of the ground where given."""
    hull = {"mass": 2.0, "com": [0.1, -0.2, 0.15], "inertia": [0.5, 0.7, 0.8], "marker": marker or {}}
    return mbdfmi.Scene.model_validate(
        {
            "name": "hull",
            "gravity": gravity,
            "solver": {"integrator": "rk853", "tolerance": tolerance, "formulation": formulation},
            "body": {
                "hull": hull | {"output": ["position", "zyx", "velocity", "omega", "alpha"]} | (body or {})
            },
            "joint": {"afloat": {"free": {}, "between": ["ground", "hull"], "start": start or {}}},
            "force": forces,
            "output": ["total_energy", "kinetic_energy", "linear_momentum", "angular_momentum"],
        }
        | more
    )


def skew(a):
    """The matrix of a x."""
    return np.cross(np.eye(3), a)


def accelerations(scene):
    """Of the hull's origin, with v' = (r'', alpha) in its axes: (6,)."""
    instance = Instance(compile_scene(scene))
    return evaluate(instance)[instance.m.n_q :]


MARKER = {"p": {"position": [0.3, -0.25, 0.4], "zyx_deg": [35, -20, 50]}}
MOVING = {
    "position": [0.2, 0.3, -0.1],
    "zyx_deg": [40, -25, 30],
    "velocity": [0.8, -0.5, 0.6],
    "omega": [0.4, 0.7, -0.9],
}


# ---- Munk's moment


@every_formulation
@pytest.mark.parametrize("u, w", [(1.0, 0.5), (-2.0, 0.3), (0.7, -1.9)])
@pytest.mark.parametrize("axes", [None, *AXES])
def test_munks_moment(axes, u, w, formulation):
    """A body without rotation that moves with (u, 0, w) feels (A33 - A11) u w when its added mass turns with it."""
    A = np.diag([1.0, 2.5, 4.0, 0.3, 0.6, 0.2])
    body = {"com": STILL}
    scene = hull_scene({"water": water(A, axes)}, {"velocity": [u, 0, w]}, body=body, formulation=formulation)
    moment = (0.7 + 0.6) * accelerations(scene)[4]
    assert moment == pytest.approx((4.0 - 1.0) * u * w if axes == "body" else 0.0, abs=1e-14)


@pytest.mark.parametrize("axes", AXES)
def test_munks_moment_in_the_plane(axes):
    """In yaw a body feels (A11 - A22) u v where its added mass follows its heading."""
    A = np.diag([1.0, 2.5, 4.0, 0.3, 0.6, 0.2])
    scene = hull_scene({"water": water(A, axes)}, {"velocity": [0.7, -0.4, 0]}, body={"com": STILL})
    moment = (0.8 + 0.2) * accelerations(scene)[5]
    assert moment == pytest.approx((1.0 - 2.5) * 0.7 * -0.4 if axes != "first" else 0.0, abs=1e-14)


# ---- the load by its definition


@every_seed
@every_formulation
def test_the_load_is_that_of_the_material_points_acceleration(seed, formulation):
    """Newton and Euler about the centre of mass with -A (r''_P, alpha) in the first marker's axes, without velocity products."""
    A = positive(seed)
    ground = {"marker": {"sea": {"position": [0.4, 0.1, -0.2], "zyx_deg": [-70, 30, 15]}}}
    forces = {"water": water(A, None, ("ground.sea", "hull.p"))}
    scene = hull_scene(forces, MOVING, [0.3, 0.2, -9.81], formulation, marker=MARKER, ground=ground)
    instance = Instance(compile_scene(scene))
    evaluate(instance)
    values = instance.outputs()
    at = {v.name: v.index for v in instance.model.of_causality("output")}
    alpha = np.array([values[at[f"hull.alpha[{k}]"]] for k in (1, 2, 3)])

    # the second route: unknowns are the acceleration of the origin and alpha
    R = Rotation.from_euler("ZYX", MOVING["zyx_deg"], degrees=True).as_matrix()
    G = np.kron(np.eye(2), Rotation.from_euler("ZYX", [-70, 30, 15], degrees=True).as_matrix())
    w = np.array(MOVING["omega"])
    c, p = R @ [0.1, -0.2, 0.15], R @ MARKER["p"]["position"]

    J = R @ np.diag([0.5, 0.7, 0.8]) @ R.T
    to_com = np.block([[np.eye(3), -skew(c)], [np.zeros((3, 3)), np.eye(3)]])
    to_p = np.block([[np.eye(3), -skew(p)], [np.zeros((3, 3)), np.eye(3)]])
    rigid = np.block([[2.0 * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), J]])
    added = G @ A @ G.T
    b_com = np.concatenate([np.cross(w, np.cross(w, c)), STILL])
    b_p = np.concatenate([np.cross(w, np.cross(w, p)), STILL])
    weight = np.concatenate([2.0 * np.array([0.3, 0.2, -9.81]), -np.cross(w, J @ w)])
    M = to_com.T @ rigid @ to_com + to_p.T @ added @ to_p
    found = np.linalg.solve(M, to_com.T @ (weight - rigid @ b_com) - to_p.T @ added @ b_p)
    assert_allclose(alpha, found[3:], rtol=0, atol=1e-12 * np.abs(found).max())


@every_axes
def test_from_rest_it_is_an_inertia_that_has_turned_as_far_as_its_axes(axes):
    """A (psi) for the heading; the moment of inertia that a force sees from rest tells which A it is."""
    A, yaw, pitch = positive(5), 0.7, 0.4
    turned = Rotation.from_euler("ZYX", [yaw, pitch, 0])
    of_axes = {"first": Rotation.identity(), "heading": Rotation.from_euler("z", yaw), "body": turned}[axes]
    body = {"com": STILL, "mass": 2.0, "inertia": [0.5, 0.5, 0.5]}
    start = {"zyx_rad": [yaw, pitch, 0]}
    scene = hull_scene({"water": water(A, axes)}, start, [1.0, 2.0, 3.0], body=body)
    T = np.kron(np.eye(2), of_axes.as_matrix())
    M = T @ A @ T.T + np.diag([2.0] * 3 + [0.5] * 3)
    found = np.linalg.solve(M, [2.0, 4.0, 6.0, 0, 0, 0])

    # v' is along the ground's axes, alpha along the hull's; with a pitch rx = 0 the yaw of the twist is that of zyx
    found[3:] = turned.inv().apply(found[3:])
    assert_allclose(accelerations(scene), found, rtol=0, atol=1e-13)


# ---- energy, momentum


@every_seed
@every_axes
def test_energy_is_kept_with_stiffness_and_added_mass(axes, seed):
    """At every communication point; both markers away from the origins and turned."""
    ground = {"marker": {"sea": {"position": [0.4, -0.1, 0.3], "zyx_deg": [45, -10, 40]}}}
    more = {"stiffness": positive(seed + 10), "preload": [0.5, 0.4, -0.3, 0.2, -0.1, 0.2]}
    forces = {"water": water(positive(seed), axes, ("ground.sea", "hull.p"), **more)}
    start = {"zyx_deg": [20, 10, -15], "omega": [0.8, -0.6, 0.7], "velocity": [0.5, 0.4, -0.3]}
    run = hull_scene(forces, start, [0, 0, -0.5], marker=MARKER, ground=ground).simulate(2.0, step=0.1)
    energy = run["total_energy"]
    assert np.ptp(run["hull.zyx"]) > 0.3 and np.ptp(run["kinetic_energy"]) > 0.3
    assert np.abs(energy - energy[0]).max() < 1e-9 * np.abs(run["kinetic_energy"]).max()


def test_energy_is_kept_through_many_turns_of_yaw():
    """A heading that goes round and round, surging and swaying on springs."""
    A = np.diag([1.0, 5.0, 2.0, 0.3, 0.6, 0.9])
    A[1, 5] = A[5, 1] = 0.8
    forces = {"water": water(A, "heading", stiffness=np.diag([3.0, 3, 3, 2, 2, 0]))}
    start = {"velocity": [0.5, -0.3, 0.2], "omega": [0.1, -0.2, 3.0]}
    run = hull_scene(forces, start).simulate(10, step=0.05)
    turns = np.unwrap(run["hull.zyx"][:, 0]) / (2 * np.pi)
    energy = run["total_energy"]
    assert turns[-1] > 3
    assert np.abs(energy - energy[0]).max() < 1e-8 * energy[0]


@pytest.mark.parametrize("seed", range(2))
def test_in_plane_motion_the_heading_is_that_of_the_body(seed):
    """Surge, sway and yaw by Kirchhoff's equations; momentum, and its moment about the vertical, stay."""
    A = positive(seed)
    plane, other = [0, 1, 5], [2, 3, 4]
    A[np.ix_(plane, other)] = A[np.ix_(other, plane)] = 0
    start = {"velocity": [0.9, -0.6, 0], "omega": [0, 0, 1.3], "zyx_deg": [50, 0, 0]}
    marker = {"p": {"position": [0.5, -0.3, 0], "zyx_deg": [25, 0, 0]}}
    body = {"com": [0.2, 0.1, 0]}

    def run(axes, matrix):
        forces = {"water": water(matrix, axes, ("ground", "hull.p"))}
        return hull_scene(forces, start, marker=marker, body=body).simulate(5, step=0.25)

    # the heading's axes are the first marker's turned by the yaw of the second, 25 deg ahead of the hull
    heading, kirchhoff = run("heading", A), run("body", A)
    for name in ("hull.position", "hull.omega", "linear_momentum"):
        assert_allclose(heading[name], kirchhoff[name], rtol=0, atol=1e-8)
    for momentum in (heading["linear_momentum"], heading["angular_momentum"][:, 2]):
        assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), rtol=0, atol=1e-8)


def test_momentum_of_fixed_axes():
    """A v of constant A is conserved as m v is: force = - dp/dt."""
    run = hull_scene({"water": water(positive(2), "first")}, MOVING).simulate(4, step=0.5)
    momentum = run["linear_momentum"]
    assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), rtol=0, atol=1e-9)


# ---- the same by other ways


def test_a_ball_is_the_same_in_all_axes():
    """A = c 1: nothing turns. Deep in water or not, at a marker anywhere."""
    forces = {axes: {"water": water(1.7 * np.eye(6), axes, ("ground", "hull.p"))} for axes in AXES}
    runs = [
        hull_scene(forces[axes], MOVING, [0, 1, -2], marker=MARKER).simulate(2, step=0.2) for axes in AXES
    ]

    for run in runs[1:]:
        for name in ("hull.position", "hull.omega", "total_energy"):
            assert_allclose(run[name], runs[0][name], rtol=0, atol=1e-9)


@every_axes
def test_two_forces_on_one_body_add_up(axes):
    A, B = positive(3), positive(4)
    ends = ("ground", "hull.p")
    both = {"a": water(A, axes, ends), "b": water(B, axes, ends)}
    one = hull_scene({"c": water(A + B, axes, ends)}, MOVING, marker=MARKER)
    assert_allclose(
        accelerations(hull_scene(both, MOVING, marker=MARKER)), accelerations(one), rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("axes", ["first", "heading"])
def test_a_turned_first_marker(axes):
    """A of the turned axes; of a heading only those turned about the vertical."""
    turn = [65, 0, 0] if axes == "heading" else [65, -20, 35]
    T = np.kron(np.eye(2), Rotation.from_euler("ZYX", turn, degrees=True).as_matrix())
    A = positive(6)
    ground = {"marker": {"sea": {"position": [3, 2, 1], "zyx_deg": turn}}}
    turned = hull_scene({"w": water(A, axes, ("ground.sea", "hull.p"))}, MOVING, marker=MARKER, ground=ground)

    # the twist of the heading is counted from the first marker: less what that has turned by itself
    other = T @ A @ T.T if axes == "first" else A
    straight = hull_scene({"w": water(other, axes, ("ground", "hull.p"))}, MOVING, marker=MARKER)
    assert_allclose(accelerations(turned), accelerations(straight), rtol=0, atol=1e-12)


def test_in_the_bodys_axes_the_marker_does_not_matter():
    """Kirchhoff's momenta about another point of the body are those of the matrix shifted there and turned."""
    A = positive(7)
    p = np.array(MARKER["p"]["position"])
    R = Rotation.from_euler("ZYX", MARKER["p"]["zyx_deg"], degrees=True).as_matrix()
    T = np.kron(np.eye(2), R.T) @ np.block([[np.eye(3), -skew(p)], [np.zeros((3, 3)), np.eye(3)]])
    at_marker = hull_scene({"w": water(A, "body", ("ground", "hull.p"))}, MOVING, marker=MARKER)
    at_origin = hull_scene({"w": water(T.T @ A @ T, "body")}, MOVING)
    assert_allclose(accelerations(at_marker), accelerations(at_origin), rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_formulations_agree(seed):
    """On trees with added mass in every system of axes, as the bodies' motion shows it."""
    scene = random_scene(50 + seed, 5)
    bodies = {
        name: body.model_copy(update={"output": ["alpha", "acceleration"]})
        for name, body in scene.body.items()
    }
    force = {
        f"water {k}": {
            "linear": {"added_mass": positive(k).tolist(), "axes": axes},
            "between": ["ground.a", f"{name}.b"],
        }
        for k, (axes, name) in enumerate(zip(AXES, scene.body))
    }
    data = scene.model_copy(update={"body": bodies}).model_dump(exclude_unset=True)
    data["force"] = data["force"] | force
    found = []

    for formulation in FORMULATIONS:
        data["solver"] = {"formulation": formulation}
        instance = Instance(compile_scene(mbdfmi.Scene.model_validate(data)))
        found.append(instance.outputs().copy())

    for other in found[1:]:
        assert_allclose(other, found[0], rtol=0, atol=1e-10 * max(1, np.abs(found[0]).max()))


# ---- what joints bear


@every_formulation
@every_axes
def test_reactions_bear_the_water(axes, formulation):
    """An arm driven about z at a constant speed: what its hinge bears is centripetal, of the arm and of the water."""
    A, speed, angle, arm = np.diag([1.0, 3.0, 2.0, 0.2, 0.3, 0.4]), 1.7, 0.6, np.array([0.8, 0, 0])
    scene = mbdfmi.Scene.model_validate(
        {
            "name": "arm",
            "gravity": STILL,
            "solver": {"formulation": formulation},
            "body": {
                "arm": {
                    "mass": 2.0,
                    "com": [0.5, 0, 0],
                    "inertia": [0.1] * 3,
                    "marker": {"p": {"position": arm.tolist()}},
                }
            },
            "joint": {
                "hinge": {
                    "revolute": {},
                    "between": ["ground", "arm"],
                    "driver": {"harmonic": {"amplitude": speed, "frequency": 1 / (2 * np.pi), "mean": angle}},
                    "output": ["reaction_force", "effort", "angle", "speed", "acceleration"],
                }
            },
            "force": {"water": water(A, axes, ("ground", "arm.p"))},
        }
    )
    run = scene.simulate(2.0, step=0.25)
    x, rate, acceleration = run["hinge.angle"], run["hinge.speed"], run["hinge.acceleration"]

    for k in range(len(x)):
        R = Rotation.from_euler("z", x[k]).as_matrix()
        w, alpha = np.array([0, 0, rate[k]]), np.array([0, 0, acceleration[k]])

        def accelerated(r):
            return np.cross(alpha, R @ r) + np.cross(w, np.cross(w, R @ r))

        # in the plane the water's momentum is A v, in axes that turn with the arm or do not
        v, a = np.cross(w, R @ arm), accelerated(arm)
        M = np.diag(A)[:3]

        if axes == "first":
            pushed, lift = M * a, 0.0
        else:
            p = R @ (M * (R.T @ v))
            pushed = np.cross(w, p) + R @ (M * (R.T @ (a - np.cross(w, v))))
            lift = np.cross(v, p)[2]

        force = 2.0 * accelerated(np.array([0.5, 0, 0])) + pushed
        assert_allclose(run["hinge.reaction_force"][k], force, rtol=0, atol=1e-11)
        torque = (0.1 + 2.0 * 0.25 + 0.4) * acceleration[k] + np.cross(R @ arm, pushed)[2] + lift
        assert run["hinge.effort"][k] == pytest.approx(torque, abs=1e-11)


# ---- damping


@every_axes
def test_damping_is_along_its_axes(axes):
    """A hull turned by 90 deg that slides along x loses its speed by the damping that lies along x then."""
    start = {"velocity": [1.0, 0, 0], "zyx_deg": [90, 0, 0]}
    D = np.diag([0.6, 2.4, 1.0, 1.0, 1.0, 1.0])
    force = {"linear": {"damping": D.tolist(), "axes": axes}, "between": ["ground", "hull"]}
    run = hull_scene({"drag": force}, start, body={"com": STILL}).simulate(2, step=0.2)
    d = 0.6 if axes == "first" else 2.4
    assert_allclose(run["hull.velocity"][:, 0], np.exp(-d / 2.0 * run["time"]), rtol=0, atol=1e-9)


# ---- water that moves with the ground


@every_axes
def test_a_ground_that_glides_takes_the_water_along(axes):
    """Galileo: everything seen from a ground of constant velocity is as on one at rest."""
    forces = {"water": water(positive(8), axes, ("ground", "hull.p"), damping=positive(9))}
    still = hull_scene(forces, MOVING, marker=MARKER)
    motion = {"acceleration": STILL, "velocity": [3, -2, 1]}
    gliding = hull_scene(forces, MOVING, marker=MARKER, ground={"motion": motion})
    assert_allclose(accelerations(gliding)[-6:], accelerations(still), rtol=0, atol=1e-12)


@every_axes
def test_a_ground_that_gathers_speed_is_a_weight(axes):
    """Seen from there, an acceleration of the ground is weight of the body, not of the water."""
    forces = {"water": water(positive(8), axes, ("ground", "hull.p"))}
    motion = {"acceleration": [0.3, -0.2, 1.5]}
    scene = hull_scene(forces, MOVING, [0, 0, -9.81], marker=MARKER, ground={"motion": motion})
    heavy = hull_scene(forces, MOVING, [-0.3, 0.2, -11.31], marker=MARKER)
    assert_allclose(accelerations(scene)[-6:], accelerations(heavy), rtol=0, atol=1e-12)


@every_axes
def test_a_ground_that_turns_keeps_its_integral(axes):
    """E - Omega . L of the body plus the energy of the water, seen from the ground, is constant (Jacobi)."""
    rate = np.array([0.0, 0.0, 0.8])
    motion = {"rotation": {"axis": "z", "speed": 0.8}}
    forces = {"water": water(positive(8), axes, ("ground", "hull.p"))}
    more = {"marker": MARKER | {"com": {"position": [0.1, -0.2, 0.15], "output": ["position", "velocity"]}}}
    scene = hull_scene(forces, MOVING, ground={"motion": motion}, **more)
    run = scene.simulate(3, step=0.1)
    r, v, w = run["hull.com.position"], run["hull.com.velocity"], run["hull.omega"]
    R = Rotation.from_euler("ZYX", run["hull.zyx"]).as_matrix()
    spin = np.einsum("tij,j,tkj,tk->ti", R, [0.5, 0.7, 0.8], R, w)
    integral = run["total_energy"] - (2.0 * np.cross(r, v) + spin) @ rate
    assert np.ptp(run["total_energy"]) > 0.01
    assert np.abs(integral - integral[0]).max() < 1e-9 * np.abs(run["kinetic_energy"]).max()


def test_the_inertial_frame_as_first_end_is_water_at_rest():
    """Beside a ground that moves: as if that stood still."""
    A = positive(8)
    motion = {"acceleration": [0.3, -0.2, 1.5]}
    inertial = {"water": water(A, None, ("inertial", "hull.p"))}
    moving = hull_scene(inertial, MOVING, marker=MARKER, ground={"motion": motion})
    moving = moving.model_copy(
        update={
            "joint": {"afloat": moving.joint["afloat"].model_copy(update={"between": ("inertial", "hull")})}
        }
    )
    still = hull_scene({"water": water(A, None, ("ground", "hull.p"))}, MOVING, marker=MARKER)
    assert_allclose(accelerations(moving)[-6:], accelerations(still), rtol=0, atol=1e-12)


# ---- what is said of it


def test_axes_are_one_of_three():
    with pytest.raises(mbdfmi.SceneError, match="axes"):
        mbdfmi.Scene(
            name="x",
            body={"hull": {"mass": 1, "inertia": [1, 1, 1]}},
            joint={},
            force={
                "water": {
                    "linear": {"added_mass": np.eye(6).tolist(), "axes": "hull"},
                    "between": ["ground", "hull"],
                }
            },
        )


@every_axes
def test_as_a_parameter(axes):
    """Set from outside it is that of a scene written so."""
    A, B = positive(3), positive(4)
    scene = hull_scene({"w": water(A, axes, ("ground", "hull.p"))}, MOVING, marker=MARKER)
    other = hull_scene({"w": water(B, axes, ("ground", "hull.p"))}, MOVING, marker=MARKER)
    changed = {f"w.added_mass[{j + 1},{k + 1}]": B[j, k] for j in range(6) for k in range(6)}
    instance = Instance(compile_scene(scene), changed)
    evaluate(instance)
    assert_allclose(instance.d.x_rate[instance.m.n_q :], accelerations(other), rtol=0, atol=1e-14)
    assert velocities(instance).shape == (6,)
