"""Trim against closed forms of steady motions."""

import numpy as np
import pytest

import mbdfmi
from mbdfmi import Scene

G = 9.81


def test_a_conical_pendulum_turns_at_the_speed_of_its_cone():
    """Two hinges, about z and y, a bob: the speed about z that keeps a cone of 40 deg, and the other way round."""
    length, cone = 0.8, np.radians(40)
    scene = Scene(
        name="cone",
        gravity=[0, 0, -G],
        body={"yoke": {"mass": 0.0}, "bob": {"mass": 1.5, "com": [0, 0, -length], "inertia": [0, 0, 0]}},
        joint={
            "spin": {"revolute": {"axis": "z"}, "between": ["ground", "yoke"], "start": {"speed": 3.0}},
            "cone": {"revolute": {"axis": "y"}, "between": ["yoke", "bob"], "start": {"angle": 0.5}},
        },
    )
    speed = np.sqrt(G / (length * np.cos(cone)))
    found = scene.trim(["spin.speed"], {"cone.acceleration": 0.0}, parameters={"cone.angle_start": cone})
    assert abs(found.values["spin.speed_start"] - speed) < 1e-10

    found = scene.trim(["cone.angle"], steady=True, parameters={"spin.speed_start": speed})
    assert abs(abs(found.values["cone.angle_start"]) - cone) < 1e-10
    assert found.unsteady == {}
    run = found.scene.simulate(5.0).poses("bob")
    assert np.ptp(run[0][:, 2]) < 1e-6

    # it swings about its cone with the speed that books have: w^2 (1 + 3 cos^2)
    (mode,) = [mode for mode in found.linearise([], []).modes() if mode.oscillates]
    assert abs(mode.eigenvalue.imag - speed * np.sqrt(1 + 3 * np.cos(cone) ** 2)) < 1e-8


def test_the_torque_that_keeps_a_turbine_at_12_rpm():
    scene = mbdfmi.load(mbdfmi.__path__[0] + "/../models/floating_wind_turbine/floating_wind_turbine.toml")
    scene.joint["shaft"].damper = 2.0e5
    scene.joint["float"] = {"fixed": {}, "between": ["ground", "platform"]}
    found = scene.trim(["shaft.torque"], {"shaft.acceleration": 0.0}, hold={"hub.moment[1]": 1e6})
    speed = 12.1 * np.pi / 30
    assert abs(found.inputs["shaft.torque"] - (2.0e5 * speed - 1e6)) < 1e-6 * 1e6


def test_a_load_that_brings_a_beam_to_an_angle_at_rest():
    bar = {"mass": 2.0, "com": [0.5, 0, 0], "inertia": [0, 0.1, 0.1]}
    joint = {"revolute": {"axis": "y"}, "between": ["ground", "bar"], "spring": {"stiffness": 30.0}}
    scene = Scene(name="bar", gravity=[0, 0, -G], body={"bar": bar}, joint={"hinge": joint})
    found = scene.trim(["bar.mass"], {"hinge.angle": 0.2}, rest=True)
    assert abs(found.parameters["bar.mass"] - 30 * 0.2 / (G * 0.5 * np.cos(0.2))) < 1e-9


def test_what_cannot_be_trimmed_is_told():
    bar = {"mass": 2.0, "com": [0.5, 0, 0], "inertia": [0, 0.1, 0.1]}
    joint = {"revolute": {"axis": "y"}, "between": ["ground", "bar"], "input": "torque"}
    scene = Scene(name="bar", gravity=[0, 0, -G], body={"bar": bar}, joint={"hinge": joint})

    with pytest.raises(
        ValueError, match="hinge.angle comes to 0, not 0.2; .hinge.torque. does nothing for it"
    ):
        scene.trim(["hinge.torque"], {"hinge.angle": 0.2})
    with pytest.raises(KeyError, match="did you mean 'hinge.torque'"):
        scene.trim(["hinge.torqe"], {"hinge.angle": 0.2})
    with pytest.raises(KeyError, match="no output"):
        scene.trim(["hinge.torque"], {"hinge.angel": 0.2})
    with pytest.raises(ValueError, match="no condition"):
        scene.trim(["hinge.torque"])


