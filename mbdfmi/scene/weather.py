"""Seas, winds and rotors that are none on earth: numbers in other units, or a digit too many. Rules of `notices.py`."""

from math import pi

import numpy as np

from ..vectors import norm
from .errors import Problem

# m/s: over a minute (Patricia, 2015), of a gust (Barrow Island, 1996), of a tidal stream (Saltstraumen), of sound in air
STRONGEST_WIND, STRONGEST_GUST, FASTEST_STREAM, SOUND = 96.0, 113.0, 12.0, 340.0

# of a current's speed over the ground, what goes up or down
STEEPEST_STREAM = 0.1

# m: significant height measured (North Atlantic, 2013), a single wave by far, the deepest sea
HIGHEST_SEA, HIGHEST_WAVE, DEEPEST = 19.0, 35.0, 11_000.0

# s, of waves that wind makes; m, up to which power laws of wind are told
LONGEST_PERIOD, HIGHEST_PROFILE = 30.0, 1000.0

# exponents of power laws of wind, over towns 0.4; peaks of spectra, 1 to 7; coefficients of members, of round ones about 1
STEEPEST_PROFILE, SHARPEST_PEAK, LARGEST_COEFFICIENT = 1.0, 10.0, 5.0

# kg/m3
WATERS, AIRS = (500.0, 2000.0), (0.1, 5.0)

# of the amplitude of an operating gust, what it adds at its peak: 0.37 times 2
PEAK = 0.74

# rad, from where blades turn their backs
BACKWARDS = 0.6 * pi


def odd_sea(scene):
    """Water, waves and currents beyond what was ever measured."""
    sea = scene.sea

    if not sea:
        return

    yield from _within(("sea", "density"), sea.density, WATERS, "kg/m3", "water has some 1000")

    if sea.depth and sea.depth > DEEPEST:
        yield _odd(("sea", "depth"), sea.depth, "m", f"the deepest sea has {DEEPEST:g}")

    if sea.current:
        speed = norm(np.array(sea.current.velocity))
        if speed > FASTEST_STREAM:
            text = f"the fastest tidal streams have some {FASTEST_STREAM:g}"
            yield _odd(("sea", "current", "velocity"), speed, "m/s", text)

        east, north, up = sea.current.velocity
        if abs(up) > STEEPEST_STREAM * np.hypot(east, north):
            text = f"goes up or down by {abs(up):g} m/s: currents are nearly level; x and y are, z is up"
            yield Problem(("sea", "current", "velocity"), text)

    if sea.waves:
        yield from _odd_waves(sea.waves)


def _odd_waves(waves):
    """Of their heights and periods."""
    for kind in ("regular", "jonswap", "pierson_moskowitz"):
        spec = getattr(waves, kind)

        if not spec:
            continue

        path = ("sea", "waves", kind)
        height, period = ("height", "period") if kind == "regular" else ("hs", "tp")
        most = HIGHEST_WAVE if kind == "regular" else HIGHEST_SEA

        if getattr(spec, height) > most:
            text = f"the highest that was measured is {'some 30' if kind == 'regular' else f'{most:g}'}"
            yield _odd((*path, height), getattr(spec, height), "m", text)
        if getattr(spec, period) > LONGEST_PERIOD:
            text = f"waves that wind makes have {LONGEST_PERIOD:g} at most"
            yield _odd((*path, period), getattr(spec, period), "s", text)
        if getattr(spec, "gamma", 0.0) > SHARPEST_PEAK:
            yield _odd((*path, "gamma"), spec.gamma, None, "of seas it is from 1 to 7")


def odd_wind(scene):
    """Winds, with their gusts, beyond what was ever measured; densities of no air."""
    wind = scene.wind

    if not wind:
        return

    steady = wind.steady
    speed = norm(np.array(steady.velocity))
    yield from _within(("wind", "density"), wind.density, AIRS, "kg/m3", "air has some 1.2")

    if speed > STRONGEST_WIND:
        text = f"the strongest wind that was measured over a minute is {STRONGEST_WIND:g}"
        yield _odd(("wind", "steady", "velocity"), speed, "m/s", text)
    if steady.exponent > STEEPEST_PROFILE:
        yield _odd(
            ("wind", "steady", "exponent"), steady.exponent, None, "it is from 0.1 at sea to 0.4 over towns"
        )
    if steady.exponent and steady.reference_height > HIGHEST_PROFILE:
        text = "power laws of wind are for some hundreds"
        yield _odd(("wind", "steady", "reference_height"), steady.reference_height, "m", text)
    if wind.gust:
        kind, peak = _peak(wind.gust, np.array(steady.velocity), steady.reference_height)
        if peak > max(STRONGEST_GUST, speed):
            text = f"with it the wind comes to {peak:.4g} m/s; the strongest gust that was measured is {STRONGEST_GUST:g}"
            yield Problem(("wind", "gust", kind), text)


def _peak(gust, steady, height):
    """(its kind, the largest speed of the wind with it, m/s)."""
    if gust.eog:
        speed = norm(steady)
        return "eog", speed + PEAK * gust.eog.size(speed, height)
    if gust.step:
        return "step", norm(steady + np.array(gust.step.velocity))
    return "table", float(np.linalg.norm(steady + np.array(gust.table.velocity), axis=1).max())


def odd_rotors(scene):
    """Rotors whose tips start faster than sound, as one in rpm where rad/s are meant; pitch in degrees."""
    for name, force in scene.force.items():
        if force.kind != "rotor":
            continue

        spec, body = force.rotor, force.on.partition(".")[0]

        if not force.input and abs(spec.pitch) > BACKWARDS:
            text = f"{spec.pitch:g} rad are {np.degrees(spec.pitch):.4g} deg: blades turn by 90 at most"
            yield Problem(("force", name, "rotor", "pitch"), text)

        for at, joint in scene.joint.items():
            turns = _turns(joint) if body in [end.partition(".")[0] for end in joint.between] else 0.0

            if turns * spec.radius > SOUND:
                text = (
                    f"{name}, of {spec.radius:g} m radius, starts at {turns:.4g} rad/s ({turns * 30 / pi:.4g} rpm), its tips at "
                    f"{turns * spec.radius:.4g} m/s, faster than sound"
                )
                yield Problem(("joint", at), text)


def _turns(joint):
    """rad/s, at which a revolute joint starts."""
    if joint.kind != "revolute":
        return 0.0

    driven = joint.driver and joint.driver.kind == "constant_speed"
    return abs(float(joint.driver.speed() if driven else joint.start.v()[0]))


def odd_members(scene):
    """Coefficients of drag and inertia that no round member has."""
    for name, force in scene.force.items():
        if force.kind == "member":
            for key in ("drag", "axial_drag", "added_mass", "axial_added_mass"):
                value = getattr(force.member, key)
                if value is not None and value > LARGEST_COEFFICIENT:
                    yield _odd(("force", name, "member", key), value, None, "of round members it is about 1")


def _within(path, value, bounds, unit, text):
    """A notice of what is outside."""
    if not bounds[0] <= value <= bounds[1]:
        yield _odd(path, value, unit, text)


def _odd(path, value, unit, text):
    """A notice of a number."""
    return Problem(path, f"is {value:.4g}{f' {unit}' if unit else ''}: {text}")


RULES = (odd_sea, odd_wind, odd_rotors, odd_members)
