"""Seas that are none on earth: waves that would break, water that is shallower than what floats in it."""

import numpy as np

from ..hydro.spectra import wave_number
from ..vectors import dot
from .seas import sea_components
from .start import start_pose

# Miche: the steepest wave, height by length, in deep water
STEEPEST = 0.142

# DNV-RP-C205, 3.5.4: 2 pi hs / (g tp^2) of the steepest seas, at periods of the peak (s), straight between
STEEP_SEAS = (8.0, 15.0), (1 / 15, 1 / 25)


def tell_steep_waves(builder):
    """A notice by Miche's limit for the regular wave of the same energy at the mean frequency, by DNV's for spectra."""
    sea, gravity = builder.scene.sea, -builder.scene.gravity[2]

    if not (sea and sea.waves and gravity > 0.0):
        return

    waves = sea_components(builder.scene)
    energy = waves.amplitude**2 / 2

    if not energy.sum() > 0.0:
        return

    mean = energy @ waves.omega / energy.sum()
    k = float(wave_number(np.array([mean]), sea.depth, gravity)[0])
    height, length = np.sqrt(8 * energy.sum()), 2 * np.pi / k
    highest = STEEPEST * length * (np.tanh(k * sea.depth) if sea.depth else 1.0)
    kind = next(kind for kind in type(sea.waves).needed[0] if getattr(sea.waves, kind))
    path = ("sea", "waves", kind)
    water = f" in {sea.depth:g} m of water" if sea.depth else ""

    if height > highest:
        what = "" if kind == "regular" else "by their energy and mean period "
        text = (
            f"{what}waves of {height:.4g} m are {length:.4g} m long{water}, where they break above {highest:.4g} m (Miche): no sea has "
            "them, and linear theory does not hold"
        )
        builder.notice(path, text)
        return

    spec = sea.waves.jonswap or sea.waves.pierson_moskowitz

    if spec:
        steepness = 2 * np.pi * spec.hs / (gravity * spec.tp**2)
        most = np.interp(spec.tp, *STEEP_SEAS)

        if steepness > most:
            text = (
                f"hs = {spec.hs:g} m at tp = {spec.tp:g} s is steeper than seas get: 2 pi hs / (g tp^2) is {steepness:.3g}, at most "
                f"{most:.3g} (DNV-RP-C205), hs = {most * gravity * spec.tp**2 / (2 * np.pi):.3g} m"
            )
            builder.notice(path, text)


def tell_member_aground(builder, name, force):
    """A notice of a member that starts under the bed."""
    depth = builder.scene.sea.depth if builder.scene.sea else None

    if depth:
        lowest = min(float(start_pose(builder, end)[0][2]) for end in force.between)

        if lowest < -depth:
            text = f"starts at z = {lowest:.4g} m, under the sea's bed: [sea] depth is {depth:g} m"
            builder.notice(("force", name, "between"), text)


def tell_wet_blades(builder, name, force):
    """A notice of a rotor whose blades start in the water."""
    place, A = start_pose(builder, force.on)
    # the disk is across the x axis of the hub
    reach = force.rotor.radius * float(np.hypot(A[2, 1], A[2, 2]))

    if builder.scene.sea and place[2] < reach:
        text = (
            f"blades of {force.rotor.radius:g} m, with the hub at z = {place[2]:.4g} m, start {reach - place[2]:.4g} m deep in the water, "
            "which they do not feel"
        )
        builder.notice(("force", name, "on"), text)


def tell_hull_aground(builder, name, end, points):
    """A notice of a hull, points (n, 3) in the axes of its end, that starts under the bed."""
    depth = builder.scene.sea.depth if builder.scene.sea else None

    if depth:
        place, A = start_pose(builder, end)
        draught = -float((place[2] + dot(points, A.T)[:, 2]).min())

        if draught > depth:
            text = (
                f"reaches {draught:.4g} m down where it starts; the water is {depth:g} m deep ([sea] depth)"
            )
            builder.notice(("force", name, "hydrostatics"), text)
