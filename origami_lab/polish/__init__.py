"""Improving a finished design off the grid, and taking out of it what it does not need.

The search plays on whole board points and on ten driving angles. Polish moves the vertices of what it found, the size
of its start pattern and its driving angle continuously; no interaction is spent and no rule of the game is broken.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
