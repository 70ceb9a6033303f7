"""Mooring lines in a GLB: tubes along the mean of their points, moved by few modes (morph targets)."""

import numpy as np

from ..scene.looks import red_green_blue
from ..threads import one_thread
from . import forms, glb
from .lines import BUOY, LEAST_BALL, LINE, THIN, WEIGHT, principal

AROUND = 6


@one_thread()
def line_nodes(picture) -> list[glb.Node]:
    """Nodes of the lines of a picture, with their weights and buoys."""
    found, radius = [], THIN * picture.reach[1]

    for line in picture.lines:
        points = line.points(np.arange(len(line.x)))
        flat = points.reshape(len(points), -1)
        mean, modes, shares = principal(flat, line.off)
        tube = forms.polyline(mean.reshape(-1, 3), radius, AROUND)
        node = glb.Node(line.name, surfaces=[(tube, red_green_blue(LINE), 1.0)], extras={"kind": "line"})
        found.append(node)

        if len(modes):
            node.targets = [np.repeat(mode.reshape(-1, 3), AROUND + 1, axis=0) for mode in modes]
            node.moves["weights"] = shares

        for k, (at, size, floats) in enumerate(line.balls, 1):
            colour = red_green_blue(BUOY if floats else WEIGHT)
            ball = glb.Node(
                f"{line.name} {k}", surfaces=[(forms.sphere(), colour, 1.0)], extras={"kind": "line"}
            )
            ball.r, ball.scale = points[0, at], np.full(3, max(size, LEAST_BALL * radius))

            if len(modes):
                ball.moves["translation"] = points[:, at]

            found.append(ball)

    return found
