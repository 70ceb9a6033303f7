"""What a verdict says, and how much was judged."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Finding:
    """Something that is not as it must be.

    verdict : which one, in a word. way : how it was run. variable, time (s) : where. found, wanted, allowed :
    the value, what it must be, and how far off it may be. text : more, in words. beyond : how many times
    as far off as it may be it is, at worst.
    """

    verdict: str
    way: str
    variable: str = ""
    time: float | None = None
    found: float | None = None
    wanted: float | None = None
    allowed: float | None = None
    text: str = ""
    beyond: float | None = None

    def __str__(self):
        parts = [f"{self.verdict}: {self.variable}".rstrip(": ")]

        if self.time is not None:
            parts.append(f"at {self.time:.6g} s")

        if self.found is not None:
            parts.append(f"is {self.found:.9g}")

        if self.wanted is not None:
            parts.append(f"must be {self.wanted:.9g}")

        if self.allowed is not None:
            parts.append(f"to {self.allowed:.2g}")

        if self.beyond is not None:
            parts.append(f"at worst {self.beyond:.3g} times what is allowed;")

        if self.text:
            parts.append(self.text)

        return f"{' '.join(parts)} [{self.way}]"


@dataclass
class Count:
    """How much was judged: comparisons made, and those that meant nothing because errors grow too much;
    what else to count, by name."""

    made: int = 0
    loose: int = 0
    other: dict[str, int] = field(default_factory=dict)
    ratios: dict[str, float] = field(default_factory=dict)

    def worst(self, name, ratio):
        """The largest part of what was allowed that was taken, by name."""
        self.ratios[name] = max(self.ratios.get(name, 0.0), float(ratio))

    def add(self, name, n=1):
        self.other[name] = self.other.get(name, 0) + n
