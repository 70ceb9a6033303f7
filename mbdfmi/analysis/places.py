"""The states that a scene can be looked at in: its start, its equilibrium, any time of a run."""

import numpy as np

from ..compiler.model import compile_scene
from ..kernels.motion import drives
from ..run.inputs import known, numbers
from ..scene import variable_name
from ..scene.errors import listed
from .mechanism import GROUND, Mechanism

START, EQUILIBRIUM = "start", "equilibrium"
AT_START, AT_REST = "the start", "the equilibrium"

# speeds below that part of 1 rad/s, or of the scene's length in a second, are none
NO_SPEED = 1e-12


def mechanism_of(scene, hold=None, parameters=None, time=0.0, like=None):
    """A scene at its start, with inputs held at values and parameters set, by name; like : a mechanism of it.
    Raises KeyError, ValueError, SimulationError.
    """
    at = {}

    if hold:
        model = like.model if like else compile_scene(scene, for_fmu=False)
        by_name = {v.name: v for v in model.of_causality("input")}

        for name, value in hold.items():
            parts = [by_name[part].index for part in known(variable_name(name), by_name, "input")]
            values = numbers(value, f"input {name!r}", () if len(parts) == 1 else (len(parts),))
            at |= zip(parts, np.ravel(values).tolist())

    if like:
        return like.again(parameters, at, time)

    return Mechanism(scene, parameters=parameters, inputs=at, start_time=time)


def state_at(scene, at=None, hold=None, parameters=None, progress=None, like=None):
    """(the mechanism in a state, where that is in words, what is to be told of it), see `linearise`.

    like : a mechanism of the scene.
    """
    from .equilibrium import NoEquilibrium, settle

    tell = progress or (lambda text: None)

    if at not in (None, START, EQUILIBRIUM):
        time = _time(at)
        mechanism = mechanism_of(scene, hold, parameters, like=like)

        tell(f"running to {time:g} s")
        mechanism.instance.step(time)
        return mechanism, f"{time:g} s into a run", list(mechanism.instance.notices)

    mechanism = mechanism_of(scene, hold, parameters, like=like)
    notices = list(mechanism.instance.notices)

    if at == START or (at is None and not rests(mechanism)):
        return mechanism, AT_START, notices

    tell("looking for the equilibrium")

    try:
        settle(mechanism)
    except NoEquilibrium as error:
        if at == EQUILIBRIUM:
            raise

        told = [*notices, f"{error}; this is about the start"]
        return mechanism.again(parameters, mechanism.held), AT_START, told

    return mechanism, AT_REST, notices + stilled(mechanism)


def stilled(mechanism) -> list[str]:
    """What is to be told of drives that an equilibrium holds while they move."""
    time = f"at {mechanism.d.time[0]:g} s"
    names = [name for name in mechanism.stilled if name != GROUND]
    told = []

    if GROUND in mechanism.stilled:
        told.append(
            f"the ground moves {time}: it is held where it is then, and what its motion does to the scene, "
            "as a turn by its centrifugal forces, is left out"
        )

    if names:
        told.append(
            f"drives move {listed(names)} {time}: this is the rest of what they hold where it is then"
        )

    return told


def _time(at):
    """s, of a time that is told as a number or in text. Raises ValueError."""
    try:
        time = float(at)
    except (TypeError, ValueError):
        time = np.nan

    if not 0.0 <= time < np.inf:
        words = f'"{START}", "{EQUILIBRIUM}", or a time of a run, a number of seconds from 0 on'
        raise ValueError(f"at = {at!r}: {words}")

    return time


def rests(mechanism):
    """Whether nothing moves, drives included."""
    m, d = mechanism.m, mechanism.d
    speeds = np.abs(d.v).max(initial=0.0) if m.n_v else 0.0

    for k in range(m.n_drive):
        if m.drive_body[k] < 0:
            speeds = max(speeds, abs(drives.target(m, d, k)[1]))

    return speeds <= NO_SPEED
