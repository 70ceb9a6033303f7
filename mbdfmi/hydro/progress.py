"""Where it is shown that something takes long: nowhere, unless a command says so."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext


def nowhere(text: str) -> AbstractContextManager[Callable[[str], None]]:
    """Shows nothing."""
    return nullcontext(lambda words: None)


class Progress:
    """shown : called with what is done, a context that yields a function to call with what comes next."""

    shown: Callable[[str], AbstractContextManager[Callable[[str], None]]] = staticmethod(nowhere)
