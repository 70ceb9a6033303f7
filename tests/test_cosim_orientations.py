"""Links that make Euler parameters and angular velocities of angles (`convert`)."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbdfmi import Scene
from mbdfmi.cosim import CouplingError, System, load_system
from mbdfmi.cosim.conversions import CONVERSION, conversion
from mbdfmi.cosim.signals import Signal

ORDERS = [
    "".join(letters)
    for letters in itertools.product("xyz", repeat=3)
    if all(map(str.__ne__, letters, letters[1:]))
]
KINDS = [*(f"euler_{order}" for order in ORDERS), "rotation_vector"]
NOTHING = np.zeros(4)


def scalars(n):
    texts = dict(variable="a", kind="real", group="Real", causality="output", variability="continuous")
    rest = dict(reference=0, element=0, size=1, unit=None, unit_name=None, start=None, nominal=0.0)
    return [Signal(name=f"a{k}", **texts, **rest) for k in range(n)]


def rotation(kind, angles):
    """By scipy's own conventions: capital letters are axes that turn along."""
    if kind == "rotation_vector":
        return Rotation.from_rotvec(angles)

    return Rotation.from_euler(kind[-3:].upper(), angles)


def test_there_are_twelve_orders_and_no_other():
    assert len(ORDERS) == 12
    assert all(CONVERSION.fullmatch(kind) for kind in KINDS)
    assert not any(map(CONVERSION.fullmatch, ["euler_zzx", "euler_xyy", "euler_xy", "zyx", "euler_zyx_rate"]))


@pytest.mark.parametrize("kind", KINDS)
def test_orientations_are_those_of_scipy(kind):
    """Of 20 triples each, also where Euler angles are singular; E and the next one are on one side."""
    draw = np.random.default_rng(3)
    made = conversion(kind, scalars(3), [1.0] * 3)

    for angles in [*draw.uniform(-7, 7, (20, 3)), np.zeros(3), np.array([0.3, np.pi / 2, 0.2])]:
        E = made.of(angles, NOTHING)
        apart = rotation(kind, angles).inv() * Rotation.from_quat(E)
        assert apart.magnitude() < 1e-14
        assert made.of(angles, -E) @ -E > 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_angular_velocities_are_rates_of_the_orientation(kind):
    """Differences of order 4 of the turn within the fixed axes, within 1e-9 of it; short rotation vectors too."""
    draw = np.random.default_rng(4)
    made = conversion(f"{kind}_rates", scalars(6), [1.0] * 6)
    h = 1e-3

    for size in (2.0, 1e-5, 0.0):
        angles, rates = size * draw.uniform(-1, 1, 3), draw.uniform(-2, 2, 3)
        turns = [
            (rotation(kind, angles + k * h * rates) * rotation(kind, angles).inv()).as_rotvec()
            for k in (-2, -1, 1, 2)
        ]
        omega = (turns[0] - 8 * turns[1] + 8 * turns[2] - turns[3]) / (12 * h)
        assert np.abs(made.of(np.concatenate([angles, rates]), NOTHING) - omega).max() < 1e-9


# runs


def harmonic(amplitude, frequency):
    return {"harmonic": {"amplitude_deg": amplitude, "frequency": frequency}}


SHIP = Scene(
    name="ship",
    body={"hull": {"mass": 1.0, "inertia": [1, 1, 1]}},
    joint={
        "sea": {
            "prescribed": {},
            "between": ["ground", "hull"],
            "driver": {"yaw": harmonic(30, 0.1), "pitch": harmonic(20, 0.3), "roll": harmonic(40, 0.2)},
            "output": ["zyx", "zyx_rate", "euler_parameters", "omega"],
        }
    },
)
"""Its yaw, pitch and roll are told, and, by kernels, its Euler parameters and its angular velocity."""


def crane(*told):
    """A scene on a ground whose motion inputs tell by these quantities."""
    load = {"mass": 1.0, "com": [0, 0, -1], "inertia": [0.1, 0.1, 0.1]}
    return Scene(
        name="crane",
        ground={"marker": {"deck": {"position": [0, 0, 0]}}, "motion": {"input": list(told)}},
        body={"load": load | {"marker": {"seen": {"output": ["euler_parameters", "omega"]}}}},
        joint={"weld": {"fixed": {}, "between": ["ground.deck", "load.seen"]}},
    )


CRANE = crane("euler_parameters", "omega")

LINKS = [
    {"source": "ship.sea.zyx", "target": "crane.ground.euler_parameters", "convert": "euler_zyx"},
    {
        "source": ["ship.sea.zyx", "ship.sea.zyx_rate"],
        "target": "crane.ground.omega",
        "convert": "euler_zyx_rates",
    },
]


