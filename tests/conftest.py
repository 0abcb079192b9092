"""Settings for all tests."""

from __future__ import annotations

from hypothesis import settings

# the first example compiles kernels, which takes as long as it takes
settings.register_profile("kernels", deadline=None)
settings.load_profile("kernels")
