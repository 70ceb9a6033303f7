"""Lines of several sections and friction of the bed: closed forms, lines cut in two, other ways to solve them, energy, random lines."""

import re

import numpy as np
import pytest
from scenes import assert_near
from scipy.integrate import solve_ivp

from mbdfmi import Scene, SceneError
from mbdfmi.analysis.moorings import moorings
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.dynamics import rates
from mbdfmi.kernels.forces import catenaries, composite_lines, composite_pulls, composite_shapes
from mbdfmi.kernels.language import INTERPRETED
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate
from mbdfmi.trace.functions import derivatives

G = 9.80665
OUTPUTS = ["tension", "anchor_tension", "grounded_length", "force", "power"]
CHAIN = {"length": 200.0, "mass": 130.4, "diameter": 0.0809, "stiffness": 589e6}
ROPE = {"length": 250.0, "mass": 30.0, "diameter": 0.14, "stiffness": 80e6}


def moored(at, line, velocity=(0, 0, 0), anchor=(0, 0, 0), **scene):
    """A body at a place, held by one line from an anchor on the ground."""
    start = {"position": list(at), "velocity": list(velocity)}
    return Scene.model_validate(
        {
            "name": "moored",
            "gravity": [0, 0, -G],
            "ground": {"marker": {"anchor": {"position": list(anchor)}}},
            "body": {"buoy": {"mass": 1e4, "inertia": [1e4, 1e4, 1e4], "output": ["position"]}},
            "joint": {"sea": {"free": {}, "between": ["ground", "buoy"], "start": start}},
            "force": {"line": {"catenary": line, "between": ["ground.anchor", "buoy"], "output": OUTPUTS}},
        }
        | scene
    )


class Lines:
    """The kernels of a line of `count` sections, asked for single ones: sections of (L, w, EA, what hangs above, N)."""

    def __init__(self, count):
        section = {"length": 50.0, "mass": 100.0, "stiffness": 1e9}
        sections = [section | {"clump": {"mass": 1.0}}] * (count - 1) + [section]
        line = {"sections": sections, "friction": 1.0}
        self.instance = Instance(compile_scene(moored([100, 0, 50], line)))
        self.m, self.d = self.instance.m, self.instance.d

    def pull(self, sections, x, z, bed, friction=0.0):
        """(H, V) at the second end."""
        m = self.m
        m.composite_bed[0], m.composite_friction[0] = bed, friction

        for k, (L, w, EA, hung) in enumerate(sections):
            m.section_length[k], m.section_mass[k] = L, w / G
            m.section_stiffness[k], m.section_clump[k] = EA, hung / G

        return composite_pulls.pull(m, self.d, 0, x, z)

    def reach(self, H, V):
        """(x, z) of the line asked for last, at some pull."""
        return np.array(composite_shapes.distances(self.m, self.d, 0, H, V)[:2])

    def anchor(self, H, V):
        """(N, N) at the first end."""
        return composite_lines.anchor_pull(self.m, self.d, 0, H, V)


@pytest.fixture(scope="module")
def lines():
    return {count: Lines(count) for count in range(1, 7)}


def outputs_of(scene):
    instance = Instance(compile_scene(scene))
    found = {}

    for v, value in zip(instance.model.of_causality("output"), instance.outputs()):
        found.setdefault(v.name.removeprefix("line.").partition("[")[0], []).append(value)

    return {name: np.array(value) if len(value) > 1 else value[0] for name, value in found.items()}


# the same as one section, and closed forms


