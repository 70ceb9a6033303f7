"""Runs of an FMU by fmpy, to be looked at: the states that it hands out are those of a run in process."""

import struct

import numpy as np

from ..compiler.model import Model
from ..kernels.motion.inputs import N_DERIVATIVE
from ..run.instance import Instance
from ..run.states import States
from .runs import Run

# a serialised state (fmu_src/snapshot.c): how it begins, its format, where that, sizes and GUID stand; its
# numbers are its end
MAGIC = bytes(8) + b"mbdfmi\0S"
VERSION = 5
FORMAT, SIZES, GUID = 16, 24, 48


class Recorder:
    """Keeps the state of an FMU of a scene after each step of a run by fmpy:

        recorder = scene.recorder()
        fmpy.simulate_fmu("crane.fmu", stop_time=10, step_finished=recorder)
        recorder.results().view("run.html")

    The first row is that after the first step. With other masters: `keep` with a serialised state at each
    row.
    """

    def __init__(self, model: Model):
        self.model = model
        self._kept: list[bytes] = []

    def __call__(self, time, recorder) -> bool:
        """What fmpy calls after a step; goes on."""
        fmu = recorder.fmu
        state = fmu.getFMUState()
        self.keep(fmu.serializeFMUState(state))
        fmu.freeFMUState(state)
        return True

    def keep(self, snapshot: bytes):
        """Keeps a serialised state of the FMU. Raises ValueError for one of another FMU."""
        model = self.model
        sizes = len(model.reals), model.n_state, model.n_u
        guid = snapshot[GUID : GUID + len(model.guid)]

        if not snapshot.startswith(MAGIC) or len(snapshot) < GUID + 8 * sum(sizes):
            raise ValueError("this is no state of an FMU made by mbdfmi")
        if (found := struct.unpack_from("<I", snapshot, FORMAT)[0]) != VERSION:
            raise ValueError(f"the state has format {found}, {VERSION} is read here: export the FMU anew")
        if guid != model.guid.encode() or struct.unpack_from("<3q", snapshot, SIZES) != sizes:
            raise ValueError(
                f"the state is of the FMU {guid.decode(errors='replace')}, the scene makes {model.guid}: "
                "it is of another scene, or of another version of it"
            )

        self._kept.append(snapshot)

    def results(self) -> Run:
        """The run so far: all inputs and outputs, and the states to draw it. Raises ValueError before the
        first.
        """
        if not self._kept:
            raise ValueError("no step was kept; pass the recorder as step_finished to fmpy.simulate_fmu")

        model, n = self.model, len(self._kept)
        states, instance = States(model, n), Instance(model)
        shown = [v for v in model.variables if v.causality != "parameter"]
        columns = np.empty((n, len(shown)))

        for k, snapshot in enumerate(self._kept):
            d, u = instance.d, N_DERIVATIVE * model.n_u
            count = len(model.reals) + model.n_state + u
            numbers = np.frombuffer(snapshot[-8 * count :], "<f8")
            reals, state, inputs = np.split(numbers, [len(model.reals), len(model.reals) + model.n_state])
            instance.reals[:] = reals
            d.state_buffer[:] = state
            instance.u[:u] = inputs
            columns[k, : model.n_u] = inputs[: model.n_u]
            columns[k, model.n_u :] = instance.outputs()
            states.keep(k, instance)

        units = {"time": "s"} | {v.name: v.unit for v in shown}
        by_name = {"time": states.time} | {v.name: columns[:, j] for j, v in enumerate(shown)}
        return Run(by_name, units, model.title, list(model.notices), states)
