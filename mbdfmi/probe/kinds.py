"""The kinds of FMU that can be asked: what one is taken as, and the questions."""

from . import exchange_questions, questions
from .exchange import Exchanged
from .fmu import Fmu

KINDS: dict[str, tuple[type[Fmu], dict]] = {
    Fmu.kind: (Fmu, questions.QUESTIONS),
    Exchanged.kind: (Exchanged, exchange_questions.QUESTIONS),
}
"""By what they are called in the description."""