@pytest.mark.parametrize("bed", [0, 1])
def test_a_line_cut_in_equal_sections_is_the_whole_line(lines, bed):
    """To 1e-9, slack, hanging, taut, in any number of pieces of any length; the whole one by catenaries.py."""
    rng = np.random.default_rng(3)
    whole = Instance(compile_scene(moored([100, 0, 50], {"length": 100.0, "mass": 100.0, "stiffness": 1e9})))
    m = whole.m

    for _ in range(200):
        L, w = 10 ** rng.uniform(0, 4), 10 ** rng.uniform(-1, 4)
        EA = w * L * 10 ** rng.uniform(0, 6)
        reach, angle = L * (1 + w * L / EA) * rng.uniform(0.0, 1.2), rng.uniform(0, np.pi / 2)
        x, z = reach * np.cos(angle), reach * np.sin(angle)
        m.line_length[0], m.line_mass[0], m.line_stiffness[0], m.line_bed[0] = L, w / G, EA, bed
        count = int(rng.integers(1, 7))
        cut = [(share * L, w, EA, 0.0) for share in rng.dirichlet(np.ones(count))]
        found, sought = lines[count].pull(cut, x, z, bed), catenaries.pull(m, whole.d, 0, x, z)
        assert_near(found, sought, 1e-9 * (w * L + np.hypot(*sought)) + 1e-12 * EA)


def test_a_weight_on_a_light_line_hangs_between_two_bars(lines):
    """As two straight bars, by angles."""
    L, P, EA = 50.0, 1e4, 1e12
    H, V = lines[2].pull([(L, 1e-4, EA, P), (L, 1e-4, EA, 0.0)], 80.0, 0.0, 0)
    assert_near([H, V], [P / 2 * 40 / 30, P / 2], 0.1)


def test_a_buoy_holds_a_line_up_off_the_bed(lines):
    """Slack: below the buoy as much as it carries, half each way; the rest on the bed, in one piece with the second end's."""
    w, EA, B = 100.0, 1e9, 4000.0
    H, V = lines[2].pull([(100.0, w, EA, -B), (100.0, w, EA, 0.0)], 120.0, 30.0, 1)
    assert H == 0.0
    assert_near(V, w * 30.0, 1e-3 * V)


def friction_distance(L, w, EA, CB, H, V):
    """x of Jonkman (2007), equation 2-37: the two last terms are the stretch of what lies."""
    lies = L - V / w
    x = lies + H / w * np.arcsinh(V / H) + H * L / EA
    tight = lies - H / (CB * w)
    return x + CB * w / (2 * EA) * (-(lies**2) + tight * max(tight, 0.0))


@pytest.mark.parametrize("CB", [0.1, 0.5, 1.0, 3.0])
def test_friction_is_that_of_the_equations_of_the_field(lines, CB):
    """Jonkman (2007) 2-37 and 2-38, with pull and without at the anchor; z does not know of friction."""
    rng = np.random.default_rng(4)
    slack = 0

    for _ in range(60):
        L, w = 10 ** rng.uniform(1, 3), 10 ** rng.uniform(1, 3)
        EA, H = w * L * 10 ** rng.uniform(0.3, 4), w * L * 10 ** rng.uniform(-1.5, 0.5)
        V = w * L * rng.uniform(0.05, 0.95)
        x = friction_distance(L, w, EA, CB, H, V)
        z = V * V / (w * (np.hypot(H, V) + H)) + V * V / (2 * EA * w)
        found = lines[1].pull([(L, w, EA, 0.0)], x, z, 1, CB)
        assert_near(found, [H, V], 1e-8 * np.hypot(H, V) + 1e-11 * EA)
        at_anchor = max(H - CB * w * (L - V / w), 0.0)
        slack += at_anchor == 0.0
        assert_near(lines[1].anchor(*found), [at_anchor, 0.0], 1e-8 * np.hypot(H, V) + 1e-11 * EA)

    assert 0 < slack < 60


def test_friction_along_the_bed_alone(lines):
    """A line all of which lies, pulled by H: tight over H / (CB w), stretched by half of H along that."""
    L, w, EA, CB = 100.0, 500.0, 1e6, 1.0
    H = 2e4
    tight = H / (CB * w)
    assert_near(lines[1].pull([(L, w, EA, 0.0)], L + H * tight / (2 * EA), 0.0, 1, CB), [H, 0.0], 1e-6)
    assert lines[1].pull([(L, w, EA, 0.0)], 99.0, 0.0, 1, CB) == (0.0, 0.0)


