"""The analysis of a user's mesh: what it is, and the settings with which a sheet is to be folded into it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
