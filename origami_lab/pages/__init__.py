"""The look of all our pages: one base template, one style, one way to fill them in, and data that opens from disk."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
