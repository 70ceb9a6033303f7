"""Fixtures of all tests."""

import ctypes

import pytest
from fmpy import fmi2


@pytest.fixture
def check(record_property):
    """A function check(error, allowed) that also writes the error down (pytest --junitxml)."""

    def check(error, allowed):
        record_property("error", f"{error:.1e}")
        assert error < allowed

    return check


@pytest.fixture
def fmpy_log():
    """(texts, a logger for FMPy that appends to them).

    FMPy keeps the last logger for all runs that follow, those without one too, even after it is gone: here it
    gets its own again.
    """
    texts = []
    yield texts, lambda *message: texts.append(message[-1].decode())
    fmi2.defaultCallbacks.logger = fmi2.fmi2CallbackLoggerTYPE(fmi2.printLogMessage)
    fmi2.addLoggerProxy(ctypes.byref(fmi2.defaultCallbacks))
