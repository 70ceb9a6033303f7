"""From a model to an FMU.

Compiled kernels (`aot`), what the C wrapper knows of them (`header`), the shared library (`link`), what
the library reads (`resource`), what a tool reads (`description`, `documentation`), and the archive of
them all (`package`).
"""

from .package import export_fmu

__all__ = ["export_fmu"]
