"""Quasi-static lines: closed forms, a second way to solve them, their stiffness, energy."""

import numpy as np
import pytest
from scenes import assert_near
from scipy.integrate import quad

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.forces import catenaries
from mbdfmi.kernels.language import INTERPRETED
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

G = 9.80665
CHAIN = {"length": 473.3, "mass": 130.4, "diameter": 0.0809, "stiffness": 589e6}
OUTPUTS = ["tension", "anchor_tension", "grounded_length", "force", "power"]


def moored(at, line=None, anchor=(0, 0, 0), **scene):
    """A body at a place, held by one line from an anchor on the ground."""
    return Scene.model_validate(
        {
            "name": "moored",
            "gravity": [0, 0, -G],
            "ground": {"marker": {"anchor": {"position": list(anchor)}}},
            "body": {"buoy": {"mass": 1e4, "inertia": [1e4, 1e4, 1e4]}},
            "joint": {"sea": {"free": {}, "between": ["ground", "buoy"], "start": {"position": list(at)}}},
            "force": {
                "line": {"catenary": line or CHAIN, "between": ["ground.anchor", "buoy"], "output": OUTPUTS}
            },
        }
        | scene
    )


class Lines:
    """The kernel that solves a line, asked for single ones."""

    def __init__(self):
        self.instance = Instance(compile_scene(moored([100, 0, 50])))
        self.m, self.d = self.instance.m, self.instance.d

    def pull(self, L, w, EA, x, z, bed):
        """(H, V) at the upper end."""
        self.m.line_length[0], self.m.line_stiffness[0], self.m.line_bed[0] = L, EA, bed
        self.m.line_mass[0] = w / G
        return catenaries.pull(self.m, self.d, 0, x, z)


@pytest.fixture(scope="module")
def lines():
    return Lines()


# closed forms


def test_a_line_that_hardly_stretches_is_a_catenary(lines):
    """z = a (cosh(x / a) - 1) and L = a sinh(x / a) where it leaves the anchor along the bed: H = w a."""
    a, x, w = 40.0, 60.0, 900.0
    H, V = lines.pull(a * np.sinh(x / a), w, 1e15, x, a * (np.cosh(x / a) - 1), 0)
    assert_near([H, V], [w * a, w * a * np.sinh(x / a)], 1e-4)


def test_part_of_it_lies_on_the_bed(lines):
    a, x, w, flat = 40.0, 60.0, 900.0, 25.0
    L = a * np.sinh(x / a) + flat
    H, V = lines.pull(L, w, 1e15, x + flat, a * (np.cosh(x / a) - 1), 1)
    assert_near([H, V], [w * a, w * a * np.sinh(x / a)], 1e-4)


def test_a_taut_line_is_a_bar(lines):
    """As its weight goes to nothing."""
    L, EA = 100.0, 1e7
    span = np.array([80.0, 70.0])
    length = np.hypot(*span)
    H, V = lines.pull(L, 1e-3, EA, *span, 0)
    assert_near([H, V], EA * (length / L - 1) * span / length, 0.1)


def test_a_line_that_hangs_straight_down_bears_its_weight(lines):
    """Slack on the bed by V = EA (sqrt(1 + 2 w z / EA) - 1); lifted off by z = L + (V L - w L^2 / 2) / EA."""
    w, EA = 500.0, 1e6
    H, V = lines.pull(200.0, w, EA, 0.0, 50.0, 1)
    assert H == 0.0
    assert_near(V, EA * (np.sqrt(1 + 2 * w * 50 / EA) - 1), 1e-9 * V)
    H, V = lines.pull(100.0, w, EA, 0.0, 110.0, 1)
    assert_near(V, EA * (10 + w * 100**2 / 2 / EA) / 100, 1e-6)
    assert abs(H) < 1e-3


def test_a_line_along_the_bed_is_a_spring(lines):
    assert lines.pull(100.0, 500.0, 1e6, 101.0, 0.0, 1) == (pytest.approx(1e4), 0.0)
    assert lines.pull(100.0, 500.0, 1e6, 99.0, 0.0, 1) == (0.0, 0.0)


def shape(L, w, EA, H, V, bed):
    """(x, z) of the ends by quadrature of the strained arc."""
    start = max(0.0, L - V / w) if bed else 0.0
    tension = lambda s: np.hypot(H, V - w * (L - s))
    x = start * (1 + H / EA)
    x += quad(lambda s: H * (1 / tension(s) + 1 / EA), start, L, epsabs=0, epsrel=1e-13, limit=400)[0]
    rise = lambda s: (V - w * (L - s)) * (1 / tension(s) + 1 / EA)
    return x, quad(rise, start, L, epsabs=0, epsrel=1e-13, limit=400)[0]


