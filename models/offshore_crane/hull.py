"""Makes barge.stl, the crane barge's hull of 110 x 45 x 12 m with its draught of 7.5 m, one panel a cell: `python hull.py`, then

mbdfmi hydro barge.stl -o barge.1 --omega 0.2:1.6:15 --heading 0:330:30 --lid
"""

from pathlib import Path

import trimesh

LENGTH, BREADTH, DEPTH, DRAUGHT = 110.0, 45.0, 12.0, 7.5  # m


def main():
    """A box; the command cuts it at the water and makes it finer."""
    hull = trimesh.creation.box([LENGTH, BREADTH, DEPTH])
    hull.apply_translation([0, 0, DEPTH / 2 - DRAUGHT])
    hull.export(Path(__file__).parent / "barge.stl")


if __name__ == "__main__":
    main()
