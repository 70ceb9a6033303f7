"""Dynamics: inertias, forward and inverse dynamics, constraint rows, projection, the start."""
