"""From a model to an FMU: compiled kernels (`aot`), the shared library (`link`), what the library
reads (`resource`), what a tool reads (`description`, `documentation`), and the archive (`package`)."""

from .package import export_fmu

__all__ = ["export_fmu"]
