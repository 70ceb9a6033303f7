"""Rotors by blade elements: momentum's own limits, another solver of the same equations, what `mbdfmi rotor` writes and refuses."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import assert_near

from mbdfmi.aero.blades import Polar, Rotor, read_blade, read_polar
from mbdfmi.cli import main

TURBINE = Path(__file__).parents[1] / "models" / "floating_wind_turbine"


def thin(drag=0.0):
    """2 pi alpha."""
    alpha = np.linspace(-np.pi, np.pi, 20001)
    return Polar("thin", alpha, 2 * np.pi * alpha, np.full_like(alpha, drag))


def test_an_ideal_rotor_takes_what_betz_allows():
    """Chord and twist of Betz's optimum (a = 1/3, with the wake's swirl), many blades (no loss at the tip), no drag, lambda = 8:
    Glauert's C_P of 0.58 to 0.5926, C_T near 8/9."""
    tip, ratio, blades = 50.0, 8.0, 400
    r = np.linspace(2.0, 49.99, 400)
    phi = 2 / 3 * np.arctan(tip / (ratio * r))
    lift = 0.6
    chord = 8 * np.pi * r * (1 - np.cos(phi)) / (blades * lift)
    rotor = Rotor(r, chord, phi - lift / (2 * np.pi), [thin()] * 400, tip, 1.0, blades)
    thrust, torque, _ = rotor.coefficients(np.array([ratio]), np.array([0.0]))
    assert 0.575 < torque[0, 0] * ratio < 16 / 27
    assert_near(thrust[0, 0], 8 / 9, 0.01)


def test_what_blades_feel_is_what_the_air_loses():
    """4 a (1 - a) F of the wind's momentum, 4 a' (1 - a) F of swirl, at a station of a light rotor."""
    r = np.linspace(5.0, 29.0, 25)
    rotor = Rotor(r, np.full(25, 1.2), np.radians(8 - 0.25 * r), [thin(0.01)] * 25, 30.0, 4.0)
    from mbdfmi.aero.blades import _Flow

    speed, pitch = np.array([[6.0 * r[12] / 30]]), np.array([[0.0]])
    flow = _Flow(rotor, 12, speed, pitch)
    phi = flow.solve()
    a, swirl, normal, tangential = flow.induced(phi)
    loss = flow.pushes(phi)[2]
    wind2 = (1 - a) ** 2 + (speed * (1 + swirl)) ** 2
    assert_near(np.tan(phi), (1 - a) / (speed * (1 + swirl)), 1e-9)
    assert_near(flow.solidity * normal * wind2, 4 * a * (1 - a) * loss, 1e-9)
    assert_near(flow.solidity * tangential * wind2, 4 * swirl * (1 - a) * speed * loss, 1e-9)


def written(folder):
    """The turbine's blade and its one generic polar, as files."""
    sys.path.insert(0, str(TURBINE))
    import blade_element as be

    lines = [f"{r},{c},{np.degrees(t)},foil" for r, c, t in zip(be.STATION, be.CHORD, be.TWIST)]
    (folder / "blade.csv").write_text("\n".join(["radius,chord,twist,polar", *lines]))
    alpha = np.linspace(-180, 180, 721)
    line = be.LIFT_SLOPE * (np.radians(alpha) - be.ZERO_LIFT)
    lift = line / (1 + np.abs(line / be.LIFT_MAX) ** 6) ** (1 / 6)
    drag = be.DRAG_MIN + be.DRAG_RISE * lift**2
    rows = [f"{a},{x},{y}" for a, x, y in zip(alpha, lift, drag)]
    (folder / "foil.csv").write_text("\n".join(["alpha,lift,drag", *rows]))
    return be


def test_fixed_points_find_the_same_rotor(tmp_path):
    """The turbine's own solver by fixed points, with its sums over rings, around where it works."""
    be = written(tmp_path)
    rotor = read_blade(tmp_path / "blade.csv", {"foil": read_polar(tmp_path / "foil.csv")}, 63.0, 1.5)
    ratio, pitch = np.array([4.0, 6.0, 7.5, 9.0]), np.radians([0.0, 3.83])
    thrust, torque, _ = rotor.coefficients(ratio, pitch)
    wanted = be.rotor_coefficients(*np.meshgrid(ratio, pitch, indexing="ij"))
    assert_near(thrust / wanted[0], 1.0, 0.01)
    assert_near(torque / wanted[1], 1.0, 0.01)


def test_the_command_writes_what_scenes_read(tmp_path, capsys):
    written(tmp_path)
    arguments = [
        "rotor",
        str(tmp_path / "blade.csv"),
        str(tmp_path / "foil.csv"),
        "--radius",
        "63",
        "--hub",
        "1.5",
    ]
    out, picture = tmp_path / "rotor.csv", tmp_path / "rotor.png"
    assert (
        main([*arguments, "-o", str(out), "--ratio", "2:12:11", "--pitch", "0:20:5", "--plot", str(picture)])
        == 0
    )
    assert "largest C_P" in capsys.readouterr().out and picture.stat().st_size > 10_000
    rows = np.loadtxt(out, delimiter=",", skiprows=1)
    assert rows.shape == (55, 4) and (rows[:, 2][rows[:, 1] == 0] > 0.1).all()


@pytest.mark.parametrize(
    "name, text, words",
    [
        (
            "blade.csv",
            "r,c,t,p\n10,2,5,foil\n20,2,1,fool\n30,1,0,foil\n",
            "line 3 names the polar 'fool'; given are foil",
        ),
        ("blade.csv", "r,c,t,p\n10,2,5,foil\n20,x,1,foil\n30,1,0,foil\n", "line 3: 'x' is no number"),
        ("blade.csv", "r,c,t,p\n10,2,5,foil\n5,2,1,foil\n30,1,0,foil\n", "radii ascend"),
        ("foil.csv", "a,l,d\n0,0.1,0.1\n-3,0.1,0.1\n", "angles of attack, ascending"),
        ("foil.csv", "a,l,d\n0,0.1\n", "line 2 needs 3 columns, found 2"),
        ("blade.csv", "2,3,10,foil\n30,2,5,foil\n60,1,0,foil\n", "line 1 is of numbers"),
        ("foil.csv", "-180,0,0.01\n0,0.5,0.01\n180,0,0.01\n", "line 1 is of numbers"),
    ],
)
def test_files_that_are_no_blade_are_told(tmp_path, capsys, name, text, words):
    written(tmp_path)
    (tmp_path / name).write_text(text)
    assert (
        main(
            ["rotor", str(tmp_path / "blade.csv"), str(tmp_path / "foil.csv"), "-o", str(tmp_path / "r.csv")]
        )
        == 1
    )
    assert words in capsys.readouterr().err
    assert not (tmp_path / "r.csv").exists()


def test_a_polar_that_ends_early_is_told(tmp_path, capsys):
    written(tmp_path)
    (tmp_path / "foil.csv").write_text("a,l,d\n-5,-0.2,0.01\n15,1.4,0.03\n")
    assert (
        main(
            ["rotor", str(tmp_path / "blade.csv"), str(tmp_path / "foil.csv"), "-o", str(tmp_path / "r.csv")]
        )
        == 0
    )
    assert "the polar foil ends at -5 and 15 deg" in " ".join(capsys.readouterr().err.split())
