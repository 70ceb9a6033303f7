"""Steady thrust and torque of the NREL 5-MW rotor by blade element and momentum theory.

Blade geometry: J. Jonkman et al., NREL/TP-500-38060 (2009), table 3-1, without the three circular
sections next to the hub. One generic section (a straight lift line rounded off at stall, parabolic
drag) stands for the report's six airfoils, so this is a small physical rotor, not AeroDyn; how
near it comes is told in README.md.
"""

import numpy as np

RADIUS, HUB_RADIUS = 63.0, 1.5  # m
BLADES = 3

STATION = np.array(
    [11.75, 15.85, 19.95, 24.05, 28.15, 32.25, 36.35, 40.45, 44.55, 48.65, 52.75, 56.1667, 58.9, 61.6333]
)  # m from the axis
LENGTH = np.array([4.1] * 11 + [2.7333] * 3)  # m
TWIST = np.radians(
    [13.308, 11.480, 10.162, 9.011, 7.795, 6.544, 5.361, 4.188, 3.125, 2.319, 1.526, 0.863, 0.370, 0.106]
)
CHORD = np.array(
    [4.557, 4.652, 4.458, 4.249, 4.007, 3.748, 3.502, 3.256, 3.010, 2.764, 2.518, 2.313, 2.086, 1.419]
)  # m

LIFT_SLOPE = 6.3  # 1/rad
ZERO_LIFT = np.radians(-4.43)  # the outer section's, NACA 64-618
LIFT_MAX = 1.4
DRAG_MIN, DRAG_RISE = 0.0065, 0.006  # Cd = DRAG_MIN + DRAG_RISE Cl^2


def rotor_coefficients(tip_speed_ratio, pitch):
    """Thrust and torque coefficients (Ct, Cq) in a steady, uniform wind V along the shaft.

    tip_speed_ratio: rotor speed * RADIUS / V, positive; pitch: of all blades, rad; arrays of one
    shape. With q = rho V^2 / 2: thrust = Ct q pi RADIUS^2, torque = Cq q pi RADIUS^3. The induced
    velocities by fixed points, with Prandtl's tip and hub losses and, beyond momentum theory's
    reach, the curve of M. Buhl, NREL/TP-500-36834 (2005).
    """
    pitch = np.asarray(pitch)[..., None]
    speed = np.asarray(tip_speed_ratio)[..., None] * STATION / RADIUS  # of the blade, over V
    solidity = BLADES * CHORD / (2 * np.pi * STATION)
    axial, swirl = 0.3 + 0 * (speed + pitch), 0 * (speed + pitch)

    for _ in range(200):
        flow = np.arctan2(1 - axial, speed * (1 + swirl))
        sine, cosine = np.sin(flow), np.cos(flow)

        line = LIFT_SLOPE * (flow - TWIST - pitch - ZERO_LIFT)
        lift = line / (1 + np.abs(line / LIFT_MAX) ** 6) ** (1 / 6)
        drag = DRAG_MIN + DRAG_RISE * lift**2
        normal = solidity * (lift * cosine + drag * sine)
        tangential = solidity * (lift * sine - drag * cosine)

        edges = ((RADIUS - STATION) / STATION, (STATION - HUB_RADIUS) / HUB_RADIUS)
        loss = np.prod(
            [np.arccos(np.exp(-BLADES / 2 * edge / np.abs(sine))) * 2 / np.pi for edge in edges], axis=0
        )

        thrust = normal * (1 - axial) ** 2 / sine**2  # of the ring
        root = np.sqrt(np.maximum(thrust * (50 - 36 * loss) + 12 * loss * (3 * loss - 4), 0))
        heavy = (18 * loss - 20 - 3 * root) / (36 * loss - 50)
        light = normal / (normal + 4 * loss * sine**2)
        axial += 0.3 * (np.where(thrust > 0.96 * loss, heavy, light) - axial)
        swirl += 0.3 * (tangential / (4 * loss * sine * cosine - tangential) - swirl)

    wind2 = (1 - axial) ** 2 + (speed * (1 + swirl)) ** 2
    ring = 2 * STATION * LENGTH * wind2 / RADIUS**2
    return np.sum(ring * normal, -1), np.sum(ring * tangential * STATION / RADIUS, -1)
