"""Springs and dampers, by a constant or by table."""

from typing import NamedTuple

import numpy as np

from ..kernels.math.tables import LINEAR
from .interpolation import curve


class Spring(NamedTuple):
    """table : index, -1 without. rest : where its energy is zero, None: as at the start."""

    table: int
    stiffness: float
    rest: float | None

    @property
    def is_linear(self) -> bool:
        """Whether it goes by stiffness and rest."""
        return self.table < 0


class Damper(NamedTuple):
    """table : index, -1 without."""

    table: int
    damping: float


def spring_of(builder, graph, stiffness, rest):
    """A spring of an effort over a position or length, or without that of a stiffness."""
    if graph is None:
        return Spring(-1, stiffness, rest)

    table, rest = _elastic_table(builder, graph)
    return Spring(table, 0.0, rest)


def damper_of(builder, given):
    """A damper of a number, or of a table of effort over speed."""
    if isinstance(given, float):
        return Damper(-1, given)

    return Damper(_elastic_table(builder, given.table)[0], 0.0)


def _elastic_table(builder, graph):
    """(index of the table of an effort over a position, length or rate, where a spring's energy is zero).

    Straight beyond the ends. The energy is zero at the first point where the effort is, else at the table's first point.
    """
    x, effort = graph.points()
    effort = curve(graph.interpolation, x, effort)
    slack = [root for root in effort.solve(0.0, extrapolate=False) if np.isfinite(root)]
    return builder.table(effort, LINEAR), float(min(slack, default=x[0]))
