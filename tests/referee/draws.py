"""Which ways a scene is run: a reference, its kicked runs,
and a few others with what they are compared to."""

from dataclasses import dataclass, replace

import numpy as np

from mbdfmi.kernels.language import INTERPRETED

from .plan import dice
from .ways import ADAPTIVE, FIXED, TIGHT, Way

PATTERNS = (("shared",), ("equal", 3), ("unequal", 3), ("tiny", 2))
KICKS = (1, 2)
SECONDS_INTERPRETED = 4.0
INTERPRETED_EVALUATIONS = 2000  # in a communication step, of one body


@dataclass(frozen=True)
class Ways:
    """near : compared with the reference within their tolerance. bits :
    (way, which of `near` it equals to the bit).
    rounding : (way, which of `near` it equals but for rounding). halved : which of `near`,
    of a fixed step -> with half and a quarter of it.
    """

    reference: Way
    kicked: list[Way]
    integrals: Way | None
    near: list[Way]
    bits: list[tuple[Way, int]]
    rounding: list[tuple[Way, int]]
    halved: dict[int, list[Way]]


def draw(seed, plan, n=3, fmu=True, interpreted=True, bodies=1):
    """The ways of a scene of so many bodies. n : of those that are compared within tolerances. fmu,
    interpreted : whether some are run so."""
    rng = dice(seed, "ways")
    pattern = PATTERNS[rng.integers(len(PATTERNS))]
    formulations = list(rng.permutation(["embedding", "augmented", "recursive"]))
    near = [_way(rng, str(formulations[k % 3]), plan, pattern) for k in range(n)]
    bits, rounding = [], []

    if not INTERPRETED and fmu:
        which = int(rng.integers(n))
        memories = [None, str(rng.choice(["restore", "serialise", "reset", "second"]))]
        bits += [(replace(near[which], host="fmu", memory=memory), which) for memory in memories]

    which = int(rng.integers(n))
    bits.append(
        (replace(near[which], memory=str(rng.choice(["restore", "serialise", "reset", "second"]))), which)
    )

    rarely = dice(seed, "rarely")
    bits.append((replace(near[0], memory=str(rarely.choice(["teased", "untouched"]))), 0))

    if not INTERPRETED and interpreted:
        which = int(rng.integers(n))
        most = INTERPRETED_EVALUATIONS // (bodies * (5 if near[which].formulation == "augmented" else 1))
        way = replace(near[which], interpreted=True, evaluations=max(20, most), seconds=SECONDS_INTERPRETED)
        rounding.append((way, which))

    equal = np.ptp(np.diff(plan.points)) < 1e-9 * plan.until

    if equal and plan.steady and not plan.bound and rng.random() < 0.3:
        near.append(Way(host="simulate", tolerance=1e-7, integrator="auto"))

    patterns = tuple(dict.fromkeys(way.pattern for way in near))
    longest = plan.until / (3 * len(plan.points))
    reference = Way("recursive", "rk853", TIGHT, max_step=longest, pattern=("union", patterns), exact=True)
    integrals = (
        None
        if plan.bound
        else Way("recursive", "rk853", TIGHT, max_step=longest, pattern=("equal", 16), exact=True)
    )
    halved = {
        k: [replace(way, step=part * way.step) for part in (0.5, 0.25)]
        for k, way in enumerate(near)
        if way.step
    }
    return Ways(
        reference, [replace(reference, kick=k) for k in KICKS], integrals, near, bits, rounding, halved
    )


def _way(rng, formulation, plan, pattern):
    pattern = pattern if plan.bound else PATTERNS[rng.integers(len(PATTERNS))]

    if rng.random() < 0.2:
        step = plan.until * 10.0 ** rng.uniform(-3.3, -2.0)
        return Way(formulation, str(rng.choice(FIXED)), step=step, pattern=pattern)

    tolerance = 10.0 ** rng.uniform(-10, -4)
    plain = rng.random() < 0.25
    most = float(plan.until * 10.0 ** rng.uniform(-2.5, -1)) if rng.random() < 0.25 else None
    return Way(formulation, str(rng.choice(ADAPTIVE)), tolerance, max_step=most, pattern=pattern, plain=plain)
