"""Tables, curves, a gallery and a page of many runs, from their folders."""

import lazy_loader

from origami_lab.caches import settle_matplotlib

settle_matplotlib()  # before anything here imports it
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
