"""Lines whose first end is on the ground and whose second is below it: they hang, and lie on no bed."""

import numpy as np
import pytest

from mbdfmi import Scene

G = 9.81
LINE = {"length": 115.0, "mass": 20.0, "stiffness": 2e7}
HALVES = {"sections": [LINE | {"length": 50.0}, LINE | {"length": 65.0}]}


def tension(line, second, bed=None):
    """(N at the start, notices) of a line from (0, 0, 10)."""
    line = line | ({} if bed is None else {"bed": bed})
    scene = Scene.model_validate(
        {
            "name": "hangs",
            "gravity": [0, 0, -G],
            "ground": {"marker": {"a": {"position": [0, 0, 10]}, "b": {"position": list(second)}}},
            "body": {"b": {"mass": 1.0, "inertia": [1.0] * 3}},
            "joint": {"held": {"fixed": {}, "between": ["ground.b", "b"]}},
            "force": {
                "line": {
                    "catenary": line,
                    "between": ["ground.a", "b"],
                    "output": ["tension", "anchor_tension", "force"],
                }
            },
        }
    )
    run = scene.simulate(0.01)
    return run["line.anchor_tension"][0], run.notices


@pytest.mark.parametrize("line", [LINE, HALVES], ids=["one", "two sections"])
def test_a_line_to_something_below_holds_it(line):
    """Straight down and taut: the anchor carries all of its weight and what it is stretched by,
    T(s) = H + w s, L + (H L + w L^2 / 2) / EA = distance.
    """
    weight, length, EA = 20.0 * G, 115.0, 2e7
    distance = 116.0
    lower = (distance - length) / length * EA - weight * length / 2
    found, notices = tension(line, (0.0, 0.0, 10.0 - distance))
    assert found == pytest.approx(lower + weight * length, rel=1e-9)
    assert found == pytest.approx(tension(line, (0.0, 0.0, 10.0 - distance), bed=False)[0], rel=1e-12)
    assert not [text for text in notices if "bed" in text]


@pytest.mark.parametrize("line", [LINE, HALVES], ids=["one", "two sections"])
def test_a_slack_one_hangs_by_its_weight(line):
    """A bight below the lower end: the anchor carries more than what hangs as far down as the lower end."""
    found, _ = tension(line, (0.0, 0.0, -40.0))
    # 32.5 m lie below the lower end, doubled up, and as much hangs above
    assert found == pytest.approx(20.0 * G * (50.0 + 32.5), rel=1e-3)


def test_a_bed_that_is_asked_for_is_kept_and_told():
    found, notices = tension(LINE, (0.0, 0.0, -40.0), bed=True)
    assert found == pytest.approx(0.0, abs=1e-6)
    (text,) = [text for text in notices if "bed" in text]
    assert "50 m below" in text and "bed = false" in text


def test_a_second_end_as_high_lies_on_the_bed():
    found, _ = tension(LINE, (100.0, 0.0, 10.0))
    assert np.isclose(found, 0.0, atol=1e-6)


@pytest.mark.parametrize("line", [LINE, HALVES], ids=["one", "two sections"])
def test_a_line_that_is_soft_is_told(line):
    """Half of its weight stretches it: 115 m of 20 kg/m by 0.056 % of 2e7 N, and by 5.6 % and 56 % of less."""

    def soft(factor):
        parts = line.get("sections", [line])
        changed = [part | {"stiffness": part["stiffness"] * factor} for part in parts]
        changed = line | ({"sections": changed} if "sections" in line else changed[0])
        return [text for text in tension(changed, (0.0, 0.0, -40.0))[1] if "EA" in text]

    assert not soft(1.0) and not soft(1e-2)
    (text,) = soft(1e-3)
    assert "22563 N" in text.replace("2.26e+04", "22563") and "56 %" in text
