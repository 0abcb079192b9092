"""Designs as files in the FOLD format: the hub between what makes designs and what draws, exports and verifies them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
