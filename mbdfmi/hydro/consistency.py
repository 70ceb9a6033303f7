"""Whether what a file says of waves made and of waves felt goes together: it is one potential."""

from dataclasses import replace

import numpy as np

from .database import Coefficients, around, motion
from .spectra import wave_number

# of the peak of damping: how far loads of waves may say otherwise
HASKIND = 0.1

# rad, between headings at most; of their mean square, damping that counts
WIDEST = np.radians(46)
COUNTS = 0.01

# of the peak: what every second or third heading may make of it, where all of them are enough for short waves
RESOLVED = 0.02

# of its size: how much of a load is a quarter of a period late
LATE = 0.7

# of its range: how far what jumps is off its neighbours; so many times as far as the median is
JUMP = 0.2
MANY = 20.0

# rad/s by which a frequency of loads may be beyond those of damping
BESIDE = 1e-9


def disagreements(
    data: Coefficients, density: float, gravity: float, depth: float | None, places=()
) -> list[str]:
    """Notes of loads of waves that do not go with the damping, or that come too late.

    places : (x, y) m of each body in the file's axes where it holds several, whose phases are about its
        origin; without them several are not asked whether they come late, and one is at the origin.
    """
    if (
        data.excitation is None
        or data.headings is None
        or data.wave_omega is None
        or not data.excitation.any()
    ):
        return []
    return _haskind(data, density, gravity, depth) + _late(data, gravity, depth, places)


def spikes(data: Coefficients) -> list[tuple[int, int]]:
    """[(frequency, motion)], indices, at which both added mass and damping jump off the cubic through their
    neighbours, as at irregular frequencies of meshes without a lid; of motions whose damping counts.
    """
    found = set()

    for i in _that_count(data):
        for reach in (1, 2):
            jumps = (_jumps(data.omega, x[:, i, i], reach) for x in (data.added, data.damping))
            found |= {(k, i) for k in set.intersection(*jumps)}

    return sorted(found)


def _that_count(data):
    """Motions whose damping counts beside what added mass makes."""
    made = np.abs(data.omega[:, None] * data.added.diagonal(axis1=1, axis2=2)).max(axis=0)
    return np.flatnonzero(data.damping.diagonal(axis1=1, axis2=2).max(axis=0) > COUNTS * made).tolist()


def _jumps(omega, values, reach):
    """Indices of values (n,) that are off by JUMP of their range, and more than most are. reach : 1,
    neighbours are the next ones, 2, those beyond, for spikes that are wider: off by twice that.
    """
    size = np.ptp(values)
    away = np.array([-reach - 1, -reach, reach, reach + 1])
    middle = np.arange(reach + 1, len(omega) - reach - 1)

    if size == 0.0 or not len(middle):
        return set()

    off = np.empty(len(middle))

    for n, k in enumerate(middle):
        near = k + away
        off[n] = abs(values[k] - np.polyval(np.polyfit(omega[near] - omega[k], values[near], 3), 0.0)) / size

    return {int(k) for k in middle[off > max(reach * JUMP, MANY * np.median(off))]}


def without_spikes(data: Coefficients) -> tuple[Coefficients, list[str]]:
    """The same without frequencies at which anything jumps, the highest first, and notes of these."""
    notes, left = [], len(data.omega) // 4

    while (found := spikes(data)) and left > 0:
        k = max(found, key=lambda at: _height(data, *at))[0]
        notes.append(f"cut out at {data.omega[k]:.4g} rad/s: {_named(data, found, k)}")
        keep = np.abs(data.omega - data.omega[k]) > BESIDE
        waves = {}

        if data.wave_omega is not None and data.excitation is not None:
            felt = np.abs(data.wave_omega - data.omega[k]) > BESIDE
            waves = {"wave_omega": data.wave_omega[felt], "excitation": data.excitation[felt]}

        data = replace(
            data, omega=data.omega[keep], added=data.added[keep], damping=data.damping[keep], **waves
        )
        left -= 1

    return data, notes


def told_spikes(data: Coefficients) -> list[str]:
    """Notes of frequencies at which added mass and damping jump."""
    found, told = spikes(data), []

    for k in sorted({k for k, _ in found}):
        one = sum(j == k for j, _ in found) == 1
        told.append(
            f"{_named(data, found, k)} jump{'s' if one else ''} at {data.omega[k]:.4g} rad/s: an irregular "
            'frequency of a mesh without a lid? spikes = "cut" leaves it out'
        )

    return told