def test_a_little_friction_is_next_to_none(lines):
    """And a line on the bed keeps its pull without it."""
    sections = [(200.0, 1200.0, 5e8, 5e3), (250.0, 150.0, 8e7, 0.0)]
    smooth, rough = (lines[2].pull(sections, 435.0, 60.0, 1, CB) for CB in (0.0, 1e-9))
    assert_near(smooth, rough, 1e-6 * smooth[0])
    with_friction = lines[2].pull(sections, 435.0, 60.0, 1, 1.0)
    assert smooth[0] < with_friction[0] < 1.05 * smooth[0]


@pytest.mark.parametrize("count", [1, 3])
def test_the_line_of_a_spar_by_another_library(lines, count):
    """OC3-Hywind at rest, by MoorPy without friction, which ends at 3e-8: tension at the fairlead, length on the bed, three lines' pull."""
    L, w, EA = 902.2, 698.0945369153751, 384.243e6
    parts = [0.2, 0.5, 0.3] if count == 3 else [1.0]
    H, V = lines[count].pull([(share * L, w, EA, 0.0) for share in parts], 853.87 - 5.2, 250.0, 1)
    assert_near(np.hypot(H, V), 911088.9911374, 1e-7 * 911088.9911374)
    assert_near(np.divide([L - V / w, 3 * V], [134.78553813953238, 1607183.547761477]), 1.0, 1e-6)


# independent ways


def along_the_line(sections, H, V, z0):
    """(x, z) of the second end over the first by the differential equation of the elastic catenary, without a bed."""
    total = sum(L * w + hung for L, w, EA, hung in sections)
    v, place = V - total, np.array([0.0, z0])

    for L, w, EA, hung in sections:

        def slope(s, r):
            T = np.hypot(H, v + w * s)
            return np.array([H, v + w * s]) * (1 / T + 1 / EA)

        place = solve_ivp(slope, (0, L), place, rtol=1e-12, atol=1e-12 * L).y[:, -1]
        v += w * L + hung

    return place


def test_ends_are_where_the_differential_equation_leads(lines):
    """Hanging lines with weights and buoys, parts that float, either end up."""
    rng = np.random.default_rng(5)

    for _ in range(30):
        count = int(rng.integers(2, 7))
        L = rng.uniform(5, 50, count)
        w = 10 ** rng.uniform(0, 3, count) * np.where(rng.random(count) < 0.2, -0.5, 1.0)
        size = np.abs(w) @ L
        EA = size * 10 ** rng.uniform(0.5, 4, count)
        hung = size * rng.uniform(-0.4, 0.4, count)
        hung[-1] = 0.0
        sections = list(zip(L, w, EA, hung))
        H, V = size * 10 ** rng.uniform(-1.0, 0.5), size * rng.uniform(-1, 2)
        found = lines[count].pull(sections, *along_the_line(sections, H, V, 0.0), 0)
        assert_near(found, [H, V], 1e-7 * np.hypot(H, V) + 1e-11 * EA.max())


