"""The memory of waves that a body makes as states, from its damping over frequency (docs/theory.md 16.16).

K(t) = 2 / pi int B(omega) cos(omega t) d omega becomes x' = A x + B V, force = -C x: poles by Kung's
realisation of K, C by least squares on H(i omega) = B + i omega (A - A_inf), without damping at frequency 0,
passive. The order grows until both parts of H are met, and damping at single frequencies that are asked for.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..lazily import scipy
from .database import Coefficients, motion

# of the peaks of two motions: coupling that counts
COUPLED = 2e-3

# frequencies of the integrals, up to this many times the file's highest; of its peak, K that has died out
FINE = 4000
BEYOND = 4.0
DEAD = 2e-4

# of a step: closer to a frequency of the integrals than this one is taken to be the same
MEETS = 1e-6

# how far passivity is looked for, by the highest frequency, and how far below 0 it may be (of the peak)
FAR = 60.0
PASSIVE = 1e-6

# of the peak: energy that waves would give from which on a fit is none
GIVES = 1e-4

# of the largest: what is rounding; a way to make waves that is none
NOTHING = 1e-10
FEWER = 1e-4

# of its own value: how far damping may be off at frequencies and motions that are asked for beside
NEAR = 0.03

# of the damping of a motion: a group of motions that has a part in it
OWN = 0.01

# that are kept of what is found
DIGITS = 9

# of a group of motions that are coupled: as many states, or as many for each of them
MOST_STATES = 40
MOST_A_MOTION = 10
ROWS = 90


@dataclass(frozen=True)
class Memory:
    """States x' = poles x + source V, force = -sink^T x.

    pole : (n, 2) 1/s, real part and rate by the mate, of opposite signs in a pair.
    mate : (n,) index of it, its own where it is single.
    source : (n, 6 N); sink : (n, 6 N), of N bodies.
    infinite : (6 N, 6 N) added mass at infinite frequency.
    error : largest error of H by the peak of its motion; orders : [(motions, states)].
    """

    pole: np.ndarray
    mate: np.ndarray
    source: np.ndarray
    sink: np.ndarray
    infinite: np.ndarray
    error: float
    orders: list

    def response(self, omega):
        """(n, 6 N, 6 N) complex: H at frequencies (n,)."""
        A = np.diag(self.pole[:, 0])
        A[np.arange(len(A)), self.mate] += self.pole[:, 1]
        return np.array(
            [self.sink.T @ np.linalg.solve(1j * w * np.eye(len(A)) - A, self.source) for w in omega]
        )


class Kernel:
    """K(t) of a database, and H as the transform of it.

    B is splined between the file's frequencies, goes to 0 with omega^2 below them, and with omega^-3 above.
    """

    def __init__(self, coefficients: Coefficients):
        omega, B = coefficients.omega, coefficients.damping
        self.top = omega[-1]
        step = self.top * BEYOND / (FINE * BEYOND)
        self.omega = step * np.arange(int(BEYOND * FINE) + 1)
        inside = self.omega <= self.top
        self.B = np.zeros((len(self.omega), *B.shape[1:]))
        known = np.concatenate([[0.0], omega])
        self.B[inside] = scipy.interpolate.PchipInterpolator(
            known, np.concatenate([np.zeros((1, *B.shape[1:])), B])
        )(self.omega[inside])
        self.B[~inside] = B[-1] * (self.top / self.omega[~inside, None, None]) ** 3
        self.step = step
        self.infinite = (
            coefficients.infinite if coefficients.infinite is not None else self._ogilvie(coefficients)
        )

    def at(self, time):
        """(n, 6 N, 6 N) K at times (n,)."""
        weights = np.full(len(self.omega), self.step)
        weights[[0, -1]] /= 2
        waves = np.cos(np.outer(time, self.omega)) * weights
        return 2 / np.pi * np.tensordot(waves, self.B, 1)

    def added(self, omega):
        """(n, 6, 6): A - A_inf at frequencies w: 2 / pi int (B(u) - B(w)) / (u^2 - w^2) du."""
        found = np.empty((len(omega), *self.B.shape[1:]))
        spline = scipy.interpolate.CubicSpline(self.omega, self.B)
        middles = (self.omega[1:] + self.omega[:-1]) / 2
        slope = spline.derivative()
        B = spline(middles)
        end = self.omega[-1]

        for k, w in enumerate(omega):
            here = spline(w)
            # at w itself the quotient is B' / (2 w)
            at = np.abs(middles - w) < MEETS * self.step
            body = np.tensordot(self.step / np.where(at, np.inf, middles**2 - w * w), B - here, 1)
            body += at.sum() * self.step * slope(w) / (2 * w)
            # the principal value of 1 / (u^2 - w^2) up to the end, and the tail of B beyond it
            body += here * np.log(abs((end - w) / (end + w))) / (2 * w)
            found[k] = 2 / np.pi * (body + self.B[-1] / (4 * end))

        return found

    def _ogilvie(self, coefficients):
        """A_inf as the median over the frequencies of A less what K makes of it."""
        inside = slice(len(coefficients.omega) // 5, -len(coefficients.omega) // 5 or None)
        return np.median(coefficients.added[inside] - self.added(coefficients.omega[inside]), axis=0)

    def response(self, omega):
        """(n, 6 N, 6 N) complex: H = B + i omega (A - A_inf)."""
        w = np.asarray(omega)[:, None, None]
        return scipy.interpolate.CubicSpline(self.omega, self.B)(omega) + 1j * w * self.added(omega)


def fit(
    coefficients: Coefficients,
    error: float = 0.01,
    states: int | None = None,
    tell: Callable[[str], None] | None = None,
    near: Sequence = (),
) -> Memory:
    """The memory of bodies, of an order that meets `error` of the peaks.

    states : so many instead, for each group of motions that are coupled. tell : is given the words of each
        group. near : (omega rad/s, motion (6 N,)) at which damping is met within NEAR of its own value too.
    """
    kernel = Kernel(coefficients)
    scale = np.sqrt(np.maximum(kernel.B.diagonal(axis1=1, axis2=2).max(axis=0), 0.0))
    parts, worst, orders = [], 0.0, []

    samples = _sampled(kernel, coefficients.omega)
    near = [(w, np.array(moves), kernel.response(np.array([w]))[0].real) for w, moves in near]

    for group in _groups(kernel.B, scale):
        if tell:
            names = ", ".join(motion(k, coefficients.bodies) for k in group)
            tell(f"fitting the memory of the waves that {names} {'makes' if len(group) == 1 else 'make'}")

        local = _Near.of(near, group, scale[group])
        part, missed = _fit_group(kernel, samples, group, scale[group], error, states, local)
        parts.append((group, part))
        worst = max(worst, missed)
        orders.append((group, len(part[0])))

    return _joined(parts, kernel.infinite, worst, orders)


def _groups(B, scale):
    """Motions that are coupled, as lists; those without damping are none's."""
    moving = [k for k in range(len(scale)) if scale[k] > 1e-9 * scale.max()]
    safe = np.where(scale > 0, scale, 1.0)
    coupling = np.abs(B / np.outer(safe, safe)).max(axis=0)
    groups = []

    for k in moving:
        near = [group for group in groups if coupling[k, group].max() > COUPLED]
        groups = [group for group in groups if group not in near] + [sorted(sum(near, [k]))]

    return groups


