"""Parts so light that the multipliers of constraints lose their digits: told."""

import numpy as np

# beside the heaviest part that constraints reach; tried: with 1e-12 of the mass all digits are left, with 1e-13 rows are dropped
LEAST = 1e-12


def tell_light_parts(builder):
    """A notice of the lightest part, by its mass or by its least moment of inertia, where constraints have too light ones."""
    reached = {
        int(node) for column in builder.tables["n_path"].columns.get("path_node", ()) for node in column
    } - {0}
    reached -= {builder.tree.home["ground"][0]}
    nodes = [
        (node.bodies[0], *_matter(builder, node))
        for i, node in enumerate(builder.nodes)
        if i in reached and node.bodies
    ]

    for what, unit, least, most in (("mass", "kg", 1, 1), ("inertia", "kg m2", 2, 3)):
        heaviest = max(nodes, key=lambda node: node[most], default=None)
        lightest = min(
            (node for node in nodes if node[least] > 0.0), key=lambda node: node[least], default=None
        )

        if lightest and lightest[least] < LEAST * heaviest[most]:
            ratio = lightest[least] / heaviest[most]
            builder.notice(
                ("body", lightest[0], what),
                f"{lightest[least]:.3g} {unit} is {ratio:.1g} of the {heaviest[most]:.3g} {unit} of {heaviest[0]!r}, with which "
                f"constraints connect it: accelerations and reactions may keep no digit; with {LEAST:g} they keep theirs. Make it "
                "heavier, or leave the part out (a distance joint, a coupling)",
            )
            return


def _matter(builder, node):
    """(mass kg, least and largest principal moment of inertia kg m2) of a node's bodies together, about their own centres of mass."""
    mass, least, most = 0.0, 0.0, 0.0

    for body in node.bodies:
        m, _, inertia = builder.scene.body[body].mass_properties()
        moments = np.linalg.eigvalsh(inertia)
        mass, least, most = mass + m, least + moments[0], most + moments[-1]

    return mass, least, most
