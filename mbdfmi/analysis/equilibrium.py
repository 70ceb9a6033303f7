"""Static equilibrium: where nothing moves on its own (docs/theory.md 19.6).

From the start downhill, as a body in thick oil would creep (pseudo-transient continuation with a step that
grows), until Newton's method takes over. Downhill is asked of the work of all efforts along a step, so that
no energy needs to be known: loads that follow their body are allowed.
"""

from dataclasses import dataclass

import numpy as np

from ..scene.errors import listed
from .manifold import Manifold, NoState

# furthest step (rad, or parts of the scene's length) at first and at all, how far in all before nothing is
# hoped for, iterations
STRIDE = 0.3
LONGEST = 30.0
FURTHEST = 200.0
ITERATIONS = 400

# iterations of Newton's method from a drawn start
STRAIGHT = 60

# rad, parts of the scene's length, that are rounding
ROUNDING = 1e-16

# a step (rad, parts of the scene's length) from which on Newton's method finishes, and the last ones
CLOSE = 1e-5
FINISHING = 8

# of these with one stiffness, and by how much they have to fall
CHORDS = 3
QUICKLY = 1e-2

# squares of frequencies (1/s2) below that part of the largest are none, and below what differences tell: a
# motion without stiffness
NEUTRAL = 1e-9
NOTHING = 5e-9

# accelerations (rad/s2, or of the scene's length) along such a motion that are not rounding, as part of the
# largest effort's
PULLED = 1e-7

# accelerations (rad/s2, parts of the scene's length) that are rounding in any case
ROUNDED = 1e-11

# rad, or part of the scene's length, by which an unstable equilibrium is left
NUDGE = 0.05


class NoEquilibrium(NoState):
    """There is no equilibrium near; the message says what moves away."""


def tiny(squares):
    """What is none among squares of frequencies, 1/s2."""
    return max(NEUTRAL * np.abs(squares).max(initial=0.0), NOTHING)


@dataclass(frozen=True)
class Rest:
    """An equilibrium found.

    squares : (n,) squares of the undamped frequencies, 1/s2, ascending; shapes : (n, n) of the independent
        velocities.
    error : how far from equilibrium it may be (rad, parts of the scene's length). iterations : of the search.
    left : unstable equilibria that the search came through.
    """

    squares: np.ndarray
    shapes: np.ndarray
    error: float
    iterations: int
    left: int = 0

    @property
    def stable(self):
        """True, False, or None where some motion has no stiffness."""
        if not len(self.squares) or self.squares[0] > tiny(self.squares):
            return True

        return False if self.squares[0] < -tiny(self.squares) else None


def settle(mechanism, stay=False, tell=None, weather=False) -> tuple[Manifold, Rest]:
    """Brings a mechanism from where it is to a static equilibrium; the drives hold.

    stay : take the first that is found, stable or not. weather : with wind and waves. Raises NoEquilibrium.
    """
    mechanism.freeze(weather)
    manifold = Manifold(mechanism)
    left, count = 0, 0

    while True:
        search = _Search(manifold)
        count += search.run(tell)
        rest = Rest(search.squares, search.shapes, search.error, count, left)

        if stay or rest.stable is not False:
            break

        left += 1

        if left > 20:
            break

        shape = manifold.V @ search.shapes[:, 0]
        manifold.put(NUDGE * shape / np.abs(shape / manifold.unit).max())
        manifold.look()

    return manifold, rest


def descend(manifold) -> Rest:
    """Brings what a manifold looks at downhill to an equilibrium, its drives being held. Raises
    NoEquilibrium.
    """
    search = _Search(manifold)
    count = search.run()
    return Rest(search.squares, search.shapes, search.error, count)


def approach(mechanism, draw, far, downhill=True, weather=False) -> tuple[Manifold, Rest]:
    """The same from a drawn start; downhill : to a stable one, else to any by Newton's method.

    draw : a generator of random numbers. far : rad, or lengths of the scene, that coordinates are drawn from.
    Raises NoEquilibrium.
    """
    mechanism.freeze(weather)
    manifold = Manifold(mechanism)
    search = _Search(manifold)

    if len(manifold.speeds):
        search.start_anywhere(draw, far)

    count = search.run() if downhill else search.run_straight()
    return manifold, Rest(search.squares, search.shapes, search.error, count)