@pytest.mark.parametrize("bed", [0, 1])
def test_ends_are_where_the_arc_leads(lines, bed):
    """By quadrature along the line, at random pulls."""
    rng = np.random.default_rng(1)

    for _ in range(40):
        L, w = 10 ** rng.uniform(1, 3), 10 ** rng.uniform(1, 3)
        EA, H = w * L * 10 ** rng.uniform(0.5, 4), w * L * 10 ** rng.uniform(-1.5, 1)
        V = w * L * (rng.uniform(0.1, 0.9) if bed else rng.uniform(0.55, 3))
        found = lines.pull(L, w, EA, *shape(L, w, EA, H, V, bed), bed)
        stiff = 1e-10 * EA
        assert_near(found, [H, V], stiff + 1e-8 * np.hypot(H, V))


def test_random_lines_all_come_to_an_end(lines):
    """Cold, taut and slack, EA from the weight to a million times it: the ends are met to 1e-10 of the length."""
    rng = np.random.default_rng(2)
    count = 2_000 if INTERPRETED else 100_000

    for k in range(count):
        bed = k % 2
        L, w = 10 ** rng.uniform(0, 4), 10 ** rng.uniform(-1, 4)
        EA = w * L * 10 ** rng.uniform(0, 6)
        reach = L * (1 + w * L / EA) * rng.uniform(0.0, 1.3)
        angle = rng.uniform(0, np.pi / 2)
        x, z = reach * np.cos(angle), reach * np.sin(angle)
        H, V = lines.pull(L, w, EA, x, z, bed)
        assert np.isfinite(H) and np.isfinite(V)

        if H > 0 and V > 0:
            found = catenaries.distances(L, w, EA, bed, H, V)[:2]
            assert np.abs(np.subtract(found, (x, z))).max() < 1e-10 * L + 1e-10 * reach, (L, w, EA, x, z, bed)


# in a scene


def outputs_of(scene):
    instance = Instance(compile_scene(scene))
    found = {}

    for v, value in zip(instance.model.of_causality("output"), instance.outputs()):
        found.setdefault(v.name.removeprefix("line.").partition("[")[0], []).append(value)

    return {name: np.array(value) if len(value) > 1 else value[0] for name, value in found.items()}


def test_outputs_of_a_line_partly_on_the_bed():
    found = outputs_of(moored([300, 300, 150]))
    w = (CHAIN["mass"] - 1025 * np.pi * CHAIN["diameter"] ** 2 / 4) * G
    force = found["force"]
    assert_near(force[0], force[1], 1e-9)
    assert_near(found["tension"], np.linalg.norm(force), 1e-6)
    assert_near(found["anchor_tension"], np.hypot(*force[:2]), 1e-6)
    assert_near(found["grounded_length"], CHAIN["length"] + force[2] / w, 1e-8)


@pytest.mark.parametrize("at", [(300, 300, 150), (330, 300, 150), (20, -10, 100), (100, 50, 30)])
def test_a_buoy_on_a_line_keeps_its_energy(at):
    """Slack, hanging, taut, moving through all of them."""
    scene = moored(
        at,
        output=["total_energy", "spring_energy"],
        solver={"tolerance": 1e-11, "integrator": "rk54"},
        gravity=[0, 0, -G],
    )
    run = simulate(compile_scene(scene), 4.0, 0.1)
    assert_near(run["total_energy"], run["total_energy"][0], 1e-6 * (1 + np.ptp(run["spring_energy"])))


def test_a_line_between_two_bodies_keeps_energy_and_momentum():
    """It hangs between them, its weight theirs to bear, whichever end is the upper one."""
    heavy = {"mass": 2e3, "inertia": [1e3, 1e3, 1e3]}
    start = [{"position": [0, 0, 0], "velocity": [0, 0, 5]}, {"position": [30, 5, 3], "velocity": [0, 0, -5]}]
    scene = Scene.model_validate(
        {
            "name": "two",
            "gravity": [0, 0, -G],
            "output": ["total_energy", "spring_energy", "linear_momentum"],
            "solver": {"tolerance": 1e-11, "integrator": "rk54"},
            "body": {"a": heavy, "b": heavy},
            "joint": {n: {"free": {}, "between": ["ground", n], "start": s} for n, s in zip("ab", start)},
            "force": {
                "line": {
                    "catenary": {"length": 40, "mass": 10, "stiffness": 1e6},
                    "between": ["a", "b"],
                    "output": ["tension", "grounded_length"],
                }
            },
        }
    )
    run = simulate(compile_scene(scene), 2.0, 0.1)
    assert_near(run["total_energy"], run["total_energy"][0], 1e-6 * np.ptp(run["spring_energy"]))
    momentum = run["linear_momentum"][:, 2] + (2 * heavy["mass"] + 400) * G * run["time"]
    assert_near(momentum, momentum[0], 1e-6 * 4e4)
    assert_near(run["line.grounded_length"], 0.0)


