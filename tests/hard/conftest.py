"""Fixtures of the hard cases."""

import faulthandler
import sys
from pathlib import Path

import pytest

# what other tests use too: fmu_host
sys.path.insert(0, str(Path(__file__).parents[1]))

# s that one case may take, the first one compiling the kernels
A_HANG = 900


@pytest.fixture(autouse=True)
def no_hang():
    """A hang inside a kernel cannot be interrupted: it ends the test run, with a traceback."""
    faulthandler.dump_traceback_later(A_HANG, exit=True, file=sys.__stderr__)
    yield
    faulthandler.cancel_dump_traceback_later()
