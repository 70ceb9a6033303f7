"""What runs at simulation time: small functions in the subset of Python that numba compiles.

Every function here serves in-process runs and FMUs alike; see `language` for the rules they keep, and for the ways to run
them. This room knows no scenes and no files.
"""

from . import language

if language.JIT:
    from . import compiled_views as compiled_views
