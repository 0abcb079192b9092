"""One experiment: a configuration and its seeds become trials, files on disk, and MLflow runs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