def test_what_lies_on_the_bed_is_at_rest(lines):
    """The bed pushes up and only where the line touches it, nothing is below it, and the ends are met, by quadrature along the line.

    Of a convex problem that is all: no other shape has less energy (Kuhn and Tucker). Buoys and sections that float
    lift parts of the line off the bed, which come down to it again.
    """
    rng = np.random.default_rng(9)
    arches = 0

    for _ in range(30 if INTERPRETED else 300):
        count = int(rng.integers(2, 7))
        L = rng.uniform(20, 50, count)
        w = 10 ** rng.uniform(0.5, 2, count) * np.where(rng.random(count) < 0.2, -0.7, 1.0)
        size = np.abs(w) @ L
        EA = size * 10 ** rng.uniform(0.7, 4, count)
        hung = np.append(size * rng.uniform(-0.4, 0.3, count - 1), 0.0)
        of, x, z = lines[count], L.sum() * rng.uniform(0.6, 0.98), L.sum() * rng.uniform(0.02, 0.4)
        H, V = of.pull(list(zip(L, w, EA, hung)), x, z, 1)

        # slack, all is upright: no shape of that is smooth; and where nothing floats nothing is out of order
        if 1e-3 * size > H or np.append(w, hung).min() >= 0.0:
            continue

        W, place, borne = w @ L + hung.sum(), np.zeros(2), None

        for k in range(count):
            s = L[k] * (0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 20_001)))
            above = W - w[k] * s
            floor, _, cap, _ = of.d.section_level[4 * k : 4 * k + 4]
            R = np.maximum(np.clip(above, floor, cap) - V, 0.0)
            v = V - above + R
            T = np.hypot(H, v)
            way = np.stack([np.full_like(v, H), v]) * (1 / T + 1 / EA[k])
            steps = 0.5 * (way[:, 1:] + way[:, :-1]) * np.diff(s)
            r = place[:, None] + np.concatenate([np.zeros((2, 1)), np.cumsum(steps, axis=1)], axis=1)
            tol = 1e-6 * L.sum()
            assert r[1].min() > -tol
            R = R if borne is None else np.append(borne, R)
            heights = r[1] if borne is None else np.append(place[1], r[1])
            falls = -np.diff(R)
            assert falls.min() > -1e-9 * size
            at = np.maximum(heights[1:], heights[:-1])
            assert (at[falls > 1e-9 * size] < tol + 1e-3 * L.sum() / 20_000).all()
            arches += bool((v < -1e-6 * size).any())
            place, borne, W = r[:, -1], R[-1], above[-1] - hung[k]

        assert_near(place, [x, z], 1e-6 * L.sum())

    assert arches > (3 if INTERPRETED else 30)


def test_the_derivatives_of_the_distances_are_those(lines):
    """By differences, hanging and lying, with friction and with buoys that come down."""
    for sections, bed, CB in (
        ([(40.0, 10.0, 4e3, -200.0), (60.0, 10.0, 4e3, 0.0)], 1, 0.0),
        ([(40.0, 10.0, 4e3, -200.0), (60.0, 10.0, 4e3, 0.0)], 0, 0.0),
        ([(40.0, 10.0, 4e3, 200.0), (60.0, 10.0, 4e3, 0.0)], 1, 0.8),
    ):
        of = lines[2]
        of.pull(sections, 60.0, 20.0, bed, CB)

        for H, V in ((100.0, 120.0), (300.0, 700.0), (250.0, 450.0), (700.0, 310.0)):
            given = composite_shapes.distances(of.m, of.d, 0, H, V)[2:]
            e = 1e-4
            by_H = (of.reach(H + e, V) - of.reach(H - e, V)) / (2 * e)
            by_V = (of.reach(H, V + e) - of.reach(H, V - e)) / (2 * e)
            assert_near(given, [by_H[0], by_V[0], by_H[1], by_V[1]], 1e-6)
            if CB == 0.0:
                assert_near(given[1], given[2], 1e-12)


def test_distances_are_the_gradient_of_a_convex_function(lines):
    """Their derivatives are symmetric and positive, without friction; with it x still rises where z is held."""
    rng = np.random.default_rng(6)

    for _ in range(300):
        sections, bed, friction = drawn(rng, int(rng.integers(1, 7)), rng.random() < 0.5)
        of = lines[len(sections)]
        of.pull(sections, 1.0, 1.0, bed, friction)
        size = sum(abs(w) * L + abs(hung) for L, w, _, hung in sections)
        V = size * rng.uniform(0.0, 2.0) + (composite_shapes.lowest(of.m, of.d, 0, size)[0] if bed else -size)
        _, _, x_H, x_V, z_H, z_V = composite_shapes.distances(
            of.m, of.d, 0, size * 10 ** rng.uniform(-3, 2), V
        )
        assert x_H >= 0.0 and z_V >= 0.0 and x_H * z_V - x_V * z_H >= -1e-12 * x_H * z_V

        if friction == 0.0:
            assert_near(x_V, z_H, 1e-9 * np.sqrt(x_H * z_V) + 1e-300)


