"""Fixtures of all tests."""

import pytest


@pytest.fixture
def check(record_property):
    """A function check(error, allowed) that also writes the error down (pytest --junitxml)."""

    def check(error, allowed):
        record_property("error", f"{error:.1e}")
        assert error < allowed

    return check
