"""Benchmarks: speed against error of this package, beside that of other libraries: `python -m benchmarks`."""
