"""Seas, winds and rotors that are none on earth are told, with what there is; those that there are, are not."""

import pytest
from test_gusts import mill
from test_members import pile

from mbdfmi import Scene

CALM = {"velocity": [8.0, 0, 0]}


def said(scene, words):
    return [str(notice) for notice in scene.notices if words in str(notice)]


def at_sea(**sea):
    return Scene.model_validate(
        {
            "name": "sea", "gravity": [0, 0, -9.81], "sea": sea, "body": {"buoy": {"mass": 1.0, "inertia": [1, 1, 1]}},
            "joint": {"free": {"free": {}, "between": ["ground", "buoy"]}},
        }
    )  # fmt: skip


SEAS = [
    ({"density": 1.025}, {"density": 998.0}, "is 1.025 kg/m3: water has some 1000"),
    ({"depth": 2e5}, {"depth": 4000.0}, "the deepest sea has 11000"),
    ({"current": {"velocity": [9.0, 9.0, 0]}}, {"current": {"velocity": [2.0, 1.0, 0]}}, "is 12.73 m/s: the fastest tidal"),
    ({"current": {"velocity": [0.4, 0.1, 3.0]}}, {"current": {"velocity": [0.4, 0.1, 0.02]}}, "goes up or down by 3 m/s"),
    ({"waves": {"regular": {"height": 60.0, "period": 25.0}}}, {"waves": {"regular": {"height": 25.0, "period": 16.0}}}, "is 60 m"),
    ({"waves": {"regular": {"height": 1.0, "period": 80.0}}}, {"waves": {"regular": {"height": 1.0, "period": 20.0}}}, "is 80 s"),
    ({"waves": {"jonswap": {"hs": 25.0, "tp": 25.0}}}, {"waves": {"jonswap": {"hs": 15.0, "tp": 17.0}}}, "measured is 19"),
    ({"waves": {"jonswap": {"hs": 2.0, "tp": 90.0}}}, {"waves": {"jonswap": {"hs": 2.0, "tp": 18.0}}}, "is 90 s"),
    ({"waves": {"jonswap": {"hs": 2.0, "tp": 9.0, "gamma": 33.0}}}, {"waves": {"jonswap": {"hs": 2.0, "tp": 9.0}}}, "from 1 to 7"),
]  # fmt: skip


@pytest.mark.parametrize("odd, usual, words", SEAS)
def test_seas(odd, usual, words):
    (text,) = said(at_sea(**odd), words)
    assert text.startswith("[sea")
    assert not at_sea(**usual).notices


WINDS = [
    ({"eog": {"start": 1.0, "amplitude": 300.0}}, {"velocity": [8.0, 0, 0]}, "the wind comes to 230 m/s"),
    (
        {"step": {"start": 1.0, "velocity": [150.0, 0, 0]}},
        CALM,
        "with it the wind comes to 158 m/s",
    ),
    (
        {"table": {"time": [0, 1], "velocity": [[0, 0, 0], [0, 200.0, 0]]}},
        CALM,
        "strongest gust that was measured is 113",
    ),
    (None, {"velocity": [120.0, 0, 0]}, "is 120 m/s: the strongest wind"),
    (None, CALM | {"exponent": 14.0}, "is 14: it is from 0.1"),
    (None, CALM | {"exponent": 0.14, "reference_height": 9000.0}, "is 9000 m"),
]


@pytest.mark.parametrize("gust, steady, words", WINDS)
def test_winds(tmp_path, gust, steady, words):
    assert len(said(mill(tmp_path, gust, steady), words)) == 1


def test_winds_that_there_are_are_not_told(tmp_path):
    for gust in (
        {"eog": {"start": 1.0, "amplitude": 15.0}},
        {"step": {"start": 1.0, "velocity": [10.0, 0, 0]}},
        None,
    ):
        assert not mill(tmp_path, gust, {"velocity": [25.0, 0, 0], "exponent": 0.2}).notices


@pytest.mark.parametrize("way", ["start", "driver"])
def test_a_rotor_in_other_units(tmp_path, way):
    """12.1 rpm taken for rad/s, at 63 m; pitch in degrees."""
    for key, told in (("speed", 1), ("speed_rpm", 0)):
        data = mill(tmp_path, None).model_dump(exclude_unset=True)
        table = {"driver": {f"constant_{key}": 12.1}} if way == "driver" else {"start": {key: 12.1}}
        data["joint"]["rail"] = {"revolute": {"axis": "x"}, "between": ["ground", "kite"]} | table
        data["force"]["sail"]["rotor"] |= {"radius": 63.0, "pitch": 3.83 if told else 0.0668}
        scene = Scene.model_validate(data)
        assert len(said(scene, "faster than sound")) == told
        assert len(said(scene, "rad are 219.4 deg")) == told


def test_coefficients_of_members():
    assert len(said(pile({}, member={"drag": 9.0}), "drag: is 9: of round members it is about 1")) == 1
    assert not pile({}, member={"drag": 1.2}).notices


def test_blades_in_the_water(tmp_path):
    """The disc is across the x axis: of the one at the height of the water half is wet, the other is 38 m clear."""
    dry = mill(tmp_path, None)
    assert not [text for text in dry.simulate(0.01).notices if "blades" in text]
    dry.sea = {"depth": 50.0}
    (text,) = [text for text in dry.simulate(0.01).notices if "blades" in text]
    assert "[force.sail] on" in text and "start 2 m deep in the water" in text


def test_members_under_the_bed():
    def told(depth):
        scene = pile({}, sea={"depth": depth})
        return [text for text in scene.simulate(0.01).notices if "under the sea's bed" in text]

    assert not told(10.5)
    (text,) = told(6.0)
    assert "[force.drag] between" in text and "z = -10 m" in text
