"""Thrust and torque of a rotor in steady wind along its axis, by blade elements and momentum
(docs/theory.md 16.18).

At each station one unknown, the angle phi of the flow to the rotor's plane, bracketed and halved, so that
it is always found (Ning 2014): momentum with Prandtl's losses at tip and hub, Buhl's curve where the rotor
blocks the wind, the propeller brake beyond that.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..files import csv_table

SMALL = 1e-6
HALVINGS = 60


@dataclass(frozen=True)
class Polar:
    """alpha : (n,) rad, ascending. lift, drag : (n,)."""

    name: str
    alpha: np.ndarray
    lift: np.ndarray
    drag: np.ndarray

    def at(self, alpha):
        """(C_L, C_D) at angles of attack (rad), which are taken within half a turn; beyond the polar its
        ends.
        """
        turned = np.mod(alpha + np.pi, 2 * np.pi) - np.pi
        return np.interp(turned, self.alpha, self.lift), np.interp(turned, self.alpha, self.drag)


@dataclass(frozen=True)
class Rotor:
    """radius : (n,) m, of the stations, ascending. chord : (n,) m. twist : (n,) rad. polars : of each. tip,
    hub : m. blades.
    """

    radius: np.ndarray
    chord: np.ndarray
    twist: np.ndarray
    polars: list
    tip: float
    hub: float
    blades: int = 3

    def coefficients(self, ratio, pitch):
        """(C_T, C_Q, widest angles of attack (2,) rad) at tip speed ratios (m,) and pitches (k,) in rad:
        (m, k) each.
        """
        ratio, pitch = np.meshgrid(ratio, pitch, indexing="ij")
        thrust = np.zeros((*ratio.shape, len(self.radius) + 2))
        torque, reach = np.zeros_like(thrust), []

        for j in range(len(self.radius)):
            thrust[..., j + 1], torque[..., j + 1], alpha = self._station(j, ratio, pitch)
            reach.append((alpha.min(), alpha.max()))

        # nothing at hub and tip
        along = np.concatenate([[self.hub], self.radius, [self.tip]])
        area = np.pi * self.tip**2
        low, high = np.array(reach).T
        return (
            np.trapezoid(thrust, along, axis=-1) / area,
            np.trapezoid(torque, along, axis=-1) / (area * self.tip),
            (low.min(), high.max()),
        )

    def _station(self, j, ratio, pitch):
        """(thrust, torque by length, 1/2 rho U^2 = 1, angle of attack) of all blades at station j."""
        r = self.radius[j]
        speed = ratio * r / self.tip
        flow = _Flow(self, j, speed, pitch)
        phi = flow.solve()
        a, swirl, normal, tangential = flow.induced(phi)
        cosine, sine = np.cos(phi), np.sin(phi)

        # the larger of its two components tells the speed best
        along, around = 1.0 - a, speed * (1.0 + swirl)
        wind = np.where(np.abs(sine) > np.abs(cosine), along / sine, around / cosine) ** 2
        width = self.blades * self.chord[j] * wind
        return width * normal, width * tangential * r, phi - self.twist[j] - pitch


class _Flow:
    """The flow at a station of a rotor; speed : of the blade by the wind."""

    def __init__(self, rotor, j, speed, pitch):
        self.rotor, self.j, self.speed, self.pitch = rotor, j, speed, pitch
        self.solidity = rotor.blades * rotor.chord[j] / (2 * np.pi * rotor.radius[j])

    def pushes(self, phi):
        """(kappa, kappa', loss, C_n, C_t): what momentum must balance."""
        rotor, r = self.rotor, self.rotor.radius[self.j]
        lift, drag = rotor.polars[self.j].at(phi - rotor.twist[self.j] - self.pitch)
        sine, cosine = np.sin(phi), np.cos(phi)
        normal, tangential = lift * cosine + drag * sine, lift * sine - drag * cosine
        loss = np.ones_like(phi)

        for edge in ((rotor.tip - r) / r, (r - rotor.hub) / rotor.hub):
            loss = (
                loss
                * 2
                / np.pi
                * np.arccos(np.exp(-rotor.blades / 2 * edge / np.maximum(np.abs(sine), SMALL)))
            )

        loss = np.maximum(loss, 1e-4)
        kappa = self.solidity * normal / (4 * loss * sine**2)
        return kappa, self.solidity * tangential / (4 * loss * sine * cosine), loss, normal, tangential

    def induced(self, phi):
        """(a, a', C_n, C_t)."""
        kappa, swirl, loss, normal, tangential = self.pushes(phi)
        return _axial(phi, kappa, loss), swirl / (1 - swirl), normal, tangential

    def residual(self, phi):
        """Of the two ways to the angle, bounded: sin (1 + a') speed - cos (1 - a), by 1 - a, 1 + a'."""
        kappa, swirl, loss, _, _ = self.pushes(phi)
        a = _axial(phi, kappa, loss)
        return np.sin(phi) / (1 - a) - np.cos(phi) / self.speed * (1 - swirl)

    def braking(self, phi):
        """The same where the rotor drives the wind back."""
        kappa, swirl, _, _, _ = self.pushes(phi)
        return np.sin(phi) * (1 - kappa) - np.cos(phi) / self.speed * (1 - swirl)

    def solve(self):
        """phi (rad)."""
        shape = self.speed.shape
        low, high = np.full(shape, SMALL), np.full(shape, np.pi / 2 - SMALL)
        forward = self.residual(low) * self.residual(high) < 0.0
        brake_low, brake_high = np.full(shape, -np.pi / 4), np.full(shape, -SMALL)
        brakes = ~forward & (self.braking(brake_low) * self.braking(brake_high) < 0.0)
        low = np.where(forward, low, np.where(brakes, brake_low, np.pi / 2 + SMALL))
        high = np.where(forward, high, np.where(brakes, brake_high, np.pi - SMALL))

        def residual(phi):
            return np.where(brakes, self.braking(phi), self.residual(phi))

        start = residual(low)

        for _ in range(HALVINGS):
            middle = (low + high) / 2
            same = residual(middle) * start > 0.0
            low, high = np.where(same, middle, low), np.where(same, high, middle)

        return (low + high) / 2


def _axial(phi, kappa, loss):
    """Part of the wind that is lost: momentum, Buhl's curve beyond 0.4 of it, the propeller brake behind
    the plane.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(np.maximum(2 * loss * kappa - loss * (4 / 3 - loss), 0.0))
        below = 2 * loss * kappa - (25 / 9 - 2 * loss)
        heavy = np.where(
            np.abs(below) > 1e-6,
            (2 * loss * kappa - (10 / 9 - loss) - root) / below,
            1 - 1 / (2 * np.maximum(root, 1e-9)),
        )
        light = kappa / (1 + kappa)
        brake = np.where(kappa > 1.0, kappa / (kappa - 1), 0.0)

    return np.where(phi < 0.0, brake, np.where(kappa <= 2 / 3, light, heavy))


def read_polar(path) -> Polar:
    """A polar: CSV with a line of names, then angle of attack (deg), C_L, C_D. Raises ValueError that names
    file and line.
    """
    path = Path(path)
    rows = _rows(path, 3)
    values = np.array([[_number(path, at, word) for word in row] for at, row in rows])

    if len(values) < 2 or not (np.diff(values[:, 0]) > 0.0).all():
        raise ValueError(f"{path}: needs at least 2 angles of attack, ascending")

    return Polar(path.stem, np.radians(values[:, 0]), values[:, 1], values[:, 2])


def read_blade(path, polars, tip=None, hub=None, blades=3) -> Rotor:
    """A blade: CSV with a line of names, then radius (m), chord (m), twist (deg) and the name of a polar.

    polars : {name: Polar}. tip, hub : m; by default what is left at both ends of the stations as half a
    distance of them. Raises ValueError that names file and line.
    """
    path = Path(path)
    rows = _rows(path, 4)
    values = np.array([[_number(path, at, word) for word in row[:3]] for at, row in rows])
    found = []

    for at, row in rows:
        if row[3] not in polars:
            raise ValueError(
                f"{path}: line {at} names the polar {row[3]!r}; given are {', '.join(polars) or 'none'}"
            )
        found.append(polars[row[3]])

    r = values[:, 0]

    if len(r) < 3 or not (np.diff(r) > 0.0).all() or not r[0] > 0.0 or not values[:, 1].min() > 0.0:
        raise ValueError(
            f"{path}: needs at least 3 stations whose radii ascend, above 0, with positive chords"
        )

    tip = r[-1] + (r[-1] - r[-2]) / 2 if tip is None else tip
    hub = max(r[0] - (r[1] - r[0]) / 2, 0.05 * r[0]) if hub is None else hub

    if not 0.0 < hub < r[0] or not tip > r[-1]:
        raise ValueError(
            f"{path}: stations are from {r[0]:g} to {r[-1]:g} m; hub {hub:g} m and tip {tip:g} m must lie "
            "outside"
        )

    return Rotor(r, values[:, 1], np.radians(values[:, 2]), found, float(tip), float(hub), blades)


def _rows(path, width):
    """[(line, words)] of a CSV file with a line of names."""
    try:
        _, lines = csv_table(path)
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror or error}") from None

    rows = []

    for at, cells in lines:
        if len(cells) != width:
            found = ",".join(cells)[:60]
            raise ValueError(f"{path}: line {at} needs {width} columns, found {len(cells)}: {found!r}")
        rows.append((at, [cell.strip() for cell in cells]))

    return rows


def _number(path, at, word):
    try:
        value = float(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise ValueError(f"{path}: line {at}: {word!r} is no number")
    return value
