"""Shapes that a folded sheet is to take: solids, a face, and meshes of the user's."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
