"""Random tree scenes, and small helpers on instances, for the tests of the kernels."""

from typing import NamedTuple

import numpy as np
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import forces
from mbdfmi.kernels.dynamics import embedding, inertia, inverse, rates
from mbdfmi.kernels.motion import kinematics
from mbdfmi.run.instance import Instance

KINDS = ("revolute", "prismatic", "spherical", "free", "fixed")
AXES = ("first", "heading", "body")

# the same examples in every run
examples = settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.generate, Phase.shrink],
)


def random_orientation(rng) -> np.ndarray:
    """Uniformly distributed Euler parameters (4,), unit length."""
    E = rng.normal(size=4)
    return E / np.linalg.norm(E)


def random_scene(
    seed: int,
    n_body: int,
    *,
    kinds=KINDS,
    branching: float = 0.5,
    floating: bool = False,
    elements: bool = True,
    linear: bool = True,
    added_mass: bool = True,
    symmetric: bool = True,
    inputs: bool = True,
    gravity: bool = True,
) -> Scene:
    """A random tree of `n_body` bodies.

    kinds : of the joints. branching : 0 a chain, 1 any earlier body or the ground is the parent.
    floating : only free joints on the ground, and no force leads there.
    elements : springs, dampers, struts, and unless not `linear` 6x6 forces. symmetric : their matrices are.
    added_mass : some bodies carry some (linear forces that do nothing else when `floating`).
    inputs : efforts in joints; wrenches on bodies and markers, unless `floating`.

    Joints are listed in any order and direction.
    """
    rng = np.random.default_rng(seed)

    def chance(p):
        return rng.random() < p

    def vector(size=1.0):
        return (size * rng.normal(size=3)).tolist()

    def pose():
        return {"position": vector(0.5), "euler_parameters": random_orientation(rng).tolist()}

    def matrix(n, definite):
        L = rng.normal(size=(n, n))
        return (L @ L.T if definite else L + L.T if symmetric else L).tolist()

    def end(owner):
        marker = rng.choice(["", ".a", ".b"])
        return owner + str(marker)

    names = [f"body {k}" for k in range(1, n_body + 1)]
    body, joint, force = {}, {}, {}

    for name in names:
        # principal moments of a real body: sums of two of three non-negative numbers
        p = rng.uniform(0.02, 1.0, 3)
        body[name] = {
            "mass": rng.uniform(0.5, 3.0),
            "com": vector(0.4),
            "inertia": [p[1] + p[2], p[0] + p[2], p[0] + p[1]],
            "inertia_axes": {"euler_parameters": random_orientation(rng).tolist()},
            "marker": {"a": pose(), "b": pose(), "c": pose()},
        }

        if inputs and not floating and chance(0.3):
            owner = body[name]["marker"]["a"] if chance(0.5) else body[name]
            owner["input"] = [["force"], ["moment"], ["force", "moment"]][rng.integers(3)]
            owner["input_axes"] = "body" if chance(0.5) else "inertial"

    for k, name in enumerate(names):
        parent = names[k - 1] if k else "ground"

        if chance(branching):
            parent = "ground" if k == 0 or chance(0.15) else names[rng.integers(k)]

        kind = "free" if floating and parent == "ground" else str(rng.choice(kinds))
        ends = [end(parent), end(name)]
        spec = {kind: {}, "between": ends[::-1] if chance(0.5) else ends}
        joint[f"joint {k + 1}"] = spec
        turned = {"euler_parameters": random_orientation(rng).tolist()}
        turned["omega_body" if chance(0.5) else "omega"] = vector()

        if kind in ("revolute", "prismatic"):
            spec[kind] = {"axis": vector()}
            position = "angle" if kind == "revolute" else "position"
            spec["start"] = {position: rng.normal(), "speed": rng.normal()}

            if elements and chance(0.4):
                spec["spring"] = {"stiffness": rng.uniform(0, 5), "rest": rng.normal()}

            if elements and chance(0.4):
                spec["damper"] = rng.uniform(0, 2)

        elif kind == "spherical":
            spec["start"] = turned

        elif kind == "free":
            spec["start"] = turned | {"position": vector(), "velocity": vector()}

        if inputs and kind in ("revolute", "spherical", "prismatic") and chance(0.5):
            spec["input"] = "force" if kind == "prismatic" else "torque"

    owners = names if floating else ["ground", *names]

    for k in range(1 + n_body // 4 if elements and len(owners) > 1 else 0):
        # at markers that no joint holds together
        pair = [f"{owner}.c" for owner in rng.choice(owners, 2, replace=False)]
        spring = {"stiffness": rng.uniform(0, 5), "damping": rng.uniform(0, 2)}

        if chance(0.7):
            spring["rest_length"] = rng.uniform(0, 2)

        force[f"strut {k}"] = {"spring_damper": spring, "between": pair}

        if linear and chance(0.7):
            pair = [end(str(owner)) for owner in rng.choice(owners, 2, replace=False)]
            matrices = {
                "stiffness": matrix(6, False),
                "damping": matrix(6, symmetric),
                "preload": rng.normal(size=6).tolist(),
                "axes": AXES[k % 3],
            }
            force[f"linear {k}"] = {"linear": matrices, "between": pair}

    for name in names:
        if added_mass and chance(0.25):
            pair = ["ground.a", f"{name}.b"]
            water = {"added_mass": matrix(6, True), "axes": AXES[len(force) % 3]}
            force[f"water {name}"] = {"linear": water, "between": pair}

    def shuffled(table):
        keys = list(table)
        rng.shuffle(keys)
        return {key: table[key] for key in keys}

    return Scene.model_validate(
        {
            "name": f"random {seed}",
            "gravity": vector(5.0) if gravity else [0, 0, 0],
            "ground": {"marker": {"a": pose(), "b": pose(), "c": pose()}},
            "body": shuffled(body),
            "joint": shuffled(joint),
            "force": shuffled(force),
        }
    )


class Tree(NamedTuple):
    """What makes a random scene; short enough to be printed when a test fails."""

    seed: int
    n_body: int
    options: dict

    def scene(self) -> Scene:
        """The scene itself."""
        return random_scene(self.seed, self.n_body, **self.options)


@st.composite
def trees(draw, **options):
    """A hypothesis strategy of `Tree`s of 1 to 30 bodies, some of joints of one kind, some pure chains."""
    options |= {
        "kinds": draw(st.sampled_from([KINDS, *((kind,) for kind in KINDS)])),
        "branching": draw(st.sampled_from([0.0, 0.5, 1.0])),
    }
    return Tree(draw(st.integers(0, 2**32 - 1)), draw(st.integers(1, 30)), options)


def random_instance(scene: Scene, seed: int = 0) -> Instance:
    """An instance with random inputs."""
    instance = Instance(compile_scene(scene))
    instance.u[:] = np.random.default_rng(seed).normal(size=len(instance.u))
    return instance


def inputs_of(instance: Instance) -> dict[str, np.ndarray]:
    """The inputs' values by name, arrays as one: "'body 1'.force" -> (3,), "'joint 1'.torque" -> (1,)."""
    values = {}

    for v in instance.model.of_causality("input"):
        values.setdefault(v.name.partition("[")[0], []).append(instance.u[v.index])

    return {name: np.array(value) for name, value in values.items()}


def evaluate(instance: Instance) -> np.ndarray:
    """x' of the state now, a copy; leaves all that the kernels know of the accelerations in d."""
    assert rates.evaluate(instance.m, instance.d, 0.0) == 0
    return instance.d.x_rate.copy()


def velocities(instance: Instance) -> np.ndarray:
    """v (n_v,), a view."""
    return instance.d.v


def inverse_dynamics(instance: Instance, accelerations) -> np.ndarray:
    """Joint efforts (n_v,) that RNEA finds for accelerations v' (n_v,), beside the applied wrenches."""
    m, d = instance.m, instance.d
    kinematics.kinematics(m, d)
    inertia.inertias(m, d)
    forces.apply(m, d)
    d.v_rate[:] = accelerations
    tau = np.zeros(m.n_v)
    inverse.rnea(m, d, tau)
    return tau


def mass_matrix(instance: Instance) -> np.ndarray:
    """M (n_v, n_v) that CRBA finds."""
    m, d = instance.m, instance.d
    kinematics.kinematics(m, d)
    inertia.inertias(m, d)
    M = np.empty((m.n_v, m.n_v))
    embedding.crba(m, d, M.ravel())
    return M


def energies(instance: Instance) -> tuple[float, float]:
    """(kinetic, potential) energy in J of the state now."""
    m, d = instance.m, instance.d
    kinematics.kinematics(m, d)
    inertia.inertias(m, d)
    return inertia.kinetic_energy(m, d), inertia.gravity_energy(m, d) + forces.stored_energy(m, d)


def rows(array, *shape) -> np.ndarray:
    """A flat array of a view as many arrays of `shape`."""
    return array.reshape(-1, *shape)


def body_motion(instance: Instance, accelerated: bool = False) -> dict[str, tuple]:
    """Of each of the user's bodies, in inertial axes: position of its frame (m), axes (3, 3), angular velocity and
    velocity of its centre of mass, and when `accelerated` (after `evaluate`) their rates.
    """
    m, d = instance.m, instance.d

    if not accelerated:
        kinematics.kinematics(m, d)

    motion = {}

    for k, name in enumerate(instance.model.scene.body):
        i = m.solid_body[k]
        A, w = rows(d.A, 3, 3)[i], rows(d.w, 3)[i]
        r, R = rows(m.solid_r, 3)[k], rows(m.solid_A, 3, 3)[k]
        c = A @ (r + R @ rows(m.solid_com, 3)[k])
        motion[name] = (rows(d.r, 3)[i] + A @ r, A @ R, w.copy(), rows(d.rd, 3)[i] + np.cross(w, c))

        if accelerated:
            alpha = rows(d.alpha, 3)[i]
            a = rows(d.rdd, 3)[i] + np.cross(alpha, c) + np.cross(w, np.cross(w, c))
            motion[name] += (alpha.copy(), a)

    return motion


def momenta(instance: Instance) -> tuple[np.ndarray, np.ndarray]:
    """(linear, angular about the inertial origin) momentum of the bodies alone."""
    linear = angular = np.zeros(3)

    for name, (r, A, w, v) in body_motion(instance).items():
        mass, com, inertia = instance.model.scene.body[name].mass_properties()
        linear = linear + mass * v
        angular = angular + np.cross(r + A @ com, mass * v) + A @ inertia @ A.T @ w

    return linear, angular


def rotation(E) -> Rotation:
    """scipy's rotation of Euler parameters (scalar last in both)."""
    return Rotation.from_quat(E)


def assert_near(actual, desired, atol=0.0, rtol=0.0):
    """numpy's assert_allclose without its relative tolerance of 1e-7."""
    assert_allclose(actual, desired, rtol=rtol, atol=atol)
