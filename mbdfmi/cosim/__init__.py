"""Coupled runs of several FMUs, ours and others', and of scenes: docs/coupling.md."""

from .errors import CouplingError
from .system import Coupled, System, couple, load_system

__all__ = ["Coupled", "CouplingError", "System", "couple", "load_system"]
