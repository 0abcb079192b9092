"""Searchers, and the problem that they play on: a game, an objective and a budget of interactions."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
