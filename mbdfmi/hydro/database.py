"""What potential theory says of a floating body: coefficients over frequency, checked."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..vectors import spline_slopes

DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")

# of A: parts by which it may be unsymmetric; of its peak: how far below 0 an eigenvalue of B may be
UNSYMMETRIC = 0.02
NEGATIVE = 0.01

# of its peak: damping at the last frequency that is told; of what added mass makes there: damping that counts
ENDS = 0.9
COUNTS = 0.01


def motion(k, bodies=1) -> str:
    """Words for a motion of one of several bodies, from 0."""
    return DOFS[k % 6] + (f" of body {k // 6 + 1}" if bodies > 1 else "")


@dataclass(frozen=True)
class Coefficients:
    """Of N bodies, six motions each, in ground axes, about their reference points; z up, time as
    exp(+i omega t).

    omega : (n,) rad/s, ascending, above 0. added : (n, 6 N, 6 N) in kg, kg m, kg m2.
    damping : (n, 6 N, 6 N) in N s/m, N s, N m s.
    infinite : (6 N, 6 N) added mass at infinite frequency, or None.
    wave_omega : (k,). headings : (h,) rad, the way that waves travel, ascending.
    excitation : (k, h, 6 N) complex, N/m and N, for an elevation Re(exp(i omega t)) at the origin of the
        file, which is the reference point of one body. These three may be None.
    """

    omega: np.ndarray
    added: np.ndarray
    damping: np.ndarray
    infinite: np.ndarray | None = None
    wave_omega: np.ndarray | None = None
    headings: np.ndarray | None = None
    excitation: np.ndarray | None = None

    @property
    def bodies(self) -> int:
        """How many they are."""
        return self.added.shape[1] // 6

    def of(self, numbers) -> "Coefficients":
        """Of some of the bodies, by their numbers from 1, in that order: the others are held still."""
        k = np.concatenate([6 * (n - 1) + np.arange(6) for n in numbers])
        infinite = None if self.infinite is None else self.infinite[np.ix_(k, k)]
        excitation = None if self.excitation is None else self.excitation[:, :, k]
        added, damping = self.added[:, k[:, None], k], self.damping[:, k[:, None], k]
        return replace(self, added=added, damping=damping, infinite=infinite, excitation=excitation)

    def enlarged(self, times: float) -> "Coefficients":
        """Of bodies so many times as large, in the same water, by Froude's law: times grow with its root."""
        turns = np.arange(self.added.shape[1]) % 6 > 2
        size = times ** (3.0 + turns[:, None] + turns)
        slower = times**-0.5

        def scaled(values, factor):
            return None if values is None else values * factor

        return replace(
            self,
            omega=self.omega * slower,
            added=self.added * size,
            damping=self.damping * size * slower,
            infinite=scaled(self.infinite, size),
            wave_omega=scaled(self.wave_omega, slower),
            excitation=scaled(self.excitation, times ** (2.0 + turns)),
        )

    def checked(self) -> tuple["Coefficients", list[str]]:
        """The same, symmetric, and what a user should be told. Raises ValueError for what no body has."""
        notes = []

        for name, matrices in (("added mass", self.added), ("damping", self.damping)):
            off = np.abs(matrices - matrices.transpose(0, 2, 1))
            size = _size(matrices)
            worst = (off / size).max()

            if worst > 10 * UNSYMMETRIC:
                raise ValueError(f"the {name} is not symmetric: up to {100 * worst:.2g} % of its peak")
            if worst > UNSYMMETRIC:
                notes.append(
                    f"the {name} is unsymmetric by {100 * worst:.2g} % of its peak: its symmetric part counts"
                )

        damping = (self.damping + self.damping.transpose(0, 2, 1)) / 2
        scale = np.sqrt(np.maximum(damping.diagonal(axis1=1, axis2=2).max(axis=0), 1e-30))
        least = np.linalg.eigvalsh(damping / np.outer(scale, scale)).min(axis=1)

        if least.min() < -NEGATIVE:
            k = int(least.argmin())
            dof = motion(int(np.argmin(damping[k].diagonal() / scale**2)), self.bodies)
            notes.append(
                f"the damping in {dof} is {100 * least[k]:.2g} % of its peak at {self.omega[k]:.4g} rad/s"
            )

        notes += self._cut_short(damping)
        added = (self.added + self.added.transpose(0, 2, 1)) / 2
        infinite = None if self.infinite is None else (self.infinite + self.infinite.T) / 2
        return replace(self, added=added, damping=damping, infinite=infinite), notes

    def _cut_short(self, damping):
        """Notes of motions whose damping has not begun to die out where the frequencies end."""
        of_motion = damping.diagonal(axis1=1, axis2=2)
        peak = of_motion.max(axis=0)
        counts = COUNTS * np.abs(self.omega[:, None] * self.added.diagonal(axis1=1, axis2=2)).max(axis=0)
        last = of_motion[-1]

        return [
            f"the damping in {motion(k, self.bodies)} is {100 * last[k] / peak[k]:.3g} % of its peak at the "
            f"last frequency, {self.omega[-1]:.4g} rad/s; beyond, it is taken to fall with the third power "
            "of frequency"
            for k in np.flatnonzero((peak > counts) & (last > ENDS * peak))
        ]

    @cached_property
    def grid(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Excitation as a bicubic: frequencies (k,), headings (h,), and for each pair of these (N, 4, 12)
        numbers.

        They are values, their derivatives by frequency, by heading and by both, each the real parts of six,
        then the imaginary ones. Headings that go all the way round end with the first once more. Raises
        ValueError without excitation.
        """
        if self.excitation is None or self.headings is None or self.wave_omega is None:
            raise ValueError("has no excitation")

        headings, values = around(self.headings, self.excitation)
        slope = spline_slopes(self.wave_omega, values, 0)
        parts = np.stack(
            [values, slope, spline_slopes(headings, values, 1), spline_slopes(headings, slope, 1)], axis=2
        )
        parts = np.moveaxis(parts.reshape(*parts.shape[:3], self.bodies, 6), 3, 2)
        return self.wave_omega, headings, np.concatenate([parts.real, parts.imag], axis=4)


def _size(matrices):
    """(6, 6): what elements of matrices (n, 6, 6) are small beside, by their diagonals."""
    peak = np.sqrt(np.maximum(np.abs(matrices.diagonal(axis1=1, axis2=2)).max(axis=0), 1e-30))
    return np.outer(peak, peak)


def around(headings, values):
    """Headings and values with the first repeated at the end where they go all the way round."""
    gaps = np.diff(headings)

    left = 2 * np.pi - (headings[-1] - headings[0])

    if len(headings) > 2 and 1e-6 < left <= gaps.max() + 1e-6:
        return np.append(headings, headings[0] + 2 * np.pi), np.concatenate([values, values[:, :1]], axis=1)

    return headings, values
