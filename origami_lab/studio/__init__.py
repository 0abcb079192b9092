"""The studio: a page on this machine on which a person plays the game, with the searchers as partners."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