def drawn(rng, count, floats):
    """(sections, bed, friction) of a random line, soft to stiff, some of whose parts may float."""
    L = np.maximum(rng.dirichlet(np.ones(count)), 1e-3) * 10 ** rng.uniform(0, 3.5)
    w = 10 ** rng.uniform(-1, 4) * 10 ** rng.uniform(-1, 1, count)
    w *= np.where((rng.random(count) < 0.2) & floats, -rng.uniform(0, 1, count), 1.0)
    size = np.abs(w) @ L
    EA = size * 10 ** rng.uniform(0, 6) * 10 ** rng.uniform(-1, 1, count)
    hung = size * rng.uniform(-0.5 if floats else 0.0, 0.5, count) * (rng.random(count) < 0.5)
    hung[-1] = 0.0
    bed = int(rng.random() < 0.6)
    friction = rng.uniform(0, 3) if bed and not floats and rng.random() < 0.5 else 0.0
    return list(zip(L, w, EA, hung)), bed, friction


def meet_random_lines(lines, seed, count):
    """Draws lines and asks that each is met to 1e-9 of its length, or is slack."""
    rng = np.random.default_rng(seed)

    for _ in range(count):
        sections, bed, friction = drawn(rng, int(rng.integers(1, 7)), rng.random() < 0.5)
        L, _, EA, _ = np.array(sections).T
        size = sum(abs(w) * length + abs(hung) for length, w, _, hung in sections)
        reach = L.sum() * (1 + size / EA.min() * rng.random()) * rng.uniform(0, 1.2)
        angle = rng.uniform(-0.1 if bed else -np.pi / 2, np.pi / 2)
        x, z = reach * np.cos(angle), reach * np.sin(angle)
        of = lines[len(sections)]
        H, V = of.pull(sections, x, z, bed, friction)
        assert np.isfinite(H) and np.isfinite(V) and H >= 0.0
        gx, gz = of.reach(H, V) - [x, max(z, 0.0) if bed else z]
        gap = abs(gz) + (max(-gx, 0.0) if H == 0.0 else abs(gx))
        assert gap < 1e-9 * (L.sum() + reach), (sections, bed, friction, x, z)


def test_random_lines_come_to_an_end(lines):
    meet_random_lines(lines, 7, 300 if INTERPRETED else 3_000)


@pytest.mark.long
def test_very_many_random_lines_come_to_an_end(lines):
    """1e5, from nearly weightless to soft as their weight, slack and taut, floating, with and without friction."""
    meet_random_lines(lines, 8, 100_000)


# in a scene


BUOYED = {
    "sections": [
        CHAIN | {"clump": {"mass": 100.0, "volume": 20.0}}, ROPE | {"clump": {"mass": 2000.0}}, CHAIN | {"length": 60.0},
    ]
}  # fmt: skip
ROUGH = {"friction": 0.8, "sections": [CHAIN | {"clump": {"mass": 2000.0}}, ROPE, CHAIN | {"length": 60.0}]}


@pytest.mark.parametrize("line", [BUOYED, ROUGH, CHAIN | {"length": 473.0, "friction": 1.0}])
def test_outputs_are_one_balance(line):
    """What the ends bear, the bed and weight add up; powers and forces are of one kind."""
    at = [380, 200, 150]
    found = outputs_of(moored(at, line))
    assert_near(found["tension"], np.linalg.norm(found["force"]), 1e-6)
    assert_near(found["force"][0] * 200, found["force"][1] * 380, 1e-3)
    assert 0.0 < found["grounded_length"] < 300.0
    pulled = np.hypot(*found["force"][:2])

    if "friction" not in line:
        assert_near(found["anchor_tension"], pulled, 1e-6 * pulled)
    else:
        assert found["anchor_tension"] < pulled


