"""Names as people give them: with blanks, accents, quotes, other scripts."""

BODIES = (
    "link", "arm", "wheel", "Flügel", "blade",
    "große Rolle",
    "hull",
    "barre à roue",
    "α",
    "part #",
    "it's",
    "Körper (neu)",
)  # fmt: skip
JOINTS = ("hinge", "joint", "slide", "Gelenk", "elbow", "axle ~", "liaison n°", "j", "Führung", "knee-joint")
COUPLINGS = ("gear", "belt", "Zahnrad", "drive train")
FORCES = ("strut", "spring", "Feder", "load", "mooring line", "water")
MARKERS = ("m", "tip", "Spitze", "pin", "eye bolt", "p")
MEASURES = ("gap", "view", "Abstand", "seen from")


class Names:
    """Gives names, no two of which are the same in an FMU."""

    def __init__(self, dice):
        self.dice = dice
        self.count = 0
        self.plain = dice.chance(0.4)

    def new(self, pool) -> str:
        """A new name."""
        self.count += 1
        word = pool[0] if self.plain else self.dice.pick(pool)
        return f"{word}{' ' if ' ' in word or self.dice.chance(0.2) else ''}{self.count}"
