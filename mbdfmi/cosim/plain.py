"""Macro steps of one length, with no more between the FMUs' calls than products of matrices that are made before.

What FMUs are told over a step is linear in what was read at the last points and, in sequence, in what those before them have reached:
the predictions of outputs, inputs at the end, slopes and squares of polynomials, values that are held (docs/coupling.md). The rest
of a step, all that may go otherwise, is `March`'s.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from .history import History
from .rig import Port, Rig


class Plain:
    """Steps of H (s) of FMUs that are not repeated.

    phases : FMUs by when they are told, each time with what those of earlier phases have reached. order : of the polynomials that
    inputs are. smooth : (n_y,) 1 for outputs that are continued beyond the last points.
    """

    def __init__(self, rig: Rig, phases: Sequence[Sequence[Port]], H: float, order: int, smooth: np.ndarray):
        self.rig, self.H, self.order = rig, H, order
        self._calls = []
        reached = np.zeros(rig.net.n_y)

        for ports in phases:
            fed = [port for port in ports if port.n_u]
            rows = [self._told(port, reached, smooth) for port in fed]
            parts = [part for row in rows for part in row]
            matrix = np.concatenate(parts) if parts else np.zeros((0, len(rig.known)))
            told = np.zeros(len(matrix))
            sets, ends, first = [], [], 0

            for port, row in zip(fed, rows):
                ends.append((port.end, told[first : first + port.n_u]))
                address = told.ctypes.data + 8 * (first + port.n_u)
                sets.append((port, port.setting(address, max(1, order))))
                first += sum(map(len, row))

            steps = rig.stepping(ports, H)
            self._calls.append((matrix, told, ends, sets, steps))
            for port in ports:
                reached[port.columns] = 1.0

    def _told(self, port, reached, smooth):
        """Matrices of [end, value, first derivative, second] of an FMU's inputs by `rig.known`: y, 1, y at the start of the step, at
        the two points before.
        """
        net, H = self.rig.net, self.H
        G, b = net.G[port.rows], net.b[port.rows, None]
        none, ahead = 0.0 * G, G * ((1.0 - reached) * smooth)
        still = G * (1.0 - reached)
        coefficients = ((0.0, 0.0, 0.0), (1.0, -1.0, 0.0), (2.0, -3.0, 1.0))[self.order]
        end = np.hstack(
            [G * reached, b, still + coefficients[0] * ahead, *(c * ahead for c in coefficients[1:])]
        )
        now = np.hstack([none, b, G, none, none])
        before = np.hstack([none, b, none, G, none])
        slope = (end - now) / H
        square = (slope - (now - before) / H) / (2 * H) if self.order == 2 else 0.0 * end

        if port.follows:
            return end, now, slope - square * H, *([2.0 * square] if self.order == 2 else [])

        w = port.weights[:, :, None]
        return end, w[0] * now + w[1] * end + w[2] * H * H * square

    def march(self, times: Sequence[float], history: History):
        """From each of the times (s) to the next. Raises CouplingError, Ended."""
        rig, H, order = self.rig, self.H, self.order
        known, y, old, older, oldest = rig.known, rig.y, rig.old, rig.older, rig.oldest
        reached, rows, row, inputs, input_row = (
            history.reached, history.rows, history.row, history.inputs, history.input_row,
        )  # fmt: skip
        copy, dot = np.copyto, np.dot
        done = 0

        try:
            for time, end in itertools.pairwise(times):
                if order:
                    if order == 2:
                        copy(oldest, older)
                    copy(older, old)
                copy(old, y)

                for matrix, told, ends, sets, steps in self._calls:
                    if sets:
                        dot(matrix, known, told)
                        for kept, part in ends:
                            copy(kept, part)
                        for port, calls in sets:
                            for call in calls:
                                if status := call():
                                    rig.time = time
                                    port.check(status, "setting its inputs")
                    rig.do(steps, time, H)

                reached.append(end)
                rows += row
                inputs += input_row
                done += 1
        finally:
            rig.time = times[done]
            history.n += done
            for port in rig.ports:
                port.slave.work += done
