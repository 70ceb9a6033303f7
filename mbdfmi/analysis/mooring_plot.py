"""The picture of mooring lines: footprint, sides, tension and force as what they hold is moved aside."""

from pathlib import Path

import numpy as np

from ..files import save_figure
from .moorings import Moorings

# lines that a legend names
NAMED = 12


def draw_moorings(path, found: Moorings, title="", direction=0.0) -> Path:
    """Plan and side view of the lines where they hang, tension and restoring force over the offset.

    path : png, svg or pdf. direction : rad, of the offset.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 8), layout="constrained")
    figure.suptitle(title, fontsize="medium")
    (plan, side), (tension, force) = figure.subplots(2, 2)

    for k, line in enumerate(found.lines):
        colour = f"C{k % 10}"
        first = int(np.argmin(np.append(line.lying, False)))
        plan.plot(*line.shape[first:, :2].T, color=colour, linewidth=1.2)
        side.plot(*_from_the_side(line, line.shape), color=colour, linewidth=1.2)

        for j in np.flatnonzero(line.lying):
            plan.plot(*line.shape[j : j + 2, :2].T, color=colour, linewidth=3, alpha=0.35)

        if len(line.joints):
            plan.plot(*line.joints[:, :2].T, ".", color=colour, markersize=4)
            side.plot(*_from_the_side(line, line.joints), ".", color=colour, markersize=6)

        plan.plot(*line.lower[:2], "v", color=colour, markersize=6)
        plan.plot(*line.upper[:2], "o", color=colour, markersize=3)
        plan.annotate(
            line.name, line.lower[:2], fontsize="x-small", xytext=(3, 3), textcoords="offset points"
        )
        tension.plot(found.offsets, found.tension[:, k] / 1e3, color=colour, linewidth=1.2, label=line.name)

    plan.set_aspect("equal", adjustable="datalim")
    plan.set_title(
        "from above, m; triangles: lower ends; dots: joins; wide: on the bed",
        loc="left",
        fontsize="medium",
    )
    side.set_title("from the side, m from the lower end", loc="left", fontsize="medium")
    tension.set_title("tension at the upper ends, kN", loc="left", fontsize="medium")
    force.plot(found.offsets, found.force / 1e3, "k", linewidth=1.2)
    force.set_title("force of all lines against the offset, kN", loc="left", fontsize="medium")

    if len(found.lines) <= NAMED:
        tension.legend(fontsize="x-small", ncols=2)

    for axes in (tension, force):
        axes.set_xlabel(f"offset towards {np.degrees(direction):g} deg, m")
        axes.axvline(0.0, color="k", linewidth=0.6, linestyle=":")

    for axes in (plan, side, tension, force):
        axes.grid(alpha=0.3)

    save_figure(figure, path)
    return Path(path)


def _from_the_side(line, points):
    """(m from the line's lower end, height) of points (n, 3)."""
    return np.hypot(*(points - line.lower)[:, :2].T), points[:, 2]
