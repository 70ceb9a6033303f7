"""Small matrices are not given to threads, which would wait for each other ten times as long as they work."""

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController, threadpool_limits

import mbdfmi
from mbdfmi.threads import one_thread
from tests.model_files import MODELS


def threads():
    """The largest number of threads of the libraries of linear algebra that are loaded."""
    return max(library["num_threads"] for library in ThreadpoolController().select(user_api="blas").info())


@pytest.fixture
def two_threads():
    with threadpool_limits(2, user_api="blas"):
        if threads() != 2:
            pytest.skip("numpy's BLAS takes no number of threads here")
        yield


def test_one_thread_inside_and_as_before_behind(two_threads):
    with one_thread():
        assert threads() == 1
    assert threads() == 2

    with pytest.raises(ValueError), one_thread():
        raise ValueError
    assert threads() == 2


def test_a_structure_is_found_by_one(two_threads, monkeypatch):
    seen, svd = [], np.linalg.svd
    monkeypatch.setattr(np.linalg, "svd", lambda *a, **k: seen.append(threads()) or svd(*a, **k))
    assert mbdfmi.load(MODELS / "four_bar.toml").structure().freedom == 1
    assert set(seen) == {1} and threads() == 2
