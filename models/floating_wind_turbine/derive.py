"""Print the derived figures of floating_wind_turbine.toml (those marked D) from the published ones.

python derive.py
"""

from math import cos, pi, radians, sin, sqrt

import numpy as np

GRAVITY, WATER = 9.80665, 1025.0  # m/s2, kg/m3

# a blade as a line of masses: mass, first and second moment about its root, and the tower with its
# centre of mass above the base and its transverse inertia about it: the distributed tables of
# NREL/TP-500-38060 lumped as the reference code ElastoDyn does it
BLADE = 17737.65376574308, 366284.13911136595, 11887081.151894601  # kg, kg m, kg m2
TOWER = 347460.2316, 38.192250566691904, 212882806.37776062  # kg, m, kg m2

TOTAL_MASS, MASS_X, MASS_Z = 6149453.2, -0.023609, 7.005816  # kg, m: all bodies
ROLL_INERTIA = 4.2861e9  # kg m2, mean of roll and pitch, about the origin
HEAVE_STIFFNESS, TILT_STIFFNESS = 16082906.0, 2023430611.0  # N/m, N m/rad: buoyancy
HEAVE_ADDED, TILT_ADDED = 18630380.0, 1.260259e9  # kg, kg m2: infinite frequency
DIAMETER, SIDE, DRAUGHT, VOLUME = 45.1352, 40.0, 4.0, 6000.0  # m, m3
TILT = radians(5)  # of the shaft


def blade():
    """Centre of mass from the root (m) and transverse inertia about it (kg m2)."""
    mass, first, second = BLADE
    return first / mass, second - first**2 / mass


def root(azimuth, radius=1.5, cone=radians(2.5)):
    """Position (3,) and axes y, z (3,) of a blade's root on the hub, turned about x by `azimuth`."""
    y = np.array([0, cos(azimuth), sin(azimuth)])
    z = np.array([-sin(cone), -sin(azimuth) * cos(cone), cos(azimuth) * cos(cone)])
    return radius * z, y, z


def yaw_about_com(about_yaw_axis=2607890.0, mass=240000.0, offset=1.9):
    """The nacelle's yaw inertia about its centre of mass, kg m2 (parallel axes)."""
    return about_yaw_axis - mass * offset**2


def damping():
    """Linear damping of (surge, heave, roll, yaw), N s/m and N m s/rad.

    Heave and roll: twice the damping ratio times the root of stiffness and inertia. The others:
    quadratic drag rho/2 Cd A |u| u replaced by the linear law of the same mean power in a
    Gaussian motion of standard deviation s, which multiplies it by sqrt(8/pi) s.
    """
    gaussian = sqrt(8 / pi)
    heave = 2 * 0.213 * sqrt(HEAVE_STIFFNESS * (TOTAL_MASS + HEAVE_ADDED))
    tilt = TILT_STIFFNESS - TOTAL_MASS * GRAVITY * MASS_Z
    roll = 2 * 0.00645 * sqrt(tilt * (ROLL_INERTIA + TILT_ADDED))
    surge = gaussian * 0.5 * WATER / 2 * DIAMETER * DRAUGHT
    yaw = gaussian * 0.01 * WATER / 2 * DRAUGHT * 2 * (SIDE / 2) ** 4 / 2
    return surge, heave, roll, yaw


def rest(thrust=0.0):
    """Surge (m), heave (m) and pitch (rad) at rest on the moorings.

    thrust: along the shaft, on the hub at (-5, 0, 90) m, N.
    """
    weight, buoyancy = TOTAL_MASS * GRAVITY, WATER * GRAVITY * VOLUME
    heave = (buoyancy - 2057596.3 - weight) / (HEAVE_STIFFNESS + 24923.68)
    stiffness = [[15882.09, 207920], [207920, 26215400 + TILT_STIFFNESS - weight * MASS_Z]]
    force, lift = thrust * cos(TILT), -thrust * sin(TILT)
    surge, pitch = np.linalg.solve(stiffness, [force, 90 * force + 5 * lift + weight * MASS_X])
    return surge, heave, pitch


def main():
    """Print everything."""
    np.set_printoptions(precision=9, suppress=True)
    print("tower: mass, com, transverse inertia   ", *TOWER)
    print("blade: com, transverse inertia         ", *blade())
    for number, azimuth in enumerate(radians(120) * np.arange(3), 1):
        print(f"root {number}: position, y, z               ", *root(azimuth))
    print("nacelle: yaw inertia about com, half   ", yaw_about_com(), yaw_about_com() / 2)
    print("hub: half the inertia about the shaft  ", 115926 / 2)
    print("buoyancy                               ", WATER * GRAVITY * VOLUME)
    print("damping: surge, heave, roll, yaw       ", *damping())
    surge, heave, pitch = rest()
    print("at rest: surge, heave, pitch in degrees", surge, heave, np.degrees(pitch))


if __name__ == "__main__":
    main()