@pytest.mark.parametrize("at", [(380, 200, 150), (500, 60, 150), (60, -10, 120), (300, 50, 15)])
@pytest.mark.parametrize("bed", [True, False])
def test_a_buoy_on_a_line_of_sections_keeps_its_energy(at, bed):
    """Slack, hanging, taut, moving through all of them; the middle comes down to the bed and leaves it."""
    scene = moored(
        at,
        BUOYED | {"bed": bed},
        output=["total_energy", "spring_energy"],
        solver={"tolerance": 1e-11, "integrator": "rk54"},
    )
    run = simulate(compile_scene(scene), 1.0 if INTERPRETED else 4.0, 0.1)
    assert_near(run["total_energy"], run["total_energy"][0], 1e-6 * (1e4 + np.ptp(run["spring_energy"])))


@pytest.mark.parametrize("line", [ROUGH, CHAIN | {"length": 473.0, "friction": 1.0}])
def test_what_friction_takes_is_all_that_is_lost(line):
    """Energy falls by the power that is told as lost, and by nothing else; some of it comes back as the pull falls."""
    scene = moored(
        (440, 0, 150) if "sections" not in line else (490, 0, 120),
        line,
        velocity=(3, 1, 1),
        output=["total_energy", "dissipated_power"],
        solver={"tolerance": 1e-11, "integrator": "rk54"},
    )
    run = simulate(compile_scene(scene), 0.5 if INTERPRETED else 3.0, 0.005)
    energy, power, t = run["total_energy"], run["dissipated_power"], run["time"]
    assert np.ptp(energy) > 10.0
    lost = np.concatenate([[0.0], np.cumsum(np.diff(t) * (power[1:] + power[:-1]) / 2)])
    assert_near(energy[0] - energy, lost, 1e-3 * np.ptp(lost) + 1e-3 * abs(power).max() * 0.005)


@pytest.mark.parametrize("line", [BUOYED, ROUGH])
def test_derivatives_by_a_trace_are_those_by_differences(line):
    """What FMUs and linear models take from the equations (docs/specialise.md)."""
    instance = Instance(compile_scene(moored([440, 60, 120], line)))
    instance.outputs()
    m, d = instance.m, instance.d
    found = derivatives(instance, outputs=True)
    place = int(m.n_q) - 7 + np.arange(3)
    assert_near(found.outputs, instance.outputs(), 1e-9 * np.abs(found.outputs).max())
    h, start = 1e-3, d.x.copy()

    for j in place:
        sides = []
        for step in (h, -h):
            d.x[:] = start
            d.x[j] += step
            rates.evaluate_now(m, d)
            sides.append(d.x_rate.copy())
        slope = (sides[0] - sides[1]) / (2 * h)
        assert_near(found.A[:, j], slope, 1e-7 * np.abs(found.A).max())


def test_sections_turn_round_with_the_ends():
    """Without a bed a line from a to b is that from b to a."""
    parts = [ROPE | {"length": 20.0, "clump": {"mass": 300.0}}, CHAIN | {"length": 30.0}]
    turned = [CHAIN | {"length": 30.0, "clump": {"mass": 300.0}}, ROPE | {"length": 20.0}]
    forces = []

    for sections, between in ((parts, ["ground", "buoy"]), (turned, ["buoy", "ground"])):
        line = {"catenary": {"sections": sections, "bed": False}, "between": between, "output": OUTPUTS}
        found = outputs_of(moored([30, 10, -15], None, force={"line": line}))
        forces.append([found["tension"], found["anchor_tension"]])

    assert_near(forces[0], forces[1][::-1], 1e-9 * np.max(forces))


