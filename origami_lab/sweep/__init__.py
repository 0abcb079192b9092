"""Optuna studies of searchers' settings, by many workers on one storage."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
