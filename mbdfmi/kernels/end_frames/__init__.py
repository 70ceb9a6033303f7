"""End frames: on curves and surfaces."""
