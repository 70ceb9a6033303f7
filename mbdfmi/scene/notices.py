"""What is odd in a scene but may be meant: it runs, and whoever runs it is told.

Each of `RULES` takes a valid scene and yields a `Problem` (where, and what) for each thing it finds odd. They are told by
`mbdfmi check`, `info`, `simulate`, as `scene.notices`, in `Results.notices`, and as warnings in the log of an FMU when its
initialisation ends. Of what the compiler or the kernels do with a scene: `Builder.notice`, `kernels/status.py`.
"""

RULES = ()


def notices(scene):
    """The `Problem`s of what is odd in a valid scene."""
    return [notice for rule in RULES for notice in rule(scene)]
