"""The referee: random scenes over the whole schema, each run every way against every other,
and judged by laws.

A fault that stands in one place alone (a stepper, a formulation, the FMU's wrapper, a turn, a start) shows
where two ways to the same motion part; one that all ways share shows against a second route that reads the
scene by itself, or breaks a law.

    generator, coverage, shrink     scenes over the whole schema, what of it they use, and the smallest scene
    that still fails plan                            what is done to a scene: inputs over time, parameters set
    in mid-run, communication points ways                            how it is run: formulation, stepper,
    tolerance, steps, process or FMU, snapshots, reset compare, laws, starts, commands, dependence    the verdicts
    masters, files                  what masters must not do, and what users do with files
    independent                     the second route, which shares nothing with the product __main__
    python -m tests.referee --seed 1 --scenes 100

Every draw is made from a seed and the names of what it is about, so a scene that loses a part keeps all else.
"""

import sys
from pathlib import Path

# what the tests share goes by plain names
sys.path.insert(0, str(Path(__file__).parents[1]))
