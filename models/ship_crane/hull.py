"""Makes hull.stl, a ship of Wigley's form with sides that go straight up from the water: `python hull.py`, then

mbdfmi hydro hull.stl -o ship.1 --omega 0.3:2:18 --heading 0:330:30 --lid --panel 2.4
"""

from pathlib import Path

import numpy as np
import trimesh

LENGTH, BREADTH, DRAUGHT, FREEBOARD = 80.0, 18.0, 5.0, 4.0  # m
ALONG, DOWN = 24, 5


def half_breadth(x, z):
    """m, at x from amidships and z from the water: B/2 (1 - (2x/L)^2) (1 - (z/T)^2), W. C. S. Wigley (1934)."""
    return BREADTH / 2 * (1 - (2 * x / LENGTH) ** 2) * (1 - (np.minimum(z, 0.0) / DRAUGHT) ** 2)


def main():
    """Rows of points along the hull, from the keel to the deck, on both sides; the deck."""
    x = LENGTH / 2 * -np.cos(np.pi * np.arange(ALONG + 1) / ALONG)
    z = np.concatenate([-DRAUGHT * np.cos(np.pi / 2 * np.arange(DOWN + 1) / DOWN), [FREEBOARD]])
    z[DOWN] = 0.0
    n, rows = len(x), len(z)
    sides = [np.array([(a, side * half_breadth(a, b), b) for b in z for a in x]) for side in (1, -1)]
    cells = [
        (r * n + k, r * n + k + 1, r * n + n + k + 1, r * n + n + k)
        for r in range(rows - 1)
        for k in range(n - 1)
    ]

    # the diagonal that leaves no triangle flat in the keel's plane, at bow and stern
    port = [
        face
        for k, (a, b, c, d) in enumerate(cells)
        for face in (((b, a, c), (c, a, d)) if k % (n - 1) < (n - 1) // 2 else ((b, a, d), (b, d, c)))
    ]
    starboard = [(a + n * rows, c + n * rows, b + n * rows) for a, b, c in port]
    top = (rows - 1) * n
    deck = [
        face
        for k in range(n - 1)
        for face in (
            (top + k, top + n * rows + k, top + n * rows + k + 1),
            (top + k, top + n * rows + k + 1, top + k + 1),
        )
    ]
    hull = trimesh.Trimesh(np.vstack(sides), np.array([*port, *starboard, *deck]))
    hull.merge_vertices()
    hull.update_faces(hull.nondegenerate_faces())
    hull.remove_unreferenced_vertices()
    trimesh.repair.fix_normals(hull)
    print(len(hull.faces), "triangles, closed:", hull.is_watertight, "volume", hull.volume)
    hull.export(Path(__file__).parent / "hull.stl")


if __name__ == "__main__":
    main()
