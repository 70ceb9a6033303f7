"""The page in a real browser (chromium, the network cut): it asks for nothing, complains of nothing, and shows the run.

Skipped, aloud, where there is no chromium or no playwright (pip install 'mbdfmi[browser]').
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbdfmi
from mbdfmi.view.picture import picture
from mbdfmi.view.show import show

playwright = pytest.importorskip(
    "playwright.sync_api", reason="pages are not tried: pip install 'mbdfmi[browser]'"
)

MODELS = Path(__file__).parents[1] / "models"


@pytest.fixture(scope="module")
def chromium():
    from mbdfmi.view.browser import ARGUMENTS, find

    path = find()
    if path is None:
        pytest.skip("pages are not tried: there is no chromium here (apt-get install chromium)")

    with playwright.sync_playwright() as p:
        browser = p.chromium.launch(executable_path=str(path), args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def opened(chromium, tmp_path):
    """A function: the page of a file, opened without a network; at the end it must have asked and complained of nothing."""
    said, asked, contexts = [], [], []

    def open_page(path, words=""):
        context = chromium.new_context(offline=True, viewport={"width": 800, "height": 500})
        page = context.new_page()
        contexts.append(context)
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri() + words)
        page.wait_for_selector('#mbdfmi[data-state="ready"]', timeout=60_000)
        # drawn only when asked for: these machines draw slowly
        page.evaluate("mbdfmi.renderer.setAnimationLoop(null)")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert said == []
    assert [url for url in asked if not url.startswith(("file:", "blob:", "data:"))] == []


def pose(page, body):
    """(r, A) of a body, as the page has it."""
    matrix = np.array(page.evaluate("body => mbdfmi.pose(body)", body)).reshape(4, 4).T
    return matrix[:3, 3], matrix[:3, :3]


def assert_at(page, results, row):
    size = picture(results.scene, results.states).size

    for body in results.scene.body:
        r, q = results.poses(body)
        found_r, found_A = pose(page, body)
        np.testing.assert_allclose(found_r, r[row], atol=1e-6 * size)
        np.testing.assert_allclose(found_A, Rotation.from_quat(q[row]).as_matrix(), atol=2e-6)


@pytest.mark.parametrize("name", ["bricard", "floating_wind_turbine/floating_wind_turbine"])
def test_playing_and_scrubbing_move_the_bodies_to_the_recorded_poses(opened, tmp_path, name):
    results = mbdfmi.load(MODELS / f"{name}.toml").simulate(2.0, 0.05)
    page = opened(results.view(tmp_path / "run.html"))
    # playing
    before = page.evaluate("mbdfmi.playing ? mbdfmi.time : (mbdfmi.play(), mbdfmi.time)")
    page.evaluate("mbdfmi.last -= 70; mbdfmi.frame(performance.now())")
    assert page.evaluate("mbdfmi.time") != before
    # at a row of the run, by the slider
    page.evaluate(
        "slider => { slider.value = 0.5; slider.dispatchEvent(new Event('input')) }",
        page.query_selector("#time"),
    )
    assert not page.evaluate("mbdfmi.playing")
    np.testing.assert_allclose(page.evaluate("mbdfmi.time"), 1.0)
    assert_at(page, results, 20)
    # and there and back, over the end
    for row in (40, 7, 0, 40, 3):
        page.evaluate("time => mbdfmi.seek(time)", float(results["time"][row]))
        assert_at(page, results, row)


def test_dragging_turns_the_view_and_no_body(opened, tmp_path):
    results = mbdfmi.load(MODELS / "four_bar.toml").simulate(1.0, 0.1)
    page = opened(results.view(tmp_path / "run.html"), "#t=0.5")
    page.evaluate("mbdfmi.pause(); mbdfmi.seek(0.5)")
    eye = page.evaluate("mbdfmi.camera.position.toArray()")
    page.mouse.move(400, 250)
    page.mouse.down()
    page.mouse.move(500, 300, steps=4)
    page.mouse.up()
    page.evaluate("mbdfmi.frame(performance.now())")
    turned = page.evaluate("mbdfmi.camera.position.toArray()")
    assert np.linalg.norm(np.subtract(turned, eye)) > 0.1 * np.linalg.norm(eye)
    assert_at(page, results, 5)


def test_what_is_shown_can_be_chosen(opened, tmp_path):
    scene = mbdfmi.load(MODELS / "four_bar.toml")
    scene.view = {"paths": ["coupler.tool"], "plots": ["crank_pivot.angle"], "frame": "coupler"}
    results = scene.simulate(1.0, 0.1)
    page = opened(results.view(tmp_path / "run.html"))
    # the path goes through the point's positions
    (line,) = page.evaluate(
        "[...mbdfmi.paths.lines.values()].map(line => [...line.geometry.attributes.position.array])"
    )
    np.testing.assert_allclose(np.reshape(line, (-1, 3)), results["coupler.tool.position"], atol=2e-6)
    # the plot reads as the run does
    page.evaluate("mbdfmi.pause(); mbdfmi.seek(0.5)")
    head = page.text_content(".plot .head")
    assert head.startswith("crank_pivot.angle [rad]")
    np.testing.assert_allclose(float(head.split()[-1]), results["crank_pivot.angle"][5], atol=1e-3)
    # the camera goes with the coupler
    way = "mbdfmi.controls.target.toArray()"
    before = page.evaluate(way)
    page.evaluate("mbdfmi.seek(1.0)")
    moved = np.subtract(page.evaluate(way), before)
    r = results.poses("coupler")[0]
    np.testing.assert_allclose(np.linalg.norm(moved), np.linalg.norm(r[10] - r[5]), rtol=1e-4)
    # a click in the list hides what it names
    page.click("summary:has-text('show')")
    page.uncheck("text=names of bodies")
    page.evaluate("mbdfmi.draw()")
    assert page.evaluate("[...document.querySelectorAll('.names span')].every(label => label.hidden)")


def test_names_do_not_cover_each_other(opened, tmp_path):
    page = opened(
        mbdfmi.load(MODELS / "floating_wind_turbine" / "floating_wind_turbine.toml").show(tmp_path / "a.html")
    )
    page.evaluate("mbdfmi.draw()")
    boxes = page.evaluate(
        "[...document.querySelectorAll('.names span')].filter(l => !l.hidden).map(l => { const b = l.getBoundingClientRect();"
        " return [b.left, b.top, b.right, b.bottom] })"
    )
    assert len(boxes) >= 5
    for k, (left, top, right, bottom) in enumerate(boxes):
        for other in boxes[:k]:
            assert right <= other[0] or other[2] <= left or bottom <= other[1] + 0.5 or other[3] <= top + 0.5


def test_without_webgl_there_are_words(chromium, tmp_path):
    path = mbdfmi.load(MODELS / "pendulum.toml").show(tmp_path / "a.html")
    context = chromium.new_context(offline=True)
    page = context.new_page()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(path.as_uri())
    page.wait_for_selector(".words")
    assert "shows no 3D" in page.text_content(".words")
    context.close()


def test_a_picture_at_a_time(chromium, tmp_path):
    import struct

    from mbdfmi.view.browser import find

    said = []
    results = mbdfmi.load(MODELS / "four_bar.toml").simulate(1.0, 0.1)
    assert find() is not None
    path = show(results, tmp_path / "a.png", 0.5, said.append)
    data = path.read_bytes()
    assert said == [] and struct.unpack(">II", data[16:24]) == (1280, 800) and len(data) > 15_000


@pytest.mark.parametrize(
    "file", ["models/floating_wind_turbine/turbine_at_sea.toml", "docs/line_of_sections.toml"]
)
def test_mooring_lines_go_with_their_bodies_between_the_rows_too(opened, tmp_path, file):
    """To a centimetre of the kernels, at their ends to rounding; weights and buoys where sections meet."""
    results = mbdfmi.load(MODELS.parent / file).simulate(10.0, 0.5)
    shown = picture(results.scene, results.states)
    page = opened(results.view(tmp_path / "run.html"))

    for time in (0.0, 3.5, 6.23, 10.0):
        page.evaluate("time => mbdfmi.seek(time)", time)
        items = page.evaluate(
            "mbdfmi.lines.items.map(item => [item.points.map(p => p.toArray()), item.beads.map(b => b.position.toArray())])"
        )

        for line, (points, beads) in zip(shown.lines, items, strict=True):
            points = np.array(points)
            ends = []

            for end in line.ends:
                body, r, _ = results.scene.marker_pose(end)
                place, A = pose(page, body)
                ends.append(place + A @ r)

            np.testing.assert_allclose(points[[0, -1]], ends, atol=2e-6 * shown.size)
            span = ends[1] - ends[0]
            across = np.hypot(*span[:2])
            flat = line.shape(across, span[2])[0]
            away = np.append(span[:2], 0.0) / across
            there = ends[0] + flat[:, :1] * away + flat[:, 1:] * [0.0, 0.0, 1.0]
            np.testing.assert_allclose(points, there, atol=0.012)
            np.testing.assert_allclose(
                beads, points[[ball[0] for ball in line.balls]].reshape(np.shape(beads)), atol=1e-9
            )

    page.click("summary:has-text('show')")
    page.uncheck("text=mooring lines")
    page.uncheck("text=sea bed")
    assert not page.evaluate("mbdfmi.lines.group.visible || mbdfmi.extras.beds.visible")
