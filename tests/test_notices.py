"""What a user should be told without being refused: notices of a scene, of its start, of a run."""

import struct
import zlib
from dataclasses import replace
from pathlib import Path

import pytest
from fmu_host import OK, WARNING, Instance, Library

from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.export.resource import resource
from mbdfmi.kernels import layout
from mbdfmi.kernels.status import MESSAGES, MOST_NOTICES, STIFF, status, tell
from mbdfmi.run.instance import Instance as InProcess
from mbdfmi.run.simulate import simulate
from mbdfmi.scene import read_scene

PENDULUM = Path(__file__).parents[1] / "models" / "pendulum.toml"
HEAD_OF_STATE = 8 + 16 + 24 + 64  # bytes before the core of a serialised state


@pytest.fixture(scope="module")
def model():
    return compile_scene(read_scene(PENDULUM))


@pytest.fixture(scope="module")
def library(model, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pendulum")
    noticed = replace(model, notices=["[body.bob] mass: 100 % odd #1", "another"])
    return Library(export_fmu(noticed, folder / "pendulum.fmu"), folder / "pendulum")


def test_notices_of_a_model_open_every_run(model):
    noticed = replace(model, notices=["[body.bob] mass: odd"])
    assert simulate(noticed, 0.1).notices == ["[body.bob] mass: odd"]
    assert simulate(model, 0.1).notices == []


@pytest.mark.parametrize("logging", [True, False])
def test_an_fmu_warns_when_its_start_stands(library, logging):
    instance = Instance(library, logging=logging)
    assert instance.setup() == instance.enter() == OK
    assert not [entry for entry in instance.log if entry[0] == WARNING]
    assert instance.exit() == OK
    warnings = [entry for entry in instance.log if entry[0] == WARNING]
    assert [entry[1] for entry in warnings] == ["logStatusWarning"] * 2
    assert [entry[2] for entry in warnings] == ["[body.bob] mass: 100 %% odd ##1", "another"]
    assert instance.step(0.0, 0.01) == OK
    assert len([entry for entry in instance.log if entry[0] == WARNING]) == 2
    instance.free()


def test_kernels_notices_with_numbers(model, monkeypatch):
    """Place and numbers stand in the text; all are told once, and those too many are counted."""
    monkeypatch.setitem(MESSAGES, 99, "%s: given %g, taken %g, 5 %")
    instance = InProcess(model)
    tell(instance.d, status(99, 1), 0.25, -1e-7)
    tell(instance.d, status(STIFF, 0), 0.0, 0.0)
    instance.step(0.5)
    place = model.places[1]
    assert instance.notices == [
        f"{place}: given 0.25, taken -1e-07, 5 % (time 0.5 s)", f"{MESSAGES[STIFF]} (time 0.5 s)"
    ]  # fmt: skip

    for k in range(MOST_NOTICES + 3):
        tell(instance.d, status(99, 1), float(k), 0.0)
    instance.step(0.5)
    told = instance.notices[2:]
    assert len(told) == MOST_NOTICES + 1 and told[-1] == "and 3 more of this kind (time 1 s)"
    assert told[MOST_NOTICES - 1].startswith(f"{place}: given {MOST_NOTICES - 1}, ")


def test_kernels_notices_in_the_log(model, library, tmp_path):
    """The same texts as in process, from a state that holds them."""
    messages = MESSAGES | {99: "%s: given %g, taken %g, 5 %"}
    (tmp_path / "model.bin").write_bytes(resource(model, messages))
    instance = Instance(library, location=tmp_path.as_uri().encode()).start()
    data = bytearray(instance.serialise(instance.save()))
    state_at = HEAD_OF_STATE + 10 * 8 + 8 * len(model.reals)
    told = {
        "notices": [2.0],
        "notice": [float(status(99, 1)), 0.25, -1e-7, float(status(STIFF, 0)), 0.0, 0.0],
    }
    for name, values in told.items():
        at = int(model.ints[layout.SLOT[name]])
        struct.pack_into(f"<{len(values)}d", data, state_at + 8 * at, *values)
    struct.pack_into("<I", data, 20, zlib.crc32(data[HEAD_OF_STATE:]))
    state, snapshot = instance.deserialise(bytes(data))
    assert state == instance.restore(snapshot) == OK
    instance.log.clear()
    assert instance.step(0.0, 0.5) == OK
    texts = [entry[2] for entry in instance.log]
    place = model.places[1]
    assert texts[0] == f"step at t = 0.5 s: {place}: given 0.25, taken -1e-07, 5 %%"
    assert MESSAGES[STIFF] in texts[1] and len(texts) == 2
    instance.free()
