"""FMUs of other makers, of public repositories, coupled with each other and with ours. They are not fetched: folders with the
FMUs of libcosim (tests/data/fmi2 and below) and of OMSimulator (testsuite/tests/resources/dcmotor/resources), all in one, are
named by MBDFMI_FOREIGN_FMUS.
"""

import os
from pathlib import Path

import numpy as np
import pytest

import mbdfmi
from mbdfmi.cosim import System

pytestmark = pytest.mark.long


def foreign(name):
    """The file of an FMU, wherever in the folder it is."""
    folder = os.environ.get("MBDFMI_FOREIGN_FMUS")
    if not folder:
        pytest.skip(
            "NOT TESTED: MBDFMI_FOREIGN_FMUS names no folder with the FMUs of libcosim and OMSimulator"
        )

    found = sorted(Path(folder).rglob(f"*{name}.fmu"))
    if not found:
        pytest.skip(f"NOT TESTED: there is no {name}.fmu below {folder}")
    return {"file": str(found[0])}


def links(*pairs):
    return [{"source": a, "target": b, "units": False} for a, b in pairs]


TRUCK = {"gravity": [0, 0, 0]}


def truck():
    """The quarter truck as one scene: 400 kg on 15 kN/m and 1 kN s/m, 40 kg on a tyre of 150 kN/m; the road rises by 0.1 m."""
    body = {"chassis": {"mass": 400.0, "inertia": [1, 1, 1]}, "wheel": {"mass": 40.0, "inertia": [1, 1, 1]}}
    rail = {"prismatic": {"axis": "z"}}
    tyre = rail | {"between": ["ground", "wheel"], "spring": {"stiffness": 150e3, "rest": 0.1}}
    strut = rail | {"between": ["wheel", "chassis"], "spring": {"stiffness": 15e3}, "damper": 1e3}
    scene = mbdfmi.Scene(name="truck", body=body, joint={"tyre": tyre, "strut": strut}, **TRUCK)
    return scene.simulate(2.0, 0.01).poses("chassis")[0][:, 2]


@pytest.mark.parametrize("method, bound", [("gauss-seidel", 3.2e-3), ("auto", 4e-3), ("jacobi", 8e-3)])
def test_the_quarter_truck_of_libcosim(method, bound):
    """Beside one scene. Its FMUs go back by themselves in each step unless they are told that none comes before it; what they
    restore is not all of their state, which is told and done without.
    """
    fmus = {"chassis": foreign("Chassis"), "wheel": foreign("Wheel")}
    pair = links(("wheel.out_spring_damper_f", "chassis.force"), ("chassis.velocity", "wheel.in_vel"))
    run = System(fmu=fmus, link=pair, master={"method": method}).simulate(2.0, 0.01)
    assert np.abs(run["chassis.position"] - truck()).max() < bound
    assert any("going back to a saved state is not exact" in text for text in run.notices) == (
        method == "auto"
    )


def test_a_chassis_of_ours_on_a_wheel_of_libcosim():
    """The same truck, one half of it ours, at 1 ms."""
    ours = mbdfmi.Scene(
        name="chassis",
        body={"chassis": {"mass": 400.0, "inertia": [1, 1, 1]}},
        joint={
            "rail": {
                "prismatic": {"axis": "z"},
                "between": ["ground", "chassis"],
                "input": "force",
                "output": ["position", "speed"],
            }
        },
        **TRUCK,
    )
    pair = links(("wheel.out_spring_damper_f", "chassis.rail.force"), ("chassis.rail.speed", "wheel.in_vel"))
    pair[0]["factor"] = -1.0
    fmus = {"chassis": {"scene": ours}, "wheel": foreign("Wheel")}
    run = System(fmu=fmus, link=pair).simulate(2.0, 1e-3)
    assert np.abs(run["chassis.rail.position"][::10] - truck()).max() < 5e-4


def test_the_machine_and_the_drive_of_omsimulator():
    """Dymola's: errors against steps of 1 ms fall with the step, and the first step in parts repeats."""
    fmus = {
        "machine": foreign("emachine_model"),
        "mass": foreign("edrive_mass"),
        "stimuli": foreign("stimuli_model"),
    }
    some = links(
        ("stimuli.U", "machine.U"),
        ("stimuli.M_load", "mass.M_B"),
        ("machine.M", "mass.M_A"),
        ("mass.wA", "machine.w"),
        ("mass.phiA", "machine.phi"),
    )
    runs = [System(fmu=fmus, link=some).simulate(1.0, H)["mass.wA"] for H in (1e-3, 1e-2, 2e-2)]
    fine = runs[0]
    coarse = [np.abs(run - fine[:: (len(fine) - 1) // (len(run) - 1)]).max() for run in runs[1:]]
    assert np.ptp(fine) > 50 and coarse[0] < 0.3 and coarse[0] < coarse[1] < 1.0


def test_the_knuckle_boom_crane_of_libcosim():
    """20-sim's crane and its hydraulic controller: nothing is commanded, and the boom stays where it is."""
    fmus = {"crane": foreign("KnuckleBoomCrane"), "control": foreign("CraneController")}
    some = [
        (f"crane.{name}[{k}]", f"control.{name}[{k}]")
        for name in ("Act_Limits", "p_Crane.f")
        for k in (1, 2, 3)
    ]
    some += [(f"control.p_Crane.e[{k}]", f"crane.p_Crane.e[{k}]") for k in (1, 2, 3)]
    run = System(fmu=fmus, link=links(*some)).simulate(2.0, 1e-3)
    assert all(np.all(np.isfinite(column)) for column in run.values())
