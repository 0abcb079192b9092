"""The game of the paper, section 3.3: a sheet on a board grows crease by crease and stays foldable."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
