"""Mutants that no test can or need tell, each with the reason: (file, line before, line after, why)."""

EQUIVALENT = [
    (
        "kernels/dynamics/redundancy.py", "d.change[v] = d.v[v]", "d.change[v] = d.q[v]",
        "any way to a position nearby will do to see which rows stay redundant: "
        "it is projected onto the constraints there",
    ),
    (
        "kernels/motion/coordinates.py", "return al.dot(al.cross(w_a, z), w_b)",
        "return al.dot(al.cross(z, w_a), w_b)",
        "rows know the angles of hinges alone, whose axis is fixed in both bodies: w_b is w_a and a turn about z, "
        "and the product is 0",
    ),
    (
        "kernels/motion/commands.py", "kind = m.drive_turn[2 * k]", "kind = m.drive_turn[k]",
        "the ground's drive, the only one with an orientation, is the first of all: k is 0",
    ),
    (
        "kernels/motion/kinematics.py", "al.set_vec3(d.w, 0, al.ZERO3)", "pass",
        "work buffers begin as zeros, and nothing else writes to the node of the inertial frame",
    ),
]  # fmt: skip


def argument(mutant):
    """Why a mutant changes nothing that could be told, or None."""
    for file, before, after, why in EQUIVALENT:
        if (file, before, after) == (mutant.file, mutant.before, mutant.after):
            return why

    return None