def system(link=LINKS, **master):
    return System(fmu={"ship": {"scene": SHIP}, "crane": {"scene": CRANE}}, link=link, master=master)


def column(run, name, n):
    return np.column_stack([run[f"{name}[{k + 1}]"] for k in range(n)])


@pytest.mark.parametrize("master", [{}, {"method": "jacobi"}, {"method": "gauss-seidel", "order": 2}])
def test_a_deck_moves_as_the_ship_does(master):
    """Angles of one scene move the ground of another: its Euler parameters and angular velocity are those that the
    first tells itself, at each communication point; held inputs are a step late.
    """
    run = system(**master).simulate(2.0, 0.01)
    late = master.get("method") == "jacobi"
    pair = "ship.sea.euler_parameters", "crane.load.seen.euler_parameters"
    right, found = (Rotation.from_quat(column(run, name, 4)) for name in pair)
    assert (right.inv() * found).magnitude().max() < (1e-4 if late else 1e-6)
    right, found = column(run, "ship.sea.omega", 3), column(run, "crane.load.seen.omega", 3)
    assert np.abs(right - found).max() < (1e-2 if late else 1e-8)


def test_angles_that_are_counted_anew_lead_on():
    """Where a yaw jumps from 180 to -180 deg the Euler parameters do not."""
    made = conversion("euler_zyx", scalars(3), [np.pi / 180] * 3)
    before = NOTHING

    for yaw in np.arange(170, 191):
        E = made.of(np.array([yaw if yaw <= 180 else yaw - 360, 5.0, 0.0]), before)
        assert before @ before == 0.0 or np.linalg.norm(E - before) < 0.01
        before = E


@pytest.mark.parametrize(
    "link, told",
    [
        ({"source": "ship.sea.zyx[1]"}, 'convert = "euler_zyx" takes 3 angles, found 1 components'),
        (
            {"target": "crane.ground.omega"},
            'convert = "euler_zyx" makes 4 Euler parameters (scalar last), and crane.ground.omega has 3 components',
        ),
        (
            {"source": "ship.sea.omega"},
            "takes 3 angles: ship.sea.omega[1] is in rad/s, not in rad or the like",
        ),
        ({"convert": "euler_zyx_rates"}, "takes 3 angles and their 3 rates, found 3 components"),
        ({"convert": "zyx"}, 'link[1].convert: needs "euler_zyx", of angles about z,'),
        ({"convert": "euler_zzy"}, 'found "euler_zzy"'),
        ({"offset": 1.0}, "a link with convert takes no offset"),
        (
            {"source": ["ship.sea.zyx[1]", "ship.sea.zyx[2]", "other.sea.zyx[3]"]},
            "convert takes sources of one FMU, found those of",
        ),
    ],
)
def test_what_does_not_fit_is_told(link, told):
    """With the link's number."""
    fmu = {"ship": {"scene": SHIP}, "crane": {"scene": CRANE}, "other": {"scene": SHIP}}

    with pytest.raises(CouplingError) as error:
        System(fmu=fmu, link=[LINKS[0] | link]).check()

    assert told in str(error.value)
    assert "link" in str(error.value)


def test_a_file_has_it_and_ssp_does_not(tmp_path):
    """Three sources, a factor each; the text of --check; a package is refused."""
    for scene in (SHIP, crane("euler_parameters")):
        (tmp_path / f"{scene.name}.toml").write_text(scene.to_toml())

    (tmp_path / "system.toml").write_text(
        """
        [fmu.ship]
        scene = "ship.toml"

        [fmu.crane]
        scene = "crane.toml"

        [[link]]
        source  = ["ship.sea.zyx[1]", "ship.sea.zyx[2]", "ship.sea.zyx[3]"]
        factor  = [1, 1, -1]
        target  = "crane.ground.euler_parameters"
        convert = "euler_zyx"
        """
    )
    loaded = load_system(tmp_path / "system.toml")
    told = loaded.check()
    assert "ship.euler_zyx(sea.zyx[1], sea.zyx[2], sea.zyx[3])[4] -> crane.ground.euler_parameters[4]" in told
    run = loaded.simulate(0.5, 0.01)
    angles = column(run, "ship.sea.zyx", 3) * [1, 1, -1]
    found = Rotation.from_quat(column(run, "crane.load.seen.euler_parameters", 4))
    assert (Rotation.from_euler("ZYX", angles).inv() * found).magnitude().max() < 1e-12

    with pytest.raises(CouplingError, match="converts an orientation, which SSP 1.0 has no words for"):
        loaded.write_ssp(tmp_path / "system.ssp")