def test_a_line_that_floats_and_one_that_is_too_short_are_told():
    with pytest.raises(SceneError, match=r"\[force.line\] catenary.diameter: the line is lighter than"):
        compile_scene(moored([300, 0, 100], CHAIN | {"diameter": 1.0}))

    (notice,) = compile_scene(moored([600, 0, 150], CHAIN)).notices
    assert "catenary.length" in notice and "618.466 m apart" in notice and "stretched by 31 %" in notice


def test_a_line_has_a_bed_where_its_anchor_is_on_one():
    for sea, anchor, bed in (({}, 0, 1), ({"depth": 100}, -100, 1), ({"depth": 100}, -50, 0)):
        scene = moored([100, 0, 10], anchor=[0, 0, anchor], sea=sea)
        assert Instance(compile_scene(scene)).m.line_bed[0] == bed


def test_a_bed_that_rises_and_falls_is_told():
    """Its work is in no power; where no bed is, or none that moves, energy is what the drive brings."""
    for motion, more, told in (
        ({"velocity": [0, 0, 0.3]}, {}, True),
        ({"velocity": [0, 0, 0.3]}, {"bed": False}, False),
        ({}, {}, False),
    ):
        ground = {"marker": {"anchor": {}}} | (
            {"motion": {"acceleration": [0, 0, 0]} | motion} if motion else {}
        )
        model = compile_scene(moored([100, 0, 50], CHAIN | more, ground=ground))
        assert (
            any("catenary.bed: is as high as the first end, which moves" in text for text in model.notices)
            == told
        )


def hywind(surge=0.0, pitch=0.0, yaw=0.0):
    """(6,) of the lines of the OC3-Hywind spar at a displacement (m, rad), about its origin on the waterline."""
    turns = np.radians([0, 120, 240])
    way = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(3)])
    places = {"anchor": way * 853.87 + [0, 0, -320], "fairlead": way * 5.2 + [0, 0, -70]}
    markers = {
        kind: {f"{kind}_{k}": {"position": list(r)} for k, r in enumerate(rows)}
        for kind, rows in places.items()
    }
    line = {"length": 902.2, "mass": 77.7066, "diameter": 0.09, "stiffness": 384.243e6}
    start = {"position": [surge, 0, 0], "zyx_rad": [yaw, pitch, 0]}
    scene = Scene.model_validate(
        {
            "name": "hywind",
            "gravity": [0, 0, -G],
            "ground": {"marker": markers["anchor"]},
            "body": {"spar": {"mass": 1e6, "inertia": [1e9] * 3, "marker": markers["fairlead"]}},
            "joint": {"sea": {"free": {}, "between": ["ground", "spar"], "start": start}},
            "force": {
                f"line {k}": {
                    "catenary": line,
                    "between": [f"ground.anchor_{k}", f"spar.fairlead_{k}"],
                    "output": ["force"],
                }
                for k in range(3)
            },
        }
    )
    instance = Instance(compile_scene(scene))
    forces = np.array(instance.outputs()).reshape(3, 3)
    c, s = np.cos([yaw, pitch]), np.sin([yaw, pitch])
    A = np.array([[c[0], -s[0], 0], [s[0], c[0], 0], [0, 0, 1]]) @ [
        [c[1], 0, s[1]],
        [0, 1, 0],
        [-s[1], 0, c[1]],
    ]
    arms = places["fairlead"] @ A.T
    return np.concatenate([forces.sum(axis=0), np.cross(arms, forces).sum(axis=0)])


def test_the_published_moorings_of_a_spar():
    """OC3-Hywind (Jonkman 2010): F_z -1,607,000 N, C11 41,180 N/m, C55 311.1e6, C66 11.56e6 N m/rad (without the extra yaw spring)."""
    h = 1e-3
    slope = lambda k, **by: -(hywind(**by)[k] - hywind(**{key: -x for key, x in by.items()})[k]) / (2 * h)
    found = [hywind()[2], slope(0, surge=h), slope(4, pitch=h), slope(5, yaw=h)]
    assert_near(np.array(found) / [-1_607_000, 41_180, 311.1e6, 11.56e6], 1.0, 0.005)
