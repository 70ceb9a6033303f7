"""Rotations as unit Euler parameters, scalar part last, and the other ways to write them.

The part of `scipy.spatial.transform.Rotation` that scenes need, to the same bits (a test compares them):
importing that takes longer than most commands.
"""

import math

import numpy as np

# below it (rad), of the pitch from +-90 deg, yaw and roll are one
SINGULAR = 1e-7


class Rotation:
    """A rotation, or n of them.

    E : Euler parameters (4,) or (n, 4) of unit length.
    """

    def __init__(self, E):
        self._E = E

    @classmethod
    def identity(cls):
        """No rotation."""
        return cls(np.array([0.0, 0.0, 0.0, 1.0]))

    @classmethod
    def from_quat(cls, E):
        """From Euler parameters (4,) or (n, 4) of any length but 0, scalar part last."""
        E = np.asarray(E, float)
        rows = [_unit(row) for row in E.reshape(-1, 4).tolist()]
        return cls(np.array(rows).reshape(E.shape))

    @classmethod
    def from_rotvec(cls, vector):
        """From an axis times the angle about it (3,), rad."""
        x, y, z = (float(value) for value in vector)
        angle = math.sqrt(x * x + y * y + z * z)

        if angle <= 1e-3:
            square = angle * angle
            scale = 0.5 - square / 48 + square * square / 3840
        else:
            scale = math.sin(angle / 2) / angle

        return cls(np.array([scale * x, scale * y, scale * z, math.cos(angle / 2)]))

    @classmethod
    def from_euler(cls, axes, angles, degrees=False):
        """From angles (m,) or (n, m), rad or degrees, each about a turned axis, as in "ZYX"."""
        angles = np.asarray(np.deg2rad(angles) if degrees else angles, float)
        places = ["XYZ".index(axis) for axis in axes]
        rows = [_turned(places, row) for row in angles.reshape(-1, len(axes)).tolist()]
        return cls(np.array(rows).reshape((*angles.shape[:-1], 4)))

    @classmethod
    def from_matrix(cls, A):
        """From orthogonal matrices (3, 3) or (n, 3, 3)."""
        A = np.asarray(A, float)
        ((xx, xy, xz), (yx, yy, yz), (zx, zy, zz)) = np.moveaxis(A.reshape(-1, 3, 3), 0, -1)
        trace = xx + yy + zz
        rows = np.array(
            [
                (1 - trace + 2 * xx, yx + xy, zx + xz, zy - yz),
                (yx + xy, 1 - trace + 2 * yy, zy + yz, xz - zx),
                (zx + xz, zy + yz, 1 - trace + 2 * zz, yx - xy),
                (zy - yz, xz - zx, yx - xy, 1 + trace),
            ]
        )
        largest = np.argmax([xx, yy, zz, trace], axis=0)
        E = rows[largest, :, np.arange(len(largest))]
        x, y, z, w = E.T
        E /= np.sqrt(x * x + y * y + z * z + w * w)[:, None]
        return cls(E.reshape((*A.shape[:-2], 4)))

    def inv(self):
        """The rotation back."""
        return Rotation(self._E * np.array([-1.0, -1.0, -1.0, 1.0]))

    def as_quat(self):
        """Euler parameters (4,) or (n, 4), a copy."""
        return self._E.copy()

    def as_matrix(self):
        """A (3, 3), of one rotation: components in the turned frame to components in the base."""
        x, y, z, w = self._E.tolist()
        x2, y2, z2, w2 = x * x, y * y, z * z, w * w
        xy, zw, xz, yw, yz, xw = x * y, z * w, x * z, y * w, y * z, x * w
        return np.array(
            [
                [x2 - y2 - z2 + w2, 2 * (xy - zw), 2 * (xz + yw)],
                [2 * (xy + zw), -x2 + y2 - z2 + w2, 2 * (yz - xw)],
                [2 * (xz - yw), 2 * (yz + xw), -x2 - y2 + z2 + w2],
            ]
        )

    def apply(self, vector):
        """The components in the base of a vector (3,) with these components in the turned frame."""
        x, y, z = (float(value) for value in vector)
        return np.array([row[0] * x + row[1] * y + row[2] * z for row in self.as_matrix().tolist()])

    def as_zyx(self):
        """Yaw, pitch, roll (3,), rad, of one rotation; at a pitch of +-90 deg the roll is 0.

        After Bernardes and Viollet (2022), Quaternion to Euler angles conversion.
        """
        x, y, z, w = self._E.tolist()
        a, b, c, d = w - y, x + z, y + w, z - x
        half_sum, half_difference = math.atan2(b, a), math.atan2(d, c)
        pitch = 2 * math.atan2(float(np.hypot(c, d)), float(np.hypot(a, b)))

        if abs(pitch) <= SINGULAR:
            yaw, roll = 2 * half_sum, 0.0
        elif abs(pitch - math.pi) <= SINGULAR:
            yaw, roll = 2 * half_difference, 0.0
        else:
            yaw, roll = half_sum + half_difference, half_sum - half_difference

        return np.array([_within_half_turn(angle) for angle in (yaw, pitch - math.pi / 2, roll)])


def _unit(E):
    """Euler parameters made of unit length."""
    length = math.sqrt(E[0] * E[0] + E[1] * E[1] + E[2] * E[2] + E[3] * E[3])
    return [value / length for value in E]


def _turned(places, angles):
    """Euler parameters of turns about axes (0: x), one after the other, each about the turned axis."""
    product = None

    for place, angle in zip(places, angles):
        turn = [0.0, 0.0, 0.0, math.cos(angle / 2)]
        turn[place] = math.sin(angle / 2)
        product = turn if product is None else _product(product, turn)

    return product


def _product(p, q):
    """Euler parameters of rotation p, and q in the frame that it turned."""
    return [
        p[3] * q[0] + q[3] * p[0] + (p[1] * q[2] - p[2] * q[1]),
        p[3] * q[1] + q[3] * p[1] + (p[2] * q[0] - p[0] * q[2]),
        p[3] * q[2] + q[3] * p[2] + (p[0] * q[1] - p[1] * q[0]),
        p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2],
    ]


def _within_half_turn(angle):
    """An angle (rad) less whole turns, from -pi to pi."""
    if angle < -math.pi:
        return angle + 2 * math.pi

    return angle - 2 * math.pi if angle > math.pi else angle
