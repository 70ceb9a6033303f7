"""Mooring lines in pictures: against the differential equation, the kernels at all times, the ends of the run, the bed; how large pages get."""

import json
from pathlib import Path

import numpy as np
import pytest
from scenes import assert_near

import mbdfmi
from mbdfmi.kernels.forces.line_pieces import piece
from mbdfmi.run import line_shapes
from mbdfmi.view import drawing, glb
from mbdfmi.view.lines import Drawn, table, told_lines
from mbdfmi.view.page import page
from mbdfmi.view.picture import picture

ROOT = Path(__file__).parents[1]
SCENES = {
    "moored_buoy": ("models/moored_buoy.toml", 30.0, 0.5),
    "turbine_at_sea": ("models/floating_wind_turbine/turbine_at_sea.toml", 40.0, 0.5),
    "line_of_sections": ("docs/line_of_sections.toml", 20.0, 0.25),
}


@pytest.fixture(scope="module", params=SCENES)
def run(request):
    file, until, step = SCENES[request.param]
    scene = mbdfmi.load(ROOT / file)

    for force in scene.force.values():
        if force.kind == "catenary":
            force.output = ["tension", "force"]

    results = scene.simulate(until, step)
    return results, picture(results.scene, results.states)


def tied(line, ground=None, position=(60.0, 0.0, 20.0)):
    """A run of a body held by one line from the ground."""
    scene = {
        "name": "tied",
        "gravity": [0, 0, -9.81],
        "ground": {"marker": {"anchor": {"position": [0, 0, 0]}}} | (ground or {}),
        "body": {"float": {"mass": 1e4, "inertia": [1e4, 1e4, 1e4]}},
        "joint": {"sea": {"free": {}, "between": ["ground", "float"], "start": {"position": list(position)}}},
        "force": {"line": {"catenary": line, "between": ["ground.anchor", "float"]}},
    }
    return mbdfmi.Scene.model_validate(scene).simulate(0.1, 0.1)


def test_lines_begin_and_end_where_their_ends_are_and_never_below_the_bed(run):
    results, shown = run
    rows = np.arange(len(results["time"]))

    for line in shown.lines:
        points = line.points(rows)
        places = results.states.poses(list(line.ends))[0]
        assert_near(points[:, 0], places[:, 0], 1e-6)
        assert_near(points[:, -1], places[:, 1], 1e-6)
        assert line.bed and points[:, :, 2].min() >= places[0, 0, 2] - 1e-9


def by_equation(lengths, weights, stiffness, hung, H, V, CB, n=40_000):
    """(s, x, z) of a line on a bed: what its second end is pulled with, less what hangs above, integrated over its length."""
    s = np.linspace(0.0, lengths.sum(), n)
    inner = np.cumsum(lengths)[:-1]
    w, EA = (
        np.append(values, values[-1])[np.searchsorted(inner, s, side="right")]
        for values in (weights, stiffness)
    )
    above = np.concatenate([np.cumsum((0.5 * (w[1:] + w[:-1]) * np.diff(s))[::-1])[::-1], [0.0]])
    above += sum(weight * (s < place) for weight, place in zip(hung, inner))
    up = V - above

    # from the anchor to where the line leaves the bed
    lies = np.logical_and.accumulate(up < 0.0)
    up = np.where(lies, 0.0, up)
    H = np.where(
        lies,
        np.maximum(H - CB * np.append(np.cumsum((w * lies * (s[1] - s[0]))[::-1])[::-1][1:], 0.0), 0.0),
        H,
    )
    T = np.hypot(H, up)
    rates = np.array([np.where(lies, 1.0, H / np.maximum(T, 1e-9)), up / np.maximum(T, 1e-9)]) * (1 + T / EA)
    way = np.cumsum(0.5 * (rates[:, 1:] + rates[:, :-1]) * np.diff(s), axis=1)
    return s, np.concatenate([[0.0], way[0]]), np.concatenate([[0.0], way[1]]), np.trapezoid(1 + T / EA, s)


def test_points_and_lengths_are_those_of_the_differential_equation(run):
    """By the run's own forces; the chain under the buoy of line_of_sections lies, the rope above it hangs."""
    results, shown = run

    for line in shown.lines:
        m = line.m
        CB = m.composite_friction[line.line.k] if line.line.composite else 0.0

        for row in (0, len(results["time"]) // 2):
            force = results[f"{line.name}.force"][row]
            lengths, weights, stiffness, hung = line.line.sections(m)
            s, x, z, stretched = by_equation(
                lengths, weights, stiffness, hung, np.hypot(*force[:2]), -force[2], CB
            )
            flat = line.shape(line.x[[row]], line.z[[row]])[0]
            # along the line, points by their lengths
            way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(z)))])
            where = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(flat, axis=0), axis=1))])
            assert_near(where[-1], stretched, 1e-3 * stretched)
            found = np.column_stack([np.interp(flat[:, 0], x, z)])[:, 0]
            assert_near(found[1:-1], flat[1:-1, 1], 0.05)
            assert_near([x[-1], z[-1], way[-1]], [*flat[-1], stretched], 0.02)


def test_the_table_of_a_page_is_right_to_a_centimetre_between_rows_too(run):
    _, shown = run

    for line in shown.lines:
        kept = table(line)
        assert 0 < kept.shares.shape[2] < 12

        for x, z in ((line.x, line.z), (0.5 * (line.x[1:] + line.x[:-1]), 0.5 * (line.z[1:] + line.z[:-1]))):
            found = np.array([kept.at(*place) for place in zip(x, z)])
            assert np.abs(found - line.shape(x, z)).max() < 0.01


