"""mbdfmi: a multibody scene in, a native FMI 2.0 co-simulation FMU out.

    import mbdfmi

    scene = mbdfmi.load("crane.toml")
    results = scene.simulate(until=10, inputs={"boom.torque": 2e3})
    scene.export("crane.fmu")

In Python a scene is made of the same parts as in a file: `mbdfmi.Scene(name=..., body={...}, joint={...})`.
"""

from .api import Scene, load
from .scene import SceneError

__all__ = ["Scene", "SceneError", "load"]
__version__ = "0.1.0"
