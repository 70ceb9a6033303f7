"""Springs and dampers by table."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from ..kernels.tables import LINEAR


def elastic_table(builder, graph):
    """(index of the table of an effort over a position, length or rate, where a spring's energy is zero).

    Cubic and monotone from point to point (PCHIP; Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984), straight beyond the ends. The energy is zero at
    the first point where the effort is, else at the table's first point.
    """
    x, effort = graph.points()
    curve = PchipInterpolator(x, effort)
    slack = [root for root in curve.solve(0.0, extrapolate=False) if np.isfinite(root)]
    return builder.table(curve, LINEAR), float(min(slack, default=x[0]))