def test_drives_are_where_they_are_at_each_try():
    """A driven hinge holds at 0.4 rad at 1 s, whatever was looked for before."""
    bar = {
        "mass": 1.0,
        "com": [0, 0, -0.5],
        "inertia": [0, 0.1, 0.1],
        "marker": {"end": {"position": [0, 0, -1]}},
    }
    scene = Scene(
        name="two",
        gravity=[0, 0, -G],
        body={"a": bar, "b": bar},
        joint={
            "motor": {
                "revolute": {"axis": "y"},
                "between": ["ground", "a"],
                "driver": {"polynomial": {"coefficients": [0, 0.4]}},
            },
            "free": {"revolute": {"axis": "y"}, "between": ["a.end", "b"], "input": "torque"},
        },
    )
    found = scene.trim(["free.torque"], {"free.angle": -0.1}, rest=True, time=1.0)
    assert abs(found.inputs["free.torque"] - G * 0.5 * np.sin(0.3)) < 1e-9


def flyball(**solver):
    """A bob on a yoke that is driven by a torque against a damper, to turn in a cone of 40 deg."""
    spin = {"revolute": {"axis": "z"}, "between": ["ground", "yoke"], "damper": 0.3, "input": "torque"}
    cone = {"revolute": {"axis": "y"}, "between": ["yoke", "bob"], "start": {"angle_deg": 40.0}}
    return Scene(
        name="flyball",
        gravity=[0, 0, -G],
        body={"yoke": {"mass": 0.0}, "bob": {"mass": 1.5, "com": [0, 0, -0.8], "inertia": [0, 0, 0]}},
        joint={
            "spin": spin | {"start": {"speed": 3.0}, "output": ["speed"]},
            "cone": cone | {"output": ["angle"]},
        },
        solver=solver,
    )


TRIM = {"find": {"spin.speed": 4.0, "spin.torque": 0.0}, "steady": True}


def test_a_scene_starts_trimmed(tmp_path):
    """Speed and torque of a steady cone: of a run, of another with other values, of a linear model, of an FMU."""
    import fmpy

    scene = flyball(start="trim", trim=TRIM)
    speed = np.sqrt(G / (0.8 * np.cos(np.radians(40))))
    run = scene.simulate(5.0)
    assert np.abs(run["cone.angle"] - np.radians(40)).max() < 1e-8
    assert np.abs(run["spin.speed"] / speed - 1).max() < 1e-8
    assert np.abs(run["spin.torque"] / (0.3 * speed) - 1).max() < 1e-10
    moon = scene.simulate(5.0, parameters={"gravity[3]": -1.62, "spin.damper": 0.1})
    assert np.abs(moon["spin.speed"] - np.sqrt(1.62 / 9.81) * speed).max() < 1e-8
    assert np.ptp(moon["cone.angle"]) < 1e-8

    # what the run gives itself counts there, and is told
    other = scene.simulate(0.1, inputs={"spin.torque": 0.0})
    assert other["spin.speed"][0] == pytest.approx(speed, rel=1e-10) and other["spin.torque"][0] == 0.0
    assert any("finds spin.torque = 1.2" in text and "begins with 0" in text for text in other.notices)

    (mode,) = [mode for mode in scene.linearise([], []).modes() if mode.oscillates]
    direct = scene.trim().linearise([], []).modes()
    assert min(abs(mode.eigenvalue - one.eigenvalue) for one in direct) < 1e-9

    path = scene.export(tmp_path / "flyball.fmu")
    starts = {v.name: v.start for v in fmpy.read_model_description(str(path)).modelVariables}
    assert float(starts["spin.torque"]) == pytest.approx(0.3 * speed, rel=1e-10)
    result = fmpy.simulate_fmu(str(path), stop_time=2.0, output=["cone.angle"])
    assert np.ptp(result["cone.angle"]) < 1e-8


