"""Everything that a run leaves on disk, under its names: folders, rows, locks, and how they are read back."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
