"""Starts: what is given is what is taken, or the joint is named in a notice;
and all who ask are told the same."""

import contextlib
import io
import re
import tomllib

import numpy as np
from scipy.spatial.transform import Rotation

from mbdfmi import Scene
from mbdfmi.analysis.equilibrium import NoEquilibrium
from mbdfmi.cli import main
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.scene import SceneError, fmi_name

from .findings import Finding
from .independent import reading

NEAR = 1e-7
UNITS = {"": 1.0, "_deg": np.pi / 180, "_rpm": 2 * np.pi / 60}
OF_BODIES = ("position", "velocity", "euler_parameters", "omega", "omega_body")
COMPONENTS = {"x": 0, "y": 1, "z": 2, "first": 0, "second": 1}


def kept(data, run):
    """Findings where a given start value is not what the run starts with, and no notice names its joint."""
    if not run.values:
        return []

    first = dict(zip(run.names, run.values[0]))
    more = sum(int(n) for text in run.notices for n in re.findall(r"^and (\d+) more of this kind", text))
    found = []

    for name, joint in data.get("joint", {}).items():
        moved = any(names(text, name) for text in run.notices)

        # where a driver leads, no start is given
        for quantity, wanted in () if joint.get("driver") else given(joint):
            values = _values(first, fmi_name(name), quantity)

            # of a joint and a body of one name the body tells its own
            if name in data["body"] and quantity in OF_BODIES:
                continue

            if values is None or moved:
                continue

            # in a plane there is no z; of two surfaces that touch the first one's parameters are given
            wanted, values = wanted[: len(values)], values[: len(wanted)]
            off = _off(quantity, values, wanted, first, fmi_name(name))
            allowed = NEAR * max(1.0, np.nanmax(np.abs(wanted)))

            if np.nanmax(off) > allowed:
                k = int(np.nanargmax(off))
                text = "given to start with, and no notice names the joint"
                found.append(
                    Finding(
                        "start", str(run.way), f"{name}.{quantity}", 0.0, values[k], wanted[k], allowed, text
                    )
                )

    # of many only the first are told one by one
    return found if len(found) > more else []


def moved(run):
    """Start values that were not kept: what is told of each -> the numbers taken, to a few digits."""
    found = {}

    for text in run.notices:
        name, here, rest = text.partition(" at the start ")

        if here:
            found[name] = [f"{float(x):.3g}" for x in re.findall(r"(?:taken as|turned by) (\S+?)[:\s]", rest)]

    return found


def names(text, joint):
    """Whether a notice names a joint."""
    return re.search(rf"(?<!\w){re.escape(joint)}(?!\w)", text) is not None or fmi_name(joint) in text


def given(joint):
    """(quantity, value (n,), NaN where nothing is given) of each start value that a joint was written
    with."""
    start = joint.get("start", {})
    start = start if isinstance(start, dict) else {}

    for key, value in start.items():
        quantity, unit = next((key.removesuffix(u), u) for u in ("_deg", "_rpm", "") if key.endswith(u))

        if quantity in ("euler_parameters", "zyx", "zyx_rad", "axis_angle", "axes"):
            yield "euler_parameters", orientation({key: value})
            continue

        yield quantity, UNITS[unit] * _vector(value)


def orientation(table):
    """Euler parameters (4,) of an orientation as it is written."""
    return Rotation.from_matrix(reading.orientation(table)).as_quat()


def _vector(value):
    if not isinstance(value, dict):
        return np.atleast_1d(np.array(value, float))

    found = np.full(2 if set(value) & {"first", "second"} else 3, np.nan)

    for key, x in value.items():
        found[COMPONENTS[key]] = x

    return found


def _values(first, joint, quantity):
    """What a run tells of a joint's quantity (n,), None where it does not."""
    name = f"{joint}.{'omega' if quantity == 'omega_body' else quantity}"

    if name in first:
        return np.array([first[name]])

    values = [first[f"{name}[{k}]"] for k in range(1, 5) if f"{name}[{k}]" in first]
    return np.array(values) if values else None


def _off(quantity, values, wanted, first, joint):
    if quantity == "euler_parameters":
        return np.minimum(np.abs(values - wanted), np.abs(values + wanted))

    if quantity == "omega_body":
        E = _values(first, joint, "euler_parameters")
        values[:] = Rotation.from_quat(E).as_matrix().T @ values

    return np.abs(values - wanted)


def checked(scene, path):
    """Findings where `mbdfmi check` of the scene, written to a file,
    does not tell what a run of it is told at its start."""
    path.write_text(scene.to_toml(), encoding="utf-8")
    said = io.StringIO()

    try:
        wanted = Instance(Scene.model_validate(tomllib.loads(scene.to_toml())).compile()).notices
    except (SceneError, SimulationError, NoEquilibrium):
        wanted = None

    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = main(["check", str(path)])

    text = _plain(said.getvalue())

    if status:
        found = [
            Finding("check", "mbdfmi check", text=f"ends with {status}, but the scene starts: {text[-300:]}")
        ]
        return found if wanted is not None and "(time " not in text else []

    return [
        Finding("check", "mbdfmi check", text=f"does not tell: {n}")
        for n in wanted or []
        if _plain(n) not in text
    ]


def _plain(text):
    return " ".join(text.split())


def alike(run, other):
    """Findings where two hosts of one way tell different things."""
    one, two = ({_told(text) for text in r.notices} for r in (run, other))
    return [
        Finding("notices", str(other.way), text=f"told by one of process and FMU alone: {text}")
        for text in sorted(one ^ two)
    ]


def _told(text):
    """A notice without the time, which process and log tell in their own ways,
    and without the doubled signs of a log."""
    text = re.sub(r" \(time \S+ s\)$", "", text)
    text = re.sub(r"^(step|initialisation)( at t = \S+ s)?: ", "", text)
    return text.replace("%%", "%").replace("##", "#")


def written(data):
    """Findings where the scene, written as TOML and read again, is another model.
    Markers may come in another order."""
    scene = Scene.model_validate(data)
    again = Scene.model_validate(tomllib.loads(scene.to_toml()))
    shown = [
        sorted(
            (v.name, v.causality, v.variability, v.start, v.unit, v.description)
            for v in compile_scene(s).variables
        )
        for s in (scene, again)
    ]

    if scene.model_dump(warnings=False) != again.model_dump(warnings=False) or repr(shown[0]) != repr(
        shown[1]
    ):
        return [Finding("TOML", "to_toml", text="read again it gives another model")]

    return []
