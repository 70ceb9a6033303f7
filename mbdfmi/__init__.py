"""mbdfmi: a multibody scene in, a native FMI 2.0 co-simulation FMU out.

    import mbdfmi

    scene = mbdfmi.load("crane.toml")
    results = scene.simulate(until=10, inputs={"boom.torque": 2e3})
    scene.export("crane.fmu")

In Python a scene is made of the same parts as in a file: `mbdfmi.Scene(name=..., body={...}, joint={...})`.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .api import Scene, load
    from .scene import SceneError

__all__ = ["Scene", "SceneError", "load"]
__version__ = "0.1.0"


def __getattr__(name):
    """What is exported is imported when it is asked for: the command's help needs none of it."""
    if name in __all__:
        from . import api

        return getattr(api, name)

    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__():
    return [*globals(), *__all__]
