"""Makes rotor.csv: thrust and torque coefficients of the NREL 5-MW rotor by blade_element.py."""

from pathlib import Path

import numpy as np
from blade_element import rotor_coefficients

RATIO = np.arange(1.0, 14.25, 0.5)
PITCH = np.radians(np.arange(0.0, 31.0, 2.0))


def main():
    """Writes the table: tip speed ratio, blade pitch, C_T, C_Q."""
    ratio, pitch = np.meshgrid(RATIO, PITCH, indexing="ij")
    columns = [ratio, pitch, *rotor_coefficients(ratio, pitch)]
    rows = np.column_stack([column.ravel() for column in columns])
    np.savetxt(
        Path(__file__).parent / "rotor.csv",
        rows,
        fmt=["%.2f", "%.9f", "%.7f", "%.7f"],
        delimiter=",",
        header="tip_speed_ratio,blade_pitch_rad,C_T,C_Q",
        comments="",
    )


if __name__ == "__main__":
    main()