def _named(data, found, k):
    """Words for the motions that jump at frequency k."""
    return ", ".join(motion(i, data.bodies) for j, i in found if j == k)


def _height(data, k, i):
    """How far the damping is off the line between its neighbours, by its range."""
    B = data.damping[:, i, i]
    return abs(B[k] - np.interp(data.omega[k], np.delete(data.omega, k), np.delete(B, k))) / np.ptp(B)


def _haskind(data, density, gravity, depth):
    """B = k / (8 pi rho g c_g) int |X|^2 d heading (Newman, Marine Hydrodynamics, 6.173), where headings go
    all the way round.
    """
    headings, X = around(data.headings, data.excitation)

    whole = np.isclose(headings[-1] - headings[0], 2 * np.pi, atol=1e-6) and len(headings) % 2

    if not whole or np.diff(headings).max() > WIDEST:
        return []

    known = (data.wave_omega >= data.omega[0] - BESIDE) & (data.wave_omega <= data.omega[-1] + BESIDE)
    omega = data.wave_omega[known]

    if len(omega) < 2:
        return []

    k = wave_number(omega, depth, gravity)
    kd = np.minimum(k * depth, 300.0) if depth else np.full(len(k), 300.0)
    group = omega / (2 * k) * (1 + 2 * kd / np.sinh(2 * kd))
    every = [n for n in (1, 2, 3) if (len(headings) - 1) % n == 0]
    by_loads, *by_less = (
        (k / (8 * np.pi * density * gravity * group))[:, None]
        * np.trapezoid(np.abs(X[known, ::n]) ** 2, headings[::n], axis=1)
        for n in every
    )
    found = []

    for i in _that_count(data):
        B = data.damping[:, i, i]
        peak = B.max()

        off = np.abs(by_loads[:, i] - np.interp(omega, data.omega, B)) / peak
        few = [np.abs(by_loads[:, i] - less[:, i]) > RESOLVED * peak for less in by_less]
        off[np.logical_or.accumulate(np.any(few, axis=0))] = 0.0
        worst = int(off.argmax())

        if off[worst] > HASKIND:
            water = f"in {depth:g} m of water" if depth else "in deep water"
            found.append(
                f"the damping in {motion(i, data.bodies)} and the loads of waves disagree by "
                f"{100 * off[worst]:.3g} % of its peak at {omega[worst]:.4g} rad/s (Haskind's relation, "
                f"{water}): other units or another depth, or spikes"
            )

    return found


def _late(data, gravity, depth, places):
    """Long waves along x push ahead where the surface still rises: a quarter of a period before the crest,
    which comes to a body where it is.
    """
    ahead = np.argmin(np.abs(np.angle(np.exp(1j * data.headings))))

    if abs(np.angle(np.exp(1j * data.headings[ahead]))) > WIDEST:
        return []

    heading = data.headings[ahead]
    k = float(wave_number(data.wave_omega[:1], depth, gravity)[0])
    late = []

    if data.bodies == 1 and not places:
        places = [(0.0, 0.0)]

    for j, (x, y) in enumerate(places):
        surge = data.excitation[0, ahead, 6 * j]
        here = surge * np.exp(1j * k * (x * np.cos(heading) + y * np.sin(heading)))

        if surge != 0.0 and here.imag < -LATE * abs(surge):
            late.append(j)

    if not late:
        return []

    return [
        f"the load of long waves in {', '.join(motion(6 * j, data.bodies) for j in late)} comes a quarter of "
        "a period after the crest, not before it: are its phases those of exp(-i omega t)?"
    ]


def long_waves_lift(data: Coefficients, j: int = 0) -> tuple[float, float] | None:
    """(heave load on body j by elevation in the longest waves (N/m), how far that is known): rho g times its
    waterplane. None where a file has no loads at three frequencies.

    It is what a parabola over the square of the frequency comes to at 0, beside what a straight line does.
    """
    if data.excitation is None or data.wave_omega is None or len(data.wave_omega) < 3:
        return None

    heave = data.excitation[:3, :, 6 * j + 2].mean(axis=1).real
    square = data.wave_omega[:3] ** 2
    line, parabola = (float(np.polyfit(square[: n + 1], heave[: n + 1], n)[-1]) for n in (1, 2))
    return parabola, abs(parabola - line)
