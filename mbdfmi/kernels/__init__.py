"""What runs at simulation time: small functions in the subset of Python that numba compiles.

Every function here serves an in-process run (numba's JIT) and the FMU (compiled ahead of time) alike;
see `language` for the rules they keep. This room knows no scenes and no files.
"""
