"""Springs and dampers by table."""

import numpy as np

from ..kernels.math.tables import LINEAR
from .interpolation import curve


def elastic_table(builder, graph):
    """(index of the table of an effort over a position, length or rate, where a spring's energy is zero).

    Straight beyond the ends. The energy is zero at the first point where the effort is, else at the table's first point.
    """
    x, effort = graph.points()
    effort = curve(graph.interpolation, x, effort)
    slack = [root for root in effort.solve(0.0, extrapolate=False) if np.isfinite(root)]
    return builder.table(effort, LINEAR), float(min(slack, default=x[0]))