def _sampled(kernel, band):
    """(times, K there, frequencies, H there): K shows how long it lasts, H is what is to be met."""
    time = np.linspace(0.0, 2 * np.pi / kernel.omega[1] / 8, 1500)
    even, low = np.linspace(band[0], band[-1], 150), np.geomspace(band[0] / 4, band[-1], 30)
    omega = np.unique(np.concatenate([even, low]))
    return time, kernel.at(time), omega, kernel.response(omega)


def _fit_group(kernel, samples, group, scale, error, states, near):
    """((A, B, C) of a group in SI, largest error by its peak)."""
    time, whole, omega, response = samples
    K = whole[np.ix_(range(len(time)), group, group)] / np.outer(scale, scale)
    size = np.abs(K).max(axis=(1, 2))
    span = time[np.flatnonzero(size > DEAD * size.max())[-1]]
    step = max(span / (2 * ROWS), 0.25 / kernel.top)
    K = kernel.at(step * np.arange(2 * ROWS))[np.ix_(range(2 * ROWS), group, group)] / np.outer(scale, scale)
    H = response[np.ix_(range(len(omega)), group, group)] / np.outer(scale, scale)
    every = _ways(H.real, len(group)).shape[1]

    # each way to make waves takes two states or more: fewer states are for the strongest ways
    for r in range(min(every, states // 2), 0, -1) if states else [every]:
        ways = _ways(H.real, r)
        found = ways.T @ K @ ways, omega, ways.T @ H @ ways
        best = _fit_ways(kernel.top, step, *found, error, states, near.along(ways))

        if best and np.isfinite(best.missed):
            missed = best.missed if r == every else best.missed_of(ways, H)
            return (best.A, best.B @ ways.T * scale, ways @ best.C * scale[:, None]), missed

    motions = ", ".join(motion(k, kernel.B.shape[1] // 6) for k in group)
    kind = "takes energy alone" if best else "dies out"
    raise ValueError(f"no memory that {kind} can be fitted to the damping in {motions}; has it spikes?")


def _fit_ways(top, step, K, omega, H, error, states, near):
    """The best `_Sinks` of samples K and H, made passive; None where no pole dies out."""
    r = K.shape[1]
    realisation = _Kung(K, step)
    most = max(MOST_STATES, MOST_A_MOTION * r)
    found = []

    for n in [states] if states else range(2 * r, most + 1, max(2, 2 * (r // 2) - 2)):
        A, B = realisation.poles(n)

        if not len(A):
            continue

        found.append(_Sinks(A, B, omega, H, near, error))

        if found[-1].score < error and not states and found[-1].made_passive(top).score < error:
            break

    return _best(found, top) if found else None


def _ways(damping, most):
    """(m, r) orthogonal: the motions by which all waves are made, `most` of them; all m are left as they are.

    Where the damping (n, m, m) makes fewer waves than there are motions, further ones would be fitted to
    rounding.
    """
    m = damping.shape[1]
    U, size, _ = np.linalg.svd(damping.transpose(1, 0, 2).reshape(m, -1), full_matrices=False)
    r = min(most, int((size > FEWER * size[0]).sum()))
    return np.eye(m) if r == m else U[:, :r]


def _best(found, top):
    """Of some fits the passive one that misses least, by infinity where none is; to be made passive costs
    time, and a fit some of its error.
    """
    found = sorted(found, key=lambda one: one.score)
    best = found[0].made_passive(top)

    for one in found[1:]:
        if one.score >= best.score:
            break
        best = min(best, one.made_passive(top), key=lambda one: one.score)

    return best


@dataclass(frozen=True)
class _Near:
    """Damping to be met at single frequencies, in motions of a group by their peaks.

    omega : (k,). motion : (k, m). damping : (k,) motion . Re H motion.
    """

    omega: np.ndarray
    motion: np.ndarray
    damping: np.ndarray

    @classmethod
    def of(cls, near, group, scale):
        """What of (omega, motion, Re H) is of a group: motions that its damping has a part in."""
        kept = []

        for omega, moves, B in near:
            own = moves[group]
            taken = own @ B[np.ix_(group, group)] @ own

            if taken > OWN * abs(moves @ B @ moves):
                kept.append((omega, own * scale, taken))

        return cls(
            np.array([omega for omega, _, _ in kept]),
            np.array([u for _, u, _ in kept]).reshape(len(kept), len(group)),
            np.array([taken for _, _, taken in kept]),
        )

    def along(self, ways):
        """The same by the ways (m, r) to make waves."""
        return replace(self, motion=self.motion @ ways)

    def missed(self, C, phi):
        """The largest part of its own value by which C phi misses it."""
        found = np.einsum("ki,kij,kj->k", self.motion, (C @ phi).real, self.motion)
        return float(np.abs(found / self.damping - 1.0).max(initial=0.0))


class _Kung:
    """Realisations of samples K (n, m, m) of different orders, from one singular value decomposition."""

    def __init__(self, K, step):
        self.step, self.m = step, K.shape[1]
        rows = len(K) // 2
        hankel = np.block([[K[i + j] for j in range(rows)] for i in range(rows)])
        self.U, self.s, self.V = np.linalg.svd(hankel)

    def poles(self, n):
        """(A in real modal form, B) of order n at most: poles that grow are left out."""
        root = np.sqrt(self.s[:n])
        O = self.U[:, :n] * root
        step = _least_squares(O[: -self.m], O[self.m :])
        source = (root[:, None] * self.V[:n])[:, : self.m]
        values, vectors = np.linalg.eig(step)
        values = np.log(values.astype(complex)) / self.step
        modal = np.linalg.solve(vectors, source.astype(complex))
        blocks, rows = [], []

        for k, p in enumerate(values):
            if p.real >= 0 or abs(p.imag) > 0.9 * np.pi / self.step:
                continue
            if abs(p.imag) < 1e-9 * abs(p):
                blocks.append(np.array([[p.real]]))
                turn = np.exp(-1j * np.angle(modal[k][np.abs(modal[k]).argmax()]))
                rows.append((modal[k] * turn).real[None])
            elif p.imag > 0:
                blocks.append(np.array([[p.real, -p.imag], [p.imag, p.real]]))
                rows.append(np.array([modal[k].real, modal[k].imag]))

        A = np.zeros((sum(map(len, blocks)),) * 2)
        at = 0

        for block in blocks:
            A[at : at + len(block), at : at + len(block)] = block
            at += len(block)

        return A, np.vstack(rows) if rows else np.zeros((0, self.m))


class _Sinks:
    """C of H = C (i omega - A)^-1 B by least squares, without damping at 0, symmetric at once.

    Rows of C in a row are the unknowns; the same matrix of the poles stands before each row, so that what is
    left of it by QR, n equations for each of m motions, is all that has to be solved.
    """

    def __init__(self, A, B, omega, H, near, error):
        self.A, self.B, self.H, self.near, self.error = A, B, H, near, error
        self.phi_near = _responses(A, B, near.omega)
        self.is_passive = False
        n, m = B.shape
        self.phi = _responses(A, B, omega)
        self.peak = np.abs(H).max(axis=(0, 1, 2))

        # H_ij = sum_k C_ik phi_kj
        wide = np.concatenate([self.phi.real, self.phi.imag]).transpose(0, 2, 1).reshape(-1, n)
        target = np.concatenate([H.real, H.imag]).transpose(0, 2, 1).reshape(-1, m)
        Q, R = np.linalg.qr(wide)
        still = np.kron(np.eye(m), np.linalg.solve(A, B).T)
        swaps = []

        for i in range(m):
            for j in range(i):
                row = np.zeros((m, n))
                row[i], row[j] = B[:, j], -B[:, i]
                swaps.append(row.ravel())

        self.free = _null_space(np.vstack([still, *swaps]) if swaps else still)
        self.reduced = np.kron(np.eye(m), R) @ self.free
        self._take(_least_squares(self.reduced, (Q.T @ target).T.ravel()))

    def _take(self, solution):
        self.solution = solution
        self.C = (self.free @ solution).reshape(self.B.shape[::-1])

        # largest error of H by its peak
        self.missed = float(np.abs(self.C @ self.phi - self.H).max() / self.peak)

        # the same with what is missed nearby, below the error where both are met
        self.score = max(self.missed, self.error * self.near.missed(self.C, self.phi_near) / NEAR)

    def missed_of(self, ways, H):
        """Largest error by its peak of an H of more motions, of which these are the ways (m, r)."""
        return float(np.abs(ways @ self.C @ self.phi @ ways.T - H).max() / np.abs(H).max())

    def made_passive(self, top) -> "_Sinks":
        """These, made the nearest ones (by the fit's own error) whose H + H^* is nowhere negative, as far as
        it gets.
        """
        if self.is_passive:
            return self

        self.is_passive = True
        grid = np.unique(
            np.concatenate([np.linspace(0, 2 * top, 500)[1:], np.geomspace(2 * top, FAR * top, 60)])
        )
        phi = _responses(self.A, self.B, grid)

        # far away H + H^* falls as 1 / omega^2
        weight = 1.0 + (grid / top) ** 2
        _, triangle = np.linalg.qr(self.reduced)
        inverse = np.linalg.pinv(triangle)
        rows, start = [], self.solution

        for _ in range(30):
            H = self.C @ phi
            real = (H + H.conj().transpose(0, 2, 1)) / 2
            lowest = np.linalg.eigvalsh(real)[:, 0] * weight

            if lowest.min() >= -PASSIVE * self.peak:
                break

            # at each local minimum below 0: Re(v^* C phi v) >= 0, linear in C
            low = (
                np.r_[True, lowest[1:] < lowest[:-1]] & np.r_[lowest[:-1] <= lowest[1:], True] & (lowest < 0)
            )

            for k in np.flatnonzero(low):
                v = np.linalg.eigh(real[k])[1][:, 0]
                row = np.real(np.outer(v.conj(), phi[k] @ v)).ravel() @ self.free
                rows.append(weight[k] * row / self.peak)

            # least |triangle (x - start)| under rows x >= 0, Lawson and Hanson's LDP
            G = np.array(rows) @ inverse
            h = PASSIVE / 2 - np.array(rows) @ start
            u, _ = scipy.optimize.nnls(
                np.vstack([G.T, h]), np.r_[np.zeros(G.shape[1]), 1.0], maxiter=50 * len(h) + 500
            )
            r = np.vstack([G.T, h]) @ u - np.r_[np.zeros(G.shape[1]), 1.0]

            if abs(r[-1]) < 1e-14:
                break

            self._take(start + inverse @ (-r[:-1] / r[-1]))

        H = self.C @ phi
        lowest = np.linalg.eigvalsh((H + H.conj().transpose(0, 2, 1)) / 2)[:, 0] * weight

        if not lowest.min() >= -GIVES * self.peak:
            self.missed = self.score = np.inf

        return self


def _least_squares(A, b):
    return scipy.linalg.lstsq(A, b, cond=NOTHING, lapack_driver="gelsy", check_finite=False)[0]


def _null_space(rows):
    """(n, k): columns to which all rows (m, n) are perpendicular."""
    Q, R, _ = scipy.linalg.qr(rows.T, pivoting=True)
    size = np.abs(R.diagonal())
    return Q[:, (size > 1e-12 * size[0]).sum() :]


def _responses(A, B, omega):
    """(n, ...) complex: (i omega - A)^-1 B at frequencies (n,)."""
    return np.linalg.solve(1j * omega[:, None, None] * np.eye(len(A)) - A, B.astype(complex))


def _joined(parts, infinite, error, orders):
    """The memory of all groups."""
    pole, mate, source, sink = [], [], [], []

    for group, (A, B, C) in parts:
        first = len(pole)

        for k in range(len(A)):
            other = next((j for j in range(len(A)) if j != k and A[k, j] != 0.0), k)
            pole.append((A[k, k], A[k, other] if other != k else 0.0))
            mate.append(first + other)
            source.append(np.zeros(len(infinite)))
            sink.append(np.zeros(len(infinite)))
            source[-1][group], sink[-1][group] = B[k], C[:, k]

    return Memory(
        _rounded(np.array(pole, float).reshape(-1, 2)),
        np.array(mate, int),
        _rounded(np.array(source, float).reshape(-1, len(infinite))),
        _rounded(np.array(sink, float).reshape(-1, len(infinite))),
        _rounded(infinite),
        error,
        orders,
    )


def _rounded(values):
    """To so many digits that processors agree on them, which LAPACK's last ones do not."""
    return np.array([float(f"{value:.{DIGITS}g}") for value in values.ravel()]).reshape(values.shape)
