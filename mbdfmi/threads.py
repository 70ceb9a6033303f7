"""Threads of the BLAS that numpy brings along."""

from contextlib import contextmanager


@contextmanager
def one_thread():
    """Inside, numpy's BLAS works by one thread.

    OpenBLAS gives matrices of some hundred by hundred to all its threads, which wait for each other,
    spinning, far longer than they work: singular values take ten times as long by two threads as by one.
    """
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1, user_api="blas"):
        yield
