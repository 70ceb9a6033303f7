"""Reactions of joints, once their constraints are known."""


def add_reactions(builder):
    """What the kernels need of the joints whose reactions outputs have asked for, in that order."""
    for name in builder.reactions:
        first, second = builder.scene.joint[name].between
        nodes = builder.joint_nodes.get(name)
        builder.tables["n_reaction"].add(
            reaction_from=builder.marker(first),
            reaction_to=builder.marker(second),
            reaction_body=max(nodes) if nodes else -1,
            reaction_constraint=-1 if nodes else builder.joint_constraints[name],
            reaction_input=builder.torque_inputs.get(name, -1),
        )
