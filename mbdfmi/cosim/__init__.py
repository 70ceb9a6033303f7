"""Coupled runs of several FMUs, ours and others' (`master`)."""

from .master import CouplingError, couple

__all__ = ["CouplingError", "couple"]
