"""What is answered to a question."""

from typing import NamedTuple

FAULT, GOOD, ABSENT, TOLD = "fault", "good", "–", "told"
"""What an answer is: something wrong; as it should be; not claimed, or nothing to ask; a figure alone."""


class Answer(NamedTuple):
    """question : what was asked. verdict : FAULT, GOOD, ABSENT or TOLD. seen : what was found. In words.

    kind : of FMU, "CoSimulation" or "ModelExchange".
    """

    question: str
    verdict: str
    seen: str
    kind: str