def test_a_trimmed_mass_is_that_of_the_run():
    """A parameter that is found at rest: the start is that of a bar of this mass, and so is the run."""
    bar = {"mass": 2.0, "com": [0.5, 0, 0], "inertia": [0, 0.1, 0.1]}
    joint = {"revolute": {"axis": "y"}, "between": ["ground", "bar"], "spring": {"stiffness": 30.0}}
    solver = {"start": "trim", "trim": {"find": ["bar.mass"], "keep": {"hinge.angle": 0.2}, "rest": True}}
    scene = Scene(
        name="bar",
        gravity=[0, 0, -G],
        body={"bar": bar},
        joint={"hinge": joint | {"output": ["angle"]}},
        solver=solver,
    )
    assert np.abs(scene.simulate(3.0)["hinge.angle"] - 0.2).max() < 1e-9
    (mass,) = [v.start for v in scene.compile().variables if v.name == "bar.mass"]
    assert abs(mass - 30 * 0.2 / (G * 0.5 * np.cos(0.2))) < 1e-9

    with pytest.raises(ValueError, match="find: .bar.mass. is to be found, and given"):
        scene.simulate(1.0, parameters={"bar.mass": 3.0})


def test_a_trim_that_does_not_fit_is_told(tmp_path):
    from mbdfmi.scene import SceneError

    for trim, text in (
        (None, "needs a table [solver.trim]"),
        ({"find": ["spin.speed"]}, "needs a condition"),
        ({"find": [], "steady": True}, "needs a list of names"),
        ({"find": ["a", "a"], "steady": True}, '"a" is listed twice'),
        (
            {"find": ["spin.speed"], "steady": ["conee"]},
            'no joint "conee"; there is "spin" and "cone". Did you mean "cone"?',
        ),
        ({"find": ["spin.speed"], "keep": {"cone.angle": "much"}}, '"cone.angle" needs a number'),
        ({"find": ["spin.speed"], "steady": True, "rest": True}, "exclude each other"),
    ):
        with pytest.raises(SceneError) as raised:
            flyball(start="trim", **({"trim": trim} if trim else {}))

        assert text in str(raised.value) and str(raised.value).startswith("[solver]")

    path = tmp_path / "flyball.toml"
    path.write_text(flyball(start="trim", trim={"find": ["spin.sped"], "steady": True}).to_toml())
    scene = mbdfmi.load(path)
    assert mbdfmi.load(path) == scene

    with pytest.raises(
        ValueError, match=r"flyball.toml: \[solver.trim\] find: no input.*did you mean 'spin.speed"
    ):
        scene.simulate(1.0)

    never = flyball(start="trim", trim={"find": ["spin.torque"], "keep": {"cone.angle": 0.1}})

    with pytest.raises(ValueError, match=r"\[solver.trim\] no trim was found: cone.angle comes to 0.698"):
        never.compile()


def test_the_command_trims_as_the_scene_asks(tmp_path, capsys):
    from mbdfmi.cli import main

    path = tmp_path / "flyball.toml"
    path.write_text(flyball(trim=TRIM).to_toml())
    assert main(["trim", str(path)]) == 0
    assert "spin.torque" in capsys.readouterr().out
    path.write_text(flyball().to_toml())
    assert main(["trim", str(path)]) == 1
    assert "--find" in capsys.readouterr().err


def test_a_locus_is_of_trimmed_states():
    """The frequency of a steady cone over gravity: its square is proportional to that."""
    from mbdfmi.analysis.locus import locus

    scene = flyball(start="trim", trim=TRIM)
    scene.joint["spin"].damper = 1e-9
    found = locus(scene, "gravity[3]", [-9.81, -4.0, -1.62], "start")
    swing = np.abs(found.eigenvalues.imag).max(axis=1)
    assert np.abs(swing / swing[0] - np.sqrt(np.array([9.81, 4.0, 1.62]) / 9.81)).max() < 1e-8
