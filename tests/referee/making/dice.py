"""Chance: one stream of numbers, short to write down."""

import numpy as np


class Dice:
    """Random choices as plain Python values, the same for the same seeds."""

    def __init__(self, *seeds: int):
        self.rng = np.random.default_rng(seeds)

    def chance(self, p: float) -> bool:
        """True with probability p."""
        return bool(self.rng.random() < p)

    def whole(self, low: int, high: int) -> int:
        """low … high, both included."""
        return int(self.rng.integers(low, high + 1))

    def pick(self, options):
        """One of the options."""
        options = list(options)
        return options[self.whole(0, len(options) - 1)]

    def weighted(self, weights: dict):
        """A key, as often as its weight says."""
        keys = list(weights)
        total = np.cumsum([weights[key] for key in keys])
        return keys[int(np.searchsorted(total, self.rng.random() * total[-1], side="right"))]

    def number(self, low: float, high: float, digits: int = 3) -> float:
        """Evenly from low to high, rounded as a person would."""
        return round(float(self.rng.uniform(low, high)), digits)

    def signed(self, low: float, high: float) -> float:
        """A number of that size, with either sign."""
        return self.number(low, high) * (1 if self.chance(0.5) else -1)

    def vector(self, size: float, n: int = 3) -> list[float]:
        """n numbers within ±size."""
        return [self.number(-size, size) for _ in range(n)]

    def numbers(self, n: int, low: float, high: float) -> list[float]:
        """n numbers."""
        return [self.number(low, high) for _ in range(n)]

    def ascending(self, n: int, low: float, high: float) -> list[float]:
        """n numbers, the first `low`, the last `high`,
        none nearer to the next than a third of the mean distance."""
        parts = np.cumsum([0.0, *self.rng.uniform(0.5, 1.5, n - 1)])
        return [round(float(low + (high - low) * part / parts[-1]), 4) for part in parts]

    def some(self, options, least: int = 0) -> list:
        """Some of the options in any order, each at most once."""
        options = list(options)
        self.rng.shuffle(options)
        return options[: self.whole(min(least, len(options)), len(options))]

    def shuffled(self, table: dict) -> dict:
        """The table in another order."""
        keys = list(table)
        self.rng.shuffle(keys)
        return {key: table[key] for key in keys}
