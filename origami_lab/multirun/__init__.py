"""Several experiments with ``-m``: checked before the first one starts, run by a launcher, told in one table."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
