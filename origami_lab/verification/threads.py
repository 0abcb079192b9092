"""Linear algebra without threads of its own."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext


def one_thread() -> AbstractContextManager[object]:
    """Linear algebra in one thread: the matrices are small, and threads would wait for each other.

    On a machine with other work that is the difference between one second and half a minute.
    """
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:  # it comes with scikit-learn, which MLflow needs
        return nullcontext()
    limits: AbstractContextManager[object] = threadpool_limits(1)
    return limits