def test_pages_do_not_grow_with_the_run():
    scene = mbdfmi.load(ROOT / SCENES["turbine_at_sea"][0])
    results = scene.simulate(60.0, 0.25)
    shown = picture(results.scene, results.states)
    many, few = (len(json.dumps(told_lines(p))) for p in (shown, shown.thinned_to(np.arange(0, 241, 10))))
    assert few < many < 1.1 * few
    whole = len(page(shown))
    shown.lines = []
    assert whole - len(page(shown)) < 45_000


def test_dry_pages_have_none():
    results = mbdfmi.load(ROOT / "models" / "four_bar.toml").simulate(0.1, 0.1)
    assert told_lines(picture(results.scene, results.states)) is None


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_what_is_slack_on_the_bed_goes_no_further_than_its_end(friction):
    line = {"length": 120.0, "mass": 100.0, "stiffness": 1e8, "friction": friction}
    results = tied(line)
    (drawn,) = picture(results.scene, results.states).lines
    (points,) = drawn.points([0])
    assert_near(points[-1], [60.0, 0.0, 20.0], 1e-6)
    assert points[:, 0].max() < 60.0 + 1e-6 and points[:, 2].min() >= 0.0


def test_pieces_are_those_of_the_kernels():
    """Of all directions, taut and slack, to 1e-9 of their lengths."""
    rng = np.random.default_rng(3)

    for _ in range(500):
        w, L, EA = rng.uniform(-50, 3000), 10 ** rng.uniform(0, 3), 10 ** rng.uniform(5, 9)
        h, bottom = 10 ** rng.uniform(0, 7), rng.uniform(-1e6, 1e6)
        now = piece(w, L, EA, h, bottom + w * L, bottom)
        x, z = line_shapes._hung(w, np.array([0.0, L]), EA, h, bottom)
        assert_near([x[0], z[0]], [0.0, 0.0], 0.0)
        assert_near([x[1], z[1]], [now.x, now.z], 1e-9 * (L + abs(now.x) + abs(now.z)))


def test_pictures_without_a_browser_have_lines_weights_and_the_bed():
    results = mbdfmi.load(ROOT / "docs" / "line_of_sections.toml").simulate(1.0, 0.5)
    shown = picture(results.scene, results.states)
    assert isinstance(shown.lines[0], Drawn)
    drawn = list(shown.drawn(shown.moves.row(0)))
    lowest = min(surface.points[:, 2].min() for surface, *_ in drawn)
    assert_near(lowest, -120.0, 3.0)
    image = drawing.draw(shown, 0, 200, 120, grid=False)
    shown.lines = []
    assert (drawing.draw(shown, 0, 200, 120, grid=False) != image).any()


def test_a_frame_that_turns_says_that_lines_are_left_out(monkeypatch):
    line = {"length": 120.0, "mass": 100.0, "stiffness": 1e8, "bed": False}
    still = tied(line)
    turning = tied(line, {"motion": {"rotation": {"axis": "x", "speed": 0.1}}})
    assert told_lines(picture(still.scene, still.states))
    assert told_lines(picture(turning.scene, turning.states)) is None
    told = []
    monkeypatch.setattr("mbdfmi.view.page.told", lambda shown, results, notes: told.extend(notes) or {})

    for results in (still, turning):
        page(picture(results.scene, results.states))

    assert [note.partition(" in ")[0] for note in told] == ["mooring lines are not drawn"]


@pytest.mark.parametrize("z", [20.0, -20.0])
def test_a_line_without_a_bed_hangs_the_same_from_either_end(z):
    """Its lower end first or last."""
    line = {"length": 90.0, "mass": 100.0, "stiffness": 1e7, "bed": False}
    results = tied(line, position=(60.0, 0.0, z))
    (drawn,) = picture(results.scene, results.states).lines
    (points,) = drawn.points([0])
    assert_near(points[[0, -1]], [[0, 0, 0], [60, 0, z]], 1e-6)
    there, back = drawn.shape([60.0], [20.0])[0], drawn.shape([60.0], [-20.0])[0]
    assert_near(back[::-1] - [60.0, -20.0], there * [-1.0, 1.0], 1e-9)


def test_a_glb_has_them_as_morph_targets(run):
    """Points by its weights, to half a centimetre; weights and buoys with them."""
    results, shown = run
    document, arrays = glb.read(shown.glb())
    nodes = {node["name"]: k for k, node in enumerate(document["nodes"])}
    outputs = {
        (channel["target"]["node"], channel["target"]["path"]): document["animations"][0]["samplers"][
            channel["sampler"]
        ]["output"]
        for channel in document["animations"][0]["channels"]
    }
    rows = np.arange(len(results["time"]))

    for line in shown.lines:
        k = nodes[line.name]
        (part,) = document["meshes"][document["nodes"][k]["mesh"]]["primitives"]
        targets = np.array([arrays[target["POSITION"]] for target in part["targets"]])
        weights = arrays[outputs[k, "weights"]].reshape(len(rows), len(targets))
        tube = arrays[part["attributes"]["POSITION"]] + np.tensordot(weights, targets, 1)
        points = line.points(rows)
        # the tube's last ring point is its first
        rings = tube.reshape(len(rows), len(line.points([0])[0]), -1, 3)[:, :, :-1].mean(axis=2)
        assert_near(rings, points, 5e-3)

        for ball, (at, *_) in enumerate(line.balls, 1):
            assert_near(arrays[outputs[nodes[f"{line.name} {ball}"], "translation"]], points[:, at], 1e-4)