def test_sections_are_parameters():
    model = compile_scene(moored([400, 0, 100], ROUGH))
    names = [v.name for v in model.of_causality("parameter") if v.name.startswith("line.")]
    assert names == [
        "line.friction",
        *(f"line.{key}[{k}]" for key in ("length", "mass", "stiffness") for k in (1, 2, 3)),
        "line.clump[1]",
        "line.clump[2]",
    ]


def test_mistakes_are_told():
    for line, told in (
        (
            {"mass": 1.0, "stiffness": 1.0},
            r'needs "length", or sections = \[\{ length = 100, mass = 80, stiffness = 5e8 \}, ...\]',
        ),
        ({"length": 1.0, "sections": [CHAIN]}, r'with sections, each of them has its "length"'),
        ({"sections": []}, r"needs a list of tables, .* found an empty list"),
        ({"sections": [CHAIN | {"clump": {"mass": 1.0}}]}, "the last section ends at the second end"),
        (CHAIN | {"friction": -1.0}, "friction: must not be negative"),
        (CHAIN | {"friction": 1.0, "bed": False}, "friction is that of a bed"),
    ):
        with pytest.raises(SceneError, match=told):
            moored([100, 0, 50], line)

    with pytest.raises(
        SceneError, match=r"friction: the clump of section 1 is lighter than .* by 2.04e\+04 kg"
    ):
        compile_scene(moored([100, 0, 50], BUOYED | {"friction": 1.0}))

    (notice,) = compile_scene(moored([100, 0, 50], CHAIN | {"friction": 1.0}, sea={"depth": 200})).notices
    assert "catenary.friction: does nothing: the line has no bed" in notice
    (notice,) = compile_scene(moored([600, 0, 150], ROUGH)).notices
    assert "catenary.sections: is 510 m long, and its ends are 618.466 m apart" in notice


@pytest.mark.parametrize(
    ("place", "line", "more", "told"),
    [
        ([100, 0, 0], BUOYED, {"anchor": [0, 0, -120]}, "between: ground.anchor starts at z = -120 m, under the sea's bed"),
        ([100, 0, 50], CHAIN | {"diameter": 0.1}, {"anchor": [0, 0, 20]}, "catenary: both ends start above the water"),
        ([3, 0, -1], CHAIN | {"length": 1e5}, {"anchor": [0, 0, -100]}, "catenary.length: is 100000 m long, .* times as long"),
        ([100, 0, 0], BUOYED, {"anchor": [0, 0, -101]}, None),
        ([100, 0, 50], CHAIN, {"anchor": [0, 0, -100]}, None),
    ],
)  # fmt: skip
def test_ends_out_of_the_water_and_lengths_in_other_units_are_told(place, line, more, told):
    notices = "\n".join(compile_scene(moored(place, line, sea={"depth": 100}, **more)).notices)
    assert re.search(told, notices) if told else not re.search("between|catenary", notices), notices


def test_a_buoy_that_would_fly_is_told():
    """Only where it is drawn: at its place the line is asked for, nothing else knows it before a run."""
    for depth, told in ((100, True), (10_000, False)):
        scene = moored([100, 0, 0], BUOYED, anchor=[0, 0, -depth], sea={"depth": depth})
        texts = [text for text in moorings(scene, 1.0, points=3).notices if "above the water" in text]
        assert len(texts) == told


def test_one_section_may_be_a_table():
    one, listed = (moored([100, 0, 50], {"sections": given}) for given in (CHAIN, [CHAIN]))
    assert compile_scene(one).notices == compile_scene(listed).notices
    assert one.force["line"].catenary.parts == listed.force["line"].catenary.parts

    with pytest.raises(SceneError, match=r"clump: needs a mass \(kg\), a volume \(m3\), or both"):
        moored([100, 0, 50], {"sections": [CHAIN | {"clump": {}}, CHAIN]})