class _Search:
    """A search from the state that a manifold looks at."""

    def __init__(self, manifold):
        self.manifold = manifold
        self.unit = manifold.unit
        self.travel = 0.0
        self.error = 0.0

    def _see(self):
        """Accelerations, reduced mass and stiffness, what they are in coordinates whose mass is 1."""
        manifold = self.manifold
        manifold.put()
        self.pull = manifold.accelerations()[manifold.speeds].copy()
        # L L^T = M: w = L^T v has the mass 1
        self.L = np.linalg.cholesky(manifold.inertia())
        self.K = self.L.T @ np.linalg.solve(self.L, manifold.stiffness().T).T
        self.force = self.L.T @ self.pull
        self.squares, self.own = self._own_motions()
        self.shapes = np.linalg.solve(self.L.T, self.own)
        manifold.put()

    def _own_motions(self):
        """(squares of frequencies, ascending, and their motions in columns) of the symmetric part of K.

        Motions without stiffness apart: far from equilibrium accelerations depend on inertias too, K is not
        symmetric, and what it takes to nothing its symmetric part would mix with others.
        """
        even = 0.5 * (self.K + self.K.T)
        squares, vectors = np.linalg.eigh(even)

        # where the symmetric part is positive, K takes nothing to nothing
        if squares[0] > tiny(squares):
            return squares, vectors

        _, sizes, rows = np.linalg.svd(self.K)
        free = sizes <= tiny(sizes)
        none, held = rows[free].T, rows[~free].T
        squares, vectors = np.linalg.eigh(held.T @ even @ held)
        squares = np.concatenate([squares, np.zeros(none.shape[1])])
        order = np.argsort(squares)
        return squares[order], np.column_stack([held @ vectors, none])[:, order]

    def _size(self, step):
        """rad, or parts of the scene's length: the largest change of a coordinate."""
        return np.abs(self.manifold.V @ step / self.unit).max(initial=0.0)

    def run(self, tell=None):
        """Iterations that it took. Raises NoEquilibrium."""
        manifold = self.manifold

        if not len(manifold.speeds):
            self.squares, self.shapes = np.zeros(0), np.zeros((0, 0))
            return 0

        damping, limit = None, STRIDE

        for iteration in range(ITERATIONS):
            self._see()
            along = self.own.T @ self.force
            neutral = np.abs(self.squares) <= tiny(self.squares)
            pulled = self._pulled(along)

            if damping is None:
                # the first step is about a tenth of the longest
                first = self._size(self.pull)
                damping = 10.0 * first / STRIDE if first > 0.0 else 0.0

            if not np.any(neutral & pulled) and self._newton_is_close(neutral):
                self._finish(neutral)
                return iteration + 1

            damping, limit = self._step(along, neutral & ~pulled, damping, limit)

            if tell:
                tell(f"{iteration + 1} steps, {self.travel:.3g} rad or lengths of the scene")

            if self.travel > FURTHEST:
                raise NoEquilibrium(self._moves_away())

        raise NoEquilibrium(
            f"no equilibrium was found in {ITERATIONS} steps from the start: {self._moving()} may never come "
            "to rest"
        )

    def start_anywhere(self, draw, far):
        """Moves to a drawn state, by steps that loops can follow."""
        manifold = self.manifold
        way = draw.uniform(-far, far, len(manifold.speeds)) * self.unit[manifold.speeds]
        parts = max(1, int(np.ceil(self._size(way) / STRIDE))) if manifold.m.n_row else 1

        for _ in range(parts):
            try:
                manifold.put(manifold.V @ way / parts)
            except NoState:
                # as far as it goes
                manifold.put()
                break

            self._stay()

        manifold.look()

    def run_straight(self):
        """Newton's method, shortened as long as the accelerations do not fall; to stable equilibria or not.
        Returns the iterations. Raises NoEquilibrium.
        """
        manifold = self.manifold

        if not len(manifold.speeds):
            return self.run()

        for iteration in range(STRAIGHT):
            self._see()
            neutral = np.abs(self.squares) <= tiny(self.squares)

            if self._newton_is_close(neutral):
                if np.any(neutral & self._pulled(self.own.T @ self.force)):
                    break

                self._finish(neutral)
                return iteration + 1

            step = self.newton * min(1.0, STRIDE / self._size(self.newton))

            if not self._falls(step, np.linalg.norm(self.force)):
                break

            manifold.look()

        raise NoEquilibrium("Newton's method finds no equilibrium from there")

    def _falls(self, step, size):
        """Goes a step, or a part of it, that makes the accelerations smaller; False where none does."""
        manifold = self.manifold

        for _ in range(10):
            try:
                manifold.put(manifold.V @ step)
                pull = manifold.accelerations()[manifold.speeds]
            except NoState:
                pull = np.full(len(step), np.inf)

            if np.linalg.norm(self.L.T @ pull) < size:
                return True

            step = 0.5 * step

        return False

    def _pulled(self, along):
        """(n,) whether forces along motions (n,) are more than rounding."""
        seen = np.abs(self.manifold.V @ self.shapes * along) / self.unit[:, None]
        return (np.abs(along) > PULLED * self._scale()) & (seen.max(axis=0, initial=0.0) > ROUNDED)

    def _scale(self):
        """Accelerations in coordinates of mass 1 that compare with those of weights and springs here."""
        manifold = self.manifold
        m, d = manifold.m, manifold.d
        nodes = np.arange(1, m.n_body)
        force = np.abs(d.force.reshape(-1, 3)[nodes]).max(initial=0.0)
        mass = max(d.body_m.max(initial=0.0), 1e-300)
        return max(np.linalg.norm(self.force), np.sqrt(mass) * force / mass * 1e-3)

    def _newton_is_close(self, neutral):
        """Whether a whole step of Newton's method is small."""
        self.newton = self._newton(neutral)
        return self._size(self.newton) < CLOSE

    def _newton(self, neutral):
        """The step of Newton's method, none along motions without stiffness."""
        if self.squares[0] > tiny(self.squares):
            return np.linalg.solve(self.L.T, np.linalg.solve(self.K, self.force))

        held = self.own[:, ~neutral]
        # far from equilibrium the stiffness is not symmetric, and may be singular otherwise
        inverse = np.linalg.pinv(held.T @ self.K @ held, rcond=NEUTRAL)
        return np.linalg.solve(self.L.T, held @ (inverse @ (held.T @ self.force)))

    def _finish(self, neutral):
        """Newton's method as long as it comes closer."""
        manifold = self.manifold
        least = np.inf

        for _ in range(FINISHING):
            size = self._size(self.newton)

            if size >= 0.5 * least or size <= ROUNDING:
                break

            least = self._come_closer(size, neutral)
            manifold.look()
            self._see()
            neutral = np.abs(self.squares) <= tiny(self.squares)
            self.newton = self._newton(neutral)

        self.error = min(least, self._size(self.newton))

    def _come_closer(self, size, neutral):
        """Steps with the stiffness at hand, which so near is as good as one of each place, as long as they
        fall quickly; the last one's size.
        """
        manifold = self.manifold
        manifold.put(manifold.V @ self.newton)

        for _ in range(CHORDS):
            self._stay()
            self.force = self.L.T @ manifold.accelerations()[manifold.speeds]
            self.newton = self._newton(neutral)
            next_size = self._size(self.newton)

            if next_size <= ROUNDING or next_size > QUICKLY * size:
                break

            size = next_size
            manifold.put(manifold.V @ self.newton)

        return size

    def _stay(self):
        """The state that was put is the one looked at; coordinates stay what they are."""
        self.manifold.x = self.manifold.d.x.copy()

    def _step(self, along, idle, damping, limit):
        """One step downhill. Returns the damping and the longest step of the next."""
        manifold = self.manifold

        while True:
            way = along / (np.abs(self.squares) + damping + 1e-300)
            way[idle] = 0.0
            step = np.linalg.solve(self.L.T, self.own @ way)
            size = self._size(step)
            shorten = min(1.0, limit / size) if size > 0.0 else 1.0
            step, way = shorten * step, shorten * way
            before = along @ way

            try:
                manifold.put(manifold.V @ step)
                pull = manifold.accelerations()[manifold.speeds]
            except NoState:
                limit *= 0.25
                damping *= 4.0

                if limit < 1e-9:
                    raise

                continue

            after = (self.own.T @ (self.L.T @ pull)) @ way

            # the work of a step is to be positive, and at its end not much is to pull back
            if after >= -0.5 * before or size * shorten < 1e-12:
                break

            damping = max(4.0 * damping, 1e-6 * np.abs(self.squares).max())
            limit = 0.5 * min(limit, size)

        self.travel += size * shorten
        even = abs(after - before) < 1e-3 * before
        manifold.look()
        grown = limit * (4.0 if even and shorten < 1.0 else 1.5)
        return damping / (4.0 if after > 0.0 else 2.0), max(
            min(grown, LONGEST) if even else min(grown, STRIDE), 1e-8
        )

    def _moving(self):
        """Coordinates that are pulled most."""
        manifold = self.manifold
        step = np.abs(manifold.V @ np.linalg.solve(self.L.T, self.force)) / self.unit
        parts = np.argsort(-step)[:3]
        return listed([manifold.named[k].position for k in parts if step[k] > 0.1 * step[parts[0]]])

    def _moves_away(self):
        """What is told of the last direction."""
        moving = self._moving()
        several = '" and "' in moving
        return f"there is no equilibrium near the start: {moving} move{'s' * (not several)} away"
