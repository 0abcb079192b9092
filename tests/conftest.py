"""Settings for all tests, and runs that several of them look at."""

from __future__ import annotations

from hypothesis import settings

from tests.small_runs import composed, tracked

__all__ = ["composed", "tracked"]

# the first example compiles kernels, which takes as long as it takes
settings.register_profile("kernels", deadline=None)
settings.load_profile("kernels")
