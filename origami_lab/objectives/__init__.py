"""Scores of folded sheets: the distance to a target, and the abstract objectives of the paper (sections 3.6 and F)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
